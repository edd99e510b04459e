"""The kinds of symbol that a model of reflection is written in (step 1).

A formula is partially evaluated by binding time [1]_.  *Static*, known after tracing: geometric factors and
parameters.  *Dynamic*, free until shading: lights and reflectances.  The kind of a symbol is its class, so two symbols
of one name and different kinds never meet.

References
----------
.. [1] N. D. Jones, C. K. Gomard and P. Sestoft, "Partial Evaluation and Automatic Program Generation", 1993, ch. 1.
"""

import re
from typing import Any, ClassVar

import numpy as np
import sympy
from jaxtyping import Float

from symrt.errors import plain
from symrt.symbols import FLUORESCENCE, halves

ESCAPES = {"\\": r"\backslash ", "~": r"\sim ", "^": r"\hat{}", "<": r"{<}", **{c: f"\\{c}" for c in "_{}$%&#"}}
"""Characters that LaTeX obeys, each with the LaTeX that shows it."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
"""A name that a symbol may have."""

GEOMETRY = {
    "n_dot_l": ("n", "l"),
    "n_dot_v": ("n", "v"),
    "n_dot_h": ("n", "h"),
    "h_dot_v": ("h", "v"),
    "r_dot_v": ("r", "v"),
    "l_dot_v": ("l", "v"),
}
"""The geometric factors: cosines between normal n, light l, viewer v, half vector h and mirrored light r, all unit."""

ONE_MINUS = "one_minus_"
"""Prefix of a cosine's name that means 1 − cosine, which keeps the digits that a cosine near 1 has lost."""

FRESNEL = frozenset({"fresnel", "transmission"})
"""Shares of unpolarised light that a smooth surface of an index mirrors, and lets through: they sum to 1.

Formulas by which rays are sent on may name them; the ray itself tells them, from its material's parameter ``index``.
"""

VIEW = frozenset({"n_dot_v", "one_minus_n_dot_v"})
"""Factors that need no light: the only ones that `ambient` and `reflected` may use."""


class Kind(sympy.Symbol):
    """A symbol of one kind; kinds print in the order light, reflectance, window, factor, parameter."""

    rank: ClassVar[str] = ""

    def __new__(cls, name: str) -> "Kind":
        """Make a symbol for a number that is not negative."""
        return super().__new__(cls, name, nonnegative=True)

    def __getnewargs_ex__(self) -> tuple[tuple[str], dict[str, Any]]:
        return (self.name,), {}

    @classmethod
    def class_key(cls) -> tuple[int, int, str]:
        """SymPy's key for the order of factors in a product."""
        return 2, 0, cls.rank

    def _latex(self, _printer: Any) -> str:
        # A user's own names may hold anything; LaTeX, and MathJax in a notebook, obey none of it.
        material, component = halves("".join(ESCAPES.get(c, c) for c in plain(self.name)))
        return rf"\mathrm{{{material}}}" + (rf"_{{\mathrm{{{component}}}}}" if component else "")


class Light(Kind):
    """The spectrum of a light."""

    rank = "1 light"


class Reflectance(Kind):
    """The spectrum of a material's component: ``diffuse`` in a model, ``sea.diffuse`` in a material."""

    rank = "2 reflectance"


class Ordered(Reflectance):
    """A reflectance in a pixel with fluorescent ones: products keep the order in which light meets their factors."""

    def __new__(cls, name: str) -> "Ordered":
        """Make a symbol that commutes with numbers and lights, and with no other of its kind."""
        return sympy.Symbol.__new__(cls, name, commutative=False)


class Hat(Kind):
    """A window of wavelengths, by its text: at each wavelength a fixed share, see `symrt.windows`."""

    rank = "3 window"

    def _latex(self, _printer: Any) -> str:
        parts = self.name.replace("…", r"\ldots").removeprefix("[").removesuffix("nm]")
        return rf"\left[{parts.strip()}\,\mathrm{{nm}}\right]"


