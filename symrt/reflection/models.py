"""Models of reflection: each one is its formulas (step 1).

``direct`` is the radiance towards the viewer per unit irradiance on a surface that faces the light; ``ambient`` per
unit radiance of an ambient light; ``reflected`` the share of the radiance that arrives along the mirrored view;
``emitted`` the radiance that a surface sends by itself, per unit of the symbol of the light that it is.
Cosines arrive clamped to [0, 1], and a light behind the surface is not asked.

References
----------
.. [1] B. T. Phong, "Illumination for Computer Generated Pictures", CACM 18(6), 1975.
.. [2] J. F. Blinn, "Models of Light Reflection for Computer Synthesized Pictures", SIGGRAPH 1977.
.. [3] E. P. Lafortune and Y. D. Willems, "Using the Modified Phong Reflectance Model for Physically Based Rendering",
   KU Leuven CW 197, 1994: the factor (s + 2)/2π.

The metals' formulas, with their references and errors, are those of `symrt.reflection.metals`.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import numpy as np
import sympy
from sympy import pi
from sympy.core.function import AppliedUndef

from symrt.reflection.metals import f82, schlick
from symrt.reflection.polynomials import monomials
from symrt.reflection.symbols import (
    FRESNEL,
    GEOMETRY,
    VIEW,
    Factor,
    Parameter,
    Reflectance,
    diffuse,
    fluorescence,
    fresnel,
    h_dot_v,
    lobe,
    mirror,
    n_dot_h,
    n_dot_l,
    n_dot_v,
    parameter,
    r_dot_v,
    reflectance,
    specular,
    transmission,
)
from symrt.symbols import FLUORESCENCE, fluoresces

ZERO = sympy.Integer(0)

DOUBLE = 53
"""Binary digits of a float."""
WORDS = {*GEOMETRY, *FRESNEL, "diffuse", "specular", "mirror", FLUORESCENCE}
"""Names of the symbols that formulas are written in, as they are imported."""
INDEX = "index"
"""The parameter that tells the refractive index; rays have been bent by it, so that it is no symbol of a formula."""
LIT = ("direct", "ambient", "emitted")
"""The formulas that lights meet, or that surfaces shine by; others meet the radiance of further rays."""
INSIDE = "inside"
"""The formula that light meets on its way through the material, not at its surface."""


@dataclass(frozen=True)
class Model:
    """A model of reflection: formulas in reflectances, geometric factors and parameters.

    A formula that is not zero calls for its effect: ``reflected`` makes the tracer follow mirrored rays.

    Parameters
    ----------
    direct
        Radiance towards the viewer per unit irradiance on a surface that faces the light.
    ambient
        Radiance towards the viewer per unit radiance of an ambient light.
    reflected
        Share of the radiance from along the mirrored view that is sent on to the viewer.
    transmitted
        Share of the radiance from along the refracted view, on the other side of the surface, that is sent on.  A
        material with this formula has the parameter ``index``, its refractive index, and its shapes are closed.
    emitted
        Radiance that the surface sends to the viewer by itself, per unit of the symbol of a `SurfaceLight`.
    inside
        The reflectance that is the material's transmittance per unit length: what goes a length d through it is left
        with its power d.  The material must let light in.

    Raises
    ------
    ValueError
        If a formula is not polynomial in its reflectances, or uses a symbol that no tracer provides.

    Examples
    --------
    >>> Model(direct=diffuse * n_dot_l / pi, ambient=diffuse).components
    frozenset({'diffuse'})
    """

    direct: Any = ZERO
    ambient: Any = ZERO
    reflected: Any = ZERO
    transmitted: Any = ZERO
    emitted: Any = ZERO
    inside: Any = ZERO

    def __post_init__(self) -> None:
        for field in fields(self):
            formula = _as_expression(field.name, getattr(self, field.name))
            object.__setattr__(self, field.name, formula)
            _check(field.name, formula)

    @property
    def formulas(self) -> dict[str, sympy.Expr]:
        """The formulas by the name of their field."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def components(self) -> frozenset[str]:
        """Names of the reflectances that a material with this model has."""
        return self._names(Reflectance)

    @cached_property
    def fluorescent(self) -> frozenset[str]:
        """Names of those of its reflectances that move light from wavelength to wavelength."""
        return frozenset(filter(fluoresces, self.components))

    @cached_property
    def parameters(self) -> frozenset[str]:
        """Names of the scalars that a material with this model must give."""
        return self._names(Parameter) | ({INDEX} if self.refracts else frozenset())

    @cached_property
    def refracts(self) -> bool:
        """Whether light goes through, or is mirrored as Fresnel's formulas say: a refractive index is needed."""
        return self.transmitted != 0 or not FRESNEL.isdisjoint(self.factors)

    @cached_property
    def factors(self) -> frozenset[str]:
        """Names of the geometric factors that the tracer must compute; it computes no others."""
        return self._names(Factor)

    @cached_property
    def sending(self) -> frozenset[str]:
        """Names of the formulas, other than zero, by which the model sends on the radiance of further rays."""
        return frozenset(name for name, formula in self.formulas.items() if _sends(name) and monomials(formula))

    @cached_property
    def always_there(self) -> bool:
        """True if a term of some formula names no reflectance: no spectrum of the material takes it away."""
        return any(() in monomials(formula) for formula in self.formulas.values())

    def sent_on(self, gathered: Collection[str] = ()) -> sympy.Expr:
        """The share of what further rays bring that is sent on, by all formulas together, if all brought the same.

        Parameters
        ----------
        gathered
            Formulas of lights, ``direct`` or ``ambient``, by which rays are sent on, too.  By ``direct`` a surface
            sends on the irradiance of its rays, at most π times their radiance: a diffuser's albedo.
        """
        total = sympy.Add(*(formula for name, formula in self.formulas.items() if _sends(name)))
        total += self.ambient if "ambient" in gathered else ZERO
        if "direct" in gathered:
            total += pi * (sympy.diff(self.direct, n_dot_l) if self.diffusing else self.direct)
        return total.xreplace({transmission: 1 - fresnel})

    @cached_property
    def diffusing(self) -> bool:
        """True if `direct` is n_dot_l times what is the same for all directions to the light.

        Light from several directions then adds up to light from one, that of its vector irradiance.
        """
        slope = sympy.diff(self.direct, n_dot_l)
        lights = {factor for factor in slope.atoms(Factor) if factor.name not in VIEW}
        return not lights and sympy.expand(self.direct - slope * n_dot_l) == 0

    def _names(self, kind: type[sympy.Symbol]) -> frozenset[str]:
        return frozenset(symbol.name for formula in self.formulas.values() for symbol in formula.atoms(kind))

    def _repr_latex_(self) -> str:
        lines = (rf"\text{{{name}}} &= {sympy.latex(f)}" for name, f in self.formulas.items() if f != 0)
        return r"$\begin{aligned}" + r" \\ ".join(lines) + r"\end{aligned}$"


