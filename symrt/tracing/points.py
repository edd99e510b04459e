"""The points of a level: each hit's materials, and the geometric factors that their formulas name (step 1)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt import fast
from symrt.arrays import dot
from symrt.geometry.directions import whole_rows
from symrt.reflection.models import Model
from symrt.reflection.symbols import FRESNEL, VIEW
from symrt.scene.lights import Answering, Illumination
from symrt.scene.surface_lights import SurfaceLight
from symrt.scene.wide_lights import WideLight
from symrt.symbols import Surface
from symrt.tracing.factors import coded, factors
from symrt.tracing.gathering import GATHERED, LIGHT, PATH, SEED, drawn
from symrt.tracing.raytree import Index, Lit, Points
from symrt.tracing.stage import Stage
from symrt.tracing.view import View
from symrt.tracing.work import AtWork

Shares = Sequence[tuple[str, tuple[np.ndarray, np.ndarray]]]
"""Each material with its hits and weights."""


@dataclass(frozen=True, eq=False)
class Reached:
    """The hits that one sample of a light reaches: those that it faces, on the viewer's side of the surface.

    Parameters
    ----------
    position
        For each hit of the level its place among those reached, −1 where the light is behind.
    direction
        Unit vectors to the light; None for light from everywhere.
    bounded
        True if an effect was left out that would change this, so that it counts in the tail.
    error
        The estimated error of `visible`, where it is not exact.
    diffusing
        True for diffusers, False for materials with highlights, of a light that comes from many directions.
    """

    light: Answering
    position: Int[np.ndarray, " hit"]
    direction: Float[np.ndarray, "3 reached"] | None
    irradiance: Float[np.ndarray, " reached"]
    visible: Float[np.ndarray, " reached"]
    bounded: bool
    error: Float[np.ndarray, " reached"] | None = None
    diffusing: bool | None = None

    def meets(self, surface: str, model: Model) -> bool:
        """True if a surface's model has a formula for the light, and the sample is for its kind, or its own light."""
        kind = self.diffusing is None or self.diffusing == model.diffusing
        own = not isinstance(self.light, SurfaceLight) or self.light.material == Surface.of(surface).material
        return kind and own and bool(model.formulas[self.light.via] != 0)


def points(stage: Stage, effects: AtWork, view: View) -> tuple[Points, ...]:
    """All points of a level, by material in the order of names; alternatives follow what they may replace."""
    # The hits that each sample of each light reaches.
    shares = sorted(_shares(stage, effects, view).items())
    asking = _asking(stage, shares, view.slot.size)
    reached = []
    for light in stage.lights:
        if isinstance(light, WideLight):
            reached += _reached_from(stage, effects, light, view, shares)
            reached += _reached_from_a_place(stage, effects, light, view, asking)
        else:
            samples = light.samples(view.surface.point)
            reached += [_reached(stage, effects, light, sample, view, asking) for sample in samples]

    # The points of each material, and again for each of its alternatives.
    found = []
    for material, (hit, weight) in shares:
        others = [Surface(other, instead_of=material) for other in stage.alternatives.get(material, ())]
        for name in (material, *map(str, others)):
            # The light on them, where the model has a formula for it, and what depends on the viewer only.
            model = stage.materials[name].model
            meeting = [one for one in reached if one.meets(name, model)]
            seen = factors(model.factors & VIEW, *view.facing(hit), None)
            met = [(one, _lit(view, one, hit, model.factors - FRESNEL)) for one in meeting]

            # A light whose effect is left out does not shine; one whose shadows are does. Both count in the tail.
            lit = tuple(arriving for one, arriving in met if one.light.calls_for not in effects.left_out)
            cut = tuple(arriving for one, arriving in met if one.bounded)
            found.append(Points(name, hit, weight, lit, seen, cut))
    return tuple(found)


def _asking(stage: Stage, shares: Shares, size: int) -> Bool[np.ndarray, " hit"]:
    """True for hits with a material, or an alternative to one, that lights from a direction are reflected by."""
    asking = np.zeros(size, dtype=bool)
    for material, (hit, _) in shares:
        others = (str(Surface(other, instead_of=material)) for other in stage.alternatives.get(material, ()))
        if any(stage.materials[name].model.direct != 0 for name in (material, *others)):
            asking[hit] = True
    return asking


def _reached(
    stage: Stage,
    effects: AtWork,
    light: Answering,
    at: Illumination,
    view: View,
    asking: Bool[np.ndarray, " hit"],
) -> Reached:
    """The hits that one sample of a light reaches, and the share of it that effects let through."""
    # Light from everywhere reaches all hits.
    if at.direction is None:
        everywhere = np.arange(view.slot.size)
        bounded = light.calls_for in effects.left_out
        return Reached(light, everywhere, None, at.falloff, np.ones(view.slot.size), bounded)

    # The hits that ask and that the light faces, on the viewer's side of the surface and of its smoothed normal.
    above = (dot(view.normal, at.direction) > 0) & (dot(view.shading_normal, at.direction) > 0)
    hit = np.flatnonzero(above & asking & (at.falloff > 0))
    position = np.full(view.slot.size, -1)
    position[hit] = np.arange(hit.size)

    # The share of it that is not hidden on the way.
    at, visible, error = at.of(hit), np.ones(hit.size), None
    figures = type(at.figure)
    if light.shadows:
        for effect in effects.simulated:
            if effect.arriving is not None and effect.figures is figures:
                passed = effect.arriving(stage, view, light, hit, at)
                visible, error = visible * passed.share, passed.error
    bounded = light.calls_for in effects.left_out or (
        light.shadows and any(effect.arriving is not None and effect.figures is figures for effect in effects.bounded)
    )
    return Reached(light, position, at.direction, at.falloff, visible, bounded, error)


