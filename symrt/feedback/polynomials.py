"""Where polynomials stay between bounds, certified: step 5 of the paper for a degree above 1.

Two cases.  A *posynomial* Σ t^k q_k with q_k ≥ 0 rises and is convex for t ≥ 0, so that Newton's method started above a
root falls to it and never below; the last bits are settled by evaluating with a bound on the rounding.  Any other
polynomial in *Bernstein form* lies between its least and its largest coefficient [1]_: a piece of the range is inside
when all of them are, outside when all of them are beyond one bound, and is halved otherwise.

References
----------
.. [1] R. T. Farouki and V. T. Rajan, "On the numerical condition of polynomials in Bernstein form", Computer Aided
   Geometric Design 4, 1987, pp. 191-216.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.spectra.bands import Number

__all__ = ["Spans", "highest", "lowest", "spans_inside"]

ROUNDING = 2.0**-53
MOST_STEPS = 200
"""Newton's steps at most; from far above, each at least halves the distance to a root of multiplicity one."""
HALVINGS = 36
"""Pieces of the range narrower than 2⁻³⁶ of it that are still undecided count as outside."""

Powers = Float[np.ndarray, "power pixel slab"]
Bounds = Float[np.ndarray, " slab"]
Values = Float[np.ndarray, " pixel"]


class Spans(NamedTuple):
    """Closed intervals of t, any number for each pixel, in the order of pixels and of t."""

    pixel: Int[np.ndarray, " span"]
    low: Float[np.ndarray, " span"]
    high: Float[np.ndarray, " span"]


def highest(q: Powers, upper: Bounds, top: Number) -> Values:
    """The largest t in [0, top] at which Σ t^k q_k is within `upper` in every slab; -inf where not even 0 is.

    Every q_k must be ≥ 0.  The sum at the t returned is within the bound in exact arithmetic.

    Examples
    --------
    >>> highest(np.array([[[0.0]], [[0.5]], [[0.5]]]), np.array([1.0]), 3.0).round(12)
    array([1.])
    """
    t = np.full(q.shape[1], float(top))
    active = np.arange(len(t))
    for _ in range(MOST_STEPS):
        value, slope = _horner(q[:, active], t[active])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            steps = np.where(value > upper, (value - upper) / slope, 0.0).max(axis=1)
        fallen = np.maximum(t[active] - steps, 0.0)
        moving = fallen < t[active] * (1 - 2 * ROUNDING)
        t[active] = fallen
        active = active[moving]
        if not active.size:
            break
    return _settled(q, upper, t, -1, top)


def lowest(q: Powers, lower: Bounds, top: Number) -> Values:
    """The smallest t in [0, top] at which Σ t^k q_k is at least `lower` in every slab; inf where not even top is.

    Every q_k must be ≥ 0.  The sum at the t returned is at least the bound in exact arithmetic.

    Examples
    --------
    >>> lowest(np.array([[[0.0]], [[0.5]], [[0.5]]]), np.array([1.0]), 3.0).round(12)
    array([1.])
    """
    t = np.full(q.shape[1], float(top))
    active = np.flatnonzero(np.all(_horner(q, t)[0] >= lower, axis=1))
    for _ in range(MOST_STEPS):
        value, slope = _horner(q[:, active], t[active])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            # A slab that holds everywhere asks for no step, one that t does not move allows any.
            steps = np.where(slope > 0, (value - lower) / slope, np.inf).min(axis=1)
        fallen = np.clip(t[active] - np.maximum(steps, 0.0), 0.0, None)
        moving = fallen < t[active] * (1 - 2 * ROUNDING)
        t[active] = fallen
        active = active[moving]
        if not active.size:
            break
    return _settled(q, lower, t, 1, top)


