"""Ranges, fits and boxes where one unit of a scale is a million million times too bright, or too little."""

from functools import cache

import numpy as np
import pytest
from feedback.synthetic import BANDS
from scipy import sparse

from symrt.device import load_device
from symrt.feedback import Exposure, Scale, feasible, fit, safe_box
from symrt.gamut import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
UNIT = device_gamut(DEVICE)
COLUMNS = tuple(Interaction("sun", (f"{name}.diffuse",)) for name in ("ice", "sea"))
COLOURS = Palette(BANDS, {"sun": 1.0, "ice.diffuse": 0.25, "sea.diffuse": 0.5})
SCALES = [Scale("ice"), Scale("sea")]


@cache
def image(size):
    """Two pixels, each lit by one material but for a touch of the other."""
    return LinearSystem(sparse.csr_array([[0.25, size], [size, 0.5]]), COLUMNS, 1, 2, white={"sun": 1.0})


@pytest.mark.parametrize("exposure", [1.0, 1e-3, 1e8])
@pytest.mark.parametrize("size", [1e6, 1e12])
@pytest.mark.parametrize("objective", ["closest", "brightest"])
def test_scales_reach_their_pixels_white_however_small_they_must_be(objective, size, exposure):
    """Ice may be 1 / (0.25 · size), and sea 1 / (0.5 · size), over the exposure; the touch of the other is nothing."""
    question = image(size), COLOURS, device_gamut(DEVICE, "unit"), SCALES
    found = fit(*question, objective=objective, within=(0.0, 3.0), reference=Reference(exposure=exposure))
    expected = {"ice": 4 / size / exposure, "sea": 2 / size / exposure}
    assert found.values == pytest.approx(expected, rel=1e-6)
    assert found.verdict == "complete"


@pytest.mark.parametrize("top", [1e8, 1e14])
@pytest.mark.parametrize("device", ["crt-brainard", "dye3-endura-premier"])
def test_a_range_may_be_long_where_colours_are_weighed(device, top):
    """What rounding amounts to at the far end of the range is not asked for where a pixel ends."""
    gamut = device_gamut(load_device(device, BANDS), "monitor" if device == "crt-brainard" else "colorimetric")
    question = image(0.5), COLOURS, gamut, Exposure()
    short, long = (feasible(*question, within=(0.5, end), progress=False) for end in (90.0, top))
    assert 0.5 < short.high < 90.0
    assert long.high == pytest.approx(short.high, rel=1e-12)


@pytest.mark.parametrize("black", ["clip", "strict"])
@pytest.mark.parametrize("size", [1e6, 1e12])
def test_a_box_has_room_however_small_its_scales_must_be(size, black):
    gamut = device_gamut(DEVICE, "envelope", black)
    found = safe_box(image(size), COLOURS, gamut, SCALES, within=(0.0, 3.0), progress=False)
    for name, factor in (("ice", 4.0), ("sea", 2.0)):
        low, high = found.box[name]
        assert high == pytest.approx(factor * gamut.upper.min() / size, rel=1e-5)
        assert low == pytest.approx(factor * gamut.lower.max() / size, rel=1e-5)
    assert np.isfinite(found.volume)
    assert found.verdict == "complete"


@pytest.mark.parametrize("objective", ["closest", "lexicographic", "brightest", "lightest"])
@pytest.mark.parametrize("within", [(1e-30, 3.0), (0.0, 3.0), (1e-250, 3.0)])
def test_a_range_of_any_number_of_decades_is_searched_to_its_end(objective, within):
    # Closed form: the first pixel reaches white at 2e-27, the second at 2; they share nothing.
    columns = tuple(Interaction("sun", (f"m{k}.diffuse",)) for k in range(2))
    image = LinearSystem(sparse.csr_array([[1e27, 0.0], [0.0, 1.0]]), columns, 1, 2, {"sun": 1.0})
    colours = Palette(BANDS, {"sun": 1.0, "m0.diffuse": 0.5, "m1.diffuse": 0.5})
    options = {"objective": objective, "within": within, "cap": False, "least_luminance": 0, "progress": False}
    found = fit(image, colours, UNIT, [Scale("m0"), Scale("m1")], **options)
    assert found.verdict == "complete"
    assert found.values["m0"] == pytest.approx(2e-27, rel=1e-9)
    assert found.values["m1"] == pytest.approx({"closest": 1.0, "lexicographic": 1.0}.get(objective, 2.0), rel=1e-9)
    assert (found.reasons["m0"].x, found.reasons["m0"].y) == (0, 0)


@pytest.mark.parametrize("kind", ["parallel", "decades"])
@pytest.mark.parametrize("seed", [262, *range(12)])
def test_rows_that_are_parallel_or_span_24_decades_have_a_brightest_image(kind, seed):
    random = np.random.default_rng(seed)
    materials, pixels = int(random.integers(2, 6)), int(random.integers(4, 40))
    if kind == "parallel":
        base = random.uniform(0, 1, (3, materials))
        rows = base[random.integers(0, 3, pixels)] * (1 + 1e-10 * random.normal(size=(pixels, materials)))
    else:
        rows = 10.0 ** random.uniform(-24, 0, (pixels, materials)) * (random.uniform(size=(pixels, materials)) < 0.7)
    names = [f"m{k}" for k in range(materials)]
    columns = tuple(Interaction("sun", (f"{name}.diffuse",)) for name in names)
    image = LinearSystem(sparse.csr_array(rows), columns, 1, pixels, {"sun": 1.0})
    colours = Palette(BANDS, {"sun": 1.0, **{f"{n}.diffuse": 0.5 * random.uniform(0.5, 1, 36) for n in names}})
    options = {"objective": "brightest", "cap": False, "least_luminance": 0, "progress": False}
    found = fit(image, colours, UNIT, [Scale(name) for name in names], **options)
    seen = shade(image, found.palette).values[0]
    assert np.all(seen <= 1)
    # No scale can rise on its own: it stands at the end of its range, or some pixel is as good as white.
    for name in names:
        touched = rows[:, names.index(name)] > 0
        assert found.values[name] >= 3 * (1 - 1e-6) or not touched.any() or seen[touched].max() >= 1 - 1e-6


@pytest.mark.parametrize("seed", [13, 1907])
def test_a_scale_that_hardly_lights_a_pixel_is_not_lowered_for_it(seed):
    # Closed form: each material has a pixel of its own, and lights those of the others by less than a millionth. One
    # was lowered to 0 where others had left its pixel no room that could be told from rounding.
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 6))
    touches = 10.0 ** random.uniform(-30, -1, (count, count))
    rows = np.where(touches > 1e-9, 1e-6 * touches, touches)
    np.fill_diagonal(rows, random.uniform(0.05, 0.3, count))
    names = [f"m{k}" for k in range(count)]
    columns = tuple(Interaction("sun", (f"{name}.diffuse",)) for name in names)
    image = LinearSystem(sparse.csr_array(rows), columns, 1, count, {"sun": 1.0})
    spectra = {f"{name}.diffuse": 0.5 * random.uniform(0.5, 1, 36) for name in names}
    colours = Palette(BANDS, {"sun": 1.0, **spectra})
    options = {"objective": "brightest", "within": (0.0, 1e6), "cap": False, "progress": False}
    found = fit(image, colours, UNIT, [Scale(name) for name in names], **options)
    expected = {name: 1 / (rows[k, k] * spectra[f"{name}.diffuse"].max()) for k, name in enumerate(names)}
    assert found.values == pytest.approx(expected, rel=2e-6)
    assert np.all(shade(image, found.palette).values <= 1)
