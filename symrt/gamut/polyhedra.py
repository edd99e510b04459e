"""Sets that half-spaces bound, ``normals · x <= offsets``: deepest point, nearest points and supports, for step 4.

The deepest point is the centre of the largest ball inside, by a linear programme.  The nearest point to another is a
problem of least distance, which non-negative least squares solves exactly, in finitely many steps [1]_.  A support is
the optimum of a linear programme; what is returned is the bound that its multipliers prove, not the optimum as the
solver's tolerance leaves it.

References
----------
.. [1] C. L. Lawson and R. J. Hanson, "Solving Least Squares Problems", Prentice-Hall 1974, ch. 23 (problem LDP).
"""

import numpy as np
from jaxtyping import Float
from scipy.optimize import linprog, nnls

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.gamut.interface import ON_BOUNDARY, of_one_band

UNBOUNDED_STATUS = 3
"""What HiGHS answers, through SciPy, where an objective has no limit."""

Normals = Float[np.ndarray, "face band"]
Offsets = Float[np.ndarray, " face"]


def halfspaces(
    matrix: Float[np.ndarray, "band slab"], lower: Float[np.ndarray, " slab"], upper: Float[np.ndarray, " slab"]
) -> tuple[Normals, Offsets]:
    """Slabs ``lower <= x A <= upper`` as half-spaces whose normals have the length 1; open sides are left out.

    Examples
    --------
    >>> normals, offsets = halfspaces(np.array([[2.0]]), np.array([-np.inf]), np.array([3.0]))
    >>> normals.tolist(), offsets.tolist()
    ([[1.0]], [1.5])
    """
    length = np.linalg.norm(matrix, axis=0)
    above, below = np.isfinite(upper), np.isfinite(lower)
    normals = np.vstack([(matrix / length).T[above], -(matrix / length).T[below]])
    return normals, np.concatenate([(upper / length)[above], -(lower / length)[below]])


def deepest(normals: Normals, offsets: Offsets) -> tuple[Spectrum, float]:
    """The centre of the largest ball of radius at most 1 inside, and its radius; below 0 if there is nothing inside.

    Normals have the length 1.

    Examples
    --------
    >>> centre, radius = deepest(np.array([[1.0], [-1.0]]), np.array([0.75, -0.25]))
    >>> centre.round(9).tolist(), round(radius, 9)
    ([0.5], 0.25)
    """
    bands = normals.shape[1]
    rows = np.column_stack([normals, np.ones(len(normals))])
    found = linprog(np.append(np.zeros(bands), -1.0), rows, offsets, bounds=[(None, None)] * bands + [(None, 1.0)])
    if found.x is None:
        raise ArithmeticError(f"the deepest point of {len(normals)} half-spaces was not found: {found.message}")
    return found.x[:-1], float(found.x[-1])


def nearest_point(normals: Normals, offsets: Offsets, point: Spectrum) -> Spectrum:
    """The point inside that is nearest to another; where there is nothing inside, that is an error.

    Examples
    --------
    >>> nearest_point(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([1.0, 1.0]), np.array([1.5, 0.25])).tolist()
    [1.0, 0.25]
    """
    room = offsets - normals @ point
    if np.all(room >= 0):
        return point

    # Far away everything is brought near by a power of two, which changes no digit.
    scale = 2.0 ** max(0, int(np.frexp(-room.min())[1]))
    room = room / scale

    # Solve the least-distance problem; its residual is the direction to the nearest point, or 0 if there is none.
    wanted = np.append(np.zeros(len(point)), 1.0)
    rows = np.vstack([-normals.T, -room])
    multipliers = nnls(rows, wanted, maxiter=10 * len(room))[0]
    missed = rows @ multipliers - wanted
    if np.linalg.norm(missed) <= ON_BOUNDARY:
        raise ValueError("nothing is inside all of the half-spaces")

    # The rough answer tells which faces it touches; least squares on those alone find the place to the last digits.
    touching = multipliers > 0
    moved = np.linalg.lstsq(normals[touching], room[touching], rcond=None)[0]
    rough = -missed[:-1] / missed[-1]
    return np.asarray(point + scale * (moved if np.linalg.norm(moved - rough) <= 1e-6 else rough))


def supports(
    matrix: Float[np.ndarray, "band slab"],
    lower: Float[np.ndarray, " slab"],
    upper: Float[np.ndarray, " slab"],
    directions: PixelBands,
) -> PerPixel:
    """The largest inner product of each direction with a point that slabs hold; ``inf`` where there is none.

    A slab of one band alone is a bound of that variable; the multipliers of the others prove, with the bounds, that no
    point inside goes farther.

    Examples
    --------
    Points of the unit square whose coordinates sum to 1.5 at most:

    >>> matrix = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    >>> supports(matrix, np.zeros(3), np.array([1.0, 1.0, 1.5]), np.array([[2.0, 1.0]])).round(9)
    array([2.5])
    """
    alone = of_one_band(matrix)
    bands = matrix[:, alone].argmax(axis=0)
    low, high = np.full(len(matrix), -np.inf), np.full(len(matrix), np.inf)
    np.maximum.at(low, bands, lower[alone])
    np.minimum.at(high, bands, upper[alone])
    normals, offsets = halfspaces(matrix[:, ~alone], lower[~alone], upper[~alone])
    bounds = np.column_stack([low, high])
    return np.array([_support(normals, offsets, bounds, direction) for direction in directions])


def _support(normals: Normals, offsets: Offsets, bounds: Float[np.ndarray, "band 2"], direction: Spectrum) -> float:
    """The support in one direction, as the multipliers of the linear programme prove it."""
    size = np.abs(direction).max(initial=0.0)
    if size == 0:
        return 0.0

    # Solve the programme in a direction of size 1.
    rows = {"A_ub": normals, "b_ub": offsets} if len(normals) else {}
    found = linprog(-direction / size, bounds=bounds, **rows)
    if found.status == UNBOUNDED_STATUS:
        return np.inf
    if found.x is None:
        raise ArithmeticError(f"a support was not found: {found.message}")

    # Sum up the bound that the multipliers prove.
    multipliers = -found.ineqlin.marginals.clip(max=0) if len(normals) else np.zeros(0)
    left = direction / size - multipliers @ normals
    # What the multipliers leave of the direction in a band without a bound is the solver's rounding.
    left[np.isinf(np.where(left > 0, bounds[:, 1], bounds[:, 0])) & (np.abs(left) <= 1e-7)] = 0
    ends = np.where(left > 0, bounds[:, 1], bounds[:, 0])
    return float(size * (multipliers @ offsets + np.where(left == 0, 0.0, left * np.where(left == 0, 0, ends)).sum()))
