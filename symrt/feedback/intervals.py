"""The values of a parameter that each pixel allows: step 5 of the paper, tile by tile.

An affine pixel is clipped, a posynomial's bounds are met once each, and anything else is enclosed in Bernstein's form.
Pixels are themselves sums of rounded products: the bounds are moved inwards by as much as those can be off, so that
the certificate holds for the system's and the palette's own numbers.
"""

from collections.abc import Sequence
from math import comb

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.feedback.along import Along
from symrt.feedback.bounds import Bound, Sizes, alike
from symrt.feedback.lines import Line
from symrt.feedback.paints import PIXELS_AT_ONCE, Paints, painted_intervals
from symrt.feedback.polynomials import highest, lowest, spans_inside
from symrt.gamut.clipping import clip_slabs
from symrt.gamut.interface import ROUNDING
from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number

FEW_SLABS = 32
"""Slabs; of fewer, more pixels fit."""

LONG = 100
"""Ranges that end beyond are looked at pixel by pixel for what rounding can amount to."""
FAR = 1 - 1e-9
"""A pixel below this share of its bounds is inside whatever its rounding, as nobody adds a million numbers."""

Rows = Int[np.ndarray, " _"]
Powers = Float[np.ndarray, "power pixel slab"]
Slabs = Float[np.ndarray, " slab"]
Moved = Float[np.ndarray, "*pixel slab"]
Range = tuple[Number, Number]


def intervals(line: Line, bound: Bound, within: Range, inward: int = 2) -> Spans:
    """The parts of `within` that keep each row of `line`, already seen through the bound's matrix, inside.

    Rows that no value keeps inside do not occur in the result.  The bounds are moved inwards by `inward` times what the
    rounding of a row can amount to.
    """
    if isinstance(line, Paints):
        return painted_intervals(line, bound, within)
    sure, rest = _parted(line, bound, within[1])
    line = line if not len(sure) else line.taken(rest)
    tiles = [Spans(sure, np.full(len(sure), float(within[0])), np.full(len(sure), float(within[1])))]
    for start in range(0, len(rest), PIXELS_AT_ONCE):
        found = _tile(line, slice(start, start + PIXELS_AT_ONCE), bound, within, inward)
        tiles.append(found._replace(pixel=rest[found.pixel + start]))
    return _ordered(tiles)


