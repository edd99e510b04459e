"""The law of Beer and Lambert against 50-digit arithmetic, and its data against their own statement."""

import json
from dataclasses import replace
from importlib import resources

import mpmath
import numpy as np
import pytest

from symrt.device.dyes import dye_devices
from symrt.device.inks import load_device
from symrt.device.printing import Device, reflectance
from symrt.gamut.basis import uniform_first
from symrt.spectra.bands import RGB, wavelengths
from symrt.spectra.library import spectrum

COLORCHECKER = (
    *("dark skin", "light skin", "blue sky", "foliage", "blue flower", "bluish green", "orange", "purplish blue"),
    *("moderate red", "purple", "yellow green", "orange yellow", "blue", "green", "red", "yellow", "magenta", "cyan"),
    *("white 9.5 (.05 D)", "neutral 8 (.23 D)", "neutral 6.5 (.44 D)", "neutral 5 (.70 D)", "neutral 3.5 (1.05 D)"),
    "black 2 (1.5 D)",
)


@pytest.fixture(scope="module")
def colorchecker():
    bands = wavelengths(380, 730, 10)
    return np.array([spectrum(f"macbeth/{name}", bands, reflectance=True) for name in COLORCHECKER])


@pytest.mark.parametrize("name", dye_devices())
def test_dyes_absorb_by_the_law_of_beer_and_lambert(name):
    device = load_device(name)
    amounts = np.random.default_rng(0).uniform(0, 2.2, (4, 3))
    prints = reflectance(device, amounts)
    with mpmath.workdps(50):
        for one, printed in zip(amounts, prints, strict=True):
            for band in range(36):
                density = sum(
                    mpmath.mpf(c) * mpmath.mpf(d) for c, d in zip(one, device.printer.densities[:, band], strict=True)
                )
                exact = mpmath.mpf("0.004") + (mpmath.mpf("0.9") - mpmath.mpf("0.004")) * mpmath.mpf(10) ** -density
                assert abs(printed[band] - exact) <= 4 * np.spacing(0.9)


def test_the_bare_paper_is_exact():
    for name in dye_devices():
        assert np.all(load_device(name).samples[0] == 0.9)


def test_samples_are_the_grid_of_nine_amounts_of_each_dye():
    device = load_device("dye3-endura-premier")
    assert device.samples.shape == (729, 36)
    assert sorted({float(a) for a in device.amounts.ravel()}) == pytest.approx(np.linspace(0, 2.2, 9))
    np.testing.assert_array_equal(device.samples, reflectance(device, device.amounts))
    assert np.all(device.printer.densities.max(axis=1) == 1)


def test_bands_where_a_dye_was_not_measured_are_flagged():
    extrapolated = load_device("dye3-endura-premier").extrapolated
    nm = np.arange(380, 731, 10)
    assert nm[extrapolated].tolist() == [380, 390, 710, 720, 730]
    assert not load_device("dye3-crystal-archive").extrapolated[:34].any()


def test_the_default_device_holds_19_of_the_24_patches_in_its_envelope_and_24_scaled(colorchecker):
    device = load_device("dye3-endura-premier")
    inside = ((device.black <= colorchecker) & (colorchecker <= device.white)).all(axis=1)
    # Measured when this device was chosen: 19 of 24, and scaling helps all 24.
    assert inside.sum() == 19
    low, high = (device.black / colorchecker).max(axis=1), (device.white / colorchecker).min(axis=1)
    assert np.all(low <= high)


def test_crystal_archive_is_unfit_because_its_darkest_print_reflects_a_third_at_380_nm(colorchecker):
    device = load_device("dye3-crystal-archive")
    # Measured when this device was chosen: 0.35 at 380 nm, none of the 24 patches.
    assert device.black[0] == pytest.approx(0.35, abs=0.005)
    assert not ((device.black <= colorchecker) & (colorchecker <= device.white)).all(axis=1).any()


def test_first_component_of_three_dye_models_is_nearly_constant():
    cosines = [uniform_first(load_device(name).samples).cosine for name in dye_devices()]
    # Measured when these devices were made: 0.89 to 0.94 on three-dye models.
    assert 0.885 < min(cosines) < max(cosines) < 0.945


def test_other_bands_are_interpolated_and_never_extrapolated():
    coarse, fine = (load_device("dye3-endura-premier", wavelengths(400, 700, step)) for step in (20, 5))
    np.testing.assert_allclose(coarse.samples, fine.samples[:, ::4], rtol=1e-12)
    with pytest.raises(ValueError, match="nothing is extrapolated"):
        load_device("dye3-endura-premier", wavelengths(360, 780, 10))
    with pytest.raises(ValueError, match="use wavelengths"):
        load_device("dye3-endura-premier", RGB)


def test_a_misspelt_device_gets_a_suggestion():
    with pytest.raises(ValueError, match=r"'dye3-endura' \(did you mean 'dye3-(portra-endura|endura-premier)'"):
        load_device("dye3-endura")


@pytest.mark.parametrize("amount", [-0.1, 2.21, np.nan])
def test_amounts_that_cannot_be_laid_down_are_refused(amount):
    with pytest.raises(ValueError, match=r"print 0, magenta: the amount .* not in \[0, 2.2\]"):
        reflectance(load_device("dye3-endura-premier"), np.array([[0.0, amount, 1.0]]))


def test_the_device_says_that_it_is_modelled_and_is_not_the_papers_printer():
    for name in dye_devices():
        device = load_device(name)
        assert device.modelled
        assert device.title.startswith("dye-sublimation-like, modelled from")
        assert "8650" not in repr(device) + device.provenance
        assert "spectral-film-lut" in device.provenance


def test_the_table_names_its_source_and_licence():
    table = json.loads(resources.files("symrt.data").joinpath("dye_densities_36.json").read_text("utf-8"))
    assert "MIT" in table["source"]
    for paper in table["papers"].values():
        assert set(paper["density"]) == set(paper["native"]) == {"cyan", "magenta", "yellow"}
        assert all(len(curve) == len(table["wavelengths"]) == 36 for curve in paper["density"].values())


def test_prints_that_are_no_numbers_are_named():
    device = load_device("dye3-endura-premier", wavelengths(400, 700, 100))
    for field, of in (("samples", "500 nm"), ("amounts", "magenta")):
        wrong = getattr(device, field).copy()
        wrong[5, 1] = np.nan
        with pytest.raises(ValueError, match=rf"dye3-endura-premier: (sample|amounts of print) 5, {of}, is nan"):
            replace(device, **{field: wrong})
    rgb = Device(
        "rgb", RGB, np.full((1, 3), 0.5), np.empty((1, 0)), (), np.zeros(3, dtype=bool), "", "", modelled=False
    )
    with pytest.raises(ValueError, match=r"rgb is in RGB, which have no wavelengths"):
        rgb.on(wavelengths(400, 700, 100))
