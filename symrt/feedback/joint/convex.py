"""Small convex programmes with posynomial constraints: the solver behind joint fits, step 5 of the paper.

Minimise φ(y) where ``ln f_r(y) <= 0`` for some posynomials in y = ln x, and ``normals y <= offsets``: a primal-dual
interior-point method with slacks and a predictor [1]_, [2]_.  It needs no point to start from.

References
----------
.. [1] S. Mehrotra, "On the implementation of a primal-dual interior point method", SIAM J. Optimization 2(4), 1992.
.. [2] J. Nocedal and S. J. Wright, *Numerical Optimization*, Springer 2006, chapter 19.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from symrt.feedback.joint.posynomials import Posynomials

GAP = 1e-13
"""Of slacks times duals, where the search ends."""
MET = 1e-9
"""Residual that counts as none: of constraints, and of the sum of gradients relative to its parts."""
NEWTON_CLOSE = 1e-8
"""Residuals below this are left to Newton's method, which is then close."""
INTERIOR_STEPS = 500
DIVERGED = 1e13
"""Duals above this, relative to the gradient, show that the constraints contradict each other."""
SHORTEST = 1e-3
"""Part of Newton's step that is tried at last."""
INSIDE = 0.99
"""Of the way to where a slack or a dual would vanish, at most."""
CENTRED = 0.4
"""Of slacks times duals, and of the sum of gradients, that a step leaves at least."""
REGULAR = 1e-15
"""Of the scaled matrix: where several points are best, the equations have no single solution."""

Point = Float[np.ndarray, " scale"]
Matrix = Float[np.ndarray, "scale scale"]
PerConstraint = Float[np.ndarray, " constraint"]
Objective = Callable[[Point], tuple[float, Point, Matrix]]
"""Value, gradient and Hessian of a convex function; an infinite value outside its domain."""


class Planes(NamedTuple):
    """Half-spaces ``normals y <= offsets``."""

    normals: Float[np.ndarray, "plane scale"]
    offsets: Float[np.ndarray, " plane"]


@dataclass(frozen=True, eq=False)
class Constraints:
    """Posynomials at most 1, and half-spaces."""

    rows: Posynomials
    planes: Planes

    def at(self, y: Point) -> PerConstraint:
        """The values of all constraints, none of which may be positive."""
        return np.concatenate([self.rows.at(y)[0], self.planes.normals @ y - self.planes.offsets])

    def slopes(self, y: Point) -> Float[np.ndarray, "constraint scale"]:
        """The gradients of all constraints."""
        return np.vstack([self.rows.at(y)[1] @ self.rows.exponents, self.planes.normals])

    def bend(self, y: Point, weights: PerConstraint) -> Matrix:
        """A weighted sum of the Hessians of all constraints."""
        shares, exponents = self.rows.at(y)[1], self.rows.exponents
        weights, slopes = weights[: len(shares)], shares @ exponents
        return (exponents.T * (weights @ shares)) @ exponents - (slopes.T * weights) @ slopes


class Minimum(NamedTuple):
    """The point of least φ, and the steps it took."""

    y: Point
    steps: int


class _State(NamedTuple):
    """A point, the slacks of the constraints, and their duals."""

    y: Point
    slacks: PerConstraint
    duals: PerConstraint

    def moved(self, step: "_State", length: float) -> "_State":
        return _State(*(value + length * change for value, change in zip(self, step, strict=True)))


def minimise(objective: Objective, constraints: Constraints, start: Point) -> Minimum | None:
    """The point of least φ that meets the constraints to 1e-9 or better; None if none was found.

    Parameters
    ----------
    start
        Where to begin: in the domain of φ, perhaps outside the constraints.

    Examples
    --------
    The nearest point to the origin at which x₁ + x₂ is at most 1, in logarithms:

    >>> both = Posynomials(np.zeros((1, 2)), np.eye(2))
    >>> nothing = Planes(np.zeros((0, 2)), np.zeros(0))
    >>> found = minimise(distance(np.zeros(2)), Constraints(both, nothing), np.full(2, -3.0))
    >>> np.exp(found.y).round(9)
    array([0.5, 0.5])
    """
    slacks = np.maximum(-constraints.at(start), 0.1)
    now = _State(start, slacks, 0.1 / slacks)
    # Where there is no such point, duals grow without bound.
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        return _minimised(objective, constraints, now)


def _minimised(objective: Objective, constraints: Constraints, now: _State) -> Minimum | None:
    """As `minimise`, from a state."""
    before = np.inf
    for steps in range(INTERIOR_STEPS):
        dual, primal = _residuals(objective, constraints, now)

        # Arrived, if the gap and both residuals are small.
        size = 1 + np.abs(objective(now.y)[1]).max(initial=0)
        gap, off, slope = now.slacks @ now.duals, np.abs(primal).max(initial=0), np.abs(dual).max()
        if max(gap, off) < GAP * size and slope < MET * size:
            return Minimum(now.y, steps)

        # Rounding ends the progress earlier where constraints are nearly parallel.
        if gap > before / 2 and gap < NEWTON_CLOSE * size and off < GAP * size and slope < NEWTON_CLOSE * size:
            return Minimum(now.y, steps)

        if not now.duals.max(initial=0) < DIVERGED * size:
            return None
        before, now = gap, _stepped(objective, constraints, now, dual, primal)
    return None


