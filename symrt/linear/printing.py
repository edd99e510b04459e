"""Print a pixel's expression as text, LaTeX or Python (steps 1 and 2).

Full float64 stays inside and in Python code; digits are dropped in text and LaTeX only.
"""

import keyword
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import sympy
from sympy.printing.latex import LatexPrinter
from sympy.printing.pycode import PythonCodePrinter
from sympy.printing.str import StrPrinter

from symrt.linear.functions import function_of
from symrt.reflection.symbols import ONE_MINUS, Factor, Hat, Kind, Lobe, lobe_value
from symrt.windows import SpectralWindow

NEGLIGIBLE = 1e-9
"""Share of the pixel below which terms are counted and not shown."""
MANY = 200
"""Largest number of terms that Python code adds one by one: a chain of additions is nested as deep as it is long."""

LOBE = '''

def lobe(cosine, exponent):
    """A cosine to a power, to the last digit: near its peak a float has no digits left, so that it is a Decimal."""
    return float((Decimal(exponent) * cosine.ln()).exp()) if exponent else 1.0
'''

HAT = '''

def window(nm, low, centre, high):
    """The share of a window of wavelengths at one of them: 1 at its centre, 0 from its ends on."""
    if not low <= nm <= high:
        return 0.0
    return (nm - low) / (centre - low) if nm < centre else (high - nm) / (high - centre) if nm > centre else 1.0
'''

LetterValues = Mapping[str, float]


class _Sized:
    """The common part of the text and LaTeX printers: digits are dropped, and the largest terms come first."""

    def __init__(self, digits: int, values: LetterValues, settings: Mapping[str, Any] | None = None) -> None:
        super().__init__(settings)  # type: ignore[call-arg]  # of the printer beside it
        self.digits, self.values = digits, values

    def _as_ordered_terms(self, expr: sympy.Expr, order: object = None) -> list[sympy.Expr]:  # noqa: ARG002
        return _largest_first(sympy.Add.make_args(expr), self.values)[0]

    def number(self, value: sympy.Float) -> str:
        """A float with digits dropped."""
        return f"{float(value):.{self.digits}g}"

    def without_ones(self, term: sympy.Expr) -> sympy.Expr:
        """The term without factors that would be printed as 1."""
        ones = {"1": sympy.Integer(1), "-1": sympy.Integer(-1)}
        return term.xreplace({f: ones[self.number(f)] for f in term.atoms(sympy.Float) if self.number(f) in ones})


class _Text(_Sized, StrPrinter):
    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        return self.number(expr)


class _Tex(_Sized, LatexPrinter):
    def __init__(self, digits: int, values: LetterValues) -> None:
        super().__init__(digits, values, {"mul_symbol": r"\,"})

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        mantissa, _, exponent = self.number(expr).partition("e")
        return mantissa + (rf" \cdot 10^{{{int(exponent)}}}" if exponent else "")


class _Python(PythonCodePrinter):
    def __init__(self, names: Mapping[Kind, str], bare: frozenset[Factor]) -> None:
        super().__init__({"fully_qualified_modules": True})
        self.names, self.bare = names, bare

    def _print_Float(self, expr: sympy.Float) -> str:  # noqa: N802 -- SymPy's name for it
        return repr(float(expr))

    def _print_Lobe(self, expr: sympy.Expr) -> str:  # noqa: N802 -- SymPy's name for it
        one_minus, exponent = (self.doprint(part) for part in expr.args)
        return f"lobe({f'1 - Decimal({one_minus})' if expr.args[0] in self.bare else one_minus}, {exponent})"

    def _print_Hat(self, expr: Hat) -> str:  # noqa: N802 -- SymPy's name for it
        return f"window(nm, {', '.join(map(repr, SpectralWindow.of(expr.name)))})"

    def _print_Symbol(self, expr: sympy.Symbol) -> str:  # noqa: N802 -- SymPy's name for it
        return self.names[expr]

    # The symbols of every kind are printed by the names given, whatever their names are elsewhere.
    _print_Light = _print_Reflectance = _print_Factor = _print_Parameter = _print_Symbol  # noqa: N815 -- as above


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


