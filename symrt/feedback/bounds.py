"""Bounds on radiances, from slabs of reflectances seen against a reference white: step 5 of the paper."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import Spectrum
from symrt.gamut.interface import Slabs

NEGLIGIBLE = 1e-4
"""Share of a slab's weights that may lie in bands that the reference white does not light."""
THIN_SLAB = 1e-3
"""A slab whose bounds are all smaller has its distances counted as they are, not as shares."""

PerSlab = Float[np.ndarray, " slab"]
Sizes = Float[np.ndarray, "_ 1"]


@dataclass(frozen=True, eq=False)
class Bound:
    """Slabs ``lower <= p A <= upper`` of a radiance p.

    Parameters
    ----------
    matrix
        A: one column a slab.
    bands
        The band that each slab bounds alone; -1 where it weighs several.
    words
        The quantity that each slab bounds, if it weighs several bands.
    extrapolated
        True where the device was not measured.
    """

    matrix: Float[np.ndarray, "band slab"]
    lower: Float[np.ndarray, " slab"]
    upper: Float[np.ndarray, " slab"]
    bands: Int[np.ndarray, " slab"]
    words: tuple[str, ...] = ()
    extrapolated: Bool[np.ndarray, " slab"] | None = None

    @property
    def signed(self) -> bool:
        """True if more light may bring a pixel inside, so that the lightest image alone decides nothing."""
        return bool((self.matrix < 0).any())


def bound_of(slabs: Slabs, shown: Spectrum, lower: PerSlab, upper: PerSlab) -> Bound:
    """The slabs of reflectances that ask for something, as slabs of radiances.

    Parameters
    ----------
    shown
        The factors from radiance to reflectance, 0 in bands that the reference does not light.
    lower, upper
        Bounds, infinite where nothing is asked for.

    Raises
    ------
    ValueError
        If a slab needs a band that the reference leaves dark.

    Examples
    --------
    >>> no = np.zeros(1, dtype=bool)
    >>> slabs = Slabs(np.array([[1.0]]), np.zeros(1), np.ones(1), np.array([0]), ("560 nm",), no, no)
    >>> bound_of(slabs, np.array([0.25]), np.array([-np.inf]), slabs.upper).matrix
    array([[0.25]])
    """
    # Leave out slabs of a single unlit band; refuse those of several bands that depend on unlit ones.
    weight = np.abs(slabs.matrix)
    unlit = weight[shown == 0].sum(axis=0) / weight.sum(axis=0)
    used = (np.isfinite(lower) | np.isfinite(upper)) & ~((slabs.bands >= 0) & (unlit > 0))
    if (unlit[used] > NEGLIGIBLE).any():
        word = slabs.words[int(np.flatnonzero(used & (unlit > NEGLIGIBLE))[0])]
        raise ValueError(f"the reference leaves bands dark that {word} depends on: use Reference('equal-energy')")

    # Weigh radiances as the reflectances that they show.
    return Bound(
        matrix=slabs.matrix[:, used] * shown[:, None],
        lower=lower[used],
        upper=upper[used],
        bands=slabs.bands[used],
        words=tuple(word for word, taken in zip(slabs.words, used, strict=True) if taken),
        extrapolated=slabs.extrapolated[used],
    )


def alike(sizes: Sizes, bound: Bound) -> Iterator[tuple[Int[np.ndarray, " row"], float]]:
    """Rows of about the same size, and the largest there; those no larger than the bounds are together.

    The rounding of a pixel as bright as the sun need not be feared in any other.

    Examples
    --------
    >>> bound = Bound(np.eye(1), np.zeros(1), np.ones(1), np.zeros(1, dtype=int))
    >>> [(rows.tolist(), most) for rows, most in alike(np.array([[0.0], [5e8], [0.5]]), bound)]
    [([0, 2], 0.5), ([1], 500000000.0)]
    """
    ends = np.abs(np.concatenate([bound.lower, bound.upper]))
    ordinary = ends[np.isfinite(ends)].max(initial=np.finfo(float).tiny)
    order = np.frexp(np.maximum(sizes[:, 0] / ordinary, 0.5))[1]
    for k in np.unique(order):
        rows = np.flatnonzero(order == k)
        yield rows, float(sizes[rows].max())


def nearest_slab(bound: Bound, values: PerSlab) -> tuple[Literal["upper", "lower"], int, float]:
    """The side and the number of the slab whose bound is met most nearly, and the room left as a share of the bound.

    Examples
    --------
    >>> bound = Bound(np.eye(2), np.zeros(2), np.full(2, 0.5), np.arange(2), ("400 nm", "500 nm"))
    >>> nearest_slab(bound, np.array([0.3, 0.4]))
    ('upper', 1, 0.2)
    """
    size = np.maximum(*(np.where(np.isfinite(b), np.abs(b), 0.0) for b in (bound.lower, bound.upper)))
    room = np.stack([bound.upper - values, values - bound.lower]) / np.where(size > THIN_SLAB, size, 1.0)
    side, slab = np.unravel_index(int(room.argmin()), room.shape)
    return ("upper", "lower")[side], int(slab), float(room[side, slab].round(15))
