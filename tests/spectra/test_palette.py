"""Palettes: what they take, what they refuse, and that they never change."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from symrt.spectra.bands import RGB, coordinates, wavelengths
from symrt.spectra.palette import Palette

BANDS = wavelengths(380, 730, 10)


def make_palette(**fields):
    return Palette(BANDS, {"sun": 1.0, "sky": np.linspace(0.5, 2, 36), "sea.diffuse": np.linspace(0, 1, 36)}, **fields)


@pytest.mark.parametrize(
    "value", [0.25, np.float32(0.25), [0.25] * 36, (0.25,) * 36, np.full(36, 0.25), np.full(36, 0.25, np.float32)]
)
def test_numbers_lists_and_arrays_become_one_float64_value_a_band(value):
    spectrum = Palette(BANDS, {"sea.diffuse": value})["sea.diffuse"]
    assert spectrum.dtype == np.float64
    np.testing.assert_array_equal(spectrum, np.full(36, 0.25))


def test_integers_are_spectra_too():
    palette = Palette(RGB, {"sun": 2, "sky": np.array([1, 2, 3]), "sea.diffuse": [0, 1, 1]})
    np.testing.assert_array_equal(palette["sky"], [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(palette["sea.diffuse"], [0.0, 1.0, 1.0])


def test_nothing_in_a_palette_can_be_changed():
    given = np.full(36, 0.5)
    palette = Palette(BANDS, {"sea.diffuse": given})
    given[0] = 0.9
    assert palette["sea.diffuse"][0] == 0.5
    with pytest.raises(ValueError, match="read-only"):
        palette["sea.diffuse"][0] = 0.9
    with pytest.raises(TypeError):
        palette.spectra["sun"] = 1.0
    with pytest.raises(FrozenInstanceError):
        palette.bands = RGB


def test_replacing_leaves_the_first_palette_and_the_other_symbols_alone():
    palette = make_palette()
    other = palette.replace({"sea.diffuse": 0.5}, sun="illuminant/A")
    np.testing.assert_array_equal(palette["sea.diffuse"], np.linspace(0, 1, 36))
    np.testing.assert_array_equal(other["sea.diffuse"], 0.5)
    np.testing.assert_array_equal(other["sky"], palette["sky"])
    assert other["sun"][-1] > other["sun"][0]
    assert list(other) == list(palette)


def test_a_misspelt_replacement_is_not_a_new_symbol():
    with pytest.raises(ValueError, match=r"no 'sea.difuse' \(did you mean 'sea.diffuse'\?\).* use add"):
        make_palette().replace({"sea.difuse": 0.5})
    assert "ice.diffuse" in make_palette().add({"ice.diffuse": 0.9})
    assert make_palette().add(moon=0.1).lights == ("sun", "sky", "moon")


def test_a_dot_makes_a_reflectance():
    palette = make_palette().add({"sea>ice.diffuse": 0.9})
    assert palette.lights == ("sun", "sky")
    assert palette.reflectances == ("sea.diffuse", "sea>ice.diffuse")


def test_the_permission_to_pass_one_is_explicit_and_carried_along():
    with pytest.raises(ValueError, match=r"'sea.diffuse' is 1.5 .*: a reflectance lies in \[0, 1\]; unphysical=True"):
        make_palette().replace({"sea.diffuse": 1.5})
    bold = make_palette(unphysical=True).replace({"sea.diffuse": 1.5})
    assert bold.unphysical
    assert bold.above_one == ("sea.diffuse",)
    assert bold.add(moon=1.0).on(wavelengths(400, 700, 10)).above_one == ("sea.diffuse",)
    with pytest.raises(ValueError, match="lies in"):
        replace(bold, unphysical=False)


def test_perfect_white_and_perfect_black_are_reflectances():
    palette = Palette(RGB, {"a.diffuse": 1.0, "b.diffuse": 0.0})
    assert palette.above_one == ()


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("sea.diffuse", [0.5] * 35, "'sea.diffuse' has 35 values for Bands"),
        ("sea.diffuse", [], "has 0 values"),
        ("sea.diffuse", [0.5] * 10 + [np.nan] + [0.5] * 25, "'sea.diffuse' is nan at 480 nm"),
        ("sun", [1.0] * 35 + [np.inf], "'sun' is inf at 730 nm"),
        ("sea.diffuse", -0.1, "'sea.diffuse' is -0.1 at 380 nm: no spectrum is negative"),
        ("sun", [1.0] * 20 + [-1e-12] + [1.0] * 15, "'sun' is -1e-12 at 580 nm"),
        ("sea.diffuse", [0.5] * 30 + [36.0] * 6, "'sea.diffuse' is 36 .*first above 1 at 680 nm.* percent"),
        ("sea.diffuse", np.nextafter(1.0, 2.0), r"lies in \[0, 1\]"),
        ("sea.diffuse", "macbeth/dark skni", "did you mean macbeth/dark skin"),
        ("sea.diffuse", "illuminant/D65", "is a light, and a reflectance is wanted"),
        ("sun", "macbeth/red", "is a reflectance, and a light is wanted"),
        ("sea.diffuse.more", 0.5, "a symbol is a light's name, or material.component"),
        ("__import__('os')", 0.5, "a symbol is a light's name"),
        ("", 0.5, "a symbol is a light's name"),
        ("sea>.diffuse", 0.5, "a symbol is a light's name"),
    ],
)
def test_what_is_no_spectrum_is_refused_by_name_rule_and_remedy(name, value, reason):
    with pytest.raises(ValueError, match=reason):
        Palette(BANDS, {name: value})


def test_every_fault_is_told_at_once():
    with pytest.raises(ValueError, match="sun") as caught:
        Palette(RGB, {"sun": -1.0, "sea.diffuse": 2.0, "sky": [1.0], "fine": 1.0})
    assert [line.split()[0] for line in str(caught.value).splitlines()] == ["'sun'", "'sea.diffuse'", "'sky'"]


def test_coordinates_are_no_palette():
    with pytest.raises(ValueError, match="their products are wrong"):
        Palette(coordinates(3), {"sun": 1.0})


def test_resampling_agrees_on_shared_wavelengths_and_never_extrapolates():
    palette = make_palette()
    few = palette.on(wavelengths(400, 700, 50))
    np.testing.assert_array_equal(few["sea.diffuse"], palette["sea.diffuse"][2:33:5])
    assert palette.on(BANDS) is palette
    with pytest.raises(ValueError, match=r"'sun' covers 380 … 730 nm, but the bands run from 370 to 730"):
        palette.on(wavelengths(370, 730, 10))
    with pytest.raises(ValueError, match="no spectra to resample"):
        Palette(RGB, {"sun": 1.0}).on(BANDS)
    with pytest.raises(ValueError, match="use wavelengths"):
        palette.on(RGB)


def test_asking_for_a_symbol_that_is_not_there_names_the_nearest():
    with pytest.raises(KeyError, match=r"did you mean 'sea\.diffuse'"):
        make_palette()["sea.difuse"]


def test_a_palette_shows_its_curves_in_a_notebook():
    shown = make_palette()._repr_html_()
    assert shown.count("<polyline") == 3
    assert "sea.diffuse" in shown
    # The first and the last band of a spectrum from 0 to 1 are drawn at the bottom and at the top.
    curve = shown.split("sea.diffuse")[1].split('points="')[1].split('"')[0].split()
    assert curve[0] == "1.0,29.0"
    assert curve[-1] == "119.0,1.0"
