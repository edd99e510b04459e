"""The objectives of a fit besides lightness: step 5 of the paper, several parameters at once.

*closest*: the least change, in logarithms of the scales, that brings the image inside.  *lexicographic*: first inside,
then exposure, then least change: no scale falls below the largest factor that all could share.  *brightest*: the
largest mean luminance.  *contrast*: the largest ratio of the luminances of regions.  Never is it the violation alone
that is minimised: black is always in gamut.

With upper bounds only, *closest* and *lexicographic* are convex in logarithms and have one solution.  *brightest* is a
linear programme where each pixel is affine in the scales, and otherwise, like *contrast*, found by tangents: the best
nearby.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.joint.constraints import LEAST, Joint, counted_pixels, joint
from symrt.feedback.joint.convex import Planes, distance
from symrt.feedback.joint.filling import Filled, Task, lightest
from symrt.feedback.joint.outermost import outermost
from symrt.feedback.joint.planes import affine, largest
from symrt.feedback.joint.posynomials import Posynomials, sliders, stacked_rows
from symrt.feedback.joint.programmes import Programme, Solved, solved
from symrt.feedback.joint.settling import GROWTH, near, raised
from symrt.feedback.reasons import Reason
from symrt.feedback.weighing import Mask, check_mask
from symrt.spectra.bands import Number
from symrt.spectra.products import gamma

Regions = Sequence[tuple[Mask, Mask]]
Pixels = Int[np.ndarray, " _"]
Point = Float[np.ndarray, " scale"]
Values = Mapping[str, float]
Matrix = Float[np.ndarray, "scale scale"]
TOP, BOTTOM = 95, 5
"""Percentiles of luminance beyond which pixels are the light and the dark region, if none are chosen."""


def closest(task: Task, allowed_dark: Number = 0.0, floor: float = 0.0, start: Values | None = None) -> Filled | None:
    """The scales of least change; where there is a floor, such that the mean luminance reaches it."""
    found = joint(task)
    origin = np.clip(np.zeros(len(found.names)), found.low, found.high)
    programme = Programme(distance(origin), found.image, found.caps, found.box, floors=_floor(found, floor))
    answer = _finished(found, programme, allowed_dark, start, most=max(1.0, task.within[0]))
    return None if answer is None else replace(answer, cost=_change(task, answer.values))


def _change(task: Task, values: Values) -> float:
    """Half the squared distance, in logarithms, from where the range is nearest to the palette given."""
    low, high = np.maximum(task.within, LEAST * task.within[1])
    away = np.log(np.maximum(list(values.values()), low)) - np.clip(0.0, np.log(low), np.log(high))
    return float(away @ away) / 2


def levelled(task: Task, budget: int = 0) -> Task:
    """The task of *closest* that *lexicographic* leaves: no scale below the largest factor, at most 1, that all share.

    Of the pixels allowed to be left out, those that are outside at that factor are.
    """
    low, high = task.within
    level = min(1.0, *lightest(task, budget).values.values())
    if not low < level < min(1.0, high):
        return task
    shared = lightest(replace(task, within=(low, level)), budget)
    return replace(task, within=(level, high), left_out=shared.left_out)


def brightest(task: Task, allowed_dark: Number = 0.0) -> Filled | None:
    """The largest mean luminance: a linear programme, or the best nearby."""
    found = joint(task)
    light = mean_luminance(found)
    if found.names and task.asked.dark is None and affine(found.image):
        answer = largest(light, found)
        return replace(_settled(found, answer, None, None), cost=-float(light.at(answer.y)[0][0]))
    return _finished(found, _ratio_programme(found, [light], [_one(found)], 0.0), allowed_dark, None, None)


def contrast(
    task: Task,
    regions: Regions | None = None,
    allowed_dark: Number = 0.0,
    floor: float = 0.0,
    start: Values | None = None,
) -> Filled | None:
    """The largest of the least ratio of mean luminances of pairs of regions, the light one first."""
    found = joint(task)
    pairs = [tuple(_pixels(task, mask) for mask in pair) for pair in regions] if regions else [_extremes(task)]
    light, dark = ([mean_luminance(found, pair[k]) for pair in pairs] for k in (0, 1))
    return _finished(found, _ratio_programme(found, light, dark, floor), allowed_dark, start, None)


def mean_luminance(found: Joint, pixels: Pixels | None = None) -> Posynomials:
    """The mean luminance of some pixels, of all that light reaches if none are named, as a posynomial.

    Raises
    ------
    ValueError
        If those pixels have no light.
    """
    task, image = found.task, found.image
    pixels = np.flatnonzero(task.system.object_pixels) if pixels is None else pixels
    products = gamma(task.system.interactions, task.painted(found.pinned)) @ task.asked.luminance
    terms = np.asarray(task.system.G[pixels].sum(axis=0)) / max(1, len(pixels)) * products
    sums = np.bincount(image.monomial, terms, len(image.exponents))
    if not sums.any():
        raise ValueError(f"a region of {len(pixels)} pixels has no light: choose regions that something is seen in")
    with np.errstate(divide="ignore"):
        return Posynomials(np.log(sums)[None], image.exponents)


def _floor(found: Joint, floor: float) -> Posynomials | None:
    if not floor:
        return None
    light = mean_luminance(found)
    return replace(light, logs=light.logs - np.log(floor))


def _one(found: Joint) -> Posynomials:
    return Posynomials(np.zeros((1, 1)), np.zeros((1, len(found.names))))


def _ratio_programme(
    found: Joint, light: Sequence[Posynomials], dark: Sequence[Posynomials], floor: float
) -> Programme:
    """The largest s below every ratio's logarithm."""
    box, count = found.box, len(found.names)

    # One more variable, the last, is s; the planes do not see it.
    planes = Planes(np.column_stack([box.normals, np.zeros(len(box.normals))]), box.offsets)

    def objective(v: Point) -> tuple[float, Point, Matrix]:
        return -float(v[-1]), np.append(np.zeros(count), -1.0), np.zeros((count + 1, count + 1))

    return Programme(
        objective,
        found.image,
        found.caps,
        planes,
        floors=_floor(found, floor),
        ratios=(stacked_rows(light), stacked_rows(dark)),
    )


