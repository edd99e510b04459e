"""Parameters of the feedback: step 5 of the paper.

A parameter is one number ``t`` that moves some of a palette's spectra along straight lines: a scale from nothing
(t = 0) to the palette's own spectra (t = 1) and beyond, a blend from one material (t = 0) to another (t = 1).
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from symrt.arrays import Spectrum
from symrt.errors import require
from symrt.feedback.mixing import Mixing, check_paints, mixed
from symrt.spectra.bands import Number
from symrt.spectra.fluorescence import Matrix, sent_on
from symrt.spectra.palette import Palette, did_you_mean, overdrawn
from symrt.symbols import Surface, Symbol, named
from symrt.system import LinearSystem

Ends = tuple[Spectrum, Spectrum] | tuple[Matrix, Matrix]


@dataclass(frozen=True)
class Scale:
    """A factor on a light ``"key"``, on all components of a material ``"brass"``, or on one ``"brass.specular"``."""

    name: str

    def __str__(self) -> str:
        return f"scale of {self.name}"


@dataclass(frozen=True)
class Blend:
    """``material`` painted over with ``other``: its spectra become (1 − t) · its own + t · the other's.

    With ``mixing="kubelka-munk"`` both are paints, stirred together: their K/S mixes so, not their reflectances.
    """

    material: str
    other: str
    mixing: Mixing | str = "linear"

    def __post_init__(self) -> None:
        if self.mixing not in get_args(Mixing):
            raise ValueError(f"mixing = {self.mixing!r}: there are {' and '.join(map(repr, get_args(Mixing)))}")

    def __str__(self) -> str:
        how = "" if self.mixing == "linear" else ", mixed as paints"
        return f"blend from {self.material} to {self.other}{how}"


@dataclass(frozen=True)
class Exposure:
    """A factor on all lights at once, against the same reference white."""

    def __str__(self) -> str:
        return "exposure"


Parameter = Scale | Blend | Exposure


def moved(system: LinearSystem, palette: Palette, parameter: Parameter, value: Number) -> Palette:
    """The palette at one value of a parameter; if a reflectance then passes 1 it is marked as unphysical.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("1*key*sea.diffuse", white={"key": 1.0})
    >>> moved(system, Palette(RGB, {"key": 1, "sea.diffuse": [0.1, 0.2, 0.4]}), Scale("sea"), 2)["sea.diffuse"]
    array([0.2, 0.4, 0.8])
    """
    ends, mixing = moved_ends(system, palette, parameter), mixing_of(parameter)
    spectra = {name: mixed(first, last, value, mixing) for name, (first, last) in ends.items()}
    return with_spectra(palette, spectra)


def with_spectra(palette: Palette, spectra: Mapping[str, Spectrum | Matrix]) -> Palette:
    """A palette with other spectra, allowed above 1."""
    given = {name: sent_on(values, palette.bands) for name, values in spectra.items() if Symbol.of(name).reflectance}
    above = any(bool(values.max() > 1) for values in given.values())
    if palette.fluorescent and not above:
        # Fluorescent paints share the light with the other components of their material.
        factors = {name: palette[name] for name in palette} | dict(spectra)
        above = any(True for _ in overdrawn(factors, palette.bands))
    return replace(palette, spectra={**palette.spectra, **spectra}, unphysical=palette.unphysical or above)


def moved_ends(system: LinearSystem, palette: Palette, parameter: Parameter) -> dict[str, Ends]:
    """For each symbol that the parameter moves, its spectra at t = 0 and t = 1."""
    require("parameter", parameter, (Scale, Blend, Exposure), "Scale('brass'), Blend('sea', 'ice') or Exposure()")
    if isinstance(parameter, Blend):
        return _blend_ends(system, palette, parameter)
    names = system.lights if isinstance(parameter, Exposure) else scaled_symbols(system, palette, parameter)
    return {name: (np.zeros_like(palette[name]), palette[name]) for name in names if name in palette}


def mixing_of(parameter: Parameter) -> Mixing:
    """The mixing law between the spectra that a parameter moves, at t = 0 and at t = 1."""
    return "kubelka-munk" if isinstance(parameter, Blend) and parameter.mixing == "kubelka-munk" else "linear"


def ends_owners(ends: Collection[str], parameter: Parameter) -> dict[str, tuple[str, str]]:
    """For each symbol that the parameter moves, the symbols whose spectra it has at t = 0 and t = 1.

    Examples
    --------
    >>> ends_owners(["sea.diffuse", "sea>ice.mirror"], Blend("sea", "ice"))
    {'sea.diffuse': ('sea.diffuse', 'ice.diffuse'), 'sea>ice.mirror': ('sea.mirror', 'ice.mirror')}
    """
    if not isinstance(parameter, Blend):
        return {name: (name, name) for name in ends}
    own, other = parameter.material, parameter.other
    components = {name: Symbol.of(name).component for name in ends}
    return {name: (named(own, component), named(other, component)) for name, component in components.items()}


def scaled_symbols(system: LinearSystem, palette: Palette, parameter: Scale) -> tuple[str, ...]:
    """The symbols that a scale multiplies: a light, a component, or all components of a material."""
    symbols = sorted({*system.lights, *system.symbols, *palette})
    found = [s for s in symbols if parameter.name and parameter.name in (s, Symbol.of(s).material)]
    if not found:
        whole = sorted({Symbol.of(s).light or Symbol.of(s).material for s in symbols})
        near = did_you_mean([parameter.name], sorted({*symbols, *whole}))
        there = "" if "did you mean" in near else f"; there are {', '.join(whole)}"
        raise ValueError(
            f"nothing to scale is called {near}: name a light, a material, or one component of it such as "
            f"'brass.specular'{there}"
        )
    return tuple(found)


def _blend_ends(system: LinearSystem, palette: Palette, blend: Blend) -> dict[str, Ends]:
    """The ends of a blend, component by component, on the material's own geometry or the other's traced columns."""
    if blend.material == blend.other:
        raise ValueError(f"a blend of {blend.material} with itself changes nothing: name two materials")

    # With columns of its own the other material comes from nothing, and the material goes to nothing.
    own, other = (_components(system, palette, name) for name in (blend.material, blend.other))
    added = Surface(blend.other, instead_of=blend.material)
    paints = blend.mixing == "kubelka-munk"
    traced = str(added) in system.models or any(Symbol.of(name).surface == added for name in system.reflectances)
    if traced and not paints:
        spectra = [
            {c: palette[named(name, c)] for c in part} for name, part in ((blend.material, own), (blend.other, other))
        ]
        return {named(blend.material, c): (spectrum, np.zeros_like(spectrum)) for c, spectrum in spectra[0].items()} | {
            named(str(added), c): (np.zeros_like(spectrum), spectrum) for c, spectrum in spectra[1].items()
        }

    # On the same columns both must have the same components and the same model.
    models = [system.models.get(name, "no model on record") for name in (blend.material, blend.other)]
    if own != other or models[0] != models[1]:
        described = " and ".join(
            f"{name} ({', '.join(sorted(components))}; {model})"
            for name, components, model in zip((blend.material, blend.other), (own, other), models, strict=True)
        )
        if paints:
            raise ValueError(f"{described} differ in more than their spectra: only a 'linear' blend joins them")
        raise ValueError(
            f"{described} differ in more than their spectra: trace(scene, alternatives="
            f'{{"{blend.material}": ["{blend.other}"]}}) adds the columns that the blend needs'
        )

    ends = {named(blend.material, c): (palette[named(blend.material, c)], palette[named(blend.other, c)]) for c in own}
    if paints:
        for name, (first, last) in ends.items():
            if Symbol.of(name).fluorescent:
                raise ValueError(
                    f"{name}: Kubelka and Munk's theory mixes bands one by one, and it moves light between "
                    "them: mix 'linear'"
                )
            check_paints(first, last, name)
    return ends


def _components(system: LinearSystem, palette: Palette, material: str) -> frozenset[str]:
    symbols = [Symbol.of(name) for name in {*system.reflectances, *palette.reflectances}]
    own = [symbol for symbol in symbols if not symbol.alternative]
    found = frozenset(symbol.component for symbol in own if symbol.material == material)
    if not found:
        known = sorted({symbol.material for symbol in own})
        near = did_you_mean([material], known)
        there = "" if "did you mean" in near else f"; there are {', '.join(known)}"
        raise ValueError(f"no material is called {near}: a blend joins two materials{there}")
    return found
