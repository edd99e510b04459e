"""Hulls of prints, spectral and colorimetric, against linear programmes, quadratic optimisers and closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog, minimize, nnls
from scipy.spatial import ConvexHull

from symrt.device import Device, load_device
from symrt.gamut import device_gamut, load_gamut, save_gamut
from symrt.gamut.colorimetric import colorimetric_gamut
from symrt.gamut.hull import HullGamut, hull_gamut
from symrt.gamut.mixtures import _by_corrals, nearest_mixtures
from symrt.spectra.bands import RGB, wavelengths

BANDS = wavelengths(400, 700, 50)


def chart(samples):
    blank = np.zeros(samples.shape[1], dtype=bool)
    bands = wavelengths(400, 400 + 10 * (samples.shape[1] - 1), 10)
    return Device("chart", bands, samples, np.empty((len(samples), 0)), (), blank, "made up", "made up", modelled=False)


@pytest.fixture(scope="module")
def device():
    return load_device("dye3-endura-premier", BANDS)


@pytest.fixture(scope="module")
def hull(device):
    return hull_gamut(device)


def spectra_around(device, count, seed=0):
    """Mixtures of prints, some moved out by little or much."""
    draw = np.random.default_rng(seed)
    weights = draw.dirichlet(np.full(5, 0.5), count)
    prints = device.samples[draw.integers(0, len(device.samples), (count, 5))]
    moved = draw.normal(0, 1, (count, len(device.bands))) * draw.choice([0, 0.01, 0.1], (count, 1))
    return np.einsum("ns,nsb->nb", weights, prints) + moved


def in_hull_by_linear_programme(samples, spectrum):
    """Whether weights exist; None where the programme's own tolerance of 1e-7 decides."""
    equal = np.vstack([samples.T, np.ones(len(samples))])
    slack = np.vstack([np.eye(len(spectrum)), np.zeros((1, len(spectrum)))])
    cost = np.concatenate([np.zeros(len(samples)), np.ones(2 * len(spectrum))])
    found = linprog(cost, A_eq=np.hstack([equal, slack, -slack]), b_eq=np.append(spectrum, 1.0))
    return None if 1e-9 < found.fun < 1e-6 else bool(found.fun <= 1e-9)


def test_membership_without_tolerance_agrees_with_a_linear_programme(device):
    bare = HullGamut(device, 0.0, 0.0, 0.0)
    spectra = spectra_around(device, 120)
    wanted = [in_hull_by_linear_programme(device.samples, s) for s in spectra]
    decided = np.array([w is not None for w in wanted])
    assert decided.sum() > 110
    assert 20 < sum(w is True for w in wanted) < 100
    np.testing.assert_array_equal(bare.contains(spectra)[decided], [w for w in wanted if w is not None])


def test_nearest_mixtures_are_certified_by_the_plane_that_keeps_the_prints_away(device):
    spectra = spectra_around(device, 300, seed=1)
    mixtures, apart = nearest_mixtures(device.samples, spectra)
    np.testing.assert_allclose(np.linalg.norm(spectra - mixtures, axis=1), apart, atol=1e-10)
    # The plane through the mixture, square to the way to it, has all prints behind it: proof by hand.
    away = spectra - mixtures
    ahead = (away @ device.samples.T).max(axis=1) - np.sum(away * mixtures, axis=1)
    assert ahead.max() < 1e-10
    weights_exist = [in_hull_by_linear_programme(device.samples, m) for m in mixtures[:20]]
    assert False not in weights_exist


