"""Plan a trace: the effects that a scene calls for; one that nothing calls for is never simulated (before step 1)."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from symrt.errors import refuse, require, shown, suggestion
from symrt.geometry.rays import clearance, inside
from symrt.scene.records import Scene
from symrt.scene.surface_lights import SurfaceLight
from symrt.tracing import effects
from symrt.tracing.effects.effect import CARRIED, Call, Effect
from symrt.tracing.plan import ON_REQUEST, TOLERANCE, Plan, Planned, Status
from symrt.tracing.stage import Alternatives, checked_alternatives

MOST_HITS = 16
"""Hits that a sample is expected to have: rays that branch at each of many levels mostly leave the scene before."""


def first_plan(
    scene: Scene,
    alternatives: Alternatives | None = None,
    *,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
) -> Plan:
    """The plan of a trace as far as the scene alone tells, without a ray: see `plan`, which takes the same.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> print(first_plan(load_scene(shipped_scene("first"))))
    effect              called for by  rays at most
    shadows  simulated  sun            1 a hit
    not called for: penumbrae, mirrors, ...
    """
    require("scene", scene, Scene, "a Scene, load_scene(path)")
    force, known = force or {}, {effect.name for effect in effects.EFFECTS}
    refuse(
        f"force: there is no effect {name!r}; {suggestion(name, sorted(known))}" for name in force if name not in known
    )
    alternatives = checked_alternatives(scene, alternatives or {})
    tolerance = TOLERANCE if tolerance is None else _checked(tolerance)
    calls = {effect.name: effect.call(scene, alternatives) for effect in effects.EFFECTS}
    planned = [_planned(effect, calls[effect.name], force.get(effect.name), tolerance) for effect in effects.EFFECTS]
    counted = tuple(_counted(planned, calls, scene.depth))
    return Plan(counted, (*_glow_remarks(scene, planned), *_remarks(scene)), tolerance)


def _checked(tolerance: float | int) -> float:
    if isinstance(tolerance, bool) or not 0 <= tolerance < 1:
        raise ValueError(f"tolerance = {shown(tolerance)}: give a share of the light from 0 to below 1, such as 0.001")
    return float(tolerance)


def _glow_remarks(scene: Scene, planned: Sequence[Planned]) -> Iterator[str]:
    """A sentence about the light of surfaces that glow, where no other surface gathers it."""
    simulated = {effect.name for effect in planned if effect.simulated}
    gathered = any(effect.gathers for effect in effects.EFFECTS if effect.name in simulated)
    glowing = [light.name for light in scene.lights if isinstance(light, SurfaceLight)]
    if glowing and "emission" in simulated and not gathered:
        yield f"The light of surfaces, {', '.join(glowing)}, is seen; on others it falls only by interreflection."


def _remarks(scene: Scene) -> Iterator[str]:
    """Sentences about closed shapes that the camera or a light stands in; a mesh that is still a file is not asked."""
    for index, shape in enumerate(scene.shapes):
        if hasattr(shape, "file"):
            continue

        # The camera inside of a closed shape.
        eye = inside(shape, scene.camera.position)
        kind = getattr(shape, "type", "mesh")
        if eye:
            yield f"The camera is inside shapes[{index}], a {kind}: it sees what is inside, and its inner side."
        if scene.camera.lens_diameter > 2 * clearance(shape, np.array(scene.camera.position, dtype=float)):
            yield f"The lens reaches into shapes[{index}], a {kind}: from there it sees past its surface."

        # Walls let nothing through: a light and the camera on two sides of one see nothing of each other.
        for light in scene.lights:
            place = getattr(light, "position", getattr(light, "centre", None))
            lamp = place is not None and inside(shape, place)
            known = place is not None or hasattr(light, "direction")
            if light.shadows and known and lamp != eye:
                here, there = ("inside", "outside of") if lamp else ("outside of", "inside")
                yield f"The light {light.name} is {here} shapes[{index}], a {kind}: it does not shine {there} it."


def _planned(effect: Effect, call: Call, forced: bool | None, tolerance: float) -> Planned:
    # Not called for, or simulated.
    if not call.by:
        if forced:
            raise ValueError(f"force: nothing calls for {effect.name}: {call.without}")
        return Planned(effect.name, "not called for", (), call.without, "none")
    left_out = call.left_out or (ON_REQUEST if forced is False else "")
    if not left_out:
        pruned = f", down to {100 * tolerance:.2g}% of a sample" if CARRIED in effect.state and tolerance else ""
        optional = not effect.needed and not effect.unbounded
        return Planned(effect.name, "simulated", call.by, "", call.rays + pruned, optional=optional)

    # Left out, if it may be.
    if forced:
        raise ValueError(f"force: {effect.name} cannot be simulated: {left_out}")
    if forced is False and effect.needed:
        raise ValueError(f"force: {effect.name} cannot be left out: {effect.needed}")
    state: Status = "left out, not bounded" if effect.unbounded else "left out, bounded"
    optional = not (call.left_out or effect.needed or effect.unbounded)
    return Planned(effect.name, state, call.by, left_out, "none", optional=optional)


def _counted(planned: list[Planned], calls: Mapping[str, Call], depth: int) -> Iterator[Planned]:
    """The effects with the rays that a sample is expected to cost, as if each of its rays met something."""
    simulated = [calls[effect.name] for effect in planned if effect.simulated]
    # A hit is mostly of one material, which sends rays on by one effect.
    sent = max((call.onwards for call in simulated), default=0)

    # Hits of a sample, level by level; where they branch, no more are expected than MOST_HITS.
    hits, level = 1, 1
    for _ in range(depth if sent else 0):
        level *= sent
        hits += level
        if hits >= MOST_HITS:
            hits = MOST_HITS
            break
    gathered = sum(call.gathered for call in simulated)
    for effect in planned:
        call = calls[effect.name]
        share = call.onwards * (hits - 1) // sent if sent else 0
        expected = call.a_hit * (hits + gathered) + share + call.gathered
        yield replace(effect, a_sample=expected) if effect.simulated else effect
