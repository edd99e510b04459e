"""Axis names, shapes and the few vector operations that every room needs.

Vectors are stored axis first, ``(3, ray)``: four spheres against 262,144 rays are eight times faster that way than with
``(ray, 3)`` rows.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float

Point = Float[np.ndarray, "3"]
Vectors = Float[np.ndarray, "3 ray"]
PerRay = Float[np.ndarray, " ray"]
PixelBands = Float[np.ndarray, "pixel band"]
PerPixel = Float[np.ndarray, " pixel"]
Spectrum = Float[np.ndarray, " band"]


def dot(a: Float[np.ndarray, "3 #ray"], b: Float[np.ndarray, "3 #ray"]) -> PerRay:
    """Inner product of each pair of vectors.

    Examples
    --------
    >>> dot(np.array([[1.0], [2.0], [3.0]]), np.array([[4.0], [5.0], [6.0]]))
    array([32.])
    """
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def length(v: Vectors) -> PerRay:
    """Length of each vector, without overflow or underflow.

    Examples
    --------
    >>> length(np.array([[3e-320], [4e-320], [0.0]]))
    array([5.e-320])
    """
    scale = power_of_two_above(v)
    scaled = v / scale
    return np.sqrt(dot(scaled, scaled)) * scale


def normalise(v: Vectors) -> Vectors:
    """Unit vectors along `v`, to 2 ulp from 1e-320 to 1e307.

    Raises
    ------
    ValueError
        If a vector is zero, infinite or nan: it has no direction.

    Examples
    --------
    >>> normalise(np.array([[0.0], [3e-320], [0.0]]))
    array([[0.],
           [1.],
           [0.]])
    """
    largest = np.abs(v).max(axis=0, initial=0)
    if not np.all(np.isfinite(largest) & (largest > 0)):
        bad = int(np.argmin(np.isfinite(largest) & (largest > 0)))
        raise ValueError(f"vector {bad} is {v[:, bad].tolist()}: a direction must be finite and not zero")
    # A subnormal vector is lifted first: the scale that would bring it to 1 overflows.
    lifted = v * np.where(largest < 2.0**-1000, 2.0**60, 1.0)
    scaled = lifted / power_of_two_above(lifted)
    return scaled / np.sqrt(dot(scaled, scaled))


def cosine(a: Vectors, b: Vectors) -> PerRay:
    """The cosine between unit vectors, clamped to [0, 1].

    Examples
    --------
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> cosine(up, up), cosine(up, -up)
    (array([1.]), array([0.]))
    """
    return np.clip(dot(a, b), 0.0, 1.0)


def one_minus_cosine(a: Vectors, b: Vectors) -> PerRay:
    """1 − a·b = |a − b|²/2 of unit vectors, at most 1: it keeps its digits where the cosine is close to 1.

    Examples
    --------
    >>> up, beside = np.array([[0.0], [1.0], [0.0]]), np.array([[1e-9], [1.0], [0.0]])
    >>> one_minus_cosine(up, beside)
    array([5.e-19])
    """
    difference = a - b
    return np.minimum(dot(difference, difference) / 2, 1.0)


def reflect(direction: Vectors, normal: Vectors) -> Vectors:
    """Mirror a unit vector that points away from a surface about its normal; the result points away too.

    Examples
    --------
    >>> up, slanting = np.array([[0.0], [1.0], [0.0]]), np.array([[0.6], [0.8], [0.0]])
    >>> reflect(slanting, up).T.tolist()
    [[-0.6, 0.8, 0.0]]
    """
    return 2 * dot(direction, normal) * normal - direction


def turned(v: Vectors, towards: Vectors) -> Vectors:
    """Vectors, of which those that point away from others are turned round.

    Examples
    --------
    >>> turned(np.array([[1.0], [-2.0], [3.0]]), np.array([[0.0], [1.0], [0.0]])).T.tolist()
    [[-1.0, 2.0, -3.0]]
    """
    return np.where(dot(v, towards) < 0, -v, v)


def half_way(a: Vectors, b: Vectors) -> Vectors:
    """The unit vector half way between two; zero where they are exactly opposite, and there is none.

    Examples
    --------
    >>> half_way(np.array([[1.0], [0.0], [0.0]]), np.array([[-1.0], [0.0], [0.0]])).T.tolist()
    [[0.0, 0.0, 0.0]]
    """
    total = a + b
    size = np.sqrt(dot(total, total))
    # Cosines with the zero vector are 0, the dark limit.
    return total / np.where(size > 0, size, 1.0)


def power_of_two_above(v: Vectors) -> PerRay:
    """A power of two of the size of each vector's largest component, 1 for a zero vector."""
    exponent = np.frexp(np.abs(v).max(axis=0, initial=0))[1]
    return np.ldexp(1.0, np.clip(exponent, -1021, 1023))


@lru_cache(maxsize=1)
def keep_memory() -> None:
    """Make the allocator keep the memory of arrays that are let go, for the next ones: once a process.

    GNU's allocator maps large arrays one by one and gives them back at once, so that each new one is cleared page by
    page, for a fifth of a render's time.  It learns from the largest one that is given back, up to 32 MiB: from then on
    arrays of up to that size come from memory that it keeps.  Other allocators do so anyway.

    References
    ----------
    .. [1] "Memory Allocation Tunables", The GNU C Library Reference Manual: glibc.malloc.mmap_threshold.
    """
    np.empty((32 << 20) - 8192, np.uint8)


Pair = tuple[np.ndarray, np.ndarray]
"""An unevaluated sum ``high + low`` of two float64 arrays: about 32 decimal digits."""


