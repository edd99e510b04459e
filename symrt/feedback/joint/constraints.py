"""The constraints on several scales at once: step 5 of the paper."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.along import along_ends
from symrt.feedback.bounds import Bound
from symrt.feedback.caps import BELOW_ONE, grouped
from symrt.feedback.joint.convex import Planes
from symrt.feedback.joint.filling import NEARLY, Task, first_limits, lit
from symrt.feedback.joint.posynomials import Posynomials, Sliders, sliders
from symrt.feedback.ranges import reason
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import End
from symrt.spectra.bands import Number
from symrt.spectra.fluorescence import sent_on

LEAST = 1e-300
"""Of the high end of the range, where logarithms begin if the low end is 0."""

Point = Float[np.ndarray, " scale"]
Pixels = Int[np.ndarray, " _"]


@dataclass(frozen=True, eq=False)
class Joint:
    """The constraints on several scales that move together.

    Parameters
    ----------
    names
        The scales that have room, sorted.
    image
        The pixels that may meet an upper bound, in shares of it.
    caps
        Rows that keep materials physical.
    low, high
        Logarithms of the ends of the range of each scale.
    pinned, reasons
        Scales that have no room above the low end, their values, and why.
    unfixable
        Pixels that are outside even at the low end.
    """

    task: Task
    names: tuple[str, ...]
    image: Sliders
    caps: Posynomials
    low: Point
    high: Point
    pinned: Mapping[str, float]
    reasons: Mapping[str, Reason]
    unfixable: Pixels

    @property
    def box(self) -> Planes:
        """The range of every scale."""
        eye = np.eye(len(self.names))
        return Planes(np.vstack([eye, -eye]), np.concatenate([self.high, -self.low]))


def joint(task: Task, values: Mapping[str, float] | None = None) -> Joint:
    """The constraints on a task's scales, of which some may already have values."""
    may_bind, unfixable, _ = first_limits(task)
    pinned, reasons = dict(values or {}), dict[str, Reason]()
    while True:
        found = _with_pinned(task, pinned, may_bind)
        stuck = _stuck(found)
        pinned |= dict.fromkeys(stuck, task.within[0])
        reasons |= stuck
        if not stuck:
            return replace(found, pinned=pinned, reasons=reasons, unfixable=unfixable)


def counted_pixels(task: Task, bound: Bound, filled: Mapping[str, float], allowed: Number) -> Pixels:
    """The pixels that must stay above black: those that may fall are the darkest of the filled image."""
    counted, budget = lit(task, bound, filled, allowed)
    image = sliders(task.system, task.painted(filled), task.symbols, bound, counted, upper=False)
    share, _ = image.darkest(np.zeros(len(filled)))
    return np.sort(counted[np.argsort(share, kind="stable")[budget:]])


def _with_pinned(task: Task, values: Mapping[str, float], pixels: Pixels) -> Joint:
    """The constraints on the scales that have no value yet."""
    free = {name: symbols for name, symbols in task.symbols.items() if name not in values}
    painted = task.painted(values)
    # Logarithms need a low end above 0.
    floor = max(task.within[0], LEAST * task.within[1])
    nothing = Posynomials(np.zeros((0, 1)), np.zeros((1, len(free))))
    return Joint(
        task=task,
        names=tuple(free),
        image=sliders(task.system, painted, free, task.asked.upper, pixels),
        caps=_cap_rows(task, values, free) if task.cap else nothing,
        low=np.full(len(free), np.log(floor)),
        high=np.full(len(free), np.log(task.within[1])),
        pinned={},
        reasons={},
        unfixable=pixels[:0],
    )


def _stuck(found: Joint) -> dict[str, Reason]:
    """The scales that a row, as good as met at the low end, forbids to rise."""
    # Find the pixels that are as good as at their bound, and the band of each.
    task, stuck = found.task, dict[str, Reason]()
    share, slab = found.image.brightest(found.low)
    met = np.flatnonzero(share >= 1 - NEARLY)
    rows = found.image.rows(met, slab[met])

    # They stop every scale of that row; earlier pixels give the reason.
    values = {**dict.fromkeys(task.symbols, task.within[0]), **found.pinned}
    line = along_ends(task.system, task.painted(values), {})
    for row, pixel in enumerate(found.image.pixels[met]):
        why = reason(line, task.asked, End("upper", int(pixel)), 1.0, task.system.width)
        stuck = {**{found.names[k]: why for k in rows.scales(row)}, **stuck}

    # So do the caps of materials.
    for cap in np.flatnonzero(found.caps.at(found.low)[0] >= -NEARLY):
        names = [found.names[k] for k in found.caps.scales(int(cap))]
        capped = task.capped({n: v for n, v in values.items() if n not in names}, frozenset(names))
        stuck = {**dict.fromkeys(names, Reason("cap", band=capped.band, symbol=capped.symbol)), **stuck}
    return stuck


def _cap_rows(task: Task, values: Mapping[str, float], free: Mapping[str, frozenset[str]]) -> Posynomials:
    """For each material and band the sum of its reflectances."""
    palette, names = task.painted(values), list(free)
    owner = {symbol: 1 + names.index(name) for name in names for symbol in free[name]}
    rows = []
    for symbols in grouped(palette).values():
        sums = np.zeros((len(palette.bands), 1 + len(names)))
        for symbol in symbols:
            sums[:, owner.get(symbol, 0)] += sent_on(palette[symbol], palette.bands) / BELOW_ONE
        rows.append(sums[sums[:, 1:].any(axis=1)])
    with np.errstate(divide="ignore"):
        logs = np.log(np.vstack([np.zeros((0, 1 + len(names))), *rows]))
    return Posynomials(logs, np.vstack([np.zeros(len(names)), np.eye(len(names))]))