class Factor(Kind):
    """A geometric factor: a number for each hit, known after tracing."""

    rank = "4 factor"

    def _sympystr(self, _printer: Any) -> str:
        return f"(1 - {self.name.removeprefix(ONE_MINUS)})" if self.name.startswith(ONE_MINUS) else self.name

    def _latex(self, printer: Any) -> str:
        if self.name.startswith(ONE_MINUS):
            return rf"\left(1 - {printer.doprint(Factor(self.name.removeprefix(ONE_MINUS)))}\right)"
        stem, where = (part.replace("_", r"\_") if part not in GEOMETRY else part for part in split_factor(self.name))
        shown = r"({} \cdot {})".format(*GEOMETRY[stem]) if stem in GEOMETRY else rf"\mathit{{{stem}}}"
        return shown + (rf"_{{\mathrm{{{where}}}}}" if where else "")


class Parameter(Kind):
    """A scalar that is not a spectrum: an exponent, a blend."""

    rank = "5 parameter"


class Lobe(sympy.Function):
    """A power of a cosine, held as ``Lobe(1 - cosine, exponent)`` because a cosine near 1 has no digits left.

    Printed as cosine^exponent, evaluated as exp(s log1p(−(1 − cosine))).
    """

    nargs = 2

    def fdiff(self, argindex: int = 2) -> sympy.Expr:
        """The derivative in the exponent; cosines are numbers by then."""
        if argindex != 2:
            raise sympy.function.ArgumentIndexError(self, argindex)
        return LogLobe(*self.args, 1)

    @property
    def cosine(self) -> Factor:
        """The factor that is raised to a power, for printing."""
        return Factor(self.args[0].name.removeprefix(ONE_MINUS))

    def _sympystr(self, printer: Any) -> str:
        return f"{printer.parenthesize(self.cosine, 60)}**{printer.parenthesize(self.args[1], 60)}"

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        power = rf"{printer.doprint(self.cosine)}^{{{printer.doprint(self.args[1])}}}"
        return rf"\left({power}\right)^{{{exp}}}" if exp else power

    def _eval_evalf(self, prec: int) -> sympy.Expr:
        one_minus, exponent = (a._eval_evalf(prec) for a in self.args)  # noqa: SLF001 -- SymPy's own protocol
        return (1 - one_minus) ** exponent


class LogLobe(sympy.Function):
    """``cosine^s (ln cosine)^k``, the k-th derivative of a `Lobe` in its exponent; 0 where the cosine is."""

    nargs = 3

    def fdiff(self, argindex: int = 2) -> sympy.Expr:
        """The derivative in the exponent."""
        if argindex != 2:
            raise sympy.function.ArgumentIndexError(self, argindex)
        return LogLobe(self.args[0], self.args[1], self.args[2] + 1)

    def _eval_evalf(self, prec: int) -> sympy.Expr:
        one_minus, exponent, times = (a._eval_evalf(prec) for a in self.args)  # noqa: SLF001 -- SymPy's own protocol
        cosine = 1 - one_minus
        return cosine**exponent * sympy.log(cosine) ** times if cosine != 0 else sympy.Integer(0)


def reflectance(name: str) -> Reflectance:
    """A reflectance for a user's own model.

    Examples
    --------
    >>> reflectance("f0")
    f0
    """
    return Reflectance(checked_name(name))


def parameter(name: str) -> Parameter:
    """A scalar that each material gives a value: ``Material("red", model=shiny, exponent=40)``.

    Examples
    --------
    >>> parameter("exponent")
    exponent
    """
    return Parameter(checked_name(name))


def lobe(cosine: sympy.Expr, exponent: object) -> sympy.Expr:
    """A power of a cosine, exact to 2 ulp up to exponents of 1e7 where ``long double`` is wider than ``double``.

    Examples
    --------
    >>> lobe(r_dot_v, parameter("exponent"))
    r_dot_v**exponent
    """
    if not isinstance(cosine, Factor) or cosine.name not in GEOMETRY:
        raise ValueError(f"lobe({cosine}, …): the first argument is one of the cosines {', '.join(GEOMETRY)}")
    exponent = float(exponent) if isinstance(exponent, np.number) else exponent
    # A string is refused, not parsed: SymPy's parser evaluates what it reads.
    bound = isinstance(exponent, sympy.Expr) and not exponent.atoms(Factor, Reflectance)
    if not (bound or isinstance(exponent, float | int)):
        raise ValueError(f"lobe(…, {exponent!r}): the exponent is a number, or an expression in parameters alone")
    return Lobe(Factor(ONE_MINUS + cosine.name), exponent)