def two_sum(a: np.ndarray, b: np.ndarray) -> Pair:
    """The sum and its rounding error: ``a + b == high + low`` exactly (Knuth).

    Examples
    --------
    >>> high, low = two_sum(np.array([1.0]), np.array([2.0**-60]))
    >>> bool(high[0] == 1.0), bool(low[0] == 2.0**-60)
    (True, True)
    """
    high = a + b
    part = high - a
    return high, (a - (high - part)) + (b - part)


def two_product(a: np.ndarray, b: np.ndarray) -> Pair:
    """The product and its rounding error: ``a * b == high + low`` exactly (Dekker), away from over- and underflow.

    Examples
    --------
    >>> high, low = two_product(np.array([1 + 2.0**-30]), np.array([1 - 2.0**-30]))
    >>> bool(high[0] == 1.0), bool(low[0] == -(2.0**-60))
    (True, True)
    """
    high = a * b
    (a_head, a_tail), (b_head, b_tail) = _halves(a), _halves(b)
    return high, a_tail * b_tail - (((high - a_head * b_head) - a_tail * b_head) - a_head * b_tail)


def pair_sum(a: Pair, b: Pair) -> Pair:
    """The sum of two pairs, accurate to 2⁻¹⁰⁴ of the result even where it cancels.

    Examples
    --------
    >>> one, tiny = (np.array([1.0]), np.array([2.0**-70])), (np.array([-1.0]), np.array([0.0]))
    >>> bool(pair_sum(one, tiny)[0][0] == 2.0**-70)
    True
    """
    high, error = two_sum(a[0], b[0])
    low, rest = two_sum(a[1], b[1])
    high, low = _renormalise(high, error + low)
    return _renormalise(high, low + rest)


def pair_product(a: Pair, b: Pair) -> Pair:
    """The product of two pairs, to about 2⁻¹⁰² of the result.

    Examples
    --------
    >>> third = (np.array([1 / 3]), np.array([2.0**-55 / 1.5]))
    >>> three = (np.array([3.0]), np.array([0.0]))
    >>> bool(pair_product(third, three)[0][0] == 1.0)
    True
    """
    high, low = two_product(a[0], b[0])
    return _renormalise(high, low + (a[0] * b[1] + a[1] * b[0]))


def pair_quotient(a: Pair, b: Pair) -> np.ndarray:
    """The quotient of two pairs, rounded to one float with little more than half an ulp of error.

    Examples
    --------
    >>> pair_quotient(exact(np.array([1.0])), exact(np.array([3.0])))
    array([0.33333333])
    """
    quotient = a[0] / b[0]
    product, rest = two_product(quotient, b[0])
    correction = (((a[0] - product) - rest) + (a[1] - quotient * b[1])) / b[0]
    return np.where(np.isfinite(correction), quotient + correction, quotient)


def pair_dot(a: Pair, b: Pair) -> Pair:
    """Inner products of vectors of pairs, to about 2⁻¹⁰² of Σ|aᵢbᵢ| [1]_.

    References
    ----------
    .. [1] T. Ogita, S. M. Rump and S. Oishi, "Accurate Sum and Dot Product", SIAM J. Sci. Comput. 26(6), 2005.

    Examples
    --------
    The plain product rounds 1e17 + 1 − 1e17 to 0:

    >>> a = exact(np.array([[1e17], [1.0], [-1e17]]))
    >>> pair_dot(a, exact(np.ones((3, 1))))[0]
    array([1.])
    """
    total, error = two_product(a[0][0], b[0][0])
    error = error + (a[0][0] * b[1][0] + a[1][0] * b[0][0])
    for i in (1, 2):
        product, rest = two_product(a[0][i], b[0][i])
        total, lost = two_sum(total, product)
        error = error + ((rest + lost) + (a[0][i] * b[1][i] + a[1][i] * b[0][i]))
    return _renormalise(total, error)


def pair_cross(a: Pair, b: Pair) -> Pair:
    """Cross products of vectors of pairs, to about 2⁻¹⁰² of |a||b|.

    Examples
    --------
    >>> x, y = exact(np.array([[1.0], [0.0], [0.0]])), exact(np.array([[0.0], [1.0], [0.0]]))
    >>> pair_cross(x, y)[0].T
    array([[0., 0., 1.]])
    """
    components = [_difference_of_products(a, b, i, (i + 1) % 3) for i in (1, 2, 0)]
    return np.stack([c[0] for c in components]), np.stack([c[1] for c in components])


def exact(a: np.ndarray) -> Pair:
    """A pair that holds the floats of `a` and nothing below them; the low part has one column for all rays.

    Examples
    --------
    >>> exact(np.ones((3, 5)))[1].shape
    (3, 1)
    """
    return a, np.zeros((*a.shape[:-1], 1))


def negative(a: Pair) -> Pair:
    """The pair with its sign turned.

    Examples
    --------
    >>> negative(exact(np.array([1.0])))[0]
    array([-1.])
    """
    return -a[0], -a[1]


def _halves(a: np.ndarray) -> Pair:
    """Two halves of 26 bits each (Veltkamp), whose products are exact."""
    scaled = 134217729.0 * a
    head = scaled - (scaled - a)
    return head, a - head


def _renormalise(high: np.ndarray, low: np.ndarray) -> Pair:
    total = high + low
    return total, low - (total - high)


def _difference_of_products(a: Pair, b: Pair, i: int, j: int) -> Pair:
    """``aᵢ bⱼ − aⱼ bᵢ`` as a pair."""
    first, first_rest = two_product(a[0][i], b[0][j])
    second, second_rest = two_product(a[0][j], b[0][i])
    total, lost = two_sum(first, -second)
    below = (a[0][i] * b[1][j] + a[1][i] * b[0][j]) - (a[0][j] * b[1][i] + a[1][j] * b[0][i])
    return _renormalise(total, ((first_rest - second_rest) + lost) + below)