def _residuals(objective: Objective, constraints: Constraints, at: _State) -> tuple[Point, PerConstraint]:
    """The sum of gradients, and the differences of constraints and slacks: both are zero at the solution."""
    return (
        objective(at.y)[1] + constraints.slopes(at.y).T @ at.duals,
        constraints.at(at.y) + at.slacks,
    )


def _stepped(objective: Objective, constraints: Constraints, now: _State, dual: Point, primal: PerConstraint) -> _State:
    """Mehrotra's step, centred and bent according to how far Newton's own would come.

    If that brings no progress, Newton's step is taken, shortened until it does.
    """
    # Predict: how much would slacks times duals lose along Newton's own step?
    newton = _newton(objective, constraints, now, dual, primal)
    products = now.slacks * now.duals
    ahead = newton(products)
    _, slacks, duals = now.moved(ahead, min(1.0, _longest(now, ahead)))
    mean = products.mean() if len(products) else 0.0
    aim = mean * (slacks @ duals / products.sum()) ** 3 if mean else 0.0
    # A product that vanishes before the gradients cancel would block all later steps.
    aim = max(aim, CENTRED * min(mean, float(np.abs(dual).max())))

    def far(state: _State) -> float:
        if not np.isfinite(objective(state.y)[0]):
            return np.inf
        parts = (*_residuals(objective, constraints, state), state.slacks * state.duals - aim)
        return float(np.linalg.norm(np.concatenate(parts)))

    # Correct: aim at centred products, bent by the second order of the prediction.
    before, step = max(far(now), NEWTON_CLOSE), newton(products + ahead.slacks * ahead.duals - aim)
    reached = now.moved(step, min(1.0, INSIDE * _longest(now, step)))
    if far(reached) <= before:
        return reached

    # Without progress, take the plain step, and halve it.
    step = newton(products - aim)
    length = min(1.0, INSIDE * _longest(now, step))
    while not far(reached := now.moved(step, length)) <= before and length > SHORTEST:
        length /= 2
    return reached


def _newton(
    objective: Objective, constraints: Constraints, now: _State, dual: Point, primal: PerConstraint
) -> Callable[[PerConstraint], _State]:
    """Newton's step on the conditions of optimality, as a function of the change asked of slacks times duals."""
    slopes = constraints.slopes(now.y)
    # Constraints far from binding go into the matrix; those that bind keep their own equations, or digits would drown.
    far = now.slacks > now.duals
    weight = np.where(far, now.duals / now.slacks, 0.0)
    bend = objective(now.y)[2] + constraints.bend(now.y, now.duals) + (slopes.T * weight) @ slopes
    binding = slopes[~far]
    matrix = np.block([[bend, binding.T], [binding, -np.diag(now.slacks[~far] / now.duals[~far])]])
    solve = _factored(matrix, len(now.y))

    def step(lost: PerConstraint) -> _State:
        pull = -dual - slopes.T @ np.where(far, (now.duals * primal - lost) / now.slacks, 0.0)
        solution = solve(np.concatenate([pull, (lost / now.duals - primal)[~far]]))
        y, slacks, duals = solution[: len(now.y)], np.zeros(len(far)), np.zeros(len(far))
        duals[~far] = solution[len(now.y) :]
        slacks[~far] = -((lost + now.slacks * duals) / now.duals)[~far]
        slacks[far] = (-primal - slopes @ y)[far]
        duals[far] = -((lost + now.duals * slacks) / now.slacks)[far]
        return _State(y, slacks, duals)

    return step


def _factored(matrix: Matrix, scales: int) -> Callable[[Point], Point]:
    """A solver of the equations, which are made regular first: binding constraints may be parallel."""
    diagonal = np.abs(np.diag(matrix))
    scale = np.ones(len(matrix))
    scale[:scales] = 1 / np.sqrt(np.maximum(diagonal[:scales], REGULAR))
    signs = np.where(np.arange(len(matrix)) < scales, REGULAR, -REGULAR)
    regular = matrix * scale[:, None] * scale + np.diag(signs)
    return lambda right: scale * np.linalg.solve(regular, scale * right)


def _longest(now: _State, step: _State) -> float:
    """The longest step that keeps slacks and duals positive."""
    value, change = np.concatenate(now[1:]), np.concatenate(step[1:])
    falling = change < 0
    return float((value[falling] / -change[falling]).min(initial=np.inf))


def distance(origin: Point) -> Objective:
    """Half the squared distance from a point."""
    return lambda y: (float((y - origin) @ (y - origin) / 2), y - origin, np.eye(len(y)))
