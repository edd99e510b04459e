"""What each hit is made of, and what its materials' formulas ask about it (step 1)."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import dot
from symrt.geometry.textures import weights
from symrt.reflection.symbols import VIEW
from symrt.scene.lights import Light
from symrt.tracing.factors import factors
from symrt.tracing.plan import direct_lights
from symrt.tracing.raytree import Lit, Points
from symrt.tracing.shadows import visible
from symrt.tracing.stage import Stage
from symrt.tracing.view import View

Index = Int[np.ndarray, " point"]
Shares = dict[str, tuple[Index, Float[np.ndarray, " point"]]]


@dataclass(frozen=True, eq=False)
class Facing:
    """The hits that one light faces, on the viewer's side of the surface and of its smoothed normal.

    Parameters
    ----------
    position
        For each hit of the level its place among the facing ones, −1 where the light is behind.
    """

    position: Int[np.ndarray, " hit"]
    direction: Float[np.ndarray, "3 lit"]
    irradiance: Float[np.ndarray, " lit"]
    visible: Float[np.ndarray, " lit"]


def points(stage: Stage, view: View, count: Counter[str]) -> tuple[Points, ...]:
    """All points of a level, by material in the order of names; alternatives follow what they may replace."""
    facing = {light.name: _facing(stage, light, view, count) for light in direct_lights(stage.lights)}
    found = []
    for material, (hit, weight) in sorted(_shares(stage, view).items()):
        for name in (material, *(f"{material}>{other}" for other in stage.alternatives.get(material, ()))):
            model = stage.materials[name].model
            seen = factors(model.factors & VIEW, view.shading_normal[:, hit], view.viewer[:, hit], None)
            lit = tuple(_lit(view, light, facing[light], hit, model.factors) for light in sorted(facing))
            found.append(Points(name, hit, weight, lit, seen))
    return tuple(found)


def _facing(stage: Stage, light: Light, view: View, count: Counter[str]) -> Facing:
    light_at = light.illuminate(view.surface.point)
    above = (dot(view.normal, light_at.direction) > 0) & (dot(view.shading_normal, light_at.direction) > 0)
    hit = np.flatnonzero(above & (light_at.falloff > 0))
    casts = light.shadows and "shadows" in stage.plan
    seen = visible(stage, view, hit, light_at, count) if casts else np.ones(hit.size)
    position = np.full(view.slot.size, -1)
    position[hit] = np.arange(hit.size)
    return Facing(position, light_at.direction[:, hit], light_at.falloff[hit], seen)


def _lit(view: View, light: str, facing: Facing, hit: Index, names: frozenset[str]) -> Lit:
    position = facing.position[hit]
    point = np.flatnonzero(position >= 0)
    position, hit = position[point], hit[point]
    found = factors(names - VIEW, view.shading_normal[:, hit], view.viewer[:, hit], facing.direction[:, position])
    return Lit(light, point, facing.irradiance[position], facing.visible[position], found)


def _shares(stage: Stage, view: View) -> Shares:
    """Hits and weights of each material, a texture's blends taken apart; hits ascend."""
    parts: dict[str, list[tuple[np.ndarray, np.ndarray]]] = {}
    for slot in np.unique(view.slot):
        hit = np.flatnonzero(view.slot == slot)
        for material, share in _blend(stage, stage.slots[slot], view, hit).items():
            present = share > 0
            parts.setdefault(material, []).append((hit[present], share[present]))
    return {name: _in_order(found) for name, found in parts.items() if any(hit.size for hit, _ in found)}


def _blend(stage: Stage, name: str, view: View, hit: Index) -> Mapping[str, np.ndarray]:
    texture = stage.textures.get(name)
    if texture is None:
        return {name: np.ones(hit.size)}
    share = weights(texture, view.surface.uv[:, hit], view.surface.extent[:, hit])
    blended: dict[str, np.ndarray] = {}
    for material, row in zip(texture.materials, share, strict=True):  # type: ignore[attr-defined]
        blended[material] = blended.get(material, 0) + row
    return blended


def _in_order(found: list[tuple[np.ndarray, np.ndarray]]) -> tuple[Index, Float[np.ndarray, " point"]]:
    hit = np.concatenate([hit for hit, _ in found])
    share = np.concatenate([share for _, share in found])
    order = np.argsort(hit, kind="stable")
    return hit[order], share[order]
