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

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.joint.convex import Constraints, Objective, Planes, minimise
from symrt.feedback.joint.posynomials import Posynomials, Sliders, stacked_rows

MARGIN = 1e-12
"""By how much bounds are moved inwards, so that a solution to rounding is inside."""
PROGRESS = 1e-7
"""Of the objective, below which a point counts as the best nearby."""
PROXIMITY = 1e-3
"""Weight of a squared change of the other variables against the ratio: a step along a tangent goes not too far."""
PATIENCE = 3
"""Steps that pay before tangents touch ahead of them."""
ADDED = 64
"""Rows added at a time."""
MOST_ROUNDS = 100

Point = Float[np.ndarray, " scale"]
Pixels = Int[np.ndarray, " _"]
Matrix = Float[np.ndarray, "scale scale"]
Optimum = Literal["global", "local"]


@dataclass(frozen=True, eq=False)
class Programme:
    """An objective to be minimised, and its constraints.

    The variables are the logarithms of the scales, or of the scales at the top of a box and then at its bottom.

    Parameters
    ----------
    upper
        The image that must be inside, and other posynomials that must be at most 1.
    dark
        Pixels that must be above a bound, in shares of it.
    bottom
        The first of the variables that they see.
    floors
        Other posynomials that must be at least 1.
    ratios
        Pairs of posynomials, whose least ratio's logarithm is at least the last of the variables.
    """

    objective: Objective
    upper: Sliders
    rows: Posynomials
    planes: Planes
    dark: Sliders | None = None
    bottom: int = 0
    floors: Posynomials | None = None
    ratios: tuple[Posynomials, Posynomials] | None = None

    @property
    def convex(self) -> bool:
        """Whether there are upper bounds only."""
        return self.dark is None and self.floors is None and self.ratios is None

    @property
    def size(self) -> int:
        """Number of variables."""
        return self.planes.normals.shape[1]


class Solved(NamedTuple):
    """The point found, whether a better one may exist, and the programmes and rows that it took."""

    y: Point
    optimum: Optimum
    rounds: int
    rows: int


def solved(programme: Programme, start: Point, tick: Callable[[], object] = bool) -> Solved | None:
    """The best point; None if there is none, or none for sure.

    Lower bounds, if there are any, must hold at the start; the point found is then the best nearby.  Each programme
    solved is ticked.
    """
    chosen = programme.upper.first()
    if programme.convex:
        return _convex(programme, chosen, start, tick)[0]
    return _condensed(programme, chosen, start, tick)


Chosen = tuple[Pixels, Pixels]
"""Pixels, counted in an image, and the band of each."""


def _convex(
    programme: Programme, chosen: Chosen, start: Point, tick: Callable[[], object]
) -> tuple[Solved | None, Chosen]:
    """Solve, add what is violated most, solve again."""
    for rounds in range(1, MOST_ROUNDS):
        # Solve with the rows chosen so far.
        tick()
        image = programme.upper.rows(*chosen)
        rows = stacked_rows([_wide(image, programme.size), _wide(programme.rows, programme.size)])
        rows = replace(rows, logs=rows.logs + MARGIN)
        found = minimise(programme.objective, Constraints(rows, programme.planes), start)
        if found is None:
            return None, chosen

        # Add the pixels that are farthest outside at the solution.
        share, slab = programme.upper.brightest(found.y[: image.exponents.shape[1]])
        over = most(share - 1, -MARGIN / 2)
        if not len(over):
            return Solved(found.y, "global", rounds, len(rows.logs)), chosen
        chosen = np.append(chosen[0], over), np.append(chosen[1], slab[over])
    raise ArithmeticError(f"rows are still violated after {MOST_ROUNDS} rounds")