def test_nearest_mixtures_of_a_triangle_are_those_of_plane_geometry():
    corners = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
    points = np.array([[3.0, 4.0], [-1.0, -1.0], [1.0, -2.0], [0.5, 0.5], [5.0, 0.0]])
    # The foot of (3, 4) on the hypotenuse divides it as the squares of the sides, 9 to 16 (Euclid, Elements VI.8).
    foot = [3 * 9 / 25, 4 * 16 / 25]
    wanted = np.array([foot, [0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [3.0, 0.0]])
    np.testing.assert_allclose(nearest_mixtures(corners, points)[0], wanted, atol=1e-10)


def test_prints_that_nearly_agree_do_not_lead_in_circles():
    device = load_device("synthetic-cmykog")
    amounts = np.random.default_rng(0).uniform(0, 1, (20, 6))
    prints = device.printer.printed(amounts)
    mixtures, apart = nearest_mixtures(device.samples, prints)
    # Inside, where the squares of differences are lost in rounding, the two still agree to a millionth.
    np.testing.assert_allclose(np.linalg.norm(prints - mixtures, axis=1), apart, atol=1e-6)


@pytest.mark.parametrize(("points", "bands"), [(3, 2), (20, 5), (60, 7)])
def test_wolfes_method_and_non_negative_least_squares_come_equally_near(points, bands):
    draw = np.random.default_rng(points)
    for _ in range(20):
        cloud = draw.normal(draw.uniform(0, 0.5), 0.3, (points, bands))
        weights = _by_corrals(cloud)
        assert weights.min() >= 0
        assert weights.sum() == pytest.approx(1, abs=1e-12)
        other = nnls(np.vstack([cloud.T, np.ones(points)]), np.append(np.zeros(bands), 1))[0]
        lengths = [np.linalg.norm(w @ cloud) for w in (weights, other / other.sum())]
        assert lengths[0] == pytest.approx(lengths[1], abs=1e-9)


@pytest.mark.parametrize("copies", [1, 3])
def test_degenerate_charts_are_hulls_too(copies):
    line = chart(np.repeat([[0.2, 0.2, 0.2], [0.8, 0.8, 0.8]], copies, axis=0))
    gamut = HullGamut(line, 0.05, 0.0, 0.0)
    spectra = np.array([[0.5, 0.5, 0.5], [0.9, 0.9, 0.9], [0.84, 0.84, 0.84], [0.5, 0.5, 0.6]])
    np.testing.assert_allclose(gamut.distance(spectra), [0, 0.1, 0.04, 0.1 * np.sqrt(2 / 9)], atol=1e-10)
    np.testing.assert_array_equal(gamut.contains(spectra), [True, False, True, True])
    point = HullGamut(chart(np.full((copies, 3), 0.5)), 0.0, 0.0, 0.0)
    assert point.distance(np.array([[0.5, 0.5, 0.5], [0.6, 0.6, 0.6]])) == pytest.approx([0, 0.1], abs=1e-12)


def test_deciding_early_decides_the_same(hull, device):
    spectra = spectra_around(device, 400, seed=2)
    np.testing.assert_array_equal(hull.contains(spectra), hull.violation(spectra) == 0)
    assert 0.2 < hull.contains(spectra).mean() < 0.95


def test_hull_clip_agrees_with_a_linear_programme(device):
    bare = HullGamut(device, 0.0, 0.0, 0.0)
    draw = np.random.default_rng(5)
    inside = draw.dirichlet(np.full(len(device.samples), 0.02), 15) @ device.samples
    direction = draw.normal(0, 1, inside.shape)
    found = bare.clip(inside, direction)
    for o, d, a, b in zip(inside, direction, found.low, found.high, strict=True):
        equal = np.vstack([np.column_stack([device.samples.T, -d]), np.append(np.ones(len(device.samples)), 0)])
        limits = [(0, None)] * len(device.samples) + [(None, None)]
        ends = [
            linprog(np.append(np.zeros(len(device.samples)), sign), A_eq=equal, b_eq=np.append(o, 1), bounds=limits).x[
                -1
            ]
            for sign in (1, -1)
        ]
        assert (a, b) == pytest.approx(tuple(ends), abs=1e-6)


def test_a_line_so_slow_that_no_number_brings_it_inside_is_said_to_be_uncertain(hull, device):
    start, way = device.samples[:1] + 0.5, np.full((1, 7), -1.0)
    found = hull.clip(np.vstack([start, device.samples[:1]]), np.vstack([way, way]) * 5e-324)
    assert found.empty.tolist() == found.uncertain.tolist() == [True, False]
    # From inside every number does: the gamut ends beyond the largest.
    assert found.high[1] == np.finfo(float).max


def test_support_is_reached_by_no_point_and_by_one(hull):
    directions = np.random.default_rng(6).normal(0, 1, (20, 7))
    support = hull.support(directions)
    spectra = np.random.default_rng(7).uniform(0, 1, (500, 7))
    inside = hull.nearest(spectra)
    assert np.all(inside @ directions.T <= support + 1e-9)
    far = hull.nearest(1e4 * directions)
    np.testing.assert_allclose(np.sum(far * directions, axis=1), support, rtol=1e-3)


def test_the_tolerance_is_never_less_than_the_gap_and_is_told(device):
    tight = hull_gamut(device, tolerance=0.0)
    assert tight.tolerance == tight.gap > 0
    assert f"{tight.gap:.4f}" in repr(tight)
    assert hull_gamut(device, tolerance=0.02).tolerance == 0.02
    # Prints that were not sampled are inside, which is what the gap is for.
    amounts = np.random.default_rng(8).uniform(0, 2.2, (200, 3))
    assert tight.contains(device.printer.printed(amounts)).mean() > 0.95
    bare = HullGamut(device, 0.0, 0.0, 0.0)
    assert not bare.contains(device.printer.printed(amounts)).any()
    measured = hull_gamut(replace(device, printer=None, modelled=False), tolerance=0.0)
    assert 0 <= measured.gap < 0.05
    for tolerance in (-1, 2, np.inf, np.nan):
        with pytest.raises(ValueError, match=f"tolerance = {tolerance}"):
            hull_gamut(device, tolerance)


def test_hull_is_within_the_envelope_and_within_the_colours(device):
    spectra = spectra_around(device, 300, seed=9)
    inside = HullGamut(device, 0.0, 0.0, 0.0).contains(spectra)
    envelope, colours = device_gamut(device, "envelope", "strict"), colorimetric_gamut(device)
    assert inside.any()
    assert envelope.violation(spectra[inside]).max() < 1e-9
    assert colours.violation(spectra[inside]).max() < 1e-9
    assert colours.contains(spectra).sum() > inside.sum()


def test_colours_inside_agree_with_a_linear_programme(device):
    gamut = colorimetric_gamut(device, "illuminant/A")
    spectra = spectra_around(device, 100, seed=10)
    xyz, prints = spectra @ gamut.observer, device.samples @ gamut.observer
    # The solid of the prints themselves, whose faces give way by a share of Y.
    faces = ConvexHull(prints).equations
    past = xyz @ faces[:, :3].T + faces[:, 3]
    beyond = (past - gamut.tolerance * xyz[:, 1:2]).max(axis=1)
    verdicts = gamut.contains(spectra)
    decided = np.abs(beyond) > 1e-9
    np.testing.assert_array_equal(verdicts[decided], (beyond <= 0)[decided])
    for one, verdict, distance in zip(xyz, verdicts, past.max(axis=1), strict=True):
        wanted = in_hull_by_linear_programme(prints, one)
        assert wanted is None or not wanted or verdict
        assert wanted is None or wanted or distance > 0


@pytest.mark.parametrize("name", ["dye3-endura-premier", "synthetic-cmyk"])
def test_a_devices_own_saturated_prints_have_colours_inside(name):
    # They were outside in two cases of five, by up to 0.6 ΔE2000, when the faces went through the samples.
    device = load_device(name)
    gamut = colorimetric_gamut(device)
    random = np.random.default_rng(77)
    amounts = random.uniform(0, device.printer.most, (2000, len(device.inks)))
    corner = random.integers(0, 3, amounts.shape)
    amounts = np.where(corner == 0, 0, np.where(corner == 1, device.printer.most, amounts))
    prints = device.printer.printed(amounts)
    assert gamut.contains(prints).mean() > 0.99
    faces = ConvexHull(device.samples @ gamut.observer).equations
    through = ((prints @ gamut.observer) @ faces[:, :3].T + faces[:, 3]).max(axis=1) <= 1e-12
    assert through.mean() < 0.9
    assert "as far as the samples are dense" in gamut.label
    assert f"sampling gap {gamut.gap:.2%}, {gamut.gap_delta_e:.1f} ΔE2000" in gamut.name


def test_prints_held_out_of_a_measured_chart_are_inside_but_for_a_few():
    device = load_device("dye3-endura-premier")
    random = np.random.default_rng(5)
    samples = random.permutation(device.samples)[:300]
    known = replace(device, samples=samples[:200], amounts=np.zeros((200, 0)), inks=(), printer=None, modelled=False)
    gamut = colorimetric_gamut(known)
    assert gamut.gap > 0
    assert gamut.contains(samples[200:]).mean() > 0.9
    hull = hull_gamut(known)
    assert hull.gap_95 >= hull.gap
    assert f"95 % within {hull.gap_95:.4f}" in repr(hull)


@pytest.mark.parametrize("tolerance", [0.3, 0.5, 1.0])
def test_a_wide_tolerance_is_a_share_of_the_luminance_up_to_the_lightest_prints(device, tolerance):
    # Beyond a third the faces that gave way by a share of Y alone had no end upwards, and the rest was anything.
    gamut = colorimetric_gamut(device, tolerance=tolerance)
    random = np.random.default_rng(21)
    spectra = random.uniform(0, 1.5, (400, len(device.bands))) * random.uniform(0, 2, (400, 1)) ** 2
    xyz, prints = spectra @ gamut.observer, device.samples @ gamut.observer
    faces = ConvexHull(prints).equations
    luminance = np.minimum(xyz[:, 1:2], prints[:, 1].max())
    beyond = (xyz @ faces[:, :3].T + faces[:, 3] - tolerance * luminance).max(axis=1)
    np.testing.assert_array_equal(gamut.contains(spectra), beyond <= 0)
    assert 0.3 < gamut.contains(spectra).mean() < 0.97
    assert gamut.contains(device.samples).all()


@pytest.mark.parametrize("count", [5, 8, 12])
def test_a_chart_of_few_prints_holds_their_colours(device, count):
    samples = np.random.default_rng(0).permutation(device.samples)[:count]
    samples[0] = 0  # of black there are no shares
    few = replace(device, samples=samples, amounts=np.zeros((count, 0)), inks=(), printer=None, modelled=False)
    gamut = colorimetric_gamut(few)
    assert gamut.contains(samples).all()
    assert 0 < gamut.gap < np.inf
    assert not gamut.contains(np.full((1, len(device.bands)), 100.0)).any()


def test_a_gap_that_cannot_be_measured_is_not_called_0(tmp_path):
    # Without one of four prints no solid is left to look from, without a single one nothing is.
    hues = np.random.default_rng(2).uniform(0.1, 0.9, (4, 31))
    four, one = chart(hues), chart(hues[:1])
    for gamut in (colorimetric_gamut(four), hull_gamut(one)):
        assert gamut.gap is None
        assert "sampling gap not measured" in repr(gamut)
        save_gamut(tmp_path / "few.npz", gamut)
        again = load_gamut(tmp_path / "few.npz")
        assert again.gap is None
        assert repr(again) == repr(gamut)


def test_a_hulls_limits_are_inside_for_certain():
    # Oracle: the distance from the hull by a quadratic programme of another library, to 1e-10.
    device = load_device("dye3-endura-premier", wavelengths(400, 700, 50))
    gamut = hull_gamut(device)
    random = np.random.default_rng(9)
    inside = random.dirichlet(np.full(len(device.samples), 0.02), 6) @ device.samples
    direction = random.normal(0, 1, inside.shape)
    found = gamut.clip(inside, direction)
    for ends in (found.low, found.high):
        for point in inside + ends[:, None] * direction:
            lifted = np.vstack([device.samples.T, 1e3 * np.ones(len(device.samples))])
            _, distance = nnls(lifted, np.append(point, 1e3), maxiter=10_000)
            # The penalty leaves the sum of weights within 1e-6 of 1: it can only make the distance less.
            assert distance <= gamut.tolerance * np.sqrt(7)
            assert distance >= gamut.tolerance * np.sqrt(7) - 1e-6


def test_nearest_colour_is_found_no_nearer_by_another_optimiser(device):
    gamut = colorimetric_gamut(device)
    spectra = np.random.default_rng(11).uniform(0, 1, (8, 7))
    nearest = gamut.nearest(spectra)
    faces = gamut.normals @ gamut.observer.T
    for target, ours in zip(spectra, nearest, strict=True):
        found = minimize(
            lambda r, t=target: np.sum((r - t) ** 2),
            device.samples.mean(axis=0),
            jac=lambda r, t=target: 2 * (r - t),
            constraints=[{"type": "ineq", "fun": lambda r: gamut.offsets - faces @ r, "jac": lambda _: -faces}],
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert np.sum((ours - target) ** 2) <= found.fun * (1 + 1e-6) + 1e-9


def test_a_match_under_one_light_may_break_under_another(device):
    day, lamp = (colorimetric_gamut(device, f"illuminant/{light}") for light in ("D50", "A"))
    spectra = day.nearest(np.random.default_rng(12).uniform(0, 1.2, (200, 7)))
    assert day.violation(spectra).max() < 1e-12
    assert 0.05 < lamp.contains(spectra).mean() < 0.95


def test_verdicts_are_asked_by_the_name_of_the_model(device):
    with pytest.raises(ValueError, match=r"model = 'hul': there are 'unit', 'envelope', 'hull'"):
        device_gamut(device, "hul")
    with pytest.raises(ValueError, match=r"model = 'monitor': dye3-endura-premier is a printer"):
        device_gamut(device, "monitor")
    with pytest.raises(ValueError, match=r"model = 'hull': crt-brainard is a monitor; choose 'monitor'"):
        device_gamut(load_device("crt-brainard"), "hull")
    with pytest.raises(ValueError, match=r"black = 'strict': model 'hull' has its own black"):
        device_gamut(device, "hull", "strict")
    with pytest.raises(ValueError, match=r"no colour under a light"):
        colorimetric_gamut(
            replace(device, bands=RGB, samples=device.samples[:, :3], extrapolated=np.zeros(3, dtype=bool))
        )
    with pytest.raises(ValueError, match=r"the colours of its 3 prints lie in a plane"):
        colorimetric_gamut(replace(device, samples=device.samples[:3], amounts=device.amounts[:3]))
