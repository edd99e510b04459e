"""Fit the scales of several materials, or lights, to a gamut at once: step 5 of the paper, its Figure 3.

Limits found one material at a time depend on the order of the materials as soon as a mirror shows one in another.
Filling does not: see `symrt.feedback.joint.filling`.  The image that comes out is checked once more, pixel by pixel.
"""

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Literal

import numpy as np
from jaxtyping import Int
from tqdm.auto import tqdm

from symrt.errors import require, require_list
from symrt.feedback.along import Along, along_ends
from symrt.feedback.bounds import Bound
from symrt.feedback.caps import above_one
from symrt.feedback.intervals import certified, inside_at
from symrt.feedback.joint.acceptance import OBJECTIVES, Answer, Goal, answered
from symrt.feedback.joint.filling import Filled, Task, first_limits
from symrt.feedback.joint.fitted import Fit
from symrt.feedback.joint.objectives import Regions
from symrt.feedback.limits import Limits, rising_limits
from symrt.feedback.parameters import Scale, moved_ends
from symrt.feedback.ranges import Range, check_share, checked_range, dark_share
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.slabs import Black, Gamut
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]


def fit(  # noqa: PLR0913  # a public verb names its options
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    scales: Sequence[Scale],
    *,
    objective: Goal = "lexicographic",
    within: Range = (0.01, 3.0),
    black: Black | None = None,
    allowed_out: Number = 0.0,
    allowed_dark: Number = 0.0,
    reference: Reference | None = None,
    cap: bool = True,
    regions: Regions | None = None,
    least_luminance: Number = 0.5,
    progress: bool = True,
) -> Fit:
    """The palette in a range of scales that keeps the image inside a gamut and is best in some respect.

    Parameters
    ----------
    scales
        Of materials, components or lights; no two of the same spectrum.  Their order does not matter.
    objective
        ``"lexicographic"``, the default: first inside, then exposed as well as may be, then changed least: no scale
        falls below the largest factor that all could share.  ``"closest"``: the least change, in logarithms.
        ``"lightest"`` raises all scales together and each as far as it goes; ``"darkest"`` lowers them in the same way
        from there, and none rises above its lightest value.
        ``"brightest"``: the largest mean luminance.  ``"contrast"``: the largest ratio of luminances of regions.
    within
        The least and the largest scale.
    black
        The treatment of the dark, if other than the gamut's own: see `Gamut`.
    allowed_out
        Share of the object pixels that may be outside; those that no scales bring inside count.  Which ones is chosen
        with the scales.  That choice is exact where all scales move together: with a single scale, in the factor that
        all share in the ``"lightest"``, and in the least scale of the ``"lexicographic"`` one.  Otherwise it is
        combinatorial: what is found is the best nearby (``optimum``), and never worse than with none left out.  A
        mean luminance is that of all pixels, and ``"darkest"`` leaves out those that the ``"lightest"`` does.
    allowed_dark
        Share of the pixels above black with the palette given that the darkest image may let fall below.
    reference, cap
        As for `feasible`.
    regions
        For ``"contrast"``: pairs of masks, light and dark, whose least ratio of mean luminances counts; if not given,
        the lightest and the darkest twentieth of the image given.
    least_luminance
        Share of the mean of min(Y, 1) of the image given that an acceptable answer's mean luminance keeps; 0 accepts
        any.  It does not bind ``"darkest"``.
    progress
        True to count steps on standard error, after a second.

    Raises
    ------
    ValueError
        If the scales overlap, or they, the palette, the gamut and the system do not fit together.

    Examples
    --------
    Sea and ice stop at the print's white, each on its own:

    >>> from symrt.device.inks import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.5*sun*ice.diffuse", "0.25*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "ice.diffuse": 0.8, "sea.diffuse": 0.2})
    >>> found = fit(
    ...     system, palette, device_gamut(device), [Scale("ice"), Scale("sea")], objective="lightest", cap=False
    ... )
    >>> {name: round(value, 9) for name, value in found.values.items()}
    {'ice': 1.25, 'sea': 3.0}

    With half of the pixels allowed out, the sun may be as bright as the sea can be printed; ice is left out:

    >>> options = {"objective": "lightest", "within": (0.5, 10), "allowed_out": 0.5}
    >>> found = fit(system, palette, device_gamut(device), [Scale("sun")], **options)
    >>> round(found.values["sun"], 9), found.left_out
    (10.0, array([0]))
    """
    # Put the question together, and refuse parts that do not fit.
    start = time.perf_counter()
    _check(objective, regions, allowed_out=allowed_out, allowed_dark=allowed_dark, least_luminance=least_luminance)
    asked = rising_limits(system, palette, with_black(gamut, black), reference)
    task = task_of(system, palette, asked, scales, within, cap)
    whole = task.line({}, frozenset(task.symbols))

    # The pixels that no scales bring inside count among those allowed out.
    outside = outside_at_rest(task, whole)
    most = int(allowed_out * int(system.object_pixels.sum()) + 1e-9)
    budget = max(0, most - len(outside) - len(first_limits(task)[1])) if most else 0

    # Answer, and certify the answer pixel by pixel.
    with tqdm(desc="fit", unit="step", delay=1, leave=False, disable=not progress) as bar:
        answer = answered(
            replace(task, tick=bar.update),
            objective,
            allowed_dark=allowed_dark,
            regions=regions,
            least_luminance=least_luminance,
            budget=budget,
        )
    found = _checked(task, whole, answer, outside, most)
    kept = as_asked(reference).kept(system, palette)
    return replace(
        found,
        palette=replace(found.palette, white=kept.radiance),
        reference=kept,
        objective=objective,
        seconds=time.perf_counter() - start,
    )


