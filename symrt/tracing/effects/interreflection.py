"""Interreflection: light that diffusers send to each other (an effect of step 1).

From each hit that the camera sees rays go out on paths, in directions whose density is the cosine to the normal over π;
so each brings the same share of the light that a diffuser sends on, its albedo times 1/N, however it is turned.
Further on each path goes on with one ray a hit, and is cut off after a number of such bounces.

    sent on = albedo · 1/N Σ radiance along the paths

The albedo is the formula ``ambient``: the radiance that a surface sends on of equal radiance from everywhere.  Where
paths end, lights with an area are seen at one place each, drawn anew for each hit.  Highlights of materials do not see
other surfaces.
"""

import numpy as np
from jaxtyping import Float

from symrt.arrays import Vectors, dot
from symrt.geometry.rays import spawn
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect, Sent
from symrt.tracing.gathering import DIRECTION, GATHERED, PATH, SEED, drawn, seeds
from symrt.tracing.nets import disk
from symrt.tracing.raytree import Points
from symrt.tracing.sobol import BITS
from symrt.tracing.stage import Alternatives, Stage, senders
from symrt.tracing.view import View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    asked = scene.interreflection
    if asked is None:
        return Call((), without="the scene does not ask for it")
    return Call(
        senders(scene, alternatives, "ambient"),
        without="no material has an albedo, a formula ambient",
        rays=f"{asked.paths} paths a hit, {asked.depth} deep",
        left_out="" if asked.depth else "its depth is 0",
        gathered=asked.paths * asked.depth,
    )


def _onwards(stage: Stage, view: View, points: tuple[Points, ...]) -> tuple[Sent, ...]:
    """Rays of all paths from hits of the camera, one ray of its path from each other hit; from the last ones none.

    A smoothed normal may have directions that go into the surface; there is nothing to see there, so no ray is cast.
    """
    # The hits with a material that has an albedo.
    sending, materials = np.zeros(view.slot.size, dtype=bool), set[str]()
    for part in points:
        if stage.materials[part.material].model.ambient != 0:
            sending[part.hit] = True
            materials.add(part.material)
    hit = np.flatnonzero(sending)

    # Beyond the depth, and where it is left out, what all rays of a hit would bring is bounded together.
    asked = stage.interreflection
    if asked is None or GATHERED not in view.state:
        return (_cut(hit, materials),)
    bounces, found = view.state[GATHERED][hit], []
    for bounce in np.unique(bounces).tolist():
        here = hit[bounces == bounce]
        if bounce >= asked.depth:
            found.append(_cut(here, materials))
            continue
        count = asked.paths if bounce == 0 else 1
        here = np.repeat(here, count)
        path = view.state[PATH][here] if bounce else np.tile(np.arange(asked.paths), here.size // count)
        u, v = drawn(view.state[SEED][here], path, asked.paths, 4 * bounce + DIRECTION)
        direction = _scattered(view.shading_normal[:, here], u, v)

        outwards = np.flatnonzero(dot(direction, view.normal[:, here]) > 0)
        here, path = here[outwards], path[outwards]
        place = view.surface.point[:, here], view.normal[:, here], view.surface.error[here]
        rays = spawn(*place, direction[:, outwards], view.leaving[:, here])
        state = {GATHERED: np.full(here.size, bounce + 1), PATH: path}
        weight = np.full(here.size, 1 / count)
        found.append(Sent("ambient", here, rays, weight, state=state, materials=frozenset(materials)))
    return tuple(found)


def _cut(hit: Which, materials: set[str]) -> Sent:
    """Rays that are not followed, one from each hit for all of them."""
    return Sent("ambient", hit, None, np.ones(hit.size), materials=frozenset(materials))


def _scattered(normal: Vectors, u: Float[np.ndarray, " ray"], v: Float[np.ndarray, " ray"]) -> Vectors:
    """Unit vectors about a normal, of the density cosθ/π, from pairs of numbers between 0 and 1 [1]_.

    References
    ----------
    .. [1] T. Duff et al., "Building an Orthonormal Basis, Revisited", J. Computer Graphics Techniques 6(1), 2017.
    """
    x, y = disk(np.stack([u, v]))
    # The radius is below 1 by 2⁻³², so that no direction grazes the surface.
    z = np.sqrt(np.maximum(1 - x * x - y * y, 2.0**-BITS))

    # Two vectors across the normal.
    sign = np.copysign(1.0, normal[2])
    a = -1 / (sign + normal[2])
    b = normal[0] * normal[1] * a
    across = np.stack([1 + sign * normal[0] ** 2 * a, sign * b, -sign * normal[0]])
    up = np.stack([b, sign + normal[1] ** 2 * a, -normal[1]])
    return x * across + y * up + z * normal


INTERREFLECTION = Effect(
    "interreflection", _call, onwards=_onwards, gathers=("ambient",), state={GATHERED: 0, PATH: 0, SEED: seeds}
)
