"""Step 1: cast rays through a scene once, and keep what its materials' formulas ask for.

Whitted's recursive ray tracing [1]_ level by level: all camera rays, then all rays that their mirrors send on.

References
----------
.. [1] T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
"""

import time
from collections import Counter

import numpy as np

from symrt.geometry.mesh import TriangleMesh
from symrt.geometry.rays import Rays, nearest, surfaces
from symrt.scene.cameras import Window, camera_rays
from symrt.scene.lights import AmbientLight
from symrt.scene.records import Scene
from symrt.tracing.mirrors import mirrored
from symrt.tracing.plan import Alternatives
from symrt.tracing.points import points
from symrt.tracing.raytree import Level, RayTree
from symrt.tracing.stage import Stage, make_stage
from symrt.tracing.view import look, select_hits, select_rays

__all__ = ["trace", "trace_window"]

Box = tuple[int, int, int, int]


def trace(scene: Scene, window: Box | None = None, alternatives: Alternatives | None = None) -> RayTree:
    """Trace a scene, or a window ``(x0, y0, x1, y1)`` of its pixels, x1 and y1 excluded.

    Parameters
    ----------
    alternatives
        For a material, others that may take its place: ``{"sea": ["ice"]}`` also records ice's geometry at sea's
        points, for a blend of materials whose models differ.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> tree = trace(load_scene(shipped_scene("first")), window=(0, 0, 8, 8))
    >>> tree.width, tree.height
    (8, 8)
    """
    return trace_window(make_stage(scene, alternatives), window)


def trace_window(stage: Stage, window: Box | None = None) -> RayTree:
    """Trace a window of a scene that was made ready."""
    start = time.perf_counter()
    x0, y0, x1, y1 = _checked(window, stage.camera.width, stage.camera.height)
    rays = camera_rays(stage.camera, Window(x0, y0, x1 - x0, y1 - y0))
    count = Counter(camera=rays.origin.shape[1])
    levels = _levels(stage, rays, count)
    return RayTree(
        levels=levels,
        materials=stage.materials,
        lights={light.name: isinstance(light, AmbientLight) for light in stage.lights},
        window=(x0, y0, x1, y1),
        samples=stage.camera.samples,
        white=stage.white,
        irradiance=stage.irradiance,
        depth=stage.depth,
        reflecting=stage.reflecting,
        rays=dict(count),
        seconds=time.perf_counter() - start,
    )


def _levels(stage: Stage, rays: Rays, count: Counter[str]) -> tuple[Level, ...]:
    sample = np.arange(rays.origin.shape[1])
    parent = np.full(sample.size, -1)
    levels: list[Level] = []
    while sample.size:
        hits = nearest(stage.shapes, rays)
        found = np.flatnonzero(hits.shape >= 0)
        rays, hits, sample, parent = select_rays(rays, found), select_hits(hits, found), sample[found], parent[found]
        view = look(surfaces(stage.shapes, rays, hits), _slots(stage, hits.shape, hits.primitive), rays, sample)
        here = points(stage, view, count)
        levels.append(Level(sample, parent, here))
        if len(levels) > stage.depth or "mirrors" not in stage.plan:
            break
        rays, parent = mirrored(stage, view, here)
        sample = sample[parent]
        count["mirrors"] += sample.size
    return tuple(levels)


def _slots(stage: Stage, shape: np.ndarray, primitive: np.ndarray) -> np.ndarray:
    slot = stage.first_slot[shape]
    for index, mesh in enumerate(stage.shapes):
        if isinstance(mesh, TriangleMesh) and mesh.face_material is not None:
            own = shape == index
            slot[own] += mesh.face_material[primitive[own]]
    return slot


def _checked(window: Box | None, width: int, height: int) -> Box:
    x0, y0, x1, y1 = window or (0, 0, width, height)
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise ValueError(
            f"window {window}: it must be (x0, y0, x1, y1) with 0 ≤ x0 < x1 ≤ {width} and 0 ≤ y0 < y1 ≤ {height}"
        )
    return x0, y0, x1, y1
