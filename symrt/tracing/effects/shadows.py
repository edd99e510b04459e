"""Shadows: one ray from each hit to each light that faces it and casts shadows (an effect of step 1).

Without them surfaces are too bright by at most the light that reaches them: that is the bound where they are left out.
"""

from collections import Counter

import numpy as np

from symrt.arrays import Vectors
from symrt.geometry.meeting import occluded
from symrt.geometry.rays import spawn
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect, PerHit
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  whatever a shape is made of, it hides
    casting = tuple(light.name for light in scene.lights if light.shadows)
    without = "there is no shape" if casting else "no light casts any"
    return Call(casting if scene.shapes else (), without, rays=f"{len(casting)} a hit", a_hit=len(casting))


def _visible(stage: Stage, view: View, hit: Which, direction: Vectors, distance: PerHit, count: Counter[str]) -> PerHit:
    """1 for each of the given hits that nothing hides from a light in that direction, else 0."""
    surface = view.surface
    place = surface.point[:, hit], view.normal[:, hit], surface.error[hit]
    rays = spawn(*place, direction, view.leaving[:, hit])
    count["shadows"] += hit.size
    return np.where(occluded(stage.shapes, rays, distance), 0.0, 1.0)


SHADOWS = Effect("shadows", _call, arriving=_visible)
