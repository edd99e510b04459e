"""Print a pixel's expression as text, LaTeX or Python (steps 1 and 2).

Full float64 stays inside and in Python code; digits are dropped in text and LaTeX only.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

from symrt.reflection.symbols import Kind, Lobe, Ordered, Reflectance, lobe_value

NEGLIGIBLE = 1e-9
"""Share of the pixel below which terms are counted and not shown."""

LetterValues = Mapping[str, float]


class _Sized:
    """The common part of the text and LaTeX printers: digits are dropped, and the largest terms come first."""

    joint = "*"
    """The sign between factors."""

    def __init__(self, digits: int, values: LetterValues, settings: Mapping[str, Any] | None = None) -> None:
        super().__init__(settings)  # type: ignore[call-arg]  # of the printer beside it
        self.digits, self.values = digits, values

    def _as_ordered_terms(self, expr: sympy.Expr, order: object = None) -> list[sympy.Expr]:  # noqa: ARG002
        return largest_first(sympy.Add.make_args(expr), self.values)[0]

    def number(self, value: sympy.Float) -> str:
        """A float with digits dropped."""
        return f"{float(value):.{self.digits}g}"

    def without_ones(self, term: sympy.Expr) -> sympy.Expr:
        """The term without factors that would be printed as 1."""
        ones = {"1": sympy.Integer(1), "-1": sympy.Integer(-1)}
        return term.xreplace({f: ones[self.number(f)] for f in term.atoms(sympy.Float) if self.number(f) in ones})

    def doprint(self, expr: sympy.Expr) -> str:
        """The text of an expression, each product of ordered reflectances standing together."""
        return str(super().doprint(self._chained(expr)))  # type: ignore[misc]  # of the printer beside it

    def _chained(self, expr: sympy.Expr) -> sympy.Expr:
        """The expression with one symbol in place of each product of ordered reflectances, for printing."""
        if expr.is_commutative:
            return expr
        if expr.is_Add:
            return sympy.Add(*map(self._chained, expr.args))
        numbers, ordered = expr.args_cnc()
        reflectances = [factor for factor in ordered if isinstance(factor.as_base_exp()[0], Ordered)]
        sums = ordered[: len(ordered) - len(reflectances)]
        # A sum, the radiance that a ray brings, stands before what the ray meets next; all else is left as it is.
        if sums + reflectances != ordered or len(sums) > 1:
            return expr
        name = self.joint.join(map(self._print, reflectances))  # type: ignore[attr-defined]  # of the printer beside it
        chain = [(Last if sums else Chain)(name)] if reflectances else []
        return sympy.Mul(*map(self._chained, (*numbers, *sums)), *chain)


class Chain(Reflectance):
    """A product of reflectances as it is printed, in one piece."""

    def _latex(self, _printer: Any) -> str:
        return self.name


class Last(Ordered):
    """A product of reflectances as it is printed, behind the sum that it multiplies."""

    def _latex(self, _printer: Any) -> str:
        return self.name


class _Text(_Sized, StrPrinter):
    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        return self.number(expr)


class _Tex(_Sized, LatexPrinter):
    joint = r"\,"

    def __init__(self, digits: int, values: LetterValues) -> None:
        super().__init__(digits, values, {"mul_symbol": self.joint})

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        mantissa, _, exponent = self.number(expr).partition("e")
        return mantissa + (rf" \cdot 10^{{{int(exponent)}}}" if exponent else "")


def text(expression: sympy.Expr, digits: int = 4, terms: int | None = None, values: LetterValues | None = None) -> str:
    """Print an expression as plain text.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, Reflectance
    >>> text(0.238512 * Light("sun") * Reflectance("sea.diffuse"))
    '0.2385*sun*sea.diffuse'
    """
    printer = _Text(digits, values or {})
    shown, left_out = _shown(expression, terms, printer.values)
    return _sum(printer, shown) + (f" + … ({left_out})" if left_out else "")


def tex(expression: sympy.Expr, digits: int = 4, terms: int | None = None, values: LetterValues | None = None) -> str:
    r"""Print an expression as LaTeX source.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, Reflectance
    >>> print(tex(0.25 * Light("sun") * Reflectance("sea.diffuse")))
    0.25\,\mathrm{sun}\,\mathrm{sea}_{\mathrm{diffuse}}
    """
    printer = _Tex(digits, values or {})
    shown, left_out = _shown(expression, terms, printer.values)
    return _sum(printer, shown) + (rf" + \dots\ (\text{{{left_out}}})" if left_out else "")


def _sum(printer: Any, terms: Sequence[sympy.Expr]) -> str:
    return joined([printer.doprint(printer.without_ones(term)) for term in terms])


def joined(terms: Sequence[str]) -> str:
    """Printed terms as a sum, one that begins with a minus as a difference.

    Examples
    --------
    >>> joined(["2*sun", "-0.5*sky"])
    '2*sun - 0.5*sky'
    """
    return " + ".join(terms).replace(" + -", " - ")


def _shown(expression: sympy.Expr, most: int | None, values: LetterValues) -> tuple[list[sympy.Expr], str]:
    """The terms of a sum that are shown, largest first, and words for the others; no words if there are none."""
    if most is not None and most < 1:
        raise ValueError(f"terms = {most}: at least one term is shown")

    # Terms that are not negligible, and of these as many as are asked for.
    ordered, sizes = largest_first(sympy.Add.make_args(expression), values)
    least = NEGLIGIBLE * sum(sizes)
    some = sum(size >= least for size in sizes)
    shown = ordered[: min(some, most or some)]

    # The others are counted; only where all that matter are shown can they be called small.
    left_out = len(ordered) - len(shown)
    if not left_out:
        return shown, ""
    terms = f"{left_out} {'more ' if len(shown) < some else ''}term{'s' if left_out > 1 else ''}"
    return shown, terms if len(shown) < some else f"{terms} below {NEGLIGIBLE:g} of the pixel"


def largest_first(terms: Sequence[sympy.Expr], values: LetterValues) -> tuple[list[sympy.Expr], list[float]]:
    """Sort terms by their size where every spectrum is 1, equal ones by their symbols' names; with the sizes.

    SymPy's own order of terms takes seconds for thousands of symbols.
    """
    if len(terms) == 1:
        return list(terms), [1.0]
    sizes = [abs(size) for size in sizes_of(terms, values)]
    order = sorted(range(len(terms)), key=lambda k: (-sizes[k], _order(terms[k])))
    return [terms[k] for k in order], [sizes[k] for k in order]


def sizes_of(terms: Sequence[sympy.Expr], values: LetterValues) -> list[float]:
    """The value of each term where every spectrum is 1 and letters have their values, or 1 if they have none.

    Examples
    --------
    >>> from symrt.reflection.symbols import Light, n_dot_l
    >>> sizes_of([3 * Light("sun"), Light("sky") * n_dot_l], {"n_dot_l": 0.5})
    [3.0, 0.5]
    """
    known: dict[sympy.Expr, float] = {}
    return [_size(term, values, known) for term in terms]


def _size(expression: sympy.Expr, values: LetterValues, known: dict[sympy.Expr, float]) -> float:
    """The value of an expression, from those of its parts, which are kept: formulas nest as deep as mirrors do."""
    found = known.get(expression)
    if found is not None:
        return found
    parts = [_size(part, values, known) for part in expression.args]

    # Sizes only sort terms: an overflow, or a power without a value, is no error here.
    with np.errstate(all="ignore"):
        if isinstance(expression, sympy.Symbol):
            found = float(values.get(expression.name, 1.0))
        elif expression.is_number:
            found = float(expression)
        elif expression.is_Add:
            found = math.fsum(parts)
        elif expression.is_Mul:
            found = math.prod(parts)
        elif expression.is_Pow:
            found = float(np.float64(parts[0]) ** parts[1])
        elif isinstance(expression, Lobe):
            found = lobe_value(*parts)
        else:  # a function of a user's own
            found = float(expression.func(*map(sympy.Float, parts)).evalf())
    known[expression] = found
    return found


def _order(term: sympy.Expr) -> list[tuple[Any, str, str]]:
    """A key that sorts terms by the kinds, names and powers of their symbols."""
    powers = term.as_powers_dict().items()
    return sorted((base.class_key(), base.name, str(power)) for base, power in powers if isinstance(base, Kind))
