"""Shadows: one ray from each hit to each place of a light that faces it and casts shadows (an effect of step 1).

Without them surfaces are too bright by at most the light that reaches them: that is the bound where they are left out.
"""

import numpy as np

from symrt.geometry.meeting import occluded
from symrt.geometry.rays import spawn
from symrt.scene.lights import Illumination, Light
from symrt.scene.records import Scene
from symrt.scene.wide_lights import WideLight
from symrt.tracing.effects.effect import Call, Effect, Passed
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    places = {light.name: _places(light, scene, alternatives) for light in scene.lights if light.shadows}
    casting = tuple(name for name, number in places.items() if number)
    without = "no light casts any" if not places else "all that cast any have penumbrae"
    without, count = "there is no shape" if casting else without, sum(places.values())
    return Call(casting if scene.shapes else (), without, rays=f"{count} a hit", a_hit=count)


def _places(light: Light, scene: Scene, alternatives: Alternatives) -> int:
    """The places of a light that cast shadows; a wide one has some for materials with highlights, and for paths.

    Where paths gather light it is seen from one place of it at each hit.
    """
    if not isinstance(light, WideLight):
        return 1
    gathering = 1 if scene.interreflection is not None and scene.interreflection.depth else 0
    used = {*scene.used_materials, *(other for others in alternatives.values() for other in others)}
    models = (material.reflection for material in scene.materials if material.name in used)
    glossy = any(model.direct != 0 and not model.diffusing for model in models)
    return len(light.samples(np.zeros((3, 1)))) if glossy else gathering


def _visible(
    stage: Stage,
    view: View,
    light: Light,  # noqa: ARG001  all lights are hidden alike
    hit: Which,
    at: Illumination,
) -> Passed:
    """1 for each of the given hits that nothing hides from a place of a light, else 0."""
    surface = view.surface
    place = surface.point.take(hit, axis=1), view.normal.take(hit, axis=1), surface.error[hit]
    rays = spawn(*place, at.towards, view.leaving.take(hit, axis=1))
    return Passed(np.where(occluded(stage.shapes, rays, at.distance), 0.0, 1.0), rays=hit.size)


SHADOWS = Effect("shadows", _call, arriving=_visible)
