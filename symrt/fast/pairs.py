"""Error-free arithmetic for one number at a time: `symrt.arrays`, compiled, operation by operation the same.

A pair is a tuple ``(high, low)``, a vector of pairs a tuple of three of them.  Numba's cache looks at a kernel's own
file alone; so each of those keeps, as `TAKES`, a digest of what it takes from elsewhere: where that changes, a test
asks for the new one, and no machine code of before is used.
"""

import numpy as np

from symrt.fast.compiling import compiled

Pair = tuple[float, float]
Triple = tuple[float, float, float]
Pairs = tuple[Pair, Pair, Pair]


@compiled()
def least(a: float, b: float) -> float:
    """As ``np.minimum``: nan if either is."""
    return a if (a <= b) | np.isnan(a) else b


@compiled()
def most(a: float, b: float) -> float:
    """As ``np.maximum``: nan if either is."""
    return a if (a >= b) | np.isnan(a) else b


@compiled()
def signed(size: float, like: float) -> float:
    """As ``np.copysign`` of a size, 0 or more, in operations that are done for several numbers at a time."""
    return size if (like > 0) | ((like == 0) & (1 / like > 0)) else -size


@compiled()
def dot(a: Triple, b: Triple) -> float:
    """As `arrays.dot`."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled()
def two_sum(a: float, b: float) -> Pair:
    """As `arrays.two_sum`."""
    high = a + b
    part = high - a
    return high, (a - (high - part)) + (b - part)


@compiled()
def two_product(a: float, b: float) -> Pair:
    """As `arrays.two_product`."""
    high = a * b
    scaled = 134217729.0 * a
    a_head = scaled - (scaled - a)
    a_tail = a - a_head
    scaled = 134217729.0 * b
    b_head = scaled - (scaled - b)
    b_tail = b - b_head
    return high, a_tail * b_tail - (((high - a_head * b_head) - a_tail * b_head) - a_head * b_tail)


@compiled()
def renormalise(high: float, low: float) -> Pair:
    """The sum of two floats, the larger first, as a pair."""
    total = high + low
    return total, low - (total - high)


@compiled()
def negative(a: Pair) -> Pair:
    """As `arrays.negative`."""
    return -a[0], -a[1]


@compiled()
def pair_sum(a: Pair, b: Pair) -> Pair:
    """As `arrays.pair_sum`."""
    high, error = two_sum(a[0], b[0])
    low, rest = two_sum(a[1], b[1])
    high, low = renormalise(high, error + low)
    return renormalise(high, low + rest)


@compiled()
def pair_product(a: Pair, b: Pair) -> Pair:
    """As `arrays.pair_product`."""
    high, low = two_product(a[0], b[0])
    return renormalise(high, low + (a[0] * b[1] + a[1] * b[0]))


@compiled()
def pair_quotient(a: Pair, b: Pair) -> float:
    """As `arrays.pair_quotient`."""
    quotient = a[0] / b[0]
    product, rest = two_product(quotient, b[0])
    correction = (((a[0] - product) - rest) + (a[1] - quotient * b[1])) / b[0]
    return quotient + correction if np.isfinite(correction) else quotient


@compiled()
def pair_dot(a: Pairs, b: Pairs) -> Pair:
    """As `arrays.pair_dot`."""
    total, error = two_product(a[0][0], b[0][0])
    error = error + (a[0][0] * b[0][1] + a[0][1] * b[0][0])
    product, rest = two_product(a[1][0], b[1][0])
    total, lost = two_sum(total, product)
    error = error + ((rest + lost) + (a[1][0] * b[1][1] + a[1][1] * b[1][0]))
    product, rest = two_product(a[2][0], b[2][0])
    total, lost = two_sum(total, product)
    error = error + ((rest + lost) + (a[2][0] * b[2][1] + a[2][1] * b[2][0]))
    return renormalise(total, error)


@compiled()
def difference_of_products(p: Pair, q: Pair, r: Pair, s: Pair) -> Pair:
    """``p s − q r`` as `arrays.pair_cross` has it."""
    first, first_rest = two_product(p[0], s[0])
    second, second_rest = two_product(q[0], r[0])
    total, lost = two_sum(first, -second)
    below = (p[0] * s[1] + p[1] * s[0]) - (q[0] * r[1] + q[1] * r[0])
    return renormalise(total, ((first_rest - second_rest) + lost) + below)


@compiled()
def pair_cross(a: Pairs, b: Pairs) -> Pairs:
    """As `arrays.pair_cross`."""
    return (
        difference_of_products(a[1], a[2], b[1], b[2]),
        difference_of_products(a[2], a[0], b[2], b[0]),
        difference_of_products(a[0], a[1], b[0], b[1]),
    )


@compiled()
def exact(a: Triple) -> Pairs:
    """As `arrays.exact`."""
    return (a[0], 0.0), (a[1], 0.0), (a[2], 0.0)


@compiled()
def difference(a: Triple, b: Triple) -> Pairs:
    """``a − b``, as ``two_sum(a, -b)`` of vectors."""
    return two_sum(a[0], -b[0]), two_sum(a[1], -b[1]), two_sum(a[2], -b[2])
