"""Step 1: cast rays through a scene once, and keep the geometric factors that its materials' formulas name.

Whitted's recursive ray tracing [1]_ level by level: all camera rays, then all rays that effects send on from where they
ended, however many from each.

References
----------
.. [1] T. Whitted, "An Improved Illumination Model for Shaded Display", CACM 23(6), 1980.
"""

import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Int

from symrt.arrays import keep_memory
from symrt.geometry.box import Box
from symrt.geometry.meeting import leaving_of, nearest, surfaces
from symrt.geometry.rays import Hits
from symrt.geometry.triangle_mesh import TriangleMesh
from symrt.reflection.models import LIT
from symrt.scene.cameras import Window
from symrt.scene.records import Scene
from symrt.tracing.film import centres
from symrt.tracing.gathering import GATHERED, PATH
from symrt.tracing.onwards import rays_onwards
from symrt.tracing.plan import Plan
from symrt.tracing.planner import first_plan
from symrt.tracing.points import points
from symrt.tracing.raytree import Level, RayTree
from symrt.tracing.stage import Alternatives, Stage, make_stage
from symrt.tracing.tally import CAMERA, Tally, watched
from symrt.tracing.view import WINDOW, Batch, View, look
from symrt.tracing.work import AtWork, at_work

Bounds = tuple[int, int, int, int]


def trace(
    scene: Scene,
    window: Bounds | None = None,
    alternatives: Alternatives | None = None,
    *,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    planned: Plan | None = None,
) -> RayTree:
    """Trace a scene, or a window ``(x0, y0, x1, y1)`` of its pixels, x1 and y1 excluded.

    Parameters
    ----------
    alternatives
        For a material, others that may take its place: ``{"sea": ["ice"]}`` also records ice's geometry at sea's
        points, for a blend of materials whose models differ.
    force
        Effects to leave out, as for `plan`: ``{"shadows": False}``.
    tolerance
        Share of its film sample's light that a ray must carry to be followed, as for `plan`: 0.001 if not given.
    planned
        A plan that `plan` made of the same scene, in the place of `force` and `tolerance`: with a tolerance it may
        leave out whole effects, for which a trace alone knows no bound.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> tree = trace(load_scene(shipped_scene("first")), window=(0, 0, 8, 8))
    >>> tree.width, tree.height
    (8, 8)
    """
    if planned is not None and (force is not None or tolerance is not None):
        raise ValueError("planned: the plan has its own force and tolerance; give them to plan(scene, ...) instead")
    chosen = planned or first_plan(scene, alternatives, force=force, tolerance=tolerance)
    return trace_window(make_stage(scene, alternatives), chosen, window)


def trace_window(stage: Stage, chosen: Plan, window: Bounds | None = None) -> RayTree:
    """Trace a window of a scene that was made ready, with the effects of a plan."""
    start = time.perf_counter()
    keep_memory()
    x0, y0, x1, y1 = _checked_window(window, stage.camera.width, stage.camera.height)
    effects = at_work(chosen)

    # The film's samples, and a ray from the camera through each.
    sampling = next((effect for effect in effects.simulated if effect.film is not None), None)
    sampled = centres if sampling is None or sampling.film is None else sampling.film
    of_film = Window(x0, y0, x1 - x0, y1 - y0)
    film, rays = sampled(stage.camera, of_film)
    tally = Tally(film, (x1 - x0) * (y1 - y0), effects.simulated)
    effects, sending = watched(effects, tally), _sending(stage, effects)

    # The values that effects keep for each ray, and the levels of the tree.
    kept = {
        name: value(film, stage.camera, of_film) if callable(value) else np.full(film.pixel.size, value)
        for effect in effects.simulated
        for name, value in effect.state.items()
    }
    batch = Batch(rays, np.arange(film.pixel.size), (), kept)
    levels = _levels(stage, effects, batch, tally, chosen.tolerance)
    tally.shone(levels, {light.name: light.calls_for for light in stage.lights})
    return RayTree(
        levels=levels,
        materials=stage.materials,
        lights=stage.remembered,
        window=(x0, y0, x1, y1),
        film=film,
        sending=sending,
        plan=chosen,
        rays=dict(tally.rays),
        counts=tally.counts(),
        seconds=time.perf_counter() - start,
        windows=stage.windows,
        paths=stage.interreflection.paths if stage.interreflection and "interreflection" in chosen else 0,
    )


