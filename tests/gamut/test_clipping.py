"""Certified clipping, against exact rationals and a linear programme."""

from fractions import Fraction
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import linprog

from symrt import fast
from symrt.device.inks import load_device
from symrt.gamut import clipping
from symrt.gamut.clipping import blocking
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.gamuts import device_gamut as every_gamut
from symrt.gamut.interface import clip
from symrt.spectra.bands import wavelengths

UNIT = Fraction(1, 2**53)
FEW, MANY = 2_000, 100_000
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="numba is not installed")
DRAWS = [FEW, pytest.param(MANY, marks=pytest.mark.exhaustive)]


def clip_slabs(*lines, **named):
    """The clip by NumPy; the kernel's is the same, so that each law is held by both."""
    with fast.use(False):
        found = clipping.clip_slabs(*lines, **named)
    if find_spec("numba") is not None:
        with fast.use(True):
            compiled = clipping.clip_slabs(*lines, **named)
        for name in ("low", "high", "uncertain"):
            np.testing.assert_array_equal(getattr(compiled, name), getattr(found, name), strict=True)
            np.testing.assert_array_equal(np.signbit(getattr(compiled, name)), np.signbit(getattr(found, name)))
    return found


def exact_interval(lower, upper, origin, direction):
    """Liang and Barsky in rationals; None where the line never is inside, infinite ends as None in the pair."""
    low, high = [], []
    for a, b, *line in zip(lower, upper, origin, direction, strict=True):
        q, d = (Fraction(float(v)) for v in line)
        if d == 0:
            if not (a <= q <= b):
                return None
            continue
        ends = sorted((Fraction(float(v)) - q) / d for v in (a, b))
        low.append(ends[0])
        high.append(ends[1])
    ends = (max(low, default=None), min(high, default=None))
    return None if low and ends[0] > ends[1] else ends


def assert_inside(lower, upper, origin, direction, t):
    for a, b, q, d in zip(lower, upper, origin, direction, strict=True):
        value = Fraction(float(q)) + Fraction(float(t)) * Fraction(float(d))
        assert Fraction(float(a)) <= value <= Fraction(float(b))


def scaled_draws(count, bands, seed):
    """Lines and slabs of any scale from 1e-300 to 1e300, many of them with origins on or near a face."""
    random = np.random.default_rng(seed)
    lower = random.uniform(-1, 0.3, bands) * random.integers(0, 2, bands)
    upper = lower + random.uniform(0.1, 1, bands)
    where = random.choice([0.0, 1.0, 0.5, 1e-9, 1 - 1e-9], (count, bands)) + random.normal(0, 0.2, (count, bands))
    origin = lower + where * (upper - lower)
    direction = random.normal(size=(count, bands)) * 10 ** random.uniform(-8, 8, (count, 1))
    power = random.integers(-990, 990) * (seed % 2)
    # Products of the scales may pass 1e308 or fall below 1e-308: that is the point.
    speed = np.ldexp(1.0, (random.integers(-60, 60, (count, 1)) + random.choice([-900, 0, 900])) * (seed % 3 > 0))
    return [np.ldexp(v, power) for v in (lower, upper, origin)] + [direction * speed]


