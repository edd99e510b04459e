"""Footprints: a filtered texture shows its mean over the part of it that a sample covers (an effect of step 1).

Each ray is the middle of a cone, two floats: its width, and the angle by which that grows [1]_.  A sphere that mirrors
spreads it by twice its curvature.  Where the cone meets a surface it is cut aslant; of that the texture gets the sides
of the box, along u and v, that has the same variances.  Means keep Σ w = 1.  The curvature of a mesh, and of glass that
bends the view, is not known to the cone, and there it is too narrow.

References
----------
.. [1] T. Akenine-Möller, C. Crassin, J. Boksansky, L. Belcour, A. Panteleev and O. Wright, "Improved Shader and Texture
   Level of Detail Using Ray Cones", JCGT 10(1), 2021.
"""

import math
from dataclasses import replace

import numpy as np

from symrt.arrays import PerRay, Vectors, dot, length, normalise
from symrt.geometry import Cylinder, Sphere
from symrt.geometry.meeting import surfaces
from symrt.geometry.rays import Hits, Rays
from symrt.scene.cameras import Camera, Window, camera_rays
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect, Segment
from symrt.tracing.raytree import Film
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import Batch, View

WIDTH, SPREAD = "width", "spread"
"""The states that keep the width of a ray's cone where the ray starts, and the angle by which it grows."""
ALONG_U, ALONG_V = "along u", "along v"
"""The states that keep the sides of the box on the surface that a ray met, in its coordinates; 0 where nothing asks."""
GRAZING = 1e-3
"""Cosine below which a cone is cut as if it met the surface under this one."""


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  textures alone call for it
    asked = tuple(
        texture.name for texture in scene.textures if texture.name in scene.used_textures and _filtered(texture)
    )
    return Call(asked, without="no texture is filtered")


def _filtered(texture: object) -> bool:
    return bool(getattr(texture, "filtered", False))


def _width(film: Film, camera: Camera, window: Window) -> PerRay:  # noqa: ARG001  the same in the whole picture
    """The width of the samples' cones at the camera: none, or for parallel rays the side of a sample."""
    parallel = camera.type == "orthographic"
    return np.full(film.pixel.size, (camera.view_width or 0.0) / (camera.width * camera.samples) if parallel else 0.0)


def _spread(film: Film, camera: Camera, window: Window) -> PerRay:
    """The angle of the samples' cones: as large in solid angle as a sample, the smaller the farther from the middle."""
    if camera.type == "orthographic":
        return np.zeros(film.pixel.size)
    side = 2 * math.tan(math.radians(camera.field_of_view or 0.0) / 2) / (camera.width * camera.samples)
    towards = camera_rays(replace(camera, samples=1), window).direction
    middle = normalise(np.subtract(camera.target, camera.position)[:, None])
    return (side * dot(towards, middle) ** 1.5)[film.pixel]


def _segment(stage: Stage, batch: Batch, view: View, hits: Hits) -> Segment:
    """The cones where their rays end, the boxes that they cover there, and how they go on from a mirror."""
    # What rays see where they meet nothing has no texture.
    width = batch.state[WIDTH] + batch.state[SPREAD] * np.where(np.isfinite(hits.distance), hits.distance, 0.0)
    cosine = np.maximum(np.abs(dot(view.normal, view.viewer)), GRAZING)
    along_u, along_v = np.zeros(width.size), np.zeros(width.size)

    # The hits on filtered textures.
    asking = [_filtered(stage.textures.get(name)) for name in stage.slots]
    asked = np.flatnonzero(np.array(asking)[view.slot] & (hits.shape >= 0))
    if asked.size:
        rays, met = batch.rays[asked], Hits(hits.distance[asked], hits.shape[asked], hits.primitive[asked])
        normal, wide = view.normal[:, asked], np.abs(width[asked])
        ahead = rays.direction - normal * dot(normal, rays.direction)
        # Straight on a surface any direction in it will do.
        aside = np.where(np.abs(normal) == np.abs(normal).min(axis=0), 1.0, 0.0)
        ahead = np.where(length(ahead) > GRAZING**2, ahead, aside - normal * dot(normal, aside))
        ahead = normalise(ahead)
        across = np.cross(normal, ahead, axis=0)
        point = view.surface.point[:, asked]
        first = _moved(stage, rays, met, point, ahead * (wide / cosine[asked]), view.surface.uv[:, asked])
        second = _moved(stage, rays, met, point, across * wide, view.surface.uv[:, asked])
        along_u[asked], along_v[asked] = np.hypot(first, second)

    # A mirror of radius R, seen from outside or from inside, turns the cone's edges by 2/R each way.
    bent = np.array([_curvature(shape) for shape in stage.seen])[hits.shape]
    outside = np.where(dot(view.surface.normal, view.viewer) > 0, 1.0, -1.0)
    spread = batch.state[SPREAD] + 2 * outside * bent * width / cosine
    return Segment({}, {WIDTH: width, SPREAD: spread, ALONG_U: along_u, ALONG_V: along_v})


def _moved(stage: Stage, rays: Rays, met: Hits, point: Vectors, step: Vectors, uv: np.ndarray) -> np.ndarray:
    """The change of a surface's coordinates by a step on it, from what is half as far."""
    towards = point + step / 2 - rays.origin
    there = Rays(rays.origin, normalise(towards))
    change = surfaces(stage.seen, there, replace(met, distance=length(towards)), stage.textured).uv - uv
    # Longitudes begin anew.
    turning = np.array([isinstance(shape, Sphere | Cylinder) for shape in stage.seen])[met.shape]
    change[0] -= np.where(turning, np.round(change[0]), 0.0)
    return 2 * change


def _curvature(shape: object) -> float:
    """The mean curvature of a shape that is as curved everywhere; 0 of all others."""
    if isinstance(shape, Sphere):
        return 1 / float(shape.radius)
    return 0.5 / float(shape.radius) if isinstance(shape, Cylinder) else 0.0


FOOTPRINTS = Effect(
    "footprints",
    _call,
    needed="a filtered texture is another one without it; set filtered = false",
    segment=_segment,
    state={WIDTH: _width, SPREAD: _spread, ALONG_U: 0.0, ALONG_V: 0.0},
)
