"""Bounds of a model's formulas by interval arithmetic, which bound the light that a trace cuts off (steps 1 and 2)."""

import functools
import math
import operator
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import sympy
from mpmath import iv

from symrt.reflection.polynomials import monomials
from symrt.reflection.symbols import Kind, Lobe, Parameter, Reflectance

Interval = Any
"""An mpmath interval."""

Known = tuple[tuple[str, tuple[float, float]], ...]
"""Ranges of parameters as the key of an answer that is remembered: materials of one model have the same bounds."""

LARGEST_POWER = 64
"""Largest integer power that is bounded; others may have any value."""
MOST_REFLECTANCES = 6
"""Reflectances of one formula that are set to 0 and to 1 in all combinations; more are bounded one by one."""


def largest(formula: sympy.Expr, ranges: Mapping[str, tuple[float, float]]) -> float:
    """An upper bound of |formula| over all reflectances and cosines in [0, 1], and parameters in their `ranges`.

    It is infinite where no bound is known.

    Examples
    --------
    >>> from symrt.reflection import MODELS
    >>> round(largest(MODELS["phong_plain"].direct, {"exponent": (60.0, 60.0)}) * 3.14159265, 6)
    2.0
    """
    return _largest(formula, tuple(sorted(ranges.items())))


@functools.lru_cache(maxsize=1024)
def _largest(formula: sympy.Expr, known: Known) -> float:
    ranges = dict(known)
    # Where a reflectance and what is left of 1 stand in one formula, no value of it makes both of them 1.
    return min(_size(_interval(formula, ranges)), max(_size(_interval(f, ranges)) for f in _extremes(formula)))


def may_subtract(formula: sympy.Expr, ranges: Mapping[str, tuple[float, float]]) -> bool:
    """True unless the number before each product of reflectances is known to be 0 or more.

    Examples
    --------
    >>> from symrt.reflection import MODELS
    >>> {name: may_subtract(MODELS[name].reflected, {}) for name in ("metal", "metal_f82")}
    {'metal': False, 'metal_f82': True}
    """
    return _may_subtract(formula, tuple(sorted(ranges.items())))


@functools.lru_cache(maxsize=1024)
def _may_subtract(formula: sympy.Expr, known: Known) -> bool:
    ranges = dict(known)
    return not all(_interval(coefficient, ranges).a >= 0 for coefficient in monomials(formula).values())


def _extremes(formula: sympy.Expr) -> Iterator[sympy.Expr]:
    """The formula with each reflectance 0 or 1: one that is affine in each of them is largest, and smallest, there."""
    reflectances = sorted(formula.atoms(Reflectance), key=str)
    affine = all(len(set(met)) == len(met) for met in monomials(formula))
    if not affine or len(reflectances) > MOST_REFLECTANCES:
        yield formula
        return
    for values in product((sympy.Integer(0), sympy.Integer(1)), repeat=len(reflectances)):
        yield formula.xreplace(dict(zip(reflectances, values, strict=True)))


def _size(bounds: Interval) -> float:
    found = max(-float(bounds.a), float(bounds.b))
    return math.inf if math.isnan(found) else found


def _interval(expression: sympy.Expr, ranges: Mapping[str, tuple[float, float]]) -> Interval:
    """An interval that holds all values of an expression, by recursion over its tree."""
    if expression.is_Atom:
        return _atom(expression, ranges)
    if isinstance(expression, Lobe):
        return iv.mpf([0, 1 if _interval(expression.args[1], ranges).a >= 0 else "inf"])
    parts = [_interval(part, ranges) for part in expression.args]
    if expression.is_Add:
        return functools.reduce(operator.add, parts)
    if expression.is_Mul:
        return functools.reduce(operator.mul, parts)
    if expression.is_Pow and expression.exp.is_Integer and abs(expression.exp) <= LARGEST_POWER:
        return parts[0] ** int(expression.exp)
    return iv.mpf(["-inf", "inf"])


def _atom(expression: sympy.Expr, ranges: Mapping[str, tuple[float, float]]) -> Interval:
    """An interval that holds a number or symbol; of numbers that no float is, such as π, the floats beside it."""
    if isinstance(expression, sympy.Rational):
        return iv.mpf(int(expression.p)) / iv.mpf(int(expression.q))
    if isinstance(expression, Parameter):
        return iv.mpf(list(ranges[expression.name]))
    if expression.is_Float:
        return iv.mpf(float(expression))
    if isinstance(expression, sympy.NumberSymbol):
        value = float(expression)
        return iv.mpf([math.nextafter(value, -math.inf), math.nextafter(value, math.inf)])
    return iv.mpf([0, 1]) if isinstance(expression, Kind) else iv.mpf(["-inf", "inf"])