def _condensed(programme: Programme, chosen: Chosen, start: Point, tick: Callable[[], object]) -> Solved | None:
    """Replace what must be large by its tangent at the best point so far.

    Steps may be short for long: once several have paid, tangents touch ahead, ever farther; they are valid anywhere.
    """
    # Begin with the lower bounds that are nearest at the start.
    best, value, rounds, rows = start, np.inf, 0, 0
    touching, paid = start, 0
    dark: Chosen = (np.zeros(0, dtype=int), np.zeros(0, dtype=int))
    if programme.dark is not None:
        share, slab = programme.dark.darkest(_seen(programme, start))
        near = np.argsort(share, kind="stable")[:ADDED]
        dark = near, slab[near]

    for _ in range(MOST_ROUNDS):
        # Solve the convex programme of the tangents.
        nearby = _linearised(programme, dark, touching)
        found, chosen = _convex(nearby, chosen, best, tick)
        if found is not None:
            rounds, rows = rounds + found.rounds, found.rows + len(nearby.planes.offsets)

            # Add lower bounds that the solution violates, and solve again from the same tangents.
            if programme.dark is not None:
                share, slab = programme.dark.darkest(_seen(programme, found.y))
                under = most(1 - share, -MARGIN / 2)
                if len(under):
                    dark = np.append(dark[0], under), np.append(dark[1], slab[under])
                    continue

            # Keep the point if it is better; go on from it, or ahead of it, if it pays.
            reached = programme.objective(found.y)[0]
            progress, step = value - reached, found.y - best
            if progress > 0:
                best, value = found.y, reached
            if progress > PROGRESS * max(1.0, abs(value)):
                paid = 0 if programme.ratios is None else paid + 1
                touching = best + (2.0 ** (paid - PATIENCE) if paid > PATIENCE else 0.0) * step
                continue

        # No progress: this is the best nearby, unless the tangents touched ahead; then they touch the best point again.
        if paid <= PATIENCE:
            break
        touching, paid = best, 0
    return Solved(best, "local", rounds, rows) if np.isfinite(value) else None


def _linearised(programme: Programme, dark: Chosen, y: Point) -> Programme:
    """The programme in which whatever must be large is replaced by its tangent, which is nowhere larger."""
    # Collect the rows that must be at least 1, and put their tangents in their place.
    parts = []
    if programme.floors is not None:
        parts.append(_wide(programme.floors, programme.size))
    if programme.dark is not None:
        parts.append(_wide(programme.dark.rows(*dark), programme.size, programme.bottom))
    planes, rows, objective = programme.planes, programme.rows, programme.objective
    if parts:
        slopes, constants = _tangents(stacked_rows(parts), y)
        planes = Planes(np.vstack([planes.normals, -slopes]), np.concatenate([planes.offsets, constants - MARGIN]))

    # A ratio is at least e^s where the smaller, divided by the tangent of the larger, times e^s is at most 1.
    if programme.ratios is not None:
        large, small = (_wide(rows, programme.size) for rows in programme.ratios)
        slopes, constants = _tangents(large, y)
        # A quotient by a monomial, times e^s with s the last variable, is a posynomial again.
        more = np.zeros(programme.size)
        more[-1] = 1.0
        quotients = [
            Posynomials(small.logs[[k]] - constants[k], small.exponents - slopes[k] + more) for k in range(len(slopes))
        ]
        rows = stacked_rows([_wide(rows, programme.size), *quotients])
        objective = _near(objective, y)
    return replace(programme, planes=planes, rows=rows, objective=objective)


def _near(objective: Objective, centre: Point) -> Objective:
    """The same, and a little of the squared distance: of points that are equally good the nearest, and only one."""
    weights = np.append(np.full(len(centre) - 1, PROXIMITY), 0.0)

    def near(y: Point) -> tuple[float, Point, Matrix]:
        value, gradient, bend = objective(y)
        away = weights * (y - centre)
        return value + float(away @ (y - centre)) / 2, gradient + away, bend + np.diag(weights)

    return near


def _tangents(rows: Posynomials, y: Point) -> tuple[Float[np.ndarray, "row scale"], Float[np.ndarray, " row"]]:
    """Slopes and constants of the tangents of the rows' logarithms."""
    logs, shares = rows.at(y)
    slopes = shares @ rows.exponents
    return slopes, logs - slopes @ y


def _wide(rows: Posynomials, size: int, start: int = 0) -> Posynomials:
    """The same rows among more variables."""
    seen = rows.exponents.shape[1]
    exponents = np.zeros((len(rows.exponents), size))
    exponents[:, start : start + seen] = rows.exponents
    return replace(rows, exponents=exponents)


def _seen(programme: Programme, y: Point) -> Float[np.ndarray, " seen"]:
    """The variables that lower bounds see."""
    seen = 0 if programme.dark is None else programme.dark.exponents.shape[1]
    return y[programme.bottom : programme.bottom + seen]


def most(excess: Float[np.ndarray, " pixel"], limit: float) -> Pixels:
    """The pixels that exceed a limit by most, worst first."""
    over = np.flatnonzero(excess > limit)
    return over[np.argsort(-excess[over], kind="stable")[:ADDED]]
