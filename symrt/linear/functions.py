"""Expressions turned into functions, every float in them kept to its last bit (step 2)."""

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from typing import Any

import sympy

from symrt.reflection.symbols import log_lobe_values


def function_of(
    letters: Iterable[sympy.Symbol], expressions: Sequence[sympy.Expr], lobe: Callable[..., Any], *, cse: bool = False
) -> Callable[..., list[Any]]:
    """Compile expressions into one function, from the letters' values to the expressions' values.

    Materials of one model have the same function, which is compiled once a process.

    Parameters
    ----------
    lobe
        The function for powers of cosines: `lobe_values` for arrays, `lobe_value` for numbers.
    cse
        True to compute common subexpressions once.

    Examples
    --------
    >>> from symrt.reflection.symbols import Factor, lobe_value
    >>> function_of([Factor("n_dot_l")], [Factor("n_dot_l") * sympy.Float(1 / 3)], lobe_value)(2.0) == [2 / 3]
    True
    """
    return _compiled(tuple(letters), tuple(expressions), lobe, cse)


@lru_cache(maxsize=512)
def _compiled(
    letters: tuple[sympy.Symbol, ...], expressions: tuple[sympy.Expr, ...], lobe: Callable[..., Any], cse: bool
) -> Callable[..., list[Any]]:
    # lambdify writes a float as text, and 15 digits of it: a letter in its place keeps all 53 bits.  Dummies stand for
    # the letters too, so that no name of a symbol is ever executed.
    floats = sorted({number for expression in expressions for number in expression.atoms(sympy.Float)}, key=float)
    stand_in = {leaf: sympy.Dummy() for leaf in (*floats, *letters)}
    function = sympy.lambdify(
        list(stand_in.values()),
        [expression.xreplace(stand_in) for expression in expressions],
        modules=[{"Lobe": lobe, "LogLobe": log_lobe_values}, "numpy"],
        cse=cse,
    )
    return partial(function, *map(float, floats))
