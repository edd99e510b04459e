"""All constraints on several scales at once, a few of them at a time: step 5 of the paper.

An image has a row for each pixel and band, of which a handful bind.  The programme starts with the row in which each
monomial is largest; what its solution violates most is added, and it is solved again, until nothing is violated [1]_.
Lower bounds are not convex: each is replaced by its tangent, the monomial that meets the posynomial at the point
reached and lies below it everywhere else, and the programme is solved again from there [2]_.

References
----------
.. [1] J. E. Kelley, "The cutting-plane method for solving convex programs", J. SIAM 8(4), 1960, pp. 703-712.
.. [2] M. Avriel and A. C. Williams, "Complementary geometric programming", SIAM J. Appl. Math. 19(1), 1970.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.along import along_ends
from symrt.feedback.caps import INWARD, grouped
from symrt.feedback.convex import Constraints, Objective, Planes, minimise
from symrt.feedback.filling import Task, first_limits
from symrt.feedback.posynomials import Posynomials, Sliders, sliders, stacked
from symrt.feedback.ranges import reason
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import End

__all__ = ["Joint", "Programme", "Solved", "joint", "solved"]

MARGIN = 1e-12
"""By how much bounds are moved inwards, so that a solution to rounding is inside."""
NEARLY = 1e-9
"""A row that is so near to its bound at the low end leaves its scales no room."""
ADDED = 64
"""Rows added at a time."""
MOST_ROUNDS = 100

Point = Float[np.ndarray, " scale"]
Pixels = Int[np.ndarray, " _"]
Optimum = Literal["global", "local"]


@dataclass(frozen=True, eq=False)
class Joint:
    """What several scales may do together.

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


def _with_pinned(task: Task, values: Mapping[str, float], pixels: Pixels) -> Joint:
    free = {name: symbols for name, symbols in task.symbols.items() if name not in values}
    painted = task.painted(values)
    floor = max(task.within[0], 1e-9 * task.within[1])
    return Joint(
        task=task,
        names=tuple(free),
        image=sliders(task.system, painted, free, task.asked.upper, pixels),
        caps=_cap_rows(task, values, free) if task.cap else _no_rows(len(free)),
        low=np.full(len(free), np.log(floor)),
        high=np.full(len(free), np.log(task.within[1])),
        pinned={},
        reasons={},
        unfixable=pixels[:0],
    )


def _stuck(found: Joint) -> dict[str, Reason]:
    """The scales that a row, as good as met at the low end, forbids to rise."""
    task, stuck = found.task, dict[str, Reason]()
    share, slab = found.image.brightest(found.low)
    met = np.flatnonzero(share >= 1 - NEARLY)
    rows = found.image.rows(met, slab[met])
    values = {**dict.fromkeys(task.symbols, task.within[0]), **found.pinned}
    line = along_ends(task.system, task.painted(values), {})
    for row, pixel in enumerate(found.image.pixels[met]):
        why = reason(line, task.asked, End("upper", int(pixel)), 1.0, task.system.width)
        stuck = {**{found.names[k]: why for k in rows.scales(row)}, **stuck}
    for cap in np.flatnonzero(found.caps.at(found.low)[0] >= -NEARLY):
        stuck = {**{found.names[k]: Reason("cap") for k in found.caps.scales(int(cap))}, **stuck}
    return stuck


def _cap_rows(task: Task, values: Mapping[str, float], free: Mapping[str, frozenset[str]]) -> Posynomials:
    """For each material and band the sum of its reflectances."""
    palette, names = task.painted(values), list(free)
    owner = {symbol: 1 + names.index(name) for name in names for symbol in free[name]}
    rows = []
    for symbols in grouped(palette).values():
        sums = np.zeros((len(palette.bands), 1 + len(names)))
        for symbol in symbols:
            sums[:, owner.get(symbol, 0)] += palette[symbol] / INWARD
        rows.append(sums[sums[:, 1:].any(axis=1)])
    with np.errstate(divide="ignore"):
        logs = np.log(np.vstack([np.zeros((0, 1 + len(names))), *rows]))
    return Posynomials(logs, np.vstack([np.zeros(len(names)), np.eye(len(names))]))


def _no_rows(scales: int) -> Posynomials:
    return Posynomials(np.zeros((0, 1)), np.zeros((1, scales)))