def outside_at_rest(task: Task, whole: Along) -> Pixels:
    """The object pixels that no scale moves, and that are outside."""
    objects, bound = np.flatnonzero(task.system.object_pixels), task.asked.upper
    untouched = objects[~whole.touched[objects]]
    return untouched[~inside_at(whole.seen(bound.matrix, untouched), bound, 0.0)]


def _checked(task: Task, whole: Along, answer: Answer, outside: Pixels, most: int) -> Fit:
    """The fit of an answer, certified once more pixel by pixel; `most` pixels may be outside."""
    found, system = answer.found, task.system
    objects, fitted = np.flatnonzero(system.object_pixels), task.painted(found.values)

    # Shade with the palette found, and certify all pixels but those left out.
    final = along_ends(system, fitted, {})
    left_out = _certified(final, whole, task, found, np.setdiff1d(objects, outside, assume_unique=True))

    out = len(outside) + len(found.unfixable) + len(left_out)
    return Fit(
        palette=fitted,
        values=found.values,
        reasons=found.reasons,
        objective="",
        within=task.within,
        verdict=_verdict(out > most, answer.acceptable),
        untouched_outside=outside,
        unfixable=found.unfixable,
        left_out=left_out,
        dark=dark_share(final, task.asked, objects, 1.0),
        objects=len(objects),
        above_one=above_one(fitted),
        optimum=found.optimum,
        luminance=answer.luminance,
        rounds=found.rounds,
        rows=found.rows,
        note=task.asked.note,
        width=system.width,
        reference=Reference(),
        seconds=0.0,
    )


def _check(objective: Goal, regions: Regions | None, **shares: Number) -> None:
    """Refuse objectives that do not exist, regions without contrast, and shares beyond 0 and 1."""
    if objective not in OBJECTIVES:
        raise ValueError(f"objective = {objective!r}: there are {', '.join(OBJECTIVES)}")
    if regions is not None and objective != "contrast":
        raise ValueError(f"regions were given, which the objective {objective!r} does not look at: use 'contrast'")
    for name, share in shares.items():
        check_share(share, name)


