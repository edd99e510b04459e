"""What figures show is what the numbers say: Figure 1 of the paper, feasible ranges and their reasons."""

from dataclasses import replace
from io import BytesIO
from itertools import combinations

import imageio.v3 as imageio
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image
from scipy.optimize import isotonic_regression
from scipy.spatial import ConvexHull

import symrt as rt
from symrt.feedback.limits import limits
from symrt.feedback.parameters import moved
from symrt.show import plots
from symrt.show.plots.feedback import _binding, _outside
from symrt.show.plots.region import _stops
from symrt.show.segments import scale_segments
from symrt.show.solid import View, facets, facing, outline, spread

WITHIN = (0.01, 3.0)


@pytest.fixture(scope="module")
def gamut():
    return rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")


@pytest.fixture(scope="module")
def palette():
    return rt.load_palettes("globe")["macbeth"]


@pytest.fixture(scope="module")
def system():
    scene = rt.load_scene("first")
    return rt.render(replace(scene, camera=replace(scene.camera, width=24, height=24)), progress=False)


@pytest.fixture(scope="module")
def ranges(system, gamut):
    names = ("red", "red.specular", "sun")
    return [rt.feasible(system, plain(), gamut, rt.Scale(name), cap=False) for name in names]


@pytest.fixture(scope="module")
def region(system, gamut):
    dim = rt.Reference(exposure=0.5)
    return rt.joint_region(
        system, plain(), gamut, rt.Scale("red.diffuse"), rt.Scale("sun"), steps=17, reference=dim, progress=False
    )


def plain():
    return rt.load_palettes("first")["plain"]


def picture(figure):
    return imageio.imread(plots.png(figure, dpi=60), extension=".png")[..., :3]