@dataclass(frozen=True, eq=False)
class Programme:
    """What is minimised, and under which constraints.

    The variables are the logarithms of the scales, or of the scales at the top of a box and then at its bottom.

    Parameters
    ----------
    upper
        The image that must be inside, and other posynomials that must be at most 1.
    dark
        Pixels that must be above a bound, in shares of it; they see the last of the variables.
    floors
        Other posynomials that must be at least 1.
    """

    objective: Objective
    upper: Sliders
    rows: Posynomials
    planes: Planes
    dark: Sliders | None = None
    floors: Posynomials | None = None

    @property
    def size(self) -> int:
        """How many variables there are."""
        return self.planes.normals.shape[1]


class Solved(NamedTuple):
    """The point found, whether a better one may exist, and what it cost."""

    y: Point
    optimum: Optimum
    rounds: int
    rows: int


def solved(programme: Programme, start: Point) -> Solved | None:
    """The best point; None if there is none, or none for sure.

    Lower bounds, if there are any, must hold at the start; the point found is then the best nearby.
    """
    chosen = programme.upper.first()
    if programme.dark is None and programme.floors is None:
        return _convex(programme, chosen, start)[0]
    return _condensed(programme, chosen, start)


Chosen = tuple[Pixels, Pixels]
"""Pixels, counted in an image, and the band of each."""


def _convex(programme: Programme, chosen: Chosen, start: Point) -> tuple[Solved | None, Chosen]:
    """Solve, add what is violated most, solve again."""
    for rounds in range(1, MOST_ROUNDS):
        image = programme.upper.rows(*chosen)
        rows = _wide(stacked([image, programme.rows]), programme.size)
        rows = replace(rows, logs=rows.logs + MARGIN)
        found = minimise(programme.objective, Constraints(rows, programme.planes), start)
        if found is None:
            return None, chosen
        share, slab = programme.upper.brightest(found.y[: image.exponents.shape[1]])
        over = _most(share - 1, -MARGIN / 2)
        if not len(over):
            return Solved(found.y, "global", rounds, len(rows.logs)), chosen
        chosen = np.append(chosen[0], over), np.append(chosen[1], slab[over])
    raise ArithmeticError(f"rows are still violated after {MOST_ROUNDS} rounds")


def _condensed(programme: Programme, chosen: Chosen, start: Point) -> Solved | None:
    """Replace lower bounds by their tangents at the best point so far."""
    best, value, rounds, rows = start, np.inf, 0, 0
    dark: Chosen = (np.zeros(0, dtype=int), np.zeros(0, dtype=int))
    if programme.dark is not None:
        share, slab = programme.dark.darkest(_last(programme.dark, start))
        near = np.argsort(share, kind="stable")[:ADDED]
        dark = near, slab[near]
    for _ in range(MOST_ROUNDS):
        planes = _tangents(programme, dark, best)
        found, chosen = _convex(replace(programme, planes=planes), chosen, best)
        if found is None:
            break
        rounds, rows = rounds + found.rounds, found.rows + len(planes.offsets)
        if programme.dark is not None:
            share, slab = programme.dark.darkest(_last(programme.dark, found.y))
            under = _most(1 - share, -MARGIN / 2)
            if len(under):
                dark = np.append(dark[0], under), np.append(dark[1], slab[under])
                continue
        reached = programme.objective(found.y)[0]
        progress = value - reached
        best, value = found.y, reached
        if progress <= NEARLY * max(1.0, abs(value)):
            break
    return Solved(best, "local", rounds, rows) if np.isfinite(value) else None


def _tangents(programme: Programme, dark: Chosen, y: Point) -> Planes:
    """Half-spaces in which the tangents of the lower bounds are at least 1."""
    parts = [] if programme.floors is None else [_wide(programme.floors, programme.size)]
    if programme.dark is not None:
        rows = programme.dark.rows(*dark)
        parts.append(_wide(rows, programme.size, last=True))
    rows = stacked(parts)
    logs, shares = rows.at(y)
    slopes = shares @ rows.exponents
    planes = programme.planes
    return Planes(
        np.vstack([planes.normals, -slopes]),
        np.concatenate([planes.offsets, logs - slopes @ y - MARGIN]),
    )


def _wide(rows: Posynomials, size: int, *, last: bool = False) -> Posynomials:
    """The same rows among more variables, as the first or the last of them."""
    more = np.zeros((len(rows.exponents), size - rows.exponents.shape[1]))
    return replace(rows, exponents=np.hstack([more, rows.exponents] if last else [rows.exponents, more]))


def _last(dark: Sliders, y: Point) -> Float[np.ndarray, " seen"]:
    return y[len(y) - dark.exponents.shape[1] :]


def _most(excess: Float[np.ndarray, " pixel"], limit: float) -> Pixels:
    """The pixels that exceed a limit by most, worst first."""
    over = np.flatnonzero(excess > limit)
    return over[np.argsort(-excess[over], kind="stable")[:ADDED]]
