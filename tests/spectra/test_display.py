"""What a screen shows, held against colour-science's own route from spectra through XYZ to sRGB."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from symrt.spectra.bands import RGB, Bands, coordinates, wavelengths
from symrt.spectra.display import display_matrix, encode, luminance_weights, of_same_luminance, to_rgb8
from symrt.spectra.image import SpectralImage
from symrt.spectra.library import colour_science, spectrum
from symrt.spectra.viewing import clipped, linear_rgb, to_rgb

colour = colour_science()
BANDS = wavelengths(380, 730, 10)
SHAPE = colour.SpectralShape(380, 730, 10)
CMFS = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(SHAPE)


def derived_srgb():
    """IEC 61966-2-1's primaries and white with the matrix that follows from them, not the one rounded to 4 decimals."""
    space = colour.RGB_COLOURSPACES["sRGB"].copy()
    space.use_derived_transformation_matrices(True)
    return space


def image_of(values, white, bands=BANDS):
    return SpectralImage(np.reshape(values, (1, -1, len(bands))), bands, {} if white is None else {"sun": white})


def xyz_by_colour(radiance, white):
    return (
        colour.sd_to_XYZ(
            colour.SpectralDistribution(radiance / white, SHAPE.wavelengths),
            CMFS,
            colour.SpectralDistribution(white, SHAPE.wavelengths),
            method="Integration",
        )
        / 100
    )


@pytest.mark.parametrize("illuminant", ["D65", "A", "FL2"])
@pytest.mark.parametrize("patch", ["dark skin", "cyan", "white"])
def test_a_picture_is_what_colour_science_makes_of_the_spectrum(illuminant, patch):
    white = spectrum(f"illuminant/{illuminant}", BANDS)
    radiance = 0.5 * white * spectrum(f"macbeth/{patch}", BANDS)
    xyz = xyz_by_colour(radiance, white)
    seen_white = colour.XYZ_to_xy(xyz_by_colour(white, white))
    expected = colour.XYZ_to_RGB(xyz, derived_srgb(), seen_white, "Bradford")
    measured = linear_rgb(image_of(radiance, white))[0, 0]
    np.testing.assert_allclose(measured, expected, rtol=0, atol=1e-12)
    encoded = to_rgb(image_of(radiance, white))[0, 0]
    # The standard's own matrix has 4 decimals, hence the looser comparison.
    published = np.clip(colour.XYZ_to_sRGB(xyz, seen_white, chromatic_adaptation_transform="Bradford"), 0, 1)
    np.testing.assert_allclose(encoded, published, rtol=0, atol=1e-3)


@pytest.mark.parametrize(
    "white", [np.ones(36), spectrum("illuminant/A", BANDS), 1e-3 * spectrum("illuminant/D50", BANDS)]
)
def test_the_reference_white_is_the_screen_s_white(white):
    np.testing.assert_allclose(linear_rgb(image_of(white, white)), 1.0, rtol=0, atol=1e-12)
    assert clipped(image_of(white, white)) == 0.0


def test_macbeth_s_published_srgb_values_come_out():
    # D. Pascale, "RGB coordinates of the Macbeth ColorChecker", BabelColor, 2006: another chart, under D50; ± 10 codes.
    published = {"dark skin": (115, 82, 68), "foliage": (87, 108, 67), "red": (175, 54, 60), "yellow": (231, 199, 31)}
    white = spectrum("illuminant/D65", BANDS)
    for patch, codes in published.items():
        shown = 255 * to_rgb(image_of(white * spectrum(f"macbeth/{patch}", BANDS), white))[0, 0]
        np.testing.assert_allclose(shown, codes, rtol=0, atol=10)


def test_exposure_is_a_factor_on_the_radiances():
    rng = np.random.default_rng(0)
    radiance, white = rng.random(36), rng.random(36) + 0.1
    twice = linear_rgb(image_of(2 * radiance, white))
    np.testing.assert_allclose(linear_rgb(image_of(radiance, white), exposure=2.0), twice, rtol=1e-12)