def _sends(field: str) -> bool:
    return field not in (*LIT, INSIDE)


FORMULAS = tuple(field.name for field in fields(Model))
"""The names of a model's formulas."""


def stack(models: Iterable[Model]) -> Model:
    """The sum of several models, formula by formula; components of one name are shared.

    Examples
    --------
    >>> stack([MODELS["lambert"], MODELS["mirror"]]).reflected
    mirror
    """
    models = list(models)
    if not models:
        raise ValueError("a material needs at least one model, such as 'lambert'")
    return Model(**{name: sympy.Add(*(m.formulas[name] for m in models)) for name in models[0].formulas})


def _as_expression(field: str, formula: object) -> sympy.Expr:
    if isinstance(formula, np.number):
        formula = float(formula)
    if isinstance(formula, int | float):
        return sympy.Integer(formula) if isinstance(formula, int) else sympy.Float(formula)
    # A string is refused, not parsed: SymPy's parser evaluates what it reads.
    if not isinstance(formula, sympy.Expr):
        raise ValueError(f"{field} = {formula!r}: a formula is a SymPy expression, such as diffuse * n_dot_l / pi")  # noqa: TRY004
    return formula


def _check(field: str, formula: sympy.Expr) -> None:
    # Functions and numbers must have real values, to the last bit of a float.
    if unknown := formula.atoms(AppliedUndef, type(sympy.I)):
        shown = ", ".join(sorted(map(str, unknown)))
        raise ValueError(f"{field} = {formula}: {shown} has no real value; write it in functions that SymPy knows")
    if short := sorted(str(number) for number in formula.atoms(sympy.Float) if number._prec < DOUBLE):  # noqa: SLF001
        raise ValueError(
            f"{field} = {formula}: {', '.join(short)} has fewer digits than a float, as NumPy's float32 has, and so "
            "has what is computed with it: write float(x)"
        )

    # Symbols must be of a known kind, and factors computable where the formula is used.
    known = {name for stem in GEOMETRY for name in (stem, f"one_minus_{stem}")} | FRESNEL
    for symbol in sorted(formula.free_symbols, key=str):
        if type(symbol) is sympy.Symbol and symbol.name in WORDS:
            raise ValueError(
                f"{field} = {formula}: {symbol} is a plain symbol of SymPy's: import it, from symrt.reflection import "
                f"{symbol}"
            )
        if not isinstance(symbol, Reflectance | Factor | Parameter):
            raise ValueError(  # noqa: TRY004 -- a bad formula is a bad value
                f"{field} = {formula}: {symbol} is neither a reflectance, a geometric factor nor a parameter; use "
                "reflectance(name), parameter(name) or one of " + ", ".join(GEOMETRY)
            )
        if isinstance(symbol, Factor) and symbol.name not in known:
            raise ValueError(f"{field} = {formula}: no tracer computes {symbol}; the factors are {', '.join(GEOMETRY)}")
        if symbol.name in FRESNEL and isinstance(symbol, Factor) and field in LIT:
            raise ValueError(f"{field} = {formula}: {symbol} is a ray's; use it in reflected or transmitted")
        if isinstance(symbol, Factor) and field != "direct" and symbol.name not in VIEW | FRESNEL:
            raise ValueError(f"{field} = {formula}: {symbol} needs a light; only n_dot_v is known here")

    # The formula must be a polynomial in its reflectances; a power of any length is known of a single one only.
    _check_order(field, formula)
    if field == INSIDE and formula != 0 and not isinstance(formula, Reflectance):
        raise ValueError(
            f"{field} = {formula}: it is one reflectance, the transmittance per unit length, such as "
            "reflectance('transmittance')"
        )