def inside_at(line: Line, bound: Bound, t: Number, share: float = 1.0) -> Bool[np.ndarray, " pixel"]:
    """Whether each row is inside at one t; a row that rounding cannot tell from the boundary is."""
    # Rows far below every bound need no spectra.
    error = -share * line.terms * ROUNDING
    inside = np.ones(len(line.degrees), dtype=bool)
    rest = np.arange(len(inside))
    if isinstance(line, Along):
        sure, rest = _parted(line, bound, t)
        line = line if not len(sure) else line.taken(rest)

    # Compare the others with bounds moved outwards by their rounding.
    size = max(PIXELS_AT_ONCE, PIXELS_AT_ONCE * FEW_SLABS // max(1, len(bound.upper)))
    for start in range(0, len(rest), size):
        rows = slice(start, start + size)
        lower, upper = _moved(bound.lower, bound.upper, error, error * line.size(t, rows))
        values = line.at(t, rows)
        inside[rest[rows]] = ((lower <= values) & (values <= upper)).all(axis=1)
    return inside


def certified(final: Along, line: Along, bound: Bound) -> Bool[np.ndarray, " pixel"]:
    """Whether each row of a finished image is inside whatever its rounding, in every slab that `line` moves.

    In the others it is enough that the row cannot be told from the boundary.
    """
    error = final.terms * ROUNDING
    inside = np.empty(len(final.degrees), dtype=bool)
    for start in range(0, len(inside), PIXELS_AT_ONCE):
        rows = slice(start, start + PIXELS_AT_ONCE)
        size = final.size(1.0, rows)
        sure = _moved(bound.lower, bound.upper, error, error * size)
        perhaps = _moved(bound.lower, bound.upper, -error, -error * size)
        values, moves = final.at(1.0, rows), (line.coefficients(rows)[1:] != 0).any(axis=0)
        lower, upper = (np.where(moves, *pair) for pair in zip(sure, perhaps, strict=True))
        inside[rows] = ((lower <= values) & (values <= upper)).all(axis=1)
    return inside


def _parted(line: Along, bound: Bound, top: Number) -> tuple[Rows, Rows]:
    """Rows that stay so far below every bound up to `top` that one number each shows it, and all others."""
    rows = np.arange(len(line.degrees))
    if line.signed or len(bound.upper) < 2 or not (bound.lower <= 0).all() or not (bound.upper > 0).all():
        return rows[:0], rows
    sure = line.brightest(top, bound.upper) <= FAR
    return rows[sure], rows[~sure]


def _tile(line: Along, rows: slice, bound: Bound, within: Range, inward: int) -> Spans:
    """The intervals of some of the rows."""
    # Bound the magnitudes that rounding is a share of.
    c, curved, rounding = line.coefficients(rows), line.degrees[rows] > 1, line.terms * ROUNDING
    size = np.broadcast_to(line.size(_reached(line, c, bound, within[1]), rows), (len(curved), 1))
    # In Bernstein's form differences are rounded, too.
    differences = np.abs(c).max(axis=(0, 2), initial=0)[:, None] / line.terms if line.form == "bernstein" else 0.0

    # Rows of about the same size have their bounds moved by as much.
    parts = []
    for group, largest in alike(size + differences, bound):
        moved = _moved(bound.lower, bound.upper, inward * rounding, inward * rounding * largest)
        if (moved[0] > moved[1]).any():  # So large that nothing can be told from outside.
            continue
        wide = _moved(bound.lower, bound.upper, -rounding, -rounding * float(size[group].max()))
        part = _eased(line, c if len(group) == len(curved) else c[:, group], wide, moved)
        found = _group(curved[group], line, part, moved, within)
        parts.append(found._replace(pixel=group[found.pixel]))
    return _ordered(parts)


def _reached(line: Along, c: Powers, bound: Bound, top: Number) -> float | Float[np.ndarray, " pixel"]:
    """The largest t that rounding may be asked about: the end of the range, or of each pixel's line if that is far."""
    if not line.signed or line.form != "power" or line.degree != 1 or top <= LONG:
        return max(1.0, float(top))
    return np.clip(clip_slabs(bound.lower, bound.upper, c[0], c[1]).high, 1.0, float(top))


def _group(
    curved: Bool[np.ndarray, " pixel"], line: Along, c: Powers, bounds: tuple[Slabs, Slabs], within: Range
) -> Spans:
    """The intervals of pixels whose bounds are moved by the same amounts: affine ones, and curved ones."""
    if not curved.any():
        return _affine(line, c, bounds, within)
    straight, bent = _affine(line, c[:, ~curved], bounds, within), _curved(line, c[:, curved], bounds, within)
    places = np.flatnonzero(~curved)[straight.pixel], np.flatnonzero(curved)[bent.pixel]
    return _ordered([found._replace(pixel=place) for found, place in zip((straight, bent), places, strict=True)])


def _ordered(parts: Sequence[Spans]) -> Spans:
    """The spans of several sets of pixels, in the order of the pixels."""
    if len(parts) == 1:
        return parts[0]
    none = Spans(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
    whole = Spans(*(np.concatenate(column) for column in zip(none, *parts, strict=True)))
    order = np.argsort(whole.pixel, kind="stable")
    return Spans(*(column[order] for column in whole))


def _eased(line: Along, c: Powers, wide: tuple[Slabs, Slabs], moved: tuple[Slabs, Slabs]) -> Powers:
    """The coefficients, moved inside the narrowed bounds where t does not move a slab and it is inside."""
    still = ~(c[1:] != (0.0 if line.form == "power" else c[0])).any(axis=0)
    if not still.any():
        return c
    inside = still & (wide[0] <= c[0]) & (c[0] <= wide[1])
    eased = np.where(inside, np.clip(c[0], *moved), c[0])
    return np.concatenate([eased[None], c[1:] if line.form == "power" else np.where(inside, eased, c[1:])])


def _affine(line: Along, c: Powers, bounds: tuple[Slabs, Slabs], within: Range) -> Spans:
    direction = c[1] if line.form == "power" else c[-1] - c[0]
    found = clip_slabs(*bounds, c[0], direction)
    return _within(found.low, found.high, within)


def _curved(line: Along, c: Powers, bounds: tuple[Slabs, Slabs], within: Range) -> Spans:
    lower, upper = bounds
    if line.form == "bernstein":
        return spans_inside(c, lower, upper, within)
    if line.signed:
        found = spans_inside(_bernstein(c, float(within[1])), lower, upper, (within[0] / within[1], 1.0))
        return Spans(found.pixel, found.low * within[1], found.high * within[1])
    low = lowest(c, lower, within[1]) if (lower > 0).any() else np.full(c.shape[1], float(within[0]))
    return _within(low, highest(c, upper, within[1]), within)


def _within(low: Float[np.ndarray, " pixel"], high: Float[np.ndarray, " pixel"], within: Range) -> Spans:
    low, high = np.maximum(low, within[0]), np.minimum(high, within[1])
    kept = np.flatnonzero(low <= high)
    return Spans(kept, low[kept], high[kept])


def _moved(lower: Slabs, upper: Slabs, error: float, extra: float | Sizes) -> tuple[Moved, Moved]:
    """Bounds moved inwards (outwards for a negative error) by a share of their size, and by a constant."""
    down, up = (np.where(np.isfinite(b), error * np.abs(b) + extra, 0.0) for b in (lower, upper))
    return lower + down, upper - up


def _bernstein(q: Powers, top: float) -> Powers:
    """Bernstein coefficients, in t / top, of Σ t^k q_k."""
    degree = len(q) - 1
    return np.stack(
        [
            sum((comb(j, k) / comb(degree, k) * top**k * q[k] for k in range(j + 1)), np.zeros_like(q[0]))
            for j in range(degree + 1)
        ]
    )
