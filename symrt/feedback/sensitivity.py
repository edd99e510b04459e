"""Sensitivities of a limit to each other parameter: step 5 of the paper, the dual values of one range.

At the end t of a range some pixel meets some slab, ``F(t, s) = bound``, where s, 1 now, scales a light or a material
against the same reference white.  So that the pixel stays on the bound, t follows with

    d ln t / d ln s = −(s ∂F/∂s) / (t ∂F/∂t)        (a scale, the exposure)        dt / d ln s        (a blend)

Both derivatives are inner products with the gradient of F by the spectra of the palette, which is taken once.

A derivative is that of one pixel: a little further on another pixel may stop the parameter.  So it only says which
parameters to ask about; put into words is the move of the limit when the range is asked for again with one of them at
0.99, against the same white.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symrt.arrays import Spectrum
from symrt.feedback.mixing import slopes
from symrt.feedback.parameters import (
    Blend,
    Exposure,
    Parameter,
    Scale,
    ends_owners,
    mixing_of,
    moved,
    moved_ends,
)
from symrt.interactions import Interaction
from symrt.spectra.bands import Number
from symrt.spectra.fluorescence import Matrix, times
from symrt.spectra.hats import hats
from symrt.spectra.palette import Palette
from symrt.spectra.powers import power_of
from symrt.symbols import Symbol
from symrt.system import LinearSystem

Gradient = Mapping[str, Spectrum | Matrix]
SHOWN = 3
"""Parameters that are asked about again, those whose derivatives are largest."""
LESS = 0.99
"""The value that they are set to."""
SEEN = 5e-7
"""Moves smaller than this are rounding, and are not put into words."""


@dataclass(frozen=True)
class Sensitivity:
    """The derivative of a limit by another parameter, as long as the same pixel stops it.

    Parameters
    ----------
    parameter
        The scale of a light or a material, or the exposure.
    change
        Relative change of the limit for a small relative change of that parameter; −1: 1 % more lowers it by 1 %.
        If the limit is of a blend, its absolute change instead: −0.5: 1 % more lowers it by 0.005.
    """

    parameter: Scale | Exposure
    change: float

    @property
    def name(self) -> str:
        """The light, the material or the exposure."""
        return _called(self.parameter)


def sensitivities(
    system: LinearSystem, palette: Palette, parameter: Parameter, t: Number, pixel: int, slab: Spectrum
) -> tuple[Sensitivity, ...]:
    """The sensitivities of a limit to each other parameter, largest first; those that are zero are left out.

    Parameters
    ----------
    t
        The limit.
    pixel
        The pixel that meets a bound there.
    slab
        Weights of each band in the quantity bounded, of any size.

    Returns
    -------
    tuple
        None of them where the pixel only touches the bound, so that t cannot follow, or where a scale ends at 0, of
        which there are no shares.

    Examples
    --------
    Half of the light on the pixel is the sun's; if it grows by 1 %, the sea may be 0.5 % lighter at most:

    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.25*sky*sea.diffuse + 0.25*sun*sea.diffuse", white={"sky": 1.0, "sun": 1.0})
    >>> palette = Palette(RGB, {"sky": 1, "sun": 1, "sea.diffuse": 0.8})
    >>> found = sensitivities(system, palette, Scale("sea"), 2.5, pixel=0, slab=np.array([0.0, 1.0, 0.0]))
    >>> [(one.name, one.change) for one in found]
    [('exposure', -1.0), ('sky', -0.5), ('sun', -0.5)]
    """
    # Take the gradient of F by the spectra, and its derivative by t; without one t cannot follow.
    gradient = _gradient(system, moved(system, palette, parameter, t), pixel, slab)
    spectra = {name: palette[name] for name in gradient if name in palette}
    ends = moved_ends(system, palette, parameter)
    owners = ends_owners(ends, parameter)
    changes = {name: slopes(first, last, t, mixing_of(parameter)) for name, (first, last) in ends.items()}
    moving = _sum(gradient, {name: by_t for name, (by_t, _, _) in changes.items()})
    if moving == 0 or (t == 0 and not isinstance(parameter, Blend)):
        return ()
    own = frozenset(ends) if not isinstance(parameter, Blend) else frozenset()

    # Another parameter moves the spectra at rest, and the ends between which the parameter itself moves.
    found = []
    for other, symbols in _others(system, palette, own).items():
        still = {name: spectrum for name, spectrum in spectra.items() if name in symbols and name not in ends}
        for name, (_, by_first, by_last) in changes.items():
            first, last = owners[name]
            still[name] = (first in symbols) * by_first + (last in symbols) * by_last

        change = -_sum(gradient, still) / (moving if isinstance(parameter, Blend) else moving * t)
        if change != 0:
            found.append(Sensitivity(other, float(change)))
    return tuple(sorted(found, key=lambda one: -abs(one.change)))


@dataclass(frozen=True)
class Move:
    """The move of a limit when the range is asked for again with another parameter at 0.99.

    Parameters
    ----------
    parameter
        The scale of a light or a material, or the exposure.
    change
        Of the limit, relative to it; if the limit is of a blend, the difference.
    """

    parameter: Scale | Exposure
    change: float

    @property
    def name(self) -> str:
        """The light, the material or the exposure."""
        return _called(self.parameter)


def sentence(found: Collection[Move], side: str, *, absolute: bool) -> str:
    """The moves of a limit in words, empty if nothing moves it.

    Examples
    --------
    >>> sentence([Move(Scale("sun"), 0.008), Move(Exposure(), -0.0025)], "upper", absolute=False)
    'Against the same white, 1 % less sun moves the upper limit by +0.8 %, 1 % less exposure by -0.25 %.'
    """
    parts = [
        f"1 % less {one.name}{'' if k else f' moves the {side} limit'} by "
        + (f"{one.change:+.3g}" if absolute else f"{100 * one.change:+.3g} %")
        for k, one in enumerate(sorted(found, key=lambda one: -abs(one.change)))
        if abs(one.change) >= SEEN
    ]
    return f"Against the same white, {', '.join(parts)}." if parts else ""


def _called(parameter: Scale | Exposure) -> str:
    return parameter.name if isinstance(parameter, Scale) else "exposure"


def _gradient(system: LinearSystem, palette: Palette, pixel: int, slab: Spectrum) -> Gradient:
    """∂F/∂X of every spectrum X that the pixel depends on."""
    found: dict[str, Any] = defaultdict(float)
    for interaction, g in system.terms(pixel):
        if not all(name in palette for name in interaction.names):  # an alternative that is no part of the picture
            continue
        if any(palette[name].ndim == 2 for name in interaction.met):
            for name, part in _in_order(interaction, palette, slab * g):
                found[name] = found[name] + part
            continue
        # A transmittance's power of d is as its product with itself, d times.
        factors = [*((name, 1.0) for name in interaction.symbols), *interaction.powers]
        for k, (name, length) in enumerate(factors):
            others = (*factors[:k], *factors[k + 1 :])
            rest = [*hats([interaction], palette.bands)]
            rest += [palette[n] if d == 1 else power_of(palette, (n, d)) for n, d in others]
            if length != 1:
                # Where nothing comes through a factor on it changes nothing, however steep the power is there.
                some = np.where(palette[name] > 0, palette[name], 1.0)
                rest.append(np.where(palette[name] > 0, length * some ** (length - 1), 0.0))
            found[name] = found[name] + np.prod([slab * g, *rest], axis=0)
    return dict(found)


def _in_order(interaction: Interaction, palette: Palette, slab: Spectrum) -> Iterator[tuple[str, Spectrum | Matrix]]:
    """The gradient of a product with matrices by each factor: light in front of it, times what weighs what leaves it.

    ``F = x₁ ⋯ x_n · slab``, with ∂F/∂x = front · behind for a spectrum and ∂F/∂M_ij = front_i behind_j for a matrix.
    """
    # Glass and windows are next to the eye.
    left = [power_of(palette, power) for power in interaction.powers]
    names = interaction.symbols
    factors: list[Spectrum | Matrix] = [palette[name] for name in names]
    front = [np.ones((1, len(slab)))]
    for factor in factors:
        front.append(times(front[-1], factor))
    behind = np.prod([slab, *hats([interaction], palette.bands), *left], axis=0)
    for k, (name, length) in enumerate(interaction.powers):
        some = np.where(palette[name] > 0, palette[name], 1.0)
        steep = np.where(palette[name] > 0, length * some ** (length - 1), 0.0)
        rest = [slab, *hats([interaction], palette.bands), *left[:k], *left[k + 1 :]]
        yield name, front[-1][0] * np.prod([steep, *rest], axis=0)
    for name, light, factor in zip(reversed(names), reversed(front[:-1]), reversed(factors), strict=True):
        yield name, light[0] * behind if factor.ndim == 1 else np.outer(light[0], behind)
        behind = factor * behind if factor.ndim == 1 else factor @ behind


def _others(system: LinearSystem, palette: Palette, own: frozenset[str]) -> dict[Scale | Exposure, frozenset[str]]:
    """The lights, the materials and the exposure with the spectra that each scales, but none that scales the same."""
    lights = [name for name in system.lights if name in palette]
    groups: dict[Scale | Exposure, frozenset[str]] = {Scale(name): frozenset([name]) for name in lights}
    for material in sorted({Symbol.of(name).material for name in palette.reflectances}):
        groups[Scale(material)] = frozenset(n for n in palette if Symbol.of(n).material == material)
    if len(lights) > 1:
        groups[Exposure()] = frozenset(lights)
    used = {*system.lights, *system.reflectances}
    return {other: symbols for other, symbols in groups.items() if symbols & used != own & used or not own}


def _sum(gradient: Gradient, change: Gradient) -> float:
    return float(sum(gradient[n].ravel() @ changed.ravel() for n, changed in change.items() if n in gradient))
