"""Boxes of complex numbers that hold all values of an expression, many boxes at a time (step 2).

Interval arithmetic [1]_ on real and imaginary parts; every operation widens its result by a few roundings.  Where no
bound is known, as of a logarithm around 0, a box is the whole plane.

References
----------
.. [1] R. E. Moore, R. B. Kearfott and M. J. Cloud, "Introduction to Interval Analysis", SIAM, 2009.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import sympy
from jaxtyping import Float

from symrt.reflection.symbols import ONE_MINUS, Factor, Lobe, LogLobe

Ends = Float[np.ndarray, " box"]
WIDER = 16 * np.finfo(float).eps


class Box(NamedTuple):
    """Many boxes: the ends of their real and of their imaginary parts."""

    low: Ends
    high: Ends
    below: Ends
    above: Ends

    @property
    def largest(self) -> Ends:
        """The largest size of a number in each box."""
        with np.errstate(over="ignore"):
            return np.hypot(np.maximum(np.abs(self.low), np.abs(self.high)), np.maximum(-self.below, self.above))


def real(low: Ends, high: Ends) -> Box:
    """Boxes of real numbers."""
    nothing = np.zeros_like(low)
    return Box(low, high, nothing, nothing)


def enclosed(expression: sympy.Expr, boxes: Mapping[sympy.Symbol, Box], size: int) -> Box:
    """Boxes that hold all values of an expression whose symbols are in the given boxes.

    Examples
    --------
    >>> x = sympy.Symbol("x")
    >>> box = enclosed(x**2 - x, {x: real(np.array([0.0, 0.5]), np.array([0.5, 1.0]))}, 2)
    >>> box.low.round(12).tolist(), box.high.round(12).tolist()
    ([-0.5, -0.75], [0.25, 0.5])
    """
    with np.errstate(all="ignore"):
        return _enclosed(expression, boxes, size)


def _enclosed(expression: sympy.Expr, boxes: Mapping[sympy.Symbol, Box], size: int) -> Box:
    leaf = _leaf(expression, boxes, size)
    if leaf is not None:
        return leaf

    # An operation on the boxes of its parts; others by exponentials, where SymPy knows how.
    operation = OPERATIONS.get(type(expression))
    if operation is not None:
        return operation(expression, [_enclosed(part, boxes, size) for part in expression.args])
    rewritten = expression.rewrite(sympy.exp)
    return _enclosed(rewritten, boxes, size) if rewritten != expression else _anything(size)


def _leaf(expression: sympy.Expr, boxes: Mapping[sympy.Symbol, Box], size: int) -> Box | None:
    """The boxes of a symbol or a number; None of anything else."""
    if expression in boxes:
        return boxes[expression]
    if isinstance(expression, Factor) and expression.name.startswith(ONE_MINUS):
        return _left_of_1(boxes[Factor(expression.name.removeprefix(ONE_MINUS))])
    if expression.is_number and expression.is_real:
        return _number(float(expression), size)
    return None


def _number(value: float, size: int) -> Box:
    # A number such as π, or a fraction, is between the floats beside it.
    exact = float(value).is_integer()
    return real(*(np.full(size, value if exact else np.nextafter(value, end)) for end in (-np.inf, np.inf)))


def _anything(size: int) -> Box:
    low, high = np.full(size, -np.inf), np.full(size, np.inf)
    return Box(low, high, low, high)


def _wider(low: Ends, high: Ends) -> tuple[Ends, Ends]:
    """Ends moved outwards by some roundings; those that are not known are infinite."""
    low, high = np.where(np.isnan(low), -np.inf, low), np.where(np.isnan(high), np.inf, high)
    return low - WIDER * np.abs(low), high + WIDER * np.abs(high)


def _added(parts: list[Box]) -> Box:
    ends = [sum((part[k] for part in parts[1:]), parts[0][k]) for k in range(4)]
    # A sum of nearly opposite numbers is wrong by roundings of its largest part.
    size = WIDER * sum((np.maximum(np.abs(p.low), np.abs(p.high)) for p in parts[1:]), np.abs(parts[0].largest))
    size = np.where(np.isfinite(size), size, 0.0)
    low, high = _wider(ends[0] - size, ends[1] + size)
    if not any(p.below.any() or p.above.any() for p in parts):
        return real(low, high)
    below, above = _wider(ends[2] - size, ends[3] + size)
    return Box(low, high, below, above)


def _left_of_1(share: Box) -> Box:
    """1 less shares in [0, 1]: no rounding takes it out of [0, 1]."""
    return real(1 - np.clip(share.high, 0.0, 1.0), 1 - np.clip(share.low, 0.0, 1.0))


def _negative(box: Box) -> Box:
    return Box(-box.high, -box.low, -box.above, -box.below)


def _times(a: tuple[Ends, Ends], b: tuple[Ends, Ends]) -> tuple[Ends, Ends]:
    """The interval of products of two intervals; 0 times anything is 0."""
    products = np.stack([x * y for x in a for y in b])
    products = np.where(np.isnan(products), 0.0, products)
    return products.min(axis=0), products.max(axis=0)


def _product(a: Box, b: Box) -> Box:
    low, high = _times(a[:2], b[:2])
    if not (a.below.any() or a.above.any() or b.below.any() or b.above.any()):
        return real(*_wider(low, high))
    across, up, down = _times(a[2:], b[2:]), _times(a[:2], b[2:]), _times(a[2:], b[:2])
    first = _wider(low, high)
    second = _wider(-across[1], -across[0])
    ends = _wider(first[0] + second[0], first[1] + second[1])
    return Box(*ends, *_wider(up[0] + down[0], up[1] + down[1]))


def _power(base: Box, exponent: int) -> Box:
    if exponent < 0:
        return _power(_inverse(base), -exponent)
    if not (base.below.any() or base.above.any()):
        ends = np.stack([base.low**exponent, base.high**exponent])
        low = np.where((exponent % 2 == 0) & (base.low < 0) & (base.high > 0), 0.0, ends.min(axis=0))
        return real(*_wider(low, ends.max(axis=0)))
    result = _number(1.0, base.low.size)
    for _ in range(exponent):
        result = _product(result, base)
    return result


def _inverse(box: Box) -> Box:
    """1/z = z̄/|z|², unknown where a box touches 0."""
    least = np.where((box.low <= 0) & (box.high >= 0), 0.0, np.minimum(np.abs(box.low), np.abs(box.high)))
    least_up = np.where((box.below <= 0) & (box.above >= 0), 0.0, np.minimum(np.abs(box.below), np.abs(box.above)))
    if not (box.below.any() or box.above.any()):
        around = least == 0
        low, high = _wider(1 / box.high, 1 / box.low)
        return real(np.where(around, -np.inf, low), np.where(around, np.inf, high))
    square = least**2 + least_up**2, box.largest**2
    over = _wider(1 / square[1], np.where(square[0] > 0, 1 / square[0], np.inf))
    opposite = Box(box.low, box.high, -box.above, -box.below)
    return _product(opposite, real(*over))


def _exponential(box: Box) -> Box:
    low, high = _wider(np.exp(box.low), np.exp(box.high))
    size = np.maximum(low, 0.0), high
    if not (box.below.any() or box.above.any()):
        return real(*size)
    parts = (_cosines(box.below, box.above), _cosines(box.below - np.pi / 2, box.above - np.pi / 2))
    (low, high), (below, above) = (_wider(*_times(size, part)) for part in parts)
    return Box(low, high, below, above)


def _logarithm(box: Box) -> Box:
    """The principal logarithm of boxes in the right half of the plane; unknown elsewhere."""
    least_up = np.where((box.below <= 0) & (box.above >= 0), 0.0, np.minimum(np.abs(box.below), np.abs(box.above)))
    low, high = _wider(np.log(np.hypot(np.maximum(box.low, 0.0), least_up)), np.log(box.largest))
    unknown = box.low < 0
    low, high = np.where(unknown, -np.inf, low), np.where(unknown, np.inf, high)
    if not (box.below.any() or box.above.any()):
        return real(low, high)
    corners = np.stack([np.arctan2(y, x) for x in (box.low, box.high) for y in (box.below, box.above)])
    below, above = _wider(corners.min(axis=0), corners.max(axis=0))
    return Box(low, high, np.where(unknown, -np.inf, below), np.where(unknown, np.inf, above))


def _cosines(low: Ends, high: Ends) -> tuple[Ends, Ends]:
    """The interval of cosines of an interval of angles."""
    ends = np.stack([np.cos(low), np.cos(high)])
    turn = 2 * np.pi
    known = np.isfinite(low) & np.isfinite(high)
    # A few roundings more, so that a peak at an end is not missed.
    low, high = low - 1e-9, high + 1e-9
    peak = np.floor(high / turn) >= np.ceil(low / turn)
    trough = np.floor((high - np.pi) / turn) >= np.ceil((low - np.pi) / turn)
    return np.where(known & ~trough, ends.min(axis=0), -1.0), np.where(known & ~peak, ends.max(axis=0), 1.0)


def _cosine(box: Box, shift: float) -> Box:
    """cos(a + ib) = cos a cosh b − i sin a sinh b, of boxes shifted back."""
    cosines = _wider(*_cosines(box.low - shift, box.high - shift))
    if not (box.below.any() or box.above.any()):
        return real(*cosines)
    sines = _wider(*_cosines(box.low - shift - np.pi / 2, box.high - shift - np.pi / 2))
    most = np.maximum(np.abs(box.below), np.abs(box.above))
    low, high = _wider(*_times(cosines, (np.ones_like(most), np.cosh(most))))
    below, above = _wider(*_times(sines, _wider(-np.sinh(box.above), -np.sinh(box.below))))
    return Box(low, high, below, above)


def _log_lobe(cosine: Box, exponent: Box, times: int) -> Box:
    """``x^s (ln x)^k`` of real x in [0, 1]: at most ``(k/(e s))^k`` in size, where x is ``e^(−k/s)``."""
    x = np.clip(cosine.low, 0.0, 1.0), np.clip(cosine.high, 0.0, 1.0)
    s = exponent.low
    peak = np.exp(-times / s)
    sizes = [np.where(end > 0, end**s * np.abs(np.log(np.where(end > 0, end, 1.0))) ** times, 0.0) for end in x]
    most = np.maximum(*sizes)
    most = np.where((x[0] <= peak) & (peak <= x[1]), np.maximum(most, (times / (np.e * s)) ** times), most)
    known = (s > 0) & (exponent.below == 0) & (exponent.above == 0)
    most = np.where(known, most, np.inf)
    nothing = np.zeros_like(most)
    return real(*_wider(*((-most, nothing) if times % 2 else (nothing, most))))


def _raised(expression: sympy.Expr, parts: list[Box]) -> Box:
    if expression.exp.is_Integer:
        return _power(parts[0], int(expression.exp))
    return _exponential(_product(parts[1], _logarithm(parts[0])))


OPERATIONS: Mapping[type, Callable[[Any, list[Box]], Box]] = {
    sympy.Add: lambda _, parts: _added(parts),
    sympy.Mul: lambda _, parts: functools.reduce(_product, parts),
    sympy.Pow: _raised,
    sympy.exp: lambda _, parts: _exponential(parts[0]),
    sympy.log: lambda _, parts: _logarithm(parts[0]),
    sympy.cos: lambda _, parts: _cosine(parts[0], 0.0),
    sympy.sin: lambda _, parts: _cosine(parts[0], np.pi / 2),
    Lobe: lambda _, parts: _exponential(_product(parts[1], _logarithm(_left_of_1(parts[0])))),
    LogLobe: lambda power, parts: _log_lobe(_left_of_1(parts[0]), parts[1], int(power.args[2])),
}
"""The boxes of each operation, from those of its parts."""
