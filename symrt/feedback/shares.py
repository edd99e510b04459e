"""How many pixels each value of a parameter keeps inside: one sweep over the sorted ends of their intervals.

The paper, §5: "clipping can be applied to force all pixels in-gamut, or some percentage of out-of-gamut pixels may be
allowed".  The sweep gives the whole curve, and from it the values, perhaps in several pieces, that keep enough inside.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float

from symrt.feedback.polynomials import Spans
from symrt.spectra.bands import Number

__all__ = ["Curve", "End", "Kind", "Piece", "curve", "pieces", "shared", "tightest"]

Kind = Literal["upper", "dark", "range", "cap"]


class End(NamedTuple):
    """What ends an interval: a pixel and its kind of bound, or no pixel, -1."""

    kind: Kind
    pixel: int = -1


class Piece(NamedTuple):
    """A closed interval of t, and what ends it on either side."""

    low: float
    high: float
    below: End
    above: End


@dataclass(frozen=True, eq=False)
class Curve:
    """Share of the object pixels that are outside, as a function of t.

    Parameters
    ----------
    low, high
        All beginnings, and all ends, of the intervals in which a pixel is inside, each sorted.
    always
        Pixels that are inside throughout.
    pixels
        Object pixels.
    """

    low: Float[np.ndarray, " span"]
    high: Float[np.ndarray, " span"]
    always: int
    pixels: int

    def outside(self, t: Float[np.ndarray, " value"]) -> Float[np.ndarray, " value"]:
        """The share outside at each t."""
        inside = np.searchsorted(self.low, t, side="right") - np.searchsorted(self.high, t, side="left")
        return 1 - (inside + self.always) / max(1, self.pixels)

    @property
    def values(self) -> Float[np.ndarray, " value"]:
        """The t at which the share changes: enough points to draw it."""
        return np.unique(np.concatenate([self.low, self.high]))


def curve(spans: Spans, always: int, pixels: int) -> Curve:
    """The curve of shares, from the intervals of the pixels that the parameter touches.

    Examples
    --------
    >>> spans = Spans(np.array([0, 1]), np.array([0.0, 0.0]), np.array([1.0, 2.0]))
    >>> curve(spans, always=2, pixels=4).outside(np.array([0.5, 1.0, 1.5, 2.5]))
    array([0.  , 0.  , 0.25, 0.5 ])
    """
    return Curve(np.sort(spans.low), np.sort(spans.high), always, pixels)


def pieces(spans: Spans, within: tuple[Number, Number], needed: int, kind: Kind) -> list[Piece]:
    """The parts of the range in which at least `needed` of the pixels are inside.

    Examples
    --------
    >>> spans = Spans(np.array([7, 8]), np.array([0.0, 0.5]), np.array([1.0, 2.0]))
    >>> pieces(spans, (0.0, 2.0), needed=2, kind="upper")
    [Piece(low=0.5, high=1.0, below=End(kind='upper', pixel=8), above=End(kind='upper', pixel=7))]
    """
    first, last = (float(end) for end in within)
    throughout = (spans.low == first) & (spans.high == last)
    pixel, low, high = (column[~throughout] for column in spans)
    always, count = int(throughout.sum()), len(pixel)
    # The range's own ends come as events of no pixel, so that every piece begins and ends at an event.
    t = np.concatenate([[first], low, high, [last]])
    order_at_one_t = np.repeat([0, 1, 2, 3], [1, count, count, 1])
    who = np.concatenate([[-1], np.where(low == first, -1, pixel), np.where(high == last, -1, pixel), [-1]])
    change = np.repeat([always, 1, -1, -always], [1, count, count, 1])
    # Intervals are closed: at one t all beginnings come before all ends.
    order = np.lexsort((order_at_one_t, t))
    enough = np.cumsum(change[order]) >= needed
    enough[-1] = False
    before = np.append(False, enough[:-1])
    begin, end = order[enough & ~before], order[~enough & before]
    return [
        Piece(float(t[i]), float(t[j]), _end(kind, int(who[i])), _end(kind, int(who[j])))
        for i, j in zip(begin, end, strict=True)
    ]


def tightest(spans: Spans, kind: Kind) -> Piece:
    """The largest beginning and the least end of all, with low > high where they have no t in common."""
    low, high = int(spans.low.argmax()), int(spans.high.argmin())
    return Piece(
        float(spans.low[low]),
        float(spans.high[high]),
        End(kind, int(spans.pixel[low])),
        End(kind, int(spans.pixel[high])),
    )


def _end(kind: Kind, pixel: int) -> End:
    return End(kind, pixel) if pixel >= 0 else End("range")


def shared(one: list[Piece], other: list[Piece]) -> list[Piece]:
    """What two lists of pieces have in common; where both end together, the first says why.

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
