"""Intersections of gamuts against least-distance programmes, linear programmes, and the parts themselves."""

from dataclasses import replace

import numpy as np
import pytest
from feedback import synthetic
from gamut.every import BANDS, PARTS, made
from scipy.optimize import linprog, minimize

from symrt.device import Device, load_device
from symrt.feedback import Scale, feasible, map_pixels, report
from symrt.gamut import device_gamut, intersection, load_gamut, save_gamut
from symrt.gamut.hull import HullGamut
from symrt.gamut.interface import ConvexGamut, SlabGamut
from symrt.gamut.intersections import InkIntersection, Intersection, SlabIntersection
from symrt.gamut.polyhedra import deepest, nearest_point, supports
from symrt.spectra.library import spectrum


@pytest.fixture(scope="module", params=list(PARTS))
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def both(kind):
    return intersection([made(name) for name in PARTS[kind]])


@pytest.fixture(scope="module")
def spectra(both):
    """Some inside, some far outside, some near the boundary."""
    random = np.random.default_rng(1)
    samples = np.vstack([device.samples for device in both.devices])
    prints = samples[random.integers(0, len(samples), 12)]
    return np.vstack([random.uniform(-0.3, 1.3, (8, 7)), prints + random.normal(0, 0.02, prints.shape), prints])


def rows_of(gamut):
    """Half-spaces a · r <= b of a gamut, from what defines it and not from its slabs."""
    if hasattr(gamut, "drive"):
        return np.vstack([gamut.drive, -gamut.drive]), np.array([1.0, 1, 1, 0, 0, 0])
    if hasattr(gamut, "offsets"):
        return gamut.normals @ gamut.observer.T, gamut.offsets
    bands = len(gamut.lower)
    more = np.empty((0, bands)) if gamut.weights is None else -gamut.weights[None]
    blackest = [] if gamut.weights is None else [-gamut.blackest]
    return np.vstack([np.eye(bands), -np.eye(bands), more]), np.concatenate([gamut.upper, -gamut.lower, blackest])


def all_rows(both):
    each = [rows_of(one) for one in both.parts]
    return np.vstack([rows for rows, _ in each]), np.concatenate([bounds for _, bounds in each])


def test_a_spectrum_is_inside_if_every_part_contains_it(both, spectra):
    each = [one.contains(spectra) for one in both.parts]
    np.testing.assert_array_equal(both.contains(spectra), np.all(each, axis=0))
    np.testing.assert_array_equal(
        both.violation(spectra), np.max([one.violation(spectra) for one in both.parts], axis=0)
    )
    assert 0 < both.contains(spectra).sum() < len(spectra)


@pytest.mark.parametrize("name", ["boxes", "luminances", "shown", "lights", "everything"])
def test_nearest_agrees_with_a_quadratic_optimiser(name):
    both = intersection([made(one) for one in PARTS[name]])
    rows, bounds = all_rows(both)
    for point in np.random.default_rng(2).uniform(-0.3, 1.3, (12, 7)):
        wanted = minimize(
            lambda r, point=point: (0.5 * np.sum((r - point) ** 2), r - point),
            both.inner[0],
            jac=True,
            method="SLSQP",
            constraints={"type": "ineq", "fun": lambda r: bounds - rows @ r, "jac": lambda _: -rows},
            options={"ftol": 1e-15, "maxiter": 500},
        )
        assert wanted.success
        # The optimiser stops at gradients of 1e-8 or so.
        np.testing.assert_allclose(both.nearest(point[None])[0], wanted.x, atol=2e-6)


@pytest.mark.parametrize("name", ["boxes", "luminances", "shown", "lights", "everything"])
def test_nearest_points_prove_themselves_by_the_support_of_the_way_to_them(name):
    both = intersection([made(one) for one in PARTS[name]])
    points = np.random.default_rng(3).uniform(-0.3, 1.3, (12, 7))
    near = both.nearest(points)
    away = points - near
    # n is nearest to s in a convex set if no point of the set is beyond it: support(s − n) = (s − n) · n.
    np.testing.assert_allclose(both.support(away), np.sum(away * near, axis=1), atol=1e-9)


