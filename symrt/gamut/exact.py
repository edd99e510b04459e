"""Clip one line to slabs in exact rationals: step 5 of the paper, where rounding leaves a clip undecided."""

from fractions import Fraction

import numpy as np
from jaxtyping import Float

PerSlab = Float[np.ndarray, " slab"]


def clip_exactly(lower: PerSlab, upper: PerSlab, q: PerSlab, d: PerSlab) -> tuple[float, float, bool]:
    """The floats inside one pixel's interval, and whether it is non-empty although it holds no float.

    Examples
    --------
    A third is no float: the end is the float below it.

    >>> low, high, uncertain = clip_exactly(np.zeros(1), np.ones(1), np.zeros(1), np.full(1, 3.0))
    >>> low, Fraction(high) < Fraction(1, 3), uncertain
    (0.0, True, False)
    """
    # Where the line enters and leaves each slab, as exact fractions.
    enter, leave = [], []
    for bound_low, bound_high, origin, direction in zip(
        lower.tolist(), upper.tolist(), q.tolist(), d.tolist(), strict=True
    ):
        if direction == 0:
            if not bound_low <= origin <= bound_high:
                return np.inf, -np.inf, False
            continue
        first, last = (bound_low, bound_high) if direction > 0 else (bound_high, bound_low)
        enter += [(Fraction(first) - Fraction(origin)) / Fraction(direction)] if np.isfinite(first) else []
        leave += [(Fraction(last) - Fraction(origin)) / Fraction(direction)] if np.isfinite(last) else []

    # Round the ends of the intersection inwards, to floats.
    if enter and leave and max(enter) > min(leave):
        return np.inf, -np.inf, False
    low = _float_towards(max(enter), np.inf) if enter else -np.inf
    high = _float_towards(min(leave), -np.inf) if leave else np.inf
    return low, high, low > high or low == np.inf or high == -np.inf


def _float_towards(value: Fraction, side: float) -> float:
    """The float nearest to `value` that is not on the other side of it."""
    try:
        nearest = float(value)
    except OverflowError:
        nearest = np.inf if value > 0 else -np.inf
    wrong_side = nearest < value if side > 0 else nearest > value
    return float(np.nextafter(nearest, side)) if wrong_side else nearest
