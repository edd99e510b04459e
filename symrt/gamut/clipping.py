"""Clip lines to slabs, certified, by Liang and Barsky's method in any dimension: step 5 of the paper.

Changing one parameter ``t`` moves a pixel along ``origin + t direction``.  A slab ``lower <= r <= upper`` allows the
``t`` between ``(lower - origin) / direction`` and ``(upper - origin) / direction``, **closed**; where the direction is
zero it allows all or nothing.  A pixel's interval is the intersection over its slabs [1]_.

The rounded quotient lies outside the gamut, in exact arithmetic, in more than half of all clips.  But a difference and
a quotient of floats are each off by at most a factor 1 ± u, u = 2⁻⁵³, so that moving an end inwards by 4u of its size
puts it back inside, and the spectrum there moves by less than 64u.  What this leaves undecided, an interval narrower
than that, is decided in exact rationals.

References
----------
.. [1] Y.-D. Liang and B. A. Barsky, "A New Concept and Method for Line Clipping", ACM TOG 3(1), 1984, pp. 1-22.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt import fast
from symrt.gamut.exact import clip_exactly

TILE_NUMBERS = 1 << 15
"""Numbers in a tile: the five arrays of a tile stay in a core's cache."""
INWARD = 2.0**-51
"""4u, because (1 + u)³ (1 − 4u) < 1: difference, quotient, and the rounding of the move itself."""
SAFE = 2.0**200
"""Differences and quotients of numbers between 1/SAFE and SAFE neither overflow nor vanish."""
NUMBERS = 32
"""Numbers that NumPy clips in the time in which it asks a ray about a shape."""
TINY = 2.0**-600
"""Ends smaller than this may have lost digits, or vanished, if an origin is tiny."""
SUBNORMAL = 2.0**-1072
"""Below the normal numbers an error of 4u is not relative; four of the smallest steps there cover it."""

Lines = Float[np.ndarray, "pixel slab"]
Bounds = Float[np.ndarray, " slab"]
LineEnds = Float[np.ndarray, " pixel"]
Pixels = Int[np.ndarray, " pixel"]


@dataclass(frozen=True, eq=False)
class Interval:
    """Parameter values that keep each pixel inside; ``low = inf > high = -inf`` where there are none.

    Parameters
    ----------
    low, high
        Ends of each pixel's interval; every one of them is inside in exact arithmetic.
    uncertain
        Pixels that some real t keeps inside, but no float: counted as empty.
    """

    low: LineEnds
    high: LineEnds
    uncertain: Bool[np.ndarray, " pixel"]

    @property
    def empty(self) -> Bool[np.ndarray, " pixel"]:
        """Pixels that no t keeps inside."""
        return self.low > self.high

    def __repr__(self) -> str:
        return f"Interval(low={self.low!r}, high={self.high!r})"


class _Scratch(NamedTuple):
    """Room for a tile, used again for the next, so that it stays in cache."""

    first: Lines
    near: Lines
    far: Lines


