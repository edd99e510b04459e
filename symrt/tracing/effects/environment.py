"""The environment: what rays see that meet nothing, and the light of the sky's regions (an effect of step 1).

Rays of the eye, of mirrors and of glass that meet nothing are kept as hits at infinity, which send the radiance of the
sky's region there.  To a surface each region sends its irradiance times the share of it that is seen: from each hit
before which some shape may stand, a ray goes to each of the region's directions above the horizon, and the share is
that of ``Σ w n·ω`` which is free.  The reported error is half the difference between every other direction and the
rest; **what is smaller than the way from one direction to the next is missed** by most.
"""

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import dot, length
from symrt.geometry.meeting import occluded
from symrt.geometry.rays import spawn
from symrt.scene.lights import Illumination, Light
from symrt.scene.outlines import Directions
from symrt.scene.records import Scene
from symrt.scene.sky import Sky
from symrt.tracing.effects.effect import Call, Effect, Passed
from symrt.tracing.raytree import Emitted
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View, Which

BATCH = 1 << 16
"""Rays that are cast together, about."""


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  whatever shapes are made of, they hide
    regions = [light for light in scene.lights if isinstance(light, Sky)]
    rays = sum(light.directions.weight.size for light in regions if light.shadows) if scene.shapes else 0
    names = tuple(light.name for light in regions)
    # About half of the sky is above a hit's horizon.
    return Call(names, without="there is no sky", rays=f"{rays} a hit", a_hit=rays // 2)


def _emitted(stage: Stage, view: View) -> tuple[Emitted, ...]:
    """The radiance of the sky where rays meet nothing, region by region."""
    found = []
    hit = np.flatnonzero((view.slot == len(stage.slots) - 1) & ~view.gathered)
    for region in stage.sky:
        radiance = region.radiance(-view.viewer[:, hit])
        some = np.flatnonzero(radiance)
        if some.size:
            found.append(Emitted(region.name, hit[some], radiance[some]))
    return tuple(found)


def _visible(
    stage: Stage,
    view: View,
    light: Light,
    hit: Which,
    at: Illumination,
) -> Passed:
    """The share that is seen of a region from each of the given hits, and its estimated error."""
    if not isinstance(at.figure, Directions):
        raise TypeError(f"{light.name} is no region of the sky: its samples stand for places")
    share, error = np.ones(hit.size), np.zeros(hit.size)

    # The hits before which some shape may stand.
    asked = np.flatnonzero(_doubtful(stage, view, hit, at.figure))
    own = hit[asked]
    point, normal, horizon = view.surface.point[:, own], view.normal[:, own], view.shading_normal[:, own]
    leaving, mistake = view.leaving[:, own], view.surface.error[own]

    # Rays to some of the directions at a time; sums run over the directions in their order, whatever the hits are.
    cast, (whole, free) = 0, np.zeros((2, 2, own.size))
    step = max(1, BATCH // max(1, own.size))
    for first in range(0, at.figure.weight.size, step):
        ways, weight = at.figure.towards[:, first : first + step], at.figure.weight[first : first + step]
        light_from = weight[:, None] * np.maximum(_cosines(ways, horizon), 0.0)
        way, to = np.nonzero((light_from > 0) & (_cosines(ways, normal) > 0))
        rays = spawn(
            point.take(to, axis=1),
            normal.take(to, axis=1),
            mistake[to],
            ways.take(way, axis=1),
            leaving.take(to, axis=1),
        )
        cast += to.size
        seen = ~occluded(stage.shapes, rays, np.full(to.size, np.inf))
        let_through = np.zeros_like(light_from)
        let_through[way[seen], to[seen]] = light_from[way[seen], to[seen]]
        for k in range(len(weight)):
            whole[(first + k) % 2] += light_from[k]
            free[(first + k) % 2] += let_through[k]

    # A region of which no direction is above the horizon gives next to nothing, all of which is let through.
    total = whole.sum(axis=0)
    share[asked] = np.where(total > 0, free.sum(axis=0) / np.where(total > 0, total, 1.0), 1.0)
    halves = np.where(whole > 0, free / np.where(whole > 0, whole, 1.0), share[asked])
    error[asked] = np.abs(halves[0] - halves[1]) / 2
    return Passed(share, error, cast)


def _cosines(ways: Float[np.ndarray, "3 way"], normals: Float[np.ndarray, "3 hit"]) -> Float[np.ndarray, "way hit"]:
    """Cosines between directions and normals, each by itself: a matrix product would round by its size."""
    return sum(way[:, None] * normal for way, normal in zip(ways, normals, strict=True))


def _doubtful(stage: Stage, view: View, hit: Which, sky: Directions) -> Bool[np.ndarray, " hit"]:
    """Whether some shape may stand between each hit and the region, by balls around the boxes that hold the shapes."""
    point, normal, own = view.surface.point[:, hit], view.normal[:, hit], view.leaving[0, hit]
    doubtful = np.zeros(hit.size, dtype=bool)
    for index in range(len(stage.shapes)):
        low, high = stage.shapes.boxes[0, :, index, None], stage.shapes.boxes[1, :, index, None]
        if not (np.isfinite(low).all() and np.isfinite(high).all()):
            doubtful |= own != index
            continue

        # The ball is below the horizon, or all lower or all higher than the region.
        towards = (low + high) / 2 - point
        far, radius = length(towards), float(length(high - low)[0]) / 2
        wide = np.arcsin(np.minimum(radius / np.where(far > 0, far, 1.0), 1.0))
        away = np.where(far > 0, far, 1.0)
        height = np.arcsin(np.clip(dot(sky.up, towards) / away, -1.0, 1.0))
        missed = (height + wide < np.arcsin(sky.lowest)) | (height - wide > np.arcsin(sky.highest))
        missed |= dot(normal, towards) < -radius
        # A flat or convex shape never stands before itself.
        doubtful |= ((far <= radius) | ~missed) & (own != index)
    return doubtful


ENVIRONMENT = Effect("environment", _call, arriving=_visible, figures=Directions, emitted=_emitted)
