"""What the feedback costs, as a ratio to the plain clip of the same arrays; seconds are reported, never asserted."""

import numpy as np
import pytest
from benchmarks.pairs import ratio

import symrt as rt
from symrt.gamut.clipping import clip_slabs

pytestmark = pytest.mark.benchmark


def plain(lower, upper, origin, direction):
    """Both quotients of every slab, whole arrays at a time, as a textbook would."""
    with np.errstate(divide="ignore", invalid="ignore"):
        at_lower, at_upper = (lower - origin) / direction, (upper - origin) / direction
    return np.minimum(at_lower, at_upper).max(axis=1), np.maximum(at_lower, at_upper).min(axis=1)


def test_a_certified_clip_costs_no_more_than_the_plain_quotient(report, benchmark):
    random = np.random.default_rng(0)
    origin, direction = random.uniform(0, 0.5, (512**2, 36)), random.normal(size=(512**2, 36))
    lines = (np.zeros(36), np.ones(36), origin, direction)
    found, one, other = ratio(lambda: clip_slabs(*lines), lambda: plain(*lines), pairs=9)
    benchmark(clip_slabs, *lines)
    report(
        f"certified clip, 512² × 36: {one * 1e3:.0f} ms, {found:.2f} times the plain quotient ({other * 1e3:.0f} ms)"
    )
    assert found <= 1.2


def test_a_certified_clip_skips_the_pixels_that_do_not_see_the_parameter(report, benchmark):
    random = np.random.default_rng(0)
    origin, direction = random.uniform(0, 0.5, (512**2, 36)), random.normal(size=(512**2, 36))
    # A fifth of the rows of G have entries in the columns that the parameter moves.
    moving = random.uniform(size=512**2) < 0.2
    direction[~moving] = 0
    lines = (np.zeros(36), np.ones(36), origin, direction)
    (low, high), found = plain(*lines), clip_slabs(*lines, moving)
    np.testing.assert_allclose(found.low[moving], low[moving], rtol=1e-14)
    np.testing.assert_allclose(found.high[moving], high[moving], rtol=1e-14)
    assert (found.low[~moving] == -np.inf).all()
    found, one, other = ratio(lambda: clip_slabs(*lines, moving), lambda: plain(*lines), pairs=9)
    benchmark(clip_slabs, *lines, moving)
    report(
        f"certified clip of 512² × 36, four pixels in five unmoved: {one * 1e3:.0f} ms, {found:.2f} times the plain "
        f"quotient ({other * 1e3:.0f} ms)"
    )
    assert found <= 0.5


def test_fitting_all_scales_costs_no_more_than_twice_the_range_of_each(system, palette, report, benchmark):
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    scales = [rt.Scale(name) for name in sorted({s.partition(".")[0] for s in system.reflectances})]
    found, both, each = ratio(
        lambda: rt.fit(system, palette, gamut, scales, objective="lightest", cap=False),
        lambda: [rt.feasible(system, palette, gamut, scale, cap=False) for scale in scales],
        pairs=3,
    )
    benchmark.pedantic(lambda: rt.fit(system, palette, gamut, scales, objective="lightest", cap=False), rounds=1)
    report(f"feasible range, globe 512²: {each / len(scales):.2f} s; fit of {len(scales)} scales: {both:.2f} s")
    assert found <= 2
