"""Emission: surfaces and lamps that are seen to shine, directly, in mirrors and through glass (an effect of step 1).

A pixel gets ``L`` times the formula ``emitted`` of a surface, or the ``L`` of a lamp, with no reflectance on the way: a
column of degree 0.  Surfaces send their light as `Lit` by that formula.  Lamps, which have no material, send it as
`Emitted`; what they send to a surface is sampled there already, so that rays along which a surface gathers light do not
meet it a second time.  No ray is cast for any of it, and no other surface is lit by it.
"""

import numpy as np

from symrt.arrays import dot
from symrt.scene.records import Scene
from symrt.scene.surface_lights import SurfaceLight
from symrt.scene.wide_lights import AreaLight
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.raytree import Emitted
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    met = {*scene.used_materials, *(name for others in alternatives.values() for name in others)}
    shining = (
        light.name
        for light in scene.lights
        if (isinstance(light, SurfaceLight) and light.material in met)
        or (isinstance(light, AreaLight) and light.visible)
    )
    return Call(tuple(shining), without="no surface glows, and no lamp is seen")


def _emitted(stage: Stage, view: View) -> tuple[Emitted, ...]:
    """The light of lamps, from their hits on the side that shines."""
    found = []
    for lamp in stage.seen[len(stage.shapes) :]:
        own = (view.slot == stage.slots.index(lamp.material)) & ~view.gathered
        hit = np.flatnonzero(own & (dot(view.surface.normal, view.viewer) > 0))
        if hit.size:
            found.append(Emitted(lamp.material, hit, np.ones(hit.size)))
    return tuple(found)


EMISSION = Effect("emission", _call, emitted=_emitted)