def test_the_display_is_one_matrix():
    rng = np.random.default_rng(1)
    radiances, white = rng.random((20, 36)), rng.random(36) + 0.1
    np.testing.assert_allclose(
        linear_rgb(image_of(radiances, white))[0], radiances @ display_matrix(BANDS, white), rtol=1e-12, atol=1e-14
    )


def test_rgb_is_scaled_to_the_white_s_luminance_and_keeps_its_colour():
    # ITU-R BT.709-6, item 3.2: luminance of the primaries.
    luminance = np.array([1.0, 0.8, 0.5]) @ [0.2126, 0.7152, 0.0722]
    shown = linear_rgb(image_of([0.5, 0.25, 0.1], np.array([1.0, 0.8, 0.5]), RGB))[0, 0]
    np.testing.assert_allclose(shown, np.array([0.5, 0.25, 0.1]) / luminance, rtol=1e-4)


def test_luminance_is_the_observer_s():
    sd = colour.SpectralDistribution(np.random.default_rng(2).random(36), SHAPE.wavelengths)
    equal = colour.SpectralDistribution(np.ones(36), SHAPE.wavelengths)
    expected = colour.sd_to_XYZ(sd, CMFS, equal, method="Integration")[1] / 100
    np.testing.assert_allclose(luminance_weights(BANDS) @ sd.values, expected, rtol=1e-12)


@pytest.mark.parametrize(
    "bands", [RGB, BANDS, Bands((550.0,)), Bands((380.0, 500.0, 510.0, 700.0)), wavelengths(300, 900, 50)]
)
def test_luminance_of_a_constant_one_is_one(bands):
    assert luminance_weights(bands).sum() == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("name", ["equal-energy", "illuminant/A"])
def test_a_viewing_reference_is_as_bright_as_the_key_light(name):
    white = 0.3 * spectrum("illuminant/D65", BANDS)
    image = image_of(white, white)
    same = of_same_luminance(name, white, BANDS)
    assert luminance_weights(BANDS) @ same == pytest.approx(luminance_weights(BANDS) @ white, rel=1e-12)
    # It has the shape asked for: divided by it, a constant.
    shape = np.ones(36) if name == "equal-energy" else spectrum(name, BANDS)
    np.testing.assert_allclose(same / shape, same[0] / shape[0], rtol=1e-12)
    np.testing.assert_array_equal(linear_rgb(image, white=name), linear_rgb(image, white=same))


def test_one_image_s_white_shows_another_dimmer():
    white = spectrum("illuminant/D65", BANDS)
    dim = image_of(0.25 * white, 0.25 * white)
    np.testing.assert_allclose(linear_rgb(dim), 1.0, rtol=1e-12)
    np.testing.assert_allclose(linear_rgb(dim, white=white), 0.25, rtol=1e-12)


