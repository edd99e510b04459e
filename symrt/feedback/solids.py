"""Intervals of a parameter in gamuts with a black of their own, hulls, inks and solids of colours: step 5 of the paper.

Bounds of each band begin at 0 and let shadows be.  A hull of prints ends at the device's black, and so does a solid of
their colours; they are asked about the pixels that are lighter than that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np
from jaxtyping import Bool, Float, Int
from tqdm.auto import tqdm

from symrt.arrays import PixelBands, Spectrum
from symrt.feedback.along import Along
from symrt.feedback.bounds import Bound
from symrt.feedback.intervals import inside_at, intervals
from symrt.feedback.lines import Line
from symrt.feedback.paints import Paints
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.looking import Spans, looked_for
from symrt.spectra.bands import Number

ASKED_AT_ONCE = 64
"""Pixels that a hull, or inks, are asked about at a time."""

Pixels = Int[np.ndarray, " _"]
Powers = Float[np.ndarray, "power pixel band"]
Range = tuple[Number, Number]


@dataclass(frozen=True, eq=False)
class Solid:
    """A gamut with a black of its own, seen against a reference white.

    Parameters
    ----------
    gamut
        The gamut.
    bound
        Its slabs, if it has any: they answer for all pixels at once.
    shown
        The factors from radiance to reflectance, band by band.
    """

    gamut: ConvexGamut | UnevenGamut
    bound: Bound | None
    shown: Spectrum

    def spans(self, line: Line, pixels: Pixels, within: Range, progress: bool = False) -> Spans:
        """The parts of `within` that keep each of the pixels, counted from 0, inside."""
        if self.bound is not None:
            return intervals(line.seen(self.bound.matrix, pixels), self.bound, within)
        return self._asked(line, pixels, within, progress)

    def inside(self, line: Line, pixels: Pixels, t: Number) -> Bool[np.ndarray, " pixel"]:
        """Whether each of the pixels is inside at one t."""
        if self.bound is not None:
            return inside_at(line.seen(self.bound.matrix, pixels), self.bound, t)
        return self.gamut.contains(self.reflectances(line, pixels, t)) if len(pixels) else np.zeros(0, dtype=bool)

    def reflectances(self, line: Line, pixels: Pixels, t: Number) -> PixelBands:
        """Reflectances of some pixels at one t."""
        return self._reflected(line, pixels).at(t)

    def _reflected(self, line: Line, pixels: Pixels) -> Line:
        return line.seen(np.diag(self.shown), pixels)

    def _asked(self, line: Line, pixels: Pixels, within: Range, progress: bool) -> Spans:
        """The intervals of each pixel in a gamut that can only be asked pixel by pixel, in chunks."""
        parts = []
        starts = range(0, len(pixels), ASKED_AT_ONCE)
        for start in tqdm(starts, desc="gamut", unit="chunk", delay=1, leave=False, disable=not progress):
            chunk = pixels[start : start + ASKED_AT_ONCE]
            seen = self._reflected(line, chunk)
            found = self._chunk(seen, within)
            parts.append(found._replace(pixel=found.pixel + start))
        if not parts:
            return Spans(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
        return Spans(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _chunk(self, seen: Line, within: Range) -> Spans:
        """The intervals of a chunk: curves, and lines in gamuts that are not convex, are looked at point by point."""
        gamut = self.gamut
        if isinstance(seen, Paints):
            return looked_for(lambda i, t: gamut.contains(seen.points(i, t)), len(seen.degrees), within)
        c = seen.coefficients(slice(None))
        if isinstance(gamut, UnevenGamut) or seen.degree > 1:
            return looked_for(lambda i, t: gamut.contains(_points(seen, c[:, i], t)), c.shape[1], within)

        # A straight line is clipped by a convex gamut.
        direction = c[-1] - c[0] if seen.form == "bernstein" else c[1] if len(c) > 1 else np.zeros_like(c[0])
        found = gamut.clip(c[0], direction)
        low, high = np.maximum(found.low, within[0]), np.minimum(found.high, within[1])
        kept = np.flatnonzero(low <= high)
        return Spans(kept, low[kept], high[kept])


def swept(parts: Sequence[Spans], needed: int) -> Spans:
    """The intervals that at least `needed` of several sets share: 1 for their union, all for their intersection.

    Examples
    --------
    >>> one = Spans(np.array([0, 0]), np.array([0.0, 3.0]), np.array([1.0, 4.0]))
    >>> other = Spans(np.array([0, 1]), np.array([0.5, 0.0]), np.array([3.5, 1.0]))
    >>> [column.tolist() for column in swept([one, other], 2)]
    [[0, 0], [0.5, 3.0], [1.0, 3.5]]
    >>> [column.tolist() for column in swept([one, other], 1)]
    [[0, 1], [0.0, 0.0], [4.0, 1.0]]
    """
    pixel = np.concatenate([part.pixel for part in parts])
    count = len(pixel)
    who, t = np.tile(pixel, 2), np.concatenate([part.low for part in parts] + [part.high for part in parts])
    change = np.repeat([1, -1], count)

    # Intervals are closed: at one t all beginnings come before all ends.
    order = np.lexsort((-change, t, who))
    inside = np.cumsum(change[order])
    before = inside - change[order]
    begins, ends = order[(before < needed) & (inside >= needed)], order[(before >= needed) & (inside < needed)]
    return Spans(who[begins], t[begins], t[ends])


def _points(seen: Along, c: Powers, t: Float[np.ndarray, " pixel"]) -> PixelBands:
    """Each pixel at a t of its own."""
    degree = len(c) - 1
    k = np.arange(degree + 1)[:, None]
    weights = t**k
    if seen.form == "bernstein":
        weights = np.array([comb(degree, j) for j in range(degree + 1)])[:, None] * (1 - t) ** (degree - k) * weights
    return np.einsum("kp,kpb->pb", weights, c)