def clip_slabs(
    lower: Bounds,
    upper: Bounds,
    origin: Lines,
    direction: Lines,
    moving: Bool[np.ndarray, " pixel"] | None = None,
) -> Interval:
    """Clip the line ``origin + t direction`` of every pixel to the slabs ``lower <= r <= upper``.

    Parameters
    ----------
    lower, upper
        Bounds of each slab; infinite where it is open.
    origin, direction
        Of each pixel's line, finite, one column a slab.
    moving
        Pixels whose direction is not zero in every slab, where that is known, as from the sparsity of G: the others
        need no quotient.  None: any may move.

    Raises
    ------
    ValueError
        If a pixel is not finite, or a bound is nan or upside down.

    Examples
    --------
    A grey of 0.5, scaled from black, stays reproducible up to twice itself:

    >>> grey = np.full((1, 2), 0.5)
    >>> clip_slabs(np.zeros(2), np.ones(2), np.zeros((1, 2)), grey).high.round(12)
    array([2.])
    """
    # Refuse bad bounds; without slabs nothing is bounded.
    _check_bounds(lower, upper)
    pixels, slabs = origin.shape
    low, high, doubtful = np.empty(pixels), np.empty(pixels), np.zeros(pixels, dtype=bool)
    if slabs == 0:
        return Interval(np.full(pixels, -np.inf), np.full(pixels, np.inf), doubtful)

    # Walk through the pixels in tiles that stay in cache.
    size = min(max(1, TILE_NUMBERS // slabs), max(1, pixels))
    scratch = _Scratch(*(np.empty((size, slabs)) for _ in range(3)))
    ordinary = _ordinary(lower) and _ordinary(upper)
    with np.errstate(all="ignore"):
        for start in range(0, pixels, size):
            rows: slice | Pixels = slice(start, min(start + size, pixels))
            q, d = origin[rows], direction[rows]

            # Pixels that do not move need no quotient.
            if moving is not None:
                some = np.flatnonzero(moving[rows])
                low[rows], high[rows] = _resting(lower, upper, q, start)
                rows, q, d = start + some, q[some], d[some]
                if not len(q):
                    continue

            # Divide, the plain way.
            room = _Scratch(*(s[: len(q)] for s in scratch))
            ends = np.empty(len(q)), np.empty(len(q))
            careful = _quotients(lower, upper, q, d, room, *ends)

            # Divide again with scaled numbers where digits may have been lost: overflow, underflow, or 0/0.
            again = np.flatnonzero(careful) if ordinary else np.arange(len(q))
            if again.size:
                numbers = np.arange(pixels)[rows][again]
                check_lines(q[again], d[again], numbers)
                near, far, doubt = _scaled_quotients(lower, upper, q[again], d[again])
                ends[0][again], ends[1][again] = near.max(axis=1), far.min(axis=1)
                doubtful[numbers] = doubt.any(axis=1)
            low[rows], high[rows] = ends

        # Round the ends inwards.
        return _certified(lower, upper, origin, direction, (low, high), doubtful)


def blocking(lower: Bounds, upper: Bounds, origin: Lines, direction: Lines) -> Int[np.ndarray, "2 pixel"]:
    """The slab that ends each pixel's interval below, and the one that ends it above; of equals, the first.

    Examples
    --------
    >>> blocking(np.zeros(2), np.ones(2), np.array([[0.5, 0.5]]), np.array([[0.1, -0.4]])).tolist()
    [[1], [1]]
    """
    check_lines(origin, direction, np.arange(len(origin)))
    with np.errstate(all="ignore"):
        near, far, _ = _scaled_quotients(lower, upper, origin, direction)
    return np.array([near.argmax(axis=1), far.argmin(axis=1)])


def _resting(lower: Bounds, upper: Bounds, q: Lines, start: int) -> tuple[LineEnds, LineEnds]:
    """All of the line, or none, for pixels that do not move: they need no quotient."""
    met = (lower <= q) & (q <= upper)
    if met.all():
        return np.full(len(q), -np.inf), np.full(len(q), np.inf)
    inside = met.all(axis=1)
    outside = np.flatnonzero(~inside)
    check_lines(q[outside], np.zeros_like(q[outside]), start + outside)
    return np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)


def _quotients(
    lower: Bounds, upper: Bounds, q: Lines, d: Lines, scratch: _Scratch, low: LineEnds, high: LineEnds
) -> Bool[np.ndarray, " pixel"]:
    """Write the ends of a tile's intervals, unmoved; say for which pixels they cannot be relied on."""
    # A compiled form gives the same bits, where there is enough to do.
    kernels = fast.kernels("symrt.gamut.fast.slabs", q.size // NUMBERS + 1)
    if kernels and all(values.dtype == np.float64 for values in (lower, upper, q, d)):
        careful = np.empty(len(q), dtype=bool)
        kernels.quotients(*map(_ready, (lower, upper, q, d)), low, high, careful)
        return careful

    first, near, far = scratch
    if not _largest(d) < SAFE:  # nan fails the test, too
        return np.ones(len(q), dtype=bool)

    # Each slab gives two quotients; the later of the firsts and the earlier of the lasts bound the interval.
    for bound, ends in ((lower, near), (upper, far)):
        np.subtract(bound, q, out=ends)
        np.divide(ends, d, out=ends)
    np.minimum(near, far, out=first)
    np.maximum(near, far, out=far)
    first.max(axis=1, out=low)
    far.min(axis=1, out=high)

    # nan stands for 0 / 0: parallel to a slab and on its face.
    careful = np.isnan(low) | np.isnan(high)

    # Ends that are tiny or infinite may have lost digits, or vanished, or overflowed: the numbers' sizes tell.
    small = (np.abs(low) < TINY) | (np.abs(high) < TINY)
    if small.any() and _smallest(q, near) < TINY * SAFE:
        careful |= small
    endless = np.isinf(low) | np.isinf(high)
    if endless.any() and (_smallest(d, near) < 1 / SAFE or not _largest(q) < SAFE):
        careful |= endless
    return careful


def _scaled_quotients(
    lower: Bounds, upper: Bounds, q: Lines, d: Lines
) -> tuple[Lines, Lines, Bool[np.ndarray, "pixel slab"]]:
    """The two ends that each slab gives, with numbers brought near 1 by powers of two first.

    It gives the same bits as the plain formula where that is safe.  An end that is no float is moved inwards to the
    next one; where that cannot be done, the slab is doubtful.
    """
    rising = d >= 0
    near, near_lost = _scaled_end(np.where(rising, lower, upper), q, d, np.inf)
    far, far_lost = _scaled_end(np.where(rising, upper, lower), q, d, -np.inf)
    # A line parallel to a slab never crosses it: the slab allows all of the line or none.
    parallel, inside = d == 0, (lower <= q) & (q <= upper)
    near = np.where(parallel, np.where(inside, -np.inf, np.inf), near)
    far = np.where(parallel, np.where(inside, np.inf, -np.inf), far)
    return near, far, (near_lost | far_lost) & ~parallel


def _scaled_end(bound: Lines, q: Lines, d: Lines, inward: float) -> tuple[Lines, Bool[np.ndarray, "pixel slab"]]:
    """``(bound - q) / d``, and where it is no float; a bound and an origin share a scale, so neither loses digits."""
    scale, (mantissa, exponent) = np.frexp(np.maximum(np.abs(q), _finite(bound)))[1], np.frexp(d)
    ends = (np.ldexp(bound, -scale) - np.ldexp(q, -scale)) / mantissa
    return _unscaled(ends, scale - exponent, inward)


def _unscaled(
    ends: Lines, exponent: Int[np.ndarray, "pixel slab"], inward: float
) -> tuple[Lines, Bool[np.ndarray, "pixel slab"]]:
    values = np.ldexp(ends, exponent)
    vanished = (np.abs(values) < np.finfo(float).tiny) & (ends != 0)
    values = np.where(vanished, values + np.copysign(SUBNORMAL, inward), values)
    burst = np.isfinite(ends) & np.isinf(values)
    values = np.where(burst, np.nextafter(values, inward), values)
    return values, burst & np.isinf(values)


def _certified(
    lower: Bounds,
    upper: Bounds,
    origin: Lines,
    direction: Lines,
    ends: tuple[LineEnds, LineEnds],
    doubtful: Bool[np.ndarray, " pixel"],
) -> Interval:
    """Move the ends inwards; where that empties an interval, let exact rationals decide."""
    size = [np.where(np.isfinite(end), INWARD * np.abs(end), 0.0) for end in ends]
    # Adding 0 takes the sign from a zero: it would hang on the order of the slabs.
    low, high = ends[0] + size[0] + 0.0, ends[1] - size[1] + 0.0

    # An interval that is empty even when its ends are moved outwards is empty for certain; decide the others exactly.
    certainly_empty = (ends[0] - (size[0] + 4 * SUBNORMAL) > ends[1] + (size[1] + 4 * SUBNORMAL)) & ~doubtful
    uncertain = np.zeros(len(low), dtype=bool)
    for pixel in np.flatnonzero(((low > high) & ~certainly_empty) | doubtful):
        low[pixel], high[pixel], uncertain[pixel] = clip_exactly(lower, upper, origin[pixel], direction[pixel])

    # Parallel and outside, both ends are at the same infinity.
    empty = (low > high) | (low == np.inf) | (high == -np.inf) | uncertain
    return Interval(np.where(empty, np.inf, low), np.where(empty, -np.inf, high), uncertain)


def _ready(values: np.ndarray) -> np.ndarray:
    """The same numbers as kernels take them: one after the other, in memory that may be written."""
    return values if values.flags.c_contiguous and values.flags.writeable else np.array(values, order="C")


def _largest(values: Lines) -> float:
    """The largest magnitude; nan if there is one."""
    return float(np.maximum(values.max(), -values.min()))


def _smallest(values: Lines, room: Lines) -> float:
    """The smallest magnitude that is not zero, nan where all are: as whole numbers, less one, zeros are the largest."""
    np.abs(values, out=room)
    bits = room.view(np.uint64)
    np.subtract(bits, np.uint64(1), out=bits)
    return float((bits.min() + np.uint64(1)).view(np.float64)) or np.nan


def _ordinary(bounds: Bounds) -> bool:
    sizes = _finite(bounds)
    return bool(np.all((sizes == 0) | ((sizes > 1 / SAFE) & (sizes < SAFE))))


def _finite(bounds: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
    """Sizes of the bounds, 0 for those that are open."""
    return np.where(np.isfinite(bounds), np.abs(bounds), 0.0)


def _check_bounds(lower: Bounds, upper: Bounds) -> None:
    wrong = ~(lower <= upper) | (lower == np.inf) | (upper == -np.inf)
    if wrong.any():
        slab = int(np.argmax(wrong))
        raise ValueError(
            f"slab {slab} is [{lower[slab]}, {upper[slab]}]: give a lower bound that is not above the upper"
        )


def check_lines(origin: Lines, direction: Lines, pixels: Int[np.ndarray, " pixel"]) -> None:
    """Refuse lines that are not finite, and name the pixel, by its number among `pixels`.

    Examples
    --------
    >>> check_lines(np.zeros((1, 2)), np.array([[1.0, np.inf]]), np.array([7]))
    Traceback (most recent call last):
    ValueError: pixel 7, slab 1: the direction is inf; shade with finite spectra
    """
    for name, values in (("origin", origin), ("direction", direction)):
        wrong = ~np.isfinite(values)
        if wrong.any():
            row, slab = np.argwhere(wrong)[0]
            raise ValueError(
                f"pixel {pixels[row]}, slab {slab}: the {name} is {values[row, slab]}; shade with finite spectra"
            )
