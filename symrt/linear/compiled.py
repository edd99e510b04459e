"""A formula compiled: split into monomials, its coefficients turned into one NumPy function (step 2).

This is done once a material, never once a pixel.
"""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy
from jaxtyping import Float

from symrt.linear.functions import function_of
from symrt.nodes import Nodes
from symrt.reflection.polynomials import Monomial, monomials
from symrt.reflection.symbols import Factor, Lobe, Parameter, lobe_values, with_lobes
from symrt.symbols import named

NodeIndex = tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class Compiled:
    """A formula Σ_k c_k(factors) Π reflectances: the products, and a function for the coefficients c_k.

    Parameters
    ----------
    terms
        For each coefficient its product of reflectances, and the node of each free parameter that it depends on.
    factors
        The geometric factors that the coefficients depend on.
    expressions
        The coefficients, with nothing but factors left in them.
    """

    terms: tuple[tuple[Monomial, NodeIndex], ...]
    factors: tuple[str, ...]
    expressions: tuple[sympy.Expr, ...]

    @cached_property
    def function(self) -> Callable[..., list[object]]:
        """The coefficients as one NumPy function of the factors, common subexpressions shared."""
        return function_of([Factor(name) for name in self.factors], self.expressions, lobe_values, cse=True)

    def __getstate__(self) -> dict[str, object]:
        # The function is compiled anew in another process: functions made at run time cannot be sent.
        return {name: value for name, value in self.__dict__.items() if name != "function"}

    def coefficients(self, factors: Mapping[str, np.ndarray], size: int) -> list[Float[np.ndarray, " point"]]:
        """The coefficient of each term at each point.

        Raises
        ------
        ValueError
            If a formula has no finite value at some point.
        """
        # 0/0 and overflow pass here: they are reported below, with the place where they happen.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            try:
                values = self.function(*(factors[name] for name in self.factors))
            except (NameError, TypeError) as error:
                shown = ", ".join(map(str, self.expressions))
                raise ValueError(f"{shown}: NumPy cannot compute this ({error}); use functions that it has") from error

        # A constant coefficient is spread over all points; every value must be finite.
        arrays = [np.broadcast_to(np.asarray(value, dtype=np.float64), (size,)) for value in values]
        for (met, _), array in zip(self.terms, arrays, strict=True):
            finite = np.isfinite(array)
            if not finite.all():
                where = {name: float(factors[name][np.argmin(finite)]) for name in self.factors}
                raise ValueError(
                    f"the coefficient of {'*'.join(met) or '1'} is not finite at {where}: guard the formula"
                )
        return arrays


def compile_formula(
    formula: sympy.Expr, material: str, parameters: Mapping[str, float], free: Mapping[str, Nodes] | None = None
) -> Compiled:
    """Bind the parameters of a material, split what is left, and compile its coefficients.

    A coefficient that depends on a free parameter is compiled once for each of its nodes.

    Examples
    --------
    >>> from symrt.reflection import MODELS
    >>> compiled = compile_formula(MODELS["lambert"].direct, "sea", {})
    >>> compiled.terms, compiled.coefficients({"n_dot_l": np.array([0.0, 1.0])}, 2)
    (((('sea.diffuse',), ()),), [array([0.        , 0.31830989])])
    """
    free = free or {}
    values = {Parameter(name): sympy.Float(float(value)) for name, value in parameters.items() if name not in free}

    # One coefficient for each monomial and each combination of nodes.
    terms: list[tuple[Monomial, NodeIndex]] = []
    coefficients: list[sympy.Expr] = []
    for met, coefficient in monomials(formula).items():
        for index, bound in _at_nodes(coefficient.xreplace(values), free):
            if any(lobe.args[1] < 0 for lobe in bound.atoms(Lobe)):
                raise ValueError(f"{material}: {bound}: an exponent of a cosine must not be negative; 40 is glossy")
            terms.append((tuple(named(material, name) for name in met), index))
            coefficients.append(bound)

    factors = tuple(sorted({symbol.name for c in coefficients for symbol in c.atoms(Factor)}))
    return Compiled(tuple(terms), factors, tuple(coefficients))


def _at_nodes(coefficient: sympy.Expr, free: Mapping[str, Nodes]) -> list[tuple[NodeIndex, sympy.Expr]]:
    """The coefficient at each combination of nodes of the free parameters in it; just itself if there are none."""
    names = sorted(symbol.name for symbol in coefficient.atoms(Parameter))
    if missing := [name for name in names if name not in free]:
        raise ValueError(f"{coefficient}: {', '.join(missing)} has no value; give it one in the material")
    found = []
    for index in itertools.product(*(range(free[name].count) for name in names)):
        # First order's second part is the slope.
        values, part = {}, coefficient
        for name, j in zip(names, index, strict=True):
            nodes, around = free[name], free[name].around
            part = part if around is None or j == 0 else sympy.diff(with_lobes(part), Parameter(name))
            values[Parameter(name)] = sympy.Float(nodes.values[j] if around is None else around)
        found.append(
            (tuple((free[name].parameter, j) for name, j in zip(names, index, strict=True)), part.xreplace(values))
        )
    return found
