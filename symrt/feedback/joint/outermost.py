"""The pixels that decide for all others: step 5 of the paper, before any programme is solved.

With coefficients and spectra ≥ 0, a pixel whose coefficients are nowhere larger than another's is nowhere lighter,
whatever the lights and the materials: it is below every upper bound that the other is below.  And a mixture of pixels
is inside where they are.  Of pixels that see the same interactions only the largest, in the sense of Pareto [1]_, need
to be looked at, and of those only the corners of their convex hull [2]_.  For lower bounds it is the smallest.

References
----------
.. [1] S. Börzsönyi, D. Kossmann and K. Stocker, "The skyline operator", Proc. ICDE 2001, pp. 421-430.
.. [2] C. B. Barber, D. P. Dobkin and H. Huhdanpaa, "The Quickhull algorithm for convex hulls", ACM TOMS 22(4), 1996.
"""

import numpy as np
from jaxtyping import Float, Int
from scipy import sparse
from scipy.spatial import ConvexHull

from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]
COMPARISONS = 64
"""Comparisons of one pixel with all others of the same interactions; a hull, or nobody, judges the rest."""
DIMENSIONS = 5
"""Hulls in more dimensions have too many faces."""


def outermost(system: LinearSystem, pixels: Pixels, *, upper: bool = True) -> Pixels:
    """Those of some pixels, sorted, that bound all of them from above, or from below.

    Examples
    --------
    >>> system = LinearSystem.of("0.5*sun", "0.25*sun", "0.25*sun + 0.5*sky", "0.5*sun + 0.25*sky")
    >>> outermost(system, np.arange(4)), outermost(system, np.arange(4), upper=False)
    (array([0, 2, 3]), array([1, 2, 3]))
    """
    rows = sparse.csr_array(system.G[pixels])
    rows.sum_duplicates()
    rows.eliminate_zeros()
    lengths = np.diff(rows.indptr)

    # Group the pixels by their interactions.
    # Pixels of the same interactions have the same sum of random numbers; others hardly ever, and are told apart below.
    numbers = np.random.default_rng(0).integers(0, 2**62, rows.shape[1], dtype=np.uint64)
    sums = np.append(np.uint64(0), np.cumsum(numbers[rows.indices], dtype=np.uint64))
    keys = sums[rows.indptr[1:]] - sums[rows.indptr[:-1]]
    order = np.lexsort((keys, lengths))
    changes = np.flatnonzero((np.diff(keys[order]) != 0) | (np.diff(lengths[order]) != 0)) + 1

    # Keep the largest of each group; pixels that only share its random sum are kept, too.
    kept = []
    for group in np.split(order, changes):
        if not len(group) or not lengths[group[0]]:
            continue
        places = rows.indptr[group][:, None] + np.arange(lengths[group[0]])
        same = (rows.indices[places] == rows.indices[places[0]]).all(axis=1)
        values = rows.data[places[same]] * (1 if upper else -1)
        kept += [group[~same], group[same][_largest(values)]]
    return np.sort(pixels[np.concatenate([*kept, np.zeros(0, dtype=int)])])


def _largest(values: Float[np.ndarray, "pixel coefficient"]) -> Int[np.ndarray, " kept"]:
    """The rows that no other is at least as large as in every column, and no mixture; of equal ones the first."""
    # Sorted by their sums, a row can only be dominated by an earlier one.
    kept, rest = [], np.argsort(-values.sum(axis=1), kind="stable")
    for _ in range(COMPARISONS):
        if not len(rest):
            break
        kept.append(rest[:1])
        rest = rest[~(values[rest] <= values[rest[0]]).all(axis=1)]

    # Of many that are left, in few dimensions, a convex hull keeps its corners.
    front = np.concatenate([*kept, rest])
    return front[_corners(values[front])] if 1 < values.shape[1] <= DIMENSIONS and len(front) > COMPARISONS else front


def _corners(values: Float[np.ndarray, "pixel coefficient"]) -> Int[np.ndarray, " corner"]:
    """The corners of the convex hull of all that is nowhere larger, and what rounding cannot tell from its faces."""
    least, span = values.min(axis=0), np.ptp(values, axis=0)
    scaled = (values - least) / np.where(span > 0, span, 1.0)
    below = np.full((1 + values.shape[1], values.shape[1]), -1.0)
    below[1:][np.diag_indices(values.shape[1])] = scaled.max(axis=0)
    hull = ConvexHull(np.vstack([scaled, below]), qhull_options="Qt Qc")
    found = np.union1d(hull.vertices, hull.coplanar[:, 0])
    return found[found < len(values)]