@pytest.mark.parametrize("name", ["hulls", "two hulls"])
def test_nearest_points_of_hulls_are_those_of_one_large_quadratic_programme(name):
    both = intersection([made(one) for one in PARTS[name]])
    hulls = [one for one in both.parts if isinstance(one, HullGamut)]
    # Fewer prints, so that the optimiser has few weights.
    hulls = [
        replace(one, device=replace(one.device, samples=one.device.samples[::150], amounts=one.device.amounts[::150]))
        for one in hulls
    ]
    hulls = [replace(one, tolerance=0.03) for one in hulls]
    both = intersection([*hulls, *(one for one in both.parts if not isinstance(one, HullGamut))])
    sizes = [len(one.device.samples) for one in hulls]
    radius = [one.tolerance * np.sqrt(7) for one in hulls]
    rows, bounds = np.empty((0, 7)), np.empty(0)
    for one in both.parts:
        if not isinstance(one, HullGamut):
            more = rows_of(one)
            rows, bounds = np.vstack([rows, more[0]]), np.append(bounds, more[1])

    def split(unknowns):
        return unknowns[:7], np.split(unknowns[7:], np.cumsum(sizes)[:-1])

    def inside(unknowns):
        r, weights = split(unknowns)
        round_ = [
            e**2 - np.sum((r - w @ h.device.samples) ** 2) for h, w, e in zip(hulls, weights, radius, strict=True)
        ]
        return np.concatenate([bounds - rows @ r, round_])

    def sums(unknowns):
        return [w.sum() - 1 for w in split(unknowns)[1]]

    start = np.concatenate([both.inner[0], *(np.full(size, 1 / size) for size in sizes)])
    for point in np.random.default_rng(4).uniform(-0.1, 1.1, (2, 7)):
        wanted = minimize(
            lambda u, point=point: np.sum((u[:7] - point) ** 2),
            start,
            method="SLSQP",
            bounds=[(None, None)] * 7 + [(0, 1)] * sum(sizes),
            constraints=[{"type": "ineq", "fun": inside}, {"type": "eq", "fun": sums}],
            options={"ftol": 1e-14, "maxiter": 500},
        )
        found = both.nearest(point[None])
        assert both.contains(found)[0]
        assert np.linalg.norm(found - point) == pytest.approx(np.linalg.norm(wanted.x[:7] - point), abs=1e-6)


@pytest.mark.parametrize("name", ["boxes", "luminances", "shown", "lights", "everything"])
def test_support_is_the_optimum_of_a_linear_programme_and_never_below_it(name):
    both = intersection([made(one) for one in PARTS[name]])
    rows, bounds = all_rows(both)
    directions = np.random.default_rng(5).normal(size=(15, 7))
    if name == "lights":
        # Colours alone bound these: other directions have no support.
        assert np.all(np.isinf(both.support(directions)))
        directions = np.random.default_rng(5).normal(size=(15, 3)) @ both.parts[0].observer.T
    for direction, found in zip(directions, both.support(directions), strict=True):
        wanted = linprog(-direction, A_ub=rows, b_ub=bounds, bounds=[(None, None)] * 7)
        if wanted.status == 3:
            assert np.isinf(found)
        else:
            assert found == pytest.approx(-wanted.fun, rel=1e-7, abs=1e-9)
            assert found >= direction @ wanted.x - 1e-7 * np.abs(direction).sum()
    assert both.support(np.zeros((1, 7)))[0] == 0


def test_hulls_and_inks_have_no_support_and_say_so():
    with pytest.raises(ValueError, match="support of an intersection is that of its planes, and hull of dye3"):
        intersection([made("hull"), made("monitor")]).support(np.ones((1, 7)))
    both = intersection([made("inks"), made("monitor")])
    assert not isinstance(both, ConvexGamut)
    assert isinstance(both, InkIntersection)


