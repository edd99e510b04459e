"""Error-free arithmetic against exact rationals, and safe lengths (G13) against 50 digits."""

import mpmath
import numpy as np
import pytest
from flint import fmpq
from geometry.oracles import inner, outer, rational, ulps
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from symrt.arrays import (
    exact,
    length,
    negative,
    normalise,
    pair_cross,
    pair_dot,
    pair_product,
    pair_quotient,
    pair_sum,
    two_product,
    two_sum,
)

numbers = st.floats(-1e100, 1e100).map(lambda x: 0.0 if abs(x) < 1e-100 else x)
vectors = arrays(float, (3, 1), elements=numbers)


def value(pair):
    """The exact value of a pair."""
    return [
        a + b for a, b in zip(rational(pair[0]), rational(np.broadcast_to(pair[1], np.shape(pair[0]))), strict=True)
    ]


def pairs(count, seed, spread=6):
    """Pairs that use both of their floats."""
    generator = np.random.default_rng(seed)
    high = generator.normal(size=(3, count)) * 10 ** generator.uniform(-spread, spread, (3, count))
    return two_sum(high, high * generator.uniform(-1, 1, (3, count)) * 2.0**-54)


@given(numbers, numbers)
def test_sums_and_products_lose_nothing(a, b):
    assert value(two_sum(np.array([a]), np.array([b])))[0] == rational(a)[0] + rational(b)[0]
    assert value(two_product(np.array([a]), np.array([b])))[0] == rational(a)[0] * rational(b)[0]


def test_pairs_keep_a_hundred_bits():
    a, b = pairs(500, 1), pairs(500, 2)
    x, y = value(a), value(b)
    total, product = value(pair_sum(a, b)), value(pair_product(a, b))
    for k in range(1500):
        assert abs(total[k] - (x[k] + y[k])) <= fmpq(1, 2**104) * abs(x[k] + y[k])
        assert abs(product[k] - x[k] * y[k]) <= fmpq(1, 2**102) * abs(x[k] * y[k])


def test_sums_of_pairs_that_cancel_keep_a_hundred_bits_of_what_is_left():
    a = pairs(500, 3)
    b = negative((a[0] * (1 + 2.0**-50), a[1]))
    for x, y, total in zip(value(a), value(b), value(pair_sum(a, b)), strict=True):
        assert abs(total - (x + y)) <= fmpq(1, 2**102) * abs(x + y)


def test_dots_and_crosses_keep_a_hundred_bits_of_their_terms():
    a, b = pairs(500, 4), pairs(500, 5)
    x, y = np.array(value(a)).reshape(3, -1), np.array(value(b)).reshape(3, -1)
    dots = value(pair_dot(a, b))
    crosses = np.array(value(pair_cross(a, b))).reshape(3, -1)
    for k in range(500):
        terms = sum(abs(p * q) for p, q in zip(x[:, k], y[:, k], strict=True))
        assert abs(dots[k] - inner(x[:, k], y[:, k])) <= fmpq(1, 2**101) * terms
        for found, true in zip(crosses[:, k], outer(x[:, k], y[:, k]), strict=True):
            assert abs(found - true) <= fmpq(1, 2**100) * max(abs(p) for p in x[:, k]) * max(abs(q) for q in y[:, k])


def test_a_dot_product_that_cancels_is_right_where_the_plain_one_is_not():
    generator = np.random.default_rng(6)
    a = generator.normal(size=(3, 400))
    b = np.cross(a, generator.normal(size=(3, 400)), axis=0) + 1e-13 * a
    found = pair_dot(exact(a), exact(b))[0]
    for k in range(400):
        true = inner(rational(a[:, k]), rational(b[:, k]))
        # G3 and G10: two units in the last place, of a sum that has lost 13 digits.
        assert ulps(found[k], mpmath.mpf(int(true.p)) / int(true.q)) <= 2


def test_quotients_are_rounded_once():
    a, b = pairs(700, 7), pairs(700, 8)
    found = pair_quotient(a, b).ravel()
    for k, (x, y) in enumerate(zip(value(a), value(b), strict=True)):
        assert ulps(found[k], mpmath.mpf(int((x / y).p)) / int((x / y).q)) <= 0.51


@pytest.mark.parametrize("exponent", [-320, -310, -300, -154, -10, 0, 10, 154, 300, 307])
def test_lengths_and_directions_do_not_overflow_or_underflow(exponent):
    generator = np.random.default_rng(9)
    v = generator.uniform(-1, 1, (3, 50)) * 10.0 ** generator.uniform(-3, 0, (3, 50))
    v = np.array([[float(mpmath.mpf(x) * mpmath.mpf(10) ** exponent) for x in row] for row in v])
    v[0, ~v.any(axis=0)] = 5e-324
    unit = normalise(v)
    for k in range(50):
        size = mpmath.sqrt(sum(mpmath.mpf(x) ** 2 for x in v[:, k]))
        if size > mpmath.mpf(10) ** -300:
            assert ulps(length(v[:, k : k + 1])[0], size) <= 2
        for found, x in zip(unit[:, k], v[:, k], strict=True):
            assert ulps(found, mpmath.mpf(x) / size) <= 2


@pytest.mark.parametrize("wrong", [0.0, np.inf, np.nan])
def test_what_has_no_direction_is_refused(wrong):
    with pytest.raises(ValueError, match=r"vector 0 is .* must be finite and not zero"):
        normalise(np.full((3, 2), wrong))


@given(vectors, vectors)
def test_a_cross_product_is_perpendicular_in_exact_arithmetic_up_to_its_rounding(a, b):
    crossed = value(pair_cross(exact(a), exact(b)))
    for v in (rational(a), rational(b)):
        bound = sum(abs(x) for x in rational(a)) * sum(abs(x) for x in rational(b)) * sum(abs(x) for x in v)
        assert abs(inner(crossed, v)) <= fmpq(1, 2**98) * bound + fmpq(1, 2**1000) * sum(abs(x) for x in v)