@pytest.mark.parametrize("count", DRAWS)
def test_no_end_lies_outside_in_exact_arithmetic(count):
    ends = 0
    for seed in range(40):
        lower, upper, origin, direction = scaled_draws(count // 40, 6, seed)
        with np.errstate(under="ignore"):
            found = clip_slabs(lower, upper, origin, direction)
        for pixel in range(len(origin)):
            truth = exact_interval(lower, upper, origin[pixel], direction[pixel])
            if found.empty[pixel]:
                assert truth is None or found.uncertain[pixel]
                continue
            assert truth is not None
            for t in (found.low[pixel], found.high[pixel]):
                if np.isfinite(t):
                    assert_inside(lower, upper, origin[pixel], direction[pixel], t)
                    ends += 1
    assert ends > count // 4


def test_the_binding_reflectance_moves_by_at_most_64_rounding_errors():
    random = np.random.default_rng(11)
    lower, upper = np.zeros(36), random.uniform(0.5, 1, 36)
    origin, direction = random.uniform(0, 0.5, (FEW, 36)), random.normal(size=(FEW, 36))
    found = clip_slabs(lower, upper, origin, direction)
    first, last = blocking(lower, upper, origin, direction)
    for pixel in range(FEW):
        for slab, t in ((first[pixel], found.low[pixel]), (last[pixel], found.high[pixel])):
            q, d = Fraction(float(origin[pixel, slab])), Fraction(float(direction[pixel, slab]))
            reached = q + Fraction(float(t)) * d
            left = min(abs(reached - Fraction(float(bound))) for bound in (lower[slab], upper[slab]))
            assert left <= 64 * UNIT


def test_the_plain_quotient_would_not_pass():
    """Half of the plain quotients are outside (51-76 % were seen): the test above can fail."""
    random = np.random.default_rng(12)
    origin, direction = random.uniform(0, 0.5, (300, 12)), random.normal(size=(300, 12))
    high = np.maximum((0 - origin) / direction, (1 - origin) / direction).min(axis=1)
    outside = 0
    for pixel in range(300):
        truth = exact_interval(np.zeros(12), np.ones(12), origin[pixel], direction[pixel])
        outside += Fraction(float(high[pixel])) > truth[1]
    assert outside > 75


def test_a_direction_of_zero_allows_all_or_nothing():
    # L2: inside, on either face, outside on either side, and one step outside.
    origin = np.array([[0.5], [0.0], [1.0], [-0.1], [1.1], [np.nextafter(1, 2)], [-5e-324]])
    for zero in (0.0, -0.0):
        found = clip_slabs(np.zeros(1), np.ones(1), origin, np.full((7, 1), zero))
        assert found.low.tolist() == [-np.inf] * 3 + [np.inf] * 4
        assert found.high.tolist() == [np.inf] * 3 + [-np.inf] * 4
        assert not found.uncertain.any()


def test_only_the_slabs_that_are_not_parallel_count():
    # L2: parallel to 35 of 36 slabs.
    random = np.random.default_rng(13)
    origin = random.choice([0.0, 1.0, 0.25], (200, 36))
    direction = np.zeros((200, 36))
    direction[np.arange(200), random.integers(0, 36, 200)] = random.choice([-2.0, 0.5], 200)
    found = clip_slabs(np.zeros(36), np.ones(36), origin, direction)
    for pixel in range(200):
        low, high = exact_interval(np.zeros(36), np.ones(36), origin[pixel], direction[pixel])
        assert float(low) == pytest.approx(found.low[pixel], rel=1e-15)
        assert float(high) == pytest.approx(found.high[pixel], rel=1e-15)


def test_perfect_white_is_inside():
    found = clip_slabs(np.zeros(3), np.ones(3), np.ones((1, 3)), np.full((1, 3), -0.5))
    assert found.low[0] == 0.0


@pytest.mark.parametrize("speed", [5e-324, 1e-310, 1e-300, 1e300, 1.7e308])
def test_subnormal_and_huge_directions_end_inside(speed):
    # L3
    random = np.random.default_rng(14)
    origin = random.uniform(0, 1, (50, 4))
    direction = random.choice([-1.0, 1.0, 0.0], (50, 4)) * speed
    found = clip_slabs(np.zeros(4), np.ones(4), origin, direction)
    for pixel in range(50):
        truth = exact_interval(np.zeros(4), np.ones(4), origin[pixel], direction[pixel])
        assert found.low[pixel] <= 0 <= found.high[pixel]
        for t, end in zip((found.low[pixel], found.high[pixel]), truth, strict=True):
            if end is not None:
                assert np.isfinite(t)
                assert_inside(np.zeros(4), np.ones(4), origin[pixel], direction[pixel], t)
                if abs(end) < Fraction(1.7e308):
                    assert abs(Fraction(float(t)) - end) <= abs(end) * 8 * UNIT + Fraction(2) ** -1070


@pytest.mark.parametrize("top", [1.0, 1e200, np.inf])
@pytest.mark.parametrize("origin", [-5e-324, -1.5e-323, -1e-310])
def test_an_origin_that_is_subnormal_keeps_its_sign(origin, top):
    lower, upper = np.zeros(1), np.full(1, top)
    low = clip_slabs(lower, upper, np.array([[origin]]), np.array([[1.0]])).low[0]
    # The end is -origin; where an error of 4u is no float it moves inwards by four of the smallest steps.
    assert -origin <= low <= -origin + 4 * 5e-324


@pytest.mark.parametrize("kernels", [False, pytest.param(True, marks=needs_numba)])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_pixel_that_is_not_finite_is_named(bad, kernels):
    # L3
    for where in ("origin", "direction"):
        lines = {"origin": np.full((5000, 4), 0.5), "direction": np.ones((5000, 4))}
        lines[where][4321, 2] = bad
        with pytest.raises(ValueError, match=f"pixel 4321, slab 2: the {where} is"), fast.use(kernels):
            clipping.clip_slabs(np.zeros(4), np.ones(4), **lines)


def test_bounds_upside_down_are_named():
    with pytest.raises(ValueError, match="slab 1"):
        clip_slabs(np.array([0.0, 1.0]), np.array([1.0, 0.5]), np.zeros((1, 2)), np.ones((1, 2)))


def test_a_range_of_one_point_is_found_exactly():
    # L4: the line grazes an edge of the square at t = 0.5, at t = 0.1 (no float), and passes it by one step.
    origin = np.array([[0.5, 1.5], [0.0, 0.0], [0.5, np.nextafter(1.5, 2)]])
    direction = np.array([[1.0, -1.0], [0.0, 0.0], [1.0, -1.0]])
    found = clip_slabs(np.zeros(2), np.ones(2), origin, direction)
    assert (found.low[0], found.high[0]) == (0.5, 0.5)
    assert found.empty.tolist() == [False, False, True]
    third = clip_slabs(np.array([1.0, 0.0]), np.array([2.0, 1.0]), np.array([[0.0, 0.0]]), np.array([[3.0, 3.0]]))
    assert third.empty[0]
    assert third.uncertain[0], "inside at t = 1/3 only, which is no float"


def test_bands_may_come_in_any_order():
    # L5
    lower, upper, origin, direction = scaled_draws(FEW, 12, 5)
    order = np.random.default_rng(0).permutation(12)
    one = clip_slabs(lower, upper, origin, direction)
    other = clip_slabs(lower[order], upper[order], origin[:, order], direction[:, order])
    assert np.array_equal(one.low, other.low)
    assert np.array_equal(one.high, other.high)


@pytest.mark.parametrize("power", [-500, -150, -3, 1, 40, 180, 600])
def test_scaling_by_a_power_of_two_changes_no_bit(power):
    # L5: of the space, and of the parameter.
    random = np.random.default_rng(15)
    lower, upper = random.uniform(0, 0.2, 36), random.uniform(0.5, 1, 36)
    origin, direction = random.uniform(0, 1, (400, 36)), random.normal(size=(400, 36))
    one = clip_slabs(lower, upper, origin, direction)
    scaled = clip_slabs(*(np.ldexp(v, power) for v in (lower, upper, origin, direction)))
    faster = clip_slabs(lower, upper, origin, np.ldexp(direction, power))
    assert np.array_equal(one.low, scaled.low)
    assert np.array_equal(one.high, scaled.high)
    assert np.array_equal(one.low, np.ldexp(faster.low, power))
    assert np.array_equal(one.high, np.ldexp(faster.high, power))


def test_a_linear_programme_agrees():
    random = np.random.default_rng(16)
    lower, upper = random.uniform(0, 0.1, 36), random.uniform(0.6, 1, 36)
    origin, direction = random.uniform(0, 0.9, (100, 36)), random.normal(size=(100, 36))
    found = clip_slabs(lower, upper, origin, direction)
    for pixel in range(100):
        rows = np.concatenate([direction[pixel], -direction[pixel]])[:, None]
        limits = np.concatenate([upper - origin[pixel], origin[pixel] - lower])
        for sign, end in ((1, found.low[pixel]), (-1, found.high[pixel])):
            best = linprog([sign], A_ub=rows, b_ub=limits, bounds=[(None, None)], method="highs")
            assert (best.status == 2) == found.empty[pixel]
            if best.status == 0:
                assert end == pytest.approx(best.x[0], rel=1e-7, abs=1e-7)


def test_pixels_do_not_depend_on_their_tile():
    lower, upper, origin, direction = scaled_draws(FEW, 36, 3)
    whole = clip_slabs(lower, upper, origin, direction)
    one_by_one = [clip_slabs(lower, upper, origin[[n]], direction[[n]]) for n in range(200)]
    assert whole.low[:200].tolist() == [i.low[0] for i in one_by_one]
    assert whole.high[:200].tolist() == [i.high[0] for i in one_by_one]


@pytest.mark.parametrize("model", ["unit", "envelope"])
def test_clipping_in_basis_coordinates_is_clipping_in_wavelengths(model):
    """The paper, §2.1 and §5: r = Bᵀ c, so that slabs of spectra are slabs lo <= Bᵀ c <= hi of coordinates."""
    random = np.random.default_rng(17)
    gamut = device_gamut(load_device("dye3-endura-premier"), model, "strict")
    origin, direction = random.uniform(0, 1, (500, 36)) ** 2, random.normal(size=(500, 36))
    spectra = clip(gamut, origin, direction)
    basis = gamut.basis
    c_origin, c_direction = basis.coordinates(origin), basis.coordinates(direction)
    coordinates = clip_slabs(gamut.lower, gamut.upper, c_origin @ basis.vectors, c_direction @ basis.vectors)
    assert np.array_equal(spectra.empty, coordinates.empty)
    some = ~spectra.empty
    assert some.any()
    np.testing.assert_allclose(coordinates.low[some], spectra.low[some], rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(coordinates.high[some], spectra.high[some], rtol=1e-12, atol=1e-13)


def test_ends_are_inside_the_gamut_that_keeps_the_luminance_of_black():
    random = np.random.default_rng(18)
    gamut = device_gamut(load_device("dye3-endura-premier"), "envelope", "luminance")
    origin, direction = random.uniform(0.001, 0.002, (500, 36)), random.normal(0.2, 0.01, size=(500, 36))
    found = clip(gamut, origin, direction)
    without = clip_slabs(gamut.lower, gamut.upper, origin, direction)
    some = ~found.empty
    for end in (found.low[some], found.high[some]):
        assert gamut.violation(origin[some] + end[:, None] * direction[some]).max() <= 1e-15
    assert (found.low > without.low).any()


@pytest.mark.parametrize("model", ["monitor", "colorimetric"])
def test_lines_clipped_by_weighed_bands_end_inside_in_exact_arithmetic(model):
    """Weights of both signs cancel: the ends keep off the planes by as much as the rounded products can be off."""
    bands = wavelengths(400, 700, 50)
    gamut = every_gamut(load_device("crt-brainard" if model == "monitor" else "synthetic-cmyk", bands), model)
    draw = np.random.default_rng(1)
    origin, direction = draw.uniform(0, 1, (40, 7)), draw.normal(size=(40, 7)) * 10.0 ** draw.uniform(-6, 6, (40, 1))
    origin[:10] *= 1e-3
    slabs, found = gamut.slabs, gamut.clip(origin, direction)
    weights = [[Fraction(float(v)) for v in column] for column in slabs.matrix.T]
    ends = 0
    for o, d, low, high in zip(origin, direction, found.low, found.high, strict=True):
        if low > high:
            continue
        for t in (low, high):
            point = [Fraction(float(a)) + Fraction(float(t)) * Fraction(float(b)) for a, b in zip(o, d, strict=True)]
            for column, a, b in zip(weights, slabs.lower, slabs.upper, strict=True):
                value = sum(w * r for w, r in zip(column, point, strict=True))
                assert a == -np.inf or value >= Fraction(float(a))
                assert b == np.inf or value <= Fraction(float(b))
            ends += 1
    assert ends >= 40


def test_pixels_known_to_rest_are_inside_or_not_as_if_it_were_not_known():
    draw = np.random.default_rng(2)
    origin, direction = draw.uniform(-0.1, 1.1, (3000, 3)), draw.normal(size=(3000, 3))
    moving = draw.uniform(size=3000) < 0.5
    direction[~moving] = 0
    lines = (np.zeros(3), np.ones(3), origin, direction)
    known, unknown = clip_slabs(*lines, moving), clip_slabs(*lines)
    np.testing.assert_array_equal(known.low, unknown.low)
    np.testing.assert_array_equal(known.high, unknown.high)
    origin[np.flatnonzero(~moving)[7], 1] = np.nan
    with pytest.raises(ValueError, match=f"pixel {np.flatnonzero(~moving)[7]}, slab 1"):
        clip_slabs(*lines, moving)


def test_what_numpy_and_the_kernel_read_may_lie_anywhere_in_memory():
    lower, upper, origin, direction = scaled_draws(300, 36, 1)
    one = clip_slabs(lower, upper, origin, direction)
    aside = np.asfortranarray(origin), np.repeat(direction, 2, axis=1)[:, ::2]
    still = [np.array(values) for values in (lower, upper)]
    for values in still:
        values.flags.writeable = False
    other = clip_slabs(*still, *aside)
    np.testing.assert_array_equal(one.low, other.low)
    np.testing.assert_array_equal(one.high, other.high)