def texts(figure):
    """Every text that is drawn, with the rectangle it covers in pixels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return [(text.get_text(), Text.get_window_extent(text, canvas.get_renderer())) for text in shown]


def figures(gamut, palette, system, ranges, region):
    return {
        "gamut": plots.gamut_figure(gamut, palette),
        "solids": plots.solids_figure(gamut),
        "ranges": plots.ranges_figure(ranges, system, plain(), gamut),
        "map": plots.out_of_gamut_map(system, plain(), gamut),
        "curve": plots.curve_figure(ranges[0]),
        "region": plots.joint_region_figure(region, system, plain(), rt.Reference(exposure=0.5)),
        "fit": plots.fit_figure(fitted(system, gamut), system, plain()),
        "adapted": plots.adapted_figure(adapted(system, gamut), system, plain()),
        "mapped": plots.mapped_figure(rt.map_pixels(system, plain(), gamut, towards="centre"), system, plain()),
    }


def adapted(system, gamut):
    return rt.adapt(system, plain(), gamut, [rt.Scale("red")], most_difference=0.1, map_rest=True, progress=False)


def fitted(system, gamut):
    scales = [rt.Scale(name) for name in ("red.diffuse", "red.specular", "sun")]
    return rt.fit(system, plain(), gamut, scales, objective="lightest", cap=False)


def test_whatever_a_device_prints_is_drawn_inside_the_shadow(gamut):
    view = View()
    planes = ConvexHull(outline(facets(gamut.shadow(3).polyhedron()), view)).equations
    points = view.project(gamut.device.samples @ gamut.basis.vectors[:3].T)
    assert (planes[:, :2] @ points.T + planes[:, 2:]).max() < 1e-9


def test_facets_are_the_flat_sides_of_the_solid(gamut):
    for solid in (gamut.shadow(3).polyhedron(), gamut.slice(3).polyhedron()):
        sides = facets(solid)
        assert len(solid.vertices) - len(solid.edges) + len(sides) == 2  # Euler's formula
        area = 0.0
        for side in sides:
            assert np.abs((side.corners - side.corners[0]) @ side.normal).max() < 1e-9
            spokes = side.corners[1:] - side.corners[0]
            area += np.linalg.norm(np.cross(spokes[:-1], spokes[1:]), axis=1).sum() / 2
        assert area == pytest.approx(ConvexHull(solid.vertices).area, rel=1e-9)


def test_the_near_sides_of_a_solid_cover_the_same_paper_as_the_far_ones(gamut):
    view, sides = View(25.0, 40.0), facets(gamut.slice(3).polyhedron())
    covered = []
    for near in (True, False):
        flats = [view.project(s.corners) for s, seen in zip(sides, facing(sides, view), strict=True) if seen == near]
        covered.append(sum(ConvexHull(flat).volume for flat in flats))
    assert covered == pytest.approx([ConvexHull(outline(sides, view)).volume] * 2, rel=1e-9)


def test_a_view_keeps_lengths_that_lie_in_the_paper_and_hides_the_one_across_it():
    rng = np.random.default_rng(7)
    for azimuth, elevation in rng.uniform(-180, 180, (50, 2)):
        view = View(float(azimuth), float(elevation))
        points = rng.normal(size=(20, 3))
        depth = points @ view.towards
        np.testing.assert_allclose((view.project(points) ** 2).sum(1) + depth**2, (points**2).sum(1), rtol=1e-12)
        assert View(float(azimuth), 0.0).project(np.array([[1.0, 0, 0]]))[0].tolist() == [0, 1]


def test_labels_are_spread_as_isotonic_regression_spreads_them():
    rng = np.random.default_rng(3)
    for _ in range(200):
        wanted, gap = rng.normal(size=rng.integers(0, 12)), float(rng.uniform(0, 1))
        placed, order = spread(wanted, gap), np.argsort(wanted, kind="stable")
        assert np.all(np.diff(placed[order]) >= gap * (1 - 1e-12))
        steps = gap * np.arange(len(wanted))
        if len(wanted):
            np.testing.assert_allclose(placed[order], isotonic_regression(wanted[order] - steps).x + steps, atol=1e-12)


def test_names_on_figures_do_not_overlap_and_stay_on_the_paper(gamut, palette, system, ranges, region):
    basis = plots.basis_figure(rt.basis_report(gamut.device))
    for name, figure in (figures(gamut, palette, system, ranges, region) | {"basis": basis}).items():
        shown = texts(figure)
        width, height = figure.canvas.get_width_height()
        for text, box in shown:
            assert 0 <= box.x0 < box.x1 <= width, (name, text)
            assert 0 <= box.y0 < box.y1 <= height, (name, text)
        for (one, a), (other, b) in combinations(shown, 2):
            apart = a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0
            assert apart, (name, one, other)


def test_figures_are_drawn_in_many_colours_and_name_what_they_show(gamut, palette, system, ranges, region):
    for name, figure in figures(gamut, palette, system, ranges, region).items():
        assert len(np.unique(picture(figure).reshape(-1, 3), axis=0)) > 100, name
        said = " ".join(text for text, _ in texts(figure)).replace("\n", " ")
        assert "modelled" in said, name
        assert "envelope of dye3-endura-premier" in said, name
    said = " ".join(text for text, _ in texts(plots.gamut_figure(gamut, palette, exposure=0.5)))
    assert all(word in said for word in ("3 of 36", "reference light, key", "exposure 0.5", "ice: ≤", "extrapolated"))


def test_materials_are_drawn_in_their_own_colour(gamut, palette):
    figure = plots.gamut_figure(gamut, palette, ["brass"])
    expected = scale_segments(gamut, palette, ["brass"], palette["key"])[0].colours[0]
    pixels = picture(figure).reshape(-1, 3) / 255
    assert (np.abs(pixels - expected).max(axis=1) < 0.02).sum() > 50


def test_the_spectrum_beside_a_range_meets_the_bound_that_stops_it(gamut, system, ranges):
    palette = plain()
    asked = limits(system, palette, gamut)
    for found in ranges:
        spectrum = _binding(found, asked, system, palette)
        band = asked.bands.labels.index(found.reasons[-1][1].band)
        assert spectrum[band] == pytest.approx(gamut.upper[band], rel=1e-12)
        assert (spectrum <= gamut.upper * (1 + 1e-12)).all()


def test_the_map_marks_the_pixels_whose_reflectance_the_gamut_does_not_contain(gamut, system):
    palette = plain()
    bright, dark, _ = _outside(system, palette, limits(system, palette, gamut))
    image = rt.shade(system, palette)
    reflectance = (image.values / image.white).reshape(-1, 36)
    assert np.array_equal(bright.ravel(), ~gamut.contains(reflectance))
    assert bright.any()
    assert not (bright & dark).any()


@pytest.mark.parametrize("model", ["hull", "colorimetric", "monitor"])
def test_ranges_against_any_gamut_show_the_reflectance_that_stops_them(system, model):
    palette, dim = plain(), rt.Reference(exposure=0.7)
    asked = rt.device_gamut(rt.load_device("crt-brainard" if model == "monitor" else "dye3-endura-premier"), model)
    found = [
        rt.feasible(
            system, palette, asked, rt.Scale("sun"), reference=dim, cap=False, allowed_out=share, progress=False
        )
        for share in (0.0, 0.1, 0.3, 0.6)
    ]
    text = " ".join(t for t, _ in texts(plots.ranges_figure(found, system, palette, asked, dim))).replace("\n", " ")
    assert asked.name in text
    stopped = [one for one in found if one.intervals and one.reasons[-1][1].x is not None]
    assert stopped
    for one in stopped:
        reason, colours = one.reasons[-1][1], moved(system, palette, one.parameter, one.high)
        spectrum = _binding(one, limits(system, palette, asked, dim), system, palette, dim)
        image = rt.shade(system, colours).values[reason.y, reason.x]
        np.testing.assert_allclose(spectrum, 0.7 * image / rt.Reference().white(system, palette), rtol=1e-12)


@pytest.mark.parametrize("model", ["hull", "inks", "colorimetric", "monitor"])
def test_the_map_of_any_gamut_marks_the_pixels_that_it_does_not_contain(system, model):
    palette = plain()
    device = rt.load_device("crt-brainard" if model == "monitor" else "dye3-endura-premier")
    asked = rt.device_gamut(device, model)
    bright, dark, side = _outside(system, palette, limits(system, palette, asked))
    image = rt.shade(system, palette)
    expected = ~asked.under(image.white).contains((image.values / image.white).reshape(-1, 36))
    lit = system.object_pixels & ~dark.ravel()
    assert side == 1
    assert np.array_equal(bright.ravel()[lit], expected[lit])
    assert not (bright & dark).any()
    assert asked.name in " ".join(text for text, _ in texts(plots.out_of_gamut_map(system, palette, asked))).replace(
        "\n", " "
    )


def test_of_many_pixels_a_hull_is_asked_about_one_in_each_block(system, monkeypatch):
    palette, asked = plain(), rt.device_gamut(rt.load_device("dye3-endura-premier"), "hull")
    every, _, _ = _outside(system, palette, limits(system, palette, asked))
    monkeypatch.setattr("symrt.show.plots.feedback.TESTED", 60)
    some, _, side = _outside(system, palette, limits(system, palette, asked))
    assert side > 1
    assert abs(int(some.sum()) - int(every.sum())) < 0.2 * system.object_pixels.sum()
    said = " ".join(text for text, _ in texts(plots.out_of_gamut_map(system, palette, asked)))
    assert f"{side} × {side}" in said


def test_the_numbers_on_a_region_stand_where_those_pixels_stop_it(gamut, system, region):
    stops = _stops(region)
    assert stops
    white = rt.Reference(exposure=0.5).white(system, plain()) / 0.5
    for stop in stops:
        colours = plain()
        for parameter, value in zip((region.one, region.other), stop.place, strict=True):
            colours = moved(system, colours, parameter, value)
        if stop.reason.side == "upper":
            r = rt.shade(system, colours).values[stop.reason.y, stop.reason.x] / white
            band = gamut.bands.labels.index(stop.reason.band)
            assert r[band] == pytest.approx(gamut.upper[band], rel=1e-9)
    said = " ".join(text for text, _ in texts(plots.joint_region_figure(region, system, plain())))
    assert all(str(stop.reason).partition(" (where")[0] in said.replace("\n   ", "") for stop in stops)


def test_figures_leave_matplotlibs_global_state_alone(gamut, palette):
    before = dict(mpl.rcParams)
    plots.png(plots.gamut_figure(gamut, palette))
    assert dict(mpl.rcParams) == before
    assert plt.get_fignums() == []
    assert rt.plots is plots


def test_a_fit_is_drawn_with_its_factors_its_reasons_and_both_pictures_under_one_white(system, gamut):
    found = fitted(system, gamut)
    figure = plots.fit_figure(found, system, plain())
    words = " ".join(text for text, _ in texts(figure)).replace("\n", " ")
    for name, value in found.values.items():
        assert f"{name}  × {value:.3g}" in words
        assert str(found.reasons[name]) in words
    given, after = (axes.images[0].get_array() for axes in figure.axes[:2])
    white = rt.Reference().white(system, plain())
    assert np.array_equal(given, rt.preview(system, plain()))
    assert np.array_equal(after, rt.preview(system, found.palette, white=white))


def test_a_figure_says_that_it_is_srgb():
    with Image.open(BytesIO(plots.png(Figure(figsize=(1, 1))))) as picture:
        assert picture.info["srgb"] == 1
        assert picture.info["gamma"] == pytest.approx(0.45455)