def _reached_from(stage: Stage, effects: AtWork, light: WideLight, view: View, shares: Shares) -> list[Reached]:
    """The hits that a wide light reaches: diffusers as a whole, materials with highlights by its places."""
    # The hits of both kinds of material; a texture may blend them.  Where light is gathered one place is enough.
    seen = view.state[GATHERED] == 0 if GATHERED in view.state else np.ones(view.slot.size, dtype=bool)
    needed = {True: np.zeros(view.slot.size, dtype=bool), False: np.zeros(view.slot.size, dtype=bool)}
    for material, (hit, _) in shares:
        others = (str(Surface(other, instead_of=material)) for other in stage.alternatives.get(material, ()))
        for model in (stage.materials[name].model for name in (material, *others)):
            if model.direct != 0:
                needed[model.diffusing][hit] = seen[hit]

    # Hits that do not need the light do not ask for it.
    found = []
    for diffusing, hits in needed.items():
        if hits.any():
            point = view.surface.point
            samples = (light.facing(point, view.shading_normal),) if diffusing else light.samples(point)
            reached = (_reached(stage, effects, light, sample, view, hits) for sample in samples)
            found += [replace(one, diffusing=diffusing) for one in reached]
    return found


def _reached_from_a_place(
    stage: Stage,
    effects: AtWork,
    light: WideLight,
    view: View,
    asking: Bool[np.ndarray, " hit"],
) -> list[Reached]:
    """The hits at which paths gather light, each reached from one place that is drawn on a wide light."""
    asked, bounces = stage.interreflection, view.state.get(GATHERED)
    if asked is None or bounces is None or not bounces.any():
        return []
    u, v = np.zeros(bounces.size), np.zeros(bounces.size)
    for bounce in np.unique(bounces[bounces > 0]).tolist():
        hit = np.flatnonzero(bounces == bounce)
        path = view.state[PATH][hit]
        u[hit], v[hit] = drawn(view.state[SEED][hit], path, asked.paths, 4 * (bounce - 1) + LIGHT)
    sample = light.drawn(view.surface.point, u, v)
    return [_reached(stage, effects, light, sample, view, asking & (bounces > 0))]


def _lit(view: View, reached: Reached, hit: Index, names: frozenset[str]) -> Lit:
    """The part of a light's sample that reaches the points at some hits, with the named cosines."""
    if compiled := _lit_compiled(view, reached, hit, names):
        return compiled
    position = reached.position[hit]
    point = np.flatnonzero(position >= 0)
    position, hit = position[point], hit[point]
    found: Mapping[str, np.ndarray] = {}
    if reached.direction is not None:
        direction = reached.direction.take(position, axis=1)
        found = factors(names - VIEW, *view.facing(hit), direction)
    light, error = reached.light, None if reached.error is None else reached.error[position]
    return Lit(light.name, light.via, point, reached.irradiance[position], reached.visible[position], found, error)


def _lit_compiled(view: View, reached: Reached, hit: Index, names: frozenset[str]) -> Lit | None:
    """The same by kernels; None where NumPy is to do it."""
    given = view.shading_normal, view.viewer, reached.direction, reached.irradiance, reached.visible
    kernels = fast.kernels("symrt.tracing.fast.lighting", hit.size)
    if kernels is None or any(array is None or array.dtype != np.float64 for array in given):
        return None
    normal, viewer, direction, irradiance, visible = (whole_rows(array) for array in given if array is not None)

    # The points that the light reaches.
    point, place = np.empty((2, hit.size), np.int64)
    falls, seen = np.empty((2, hit.size))
    count = kernels.reach(reached.position, hit, irradiance, visible, point, place, falls, seen)
    point, place = point[:count], place[:count]

    # The factors there; those of the same light, in the order of their names.
    asked = sorted(names - VIEW)
    codes = np.array([coded(name) for name in asked], np.int64).reshape(-1, 3)
    found = np.empty((len(asked), count))
    kernels.factors(codes, hit.take(point), place, normal, viewer, direction, found)
    light, error = reached.light, None if reached.error is None else reached.error[place]
    factors = dict(zip(asked, found, strict=True))
    return Lit(light.name, light.via, point, falls[:count], seen[:count], factors, error)


def _shares(stage: Stage, effects: AtWork, view: View) -> dict[str, tuple[Index, Float[np.ndarray, " point"]]]:
    """Hits and weights of each material, a texture's blends taken apart; hits ascend."""
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for slot in np.unique(view.slot):
        # Lamps that are seen have no material, and the sky has none.
        if stage.slots[slot] in stage.remembered:
            continue
        hit = np.flatnonzero(view.slot == slot)
        for material, share in _materials_at(stage, effects, stage.slots[slot], view, hit).items():
            present = share > 0
            parts.setdefault(material, []).append((hit[present], share[present]))
    return {name: _in_order(found) for name, found in parts.items() if any(hit.size for hit, _ in found)}


def _materials_at(stage: Stage, effects: AtWork, name: str, view: View, hit: Index) -> Mapping[str, np.ndarray]:
    """Shares of the materials that a name stands for at some hits: those of a texture, or all of a material."""
    for effect in effects.simulated:
        if effect.surface is not None:
            blended = effect.surface(stage, name, view, hit)
            if blended is not None:
                return blended
    return {name: np.ones(hit.size)}


def _in_order(found: list[tuple[np.ndarray, np.ndarray]]) -> tuple[Index, Float[np.ndarray, " point"]]:
    """Join hits and shares, and sort them by hit."""
    hit = np.concatenate([hit for hit, _ in found])
    share = np.concatenate([share for _, share in found])
    order = np.argsort(hit, kind="stable")
    return hit[order], share[order]
