"""Shadows: one ray from each hit to each light that faces it and casts shadows (an effect of step 1)."""

from collections import Counter

import numpy as np
from jaxtyping import Float, Int

from symrt.geometry.rays import occluded, spawn
from symrt.scene.lights import Illumination
from symrt.tracing.stage import Stage
from symrt.tracing.view import View


def visible(
    stage: Stage, view: View, hit: Int[np.ndarray, " lit"], light: Illumination, count: Counter[str]
) -> Float[np.ndarray, " lit"]:
    """1 for each of the given hits that nothing hides from the light, else 0."""
    surface = view.surface
    direction = light.direction[:, hit]
    rays = spawn(surface.point[:, hit], view.normal[:, hit], surface.error[hit], direction)
    count["shadows"] += hit.size
    return np.where(occluded(stage.shapes, rays, light.distance[hit]), 0.0, 1.0)