def test_any_light_of_the_scene_can_be_the_reference():
    whites = {"sun": spectrum("illuminant/D65", BANDS), "lamp": 0.5 * spectrum("illuminant/A", BANDS)}
    image = SpectralImage(whites["lamp"].reshape(1, 1, 36), BANDS, whites)
    np.testing.assert_allclose(linear_rgb(image, white="lamp"), 1.0, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(linear_rgb(image, white="sun"), linear_rgb(image))
    assert linear_rgb(image)[0, 0, 0] > linear_rgb(image)[0, 0, 2]
    with pytest.raises(ValueError, match="no light 'lmap': did you mean 'lamp'"):
        linear_rgb(image, white="lmap")


def test_a_single_band_is_shown_as_grey():
    image = image_of([0.0, 1.0, 2.0], np.array([2.0]), Bands((700.0,)))
    np.testing.assert_allclose(linear_rgb(image)[0], [[0.0] * 3, [0.5] * 3, [1.0] * 3], rtol=1e-12)


def test_a_white_without_blue_is_not_adapted_to_with_infinite_gains():
    red = wavelengths(620, 700, 10)
    with pytest.raises(ValueError, match="too saturated"):
        linear_rgb(image_of(np.ones(9), np.ones(9), red))


def test_what_a_screen_cannot_show_is_counted():
    values = np.array([[0.2, 0.2, 0.2], [1.0, 1.0, 1.0], [1.1, 0.5, 0.5], [0.5, 0.5, 2.0]])
    assert clipped(image_of(values, np.ones(3), RGB)) == 0.5
    green = image_of(np.exp(-(((np.array(BANDS.centres) - 520) / 10) ** 2)), np.ones(36))
    assert linear_rgb(green).min() < 0
    assert clipped(green) == 1.0
    assert to_rgb(green).min() == 0.0


@given(st.floats(-0.5, 1.5))
def test_encoding_is_the_standard_s_and_its_table_rounds_to_the_nearest_code(x):
    linear = np.array([[x, x, x]])
    expected = colour.models.eotf_inverse_sRGB(np.clip(linear, 0, 1))
    # colour decodes the straight part's end from 0.04045, the standard states 0.0031308: they meet within 3e-8.
    np.testing.assert_allclose(encode(linear), expected, rtol=0, atol=1e-7)
    np.testing.assert_array_equal(to_rgb8(linear), np.rint(255 * encode(linear)).astype(np.uint8))


def test_every_code_is_reached_and_every_threshold_is_on_its_side():
    codes = np.arange(256) / 255
    linear = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    np.testing.assert_array_equal(to_rgb8(np.stack([linear] * 3, axis=1))[:, 0], np.arange(256))
    dense = np.linspace(0, 1, 400_002).reshape(-1, 3)
    np.testing.assert_array_equal(to_rgb8(dense), np.rint(255 * encode(dense)).astype(np.uint8))


@pytest.mark.parametrize(
    ("act", "reason"),
    [
        (lambda: to_rgb(image_of(np.ones(5), None, coordinates(5))), "basis coordinates"),
        (lambda: to_rgb(image_of(np.ones(36), None)), "no light shines"),
        (lambda: to_rgb(image_of(np.ones(36), np.zeros(36))), "no luminance"),
        (lambda: to_rgb(image_of(np.ones(36), np.ones(36)), exposure=0.0), "above 0"),
        (lambda: to_rgb(image_of(np.ones(36), np.ones(36)), exposure=float("nan")), "above 0"),
        (lambda: to_rgb(image_of(np.ones(36), np.ones(36)), white="illuminant/D66"), "did you mean illuminant/D65"),
        (lambda: luminance_weights(wavelengths(1000, 1100, 10)), "all invisible"),
        (lambda: luminance_weights(coordinates(3)), "have no colour"),
    ],
)
def test_what_cannot_be_shown_says_why(act, reason):
    with pytest.raises(ValueError, match=reason):
        act()


def test_the_colour_library_leaves_no_trace_in_numpy_or_warnings():
    code = (
        "import numpy as np, warnings, sys\n"
        "import symrt.spectra.shading, symrt.spectra.palette, symrt.spectra.display, symrt.spectra.library\n"
        # SciPy, imported by now, has a filter of its own.
        "before, filters = np.get_printoptions(), list(warnings.filters)\n"
        "assert 'colour' not in sys.modules, 'imported before it is needed'\n"
        "from symrt.spectra.bands import wavelengths\n"
        "symrt.spectra.library.spectrum('macbeth/red', wavelengths(400, 700, 10))\n"
        "symrt.spectra.display.display_matrix(wavelengths(400, 700, 10), np.ones(31))\n"
        "assert 'colour' in sys.modules\n"
        "assert np.get_printoptions() == before, np.get_printoptions()\n"
        "assert list(warnings.filters) == filters, warnings.filters\n"
        "assert str(np.array([0.1, 1.0])) == '[0.1 1. ]'\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
