"""Bands and tables of spectra: what is refused, and linear interpolation against exact rationals."""

from fractions import Fraction

import numpy as np
import pytest

from symrt.spectra.bands import RGB, Bands, coordinates, resample, wavelengths


def test_thirty_six_bands_run_from_380_to_730_nm():
    # The paper, §2.1: a 10 nm sampling gives 36 values across the visible spectrum.
    bands = wavelengths(380, 730, 10)
    assert len(bands) == 36
    assert bands.centres == tuple(map(float, range(380, 731, 10)))
    assert bands.labels[0] == "380 nm"


def test_fractional_steps_are_whole_in_number():
    assert wavelengths(400.0, 401.0, 0.1).centres[7] == pytest.approx(400.7, abs=1e-12)
    assert len(wavelengths(400.0, 401.0, 0.1)) == 11


def test_widths_tile_the_axis():
    np.testing.assert_array_equal(wavelengths(380, 730, 10).widths, 10.0)
    np.testing.assert_array_equal(Bands((400.0, 410.0, 440.0)).widths, [10.0, 20.0, 30.0])
    np.testing.assert_array_equal(Bands((400.0,)).widths, [1.0])
    np.testing.assert_array_equal(RGB.widths, 1.0)


def test_bands_are_equal_when_their_centres_are():
    assert wavelengths(400, 420, 10) == Bands((400.0, 410.0, 420.0))
    assert len({wavelengths(400, 420, 10), Bands((400.0, 410.0, 420.0)), RGB, coordinates(3)}) == 3


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ((380, 735, 10), "735 is not a whole number of steps"),
        ((730, 380, 10), "first <= last"),
        ((380, 730, 0), "a step above 0"),
        ((380, 730, -10), "a step above 0"),
        ((380, float("nan"), 10), "first <= last"),
        ((0.38, 0.73, 0.01), r"wavelengths 0\.38 … 0\.73 look like micrometres: multiply by 1000"),
        ((380e-9, 730e-9, 10e-9), "wavelengths 3.8e-07 … 7.3e-07 look like metres: multiply by 1e9"),
        ((3800, 7300, 100), r"3800 nm is not in \[100, 3000\]"),
        ((380, 730, 1e-9), "not a whole number of steps"),
    ],
)
def test_steps_that_make_no_bands_are_refused(arguments, reason):
    with pytest.raises(ValueError, match=reason):
        wavelengths(*arguments)


@pytest.mark.parametrize(
    ("nm", "reason"),
    [
        ([0.38, 0.55, 0.73], "micrometres"),
        ([500.0, 400.0, 600.0], "500 nm comes before 400 nm: wavelengths must increase"),
        ([400.0, 500.0, 500.0], "500 nm appears twice"),
        ([400.0, np.nan, 600.0], "wavelength nan"),
        ([400.0, 500.0, np.inf], "wavelength inf"),
        ([], "no "),
    ],
)
def test_wavelengths_that_are_not_increasing_nanometres_are_refused(nm, reason):
    with pytest.raises(ValueError, match=reason):
        Bands(tuple(nm))
    with pytest.raises(ValueError, match=reason):
        resample(np.array(nm, dtype=float), np.ones(len(nm)), wavelengths(450, 550, 50), "gold")


@pytest.mark.parametrize("edges", [(391, 730), (380, 729), (400, 700)])
def test_nothing_is_extrapolated(edges):
    nm = np.array(edges, dtype=float)
    with pytest.raises(
        ValueError, match=rf"gold covers {edges[0]} … {edges[1]} nm, but the bands run from 380 to 730 nm"
    ):
        resample(nm, np.ones(2), wavelengths(380, 730, 10), "gold")


def test_wavelengths_do_not_become_rgb_unasked():
    with pytest.raises(ValueError, match="use wavelengths"):
        resample(np.array([400.0, 700.0]), np.ones(2), RGB, "gold")


def test_interpolation_is_linear_as_in_exact_rationals():
    rng = np.random.default_rng(0)
    for _ in range(200):
        nm = np.unique(rng.uniform(380, 730, 12))
        values = rng.random(nm.size)
        at = float(rng.uniform(nm[0], nm[-1]))
        i = int(np.searchsorted(nm, at, side="right")) - 1
        share = (Fraction(at) - Fraction(nm[i])) / (Fraction(nm[i + 1]) - Fraction(nm[i]))
        exact = Fraction(values[i]) + share * (Fraction(values[i + 1]) - Fraction(values[i]))
        assert resample(nm, values, Bands((at,)))[0] == pytest.approx(float(exact), rel=1e-12, abs=1e-15)


def test_a_table_on_the_bands_themselves_is_returned_bit_for_bit():
    bands = wavelengths(380, 730, 10)
    values = np.random.default_rng(1).random(36)
    np.testing.assert_array_equal(resample(np.array(bands.centres), values, bands), values)


def test_a_step_stays_between_its_sides():
    # colour's Sprague interpolation overshoots to -0.09 and 1.09 here; a reflectance must not.
    values = np.array([0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
    fine = resample(np.arange(400.0, 460.0, 10.0), values, wavelengths(400, 450, 1))
    assert fine.min() == 0.0
    assert fine.max() == 1.0
