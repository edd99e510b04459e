"""A pixel as a formula: with the geometry still in letters, or collapsed to its linear form (steps 1 and 2)."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import singledispatch
from typing import Any

import numpy as np
import sympy
from jaxtyping import Float

from symrt.errors import shown
from symrt.linear.coding import python_code
from symrt.linear.evaluating import evaluated
from symrt.linear.printing import tex, text
from symrt.linear.terms import number, tree_expression
from symrt.reflection.symbols import ONE_MINUS, Factor, Hat, Light, Ordered, Parameter, Reflectance
from symrt.scene.records import Scene
from symrt.symbols import OF_MATERIAL, Symbol
from symrt.system import LinearSystem
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace
from symrt.windows import SpectralWindow

MANY = 24
"""Most letters of a pixel's film samples that are shown one by one; of more the ranges are."""
Spectra = Mapping[str, float | Float[np.ndarray, " band"] | Float[np.ndarray, "band band"]]


@dataclass(frozen=True)
class Formula:
    """The formula of one pixel: an expression in lights and reflectances, and the values of its geometric letters.

    The expression and its Python code keep every digit; text and LaTeX drop digits, and count the terms that they
    leave out.

    Parameters
    ----------
    samples
        Of a pixel with several film samples, for each letter the same one without the sample's mark.

    Examples
    --------
    >>> from symrt.reflection.symbols import n_dot_l
    >>> grey = Formula(Light("sun") * Reflectance("sea.diffuse") * n_dot_l / sympy.pi, {"n_dot_l": 0.5})
    >>> print(grey)
    sun*sea.diffuse*n_dot_l/pi
      where n_dot_l = 0.5
    >>> grey.evaluate({"sun": np.pi, "sea.diffuse": 0.5})
    0.25
    """

    expression: sympy.Expr
    values: Mapping[str, float] = field(default_factory=dict)
    samples: Mapping[str, str] = field(default_factory=dict)

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the free spectra, lights first."""
        free = self.expression.atoms(Light, Reflectance)
        return tuple(symbol.name for symbol in sorted(free, key=lambda s: (s.class_key(), s.name)))

    def text(self, digits: int = 4, terms: int | None = None) -> str:
        """Plain text, largest terms first, with floats to some `digits`, and at most so many `terms` if given.

        Terms below 1e-9 of the pixel are counted, not shown.
        """
        return text(self.expression, digits, terms, self.values)

    def latex(self, digits: int = 4, terms: int | None = None) -> str:
        """LaTeX source, as `text`."""
        return tex(self.expression, digits, terms, self.values)

    def code(self, name: str = "pixel") -> str:
        """A Python function of the free spectra, exact to the last bit of every number in it.

        It takes numbers, one band at a time; up to 200 terms also arrays.  Where glass bends wavelengths apart it takes
        the band's wavelength, too: ``nm``, a number.  With a fluorescent reflectance, a matrix, it takes arrays alone.

        Examples
        --------
        >>> print(Formula(0.25 * Light("sun") * Reflectance("sea.diffuse")).code())
        import math
        <BLANKLINE>
        <BLANKLINE>
        def pixel(sun, sea_diffuse):
            return 0.25*sun*sea_diffuse
        """
        return python_code(self.expression, self.symbols, self.values, name)

    def evaluate(
        self, spectra: Spectra, nm: float | int | Float[np.ndarray, " band"] | None = None
    ) -> Float[np.ndarray, " band"] | float:
        """The pixel's value for given spectra, by name; bands broadcast.

        A fluorescent reflectance is the matrix that a palette has for it, which takes all bands of the others.

        Parameters
        ----------
        nm
            The wavelength of each band, where glass bends wavelengths apart.

        Examples
        --------
        >>> Formula(Light("sun") * Hat("[400 … 500 … 700 nm]")).evaluate({"sun": 2.0}, nm=600)
        1.0
        """
        # Values for all letters and spectra in the expression.
        leaves: dict[sympy.Symbol, Any] = {Factor(name): value for name, value in self.values.items()}
        free = self.expression.free_symbols
        leaves |= {s: spectra[s.name] for s in free if not isinstance(s, Factor) and s.name in spectra}
        windows = [s for s in free if isinstance(s, Hat)]
        if windows and nm is None:
            raise ValueError(
                f"{windows[0].name}: the pixel depends on the wavelength: give nm=, such as the palette's bands.centres"
            )
        for symbol in windows:
            weights = SpectralWindow.of(symbol.name).weights(np.atleast_1d(np.asarray(nm, dtype=float)))
            leaves[symbol] = float(weights[0]) if isinstance(nm, float | int) else weights
        missing = sorted(s.name for s in free - set(leaves))
        if missing:
            raise ValueError(f"no value for {', '.join(missing)}; the formula's spectra are {', '.join(self.symbols)}")

        # Numbers are summed without rounding in between, bands as arrays.
        terms = evaluated(sympy.Add.make_args(self.expression), leaves)
        if all(np.ndim(term) == 0 for term in terms):
            return math.fsum(terms)
        return np.sum(np.broadcast_arrays(*terms), axis=0)

    @property
    def letters(self) -> dict[str, float]:
        """The geometric letters and their values as they are printed: a cosine where its 1 − cosine is kept."""
        return {
            name.removeprefix(ONE_MINUS): 1 - value if name.startswith(ONE_MINUS) else value
            for name, value in self.values.items()
        }

    def __str__(self) -> str:
        if self.expression == 0:
            return "0\n  nothing is seen here that light reaches"
        if len(self.samples) > MANY:
            return self._averaged()
        letters = ", ".join(f"{name} = {value:.4g}" for name, value in self.letters.items())
        return self.text() + (f"\n  where {letters}" if letters else "") + self._order()

    def _order(self) -> str:
        """A sentence about the fluorescent factors; empty if there are none."""
        names = [name for name in self.symbols if OF_MATERIAL.fullmatch(name) and Symbol.of(name).fluorescent]
        if not names:
            return ""
        them = f"{', '.join(names)} {'give' if len(names) > 1 else 'gives'}"
        return f"\n  {them} light back at other wavelengths: factors stand in the order in which light meets them"

    def _averaged(self) -> str:
        """Terms that are alike but for their samples as one, and the range of each letter over the samples."""
        alike = Formula(self.expression.xreplace({Factor(a): Factor(b) for a, b in self.samples.items()}))
        found: dict[str, list[float]] = {}
        for name, value in self.letters.items():
            found.setdefault(self._bare[name], []).append(value)
        letters = ", ".join(f"{name} = {_range(values)}" for name, values in found.items())
        return f"{alike.text()}\n  in the mean over the pixel's samples, where {letters}"

    @property
    def _bare(self) -> dict[str, str]:
        return {a.removeprefix(ONE_MINUS): b.removeprefix(ONE_MINUS) for a, b in self.samples.items()}

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


@singledispatch
def formula(source: object, x: Any, y: Any) -> Formula:  # noqa: ARG001 -- the registered ones use them
    """The formula of pixel (x, y), x from the left and y from the top, both from 0; in a window, from its corner.

    Parameters
    ----------
    source
        A `RayTree`, for the formula with geometry still in letters; a `LinearSystem`, for the linear form; or a
        `Scene`, which is traced for this one pixel.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> formula(load_scene(shipped_scene("first")), x=0, y=0).text()
    '0'
    """
    raise TypeError(f"formula of a {type(source).__name__}, {shown(source)}: give a Scene, a RayTree or a LinearSystem")


@formula.register
def _(source: RayTree, x: Any, y: Any) -> Formula:
    expression, letters = tree_expression(source, _checked_pixel(x, y, source.width, source.height))
    held = {symbol.name for symbol in expression.free_symbols if isinstance(symbol, Factor)}
    samples = {name: bare for name, bare in letters.alike.items() if name in held and bare != name}
    return Formula(expression, {name: v for name, v in letters.values.items() if name in held}, samples)


@formula.register
def _(source: Scene, x: Any, y: Any) -> Formula:
    _checked_pixel(x, y, source.camera.width, source.camera.height)
    return formula(trace(source, window=(x, y, x + 1, y + 1)), 0, 0)


@formula.register
def _(source: LinearSystem, x: Any, y: Any) -> Formula:
    pixel = _checked_pixel(x, y, source.width, source.height)
    found = source.terms(pixel)
    matrices = any(Symbol.of(name).fluorescent for interaction, _ in found for name in interaction.met)
    kind = Ordered if matrices else Reflectance
    terms = []
    for interaction, g in found:
        nodes = [_node(source, name, j) for name, j in interaction.nodes]
        powers = [kind(name) ** sympy.Float(length) for name, length in interaction.powers]
        window = [Hat(str(interaction.window))] if interaction.window else []
        met = map(kind, interaction.met)
        terms.append(sympy.Mul(number(g), Light(interaction.light), *met, *powers, *window, *nodes))
    return Formula(sympy.Add(*terms))


def _node(source: LinearSystem, name: str, j: int) -> sympy.Expr:
    """The weight of a node, as a letter of its own; of first order 1, and the distance from the value it is around."""
    around = source.parameters[name].around if name in source.parameters else None
    if around is None:
        return Parameter(f"{name}[{j}]")
    return Parameter(name) - number(around) if j else sympy.Integer(1)


@dataclass(frozen=True, eq=False)
class Expressions:
    """The expression trees of a traced image, one for each pixel, made when asked for."""

    tree: RayTree

    def __getitem__(self, pixel: tuple[int, int]) -> Formula:
        return formula(self.tree, *pixel)

    def __len__(self) -> int:
        return self.tree.width * self.tree.height

    def __iter__(self) -> Iterator[Formula]:
        """All pixels, row by row from the top."""
        return (self[x, y] for y in range(self.tree.height) for x in range(self.tree.width))


def expressions(tree: RayTree) -> Expressions:
    """A SymPy expression for each pixel, geometry in letters: ``expressions(tree)[x, y]``.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> len(expressions(trace(load_scene(shipped_scene("first")), window=(0, 0, 4, 3))))
    12
    """
    return Expressions(tree)


def _range(values: list[float]) -> str:
    """Numbers as the first and the last of them, or as the one that all are."""
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    return low if low == high else f"{low} … {high}"


def _checked_pixel(x: Any, y: Any, width: int, height: int) -> int:
    for name, value, what in (("x", x, "column"), ("y", y, "row")):
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            raise ValueError(f"{name} = {shown(value)}: a pixel's {what} is a whole number, counted from 0")  # noqa: TRY004
    if not (0 <= x < width and 0 <= y < height):
        raise ValueError(f"pixel ({x}, {y}) is outside the image of {width} × {height}; x and y count from 0")
    return int(y) * width + int(x)
