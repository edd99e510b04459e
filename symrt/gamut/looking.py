"""The parts of a curve inside a set that can only be asked point by point: step 5 of the paper for curved gamuts."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import PerPixel
from symrt.spectra.bands import Number

LOOKS = 64
"""Places on a curve at which it is asked whether it is inside; a shorter stretch may be missed."""
LOOK_HALVINGS = 26

Pixels = Int[np.ndarray, " _"]
Inside = Callable[[Pixels, PerPixel], Bool[np.ndarray, " _"]]


class Spans(NamedTuple):
    """Closed intervals of t, any number for each pixel, in the order of pixels and of t."""

    pixel: Int[np.ndarray, " span"]
    low: Float[np.ndarray, " span"]
    high: Float[np.ndarray, " span"]


def looked_for(inside: Inside, count: int, within: tuple[Number, Number], looks: int = LOOKS) -> Spans:
    """The parts of a range of t in which each pixel's curve is inside, as far as looking at some places tells.

    Parameters
    ----------
    inside
        Says of pixels, by their numbers, and a t each whether they are inside there.
    count
        How many pixels there are.
    within
        The range of t.
    looks
        Places in it, at even distances, beside its beginning; a part that falls between two of them is missed.

    Examples
    --------
    >>> found = looked_for(lambda pixel, t: np.abs(t - 0.5) >= 0.25, 1, (0.0, 1.0))
    >>> found.pixel.tolist(), found.low.round(6).tolist(), found.high.round(6).tolist()
    ([0, 0], [0.0, 0.75], [0.25, 1.0])
    """
    if not -np.inf < within[0] <= within[1] < np.inf:
        raise ValueError(f"within = ({within[0]}, {within[1]}): give a finite range, the lower end first")

    # Look at even distances, and note the neighbours between which a curve enters or leaves.
    t = np.linspace(within[0], within[1], looks + 1)
    pixel = np.repeat(np.arange(count), len(t))
    seen = inside(pixel, np.tile(t, count)).reshape(count, len(t))
    row, after = np.nonzero(seen[:, 1:] != seen[:, :-1])
    inner = np.where(seen[row, after], t[after], t[after + 1])
    outer = np.where(seen[row, after], t[after + 1], t[after])

    # Halve the gaps between them, keeping one end inside.
    for _ in range(LOOK_HALVINGS if len(row) else 0):
        middle = (inner + outer) / 2
        kept = inside(row, middle)
        inner, outer = np.where(kept, middle, inner), np.where(kept, outer, middle)

    # Pair each place of entry with the next of leaving; the ends of the range count where they are inside.
    enters = ~seen[row, after]
    first, last = np.flatnonzero(seen[:, 0]), np.flatnonzero(seen[:, -1])
    low = np.concatenate([np.full(len(first), t[0]), inner[enters]])
    high = np.concatenate([inner[~enters], np.full(len(last), t[-1])])
    begin, end = np.concatenate([first, row[enters]]), np.concatenate([row[~enters], last])
    begins, ends = np.lexsort((low, begin)), np.lexsort((high, end))
    return Spans(begin[begins], low[begins], high[ends])
