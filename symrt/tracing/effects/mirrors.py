"""Mirrors: one ray onwards from each hit that reflects, along the mirrored view (an effect of step 1)."""

import numpy as np

from symrt.arrays import dot, normalise, reflect
from symrt.geometry.rays import spawn
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import CARRIED, Call, Effect, Sent
from symrt.tracing.raytree import Points
from symrt.tracing.stage import Alternatives, Stage, refracting, senders
from symrt.tracing.view import View


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    # Glass mirrors by its index, which is another effect's to follow.
    glass = refracting(scene, alternatives)
    return Call(
        tuple(name for name in senders(scene, alternatives, "reflected") if name not in glass),
        without="no material mirrors",
        rays=f"{scene.depth} a sample",
        left_out="" if scene.depth else "the depth is 0",
        onwards=1,
    )


def _onwards(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Sent, ...]:
    """Rays along the mirrored view.

    A smoothed normal may send the view into the surface; there is nothing to see there, so no ray is cast.
    """
    # The hits with a material that mirrors; where a texture blends several, they share the ray.
    share = np.zeros(view.slot.size)
    materials: set[str] = set()
    for part in points:
        model = stage.materials[part.material].model
        if "reflected" in model.sending and not model.refracts:
            share[part.hit] += part.weight * stage.most[part.material]["reflected"]
            materials.add(part.material)
    hit = np.flatnonzero(share)

    # The mirrored view, where it leaves the true surface.
    direction = reflect(view.viewer.take(hit, axis=1), view.shading_normal.take(hit, axis=1))
    outwards = np.flatnonzero(dot(direction, view.normal.take(hit, axis=1)) > 0)
    hit, direction = hit[outwards], direction.take(outwards, axis=1)

    surface = view.surface
    place = surface.point.take(hit, axis=1), view.normal.take(hit, axis=1), surface.error[hit]
    rays = spawn(*place, normalise(direction), view.leaving.take(hit, axis=1))
    carried = np.minimum(share[hit], 1.0)
    return (Sent("reflected", hit, rays, np.ones(hit.size), materials=frozenset(materials), share=carried),)


MIRRORS = Effect("mirrors", _call, onwards=_onwards, state={CARRIED: 1.0})
