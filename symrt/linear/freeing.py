"""Parameters that stay free: nodes, or first order, that make each linear, and a bound on the error (step 2)."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import sympy

from symrt.errors import shown
from symrt.linear.limits import Materials, parameter_of
from symrt.linear.remainders import Asked, first_order_bound, interpolation_bound
from symrt.nodes import FIRST_ORDER, Nodes
from symrt.reflection.nodes import choose_nodes
from symrt.reflection.polynomials import monomials
from symrt.reflection.symbols import Parameter

Range = tuple[float | int, float | int]
Free = Sequence[str] | Mapping[str, Range | str | tuple[str, float | int, float | int]]
"""Names of parameters, or for each name a range, ``"first order"``, or first order with a range."""
ERROR = 1e-6
"""Largest error of a free parameter, unless told otherwise."""
MOST = 64
"""Largest number of nodes that are tried."""
NEAR = 0.1
"""Of first order without a range: the share of its value by which a parameter moves at most."""


def freed(materials: Materials, free: Free, error: float | int | None = None) -> dict[str, Nodes]:
    """The nodes, or the first order, of each parameter that stays free.

    Raises
    ------
    ValueError
        If a range is impossible, the error cannot be kept, or no bound is known of a first order.

    Examples
    --------
    >>> from symrt.reflection import MODELS
    >>> from symrt.tracing.raytree import MaterialRecord
    >>> brass = {"brass": MaterialRecord(MODELS["phong"], {"exponent": 40.0})}
    >>> nodes = freed(brass, {"brass.exponent": (10, 160)}, 1e-4)["brass.exponent"]
    >>> nodes.count, nodes.error < 1e-4
    (18, True)
    >>> freed(brass, {"brass.exponent": "first order"})["brass.exponent"].around
    40.0
    """
    if error is not None and not 0 < error < np.inf:
        raise ValueError(f"error = {shown(error)}: it must be a number above 0, such as 1e-4")
    now = {parameter_of(n, key): v for n, record in materials.items() for key, v in record.parameters.items()}
    ways = free if isinstance(free, Mapping) else {name: (now[name] / 4, now[name] * 4) for name in free}
    asked = {name: _asked(name, how, now[name]) for name, how in ways.items()}
    return {name: _nodes(one, materials, asked, error) for name, one in asked.items()}


def _asked(name: str, how: object, value: float) -> Asked:
    """A way to stay free, as it was written, taken apart."""
    reach = abs(value) * NEAR
    match how:
        case str() if how == FIRST_ORDER and value != 0:
            return Asked(name, value - reach, value + reach, value)
        case (str(word), float() | int() as low, float() | int() as high) if word == FIRST_ORDER:
            if not low <= value <= high or not low < high:
                raise ValueError(f"{name}: first order is around its value, {value:g}, which [{low}, {high}] must hold")
            return Asked(name, float(low), float(high), value)
        case (float() | int() as low, float() | int() as high):
            return Asked(name, float(low), float(high))
    rule = "give a range, (low, high), 'first order', or ('first order', low, high)"
    raise ValueError(f"free = {{{name!r}: {shown(how)}}}: {rule}")


def _nodes(one: Asked, materials: Materials, asked: Mapping[str, Asked], error: float | int | None) -> Nodes:
    """The fewest nodes that keep an error, or first order if it does."""
    ends = one.low, one.high
    places = list(_coefficients(one, materials, asked))
    if one.around is not None:
        bounds = (first_order_bound([c], key, one.around, ends, ranges) for c, key, ranges in places)
        return _first_order(one, max(bounds, default=0.0), error)

    # The logarithm serves what is above 0; a range without an end, or of nothing, has no nodes.
    log = not one.low <= 0
    usual = choose_nodes(one.name, *ends) if (error is None and log) or not one.low < one.high < np.inf else None
    enlarged = _lebesgue(one, materials, asked)
    found = [interpolation_bound([c], key, ends, ranges, log=log) for c, key, ranges in places]

    def bound(count: int) -> float:
        return max((known(count) for known in found), default=0.0) * enlarged

    scale = "log" if log else "linear"
    if usual is not None:
        return Nodes(one.name, *ends, usual.count, "log", bound(usual.count))
    for count in range(2, MOST + 1):
        if bound(count) <= (ERROR if error is None else error):
            return Nodes(one.name, *ends, count, scale, bound(count))  # type: ignore[arg-type]  # one of the two
    why = f"more than {MOST} nodes" if bound(MOST) < np.inf else "a bound, and none is known of its formula"
    raise ValueError(f"{one.name} in [{one.low:g}, {one.high:g}] needs {why} for error = {error}; free a smaller range")


def _first_order(one: Asked, bound: float, error: float | int | None) -> Nodes:
    within = f"{one.name} in [{one.low:g}, {one.high:g}]"
    if not np.isfinite(bound):
        raise ValueError(
            f"{within}: no bound is known on what first order leaves out; free it between nodes, (low, high)"
        )
    if error is not None and bound > error:
        raise ValueError(
            f"{within}: first order errs by at most {bound:.2g}, and error = {error} is asked for; free a smaller "
            "range, ('first order', low, high), or between nodes, (low, high)"
        )
    return Nodes(one.name, one.low, one.high, 2, "first order", bound, one.around)


def _coefficients(
    one: Asked, materials: Materials, asked: Mapping[str, Asked]
) -> Iterator[tuple[sympy.Expr, str, dict[str, tuple[float, float]]]]:
    """The coefficients that depend on a parameter, with its name in the model and the ranges of all others."""
    for surface, record in materials.items():
        own = {key: asked.get(parameter_of(surface, key)) for key in record.parameters}
        ranges = {key: (v, v) if (w := own[key]) is None else (w.low, w.high) for key, v in record.parameters.items()}
        for key in (key for key, way in own.items() if way == one):
            others = {name: ends for name, ends in ranges.items() if name != key}
            for formula in record.model.formulas.values():
                for coefficient in monomials(formula).values():
                    if Parameter(key) in coefficient.free_symbols:
                        _check_alone(own, coefficient)
                        yield coefficient, key, others


def _check_alone(own: Mapping[str, Asked | None], coefficient: sympy.Expr) -> None:
    """Refuse first order of a coefficient in which another parameter is free, too: their errors multiply."""
    free = [way for key, way in own.items() if way is not None and Parameter(key) in coefficient.free_symbols]
    if len(free) > 1 and any(way.around is not None for way in free):
        names = " and ".join(way.name for way in free)
        raise ValueError(f"{names} are in one formula, where first order stands alone: free both between nodes, or one")


def _lebesgue(one: Asked, materials: Materials, asked: Mapping[str, Asked]) -> float:
    """The factor by which interpolation in other parameters of the same material may enlarge an error, at most."""
    places = [{parameter_of(surface, key) for key in record.parameters} for surface, record in materials.items()]
    others = max((len(names.intersection(asked)) - 1 for names in places if one.name in names), default=0)
    # Lebesgue's constant of Chebyshev's nodes: 1 + (2/π) ln n bounds it.
    return float((1 + 2 / np.pi * np.log(MOST)) ** others)