def _certified(final: Along, whole: Along, task: Task, found: Filled, objects: Pixels) -> Pixels:
    """The pixels left out that cannot be certified inside, after all others are."""
    bound, spared = task.asked.upper, np.setdiff1d(found.left_out, found.unfixable)
    inside = certified(final.seen(bound.matrix, spared), whole.seen(bound.matrix, spared), bound)
    left_out = spared[~inside]
    certify(final, whole, bound, np.setdiff1d(objects, np.concatenate([found.unfixable, left_out]), assume_unique=True))
    if task.asked.dark is not None and found.lit is not None:
        certify(final, whole, task.asked.dark, found.lit)
    return left_out


def _verdict(outside: bool, acceptable: bool) -> Literal["complete", "rest-only", "unacceptable"]:
    if not acceptable:
        return "unacceptable"
    return "rest-only" if outside else "complete"


def with_black(gamut: ConvexGamut | UnevenGamut, black: Black | None) -> ConvexGamut | UnevenGamut:
    """The gamut with another treatment of black, if one is given: only bounds in each band have a choice."""
    if black is None:
        return gamut
    if not isinstance(gamut, Gamut):
        raise ValueError(  # noqa: TRY004  # another model of the same device is a bad choice, not another type to a user
            f"black = {black!r}: {gamut.name} has its own black; leave it out"
        )
    return device_gamut(gamut.device, gamut.model, black)


def task_of(
    system: LinearSystem, palette: Palette, asked: Limits, scales: Sequence[Scale], within: Range, cap: bool
) -> Task:
    """The task of several scales, no two of which may multiply the same spectrum."""
    symbols = symbols_of(system, palette, scales)
    names = sorted(symbols)
    if not names:
        raise ValueError("no scales to fit: give for example [Scale('sea'), Scale('brass')]")
    task = Task(system, palette, asked, {n: symbols[n] for n in names}, checked_range(Scale(names[0]), within), cap)
    least = task.painted(dict.fromkeys(names, task.within[0]))
    if cap and (above := above_one(least, frozenset().union(*symbols.values()))):
        raise ValueError(
            f"within = {within}: even at {within[0]:g} more would be reflected than received by {', '.join(above)}: "
            "begin lower, or let them with cap=False"
        )
    return task


def symbols_of(system: LinearSystem, palette: Palette, scales: Sequence[Scale]) -> dict[str, frozenset[str]]:
    """The spectra that each scale multiplies.

    Raises
    ------
    ValueError
        If there is nothing of that name, a scale is named twice, or two multiply the same spectrum.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.spectra.bands import RGB
    >>> palette = Palette(RGB, {"sun": 1, "sea.diffuse": 0.2, "sea.mirror": 0.1})
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 1.0})
    >>> {name: sorted(symbols) for name, symbols in symbols_of(system, palette, [Scale("sea"), Scale("sun")]).items()}
    {'sea': ['sea.diffuse', 'sea.mirror'], 'sun': ['sun']}
    """
    require_list("scales", scales, "[Scale('sea'), Scale('brass')]")
    for scale in scales:
        require("scale", scale, Scale, "Scale('brass') for each spectrum")
    names = [scale.name for scale in scales]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"the scale of {twice[0]} is named twice: name each scale once")
    symbols = {scale.name: frozenset(moved_ends(system, palette, scale)) for scale in scales}
    for one, other in combinations(sorted(symbols), 2):
        if both := symbols[one] & symbols[other]:
            raise ValueError(f"scales of {one} and of {other} both multiply {min(both)}: give each spectrum one scale")
    return symbols


def certify(final: Along, whole: Along, bound: Bound, pixels: Pixels) -> None:
    """Make sure that every pixel is inside whatever its rounding."""
    inside = certified(final.seen(bound.matrix, pixels), whole.seen(bound.matrix, pixels), bound)
    if not inside.all():
        raise ArithmeticError(f"pixel {pixels[~inside][0]} could not be certified inside")
