"""Every word of a figure can be read, and none says more than was found: the cases that once broke this."""

import re
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Annotation, Text
from scipy import sparse
from scipy.optimize import minimize

import symrt as rt
from symrt.interactions import Interaction
from symrt.show import plots
from symrt.show.solid import spread
from symrt.system import LinearSystem

UNREACHED = ("ice", "upland", "brass", "table")
FIGURES = {
    "no segment of a hull inside": lambda case: plots.gamut_figure(case.hull, case.palette),
    "no segment of inks inside": lambda case: plots.gamut_figure(case.inks, case.palette),
    "a slim body": lambda case: plots.gamut_figure(case.hull, case.palette, components=(0, 3, 4)),
    "two devices": lambda case: plots.gamut_figure(case.shared, case.palette),
    "two devices' body": lambda case: plots.body_figure(case.shared),
    "given points off the panel": lambda case: plots.gamut_figure(case.envelope, case.palette, exposure=2.5),
    "long names in a fit": lambda case: case.fit("lightest", "mountain", "brass.specular", "brass.diffuse"),
    "decades in a fit": lambda case: case.fit("darkest", "upland", "brass", "ice", "key"),
    "a blend's range": lambda case: case.ranges(rt.Blend("upland", "ice", "kubelka-munk"), rt.Scale("brass")),
    "a blend's curve": lambda case: plots.curve_figure(case.feasible(rt.Blend("upland", "ice", "kubelka-munk"))),
    "a region of pairs": lambda case: case.region("upland", "key"),
    "means tried": lambda case: case.adapted(),
    "the map": lambda case: plots.out_of_gamut_map(case.system, case.palette, case.hull),
}


class Case:
    """The globe, small, with the gamuts of one printer and what two share."""

    def __init__(self):
        scene, dyes = rt.load_scene("globe"), rt.load_device("dye3-endura-premier")
        self.system = rt.render(replace(scene, camera=replace(scene.camera, width=32, height=32)), progress=False)
        self.palette = rt.load_palettes("globe")["macbeth"]
        self.envelope, self.hull, self.inks = (rt.device_gamut(dyes, model) for model in ("envelope", "hull", "inks"))
        self.shared = rt.intersection([self.envelope, rt.device_gamut(rt.load_device("synthetic-cmyk"), "envelope")])

    def feasible(self, parameter):
        return rt.feasible(self.system, self.palette, self.envelope, parameter, cap=False, progress=False)

    def ranges(self, *parameters):
        found = [self.feasible(parameter) for parameter in parameters]
        return plots.ranges_figure(found, self.system, self.palette, self.envelope)

    def fit(self, objective, *names):
        scales = [rt.Scale(name) for name in names]
        found = rt.fit(self.system, self.palette, self.envelope, scales, objective=objective, cap=False)
        return plots.fit_figure(found, self.system, self.palette)

    def region(self, one, other):
        names = rt.Scale(one), rt.Scale(other)
        found = rt.joint_region(self.system, self.palette, self.envelope, *names, steps=9, progress=False)
        return plots.joint_region_figure(found, self.system, self.palette)

    def adapted(self):
        scales = [rt.Scale("upland"), rt.Scale("brass")]
        asked = {"most_difference": 0.1, "map_rest": True, "progress": False}
        found = rt.adapt(self.system, self.palette, self.envelope, scales, **asked)
        return plots.adapted_figure(found, self.system, self.palette)


@pytest.fixture(scope="module")
def case():
    return Case()


@cache
def drawn(case, name):
    return FIGURES[name](case)


@pytest.fixture(scope="module", params=FIGURES)
def figure(request, case):
    return drawn(case, request.param)