def with_lobes(formula: sympy.Expr) -> sympy.Expr:
    """A formula in which powers of cosines with a parameter in the exponent are lobes, whose slopes are known at 0.

    Examples
    --------
    >>> with_lobes(n_dot_v ** parameter("s") * sympy.log(2)).has(Lobe)
    True
    """
    powers = [p for p in formula.atoms(sympy.Pow) if isinstance(p.base, Factor) and p.exp.atoms(Parameter)]
    opposite = {p: p.base.name.removeprefix(ONE_MINUS) for p in powers}
    names = {p: n if p.base.name != n else ONE_MINUS + n for p, n in opposite.items()}
    return formula.xreplace({p: Lobe(Factor(name), p.exp) for p, name in names.items()})


def lobe_values(one_minus_cosine: Float[np.ndarray, " point"], exponent: float | int) -> Float[np.ndarray, " point"]:
    """Evaluate (1 − x)^s as exp(s log1p(−x)), x clamped to [0, 1] first; anything to the power 0 is 1.

    Examples
    --------
    >>> lobe_values(np.array([0.0, 0.5, 1.0, 1.7]), 2.0)
    array([1.  , 0.25, 0.  , 0.  ])
    """
    if exponent == 0:
        return np.ones_like(one_minus_cosine)
    # Rounding the logarithm costs s·|log| ulp of the power: the wider type has 11 bits to spare for it.
    x = np.clip(one_minus_cosine, 0.0, 1.0).astype(np.longdouble)
    with np.errstate(divide="ignore", under="ignore"):
        return np.exp(np.longdouble(exponent) * np.log1p(-x)).astype(np.float64)


def log_lobe_values(
    one_minus_cosine: Float[np.ndarray, " point"], exponent: float | int, times: float | int
) -> Float[np.ndarray, " point"]:
    """Evaluate x^s (ln x)^k, which is 0 at x = 0.

    Examples
    --------
    >>> log_lobe_values(np.array([0.0, 0.5, 1.0]), 2.0, 1).round(6)
    array([-0.      , -0.173287,  0.      ])
    """
    x = np.clip(one_minus_cosine, 0.0, 1.0)
    with np.errstate(divide="ignore"):
        logarithm = np.where(x < 1, np.log1p(-x), 0.0)
    return lobe_values(x, exponent) * np.where(x < 1, logarithm**times, 0.0)


def lobe_value(one_minus_cosine: float | int, exponent: float | int) -> float:
    """One value of `lobe_values`.

    Examples
    --------
    >>> lobe_value(0.5, 2.0)
    0.25
    """
    return float(lobe_values(np.array([float(one_minus_cosine)]), float(exponent))[0])


def checked_name(name: object) -> str:
    """The name itself, if a symbol may have it."""
    if not isinstance(name, str) or NAME.fullmatch(name) is None:
        raise ValueError(f"{name!r} is not a name: a letter, then letters, digits and underscores")
    return name


def split_factor(name: str) -> tuple[str, str]:
    """The factor and the place it belongs to: ``n_dot_l_sun_2`` is ``n_dot_l`` at ``sun_2``."""
    for stem in (*GEOMETRY, *sorted(FRESNEL), "visible", "irradiance", "weight", "d"):
        if name == stem or name.startswith(f"{stem}_"):
            return stem, name[len(stem) + 1 :]
    return name, ""


diffuse = Reflectance("diffuse")
fluorescence = Reflectance(FLUORESCENCE)
specular = Reflectance("specular")
mirror = Reflectance("mirror")
n_dot_l, n_dot_v, n_dot_h, h_dot_v, r_dot_v, l_dot_v = map(Factor, GEOMETRY)
fresnel, transmission = map(Factor, sorted(FRESNEL))
