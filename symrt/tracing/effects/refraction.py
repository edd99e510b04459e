"""Refraction: at glass a view goes on along two ways, mirrored and bent (an effect of step 1).

The shares are Fresnel's; what is mirrored and what goes through is all of it.  A branch that carries less of its film
sample's light than the plan's tolerance is not followed: it is bounded in the tail, as what is beyond the depth.

Where the index changes with the wavelength, a view that meets such glass goes on once for each window of wavelengths,
by the index at its centre, and stays in that window: see `dispersion`.

Outside of glass is air, of index 1.  Light that glass bends onto other surfaces is another effect, caustics: for
lights glass hides what is behind it.  Rays carry basic radiance, L/n², which is what leaves the glass again; a matte
surface inside of solid glass is seen brighter than it is by the index squared.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerRay, dot, normalise, reflect
from symrt.geometry.rays import Rays, spawn
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import CARRIED, Call, Effect, Sent
from symrt.tracing.raytree import MaterialRecord, Points
from symrt.tracing.refracting import Interface, interface
from symrt.tracing.stage import Alternatives, Stage, refracting
from symrt.tracing.view import WINDOW, View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    return Call(
        refracting(scene, alternatives),
        without="no material is of glass",
        rays=f"2 a hit, {scene.depth} deep",
        left_out="" if scene.depth else "the depth is 0",
        onwards=1,  # of two ways the weaker is soon not worth following
    )


@dataclass(frozen=True, eq=False)
class Meeting:
    """Views that meet one material of glass; a hit stands once for each window that its view is split into.

    Parameters
    ----------
    weight
        The share of the material at the hit.
    index
        Of the glass, one for all views or one for each.
    state
        The window of each view, where there are any.
    """

    material: str
    hit: Which
    weight: PerRay
    index: float | PerRay
    state: Mapping[str, Which] = field(default_factory=dict)


def _onwards(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Sent, ...]:
    """Rays along the mirrored and along the bent view, of each material of glass."""
    found: list[Sent] = []
    for part in points:
        record = stage.materials[part.material]
        if record.model.refracts:
            meeting = _split(view, part, record)
            met = interface_of(view, meeting)
            found += _mirrored(view, meeting, met) if "reflected" in record.model.sending else []
            found += _bent(view, meeting, met) if "transmitted" in record.model.sending else []
    return tuple(found)


def _split(view: View, part: Points, record: MaterialRecord) -> Meeting:
    """The views at the points of one material, those of no window yet split where its index changes with wavelength."""
    if WINDOW not in view.state or not record.indices:
        return Meeting(part.material, part.hit, part.weight, record.parameters["index"])
    window = view.state[WINDOW][part.hit]
    count = np.where(window < 0, len(record.indices), 1)
    which = np.repeat(np.arange(part.hit.size), count)
    within = np.arange(which.size) - np.repeat(np.cumsum(count) - count, count)
    window = np.where(window[which] < 0, within, window[which])
    indices = np.array(record.indices)[window]
    return Meeting(part.material, part.hit[which], part.weight[which], indices, {WINDOW: window})


def interface_of(view: View, meeting: Meeting) -> Interface:
    """The ways on of views that meet glass, and Fresnel's shares."""
    return interface(*_seen(view, meeting.hit), _eta(view, meeting.hit, meeting.index))


def _seen(view: View, hit: Which) -> tuple[Float[np.ndarray, "3 hit"], Float[np.ndarray, "3 hit"]]:
    return view.shading_normal[:, hit], view.viewer[:, hit]


def _eta(view: View, hit: Which, index: float | PerRay) -> PerRay:
    """The index on the viewer's side over that on the other: the surface's own normal points out of the glass."""
    outside = dot(view.surface.normal[:, hit], view.viewer[:, hit]) > 0
    return np.where(outside, 1 / index, index)


def _mirrored(view: View, meeting: Meeting, met: Interface) -> tuple[Sent, ...]:
    """Rays along the mirrored view; a smoothed normal may send it into the surface, where there is nothing to see."""
    normal, viewer = _seen(view, meeting.hit)
    direction = reflect(viewer, normal)
    good = (dot(direction, view.normal[:, meeting.hit]) > 0) & (met.mirrored > 0)
    return _sent("reflected", view, meeting, good, direction, met)


def _bent(view: View, meeting: Meeting, met: Interface) -> tuple[Sent, ...]:
    """Rays along the bent view, where any light goes through."""
    good = (dot(met.bent, view.normal[:, meeting.hit]) < 0) & (met.through > 0)
    return _sent("transmitted", view, meeting, good, met.bent, met)


def _sent(
    via: str,
    view: View,
    meeting: Meeting,
    good: Bool[np.ndarray, " hit"],
    direction: Float[np.ndarray, "3 hit"],
    met: Interface,
) -> tuple[Sent, ...]:
    """The rays of one way; a texture's weight is a share of what they carry, too."""
    share = met.mirrored if via == "reflected" else met.through
    chosen = np.flatnonzero(good)
    if not chosen.size:
        return ()
    hit, materials = meeting.hit[chosen], frozenset({meeting.material})
    factors = {"fresnel": met.mirrored[chosen], "transmission": met.through[chosen]}
    rays = _spawned(view, hit, direction[:, chosen])
    carried = meeting.weight[chosen] * share[chosen]
    state = {name: values[chosen] for name, values in meeting.state.items()}
    return (Sent(via, hit, rays, np.ones(chosen.size), factors, state, materials, carried),)


def _spawned(view: View, hit: Which, direction: Float[np.ndarray, "3 hit"]) -> Rays:
    surface = view.surface
    place = surface.point[:, hit], view.normal[:, hit], surface.error[hit]
    return spawn(*place, normalise(direction), view.leaving[:, hit])


REFRACTION = Effect("refraction", _call, onwards=_onwards, state={CARRIED: 1.0})