@cache
def rendered(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas.get_renderer()


def texts(figure):
    """Every text that is drawn, with the rectangle that it covers, in pixels."""
    renderer = rendered(figure)
    beyond = {
        label for axes in figure.axes if axes.axison for axis in (axes.xaxis, axes.yaxis) for label in unseen(axis)
    }
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    shown = [text for text in shown if text not in beyond]
    return [(text, Text.get_window_extent(text, renderer)) for text in shown]


def unseen(axis):
    """Labels of ticks that lie beyond the end of their axis, and are not drawn."""
    low, high = sorted(axis.get_view_interval())
    return [tick.label1 for tick in axis.majorTicks if not low * (1 - 1e-9) <= tick.get_loc() <= high * (1 + 1e-9)]


def words(figure):
    return " ".join(text.get_text() for text, _ in texts(figure)).replace("\n", " ")


def apart(a, b):
    return a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0


def test_no_word_lies_on_another_on_a_picture_or_off_the_paper(figure):
    shown, (width, height) = texts(figure), figure.canvas.get_width_height()
    for text, box in shown:
        assert 0 <= box.x0 < box.x1 <= width, text
        assert 0 <= box.y0 < box.y1 <= height, text
        for axes in figure.axes:
            assert not axes.images or text.axes is axes or apart(box, axes.get_window_extent()), text
    for (one, a), (other, b) in combinations(shown, 2):
        assert apart(a, b), (one, other)


def test_no_name_vanishes_because_what_it_names_is_off_the_panel(figure):
    renderer = rendered(figure)
    for name in figure.findobj(Annotation):
        assert not name.get_text() or np.isfinite(name.get_tightbbox(renderer).extents).all(), name


def test_every_sentence_of_a_caption_begins_with_a_capital(figure):
    said = figure.texts[-1].get_text().replace("\n", " ")
    assert said.endswith(".")
    assert re.match("[A-ZΔ]", said)
    assert not re.search(r"\. [a-z]", said), said


@pytest.mark.parametrize("which", ["no segment of a hull inside", "a slim body"])
def test_a_segment_that_is_never_inside_is_named_at_its_given_point(case, which):
    left, right, *_ = drawn(case, which).axes
    given = {name.get_text(): name.xy for name in right.texts if isinstance(name, Annotation)}
    named = {name.get_text(): name.xy for name in left.texts if isinstance(name, Annotation)}
    for name in UNREACHED:
        assert named[f"{name}: none"] == given[name]
    assert len(set(given.values())) == len(given)


def test_the_name_of_the_upright_axis_lies_above_all_else(case):
    for axes in drawn(case, "a slim body").axes[:2]:
        (name,) = (text for text in axes.texts if "neutral" in text.get_text())
        assert name.get_path_effects()
        assert all(name.zorder > other.zorder for other in axes.get_children() if other is not name)


def test_labels_in_a_room_are_the_nearest_that_keep_their_distance_in_it():
    rng = np.random.default_rng(5)
    for _ in range(40):
        wanted, gap = np.sort(rng.normal(size=rng.integers(1, 7))), float(rng.uniform(0.1, 0.6))
        low, high = float(rng.uniform(-2, -1)), float(rng.uniform(0, 2))
        placed = spread(wanted, gap, (low, high))
        gap = min(gap, (high - low) / max(1, len(wanted) - 1))
        laws = ({"type": "ineq", "fun": lambda y, gap=gap: np.diff(y) - gap},) if len(wanted) > 1 else ()
        bounds = [(low, high)] * len(wanted)
        best = minimize(
            lambda y, wanted=wanted: ((y - wanted) ** 2).sum(),
            np.linspace(low, high, len(wanted)),
            bounds=bounds,
            constraints=laws,
            options={"ftol": 1e-14},
        )
        # The optimiser stops where the sum of squares is flat.
        np.testing.assert_allclose(placed, best.x, atol=1e-5)
        assert placed.min() >= low - 1e-12
        assert placed.max() <= high + 1e-12


def test_a_blend_among_ranges_has_its_scale_explained(case):
    said = words(drawn(case, "a blend's range"))
    assert "a blend is as given at 0 and wholly replaced at 1" in said
    assert "axis begins at 0.01" in said
    said = words(case.ranges(rt.Scale("brass")))
    assert "replaced" not in said
    assert "begins" not in said


def test_bars_of_the_means_tried_have_three_ticks_at_least(case):
    bars = [axes for axes in drawn(case, "means tried").axes if axes.patches]
    assert len(bars) == 3
    for axes in bars:
        right = axes.get_xlim()[1]
        assert 3 <= sum(0 <= tick <= right for tick in axes.get_xticks()) <= 5


def narrow(case, shares):
    """Two pixels of a material that reflects in one band alone, as no print does, and of a print."""
    columns = (Interaction("sun", ("sea.diffuse",)), Interaction("sun", ("ice.diffuse",)))
    light = sparse.csr_array(np.array(shares, dtype=float))
    system = LinearSystem(light, columns, height=1, width=len(shares), white={"sun": 1.0})
    spike = np.zeros(36)
    spike[18] = 0.9
    return system, rt.Palette(
        case.hull.bands, {"sun": 1, "sea.diffuse": spike, "ice.diffuse": case.hull.device.samples[40]}
    )


@pytest.mark.parametrize(("shares", "none"), [([[1, 0], [0.8, 0]], True), ([[1, 0], [0, 1]], False)])
def test_where_no_pixel_is_inside_no_value_is_drawn_as_feasible(case, shares, none):
    system, palette = narrow(case, shares)
    asked = {"cap": False, "within": (0.8, 1.5), "progress": False}
    found = rt.feasible(system, palette, case.hull, rt.Scale("sea"), **asked)
    assert found.verdict == "rest-only"
    assert (len(found.unfixable) + len(found.untouched_outside) == found.objects) is none
    ranges = plots.ranges_figure([found], system, palette, case.hull)
    curve = plots.curve_figure(found)
    assert (not ranges.axes[0].patches) is none
    assert (not curve.axes[0].patches) is none
    assert ("no pixel is inside" in words(ranges)) is none
    assert ("No pixel is inside" in words(curve)) is none
    assert ("feasible" in words(curve)) is not none