def spans_inside(
    b: Powers, lower: Bounds, upper: Bounds, within: tuple[Number, Number], halvings: int = HALVINGS
) -> Spans:
    """The parts of `within`, in [0, 1], where Σ C(D, k) (1 − t)^(D−k) t^k b_k is between the bounds in every slab.

    Examples
    --------
    A band that dips below 0.3 in the middle:

    >>> spans = spans_inside(np.array([[[0.5]], [[0.0]], [[0.5]]]), np.array([0.3]), np.array([1.0]), (0.0, 1.0))
    >>> spans.pixel.tolist(), spans.low.round(6).tolist(), spans.high.round(6).tolist()
    ([0, 0], [0.0, 0.723607], [0.276393, 1.0])
    """
    pieces = _between(b, *within)
    pixel, start = np.arange(b.shape[1]), np.zeros(b.shape[1])
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    # Halving averages non-negative numbers, so that its error stays below that of this many roundings.
    slack = (2 * halvings * len(b) + 8) * ROUNDING * np.abs(b).max(initial=0)
    for level in range(halvings + 1):
        least, largest = pieces.min(axis=0), pieces.max(axis=0)
        inside = ((least >= lower + slack) & (largest <= upper - slack)).all(axis=1)
        outside = ((least > upper) | (largest < lower)).any(axis=1)
        width = 0.5**level
        found.append((pixel[inside], start[inside], start[inside] + width))
        open_ = ~(inside | outside)
        if not open_.any():
            break
        left, right = _halved(pieces[:, open_])
        pieces = np.concatenate([left, right], axis=1)
        pixel, start = np.tile(pixel[open_], 2), np.concatenate([start[open_], start[open_] + width / 2])
    return _joined(found, within)


def _horner(q: Powers, t: Values) -> tuple[Float[np.ndarray, "pixel slab"], Float[np.ndarray, "pixel slab"]]:
    """Value and slope of Σ t^k q_k."""
    value, slope = q[-1], np.zeros_like(q[-1])
    for coefficient in q[-2::-1]:
        slope = slope * t[:, None] + value
        value = value * t[:, None] + coefficient
    return value, slope


def _settled(q: Powers, bound: Bounds, t: Values, side: int, top: Number) -> Values:
    """Move t down (side -1) or up (1), by twice as much each time, until the rounded sum is surely within the bound."""
    t, step = t.copy(), 4 * ROUNDING
    unsure = np.flatnonzero(~_surely(q, bound, t, side))
    while unsure.size and step < 1:
        moved = t[unsure] * (1 + side * step) + (top * step if side > 0 else 0.0)
        t[unsure] = np.minimum(moved, top)
        unsure = unsure[~_surely(q[:, unsure], bound, t[unsure], side)]
        step *= 2
    # At the very end of the range, and at 0 with the bound met exactly, there is no room to move.
    t[unsure] = 0.0 if side < 0 else top
    t[unsure[~_surely(q[:, unsure], bound, t[unsure], side)]] = side * np.inf
    return t


def _surely(q: Powers, bound: Bounds, t: Values, side: int) -> Bool[np.ndarray, " pixel"]:
    """Whether the sum is within the bound whatever its rounding, at most a factor 1 ± (2 D + 2) u."""
    error = np.where(t == 0, 0.0, 4 * len(q) * ROUNDING)[:, None]
    value = _horner(q, t)[0] * (1 - side * error)
    return np.all(value <= bound if side < 0 else value >= bound, axis=1)


def _halved(b: Powers) -> tuple[Powers, Powers]:
    return _split(b, 0.5)


def _split(b: Powers, t: float) -> tuple[Powers, Powers]:
    """Bernstein coefficients of the parts before and after t, by de Casteljau's averages."""
    left, right = [b[0]], [b[-1]]
    while len(b) > 1:
        b = b[:-1] * (1 - t) + b[1:] * t
        left.append(b[0])
        right.append(b[-1])
    return np.stack(left), np.stack(right[::-1])


def _between(b: Powers, low: float, high: float) -> Powers:
    before = _split(b, high)[0] if high < 1 else b
    return _split(before, low / high)[1] if low > 0 else before


def _joined(found: list[tuple[np.ndarray, np.ndarray, np.ndarray]], within: tuple[Number, Number]) -> Spans:
    """Pieces that touch, made one, and brought from [0, 1] to the range."""
    pixel, start, end = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.lexsort((start, pixel))
    pixel, start, end = pixel[order], start[order], end[order]
    goes_on = (pixel[1:] == pixel[:-1]) & (start[1:] == end[:-1])
    first, last = np.append(True, ~goes_on)[: len(pixel)], np.append(~goes_on, True)[: len(pixel)]
    low, high = within
    return Spans(pixel[first], _at(start[first], low, high), _at(end[last], low, high))


def _at(share: Values, low: float, high: float) -> Values:
    """Ends of the range stay what they are to the last bit."""
    return np.where(share == 1, high, low + share * (high - low))
