"""Print a pixel's expression as text, LaTeX or Python (steps 1 and 2).

Full float64 stays inside and in Python code; digits are dropped in text and LaTeX only.
"""

import keyword
from collections.abc import Mapping, Sequence
from typing import Any

import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.pycode import PythonCodePrinter
from sympy.printing.str import StrPrinter

from symrt.reflection.symbols import Factor, Kind


class _Text(StrPrinter):
    def __init__(self, digits: int) -> None:
        super().__init__()
        self.digits = digits

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        return f"{float(expr):.{self.digits}g}"


class _Tex(LatexPrinter):
    def __init__(self, digits: int) -> None:
        super().__init__({"mul_symbol": r"\,"})
        self.digits = digits

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        mantissa, _, exponent = f"{float(expr):.{self.digits}g}".partition("e")
        return mantissa + (rf" \cdot 10^{{{int(exponent)}}}" if exponent else "")


class _Python(PythonCodePrinter):
    def __init__(self, names: Mapping[Kind, str]) -> None:
        super().__init__({"fully_qualified_modules": True})
        self.names = names

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        return repr(float(expr))

    def _print_Lobe(self, expr: sympy.Expr) -> str:  # noqa: N802 -- SymPy's name for it
        one_minus, exponent = (self.doprint(part) for part in expr.args)
        # Where the cosine is 0 its logarithm is not a number; 0.0**0 is 1, as it must be.
        return f"(math.exp({exponent}*math.log1p(-{one_minus})) if {one_minus} < 1 else 0.0**({exponent}))"

    def _print_Symbol(self, expr: sympy.Symbol) -> str:  # noqa: N802 -- SymPy's name for it
        return self.names[expr]

    # The symbols of every kind are printed by the names given, whatever their names are elsewhere.
    _print_Light = _print_Reflectance = _print_Factor = _print_Parameter = _print_Symbol  # noqa: N815 -- as above


def text(expression: sympy.Expr, digits: int = 4, terms: int | None = None) -> str:
    """Plain text.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, Reflectance
    >>> text(0.238512 * Light("sun") * Reflectance("sea.diffuse"))
    '0.2385*sun*sea.diffuse'
    """
    shown, left_out = _terms(_Text(digits), expression, terms)
    return shown + (f" + … ({left_out} more terms)" if left_out else "")


def tex(expression: sympy.Expr, digits: int = 4, terms: int | None = None) -> str:
    r"""LaTeX source.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, Reflectance
    >>> print(tex(0.25 * Light("sun") * Reflectance("sea.diffuse")))
    0.25\,\mathrm{sun}\,\mathrm{sea}_{\mathrm{diffuse}}
    """
    shown, left_out = _terms(_Tex(digits), expression, terms)
    return shown + (rf" + \dots\ (\text{{{left_out} more terms}})" if left_out else "")


def python_code(expression: sympy.Expr, spectra: Sequence[str], values: Mapping[str, float], name: str) -> str:
    """The source of a Python function of the spectra; the letters of the geometry become numbers beside it.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, n_dot_l
    >>> print(python_code(Light("sun") * n_dot_l, ["sun"], {"n_dot_l": 0.5}, "pixel"))
    import math
    <BLANKLINE>
    n_dot_l = 0.5
    <BLANKLINE>
    <BLANKLINE>
    def pixel(sun):
        return sun*n_dot_l
    """
    if not name.isidentifier() or keyword.iskeyword(name):
        raise ValueError(f"{name!r} cannot be a function's name; give a Python identifier, such as 'pixel'")
    names = _identifiers(expression, taken={name, "math"})
    printer = _Python(names)
    letters = [f"{names[Factor(letter)]} = {float(v)!r}" for letter, v in values.items() if Factor(letter) in names]
    arguments = ", ".join(names[s] for s in _in_order(expression, spectra))
    head = "\n".join(["import math", *([""] if letters else []), *letters])
    return f"{head}\n\n\ndef {name}({arguments}):\n    return {_terms(printer, expression)[0]}"


def _terms(printer: Any, expression: sympy.Expr, most: int | None = None) -> tuple[str, int]:
    """The first terms of a sum, ordered by their symbols' names, and how many were left out.

    SymPy's own order of terms takes seconds for thousands of symbols.
    """
    if most is not None and most < 1:
        raise ValueError(f"terms = {most}: at least one term is shown")
    ordered = sorted(sympy.Add.make_args(expression), key=_order)
    shown = " + ".join(printer.doprint(term) for term in ordered[:most])
    return shown.replace(" + -", " - "), len(ordered) - len(ordered[:most])


def _order(term: sympy.Expr) -> list[tuple[Any, str, str]]:
    powers = term.as_powers_dict().items()
    return sorted((base.class_key(), base.name, str(power)) for base, power in powers if isinstance(base, Kind))


def _in_order(expression: sympy.Expr, spectra: Sequence[str]) -> list[Any]:
    rank = {name: k for k, name in enumerate(spectra)}
    free = [s for s in expression.free_symbols if not isinstance(s, Factor)]
    return sorted(free, key=lambda s: (rank.get(s.name, len(rank)), s.class_key(), s.name))


def _identifiers(expression: sympy.Expr, taken: set[str]) -> dict[Kind, str]:
    """A Python identifier for each symbol; no two symbols share one."""
    names: dict[Kind, str] = {}
    for symbol in sorted(expression.free_symbols, key=lambda s: (s.class_key(), s.name)):
        name = "".join(c if c.isalnum() and c.isascii() else "_" for c in symbol.name)
        while name in taken or keyword.iskeyword(name) or not name.isidentifier():
            name += "_" if name else "x"
        taken.add(name)
        names[symbol] = name
    return names
