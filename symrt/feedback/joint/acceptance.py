"""A fit's answer must still be a picture: step 5 of the paper, and its guard against the trivial solution.

Black is in every gamut.  An answer is acceptable only if its mean luminance is at least a share, half unless told
otherwise, of the mean of min(Y, 1) over the image given.  An objective whose best falls short is asked again with that
as a lower bound, from the brightest image inside; if even that one is too dark, there is no acceptable solution.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.joint.filling import Filled, Task, darkest, lightest
from symrt.feedback.joint.leaving import leave_out
from symrt.feedback.joint.objectives import Regions, brightest, closest, contrast, levelled
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma

Goal = Literal["lightest", "darkest", "closest", "lexicographic", "brightest", "contrast"]
OBJECTIVES: tuple[Goal, ...] = ("lightest", "darkest", "closest", "lexicographic", "brightest", "contrast")
LUMINANCE_ROUNDING = 1e-9
"""Share of the luminance that may be missing without making an answer unacceptable."""


class Answer(NamedTuple):
    """The scales found, their mean luminance as a share of that of the image given, and whether that is enough."""

    found: Filled
    luminance: float
    acceptable: bool


def answered(
    task: Task,
    goal: Goal,
    *,
    allowed_dark: Number = 0.0,
    regions: Regions | None = None,
    least_luminance: Number = 0.5,
    budget: int = 0,
) -> Answer:
    """The scales that an objective asks for, and whether they leave enough of the picture.

    A budget of pixels may be left outside.
    """
    enough = least_luminance * (1 - LUMINANCE_ROUNDING)
    # Filling answers directly.
    if goal in ("lightest", "darkest"):
        found = lightest(task, budget)
        if goal == "darkest":
            found = darkest(task, found, allowed_dark)
        kept = _kept(task, found)
        return Answer(found, kept, goal == "darkest" or kept >= enough)

    # Ask for the objective alone; that is the answer if it leaves enough.
    if goal == "lexicographic":
        task, budget = _levelled(task, budget)
    best = _found(leave_out(task, _ask(goal, allowed_dark, regions), budget), goal)
    kept = _kept(task, best)
    if kept >= enough or goal == "brightest":
        return Answer(best, kept, kept >= enough)

    # Otherwise ask again, with the luminance as a lower bound, if the brightest image has that much.
    light = _found(leave_out(task, _ask("brightest", allowed_dark, None), budget), "brightest")
    if _kept(task, light) < least_luminance:
        return Answer(best, kept, acceptable=False)
    floor = float(least_luminance) * _mean(task, task.palette, _seen(task, light), 1.0)
    # Lower bounds start from an image in which they hold: with the pixels left out that it leaves out.
    bright = replace(task, left_out=light.left_out)
    spare = budget - (len(light.left_out) - len(task.left_out))
    again = leave_out(bright, _ask(goal, allowed_dark, regions, floor, light.values), spare)
    if again is None or _kept(task, again) < enough:
        return Answer(best, kept, acceptable=False)
    return Answer(again, _kept(task, again), acceptable=True)


def _levelled(task: Task, budget: int) -> tuple[Task, int]:
    level = levelled(task, budget)
    return level, budget - (len(level.left_out) - len(task.left_out))


def _ask(
    goal: Goal,
    allowed_dark: Number,
    regions: Regions | None,
    floor: float = 0.0,
    start: Mapping[str, float] | None = None,
) -> Callable[[Task], Filled | None]:
    def ask(task: Task) -> Filled | None:
        if goal == "contrast":
            return contrast(task, regions, allowed_dark, floor, start)
        if goal == "brightest":
            return brightest(task, allowed_dark)
        return closest(task, allowed_dark, floor, start)

    return ask


def _found(found: Filled | None, goal: Goal) -> Filled:
    if found is None:
        raise ArithmeticError(f"the search for the {goal} image did not settle, although some image is inside")
    return found


def _kept(task: Task, found: Filled) -> float:
    """Mean luminance as a share of the mean of min(Y, 1) of the image given, without what no scales bring inside.

    Pixels that are left outside may be lighter than white: they count with min(Y, 1), too.
    """
    seen = _seen(task, found)
    given = _mean(task, task.palette, seen, 1.0)
    most = 1.0 if len(found.left_out) else np.inf
    return _mean(task, task.painted(found.values), seen, most) / given if given else 1.0


def _seen(task: Task, found: Filled) -> Int[np.ndarray, " pixel"]:
    return np.setdiff1d(np.flatnonzero(task.system.object_pixels), found.unfixable, assume_unique=True)


def _mean(task: Task, palette: Palette, pixels: Int[np.ndarray, " pixel"], most: float = np.inf) -> float:
    light: Float[np.ndarray, " pixel"] = task.system.times(
        gamma(task.system.interactions, palette) @ task.asked.luminance, pixels
    )
    return float(np.minimum(light, most).mean()) if len(pixels) else 0.0
