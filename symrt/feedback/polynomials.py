"""Intervals on which polynomials stay between bounds, certified: step 5 of the paper for a degree above 1.

Two cases.  A *posynomial* Σ t^k q_k with q_k ≥ 0 rises and is convex for t ≥ 0, so that Newton's method started above a
root falls to it and never below.  It aims a few roundings inwards, and what it finds is evaluated once more.  Any other
polynomial in *Bernstein form* lies between its least and its largest coefficient [1]_: a piece of the range is inside
when all of them are, outside when all of them are beyond one bound, and is halved otherwise.

References
----------
.. [1] R. T. Farouki and V. T. Rajan, "On the numerical condition of polynomials in Bernstein form", Computer Aided
   Geometric Design 4, 1987, pp. 191-216.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float

from symrt.gamut.interface import ROUNDING
from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number

NEWTON_STEPS = 200
"""Newton's steps at most; from far above, each multiplies t by 1 − 1/D or less."""
RAISED = 1e-12
"""Share by which a root of a single term is raised, to be above whatever its rounding."""
HALVINGS = 36
"""Pieces of the range narrower than 2⁻³⁶ of it that are still undecided count as outside."""

Powers = Float[np.ndarray, "power pixel slab"]
Bounds = Float[np.ndarray, " slab"]
Values = Float[np.ndarray, " pixel"]
Slabs = Float[np.ndarray, "pixel slab"]


def highest(q: Powers, upper: Bounds, top: Number) -> Values:
    """The largest t in [0, top] at which Σ t^k q_k is within `upper` in every slab; -inf where not even 0 is.

    Every q_k must be ≥ 0.  The sum at the t returned is within the bound in exact arithmetic.

    Examples
    --------
    >>> highest(np.array([[[0.0]], [[0.5]], [[0.5]]]), np.array([1.0]), 3.0).round(12)
    array([1.])
    """
    error = _rounding(q)
    aim = upper * (1 - 2 * error)
    t = _newton(q, aim, _above(q, aim, top, np.min, np.inf), np.min, np.inf)
    # What was found before as the end, and is certain there, is found again.
    with np.errstate(over="ignore", invalid="ignore"):
        t = np.where((_value(q, np.full_like(t, top)) * (1 + error) <= upper).all(axis=1), float(top), t)
    sure = (_value(q, t) * (1 + error) <= upper).all(axis=1)
    return np.where(sure, t, np.where((q[0] <= upper).all(axis=1), 0.0, -np.inf))


def lowest(q: Powers, lower: Bounds, top: Number) -> Values:
    """The smallest t in [0, top] at which Σ t^k q_k is at least `lower` in every slab; inf where not even top is.

    Every q_k must be ≥ 0.  The sum at the t returned is at least the bound in exact arithmetic.

    Examples
    --------
    >>> lowest(np.array([[[0.0]], [[0.5]], [[0.5]]]), np.array([1.0]), 3.0).round(12)
    array([1.])
    """
    error = _rounding(q)
    aim = lower * (1 + 2 * error)
    t = _newton(q, aim, _above(q, aim, top, np.max, -np.inf), np.max, -np.inf)
    sure = (_value(q, t) * (1 - error) >= lower).all(axis=1)
    return np.where((q[0] >= lower).all(axis=1), 0.0, np.where(sure, t, np.inf))


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
    # Halving averages numbers, so that its error stays below that of this many roundings.
    slack = (2 * halvings * len(b) + 8) * ROUNDING * np.abs(b).max(initial=0)
    pieces = _between(_rested(b, lower, upper, 2 * slack), *within)
    pixel, start = np.arange(b.shape[1]), np.zeros(b.shape[1])
    found: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []
    for level in range(halvings + 1):
        least, largest = pieces.min(axis=0), pieces.max(axis=0)
        inside = ((least >= lower + slack) & (largest <= upper - slack)).all(axis=1)
        # Of what lies all within the slack of a bound, no part will ever be certain: it is not halved further.
        outside = ((least > upper - slack) | (largest < lower + slack)).any(axis=1)

        # Keep the pieces inside, and halve those that are open.
        width = 0.5**level
        found.append((pixel[inside], start[inside], start[inside] + width))
        open_ = ~(inside | outside)
        if not open_.any():
            break
        left, right = _halved(pieces[:, open_])
        pieces = np.concatenate([left, right], axis=1)
        pixel, start = np.tile(pixel[open_], 2), np.concatenate([start[open_], start[open_] + width / 2])
    return joined(found, within)