def test_slabs_say_the_same_as_the_parts(kind, both, spectra):
    if kind in {"hulls", "two hulls", "printed"}:
        assert not isinstance(both, SlabGamut)
        return
    assert isinstance(both, SlabGamut)
    slabs = both.slabs
    seen = spectra @ slabs.matrix
    inside = np.all((slabs.lower - 1e-12 <= seen) & (seen <= slabs.upper + 1e-12), axis=1)
    np.testing.assert_array_equal(inside, both.contains(spectra))
    assert len(slabs.words) == slabs.matrix.shape[1]
    for word, band in zip(slabs.words, slabs.bands, strict=True):
        assert word == BANDS.labels[band] if band >= 0 else any(word.endswith(one.name) for one in both.parts)
    alone = sum(isinstance(one, type(made("unit"))) for one in both.parts)
    assert np.sum(slabs.bands >= 0) == (7 if alone else 0)


def test_slabs_of_boxes_are_the_narrower_bounds_and_know_whose_they_are():
    device = load_device("dye3-endura-premier")
    guessed, strict = (
        device_gamut(device, "envelope"),
        device_gamut(load_device("synthetic-cmyk"), "envelope", "strict"),
    )
    slabs = intersection([guessed, strict]).slabs
    np.testing.assert_array_equal(slabs.matrix, np.eye(36))
    np.testing.assert_array_equal(slabs.lower, np.maximum(guessed.lower, strict.lower))
    np.testing.assert_array_equal(slabs.upper, np.minimum(guessed.upper, strict.upper))
    assert slabs.dark.all()
    assert not intersection([guessed, device_gamut(device, "unit")]).slabs.dark.any()
    assert slabs.words == device.bands.labels
    # Both bounds are those of the device without guessed bands, or of one that guessed there.
    np.testing.assert_array_equal(slabs.extrapolated, device.extrapolated)


def test_clipping_is_what_every_part_allows(kind, both, spectra):
    if kind == "printed":
        return
    origin, direction = spectra, np.random.default_rng(6).normal(size=spectra.shape)
    found = both.clip(origin, direction)
    each = [one.clip(origin, direction) for one in both.parts]
    low, high = np.max([one.low for one in each], axis=0), np.min([one.high for one in each], axis=0)
    np.testing.assert_array_equal(found.empty, low > high)
    met = ~found.empty
    assert met.sum() > 3
    np.testing.assert_allclose(found.low[met], low[met], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found.high[met], high[met], rtol=1e-12, atol=1e-12)


def test_lines_through_what_inks_print_are_cut_where_a_part_ends():
    both = intersection([made("inks"), made("monitor")])
    device = load_device("dye3-endura-premier", BANDS)
    origin, direction = device.samples[[0, 100, 400]], device.samples[[728, 500, 0]] - device.samples[[0, 100, 400]]
    found = both.clip(origin, direction, (-0.2, 1.0))
    t = np.linspace(-0.2, 1.0, 97)
    for row, intervals in enumerate(found):
        points = origin[row] + t[:, None] * direction[row]
        told = np.any([(a <= t) & (t <= b) for a, b in intervals], axis=0) if intervals else np.zeros(97, dtype=bool)
        clear = np.min([np.abs(t - end) for interval in intervals for end in interval], axis=0, initial=1) > 1e-6
        np.testing.assert_array_equal(both.contains(points)[clear], told[clear])
    assert any(found)
    assert any(len(intervals) != 1 or intervals[0] != (-0.2, 1.0) for intervals in found)


