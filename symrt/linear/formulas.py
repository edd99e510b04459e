"""A pixel as a formula: with the geometry still in letters, or collapsed to its linear form (steps 1 and 2)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import singledispatch

import numpy as np
import sympy
from jaxtyping import Float

from symrt.linear.functions import function_of
from symrt.linear.printing import python_code, tex, text
from symrt.linear.terms import tree_expression
from symrt.reflection.symbols import Factor, Light, Parameter, Reflectance, lobe_value
from symrt.scene.records import Scene
from symrt.system import LinearSystem
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

__all__ = ["Expressions", "Formula", "expressions", "formula"]

Spectra = Mapping[str, float | Float[np.ndarray, " band"]]


@dataclass(frozen=True)
class Formula:
    """What one pixel says: an expression in lights and reflectances, and the values of the letters of its geometry.

    The expression and its Python code hold every digit; text and LaTeX drop digits, and say how many terms they left
    out if they were asked to.

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

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the free spectra, lights first."""
        free = self.expression.atoms(Light, Reflectance)
        return tuple(symbol.name for symbol in sorted(free, key=lambda s: (s.class_key(), s.name)))

    def text(self, digits: int = 4, terms: int | None = None) -> str:
        """Plain text, with floats to some digits; only the first `terms` terms if a number is given."""
        return text(self.expression, digits, terms)

    def latex(self, digits: int = 4, terms: int | None = None) -> str:
        """LaTeX source, with floats to some digits; only the first `terms` terms if a number is given."""
        return tex(self.expression, digits, terms)

    def code(self, name: str = "pixel") -> str:
        """A Python function of the free spectra, exact to the last bit of every number in it.

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

    def evaluate(self, spectra: Spectra) -> Float[np.ndarray, " band"] | float:
        """The pixel's value for given spectra, by name; bands broadcast."""
        leaves = {Factor(name): value for name, value in self.values.items()}
        leaves |= {
            s: spectra[s.name] for s in self.expression.atoms(Light, Reflectance, Parameter) if s.name in spectra
        }
        missing = sorted(s.name for s in self.expression.free_symbols - set(leaves))
        if missing:
            raise ValueError(f"no value for {', '.join(missing)}; the formula's spectra are {', '.join(self.symbols)}")
        (value,) = function_of(leaves, [self.expression], lobe_value)(*leaves.values())
        return value

    def __str__(self) -> str:
        letters = ", ".join(f"{_shown(name, value)}" for name, value in self.values.items())
        return self.text() + (f"\n  where {letters}" if letters else "")

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"


@singledispatch
def formula(source: object, x: int, y: int) -> Formula:  # noqa: ARG001 -- the registered ones use them
    """The formula of pixel (x, y), x from the left and y from the top, both from 0; in a window, from its corner.

    Parameters
    ----------
    source
        A `RayTree` gives the formula with geometry still in letters, a `LinearSystem` the linear form, and a `Scene`
        is traced for this one pixel.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> formula(load_scene(shipped_scene("first")), x=0, y=0).text()
    '0'
    """
    raise ValueError(f"formula of a {type(source).__name__}: give a RayTree, a LinearSystem or a Scene")


@formula.register
def _(source: RayTree, x: int, y: int) -> Formula:
    return Formula(*tree_expression(source, _pixel(x, y, source.width, source.height)))


@formula.register
def _(source: Scene, x: int, y: int) -> Formula:
    _pixel(x, y, source.camera.width, source.camera.height)
    return formula(trace(source, window=(x, y, x + 1, y + 1)), 0, 0)


@formula.register
def _(source: LinearSystem, x: int, y: int) -> Formula:
    pixel = _pixel(x, y, source.width, source.height)
    entries = slice(source.G.indptr[pixel], source.G.indptr[pixel + 1])
    terms = []
    for column, g in zip(source.G.indices[entries], source.G.data[entries], strict=True):
        interaction = source.interactions[column]
        nodes = [Parameter(f"{name}[{j}]") for name, j in interaction.nodes]
        terms.append(
            sympy.Mul(sympy.Float(float(g)), Light(interaction.light), *map(Reflectance, interaction.met), *nodes)
        )
    return Formula(sympy.Add(*terms))


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


def _pixel(x: int, y: int, width: int, height: int) -> int:
    if not (0 <= x < width and 0 <= y < height):
        raise ValueError(f"pixel ({x}, {y}) is outside the image of {width} × {height}; x and y count from 0")
    return y * width + x


def _shown(name: str, value: float) -> str:
    if name.startswith("one_minus_"):
        return f"{name.removeprefix('one_minus_')} = {1 - value:.4g}"
    return f"{name} = {value:.4g}"
