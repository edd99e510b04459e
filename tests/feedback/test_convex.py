"""The small convex solver, against another solver, against what is known, and where there is nothing to find."""

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from symrt.feedback.joint.convex import Constraints, Planes, distance, minimise
from symrt.feedback.joint.posynomials import Posynomials, stacked_rows


def programme(seed, scales=5, rows=60):
    """Random posynomials with a constant, and a box of −4.6 … 1.1 in logarithms."""
    random = np.random.default_rng(seed)
    exponents = np.vstack([np.zeros((1, scales)), random.integers(0, 3, (12, scales))])
    terms = random.uniform(0, 0.1, (rows, 13)) * (random.uniform(size=(rows, 13)) < 0.4)
    terms[:, 0] = 0.1
    with np.errstate(divide="ignore"):
        logs = np.log(terms)
    eye = np.eye(scales)
    box = Planes(np.vstack([eye, -eye]), np.concatenate([np.full(scales, 1.1), np.full(scales, 4.6)]))
    return Constraints(Posynomials(logs, exponents), box)


def furthest(y):
    return -float(y.sum()), -np.ones(len(y)), np.zeros((len(y), len(y)))


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("objective", [distance(np.ones(5)), furthest], ids=["distance", "linear"])
def test_the_minimum_agrees_with_sequential_quadratic_programming(objective, seed):
    constraints = programme(seed)
    found = minimise(objective, constraints, np.zeros(5))
    assert found is not None
    assert constraints.at(found.y).max() <= 1e-12
    oracle = minimize(
        lambda y: objective(y)[0],
        np.full(5, -4.0),
        jac=lambda y: objective(y)[1],
        constraints={"type": "ineq", "fun": lambda y: -constraints.at(y), "jac": lambda y: -constraints.slopes(y)},
        method="SLSQP",
        options={"ftol": 1e-13, "maxiter": 500},
    )
    assert objective(found.y)[0] <= oracle.fun + 1e-9
    assert objective(found.y)[0] == pytest.approx(oracle.fun, abs=1e-6)


@pytest.mark.parametrize("seed", range(20))
def test_a_linear_programme_has_the_optimum_of_highs(seed):
    random = np.random.default_rng(seed)
    normals, offsets = random.normal(size=(40, 6)), random.uniform(0.5, 1, 40)
    planes = Planes(np.vstack([normals, np.eye(6), -np.eye(6)]), np.concatenate([offsets, np.full(12, 10.0)]))
    found = minimise(furthest, Constraints(Posynomials(np.zeros((0, 1)), np.zeros((1, 6))), planes), np.zeros(6))
    oracle = linprog(-np.ones(6), planes.normals, planes.offsets, bounds=(None, None))
    assert found is not None
    # HiGHS meets its rows to 1e-7.
    assert -found.y.sum() == pytest.approx(oracle.fun, rel=1e-7)


@pytest.mark.parametrize("seed", range(5))
def test_duplicated_and_nearly_parallel_rows_change_nothing(seed):
    constraints = programme(seed)
    rows = constraints.rows
    nudged = Posynomials(rows.logs - 1e-11, rows.exponents)
    more = Constraints(stacked_rows([rows, rows, nudged]), constraints.planes)
    one, other = (minimise(distance(np.ones(5)), c, np.zeros(5)) for c in (constraints, more))
    assert one is not None
    assert other is not None
    np.testing.assert_allclose(other.y, one.y, atol=1e-9)


@pytest.mark.parametrize("gap", [1e-6, 1e-3, 1.0])
def test_constraints_that_contradict_each_other_have_no_minimum(gap):
    planes = Planes(np.array([[1.0], [-1.0]]), np.array([0.0, -gap]))
    nothing = Posynomials(np.zeros((0, 1)), np.zeros((1, 1)))
    assert minimise(distance(np.zeros(1)), Constraints(nothing, planes), np.zeros(1)) is None


def test_slopes_and_bends_are_derivatives():
    constraints, random = programme(0), np.random.default_rng(0)
    y, weights, step = random.normal(size=5), random.uniform(size=70), 1e-6
    for k in range(5):
        ahead, behind = y + step * np.eye(5)[k], y - step * np.eye(5)[k]
        slope = (constraints.at(ahead) - constraints.at(behind)) / (2 * step)
        bend = weights @ (constraints.slopes(ahead) - constraints.slopes(behind)) / (2 * step)
        # Central differences at this step are good to about 1e-9.
        np.testing.assert_allclose(constraints.slopes(y)[:, k], slope, atol=1e-8)
        np.testing.assert_allclose(constraints.bend(y, weights)[k], bend, atol=1e-7)
