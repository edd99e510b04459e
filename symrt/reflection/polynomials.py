"""Split an expression into monomials of its reflectances: the binding-time division of step 2.

``f(static, dynamic) = Σ_k c_k(static) Π dynamic`` with static coefficients c_k that are never expanded: (1 − cosθ)^5
stays one power, because its expansion cancels.
"""

from collections.abc import Mapping
from functools import lru_cache

import sympy

from symrt.reflection.symbols import Light, Reflectance

Monomial = tuple[str, ...]
"""Names of the reflectances in a product, sorted, repeated as often as they occur."""


def monomials(expression: sympy.Expr) -> dict[Monomial, sympy.Expr]:
    """The coefficient of each product of reflectances, in the order of the monomials.

    Raises
    ------
    ValueError
        If the expression is not a polynomial in its reflectances, with the symbol and the part at fault.

    Examples
    --------
    >>> from symrt.reflection.symbols import diffuse, n_dot_l, specular
    >>> monomials((diffuse + specular) * n_dot_l)
    {('diffuse',): n_dot_l, ('specular',): n_dot_l}
    """
    return dict(_monomials(expression))


@lru_cache(maxsize=1024)
def _monomials(expression: sympy.Expr) -> tuple[tuple[Monomial, sympy.Expr], ...]:
    """The same as pairs, remembered: materials of one model have the same formulas."""
    return tuple((met, coefficient) for met, coefficient in sorted(_split(expression).items()) if coefficient != 0)


def _split(expression: sympy.Expr) -> dict[Monomial, sympy.Expr]:
    """The coefficients of an expression, by recursion over its tree; some may be zero."""
    # A part without reflectances is a coefficient, kept whole.
    dynamic = expression.atoms(Reflectance, Light)
    if not dynamic:
        return {(): expression}
    if isinstance(expression, Reflectance | Light):
        return {(expression.name,): sympy.Integer(1)}

    # Sums, products and whole powers of polynomials are polynomials; nothing else is taken apart.
    if expression.is_Add:
        return _sum([_split(term) for term in expression.args])
    if expression.is_Mul:
        return _product([_split(factor) for factor in expression.args])
    if expression.is_Pow and expression.exp.is_Integer and expression.exp > 0:
        return _product([_split(expression.base)] * int(expression.exp))
    names = ", ".join(sorted(symbol.name for symbol in dynamic))
    raise ValueError(
        f"{expression} is not a polynomial in {names}: a pixel must be linear in products of reflectances; make "
        f"{names} a parameter, or approximate this part by a polynomial"
    )


def _sum(parts: list[dict[Monomial, sympy.Expr]]) -> dict[Monomial, sympy.Expr]:
    total: dict[Monomial, list[sympy.Expr]] = {}
    for part in parts:
        for met, coefficient in part.items():
            total.setdefault(met, []).append(coefficient)
    return {met: sympy.Add(*coefficients) for met, coefficients in total.items()}


def _product(parts: list[dict[Monomial, sympy.Expr]]) -> dict[Monomial, sympy.Expr]:
    total: Mapping[Monomial, sympy.Expr] = {(): sympy.Integer(1)}
    for part in parts:
        total = _sum([{tuple(sorted(a + b)): c * d} for a, c in total.items() for b, d in part.items()])
    return dict(total)
