"""The largest box in which several scales may move freely and independently: step 5 of the paper.

Every coefficient of G is ≥ 0, so that no scale darkens anything.  An image whose scales lie between l and u is then
between the images at l and at u, at any degree: a box [l, u] is safe exactly if the image meets the upper bounds at u
and the lower ones at l.  The largest maximises ``Σ log(u_i − l_i)``.  In logarithms that is concave, and the upper
bounds are convex: the box found is the largest of all.  Where the device's black is kept, lower bounds are replaced by
tangents, and it is the largest nearby.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int
from tqdm.auto import tqdm

from symrt.feedback.along import along_ends
from symrt.feedback.caps import above_one
from symrt.feedback.joint.boxes import Box, SafeBox
from symrt.feedback.joint.constraints import Joint, counted_pixels, joint
from symrt.feedback.joint.convex import Objective, Planes
from symrt.feedback.joint.filling import Task, lightest
from symrt.feedback.joint.fits import certify, outside_at_rest, task_of, with_black
from symrt.feedback.joint.outermost import outermost
from symrt.feedback.joint.posynomials import sliders
from symrt.feedback.joint.programmes import Programme, Solved, solved
from symrt.feedback.joint.settling import lowered, near, raised
from symrt.feedback.limits import rising_limits
from symrt.feedback.parameters import Scale
from symrt.feedback.ranges import Range, check_share, dark_share, feasible
from symrt.feedback.reasons import Reason
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.slabs import Black
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]
Point = Float[np.ndarray, " scale"]
NARROW = 1e-9
"""Sides shorter than this, in logarithms, are none."""
NOTHING = Solved(np.zeros(0), "global", 0, 0)


def safe_box(  # noqa: PLR0913  # a public verb names its options
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    scales: Sequence[Scale],
    *,
    within: Range = (0.01, 3.0),
    black: Black | None = None,
    allowed_dark: Number = 0.0,
    reference: Reference | None = None,
    cap: bool = True,
    samples: int = 0,
    progress: bool = True,
) -> SafeBox:
    """The largest box in which all scales may move freely and independently while the image stays inside a gamut.

    Parameters
    ----------
    scales
        Of materials, components or lights; no two of the same spectrum.  Their order does not matter.
    within, black, reference, cap
        As for `fit`.
    allowed_dark
        Share of the pixels above black with the palette given that may fall below.
    samples
        Points at which to try the box of the separate ranges, seeded; 0: no comparison.
    progress
        True to count steps on standard error, after a second.

    Raises
    ------
    ValueError
        If the scales overlap, or they, the palette, the gamut and the system do not fit together, or if some
        coefficient of G is negative.

    Examples
    --------
    One pixel that two materials share: each alone may go to 3, both together not:

    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*ice.diffuse + 0.25*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "ice.diffuse": 0.5, "sea.diffuse": 0.5})
    >>> found = safe_box(system, palette, device_gamut(device), [Scale("ice"), Scale("sea")], within=(0.5, 3))
    >>> {name: (low, round(high, 9)) for name, (low, high) in found.box.items()}
    {'ice': (0.5, 2.0), 'sea': (0.5, 2.0)}
    """
    # Put the question together, and refuse parts that do not fit.
    start = time.perf_counter()
    check_share(allowed_dark, "allowed_dark")
    if within[0] == within[1]:
        raise ValueError(f"within = {within}: a box needs room, low below high")
    gamut = with_black(gamut, black)
    asked = rising_limits(system, palette, gamut, reference)
    task = task_of(system, palette, asked, scales, within, cap)

    # Find both corners, and settle each scale where a pixel certainly stops it.
    with tqdm(desc="safe box", unit="step", delay=1, leave=False, disable=not progress) as bar:
        task = replace(task, tick=bar.update)
        found = joint(task)
        bottom, top, counted, cost = _corners(task, found, allowed_dark)
        reasons = {name: (Reason("range"), why) for name, why in found.reasons.items()}
        close = near(found.image, top, found.names)
        for name in found.names:
            task.tick()
            top[name], above = raised(task, close, top, name)
            bottom[name], below = lowered(task, counted, bottom, name)
            reasons[name] = below, above

    # Compare with the ranges of single scales, if asked to.
    separate = _separate(task, gamut, reference) if samples else None
    answer = _answer(task, found, bottom, top, counted)
    return replace(
        answer,
        reasons={name: reasons[name] for name in task.symbols},
        optimum=cost.optimum,
        separate=separate,
        separate_inside=_share_inside(task, found, counted, separate, samples) if separate else None,
        rounds=cost.rounds,
        rows=cost.rows,
        seconds=time.perf_counter() - start,
    )


def _corners(
    task: Task, found: Joint, allowed_dark: Number
) -> tuple[dict[str, float], dict[str, float], Pixels, Solved]:
    """Scales at the bottom and at the top, and the pixels that must stay above black."""
    bottom, top = dict(found.pinned), dict(found.pinned)
    low, high, counted = task.within[0], task.within[1], np.zeros(0, dtype=int)

    # Without lower bounds the bottom is that of the range; with them both corners are sought.
    if task.asked.dark is None:
        programme = Programme(_room(low), found.image, found.caps, found.box)
        middle = np.full(len(found.names), np.log((low + high) / 2))
        cost = solved(programme, middle, task.tick) if found.names else NOTHING
        if cost is None:
            raise ArithmeticError("no box was found, although the low end of the range is inside")
        ends = np.full(len(found.names), low), np.exp(cost.y)
    else:
        filled = lightest(task).values
        counted = counted_pixels(task, task.asked.dark, filled, allowed_dark)
        ends, cost = _between(task, found, filled, counted)

    for name, least, most in zip(found.names, *ends, strict=True):
        bottom[name], top[name] = float(least), min(float(most), high)
    return bottom, top, counted, cost


def _between(
    task: Task, found: Joint, filled: Mapping[str, float], counted: Pixels
) -> tuple[tuple[Point, Point], Solved]:
    """The bottom and the top where both are bounded; the same point where there is no room between the bounds."""
    free = {name: task.symbols[name] for name in found.names}
    n, start = len(free), np.log([filled[name] for name in found.names])
    if task.asked.dark is None or not n:
        return (np.exp(start), np.exp(start)), NOTHING

    # The variables are the logarithms at the top, and then at the bottom.
    deciding = outermost(task.system, counted, upper=False)
    dark = sliders(task.system, task.painted(found.pinned), free, task.asked.dark, deciding, upper=False)
    eye, none = np.eye(n), np.zeros((n, n))
    planes = Planes(np.block([[eye, none], [none, -eye]]), np.concatenate([found.high, -found.low]))
    programme = Programme(_room(None), found.image, found.caps, planes, dark=dark, bottom=n)

    # Start a little below the filled image, where lower bounds hold and there is room.
    # At the filled image something is as bright as it may be, but what is darkest may still be halfway to black.
    room = np.log(dark.darkest(start)[0].min(initial=np.e)) / (2 * max(1.0, dark.exponents.sum(axis=1).max()))
    cost = solved(programme, np.concatenate([start, start - room]), task.tick) if room > NARROW else None
    if cost is None:
        return (np.exp(start), np.exp(start)), NOTHING._replace(optimum="local")
    return (np.exp(cost.y[n:]), np.exp(cost.y[:n])), cost


def _room(low: float | None) -> Objective:
    """−Σ log(u − l) in logarithms, with its derivatives; l is the same for all scales, or the rest of the variables."""

    def objective(v: Point) -> tuple[float, Point, Float[np.ndarray, "scale scale"]]:
        n = len(v) if low is not None else len(v) // 2
        y = v[:n]
        z = v[n:] if low is None else np.full(n, np.log(low) if low > 0 else -np.inf)
        if (z >= y).any():
            return np.inf, v, np.eye(len(v))
        # With t = l / u, log(u − l) is y + log(1 − t), and q = t / (1 − t) its derivatives' only ingredient.
        t = np.exp(z - y)
        q = t / -np.expm1(z - y)
        value, bend = -float(np.sum(y + np.log1p(-t))), np.zeros((len(v), len(v)))
        top = np.arange(n)
        bend[top, top] = q * (1 + q)
        if low is not None:
            return value, -1 - q, bend
        bend[top + n, top + n] = q * (1 + q)
        bend[top, top + n] = bend[top + n, top] = -q * (1 + q)
        return value, np.concatenate([-1 - q, q]), bend

    return objective


def _answer(
    task: Task, found: Joint, bottom: Mapping[str, float], top: Mapping[str, float], counted: Pixels
) -> SafeBox:
    """The box between two corners, certified once more pixel by pixel."""
    whole, bound = task.line({}, frozenset(task.symbols)), task.asked.upper
    objects = np.flatnonzero(task.system.object_pixels)
    outside = outside_at_rest(task, whole)
    excluded = np.concatenate([outside, found.unfixable])

    # All other pixels must be inside at the top; those counted must be above black at the bottom.
    light, dark = (along_ends(task.system, task.painted(corner), {}) for corner in (top, bottom))
    certify(light, whole, bound, np.setdiff1d(objects, excluded, assume_unique=True))
    if task.asked.dark is not None:
        certify(dark, whole, task.asked.dark, counted)

    return SafeBox(
        box={name: (bottom[name], top[name]) for name in task.symbols},
        reasons={},
        optimum="global",
        separate=None,
        separate_inside=None,
        within=task.within,
        verdict="rest-only" if len(excluded) else "complete",
        untouched_outside=outside,
        unfixable=found.unfixable,
        dark=dark_share(dark, task.asked, objects, 1.0),
        objects=len(objects),
        above_one=above_one(task.painted(top)),
        note=task.asked.note,
        width=task.system.width,
        rounds=0,
        rows=0,
        seconds=0.0,
    )


def _separate(task: Task, gamut: ConvexGamut | UnevenGamut, reference: Reference | None) -> Box:
    """The range of each scale, all others as given."""
    ranges = {}
    for name in task.symbols:
        alone = feasible(
            task.system, task.palette, gamut, Scale(name), within=task.within, reference=reference, cap=task.cap
        )
        if not alone.intervals:
            return {}
        ranges[name] = alone.intervals[0]
    return ranges


def _share_inside(task: Task, found: Joint, counted: Pixels, box: Box, samples: int) -> float:
    """Share of seeded random points of a box at which every pixel is inside."""
    low, high = np.array([box[name] for name in task.symbols]).T
    draws = np.random.default_rng(0).uniform(low, high, (samples, len(low)))
    bound = task.asked.dark
    light = sliders(task.system, task.palette, task.symbols, task.asked.upper, found.image.pixels)
    dark = None if bound is None else sliders(task.system, task.palette, task.symbols, bound, counted, upper=False)
    inside = [
        bool((light.brightest(y)[0] <= 1).all() and (dark is None or (dark.darkest(y)[0] >= 1).all()))
        for y in np.log(draws)
    ]
    return float(np.mean(inside))
