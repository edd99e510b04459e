"""The brightest image where every pixel is affine in the scales: a linear programme by cutting planes, step 5.

All lights, or materials of degree 1, make the image ``A x + b``, A ≥ 0, with a row for each pixel and band.  HiGHS [1]_
solves the programme of a few of them; what its solution violates most is added, until nothing is violated by more than
rounding.  HiGHS takes coefficients below 1e-9 for zeros and calls rows met that are violated by 1e-7: rows and columns
are scaled by powers of two first, and the solution is drawn towards the low end, where the image is inside, as far as
its largest violation asks for.

References
----------
.. [1] Q. Huangfu and J. A. J. Hall, "Parallelizing the dual revised simplex method", Mathematical Programming
   Computation 10(1), 2018, pp. 119-142.
"""

import numpy as np
from jaxtyping import Float
from scipy.optimize import linprog

from symrt.feedback.joint.constraints import Joint
from symrt.feedback.joint.posynomials import Posynomials, Sliders
from symrt.feedback.joint.programmes import MARGIN, MOST_ROUNDS, Solved, most

TOLERANCES = (1e-10, 1e-9, 1e-8)
"""Violations that HiGHS is asked for: the least that it can be, and larger ones where it does not settle with that."""

Point = Float[np.ndarray, " scale"]


def affine(rows: Posynomials | Sliders) -> bool:
    """Whether no term has two factors that are scaled."""
    return bool((rows.exponents.sum(axis=1) <= 1).all())


def largest(sums: Posynomials, found: Joint) -> Solved:
    """The scales of the largest sum, one row, that keep an affine image inside.

    Raises
    ------
    ArithmeticError
        If HiGHS does not find what must be there.

    Examples
    --------
    See `symrt.feedback.fit` with ``objective="brightest"``.
    """
    said: Solved | str = ""
    for tolerance in TOLERANCES:
        said = _largest(sums, found, tolerance)
        if isinstance(said, Solved):
            return said
    raise ArithmeticError(f"HiGHS: {said}")


def _largest(sums: Posynomials, found: Joint, tolerance: float) -> Solved | str:
    """As `largest`, at one tolerance; the message of HiGHS where it does not settle."""
    low, high = np.exp(found.low), np.exp(found.high)
    gain, _ = _matrix(sums)
    chosen = found.image.first()
    for rounds in range(1, MOST_ROUNDS):
        # Solve with the rows chosen so far.
        found.task.tick()
        parts = [_matrix(found.image.rows(*chosen)), _matrix(found.caps)]
        matrix, constant = (np.concatenate(part) for part in zip(*parts, strict=True))
        x = _solution(gain[0], matrix, 1 - constant, low, high, tolerance)
        if isinstance(x, str):
            return x

        # Add the pixels that are farthest outside; what the tolerance leaves is drawn inside at the end.
        share, slab = found.image.brightest(np.log(x))
        over = most(share - 1, 2 * tolerance)
        if not len(over):
            return Solved(np.log(_inside(found, x, low, float(share.max(initial=0.0)))), "global", rounds, len(matrix))
        chosen = np.append(chosen[0], over), np.append(chosen[1], slab[over])
    return f"rows are still violated after {MOST_ROUNDS} rounds"


def _matrix(rows: Posynomials) -> tuple[Float[np.ndarray, "row scale"], Float[np.ndarray, " row"]]:
    """Coefficients and constants of affine rows."""
    terms = np.exp(rows.logs)
    return terms @ rows.exponents, terms[:, ~rows.exponents.any(axis=1)].sum(axis=1)


def _solution(
    gain: Point,
    matrix: Float[np.ndarray, "row scale"],
    room: Float[np.ndarray, " row"],
    low: Point,
    high: Point,
    tolerance: float,
) -> Point | str:
    """The solution for some rows, in variables and rows of size 1; the message of HiGHS where it finds none."""
    column = _power_of_two(np.concatenate([matrix, gain[None] / max(gain.max(), np.finfo(float).tiny)]).max(axis=0))
    scaled = matrix / column
    row = _power_of_two(scaled.max(axis=1, initial=0.0))
    bounds = np.column_stack([low * column, high * column])
    aim = gain / column
    options = {"primal_feasibility_tolerance": tolerance, "dual_feasibility_tolerance": tolerance}
    answer = linprog(
        -aim / _power_of_two(np.array([aim.max()])), scaled / row[:, None], room / row, bounds=bounds, options=options
    )
    if answer.x is None:
        return str(answer.message)
    return np.clip(answer.x / column, low, high)


def _inside(found: Joint, x: Point, low: Point, share: float) -> Point:
    """The point on the way from the low end to x at which a violation by a share, affine in x, is gone for sure."""
    logs = found.caps.at(np.log(x))[0].max(initial=-np.inf)
    worst = max(share, float(np.exp(logs)))
    if worst <= 1 - MARGIN / 2:
        return x
    least = max(
        float(found.image.brightest(found.low)[0].max(initial=0.0)),
        float(np.exp(found.caps.at(found.low)[0].max(initial=-np.inf))),
    )
    return low + (1 - MARGIN - least) / (worst - least) * (x - low)


def _power_of_two(size: Float[np.ndarray, " number"]) -> Float[np.ndarray, " number"]:
    """The power of two near each number, 1 for 0."""
    return np.where(size > 0, np.exp2(np.round(np.log2(np.where(size > 0, size, 1.0)))), 1.0)
