"""Values of a pixel's terms for given spectra, in the order in which light meets its factors (steps 1 and 2)."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy

from symrt.linear.functions import function_of
from symrt.reflection.symbols import Hat, lobe_value


def evaluated(terms: Sequence[sympy.Expr], leaves: Mapping[sympy.Symbol, Any]) -> list[Any]:
    """The value of each term; products of powers are multiplied out, and only other terms compiled.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light
    >>> evaluated([3 * Light("sun") ** 2], {Light("sun"): 2.0})
    [12.0]
    """
    # Products of whole powers of known leaves.
    found: list[Any] = [None] * len(terms)
    others = []
    for k, term in enumerate(terms):
        if not term.is_commutative:
            found[k] = _passed(1.0, term, leaves)
            continue
        powers = term.as_powers_dict()
        if all((base in leaves or base.is_number) and power.is_Integer for base, power in powers.items()):
            product: Any = 1.0
            for base, power in powers.items():
                product = product * (leaves[base] if base in leaves else float(base)) ** int(power)
            found[k] = product
        else:
            others.append(k)

    # The other terms, compiled together.
    if others:
        compiled = function_of(leaves, [terms[k] for k in others], lobe_value)(*leaves.values())
        for k, value in zip(others, compiled, strict=True):
            found[k] = value
    return found


def _passed(light: Any, expression: sympy.Expr, leaves: Mapping[sympy.Symbol, Any]) -> Any:
    """The light that has passed an expression with ordered reflectances: each takes it in turn, a matrix as such."""
    if expression in leaves:
        factor = leaves[expression]
        return light @ factor if np.ndim(factor) == 2 else light * factor
    if expression.is_Add:
        return sum(_passed(light, part, leaves) for part in expression.args)
    if expression.is_commutative:
        return light * evaluated([expression], leaves)[0]

    # A product: numbers and lights first, then one factor after the other, and last a window, next to the eye.
    numbers, ordered = expression.args_cnc()
    windows = [number for number in numbers if isinstance(number, Hat)]
    light = light * evaluated([sympy.Mul(*(number for number in numbers if number not in windows))], leaves)[0]
    for base, power in (factor.as_base_exp() for factor in (*ordered, *windows)):
        if not power.is_Integer:  # of a transmittance, to the length of a way
            light = light * leaves[base] ** evaluated([power], leaves)[0]
            continue
        for _ in range(int(power)):
            light = _passed(light, base, leaves)
    return light
