"""The share of pixels that each value of a parameter keeps inside: one sweep over the sorted ends of their intervals.

The paper, §5: "clipping can be applied to force all pixels in-gamut, or some percentage of out-of-gamut pixels may be
allowed".  The sweep gives the whole curve, and from it the values, perhaps in several pieces, that keep enough inside.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number

Kind = Literal["upper", "dark", "range", "cap"]
Weights = Int[np.ndarray, " span"] | None


class End(NamedTuple):
    """The end of an interval: the pixel that makes it and its kind of bound, or no pixel, -1."""

    kind: Kind
    pixel: int = -1


class Piece(NamedTuple):
    """A closed interval of t, with its end on either side."""

    low: float
    high: float
    below: End
    above: End


class Steps(NamedTuple):
    """Different values in rising order, and the sum of the weights of all up to each."""

    values: Float[np.ndarray, " step"]
    sums: Int[np.ndarray, " step"]

    def up_to(self, t: Float[np.ndarray, " value"], *, before: bool = False) -> Int[np.ndarray, " value"]:
        """The sum of the weights of the values up to each t, or before it."""
        return np.append(0, self.sums)[np.searchsorted(self.values, t, side="left" if before else "right")]


@dataclass(frozen=True, eq=False)
class Curve:
    """Share of the object pixels that are outside, as a function of t.

    Parameters
    ----------
    begins, ends
        All beginnings, and all ends, of the intervals in which a pixel is inside.
    always
        Pixels that are inside throughout, each times its weight.
    pixels
        Object pixels, each times its weight.
    """

    begins: Steps
    ends: Steps
    always: int
    pixels: int

    def outside(self, t: Float[np.ndarray, " value"]) -> Float[np.ndarray, " value"]:
        """The share outside at each t."""
        inside = self.begins.up_to(t) - self.ends.up_to(t, before=True)
        return 1 - (inside + self.always) / max(1, self.pixels)

    @property
    def values(self) -> Float[np.ndarray, " value"]:
        """The t at which the share changes: enough points to draw it."""
        return np.unique(np.concatenate([self.begins.values, self.ends.values]))

    def least(self, within: tuple[Number, Number]) -> tuple[float, float]:
        """The t of a range at which the smallest share is outside, and that share: the middle of its best part."""
        corners = np.unique(np.clip(np.append(self.values, within), *within))
        t = np.sort(np.concatenate([corners, (corners[1:] + corners[:-1]) / 2]))
        share = self.outside(t)
        best = np.flatnonzero(share == share.min())
        run = best[: int(np.argmax(np.diff(best, append=best[-1] + 2) > 1)) + 1]
        return float(t[run[len(run) // 2]]), float(share.min())


def curve(spans: Spans, always: int, pixels: int, weights: Weights = None) -> Curve:
    """The curve of shares, from the intervals of the pixels that the parameter touches.

    Parameters
    ----------
    weights
        Weights of the pixel of each interval, whole numbers; 1 each if not given.

    Examples
    --------
    >>> spans = Spans(np.array([0, 1]), np.array([0.0, 0.0]), np.array([1.0, 2.0]))
    >>> curve(spans, always=2, pixels=4).outside(np.array([0.5, 1.0, 1.5, 2.5]))
    array([0.  , 0.  , 0.25, 0.5 ])
    """
    return Curve(_steps(spans.low, weights), _steps(spans.high, weights), always, pixels)


def pieces(
    spans: Spans, within: tuple[Number, Number], needed: int, kind: Kind, weights: Weights = None
) -> list[Piece]:
    """The parts of the range in which at least `needed` of the pixels, by their weights, are inside.

    Intervals are closed: at one t all beginnings come before all ends.

    Examples
    --------
    >>> spans = Spans(np.array([7, 8]), np.array([0.0, 0.5]), np.array([1.0, 2.0]))
    >>> pieces(spans, (0.0, 2.0), needed=2, kind="upper")
    [Piece(low=0.5, high=1.0, below=End(kind='upper', pixel=8), above=End(kind='upper', pixel=7))]
    """
    # Intervals that are the whole range end nothing: they are counted once.
    first, last = (float(end) for end in within)
    partly = (spans.low != first) | (spans.high != last)
    kept = Spans(*(column[partly] for column in spans))
    always = int((~partly).sum()) if weights is None else int(weights[~partly].sum())
    weights = None if weights is None else weights[partly]

    # Count the weights inside on both sides of every beginning and of every end.
    begins, ends = _steps(kept.low, weights), _steps(kept.high, weights)
    come, gone = always + begins.up_to(ends.values), ends.up_to(begins.values, before=True)
    inside, left = come - np.append(0, ends.sums)[:-1], come - ends.sums
    enough, fewer = always + begins.sums - gone, always + np.append(0, begins.sums)[:-1] - gone

    # A piece starts where they become enough, and stops where they become too few.
    starts = np.flatnonzero((enough >= needed) & (fewer < needed) & (begins.values > first))
    stops = np.flatnonzero((inside >= needed) & (left < needed) & (ends.values < last))

    # Name the pixel that makes the difference there, or the range.
    below, above = [], []
    if always + _at(begins, first) >= needed:
        below.append((first, End("range")))
    for t, more in zip(begins.values[starts].tolist(), (needed - fewer[starts]).tolist(), strict=True):
        below.append((t, _nth(kind, kept.pixel, kept.low == t, weights, more)))
    for t, less in zip(ends.values[stops].tolist(), (inside[stops] - needed + 1).tolist(), strict=True):
        above.append((t, _nth(kind, kept.pixel, kept.high == t, weights, less)))
    if always + _at(begins, last) - _at(ends, last, before=True) >= needed:
        above.append((last, End("range")))
    return [Piece(low, high, one, other) for (low, one), (high, other) in zip(below, above, strict=True)]


def tightest(spans: Spans, kind: Kind) -> Piece:
    """The largest beginning and the least end of all, with low > high where they have no t in common."""
    low, high = int(spans.low.argmax()), int(spans.high.argmin())
    return Piece(
        float(spans.low[low]),
        float(spans.high[high]),
        End(kind, int(spans.pixel[low])),
        End(kind, int(spans.pixel[high])),
    )


def _steps(values: Float[np.ndarray, " span"], weights: Weights) -> Steps:
    order = None if weights is None else np.argsort(values)
    values = np.sort(values) if order is None else values[order]
    ends = np.flatnonzero(np.append(values[1:] != values[:-1], True)[: len(values)])
    sums = ends + 1 if weights is None else np.cumsum(weights[order])[ends]
    return Steps(values[ends], sums)


def _at(steps: Steps, t: float, *, before: bool = False) -> int:
    return int(steps.up_to(np.array([t]), before=before)[0])


def _nth(
    kind: Kind, pixel: Int[np.ndarray, " span"], here: Bool[np.ndarray, " span"], weights: Weights, sought: int
) -> End:
    """Of the pixels whose intervals begin or end here, the first with which they count as much as is sought."""
    which = np.flatnonzero(here)
    sums = np.arange(1, len(which) + 1) if weights is None else np.cumsum(weights[which])
    return End(kind, int(pixel[which[np.searchsorted(sums, sought)]]))


def shared(one: list[Piece], other: list[Piece]) -> list[Piece]:
    """The intersection of two lists of pieces; where both end together, the end is that of the first.

    Examples
    --------
    >>> a, b = Piece(0.0, 2.0, End("range"), End("upper", 7)), Piece(0.5, 3.0, End("dark", 1), End("range"))
    >>> shared([a], [b])
    [Piece(low=0.5, high=2.0, below=End(kind='dark', pixel=1), above=End(kind='upper', pixel=7))]
    """
    common = []
    for a in one:
        for b in other:
            low, high = max(a, b, key=lambda p: p.low), min(a, b, key=lambda p: p.high)
            if low.low <= high.high:
                common.append(Piece(low.low, high.high, low.below, high.above))
    return common
