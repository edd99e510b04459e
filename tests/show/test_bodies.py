"""Gamuts of every model are drawn as what they are, and the sizes written on them are right."""

import re
from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection, PolyCollection
from matplotlib.text import Text
from scipy.spatial import ConvexHull

import symrt as rt
from symrt.device.colorimetry import tristimulus
from symrt.show import plots
from symrt.spectra.display import display_matrix, encode

MODELS = {
    "unit": "dye3-endura-premier",
    "envelope": "dye3-endura-premier",
    "hull": "dye3-endura-premier",
    "inks": "synthetic-cmyk",
    "colorimetric": "dye3-endura-premier",
    "monitor": "crt-brainard",
}


def gamut(model):
    return rt.device_gamut(rt.load_device(MODELS[model]), model)


def texts(figure):
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    return [(text.get_text(), Text.get_window_extent(text, canvas.get_renderer())) for text in shown]


@pytest.mark.parametrize("model", MODELS)
def test_each_model_is_drawn_named_and_legible(model):
    figure, asked = plots.body_figure(gamut(model)), gamut(model)
    shown = texts(figure)
    said = " ".join(text for text, _ in shown).replace("\n", " ")
    assert asked.name in said
    assert asked.label in said
    width, height = figure.canvas.get_width_height()
    for text, box in shown:
        assert 0 <= box.x0 < box.x1 <= width, text
        assert 0 <= box.y0 < box.y1 <= height, text
    for (one, a), (other, b) in combinations(shown, 2):
        assert a.x1 <= b.x0 or b.x1 <= a.x0 or a.y1 <= b.y0 or b.y1 <= a.y0, (one, other)


@pytest.mark.parametrize("model", ["hull", "inks"])
def test_every_print_is_a_dot_in_its_own_colour(model):
    asked = gamut(model)
    samples = asked.device.samples
    expected = encode(samples @ display_matrix(asked.bands, np.ones(36)))
    for axes in plots.prints_figure(asked).axes[:2]:
        dots = next(c for c in axes.collections if isinstance(c, PathCollection))
        drawn = dots.get_facecolor()[:, :3]
        np.testing.assert_allclose(np.sort(drawn.sum(axis=1)), np.sort(expected.sum(axis=1)), rtol=1e-12)


def xyz_of(lab, white):
    """Back from L*a*b*, by CIE 15:2018, 8.2.1.3."""
    f = np.stack([(lab[:, 0] + 16) / 116] * 3, axis=1)
    f[:, 0] += lab[:, 1] / 500
    f[:, 2] -= lab[:, 2] / 200
    return white * np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29))


@pytest.mark.parametrize("model", ["colorimetric", "monitor"])
def test_the_size_of_a_solid_of_colours_is_what_random_colours_measure(model):
    asked = gamut(model)
    title = next(text for text, _ in texts(plots.colours_figure(asked)) if "cubic units" in text)
    written = float(re.search(r"[\d,]+", title)[0].replace(",", ""))
    low, high = np.array([0, -130, -130]), np.array([100, 130, 130])
    lab = np.random.default_rng(2).uniform(low, high, (200_000, 3))
    if model == "monitor":
        primaries = asked.monitor.primaries
        drive = np.linalg.solve(primaries, xyz_of(lab, primaries.sum(axis=1)).T)
        inside = ((drive >= 0) & (drive <= 1)).all(axis=0)
    else:
        xyz = xyz_of(lab, tristimulus(asked.bands, asked.light).sum(axis=0))
        # What is drawn is the solid of the prints themselves, without the tolerance around it.
        faces = ConvexHull(asked.device.samples @ asked.observer).equations
        inside = (xyz @ faces[:, :3].T + faces[:, 3] <= 0).all(axis=1)
    # Four standard deviations, and 1 % for the pieces that a curved side is cut into.
    share = inside.mean()
    error = 4 * np.sqrt(share * (1 - share) / len(lab)) / share + 0.01
    assert written == pytest.approx(share * np.prod(high - low), rel=error)


def test_colours_are_drawn_where_their_lab_is():
    asked = gamut("monitor")
    above = plots.colours_figure(asked).axes[1]
    corners = np.vstack([path.vertices for path in above.collections[0].get_paths()])
    assert isinstance(above.collections[0], PolyCollection)
    drive = np.array(np.meshgrid([0.0, 1], [0, 1], [0, 1])).reshape(3, 8).T
    primaries = asked.monitor.primaries
    for colour in drive[1:]:
        y = primaries @ colour / primaries.sum(axis=1)
        f = np.where(y > (6 / 29) ** 3, np.cbrt(y), y / (3 * (6 / 29) ** 2) + 4 / 29)
        place = np.array([500 * (f[0] - f[1]), 200 * (f[1] - f[2])])
        assert np.abs(corners - place).max(axis=1).min() < 1e-6


def test_what_several_gamuts_share_is_drawn_as_large_as_it_is():
    device = rt.load_device("dye3-endura-premier")
    parts = [rt.device_gamut(device, model) for model in ("unit", "envelope")]
    both, first = (
        float(text.split()[-1]) for text, _ in texts(plots.body_figure(rt.intersection(parts))) if "volume" in text
    )
    # The envelope lies in the unit gamut; three digits are written.
    assert first == pytest.approx(parts[0].shadow(3).polyhedron().volume, rel=0.01)
    assert both == pytest.approx(parts[1].shadow(3).polyhedron().volume, rel=0.01)
    assert both < first


def test_a_monitor_of_rgb_has_no_figure():
    with pytest.raises(ValueError, match="nothing to draw"):
        plots.body_figure(rt.device_gamut(rt.load_device("srgb"), "monitor"))
