"""Bring scales that were computed to rounding to where a pixel certainly stops them: step 5 of the paper.

One scale after another goes as far as its pixels allow with all others as they are, in the arithmetic of `feasible`;
what moves is only the last digits, and the answer names the pixel. A pixel that another scale has brought to its bound
leaves one that hardly lights it no room that could be told from rounding: it is inside already, and asks for nothing.
"""

from collections.abc import Mapping

import numpy as np
from jaxtyping import Bool, Int

from symrt.arrays import PerPixel
from symrt.feedback.along import Along
from symrt.feedback.bounds import Bound
from symrt.feedback.caps import above_one
from symrt.feedback.intervals import intervals
from symrt.feedback.joint.filling import ROUNDINGS_INWARD, Task
from symrt.feedback.joint.posynomials import Sliders
from symrt.feedback.ranges import reason
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import End

NEAR = 1e-6
"""Pixels whose share of a bound is so near to 1 may be what stops a scale."""
GROWTH = 1e-9
"""By how much a scale may still move."""

Pixels = Int[np.ndarray, " _"]
Values = Mapping[str, float]


def near(image: Sliders, values: Values, names: tuple[str, ...]) -> Pixels:
    """The pixels that may stop a scale."""
    share, _ = image.brightest(np.log([values[name] for name in names]))
    return image.pixels[share >= 1 - NEAR]


def raised(task: Task, close: Pixels, values: Values, name: str, most: float | None = None) -> tuple[float, Reason]:
    """The value of one scale, raised to where something stops it, at most to `most`, and the reason that stops it."""
    # Ask the pixels that may bind, all other scales as they are.
    others = {n: v for n, v in values.items() if n != name}
    line, bound = task.line(others, frozenset({name})), task.asked.upper
    pixels = close[line.touched[close]]
    found = intervals(line.seen(bound.matrix, pixels), bound, (0.0, task.within[1]), ROUNDINGS_INWARD)
    limit = np.zeros(len(pixels))
    limit[found.pixel] = found.high

    # Its own value stands where a pixel or the cap is passed by rounding alone.
    value, capped = values[name], task.capped(others, frozenset({name}))
    limit = _kept(limit, value, limit < value, line, bound, pixels)
    physical = capped.value < value and not above_one(task.painted(values), task.symbols[name])
    highest = value if physical else capped.value

    # The first of the ends stops it: range, cap, objective, or a pixel.
    ends = [(task.within[1], Reason("range")), (highest, Reason("cap", band=capped.band, symbol=capped.symbol))]
    if most is not None:
        ends.append((most, Reason("objective")))
    if len(pixels):
        high, pixel = float(limit.min()), int(pixels[limit.argmin()])
        ends.append((high, reason(line, task.asked, End("upper", pixel), high, task.system.width)))
    end, why = min(ends, key=lambda pair: pair[0])
    return (end, why) if end <= value * (1 + GROWTH) else (value, Reason("objective"))


def lowered(task: Task, counted: Pixels, values: Values, name: str) -> tuple[float, Reason]:
    """The value of one scale, lowered to where a pixel counted would fall below black, and the reason that stops it."""
    low, value, bound = task.within[0], values[name], task.asked.dark
    if bound is None:
        return low, Reason("range")

    # Ask the pixels counted, all other scales as they are.
    line = task.line({n: v for n, v in values.items() if n != name}, frozenset({name}))
    pixels = counted[line.touched[counted]]
    found = intervals(line.seen(bound.matrix, pixels), bound, (low, task.within[1]), ROUNDINGS_INWARD)
    limit = np.full(len(pixels), np.inf)
    limit[found.pixel] = found.low
    limit = _kept(limit, value, limit > value, line, bound, pixels)

    # The highest of the limits stops it, or the end of the range.
    least = float(limit.max(initial=low))
    if least < value * (1 - GROWTH):
        return value, Reason("objective")
    if least <= low:
        return low, Reason("range")
    return least, reason(line, task.asked, End("dark", int(pixels[limit.argmax()])), least, task.system.width)


def _kept(
    limit: PerPixel, value: float, passed: Bool[np.ndarray, " pixel"], line: Along, bound: Bound, pixels: Pixels
) -> PerPixel:
    """The limits, with the value itself where it has passed the limit of a pixel that is certainly inside there."""
    asking = np.flatnonzero(passed)
    inside = intervals(line.seen(bound.matrix, pixels[asking]), bound, (value, value), 1).pixel
    kept = np.zeros(len(limit), dtype=bool)
    kept[asking[inside]] = True
    return np.where(kept, value, limit)
