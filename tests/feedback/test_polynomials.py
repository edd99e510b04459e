"""Roots and enclosures of polynomials, against exact rationals and 50-digit roots."""

from fractions import Fraction
from math import comb

import mpmath
import numpy as np
import pytest

from symrt.feedback import polynomials
from symrt.feedback.polynomials import highest, lowest, spans_inside
from symrt.gamut.clipping import clip_slabs

PIXELS = 150
UNIT = Fraction(1, 2**53)


def draws(degree, seed=0):
    random = np.random.default_rng(seed)
    q = random.uniform(0, 1, (degree + 1, PIXELS, 5)) * 10 ** random.uniform(-6, 2, (degree + 1, PIXELS, 1))
    q *= random.uniform(size=q.shape) < 0.8
    q[0] *= 0.01
    return q, random.uniform(0.2, 1, 5)


def exactly(coefficients, t):
    return sum(Fraction(float(c)) * Fraction(float(t)) ** k for k, c in enumerate(coefficients))


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_highest_is_inside_in_exact_arithmetic_and_meets_the_bound(degree):
    q, upper = draws(degree)
    found = highest(q, upper, 3.0)
    bounds = [Fraction(float(u)) for u in upper]
    for pixel in range(PIXELS):
        if (q[0, pixel] > upper).any():
            assert found[pixel] == -np.inf
            continue
        values = [exactly(q[:, pixel, s], found[pixel]) for s in range(5)]
        assert all(value <= bound for value, bound in zip(values, bounds, strict=True))
        # The binding reflectance moves by at most 64u.
        left = min((bound - value) / bound for value, bound in zip(values, bounds, strict=True))
        assert found[pixel] == 3.0 or left <= 64 * UNIT
    assert (found == 3.0).any()
    assert ((found > 0) & (found < 3.0)).sum() > 50


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_lowest_is_inside_in_exact_arithmetic_and_meets_the_bound(degree):
    q, lower = draws(degree, seed=1)
    lower = lower * 0.05
    found = lowest(q, lower, 3.0)
    bounds = [Fraction(float(b)) for b in lower]
    for pixel in range(PIXELS):
        if found[pixel] == np.inf:
            assert any(exactly(q[:, pixel, s], 3.0) < bounds[s] for s in range(5))
            continue
        values = [exactly(q[:, pixel, s], found[pixel]) for s in range(5)]
        assert all(value >= bound for value, bound in zip(values, bounds, strict=True))
        left = min((value - bound) / bound for value, bound in zip(values, bounds, strict=True))
        assert found[pixel] == 0 or left <= 64 * UNIT
    assert np.isinf(found).any()
    assert ((found > 0) & (found < 3.0)).sum() > 10


def test_roots_agree_with_fifty_digits():
    q, upper = draws(3, seed=4)
    q[0] = 0
    found = highest(q[:, :, :1], upper[:1], 1e6)
    for pixel in np.flatnonzero((found > 0) & (found < 1e6))[:60]:
        with mpmath.workdps(50):
            terms = [mpmath.mpf(float(c)) for c in q[:, pixel, 0]]
            terms[0] -= mpmath.mpf(float(upper[0]))
            while not terms[-1]:
                terms.pop()
            roots = mpmath.polyroots(terms[::-1], maxsteps=500, extraprec=200)
            truth = min(r.real for r in roots if abs(r.imag) < 1e-30 and r.real > 0)
        assert found[pixel] == pytest.approx(float(truth), rel=1e-12)


def test_a_degree_of_one_is_the_certified_clip():
    q, upper = draws(1, seed=2)
    q[0] = np.minimum(q[0], upper)
    clipped = clip_slabs(np.full(5, -np.inf), upper, q[0], q[1])
    t = highest(q, upper, 3.0)
    # Equal in reflectance, not in t where the pixel starts close to the bound.
    np.testing.assert_allclose(
        q[0] + t[:, None] * q[1], q[0] + np.minimum(clipped.high, 3.0)[:, None] * q[1], rtol=1e-14
    )


def test_a_pixel_on_the_bound_stays_at_zero():
    q = np.array([[[0.5, 0.25]], [[0.0, 0.1]], [[0.3, 0.0]]])
    assert highest(q, np.array([0.5, 0.5]), 3.0)[0] == 0.0
    assert lowest(q, np.array([0.5, 0.25]), 3.0)[0] == 0.0


def test_multiple_roots_at_zero_are_reached():
    q = np.array([[[0.0]], [[0.0]], [[0.0]], [[4.0]]])
    assert highest(q, np.array([0.0]), 3.0)[0] == pytest.approx(0, abs=1e-12)
    assert lowest(q, np.array([0.0]), 3.0)[0] == pytest.approx(0, abs=1e-12)


def bernstein_at(b, t):
    degree = len(b) - 1
    return sum(comb(degree, k) * (1 - t) ** (degree - k) * t**k * Fraction(float(c)) for k, c in enumerate(b))