def test_the_nearest_of_inks_is_the_nearest_print_that_every_part_contains():
    both = intersection([made("inks"), made("monitor")])
    spectra = np.random.default_rng(8).uniform(0, 1, (20, 7))
    prints = load_device("dye3-endura-premier", BANDS).samples
    prints = prints[both.contains(prints)]
    outside = ~both.contains(spectra)
    wanted = [prints[np.linalg.norm(prints - s, axis=1).argmin()] for s in spectra[outside]]
    np.testing.assert_array_equal(both.nearest(spectra)[outside], wanted)


@pytest.mark.parametrize(
    ("names", "whole"),
    [
        (("envelope", "other/envelope"), "necessary, not sufficient for all of them together"),
        (("envelope", "monitor"), "necessary, not sufficient for all of them together"),
        (("inks", "other/inks"), "sufficient for all of them together"),
        (("inks", "monitor"), "sufficient for all of them together"),
        (("inks", "envelope"), "neither necessary nor sufficient for all of them together"),
    ],
)
def test_the_label_says_what_follows_from_all_parts_and_lists_each(names, whole):
    parts = [made(name) for name in names]
    both = intersection(parts)
    assert both.label.partition(" (")[0] == whole
    for one in parts:
        assert one.label in both.label
        assert one.name in both.name
    two = intersection(
        [device_gamut(load_device(name, BANDS), "monitor") for name in ("crt-brainard", "apple-studio-display")]
    )
    assert two.label.startswith("necessary and sufficient for all of them together")


def test_intersections_of_intersections_are_flat_and_one_gamut_is_itself():
    one, other, third = made("envelope"), made("monitor"), made("colorimetric/A")
    nested = intersection([intersection([one, other]), third])
    assert nested.parts == (one, other, third)
    assert intersection([one]) is one
    assert isinstance(nested, SlabIntersection)
    assert isinstance(intersection([one, made("hull")]), Intersection)
    device = load_device("dye3-endura-premier", BANDS)
    assert len(intersection([device_gamut(device), device_gamut(device, "colorimetric")]).devices) == 1


def test_gamuts_that_cannot_be_intersected_are_named():
    with pytest.raises(ValueError, match="no gamuts to intersect"):
        intersection([])
    with pytest.raises(ValueError, match=r"envelope of dye3.* is in Bands\(36 .*load_device\(name, bands\)"):
        intersection([device_gamut(load_device("dye3-endura-premier"), "envelope"), made("monitor")])


def greys(name, low, high):
    """A chart of greys between two reflectances."""
    samples = np.linspace(low, high, 5)[:, None] * np.ones(7)
    none = np.zeros(7, dtype=bool)
    return Device(name, BANDS, samples, np.empty((5, 0)), (), none, "made up", "made up", modelled=False)


def test_what_has_nothing_in_common_is_said_to_be_empty():
    dark, light = (greys(*given) for given in (("dark", 0.1, 0.4), ("light", 0.5, 0.8)))
    boxes = [device_gamut(device, "envelope", "strict") for device in (dark, light)]
    with pytest.raises(ValueError, match=r"nothing is inside all of: envelope of dark, .*; envelope of light"):
        intersection([made("unit"), *boxes])
    with pytest.raises(ValueError, match=r"nothing is inside all of: hull of dark's prints.*; hull of light's"):
        intersection([made("unit"), HullGamut(dark, 0.04, 0.0, 0.0), HullGamut(light, 0.04, 0.0, 0.0)])
    with pytest.raises(ValueError, match=r"nothing is inside all of: hull of dark's prints.*; envelope of light"):
        intersection([HullGamut(dark, 0.04, 0.0, 0.0), boxes[1], made("inks")])
    # Boxes may touch: what they share is a point, and inside.
    touching = intersection([boxes[0], device_gamut(greys("next", 0.4, 0.7), "envelope", "strict")])
    np.testing.assert_array_equal(touching.nearest(np.zeros((1, 7))), np.full((1, 7), 0.4))
    # Hulls that overlap by their tolerance are not empty, by less than it they are.
    assert intersection([HullGamut(dark, 0.0501, 0.0, 0.0), HullGamut(light, 0.0501, 0.0, 0.0)]).inner[1] > 0
    with pytest.raises(ValueError, match="nothing is inside"):
        intersection([HullGamut(dark, 0.0499, 0.0, 0.0), HullGamut(light, 0.0499, 0.0, 0.0)])