def _finished(
    found: Joint, programme: Programme, allowed_dark: Number, start: Values | None, most: float | None
) -> Filled | None:
    """Solve a programme; lower bounds start from an image in which they hold: the lightest, if no other is given."""
    # Without scales that have room there is nothing to solve.
    task, counted = found.task, None
    if not found.names:
        return _settled(found, Solved(np.zeros(0), "global", 0, 0), None, most)

    # Start where lower bounds hold, and add the pixels that must stay above black there.
    if task.asked.dark is not None or not programme.convex:
        start = start or lightest(task).values
    if task.asked.dark is not None and start is not None:
        free = {name: task.symbols[name] for name in found.names}
        counted = counted_pixels(task, task.asked.dark, start, allowed_dark)
        deciding = outermost(task.system, counted, upper=False)
        dark = sliders(task.system, task.painted(found.pinned), free, task.asked.dark, deciding, upper=False)
        programme = replace(programme, dark=dark)

    # Solve, and settle the last digits.
    logs = found.low if start is None else np.log([start[name] for name in found.names])
    answer = solved(programme, _with_ratio(programme, logs), task.tick)
    if answer is None:
        return None
    return replace(_settled(found, answer, counted, most), cost=programme.objective(answer.y)[0])


def _with_ratio(programme: Programme, y: Point) -> Float[np.ndarray, " variable"]:
    if programme.ratios is None:
        return y
    light, dark = programme.ratios
    return np.append(y, (light.at(y)[0] - dark.at(y)[0]).min())


def _settled(found: Joint, answer: Solved, counted: Pixels | None, most: float | None) -> Filled:
    """The values, brought to where pixels certainly stop them, and the reasons that they are not larger."""
    # Take the scales out of their logarithms, into the range.
    task = found.task
    values = dict(found.pinned)
    values |= {
        name: float(np.clip(np.exp(y), *task.within))
        for name, y in zip(found.names, answer.y[: len(found.names)], strict=True)
    }

    # Raise each scale by what rounding left; one at the low end, or at its aim, is not raised.
    reasons, close = dict(found.reasons), near(found.image, values, found.names)
    for name in found.names:
        reasons[name] = Reason("objective")
        if values[name] <= task.within[0] * (1 + GROWTH):
            values[name], reasons[name] = task.within[0], Reason("range")
        elif most is None or values[name] < most:
            values[name], reasons[name] = raised(task, close, values, name, most)

    return Filled(
        {name: values[name] for name in task.symbols},
        {name: reasons[name] for name in task.symbols},
        found.unfixable,
        counted,
        answer.optimum,
        answer.rounds,
        answer.rows,
        task.left_out,
    )


def _pixels(task: Task, mask: Mask) -> Pixels:
    check_mask(task.system, mask, "a region's mask")
    return np.flatnonzero(mask.ravel() & task.system.object_pixels)


def _extremes(task: Task) -> tuple[Pixels, Pixels]:
    """The lightest and the darkest pixels of the image given."""
    objects = np.flatnonzero(task.system.object_pixels)
    luminance = task.system.times(gamma(task.system.interactions, task.palette) @ task.asked.luminance, objects)
    low, high = np.percentile(luminance, (BOTTOM, TOP)) if len(objects) else (0.0, 0.0)
    return objects[luminance >= high], objects[(luminance <= low) & (luminance > 0)]
