"""The canary of the extra `fast`: it falls where Numba, as it is here, would round otherwise than NumPy."""

import numpy as np
from jaxtyping import Float

from symrt import arrays
from symrt.fast import pairs
from symrt.fast.compiling import compiled

TAKES = "686c3bd67c847ec1"


@compiled("void(float64[:, ::1], float64[:, ::1])")
def sing(given: Float[np.ndarray, "4 case"], out: Float[np.ndarray, "3 case"]) -> None:
    """For each a, b, c, d the difference ``a d − b c``, and the error of the product a d, and a root of a quotient."""
    for k in range(given.shape[1]):
        a, b, c, d = given[0, k], given[1, k], given[2, k], given[3, k]
        out[0, k] = a * d - b * c
        out[1, k] = pairs.two_product(a, d)[1]
        out[2, k] = np.sqrt(a / c)


def fault() -> str:
    """Why kernels must not be used, or nothing.

    Examples
    --------
    >>> import pytest
    >>> _ = pytest.importorskip("numba")
    >>> fault()
    ''
    """
    # A product that is 2⁻⁶⁰ above a float, less that float: 0, and 2⁻⁶⁰ where multiplication and subtraction are
    # contracted; then the smallest numbers, which must not be flushed to 0; then any.
    draw = np.random.default_rng(1)
    telling = np.array([[1 + 2.0**-30], [1 + 2.0**-29], [1.0], [1 + 2.0**-30]])
    tiny = np.array([[2.0**-1060], [2.0**-1074], [1.0], [2.0**-8]])
    given = np.ascontiguousarray(np.concatenate([telling, tiny, draw.uniform(0.5, 2, (4, 500))], axis=1))
    found = np.empty((3, given.shape[1]))
    sing(given, found)
    a, b, c, d = given
    true = np.stack([a * d - b * c, arrays.two_product(a, d)[1], np.sqrt(a / c)])
    if np.array_equal(found, true):
        return ""
    what = ("a d − b c", "the error of a product", "a quotient's root")[int(np.argmax((found != true).any(axis=1)))]
    return f"compiled here, {what} differs from NumPy's in its last bit; another version of Numba may not"