def _check_order(field: str, formula: sympy.Expr) -> None:
    """Refuse products with a matrix: SymPy sorts their factors, and light meets them in one order."""
    for met in monomials(formula):
        if len(met) > 1 and (matrices := list(filter(fluoresces, met))):
            raise ValueError(
                f"{field} = {formula}: {'*'.join(met)} is a product with {matrices[0]}, a matrix, and a formula does "
                "not tell its order; give the layers surfaces of their own, or add the components up"
            )


_exponent = parameter("exponent")
_f0, _f82 = reflectance("f0"), reflectance("f82")

MODELS = {
    "lambert": Model(direct=diffuse * n_dot_l / pi, ambient=diffuse),
    "phong": Model(
        direct=diffuse * n_dot_l / pi + specular * (_exponent + 2) / (2 * pi) * lobe(r_dot_v, _exponent) * n_dot_l,
        ambient=diffuse,
    ),
    # The paper's: diffuse and specular share the white of a perfect diffuser, and neither is normalised.
    "phong_plain": Model(direct=(diffuse * n_dot_l + specular * lobe(r_dot_v, _exponent)) / pi, ambient=diffuse),
    "blinn_phong": Model(
        direct=diffuse * n_dot_l / pi + specular * (_exponent + 8) / (8 * pi) * lobe(n_dot_h, _exponent) * n_dot_l,
        ambient=diffuse,
    ),
    # Paint that gives light back at other wavelengths, stacked on one that reflects: ["lambert", "fluorescent"].
    "fluorescent": Model(direct=fluorescence * n_dot_l / pi, ambient=fluorescence),
    "mirror": Model(reflected=mirror),
    # A surface that glows, the same in all directions; to stack on one that reflects.
    "emitter": Model(emitted=1),
    # Clear glass or water, smooth: what is not mirrored goes on, bent.
    "glass": Model(reflected=fresnel, transmitted=transmission),
    # Light on its way through glass, to stack on it: ["glass", "absorption"].
    "absorption": Model(inside=reflectance("transmittance")),
    # Polished metals: a mirror with Fresnel's reflectance, white along its edge.
    "metal": Model(reflected=schlick(_f0, n_dot_v)),
    "metal_f82": Model(reflected=f82(_f0, _f82, n_dot_v)),
    # A metal's highlight of lights, which a mirror sees nowhere; stacked on a polished one they share their f0.
    "rough_metal": Model(
        direct=(_exponent + 8) / (8 * pi) * lobe(n_dot_h, _exponent) * schlick(_f0, h_dot_v) * n_dot_l
    ),
}
"""The models a scene file may name."""
