"""A fit's answer must still be a picture: step 5 of the paper, and its guard against the trivial solution.

Black is in every gamut.  An answer is acceptable only if its mean luminance is at least a share, half unless told
otherwise, of the mean of min(Y, 1) over the image given.  An objective whose best falls short is asked again with that
as a lower bound, from the brightest image inside; if even that one is too dark, there is no acceptable solution.
"""

from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.filling import Filled, Task, darkest, lightest
from symrt.feedback.objectives import Regions, brightest, closest, contrast, lexicographic
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.shading import gamma

__all__ = ["OBJECTIVES", "Answer", "Goal", "answered"]

Goal = Literal["lightest", "darkest", "closest", "lexicographic", "brightest", "contrast"]
OBJECTIVES: tuple[Goal, ...] = ("lightest", "darkest", "closest", "lexicographic", "brightest", "contrast")
ROUNDING = 1e-9
"""Of luminance, that does not make an answer unacceptable."""


class Answer(NamedTuple):
    """What was found, its mean luminance as a share of that of the image given, and whether that is enough."""

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
) -> Answer:
    """The scales that an objective asks for, and whether they leave enough of the picture."""
    if goal in ("lightest", "darkest"):
        found = lightest(task)
        if goal == "darkest":
            found = darkest(task, found, allowed_dark)
        kept = _kept(task, found)
        return Answer(found, kept, goal == "darkest" or kept >= least_luminance * (1 - ROUNDING))
    best = _found(_ask(task, goal, allowed_dark, regions)(0.0, None), goal)
    kept = _kept(task, best)
    if kept >= least_luminance * (1 - ROUNDING) or goal == "brightest":
        return Answer(best, kept, kept >= least_luminance * (1 - ROUNDING))
    light = _found(brightest(task, allowed_dark), "brightest")
    if _kept(task, light) < least_luminance:
        return Answer(best, kept, acceptable=False)
    floor = float(least_luminance) * _mean(task, task.palette, _seen(task, light), 1.0)
    again = _ask(task, goal, allowed_dark, regions)(floor, light)
    if again is None or _kept(task, again) < least_luminance * (1 - ROUNDING):
        return Answer(best, kept, acceptable=False)
    return Answer(again, _kept(task, again), acceptable=True)


def _ask(
    task: Task, goal: Goal, allowed_dark: Number, regions: Regions | None
) -> Callable[[float, Filled | None], Filled | None]:
    def ask(floor: float, start: Filled | None) -> Filled | None:
        values = None if start is None else start.values
        if goal == "closest":
            return closest(task, allowed_dark, floor, values)
        if goal == "lexicographic":
            return lexicographic(task, allowed_dark, floor, values)
        if goal == "contrast":
            return contrast(task, regions, allowed_dark, floor, values)
        return brightest(task, allowed_dark)

    return ask


def _found(found: Filled | None, goal: Goal) -> Filled:
    if found is None:
        raise ArithmeticError(f"the search for the {goal} image did not settle, although some image is inside")
    return found


def _kept(task: Task, found: Filled) -> float:
    """Mean luminance as a share of the mean of min(Y, 1) of the image given, without the pixels left out."""
    seen = _seen(task, found)
    given = _mean(task, task.palette, seen, 1.0)
    return _mean(task, task.painted(found.values), seen) / given if given else 1.0


def _seen(task: Task, found: Filled) -> Int[np.ndarray, " pixel"]:
    return np.setdiff1d(np.flatnonzero(task.system.object_pixels), found.unfixable)


def _mean(task: Task, palette: Palette, pixels: Int[np.ndarray, " pixel"], most: float = np.inf) -> float:
    light: Float[np.ndarray, " pixel"] = task.system.G[pixels] @ (
        gamma(task.system.interactions, palette) @ task.asked.luminance
    )
    return float(np.minimum(light, most).mean()) if len(pixels) else 0.0
