"""An image as posynomials of several scales: step 5 of the paper, for all of its parameters at once.

A pixel's band, divided by its bound, is ``f(x) = Σ_m c_m Π_i x_i^(a_mi)`` with c_m ≥ 0: a posynomial.  In y = ln x it
is a sum of exponentials, so that ``ln f`` is convex and {y: ln f <= 0} a convex set [1]_.

References
----------
.. [1] S. Boyd, S.-J. Kim, L. Vandenberghe and A. Hassibi, "A tutorial on geometric programming", Optimization and
   Engineering 8, 2007, pp. 67-127.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.feedback.bounds import Bound
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.system import LinearSystem

SHARES_AT_ONCE = 1 << 15
"""Pixels that are shaded at a time."""

Point = Float[np.ndarray, " scale"]
Rows = Int[np.ndarray, " row"]


@dataclass(frozen=True, eq=False)
class Posynomials:
    """Rows ``Σ_m exp(logs[row, m] + exponents[m] · y)``; a term that a row lacks has the logarithm -inf."""

    logs: Float[np.ndarray, "row monomial"]
    exponents: Float[np.ndarray, "monomial scale"]

    def at(self, y: Point) -> tuple[Float[np.ndarray, " row"], Float[np.ndarray, "row monomial"]]:
        """The logarithm of each row, and the share of each of its terms.

        Examples
        --------
        >>> rows = Posynomials(np.log([[0.5, 0.5]]), np.array([[0.0], [2.0]]))
        >>> rows.at(np.zeros(1))
        (array([0.]), array([[0.5, 0.5]]))
        """
        # Powers are taken relative to the largest term, so that none overflows.
        terms = self.logs + self.exponents @ y
        largest = terms.max(axis=1, keepdims=True)
        powers = np.exp(terms - largest)
        sums = powers.sum(axis=1, keepdims=True)
        return (largest + np.log(sums))[:, 0], powers / sums

    def scales(self, row: int) -> Int[np.ndarray, " moved"]:
        """The scales on which a row depends."""
        return np.flatnonzero(self.exponents[np.isfinite(self.logs[row])].any(axis=0))


def stacked_rows(parts: Sequence[Posynomials]) -> Posynomials:
    """The rows of several, with the monomials of all."""
    exponents = np.vstack([part.exponents for part in parts])
    logs = np.full((sum(len(part.logs) for part in parts), len(exponents)), -np.inf)
    row = column = 0
    for part in parts:
        height, width = part.logs.shape
        logs[row : row + height, column : column + width] = part.logs
        row, column = row + height, column + width
    return Posynomials(logs, exponents)


@dataclass(frozen=True, eq=False)
class Sliders:
    """Some pixels of an image, in shares of a bound, as posynomials of scales.

    Parameters
    ----------
    part
        Those pixels, as a system.
    spectra
        Γ through the bound's matrix, divided by the bound.
    monomial
        For each interaction, the number of its monomial.
    exponents
        Of each monomial, in each scale; the first monomial is the constant.
    pixels
        The pixels' numbers in the picture.
    """

    part: LinearSystem
    spectra: Float[np.ndarray, "interaction slab"]
    monomial: Int[np.ndarray, " interaction"]
    exponents: Float[np.ndarray, "monomial scale"]
    pixels: Int[np.ndarray, " pixel"]

    @cached_property
    def still(self) -> Bool[np.ndarray, "pixel slab"]:
        """Bands that no scale moves."""
        return self.part.times(np.where(self.monomial[:, None] > 0, self.spectra, 0.0)) == 0

    def brightest(self, y: Point) -> tuple[Float[np.ndarray, " pixel"], Int[np.ndarray, " pixel"]]:
        """Each pixel's largest share of a bound at y, and in which band, of those that some scale moves."""
        return self._extreme(y, 0.0, np.argmax)

    def darkest(self, y: Point) -> tuple[Float[np.ndarray, " pixel"], Int[np.ndarray, " pixel"]]:
        """Each pixel's least share of a bound at y, and in which band, of those that some scale moves."""
        return self._extreme(y, np.inf, np.argmin)

    def _extreme(
        self, y: Point, ignored: float, choose: Callable[..., np.ndarray]
    ) -> tuple[Float[np.ndarray, " pixel"], Int[np.ndarray, " pixel"]]:
        factors = np.exp(self.exponents @ y)[self.monomial, None] * self.spectra
        value, slab = np.empty(len(self.pixels)), np.empty(len(self.pixels), dtype=int)
        for start in range(0, len(value), SHARES_AT_ONCE):
            rows = slice(start, start + SHARES_AT_ONCE)
            shares = np.where(self.still[rows], ignored, self.part.times(factors, rows))
            slab[rows] = choose(shares, axis=1)
            value[rows] = np.take_along_axis(shares, slab[rows, None], axis=1)[:, 0]
        return value, slab

    def rows(self, pixel: Rows, slab: Rows) -> Posynomials:
        """Some of the pixels' bands; pixels are counted in this object."""
        terms = self.part.G[pixel].toarray() * self.spectra[:, slab].T
        members = np.zeros((len(self.monomial), len(self.exponents)))
        members[np.arange(len(self.monomial)), self.monomial] = 1.0
        with np.errstate(divide="ignore"):
            return Posynomials(np.log(terms @ members), self.exponents)

    def first(self) -> tuple[Rows, Rows]:
        """For each monomial but the constant the pixel and the band in which it is largest."""
        found = []
        for m in range(1, len(self.exponents)):
            mine = self.part.times(np.where((self.monomial == m)[:, None], self.spectra, 0.0))
            if mine.any():
                found.append(np.unravel_index(mine.argmax(), mine.shape))
        pairs = np.unique(np.array(found, dtype=int).reshape(-1, 2), axis=0)
        return pairs[:, 0], pairs[:, 1]


def sliders(
    system: LinearSystem,
    palette: Palette,
    scales: Mapping[str, frozenset[str]],
    bound: Bound,
    pixels: Int[np.ndarray, " pixel"],
    *,
    upper: bool = True,
) -> Sliders:
    """Pixels of a system as posynomials of scales, each of which multiplies some symbols.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.5*key*brass.diffuse + 0.25*key*brass.diffuse*brass.mirror", white={"key": 0.5})
    >>> colours = Palette(RGB, {"key": 1, "brass.diffuse": 0.5, "brass.mirror": 0.4})
    >>> bound = Bound(np.eye(3), np.zeros(3), np.full(3, 0.5), np.arange(3))
    >>> brass = {"brass": frozenset({"brass.diffuse", "brass.mirror"})}
    >>> image = sliders(system, colours, brass, bound, np.array([0]))
    >>> image.exponents.ravel().tolist(), image.brightest(np.zeros(1))[0].round(12)
    ([0.0, 1.0, 2.0], array([0.6]))
    """
    # Each interaction has a degree in each scale; interactions of the same degrees share a monomial.
    against = bound.upper if upper else bound.lower
    bounding = _bounding(against)
    blocks = system.blocks(*scales.values())

    # Divide the spectra by the bounds that there are: finite, and above 0.
    return Sliders(
        part=replace(system, tail=None).rows(pixels),
        spectra=gamma(system.interactions, palette) @ bound.matrix[:, bounding] / against[bounding],
        monomial=blocks.of,
        exponents=blocks.degrees.astype(float),
        pixels=pixels,
    )


def _bounding(against: Float[np.ndarray, " slab"]) -> Bool[np.ndarray, " slab"]:
    return np.isfinite(against) & (against > 0)
