"""Other people's solvers for the questions of a fit, with every row of an image at once; rows are shares of bounds."""

import numpy as np
from scipy.optimize import linprog, minimize


def rows_of(judged):
    """What each scale adds to the share of the upper bound, (pixel × band × scale): no constants and no products."""
    assert (judged.degrees.sum(axis=1) == 1).all()
    return np.einsum("pi,ib,is->pbs", judged.weights, judged.products / judged.upper, judged.degrees)


def gains_of(judged, pixels=slice(None)):
    """What each scale adds to the mean luminance of some pixels."""
    return (judged.weights[pixels].mean(axis=0) * (judged.products @ judged.luminance)) @ judged.degrees


def undominated(rows):
    """Rows that no other is at least as large as in every column: all others follow from them."""
    rows = np.unique(rows.reshape(-1, rows.shape[-1]), axis=0)
    larger = (rows[:, None] <= rows[None]).all(axis=2)
    np.fill_diagonal(larger, val=False)
    return rows[~larger.any(axis=1)]


def fairest(rows, limits, bounds):
    """Lexicographic max-min by linear programmes: raise the least, fix what cannot rise, go on."""
    count = rows.shape[1]
    fixed = {}
    while len(fixed) < count:
        free = [i for i in range(count) if i not in fixed]
        box = [(fixed[i], fixed[i]) if i in fixed else bounds[i] for i in range(count)]
        apart = np.zeros((len(free), count + 1))
        apart[np.arange(len(free)), free], apart[:, -1] = -1, 1
        rows_and_level = np.vstack([np.hstack([rows, np.zeros((len(rows), 1))]), apart])
        right = np.concatenate([limits, np.zeros(len(free))])
        level = linprog([*[0] * count, -1], rows_and_level, right, bounds=[*box, (None, None)]).x[-1]
        at_least = [
            (fixed[i] - 1e-11, fixed[i]) if i in fixed else (max(bounds[i][0], level - 1e-11), bounds[i][1])
            for i in range(count)
        ]
        for i in free:
            objective = np.zeros(count)
            objective[i] = -1
            if linprog(objective, rows, limits, bounds=at_least).x[i] <= level + 1e-7:
                fixed[i] = level
    return np.array([fixed[i] for i in range(count)])


def filled(rows, within):
    """The same of positive rows, in closed form: all rise together, those in a full row stop, the rest goes on."""
    low, high = within
    values, free = np.zeros(rows.shape[1]), np.ones(rows.shape[1], bool)
    while free.any():
        met = rows[rows[:, free].any(axis=1)]
        limit = (1 - met @ values) / met[:, free].sum(axis=1)
        level = min(high, limit.min(initial=np.inf))
        assert level >= low
        stopped = free & (met[limit <= level * (1 + 1e-12)].any(axis=0) | (level == high))
        values[stopped], free = level, free & ~stopped
    return values


def nearest(rows, within):
    """The least change, by sequential quadratic programming in logarithms of the scales."""
    answer = minimize(
        lambda y: y @ y / 2,
        np.full(rows.shape[1], max(np.log(within[0]), -2.0)),
        jac=lambda y: y,
        bounds=[tuple(np.log(within))] * rows.shape[1],
        constraints={"type": "ineq", "fun": lambda y: 1 - rows @ np.exp(y), "jac": lambda y: -rows * np.exp(y)},
        method="SLSQP",
        options={"ftol": 1e-15, "maxiter": 500},
    )
    return np.exp(answer.x)


def largest(gain, rows, within):
    """The largest sum, by HiGHS."""
    return linprog(-gain, rows, np.ones(len(rows)), bounds=[within] * len(gain)).x


def largest_ratio(light, dark, rows, within):
    """The largest quotient of two sums: a linear programme in x / dark·x and 1 / dark·x (Charnes and Cooper 1962)."""
    low, high = within
    count = len(light)
    eye = np.eye(count)
    below = np.vstack([np.hstack([-eye, np.full((count, 1), low)]), np.hstack([eye, np.full((count, 1), -high)])])
    below = np.vstack([np.hstack([rows, -np.ones((len(rows), 1))]), below])
    one = np.append(dark, 0.0)[None]
    answer = linprog(-np.append(light, 0.0), below, np.zeros(len(below)), one, [1.0])
    return answer.x[:-1] / answer.x[-1]


def largest_least_ratio(lights, darks, rows, within):
    """The largest least of several quotients: for each level it is a question for HiGHS whether all reach it."""
    low, high = 0.0, 1e3
    for _ in range(50):
        level = (low + high) / 2 if low == 0 else np.sqrt(low * high)
        above = np.vstack([rows, *(level * dark - light for light, dark in zip(lights, darks, strict=True))])
        right = np.append(np.ones(len(rows)), np.zeros(len(lights)))
        met = linprog(np.zeros(rows.shape[1]), above, right, bounds=[within] * rows.shape[1]).status == 0
        low, high = (level, high) if met else (low, level)
    return low


def climbed(value, room, start, within):
    """The best near a start, by sequential quadratic programming in logarithms; `value` is to be small, `room` ≥ 0."""
    answer = minimize(
        value,
        start,
        bounds=[tuple(np.log(within))] * len(start),
        constraints={"type": "ineq", "fun": room},
        method="SLSQP",
        options={"ftol": 1e-12, "maxiter": 200},
    )
    return answer.x
