"""Bounds on what a formula errs by where one of its parameters stays free (step 2).

*Between nodes.*  A coefficient that is analytic in the parameter, and at most M in size, in the ellipse about the range
whose semi-axes sum to ρ times half its width, is interpolated at n + 1 Chebyshev nodes to ``4 M ρ^−n/(ρ − 1)`` [1]_;
the best of some ρ counts.  Boxes that cover the ellipse bound the size for all cosines; a pole within one has no bound.

*First order.*  ``f(θ) − f(θ₀) − f′(θ₀)(θ − θ₀)`` is at most ``½ max |f″| (θ − θ₀)²``, Lagrange's remainder; the second
derivative is SymPy's, bounded by boxes.

References
----------
.. [1] L. N. Trefethen, "Approximation Theory and Approximation Practice", SIAM, 2013, theorem 8.2.
"""

import itertools
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import sympy

from symrt.linear.enclosures import Box, enclosed, real
from symrt.reflection.symbols import ONE_MINUS, Factor, Parameter, with_lobes

Ranges = Mapping[str, tuple[float, float]]
RHOS = tuple(1.05 + 0.05 * 1.4**k for k in range(18))
ARCS, STOREYS = 32, 3
"""Boxes side by side, and on top of each other, that cover the upper half of an ellipse; the lower is its image."""
CUTS = {0: 1, 1: 32, 2: 12, 3: 6}
"""Into how many parts each cosine's [0, 1] is cut, by the number of cosines; 3 for more."""


@dataclass(frozen=True)
class Asked:
    """A parameter that shall stay free, and how: `around` is its value where first order is asked for."""

    name: str
    low: float
    high: float
    around: float | None = None


def interpolation_bound(
    coefficients: Iterable[sympy.Expr], key: str, ends: tuple[float, float], ranges: Ranges, *, log: bool
) -> Callable[[int], float]:
    """A function from a number of nodes to a bound on the error of each coefficient; infinite where none is known.

    Parameters
    ----------
    key
        The parameter that stays free.
    ends
        Of its range.
    ranges
        Of the other parameters, the same number twice where they have a value.
    log
        True for nodes in the logarithm of the parameter.

    Examples
    --------
    >>> from symrt.reflection.symbols import lobe, parameter, r_dot_v
    >>> power = lobe(r_dot_v, parameter("exponent"))
    >>> bound = interpolation_bound([power], "exponent", (5.0, 80.0), {}, log=True)
    >>> bound(12) < 1e-3, bound(24) < 1e-7
    (True, True)
    """
    held = [c for c in coefficients if Parameter(key) in c.free_symbols]
    sizes = [max((_on_ellipse(c, key, ends, ranges, rho, log=log) for c in held), default=0.0) for rho in RHOS]

    def bound(count: int) -> float:
        return min(4 * size * rho ** (1 - count) / (rho - 1) for size, rho in zip(sizes, RHOS, strict=True))

    return bound


def first_order_bound(
    coefficients: Iterable[sympy.Expr], key: str, around: float, ends: tuple[float, float], ranges: Ranges
) -> float:
    """A bound on what first order leaves out of each coefficient within a range; infinite where none is known.

    Examples
    --------
    >>> from symrt.reflection.symbols import parameter
    >>> round(first_order_bound([parameter("t") ** 2], "t", 2.0, (1.0, 3.5), {}), 9)
    2.25
    """
    theta = Parameter(key)
    edges = np.linspace(*ends, ARCS + 1)
    reach = max(ends[1] - around, around - ends[0])
    most = 0.0
    for coefficient in coefficients:
        if theta in coefficient.free_symbols:
            bend = sympy.diff(with_lobes(coefficient), theta, 2)
            most = max(most, _largest(bend, key, real(edges[:-1], edges[1:]), ranges))
    return most / 2 * reach**2


def _on_ellipse(
    coefficient: sympy.Expr, key: str, ends: tuple[float, float], ranges: Ranges, rho: float, *, log: bool
) -> float:
    """A bound on a coefficient's size in an ellipse about the parameter's range, or its logarithm's."""
    # Points of the ellipse, and boxes in storeys that cover its upper half.
    low, high = np.log(ends) if log else np.array(ends)
    angle = np.linspace(0, np.pi, ARCS + 1)
    across = (low + high) / 2 + (high - low) / 2 * (rho + 1 / rho) / 2 * np.cos(angle)
    up = (high - low) / 2 * (rho - 1 / rho) / 2 * np.sin(angle)
    top, storey = np.tile(np.maximum(up[1:], up[:-1]), STOREYS), np.repeat(np.arange(STOREYS), ARCS)
    cover = Box(
        np.tile(across[1:], STOREYS),
        np.tile(across[:-1], STOREYS),
        top * storey / STOREYS,
        top * (storey + 1) / STOREYS,
    )

    # Where nodes stand in the logarithm, the parameter itself.
    if log:
        stand_in = sympy.Dummy()
        cover = enclosed(sympy.exp(stand_in), {stand_in: cover}, cover.low.size)
    return _largest(coefficient, key, cover, ranges)


def _largest(expression: sympy.Expr, key: str, boxes: Box, ranges: Ranges) -> float:
    """A bound on an expression's size over boxes of one parameter, all cosines, and ranges of the other parameters."""
    # Each cosine, or what is left of 1, is cut into parts; the parts are combined with the boxes.
    cosines = sorted({f.name.removeprefix(ONE_MINUS) for f in expression.atoms(Factor)})
    cuts = CUTS.get(len(cosines), 3)
    parts = [*itertools.product(range(cuts), repeat=len(cosines))]
    size = boxes.low.size * len(parts)
    given: dict[sympy.Symbol, Box] = {Parameter(key): Box(*(np.tile(end, len(parts)) for end in boxes))}
    for place, name in enumerate(cosines):
        at = np.repeat([part[place] for part in parts], boxes.low.size)
        given[Factor(name)] = real(at / cuts, (at + 1) / cuts)
    for name, (low, high) in ranges.items():
        given.setdefault(Parameter(name), real(np.full(size, low), np.full(size, high)))
    found = enclosed(expression, given, size).largest
    return float(np.where(np.isnan(found), np.inf, found).max(initial=0.0))
