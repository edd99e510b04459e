"""What a range costs where few pixels see the parameter, what shares cost, and what a hull costs: ratios in one run."""

import numpy as np
import pytest
from benchmarks.pairs import ratio, seconds
from benchmarks.test_feedback_speed import plain
from scipy import sparse
from scipy.optimize import nnls

import symrt as rt
from symrt.feedback.polynomials import Spans
from symrt.feedback.shares import curve, pieces
from symrt.gamut.hull import hull_gamut
from symrt.spectra.products import gamma

pytestmark = pytest.mark.benchmark
DEVICE = rt.load_device("dye3-endura-premier")
ENVELOPE = rt.device_gamut(DEVICE, "envelope")
SIDE = 512


def mostly_unseen(exposure, seed=0):
    """512² pixels of four materials, a fifth of them brass, each under three lights, with the palette's brightness."""
    random = np.random.default_rng(seed)
    names = ("brass", "deep", "ice", "shelf", "upland")
    columns = tuple(sorted(rt.Interaction(light, (f"{m}.diffuse",)) for light in ("fill", "key", "sky") for m in names))
    lit = np.array([[k for k, column in enumerate(columns) if column.met == (f"{m}.diffuse",)] for m in names])
    indices = lit[random.integers(0, len(names), SIDE**2)]
    data = random.uniform(0, exposure / np.pi, indices.shape)
    rows = np.arange(0, 3 * SIDE**2 + 1, 3)
    G = sparse.csr_array((data.ravel(), indices.ravel(), rows), shape=(SIDE**2, len(columns)))  # noqa: N806
    system = rt.LinearSystem(G, columns, SIDE, SIDE, {"key": 1 / np.pi, "fill": 1 / np.pi, "sky": 1 / np.pi})
    spectra = {f"{m}.diffuse": random.uniform(0.1, 0.8, 36) for m in names}
    return system, rt.Palette(ENVELOPE.bands, spectra | {"key": 3.0, "fill": 1.0, "sky": 0.5})


@pytest.mark.parametrize(("exposure", "kind", "most"), [(0.5, "dim", 0.5), (1.0, "as bright as the white", 1.0)])
def test_a_range_that_few_pixels_see_costs_less_than_the_plain_route_and_half_where_they_are_dim(
    exposure, kind, most, report, benchmark
):
    system, palette = mostly_unseen(exposure)
    touched = rt.pixels_of(system, "brass").mean()
    assert 0.19 < touched < 0.21
    black = palette.replace({"brass.diffuse": 0.0})
    white = rt.Reference().white(system, palette)

    def lines():
        first, second = (system.G @ (gamma(system.interactions, spectra) / white) for spectra in (black, palette))
        return np.zeros(36), ENVELOPE.upper, first, second - first

    def whole():
        return rt.feasible(system, palette, ENVELOPE, rt.Scale("brass"), cap=False)

    dense = lines()
    low, high = plain(*dense)
    fixable = dense[3].any(axis=1) & (low <= high)
    assert whole().high == pytest.approx(high[fixable].min(), rel=1e-9)
    found, one, other = ratio(whole, lambda: plain(*lines()), pairs=9)
    alone, _, quotient = ratio(whole, lambda: plain(*dense), pairs=5)
    benchmark(whole)
    report(
        f"range of a scale that {touched:.0%} of 512² pixels see, {kind}: {one * 1e3:.0f} ms, {found:.2f} times "
        f"shading all pixels and the plain quotient ({other * 1e3:.0f} ms), {alone:.2f} times the quotient alone "
        f"({quotient * 1e3:.0f} ms)"
    )
    assert found <= most


def test_the_curve_of_shares_and_a_share_of_it_cost_a_few_sorts(report, benchmark):
    random = np.random.default_rng(1)
    low, high = random.uniform(0, 0.5, SIDE**2), random.uniform(0.5, 3, SIDE**2)
    spans = Spans(np.arange(SIDE**2), low, high)

    def asked():
        return curve(spans, 0, SIDE**2), pieces(spans, (0.0, 3.0), int(0.95 * SIDE**2), "upper")

    found, one, other = ratio(asked, lambda: np.sort(np.concatenate([low, high]), kind="stable"), pairs=9)
    benchmark(asked)
    report(
        f"curve of shares and the part of it with 5 % outside, 512² pixels: {one * 1e3:.0f} ms (50 asked), "
        f"{found:.2f} times one stable sort of all ends ({other * 1e3:.0f} ms)"
    )
    assert asked()[1][0].low > 0
    assert found <= 1


def test_hull_membership_costs_less_than_the_whole_chart_for_every_pixel(system, palette, report, benchmark):
    hull = hull_gamut(DEVICE)
    assert len(DEVICE.samples) == 729
    spectra = rt.shade(system, palette).values.reshape(-1, 36) / rt.Reference().white(system, palette)
    objects = spectra[system.object_pixels]
    reach = objects @ np.random.default_rng(0).normal(size=(36, 100))
    extreme = objects[np.unique(np.argpartition(reach, -100, axis=0)[-100:])][:1000]
    assert len(extreme) == 1000

    def one_by_one():
        matrix = np.vstack([DEVICE.samples.T, np.full(729, 100.0)])
        return [nnls(matrix, np.append(spectrum, 100.0))[1] for spectrum in extreme[::20]]

    taken, whole = min(seconds(lambda: hull.contains(extreme)) for _ in range(3)), seconds(one_by_one) * 20
    benchmark.pedantic(hull.contains, args=(extreme,), rounds=1)
    report(
        f"hull membership, {len(extreme)} extreme pixels, 729 prints: {taken:.2f} s (2 asked), "
        f"{taken / whole:.2f} times as many nnls on the whole chart ({whole:.1f} s, from one in twenty)"
    )
    assert taken <= whole
