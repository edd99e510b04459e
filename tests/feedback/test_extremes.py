"""Ranges, fits and boxes where one unit of a scale is a million million times too bright, or too little."""

from functools import cache

import numpy as np
import pytest
from feedback.synthetic import BANDS
from scipy import sparse

from symrt.device import load_device
from symrt.feedback import Exposure, Scale, feasible, fit, safe_box
from symrt.gamut import device_gamut
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import Interaction, LinearSystem

DEVICE = load_device("dye3-endura-premier")
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
