"""The reference white: the radiance of a perfect diffuser, and nothing else, is what pixels are divided by."""

import numpy as np
import pytest
from scipy import sparse

from symrt.spectra.bands import RGB, wavelengths
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, whites
from symrt.system import LinearSystem

BANDS = wavelengths(380, 730, 10)


def make_system(**white):
    return LinearSystem(sparse.csr_array((1, 0)), (), 1, 1, white)


def test_the_white_is_the_radiance_of_a_perfect_diffuser_facing_the_light():
    # A directional light of irradiance E gives E/π, a point light of intensity I at distance d gives I/(π d²).
    system = make_system(sun=1 / np.pi, lamp=1 / (np.pi * 2.0**2))
    palette = Palette(BANDS, {"sun": "illuminant/D65", "lamp": 5.0})
    np.testing.assert_allclose(Reference("sun").white(system, palette), palette["sun"] / np.pi, rtol=1e-15)
    np.testing.assert_allclose(Reference("lamp").white(system, palette), 5 / (4 * np.pi), rtol=1e-15)


def test_exposure_leaves_the_white_alone():
    system, palette = make_system(sun=0.5), Palette(RGB, {"sun": [1.0, 2.0, 3.0]})
    np.testing.assert_array_equal(Reference("sun", 4.0).white(system, palette), Reference("sun").white(system, palette))


def test_the_key_light_is_the_first_that_is_neither_ambient_nor_black():
    system = make_system(sky=1.0, dark=1 / np.pi, sun=1 / np.pi, lamp=0.1)
    palette = Palette(RGB, {"sky": 1.0, "dark": 0.0, "sun": 1.0, "lamp": 1.0})
    assert list(whites(system, palette)) == ["sun", "lamp", "sky"]
    np.testing.assert_array_equal(Reference().white(system, palette), Reference("sun").white(system, palette))
    np.testing.assert_array_equal(Reference().white(make_system(sky=1.0), palette), [1.0, 1.0, 1.0])


@pytest.mark.parametrize("name", ["equal-energy", "illuminant/A", "Illuminant/a"])
def test_other_whites_have_the_key_light_s_luminance(name):
    system, palette = make_system(sun=0.3), Palette(BANDS, {"sun": "illuminant/D65"})
    weights = luminance_weights(BANDS)
    white = Reference(name).white(system, palette)
    assert weights @ white == pytest.approx(weights @ Reference().white(system, palette), rel=1e-12)
    assert (np.ptp(white) == 0) == (name == "equal-energy")


@pytest.mark.parametrize("exposure", [0.0, -1.0, float("nan"), float("inf")])
def test_an_exposure_that_is_none_is_refused(exposure):
    with pytest.raises(ValueError, match="it must be above 0"):
        Reference(exposure=exposure)


def test_a_reference_that_is_not_there_or_gives_no_light_is_refused():
    system, palette = make_system(sun=0.3, dark=0.3), Palette(RGB, {"sun": 1.0, "dark": 0.0})
    with pytest.raises(ValueError, match="no light 'son': did you mean 'sun'"):
        Reference("son").white(system, palette)
    with pytest.raises(ValueError, match="'dark' is black"):
        Reference("dark").white(system, palette)
    with pytest.raises(ValueError, match="none of the scene's lights"):
        Reference().white(system, palette.replace(sun=0.0))
