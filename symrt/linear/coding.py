"""Print a pixel's expression as a Python function, exact to the last bit of every number in it (steps 1 and 2)."""

import keyword
from collections.abc import Mapping, Sequence
from typing import Any

import sympy
from sympy.printing.precedence import precedence
from sympy.printing.pycode import PythonCodePrinter

from symrt.linear.printing import joined, largest_first
from symrt.reflection.symbols import ONE_MINUS, Factor, Hat, Kind, Lobe, Ordered
from symrt.symbols import fluoresces, halves
from symrt.windows import SpectralWindow

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

    def _print_Mul(self, expr: sympy.Expr) -> str:  # noqa: N802 -- SymPy's name for it
        numbers, ordered = expr.args_cnc()
        if not ordered:
            return str(super()._print_Mul(expr))
        # Python multiplies from the left, spectra and matrices alike, as light meets them.
        text = self.parenthesize(sympy.Mul(*numbers), precedence(expr), strict=True)
        for base, power in (factor.as_base_exp() for factor in ordered):
            if not power.is_Integer:  # of a transmittance, to the length of a way
                text += f"*{self.doprint(base)}**{self.doprint(power)}"
                continue
            sign = "@" if isinstance(base, Ordered) and fluoresces(halves(base.name)[1]) else "*"
            text += f"{sign}{self.doprint(base)}" * int(power)
        return text.removeprefix("1*")

    # The symbols of every kind are printed by the names given, whatever their names are elsewhere.
    _print_Ordered = _print_Light = _print_Reflectance = _print_Factor = _print_Parameter = _print_Symbol  # noqa: N815 -- as above


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

    # A sum of spectra and matrices is no array: light is multiplied by each of them.
    if not expression.is_commutative:
        if expression.atoms(Hat):
            raise ValueError("code of windows takes one wavelength, and a fluorescent factor all of them: use evaluate")
        expression = sympy.expand(expression, deep=True, power_base=False, power_exp=False)

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

    # The sum that it returns, largest terms first; terms with a matrix among their factors are arrays.
    terms = [printer.doprint(term) for term in largest_first(sympy.Add.make_args(expression), values)[0]]
    total = joined(terms)
    if len(terms) > MANY:
        added = "math.fsum" if expression.is_commutative else "sum"
        total = f"{added}((\n        " + ",\n        ".join(terms) + ",\n    ))"

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