def _rested(b: Powers, lower: Bounds, upper: Bounds, room: float) -> Powers:
    """The coefficients, moved off the bounds by the slack where they do not change with t and are inside."""
    still = (b == b[0]).all(axis=0) & (lower <= b[0]) & (b[0] <= upper)
    return np.where(still, np.clip(b[0], lower + room, upper - room), b) if still.any() else b


def _above(q: Powers, aim: Slabs, top: Number, choose: Callable[..., Values], ignored: float) -> Values:
    """A start for Newton's method: no root is above, and none far below, as no single term passes the aim there.

    From `top` it might take more steps than it has, because each goes only a share of the way down.
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        room = np.maximum(aim - q[0], 0.0)
        alone = [np.where(part > 0, (room / part) ** (1 / k), np.inf) for k, part in enumerate(q[1:], start=1)]
    first = np.min(alone, axis=0) * (1 + RAISED)
    return np.minimum(choose(np.where(q[1:].any(axis=0), first, ignored), axis=1), float(top))


def _newton(q: Powers, aim: Slabs, start: Values, choose: Callable[..., Values], ignored: float) -> Values:
    """Newton's method in all slabs at once, downwards from the start: the first, or the last, of the roots.

    The tangent at t meets the aim at ``(aim − q_0 + Σ (k − 1) q_k t^k) / Σ k q_k t^(k−1)``; written so, nothing but
    aim − q_0 cancels.  A tangent to a convex function lies below it: no root is passed.
    """
    # Rows that no longer fall have arrived; the others take one more step.
    t = np.maximum(start, 0.0)
    active = np.arange(len(t))
    for _ in range(NEWTON_STEPS):
        slope, bend = _derivatives(q[:, active], t[active])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            met = np.where(slope > 0, (aim[active] - q[0, active] + bend) / slope, ignored)
        fallen = np.clip(choose(met, axis=1), 0.0, t[active])

        # A fall within rounding is none.
        moving = fallen < t[active] * (1 - 2 * ROUNDING)
        t[active] = fallen
        active = active[moving]
        if not active.size:
            break
    return t


def _value(q: Powers, t: Values) -> Slabs:
    value = q[-1]
    for coefficient in q[-2::-1]:
        value = value * t[:, None] + coefficient
    return value


def _derivatives(q: Powers, t: Values) -> tuple[Slabs, Slabs]:
    """Σ k q_k t^(k−1), and Σ (k − 1) q_k t^k."""
    slope, bend = q[1].copy(), np.zeros_like(q[1])
    power = np.ones((len(t), 1))
    for k in range(2, len(q)):
        power = power * t[:, None]
        term = q[k] * power
        slope += k * term
        bend += (k - 1) * term * t[:, None]
    return slope, bend


def _rounding(q: Powers) -> Slabs:
    """A bound on the relative error of the sum, (2 D + 2) u and as much again; none where t moves nothing."""
    return np.where(q[1:].any(axis=0), 4 * len(q) * ROUNDING, 0.0)


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


def joined(found: list[tuple[np.ndarray, np.ndarray, np.ndarray]], within: tuple[Number, Number]) -> Spans:
    """The pieces, with those that touch made one, brought from [0, 1] to the range."""
    pixel, start, end = (np.concatenate(column) for column in zip(*found, strict=True))
    order = np.lexsort((start, pixel))
    pixel, start, end = pixel[order], start[order], end[order]
    goes_on = (pixel[1:] == pixel[:-1]) & (start[1:] == end[:-1])
    first, last = np.append(True, ~goes_on)[: len(pixel)], np.append(~goes_on, True)[: len(pixel)]
    low, high = within
    return Spans(pixel[first], placed(start[first], low, high), placed(end[last], low, high))


def placed(share: Values, low: float, high: float) -> Values:
    """Places in the range from places in [0, 1]; the ends of the range stay as they are to the last bit."""
    return np.where(share == 1, high, low + share * (high - low))
