"""Raise or lower several scales at once until pixels stop them: the filling behind `fit`, step 5 of the paper.

All scales start at the low end of the range and rise together.  Where a pixel binds, those that brighten it in the
binding band stop there, and the rest rises on.  This is valid because every coefficient of G is ≥ 0, so that no scale
darkens anything; and the result does not depend on the order of the scales, because none has an order.  The *darkest*
image is found the same way downwards: the level sinks from the high end, each scale follows it from its lightest value,
and stops where a pixel would fall below the device's black.  No scale rises on the way, although that might let others
sink further.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Int

from symrt.feedback.along import Along, along_ends
from symrt.feedback.bounds import Bound
from symrt.feedback.caps import UNLIMITED, Cap, physical_cap
from symrt.feedback.intervals import inside_at, intervals
from symrt.feedback.joint.outermost import outermost
from symrt.feedback.limits import Limits
from symrt.feedback.parameters import with_spectra
from symrt.feedback.ranges import reason
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import End
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.products import gamma
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]
NEARLY = 1e-9
"""A bound that is met to this share binds, and leaves the scales that light it no room."""
ROUNDINGS_INWARD = 8
"""Times the rounding of a pixel that bounds are moved inwards, because every round computes the pixels anew."""


@dataclass(frozen=True, eq=False)
class Task:
    """A question to several scales: a system, the symbols of each, the bounds, and the pixels that need not be inside.

    `tick` is called once per level, programme or scale.
    """

    system: LinearSystem
    palette: Palette
    asked: Limits
    symbols: Mapping[str, frozenset[str]]
    within: tuple[float, float]
    cap: bool
    left_out: Pixels = field(default_factory=lambda: np.zeros(0, dtype=int))
    tick: Callable[[], object] = bool

    @cached_property
    def deciding(self) -> tuple[Pixels, Pixels]:
        """Pixels that decide for all that may bind, and those that no common scale brings inside."""
        return _first_limits(self, every=False)

    def painted(self, values: Mapping[str, float]) -> Palette:
        """The palette with some of the scales at their values, the others at 1."""
        owners = {symbol: name for name, symbols in self.symbols.items() for symbol in symbols}
        return with_spectra(
            self.palette, {s: values[owner] * self.palette[s] for s, owner in owners.items() if owner in values}
        )

    def line(self, values: Mapping[str, float], free: frozenset[str]) -> Along:
        """The image when the free scales share one value and the others have theirs."""
        moving = [s for name in sorted(free) for s in sorted(self.symbols[name])]
        ends = {s: (np.zeros_like(self.palette[s]), self.palette[s]) for s in moving}
        return along_ends(self.system, self.painted(values), ends)

    def capped(self, values: Mapping[str, float], free: frozenset[str]) -> Cap:
        """The largest value that the free scales may physically share."""
        return (
            physical_cap(self.painted(values), frozenset().union(*(self.symbols[n] for n in free)))
            if self.cap
            else UNLIMITED
        )


@dataclass(frozen=True, eq=False)
class Filled:
    """Values and reasons of the scales, pixels that are not kept inside, those above black, and the work done."""

    values: Mapping[str, float]
    reasons: Mapping[str, Reason]
    unfixable: Pixels
    lit: Pixels | None = None
    optimum: Literal["global", "local"] = "global"
    rounds: int = 0
    rows: int = 0
    left_out: Pixels = field(default_factory=lambda: np.zeros(0, dtype=int))
    cost: float = 0.0


def lightest(task: Task, budget: int = 0) -> Filled:
    """Raise all scales together; where a pixel binds, freeze those that brighten it, and go on with the rest.

    A budget of pixels may be left outside.  Nothing gets darker as scales rise, so that the pixels outside when all
    share a value are outside wherever none is below it: the level is that of the first pixel beyond the budget.
    """
    low, high = task.within
    values: dict[str, float] = {}
    reasons: dict[str, Reason] = {}
    rows, unfixable, level = first_limits(task, every=budget > 0)
    out = task.left_out
    optimum: Literal["global", "local"] = "global"
    while free := frozenset(task.symbols).difference(values):
        task.tick()

        # Each pixel limits the value that the free scales share, and so does the cap on materials.
        line = task.line(values, free)
        bound = task.asked.upper
        touched = rows[line.touched[rows]]
        found = intervals(line.seen(bound.matrix, touched), bound, (0.0, high), ROUNDINGS_INWARD)
        limit = np.full(len(touched), low)
        limit[found.pixel] = found.high
        capped = task.capped(values, free)

        # Rise to the first limit beyond the budget; the pixels that are passed on the way are left out.
        reached = min(float(np.sort(limit)[budget]) if budget < len(limit) else high, capped.value)
        spared = touched[limit < reached]
        out, rows, budget = np.append(out, spared), np.setdiff1d(rows, spared), budget - len(spared)
        if len(spared) and not budget:
            rows = outermost(task.system, rows)
        touched, limit, level = touched[limit >= reached], limit[limit >= reached], max(level, reached)

        # Freeze the scales that a pixel, the cap or the range stops there.
        stopped: Mapping[str, Reason] = {}
        if limit.min(initial=high) <= level < high:
            stopped = _stopped(task, values, free, line, End("upper", int(touched[limit.argmin()])), level)
            # Pixels that bind together leave a choice of whom to spare.
            optimum = "local" if budget else optimum
        elif capped.value <= level < high:
            why = Reason("cap", band=capped.band, symbol=capped.symbol)
            stopped = {n: why for n in sorted(free) if task.symbols[n] & capped.symbols}
        elif level >= high:
            stopped = dict.fromkeys(sorted(free), Reason("range"))
        values |= dict.fromkeys(stopped, level)
        reasons |= stopped
    return Filled(values, reasons, unfixable, optimum=optimum, left_out=np.sort(out))


def first_limits(task: Task, *, every: bool = False) -> tuple[Pixels, Pixels, float]:
    """Pixels that may bind, those that no common scale brings inside, and the level to start at.

    Of the pixels that may bind those that decide for the others, unless every one is asked for.
    """
    rows, unfixable = _first_limits(task, every=True) if every else task.deciding
    return rows, unfixable, task.within[0]


def _first_limits(task: Task, *, every: bool) -> tuple[Pixels, Pixels]:
    """As `first_limits`, without the level."""
    # Ask the pixels that the scales move at the low end.
    line, bound, (low, high) = task.line({}, frozenset(task.symbols)), task.asked.upper, task.within
    touched = np.setdiff1d(np.flatnonzero(line.touched), task.left_out, assume_unique=True)
    rows = touched if every else outermost(task.system, touched)
    inside = _inside(line, bound, rows, low)
    if not every and not inside.all():
        # What is outside hides what it decided for.
        inside = _inside(line, bound, touched, low)
        rows = np.union1d(outermost(task.system, touched[inside]), touched[~inside])
        inside = _inside(line, bound, rows, low)

    # Pixels that are inside at the high end, too, never bind.
    kept = rows[inside]
    return kept[~_inside(line, bound, kept, high)], rows[~inside]


def _inside(line: Along, bound: Bound, pixels: Pixels, value: float) -> Bool[np.ndarray, " pixel"]:
    """Whether each of the pixels is certainly inside when all scales share a value."""
    found = intervals(line.seen(bound.matrix, pixels), bound, (value, value), ROUNDINGS_INWARD)
    inside = np.zeros(len(pixels), dtype=bool)
    inside[found.pixel] = True
    return inside


def darkest(task: Task, first: Filled, allowed_dark: Number) -> Filled:
    """Lower the scales from their lightest values; freeze those that light a pixel which must not go dark."""
    low = task.within[0]
    if task.asked.dark is None:
        return replace(
            first,
            values=dict.fromkeys(task.symbols, low),
            reasons=dict.fromkeys(task.symbols, Reason("range")),
        )

    rows, budget = lit(task, task.asked.dark, first.values, allowed_dark)
    values, reasons, optimum = dict(first.values), dict[str, Reason](), first.optimum
    level = max(values.values())
    while free := frozenset(task.symbols).difference(reasons):
        task.tick()

        # The scales at the level sink, as far as the next one's value or the pixels that must stay above black.
        sinking = frozenset(n for n in free if values[n] >= level)
        below = max((values[n] for n in free - sinking), default=low)
        others = {n: v for n, v in values.items() if n not in sinking}
        line = task.line(others, sinking)
        bound = task.asked.dark
        touched = rows[line.touched[rows]]
        found = intervals(line.seen(bound.matrix, touched), bound, (below, level), ROUNDINGS_INWARD)
        limit = np.full(len(touched), level)
        limit[found.pixel] = found.low

        # Sink to the last limit within the budget; the pixels that are passed on the way go dark.
        falling = int(np.sum(limit > below))
        level = below if falling <= budget else float(np.sort(limit)[-1 - budget])
        values |= dict.fromkeys(sinking, level)
        rows = np.setdiff1d(rows, touched[limit > level])
        budget -= int(np.sum(limit > level))

        # Freeze the scales that light the pixel which stops them.
        if falling > budget and (limit == level).any() and level > below:
            pixel = int(touched[limit == level][0])
            reasons |= _stopped(task, others, sinking, line, End("dark", pixel), level)
            # As above: of pixels that bind together some might fall.
            optimum = "local" if budget else optimum
        elif level <= low:
            reasons |= dict.fromkeys(sorted(free), Reason("range"))
    return replace(first, values=values, reasons=reasons, lit=rows, optimum=optimum)


def lit(task: Task, bound: Bound, start: Mapping[str, float], allowed: Number) -> tuple[Pixels, int]:
    """Pixels above black both with the palette given and at the start, and how many of them may go dark."""
    given, first = task.line({}, frozenset()), task.line(start, frozenset())
    objects = np.flatnonzero(task.system.object_pixels)
    counted = objects[inside_at(given.seen(bound.matrix, objects), bound, 1.0)]
    rows = counted[inside_at(first.seen(bound.matrix, counted), bound, 1.0)]
    return rows, max(0, int(allowed * len(counted) + 1e-9) - (len(counted) - len(rows)))


def _stopped(
    task: Task, values: Mapping[str, float], free: frozenset[str], line: Along, end: End, level: float
) -> dict[str, Reason]:
    """The free scales that light the pixel in a slab whose bound it meets, each with that as its reason."""
    # Find the slabs whose bounds the pixel meets.
    bound = task.asked.upper if end.kind == "upper" or task.asked.dark is None else task.asked.dark
    row = np.array([end.pixel])
    value = line.seen(bound.matrix, row).at(level)[0]
    meets = value >= bound.upper * (1 - NEARLY) if end.kind == "upper" else value <= bound.lower * (1 + NEARLY)

    # Find the symbols that light it there.
    columns = [interaction for interaction, _ in task.system.terms(end.pixel)]
    lights = (gamma(columns, task.painted(values)) @ bound.matrix[:, meets] > 0).any(axis=1)
    symbols = {name for i, lit in zip(columns, lights, strict=True) if lit for name in i.symbols}

    why = reason(line, task.asked, end, level, task.system.width)
    stopped = {name: why for name in sorted(free) if symbols & task.symbols[name]}
    if not stopped:
        raise ArithmeticError(f"pixel {end.pixel} binds at {level}, but no free scale lights it there")
    return stopped