def test_another_white_moves_the_parts_that_it_moves():
    lamp = spectrum("illuminant/A", BANDS)
    one, other = made("envelope/luminance"), made("monitor")
    both = intersection([one, other]).under(lamp)
    spectra = np.random.default_rng(7).uniform(0, 1, (50, 7))
    np.testing.assert_array_equal(
        both.contains(spectra), one.under(lamp).contains(spectra) & other.under(lamp).contains(spectra)
    )
    assert both.contains(both.nearest(spectra)).all()


def test_intersections_are_saved_and_come_back_bit_for_bit(kind, both, spectra, tmp_path):
    save_gamut(tmp_path / "a.npz", both)
    again = load_gamut(tmp_path / "a.npz")
    assert (type(again), repr(again), len(again.devices)) == (type(both), repr(both), len(both.devices))
    some = spectra[::7]
    for question in (
        "contains",
        "violation",
        "nearest",
        *([] if kind in {"hulls", "two hulls", "printed"} else ["support"]),
    ):
        np.testing.assert_array_equal(getattr(again, question)(some), getattr(both, question)(some))


def test_polyhedra_without_a_point_are_told_by_a_negative_radius():
    normals, offsets = np.array([[1.0], [-1.0]]), np.array([0.25, -0.75])
    assert deepest(normals, offsets)[1] == pytest.approx(-0.25)
    with pytest.raises(ValueError, match="nothing is inside"):
        nearest_point(normals, offsets, np.array([0.5]))
    assert np.isinf(supports(np.eye(2)[:, :1], np.zeros(1), np.ones(1), np.array([[1.0, 1.0]]))[0])


def test_a_range_in_an_intersection_is_what_the_ranges_in_its_parts_have_in_common():
    system, palette = synthetic.system(), synthetic.palette()
    dyes, inks = (load_device(name) for name in ("dye3-endura-premier", "synthetic-cmyk"))
    parts = [
        device_gamut(dyes, "envelope", "strict"),
        device_gamut(inks, "envelope"),
        device_gamut(dyes, "colorimetric", light="illuminant/A"),
        device_gamut(load_device("crt-brainard"), "monitor"),
    ]
    for name in ("deep", "brass.specular", "key"):
        ranges = [feasible(system, palette, gamut, Scale(name), cap=False) for gamut in (*parts, intersection(parts))]
        *each, whole = ranges
        assert all(len(one.intervals) <= 1 for one in ranges)
        if not all(one.intervals for one in each):
            assert whole.intervals == ()
            continue
        assert whole.low == pytest.approx(max(one.low for one in each), rel=1e-9)
        assert whole.high == pytest.approx(min(one.high for one in each), rel=1e-9)


def test_feedback_takes_intersections_with_what_inks_print():
    system, palette = synthetic.system(4, 4), synthetic.palette()
    parts = [
        device_gamut(load_device("dye3-endura-premier"), "inks", tolerance=0.2),
        device_gamut(load_device("crt-brainard"), "monitor"),
    ]
    both = intersection(parts)
    white = palette["key"] / np.pi
    shares = [verdict.inside for verdict in report(system, palette, [*parts, both]).verdicts]
    assert shares[2] <= min(shares[:2])
    moved = map_pixels(system, palette, both, towards="nearest", progress=False)
    seen = moved.image.values[system.object_pixels.reshape(4, 4)] / white
    assert both.under(white).violation(seen).max() < 1e-9
    found = feasible(system, palette, both, Scale("key"), within=(0.2, 1.0), cap=False)
    shown = feasible(system, palette, parts[1], Scale("key"), within=(0.2, 1.0), cap=False)
    assert found.verdict == "rest-only" or found.high <= shown.high
