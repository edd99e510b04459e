"""Areas of regions of pairs, from the lengths of lines drawn through them, and the error between the lines."""

import numpy as np
from jaxtyping import Float

Lengths = Float[np.ndarray, " line"]
Ends = tuple[float, float]
THIN = 1e-5
"""Share of the range below which two lines stand on both sides of one place: a bend, a jump or an end."""


def lengths_within(intervals: tuple[tuple[Ends, ...], ...], allowed: tuple[Ends, ...]) -> Lengths:
    """The length of each line's intervals that lies in the `allowed` ones, which do not overlap.

    Examples
    --------
    >>> lengths_within((((0.0, 2.0), (3.0, 4.0)), ()), ((1.0, 3.5),)).tolist()
    [1.5, 0.0]
    """
    shared = [[min(b, d) - max(a, c) for a, b in line for c, d in allowed] for line in intervals]
    return np.array([sum(max(0.0, length) for length in line) for line in shared], dtype=float)


def between_lines(values: Lengths, lengths: Lengths) -> Float[np.ndarray, " gap"]:
    """The area that the trapezoids between neighbouring lines may miss, or have too much.

    Both neighbours of a gap are extended into it, and with the chord they make a triangle: for a convex region, whose
    lengths are concave, it holds whatever the chord cuts off.  In a region of another shape it is an estimate.

    Examples
    --------
    The edge bends somewhere between the second line and the third, and is straight on both sides:

    >>> values, lengths = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), np.array([1.5, 1.5, 1.5, 1.25, 0.75, 0.25])
    >>> between_lines(values, lengths)[1:-1].round(3).tolist()
    [0.0, 0.062, 0.0]
    """
    width, rise = np.diff(values), np.diff(lengths)
    wide = width > THIN * (values[-1] - values[0])

    # Of thin gaps, the jump in them; the slopes of what is on both their sides are compared across them.
    missed = np.where(wide, 0.0, np.abs(rise) * width / 2)
    slopes, h = rise[wide] / width[wide], width[wide]
    turns = np.concatenate([[np.nan], np.diff(slopes), [np.nan]])
    left, right = turns[:-1], turns[1:]

    # A triangle over the chord: both angles known, or one at the ends of the range; an edge that turns both ways is
    # held by the smaller turn.
    with np.errstate(invalid="ignore", divide="ignore"):
        held = np.where(left * right > 0, left * right / (left + right), np.fmin(np.abs(left), np.abs(right)))
    missed[wide] = np.where(np.isnan(held), np.inf, np.abs(held)) * h**2 / 2  # one gap alone says nothing
    return missed
