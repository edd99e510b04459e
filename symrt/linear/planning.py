"""Plan a render: the effects a scene calls for, what they will cost, and what pixels miss without them (before step 1).

Costs are those of two coarse renders by the real tracer: what the larger takes more than the smaller is the price of
its rays, and the rest that of a tile.  Pixels are compared with those of a coarse render that leaves an effect out:
``Σ_i |Δg_i|`` is what one misses at most, whatever the spectra are, as long as no reflectance passes 1.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symrt.linear.collapse import run
from symrt.linear.energy import brightening
from symrt.linear.program import Program, Values, make_program
from symrt.linear.tiles import tiles
from symrt.scene.records import Scene
from symrt.system import LinearSystem
from symrt.tails import Shares, Tail
from symrt.tracing.plan import Expectation, Expected, Plan
from symrt.tracing.planner import first_plan
from symrt.tracing.stage import Alternatives, Stage, make_stage
from symrt.tracing.tally import CAMERA
from symrt.tracing.tracer import trace_window
from symrt.tracing.work import at_work
from symrt.windows import EVERYWHERE

FEW, MANY = (16**2, 48), (40**2, 192)
"""Pixels of the smaller and of the larger coarse render: as a rule, and at least."""
RAYS = 32
"""Rays for each of these pixels beyond which there are fewer of them."""
REPEATED = 2
"""Times that each is made: the faster one counts."""
REFLECTANCE = 0.8
"""The largest reflectance that a certificate is foretold for where with reflectances of 1 there would be none."""


def plan(
    scene: Scene,
    alternatives: Alternatives | None = None,
    *,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    probe: bool = False,
) -> Plan:
    """Plan the render of a scene: the effects it calls for, and why the others are not simulated.

    Parameters
    ----------
    alternatives
        Other materials that are traced too, as for `trace`; they may call for effects of their own.
    force
        Effects to leave out, ``{"shadows": False}``: the error without them is bounded in the system's tail.  True
        insists on an effect, and is refused where it is not simulated.
    tolerance
        Rays that carry less than this share of their film sample's light are not followed, 0.001 if not given; with 0
        all are, down to the scene's depth.  Where it is given, effects are left out that a coarse render meets, but
        of which even together it misses less than this share of white.  Whatever is left out is bounded in the tail.
    probe
        True to add what each effect is expected to cost on this machine, and what pixels would miss without it: this
        takes some coarse renders.

    Raises
    ------
    ValueError
        If `force` names no effect, or one that cannot be forced so, or the tolerance is no share.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> scene = load_scene(shipped_scene("spheres"))
    >>> print(plan(scene))
    effect               called for by                 rays at most
    shadows   simulated  lamp                          1 a hit
    mirrors   simulated  chrome, light_tile,           4 a sample, down to 0.1% of a
                         dark_tile                     sample
    ambient   simulated  sky                           none
    textures  simulated  tiles                         none
    not called for: penumbrae, refraction, ...
    >>> found = plan(scene, probe=True).expectation.effects["mirrors"]
    >>> found.rays > 100_000, found.most > found.mean > 0
    (True, True)
    """
    chosen = first_plan(scene, alternatives, force=force, tolerance=tolerance)
    chosen = replace(chosen, remarks=(*chosen.remarks, *brightening(scene)))
    if tolerance is None and not probe:
        return chosen
    stage = make_stage(scene, alternatives)
    chosen = thrifty(chosen, stage, tolerance, force or {})
    return replace(chosen, expectation=_expectation(chosen, stage)) if probe else chosen


def thrifty(
    chosen: Plan,
    stage: Stage,
    tolerance: float | int | None,
    force: Mapping[str, bool],
    values: Values | None = None,
) -> Plan:
    """The plan without those effects that together are missed by less than a tolerance, as a coarse render tells."""
    if not tolerance:
        return chosen
    program = make_program(stage.materials, values, gathered=at_work(chosen).gathered)
    asked = [effect.name for effect in chosen.effects if effect.simulated and effect.optional]
    coarse = _coarse(stage, chosen, FEW)
    whole = _rendered(coarse, chosen, program)
    each = {name: _missed(whole, _rendered(coarse, chosen.without(name), program))[0] for name in asked}
    for name in sorted(asked, key=lambda name: (each[name], name)):
        # An effect that no ray of the coarse render met may still be all of a pixel's light.
        if each[name] > 0 and not force.get(name):
            less = chosen.without(name, f"without it pixels miss less than the tolerance, {100 * tolerance:.2g}%")
            if _missed(whole, _rendered(coarse, less, program))[0] < tolerance:
                chosen = less
    return chosen


def _expectation(chosen: Plan, stage: Stage) -> Expectation:
    """The expected costs of all effects that are simulated, and what pixels miss without those that may be left out."""
    # Coarse renders: the first pays for what is paid once.
    program = make_program(stage.materials, gathered=at_work(chosen).gathered)
    coarse, finer = (_coarse(stage, chosen, size) for size in (FEW, MANY))
    few, many = ([_rendered(one, chosen, program) for _ in range(REPEATED)] for one in (coarse, finer))
    small, large = few[0].counts, many[0].counts

    # Coarse renders without an effect, or with one that was left out.
    certified, missed = {}, {}
    for effect in chosen.called_for:
        if effect.optional:
            other = chosen.without(effect.name) if effect.simulated else chosen.restored(effect.name)
            system = _rendered(coarse, other, program)
            missed[effect.name] = _missed(few[0], system)
            certified[effect.name] = _certified(system if effect.simulated else few[0])

    # As often as there are such pixels, and such tiles, in the picture.
    camera = stage.camera
    pixels = camera.width * camera.height
    count = len(tiles(camera.width, camera.height, camera.rays_a_pixel, chosen.rays_a_sample))
    found = {}
    for name in dict.fromkeys([*large.effects, *missed]):
        rays, seconds = 0, 0.0
        if name in large.effects:
            rays = round(large.effects[name].rays * pixels / large.pixels)
            less, more = (min(one.counts.effects[name].seconds for one in systems) for systems in (few, many))
            a_pixel = max(0.0, (more - less) / (large.pixels - small.pixels))
            seconds = a_pixel * pixels + max(0.0, less - a_pixel * small.pixels) * count
        most, mean = missed.get(name, (None, None))
        found[name] = Expected(rays, seconds, most, mean, certified.get(name))
    return Expectation(found, large.effects[CAMERA].rays, small.pixels)


def _missed(whole: LinearSystem, other: LinearSystem) -> tuple[float, float]:
    """The largest share of white that pixels of two renders may differ by, and the mean of all pixels.

    White is what a perfect diffuser at the camera's target sends of all lights, each of which it faces: as no spectrum
    is known, a pixel's share is that of the light of which it is largest, and of the window of wavelengths.
    """
    # The difference of each column, whether one of the pictures has it or both.
    columns = {i: number for number, i in enumerate(sorted({*whole.interactions, *other.interactions}))}
    size = whole.height * whole.width
    differences = np.zeros((size, len(columns)))
    for system, sign in ((whole, 1.0), (other, -1.0)):
        found = system.times(np.eye(len(system.interactions)))
        differences[:, [columns[i] for i in system.interactions]] += sign * found

    # All columns of a light together, but of its windows of wavelengths only the one that matters most.
    sums: dict[str, dict[tuple[float, ...], np.ndarray]] = {}
    for interaction, number in columns.items():
        windows = sums.setdefault(interaction.light, {})
        before = windows.get(interaction.window, np.zeros(size))
        windows[interaction.window] = before + np.abs(differences[:, number])
    share = np.zeros(size)
    for light, windows in sums.items():
        always = windows.pop(EVERYWHERE, np.zeros(size))
        most = always + np.max([np.zeros(size), *windows.values()], axis=0)
        white = whole.white[light]
        known = most / white if white else np.inf
        share = np.maximum(share, np.where(most > 0, known, 0.0))
    return float(share.max()), float(share.mean())


def _certified(system: LinearSystem) -> float:
    """The largest share of white that a certificate would bound pixels by; infinite if it knows no bound."""
    # For reflectances up to 1, unless there is no bound then.
    tail = system.tail
    if tail is None or not tail.bound.nnz:
        return 0.0
    reflectance = 1.0 if _sent_on(tail, 1.0) < 1 else REFLECTANCE
    left = 1 - _sent_on(tail, reflectance)
    if left <= 0 or not np.isfinite(tail.bound.data).all() or not all(system.white.values()):
        return float("inf")
    lights = list(system.white)
    weights = np.zeros((len(tail.interactions), len(lights)))
    for column, interaction in enumerate(tail.interactions):
        share = reflectance**interaction.degree / (left * system.white[interaction.light])
        weights[column, lights.index(interaction.light)] = share
    return float((tail.bound @ weights).max())


def _sent_on(tail: Tail, reflectance: float) -> float:
    """The largest share that a material sends on of what rays bring; infinite if one adds to it."""
    if any(_sum(shares, reflectance) > 1 + 1e-9 for shares in tail.passed):
        return float("inf")
    return max((_sum(shares, reflectance) for shares in tail.reflected), default=0.0)


def _sum(shares: Shares, reflectance: float) -> float:
    return sum(most * reflectance ** len(met) for met, most in shares)


def _coarse(stage: Stage, chosen: Plan, size: tuple[int, int]) -> Stage:
    """The stage with a film of so many pixels, or of less where the plan expects many rays for each of them."""
    most, least = size
    camera = stage.camera
    pixels = max(least, most * min(1.0, RAYS / (camera.rays_a_pixel * chosen.rays_a_sample)))
    across = max(1, round((pixels * camera.width / camera.height) ** 0.5))
    return replace(stage, camera=replace(camera, width=across, height=max(1, round(pixels / across))))


def _rendered(stage: Stage, chosen: Plan, program: Program) -> LinearSystem:
    return run(program, trace_window(stage, chosen))
