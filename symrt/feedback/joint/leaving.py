"""Leave a share of the pixels outside: step 5 of the paper, "some percentage of out-of-gamut pixels may be allowed".

Which pixels to leave out is a combinatorial question as soon as there are several scales.  What is done here is a
descent: from an answer the scales go straight towards what the objective would ask for if there were no pixels, as far
as the pixels that come out on the way are few enough; those are left out, the best scales for the rest are found, and
so on until nothing improves.  Pixels come out one by one on a straight line, because in logarithms of the scales each
allows a convex set.  It starts from the best few of these, so that it is never worse than with no pixel left out: none;
those that all scales would leave out together; those that are farthest outside where the objective pulls; and for each
scale those that come out if it goes alone, the others least.  Where the best scales are quickly found it also goes in
several steps, and exchanges pixels that bind for others as long as it pays.  With a single scale all pixels come out in
the order of their limits, and the answer is exact.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.joint.constraints import LEAST
from symrt.feedback.joint.filling import Filled, Task, first_limits, lightest
from symrt.feedback.joint.posynomials import Sliders, sliders
from symrt.feedback.joint.settling import NEAR

DESCENT_ROUNDS = 10
DESCENTS = 4
"""Of the starts, from the best of which there is a descent."""
EXCHANGES = 12
"""At most this many exchanges of pixels, of two questions each."""
LINE_HALVINGS = 52
"""Of a line, after which its points are the same to rounding."""
PARTS = 8
"""Parts in which the budget is spent in one of the attempts."""
COST_PROGRESS = 1e-9
"""Of the cost, below which a round is the last."""

Ask = Callable[[Task], Filled | None]
Pixels = Int[np.ndarray, " _"]
Point = Float[np.ndarray, " scale"]


@dataclass(frozen=True, eq=False)
class _Search:
    """A question, the pixels that it may leave out, how many, and the answers so far: many ways lead to one choice."""

    task: Task
    ask: Ask
    image: Sliders
    budget: int
    answers: dict[bytes, Filled | None] = field(default_factory=dict)

    def asked(self, out: Pixels) -> Filled | None:
        """The answer without some of the pixels."""
        left_out = np.union1d(self.task.left_out, out)
        if (choice := left_out.tobytes()) not in self.answers:
            self.answers[choice] = self.ask(replace(self.task, left_out=left_out))
        return self.answers[choice]

    def outside(self, y: Point, of: Sliders | None = None) -> Pixels:
        """The pixels that are outside at a point."""
        image = of or self.image
        return image.pixels[image.brightest(y)[0] > 1]

    def point(self, found: Filled) -> Point:
        """The logarithms of an answer's scales."""
        values = np.array([found.values[name] for name in self.task.symbols])
        return np.log(np.maximum(values, LEAST * self.task.within[1]))


def leave_out(task: Task, ask: Ask, budget: int) -> Filled | None:
    """The best answer found that leaves no more than a budget of pixels outside, besides those already left out.

    Parameters
    ----------
    ask
        The answer to a task, with the cost that is to be small.

    Examples
    --------
    See `symrt.feedback.fit` with ``allowed_out``.
    """
    # Ask with no pixel left out; that is the answer where nothing may be, or no pixel binds.
    first = ask(task)
    if first is None or budget <= 0:
        return first
    rows, _, _ = first_limits(task, every=True)
    if not len(rows):
        return first

    # Ask without any pixel: that is where the objective pulls, and all if few enough are outside there.
    search = _Search(task, ask, sliders(task.system, task.palette, task.symbols, task.asked.upper, rows), budget)
    free = search.asked(rows)
    if free is None:
        return first
    share, _ = search.image.brightest(search.point(free))
    farthest = search.image.pixels[np.argsort(-share, kind="stable")[:budget]]
    if (share > 1).sum() <= budget:
        return search.asked(search.image.pixels[share > 1])

    # A single scale takes pixels out in their order.
    aim = search.point(free)
    if len(task.symbols) == 1:
        return _descended(search, first, aim)

    # Choose the starts.
    ways = [_on_the_way(search, *line) for line in _alone(search, aim)]
    chosen = [lightest(task, budget).left_out, farthest, *ways]
    starts = [first, *(search.asked(out) for out in chosen)]
    if first.optimum == "global":
        starts.append(_stepped(search, first, aim))

    # Descend from the best of them, and exchange pixels as long as it pays.
    likely = sorted((start for start in starts if start is not None), key=lambda answer: answer.cost)[:DESCENTS]
    best = min((_descended(search, start, aim) for start in likely), key=lambda answer: answer.cost)
    return replace(_exchanged(search, best) if best.optimum == "global" else best, optimum="local")


def _alone(search: _Search, aim: Point) -> list[tuple[Point, Point]]:
    """For each scale the line to its aim from where all are least, the others staying there."""
    least = np.full(len(aim), np.log(max(search.task.within[0], LEAST * search.task.within[1])))
    return [(least, np.where(np.arange(len(aim)) == k, aim, least)) for k in range(len(aim))]


def _descended(search: _Search, found: Filled, aim: Point) -> Filled:
    """Go towards the aim, leave out what comes out on the way, ask again."""
    for _ in range(DESCENT_ROUNDS):
        better = search.asked(_on_the_way(search, search.point(found), aim))
        if better is None or better.cost >= found.cost - COST_PROGRESS * abs(found.cost):
            break
        found = better
    return found


def _stepped(search: _Search, found: Filled, aim: Point) -> Filled:
    """Spend the budget in parts, with the best scales after each."""
    for part in np.unique(np.linspace(0, search.budget, PARTS + 1).astype(int))[1:]:
        found = search.asked(_on_the_way(replace(search, budget=int(part)), search.point(found), aim)) or found
    return found


def _exchanged(search: _Search, found: Filled) -> Filled:
    """Leave out a pixel that binds, and keep the one that is then least outside, for as long as it pays."""
    image, tried = search.image, np.zeros(0, dtype=int)
    for _ in range(EXCHANGES):
        # Leave out one more pixel, that binds.
        share, _ = image.brightest(search.point(found))
        binding = np.setdiff1d(image.pixels[(share <= 1) & (share > 1 - NEAR)], tried)
        freed = search.asked(np.append(image.pixels[share > 1], binding[0])) if len(binding) else None
        if freed is None:
            break
        tried = np.append(tried, binding[0])

        # Of the pixels outside then, keep the one that is least so.
        share, _ = image.brightest(search.point(freed))
        farthest = np.argsort(-share, kind="stable")[: min(search.budget, int((share > 1).sum()))]
        other = search.asked(image.pixels[farthest])
        if other is not None and other.cost < found.cost - COST_PROGRESS * abs(found.cost):
            found = other
    return found


def _on_the_way(search: _Search, y: Point, aim: Point) -> Pixels:
    """The pixels outside at the farthest point towards the aim where they are no more than the budget."""
    # Only what is inside here and outside there comes out: a pixel allows a part of the line without gaps.
    image = search.image
    there = np.flatnonzero((image.brightest(aim)[0] > 1) | (image.brightest(y)[0] > 1))
    close = replace(image, part=image.part.rows(there), pixels=image.pixels[there])

    near, far = 0.0, 1.0
    for _ in range(LINE_HALVINGS):
        middle = (near + far) / 2
        if len(search.outside(y + middle * (aim - y), close)) <= search.budget:
            near = middle
        else:
            far = middle
    return search.outside(y + near * (aim - y), close)
