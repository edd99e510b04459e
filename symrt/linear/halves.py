"""Pixels of two halves: their sum, and the noise that the halves' difference tells of (step 2).

Each half of a pixel's samples gives half of the pixel.  With errors that are independent, as those of samples drawn
anew are, the sum errs as much as the difference, by the same root mean square.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy import sparse

from symrt.estimates import Estimate
from symrt.interactions import Interaction


def joined(halves: sparse.csr_array) -> sparse.csr_array:
    """The matrix of whole pixels, from one that has two rows for each.

    Examples
    --------
    >>> joined(sparse.csr_array([[0.25, 0.0], [0.25, 0.5]])).toarray()
    array([[0.5, 0.5]])
    """
    rows = halves.shape[0]
    pairs = sparse.csr_array((np.ones(rows), np.arange(rows), np.arange(0, rows + 1, 2)), shape=(rows // 2, rows))
    whole = (pairs @ halves).tocsr()
    whole.sort_indices()
    return whole


def noise(
    halves: sparse.csr_array, interactions: Sequence[Interaction], white: Mapping[str, float]
) -> dict[str, Estimate]:
    """For each light, the error of the pixels that it reaches if all reflectances are 1, as a share of its white.

    Examples
    --------
    >>> halves = sparse.csr_array([[0.25], [0.35], [0.0], [0.0]])
    >>> print(noise(halves, [Interaction("sun", ("sea.diffuse",))], {"sun": 0.5})["sun"])
    about 0.2 (rms), 0.2 at most
    """
    found = {}
    for light, reference in white.items():
        one, other = (halves @ np.array([float(i.light == light) for i in interactions])).reshape(-1, 2).T
        lit = (one != 0) | (other != 0)
        if lit.any() and reference > 0:
            found[light] = Estimate.of(np.abs(one - other)[lit] / reference)
    return found
