"""Mirrors: one ray onwards from each hit that reflects (an effect of step 1)."""

import numpy as np
from jaxtyping import Int

from symrt.arrays import dot, normalise
from symrt.geometry.rays import Rays, spawn
from symrt.tracing.factors import reflect
from symrt.tracing.raytree import Points
from symrt.tracing.stage import Stage
from symrt.tracing.view import View


def mirrored(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Rays, Int[np.ndarray, " ray"]]:
    """Rays along the mirrored view, and the hit that each leaves from.

    A smoothed normal may send the view into the surface; there is nothing to see there, so no ray is cast.
    """
    reflecting = np.zeros(view.slot.size, dtype=bool)
    for part in points:
        if stage.materials[part.material].model.mirrors:
            reflecting[part.hit] = True
    hit = np.flatnonzero(reflecting)
    direction = reflect(view.viewer[:, hit], view.shading_normal[:, hit])
    outwards = dot(direction, view.normal[:, hit]) > 0
    hit, direction = hit[outwards], direction[:, outwards]
    surface = view.surface
    rays = spawn(surface.point[:, hit], view.normal[:, hit], surface.error[hit], normalise(direction))
    return rays, hit