@pytest.mark.parametrize("degree", [2, 3, 4])
@pytest.mark.parametrize("within", [(0.0, 1.0), (0.125, 0.875), (0.1, 0.9)])
def test_spans_are_the_parts_of_the_range_that_are_inside(degree, within):
    random = np.random.default_rng(degree)
    b = random.uniform(0, 1, (degree + 1, 60, 2))
    lower, upper = np.array([0.25, 0.2]), np.array([0.7, 0.75])
    found = spans_inside(b, lower, upper, within)
    assert len(found.pixel) > 30
    for t in np.linspace(*within, 57):
        exact = [[bernstein_at(b[:, p, s], Fraction(float(t))) for s in range(2)] for p in range(60)]
        truth = np.array([all(lower[s] <= v[s] <= upper[s] for s in range(2)) for v in exact])
        close = np.array(
            [min(abs(v[s] - bound) for s in range(2) for bound in (lower[s], upper[s])) < 1e-9 for v in exact]
        )
        held = np.isin(np.arange(60), found.pixel[(found.low <= t) & (t <= found.high)])
        assert np.array_equal(held[~close], truth[~close])


def test_ends_of_spans_are_inside_and_near_the_bounds():
    random = np.random.default_rng(9)
    b = random.uniform(0, 1, (3, 60, 2))
    lower, upper = np.array([0.25, 0.2]), np.array([0.7, 0.75])
    found = spans_inside(b, lower, upper, (0.0, 1.0))
    for pixel, *ends in zip(*found, strict=True):
        for t in ends:
            values = [bernstein_at(b[:, pixel, s], Fraction(float(t))) for s in range(2)]
            assert all(lower[s] <= values[s] <= upper[s] for s in range(2))
            near = min(abs(values[s] - bound) for s in range(2) for bound in (lower[s], upper[s]))
            assert t in (0.0, 1.0) or near < 1e-9


def test_a_pixel_can_leave_and_come_back():
    # (1 − t)² 0.5 + t² 0.5 is 0.25 at t = 0.5 and 0.3 at t = (1 ± 1/√5)/2.
    found = spans_inside(np.array([[[0.5]], [[0.0]], [[0.5]]]), np.array([0.3]), np.array([1.0]), (0.0, 1.0))
    assert found.pixel.tolist() == [0, 0]
    assert found.high[0] == pytest.approx((1 - 5**-0.5) / 2, abs=1e-9)
    assert found.low[1] == pytest.approx((1 + 5**-0.5) / 2, abs=1e-9)


@pytest.mark.parametrize("degree", [2, 4, 6])
@pytest.mark.parametrize("top", [1e4, 1e20, 1e45])
def test_roots_far_below_the_end_of_the_range_are_reached(degree, top):
    """Newton's method goes down from the end of the range only a share of the way at a time."""
    q, upper = draws(degree, seed=3)
    q[1:] += 1e-3
    near, far = highest(q, upper, 50.0), highest(q, upper, top)
    assert (near > 0).sum() > 100
    np.testing.assert_allclose(far, near, rtol=1e-12)
    np.testing.assert_allclose(lowest(q, upper, top), lowest(q, upper, 50.0), rtol=1e-12)


@pytest.mark.parametrize("value", [1.0, 0.25, np.nextafter(1.0, 0.0)])
def test_a_slab_that_stays_on_its_bound_asks_for_nothing(value):
    """The other slab alone has roots: x² + (1 − x)² is 0.625 at 1/4 and at 3/4."""
    b = np.array([[[value, 1.0]], [[value, 0.0]], [[value, 1.0]]])
    found = spans_inside(b, np.array([0.25, 0.0]), np.array([1.0, 0.625]), (0.0, 1.0), halvings=14)
    assert (len(found.low), found.pixel.tolist()) == (1, [0])
    np.testing.assert_allclose([found.low[0], found.high[0]], [0.25, 0.75], atol=2.0**-13)


@pytest.mark.parametrize("room", [2.0**-50, 0.0, -(2.0**-50)])
def test_what_cannot_be_told_from_a_bound_is_given_up_at_once(room, monkeypatch):
    halved = []
    monkeypatch.setattr(polynomials, "_halved", lambda b: halved.append(b.shape[1]) or (b, b))
    b = np.linspace(1, 1 + 2.0**-51, 3)[:, None, None]
    found = spans_inside(b, np.zeros(1), np.ones(1) + room, (0.0, 1.0), halvings=8)
    assert (len(found.low), sum(halved)) == (0, 0)


@pytest.mark.parametrize("degree", [1, 2, 3, 6])
def test_an_end_that_was_found_is_found_again(degree):
    q, upper = draws(degree, seed=5)
    found = highest(q, upper, 3.0)
    again = [highest(q[:, [k]], upper, t)[0] for k, t in enumerate(found) if t > 0]
    np.testing.assert_array_equal(again, found[found > 0])


@pytest.mark.parametrize("root", [0.5, 1 / 3])
@pytest.mark.parametrize("times", [2, 4, 6])
@pytest.mark.parametrize("side", [1, -1])
def test_a_bound_that_is_only_touched_costs_its_neighbourhood_and_no_more(root, times, side):
    """(t − root)^times stays within 0.25 of its bound; nothing that is farther from it than rounding is lost."""
    # In Bernstein form (t − root)^m has the coefficients (−root)^(m−k) (1 − root)^k.
    b = np.array([(-root) ** (times - k) * (1 - root) ** k for k in range(times + 1)])[:, None, None]
    lower, upper = (0.0, 2.0) if side > 0 else (-2.0, 0.0)
    found = spans_inside(side * b, np.array([lower]), np.array([upper]), (0.0, 1.0))
    assert len(found.low) == 2
    assert (found.low[0], found.high[1]) == (0.0, 1.0)
    assert found.high[0] < root < found.low[1]
    assert max(root - found.high[0], found.low[1] - root) < 2 * (1e-12) ** (1 / times)