def python_code(expression: sympy.Expr, spectra: Sequence[str], values: Mapping[str, float], name: str) -> str:
    """Print an expression as a Python function of the spectra, with the geometric letters as numbers above it.

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

    # The letters of the geometry, and the function's arguments.
    bare = _outside_lobes(expression)
    names = _identifiers(expression, {name, "math", "Decimal", "lobe", "window", "nm"}, bare)
    printer = _Python(names, bare)
    letters = [
        f"{names[Factor(letter)]} = {_python_value(letter, float(value), Factor(letter) in bare)}"
        for letter, value in values.items()
        if Factor(letter) in names
    ]
    windows = bool(expression.atoms(Hat))
    arguments = ", ".join([*(names[s] for s in _arguments(expression, spectra)), *(["nm"] if windows else [])])

    # The sum that it returns, largest terms first.
    terms = [printer.doprint(term) for term in _largest_first(sympy.Add.make_args(expression), values)[0]]
    total = _joined(terms)
    if len(terms) > MANY:
        total = "math.fsum((\n        " + ",\n        ".join(terms) + ",\n    ))"

    # Its imports, and the powers of cosines and the windows if there are any.
    lobes = bool(expression.atoms(Lobe))
    head = ["import math", *(["from decimal import Decimal"] if lobes else []), *([""] if letters else []), *letters]
    needed = "".join(part for part, used in ((LOBE, lobes), (HAT, windows)) if used)
    return "\n".join(head) + f"\n{needed}\n\ndef {name}({arguments}):\n    return {total}"


def _python_value(letter: str, value: float, bare: bool) -> str:
    """A letter's value as code; a cosine that lobes alone raise to powers keeps every digit of its distance from 1."""
    return f"1 - Decimal({value!r})" if letter.startswith(ONE_MINUS) and not bare else repr(value)


def _outside_lobes(expression: sympy.Expr) -> frozenset[Factor]:
    """The factors that occur in an expression elsewhere than as the cosine of a lobe."""
    found, left, seen = set(), [expression], set()
    while left:
        part = left.pop()
        if part not in seen:
            seen.add(part)
            left += part.args[1:] if isinstance(part, Lobe) else part.args
            if isinstance(part, Factor):
                found.add(part)
    return frozenset(found)


def _sum(printer: Any, terms: Sequence[sympy.Expr]) -> str:
    return _joined([printer.doprint(printer.without_ones(term)) for term in terms])


def _joined(terms: Sequence[str]) -> str:
    return " + ".join(terms).replace(" + -", " - ")


def _shown(expression: sympy.Expr, most: int | None, values: LetterValues) -> tuple[list[sympy.Expr], str]:
    """The terms of a sum that are shown, largest first, and words for the others; no words if there are none."""
    if most is not None and most < 1:
        raise ValueError(f"terms = {most}: at least one term is shown")

    # Terms that are not negligible, and of these as many as are asked for.
    ordered, sizes = _largest_first(sympy.Add.make_args(expression), values)
    least = NEGLIGIBLE * sum(sizes)
    some = sum(size >= least for size in sizes)
    shown = ordered[: min(some, most or some)]

    # The others are counted; only where all that matter are shown can they be called small.
    left_out = len(ordered) - len(shown)
    if not left_out:
        return shown, ""
    terms = f"{left_out} {'more ' if len(shown) < some else ''}term{'s' if left_out > 1 else ''}"
    return shown, terms if len(shown) < some else f"{terms} below {NEGLIGIBLE:g} of the pixel"


def _largest_first(terms: Sequence[sympy.Expr], values: LetterValues) -> tuple[list[sympy.Expr], list[float]]:
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


def _order(term: sympy.Expr) -> list[tuple[Any, str, str]]:
    """A key that sorts terms by the kinds, names and powers of their symbols."""
    powers = term.as_powers_dict().items()
    return sorted((base.class_key(), base.name, str(power)) for base, power in powers if isinstance(base, Kind))


def _arguments(expression: sympy.Expr, spectra: Sequence[str]) -> list[Any]:
    """The free symbols other than geometric letters, in the order of `spectra`, and any others after them."""
    rank = {name: k for k, name in enumerate(spectra)}
    free = [s for s in expression.free_symbols if not isinstance(s, Factor | Hat)]
    return sorted(free, key=lambda s: (rank.get(s.name, len(rank)), s.class_key(), s.name))


def _identifiers(expression: sympy.Expr, taken: set[str], bare: frozenset[Factor]) -> dict[Kind, str]:
    """A Python identifier for each symbol; no two symbols share one."""
    names: dict[Kind, str] = {}
    for symbol in sorted(expression.free_symbols, key=lambda s: (s.class_key(), s.name)):
        shown = symbol.name if symbol in bare or not isinstance(symbol, Factor) else symbol.name.removeprefix(ONE_MINUS)
        name = "".join(c if c.isalnum() and c.isascii() else "_" for c in shown)
        # No identifier begins with a digit, whatever is put behind it.
        name = f"x{name}" if name[:1].isdigit() else name
        while name in taken or keyword.iskeyword(name) or not name.isidentifier():
            name += "_" if name else "x"
        taken.add(name)
        names[symbol] = name
    return names