def _levels(stage: Stage, effects: AtWork, batch: Batch, tally: Tally, tolerance: float) -> tuple[Level, ...]:
    """The levels of the tree, from the camera's rays until none goes on."""
    levels: list[Level] = []
    cast = Counter({CAMERA: batch.sample.size})
    while batch.sample.size:
        with tally.shared(cast):
            # Where the rays of all branches end; those that meet nothing are dropped, unless they see the sky.
            hits = nearest(stage.seen, batch.rays)
            found = np.flatnonzero((hits.shape >= 0) | bool(stage.sky))
            batch, hits = batch.of(found), hits.of(found)

            # The surfaces there, what rays went through on their way, and the light that reaches them.
            leaving, surface = leaving_of(stage.seen, hits), surfaces(stage.seen, batch.rays, hits, stage.textured)
            view = look(surface, _slots_of(stage, hits), batch, leaving)
            view, inside = _segments(stage, effects, batch, view, hits)
            here = points(stage, effects, view)
            emitted, unlit = (
                tuple(one for effect in those if effect.emitted is not None for one in effect.emitted(stage, view))
                for those in (effects.simulated, effects.bounded)
            )

        # The rays that go on: followed until the depth is reached, cut off and bounded from there on.
        onwards = rays_onwards(stage, effects, view, here, tolerance, level=len(levels))
        cast = tally.sent(onwards.followed, view)
        gathered, path, window = (view.state.get(name) for name in (GATHERED, PATH, WINDOW))
        levels.append(
            Level(batch.sample, batch.branches, here, emitted, onwards.cut, unlit, inside, gathered, path, window)
        )
        batch = onwards.batch
    return tuple(levels)


def _segments(
    stage: Stage, effects: AtWork, batch: Batch, view: View, hits: Hits
) -> tuple[View, Mapping[str, np.ndarray]]:
    """The view with what rays keep of their way, and the lengths that they went in absorbing materials."""
    inside: Mapping[str, np.ndarray] = {}
    # An effect that is left out is bounded by them, too.
    for effect in (*effects.simulated, *effects.bounded):
        if effect.segment is not None:
            segment = effect.segment(stage, batch, view, hits)
            inside, view = {**inside, **segment.inside}, replace(view, state={**view.state, **segment.state})
    return view, inside


def _sending(stage: Stage, effects: AtWork) -> dict[str, tuple[str, ...]]:
    """The formulas by which each material's surfaces send rays on: of those that lights meet, the ones effects use."""
    unused = {*LIT} - effects.gathered
    chosen = {place: tuple(via for via in formulas if via not in unused) for place, formulas in stage.sending.items()}
    return {place: formulas for place, formulas in chosen.items() if formulas}


def _slots_of(stage: Stage, hits: Hits) -> Int[np.ndarray, " hit"]:
    """The slot of each hit, from its shape and, on a mesh or a box, from its face."""
    slot = stage.first_slot[hits.shape]
    for index, mesh in enumerate(stage.seen):
        if isinstance(mesh, TriangleMesh | Box) and mesh.face_material is not None:
            own = hits.shape == index
            slot[own] += mesh.face_material[hits.primitive[own]]
    return slot


def _checked_window(window: Bounds | None, width: int, height: int) -> Bounds:
    x0, y0, x1, y1 = window or (0, 0, width, height)
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise ValueError(
            f"window {window}: it must be (x0, y0, x1, y1) with 0 ≤ x0 < x1 ≤ {width} and 0 ≤ y0 < y1 ≤ {height}"
        )
    return x0, y0, x1, y1
