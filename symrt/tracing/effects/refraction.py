"""Refraction: at glass a view goes on along two ways, mirrored and bent (an effect of step 1).

The shares are Fresnel's; what is mirrored and what goes through is all of it.  A branch that carries less of its film
sample's light than the plan's tolerance is not followed: it is bounded in the tail, as what is beyond the depth.

Outside of glass is air, of index 1.  Light that glass bends onto other surfaces is another effect, caustics: for
lights glass hides what is behind it.  Rays carry basic radiance, L/n², which is what leaves the glass again; a matte
surface inside of solid glass is seen brighter than it is by the index squared.
"""

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerRay, dot, normalise
from symrt.geometry.rays import Rays, spawn
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import CARRIED, Call, Effect, Sent
from symrt.tracing.factors import reflect
from symrt.tracing.raytree import Points
from symrt.tracing.refracting import Interface, interface
from symrt.tracing.stage import Alternatives, Stage, refracting
from symrt.tracing.view import View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    return Call(
        refracting(scene, alternatives),
        without="no material is of glass",
        rays=f"2 a hit, {scene.depth} deep",
        left_out="" if scene.depth else "the depth is 0",
        onwards=1,  # of two ways the weaker is soon not worth following
    )


def _onwards(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Sent, ...]:
    """Rays along the mirrored and along the bent view, of each material of glass."""
    found: list[Sent] = []
    for part in points:
        record = stage.materials[part.material]
        if record.model.refracts:
            met = interface(*_seen(view, part.hit), _eta(view, part.hit, record.parameters["index"]))
            found += _mirrored(view, part, met) if "reflected" in record.model.sending else []
            found += _bent(view, part, met) if "transmitted" in record.model.sending else []
    return tuple(found)


def _seen(view: View, hit: Which) -> tuple[Float[np.ndarray, "3 hit"], Float[np.ndarray, "3 hit"]]:
    return view.shading_normal[:, hit], view.viewer[:, hit]


def _eta(view: View, hit: Which, index: float) -> PerRay:
    """The index on the viewer's side over that on the other: the surface's own normal points out of the glass."""
    outside = dot(view.surface.normal[:, hit], view.viewer[:, hit]) > 0
    return np.where(outside, 1 / index, index)


def _mirrored(view: View, part: Points, met: Interface) -> tuple[Sent, ...]:
    """Rays along the mirrored view; a smoothed normal may send it into the surface, where there is nothing to see."""
    normal, viewer = _seen(view, part.hit)
    direction = reflect(viewer, normal)
    good = (dot(direction, view.normal[:, part.hit]) > 0) & (met.mirrored > 0)
    return _sent("reflected", view, part, good, direction, met)


def _bent(view: View, part: Points, met: Interface) -> tuple[Sent, ...]:
    """Rays along the bent view, where any light goes through."""
    good = (dot(met.bent, view.normal[:, part.hit]) < 0) & (met.through > 0)
    return _sent("transmitted", view, part, good, met.bent, met)


def _sent(
    via: str,
    view: View,
    part: Points,
    good: Bool[np.ndarray, " hit"],
    direction: Float[np.ndarray, "3 hit"],
    met: Interface,
) -> tuple[Sent, ...]:
    """The rays of one way; a texture's weight is a share of what they carry, too."""
    share = met.mirrored if via == "reflected" else met.through
    chosen = np.flatnonzero(good)
    if not chosen.size:
        return ()
    hit, materials = part.hit[chosen], frozenset({part.material})
    factors = {"fresnel": met.mirrored[chosen], "transmission": met.through[chosen]}
    rays = _spawned(view, hit, direction[:, chosen])
    carried = part.weight[chosen] * share[chosen]
    return (Sent(via, hit, rays, np.ones(chosen.size), factors, materials=materials, share=carried),)


def _spawned(view: View, hit: Which, direction: Float[np.ndarray, "3 hit"]) -> Rays:
    surface = view.surface
    place = surface.point[:, hit], view.normal[:, hit], surface.error[hit]
    return spawn(*place, normalise(direction), view.leaving[:, hit])


REFRACTION = Effect("refraction", _call, onwards=_onwards, state={CARRIED: 1.0})
