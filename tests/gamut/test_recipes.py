"""What inks really print, against the printer's own prints and a general optimiser."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from symrt.device import fit_halftone, load_device, reflectance
from symrt.gamut import device_gamut
from symrt.gamut.hull import HullGamut
from symrt.gamut.recipes import ink_gamut, recipes
from symrt.spectra.bands import wavelengths
from symrt.spectra.library import names, spectrum

BANDS = wavelengths(400, 700, 20)


@pytest.fixture(scope="module", params=["dye3-endura-premier", "synthetic-cmyk"])
def device(request):
    return load_device(request.param, BANDS)


def random_amounts(device, count, seed=0):
    return np.random.default_rng(seed).uniform(0, device.printer.most, (count, len(device.inks)))


def test_a_recipe_is_found_for_everything_that_is_printed(device):
    amounts = random_amounts(device, 100)
    # Some with inks at their bounds.
    amounts[:30] = np.where(np.random.default_rng(1).uniform(size=(30, 1)) < 0.5, 0, amounts[:30])
    amounts[10:40, 0] = device.printer.most
    prints = reflectance(device, amounts)
    found, printed = recipes(device, prints)
    assert ink_gamut(device, 1e-6).contains(prints).all()
    np.testing.assert_array_equal(reflectance(device, found), printed)


def test_three_dyes_have_one_recipe_for_each_print():
    device = load_device("dye3-endura-premier", BANDS)
    amounts = random_amounts(device, 50)
    np.testing.assert_allclose(recipes(device, reflectance(device, amounts))[0], amounts, atol=1e-4)


def test_no_recipe_comes_nearer_by_another_optimiser_from_other_starts(device):
    patches = np.array([spectrum(name, BANDS) for name in names() if name.startswith("macbeth/")])[::4]
    ours = ink_gamut(device).distance(patches)
    draw = np.random.default_rng(2)
    for patch, distance in zip(patches, ours, strict=True):
        tried = [
            least_squares(
                lambda a, wanted=patch: device.printer.printed(a[None])[0] - wanted,
                draw.uniform(0.1, 0.9, len(device.inks)) * device.printer.most,
                bounds=(0, device.printer.most),
                xtol=1e-12,
            )
            for _ in range(5)
        ]
        assert distance <= min(np.sqrt(2 * t.cost / len(BANDS)) for t in tried) + 1e-7


def test_a_yes_comes_with_its_proof(device):
    gamut = ink_gamut(device, 0.02)
    prints = reflectance(device, random_amounts(device, 60, seed=3))
    spectra = prints + np.random.default_rng(4).normal(0, 1, prints.shape) * np.linspace(0, 0.05, 60)[:, None]
    inside = gamut.contains(spectra)
    assert 5 < inside.sum() < 60
    printed = reflectance(device, recipes(device, spectra)[0])
    assert np.sqrt(np.mean((printed - spectra)[inside] ** 2, axis=1)).max() <= 0.02 + 1e-9
    np.testing.assert_array_equal(gamut.violation(spectra) == 0, inside)


def test_mixtures_of_prints_need_not_be_prints(device):
    ends = reflectance(device, np.eye(len(device.inks))[:2] * device.printer.most)
    middle = ends.mean(axis=0, keepdims=True)
    assert HullGamut(device, 0.001, 0.0, 0.0).contains(middle).all()
    assert not ink_gamut(device, 0.001).contains(middle).any()


def test_a_line_may_enter_more_than_once(device):
    first, last = reflectance(device, np.eye(len(device.inks))[:2] * device.printer.most)
    gamut = ink_gamut(device, 0.01)
    intervals = gamut.clip(first[None], (last - first)[None])
    assert len(intervals[0]) == 2
    assert (intervals[0][0][0], intervals[0][1][1]) == (0, 1)
    for t in (intervals[0][0][1], intervals[0][1][0]):
        into_the_gap = 1e-5 if t < 0.5 else -1e-5
        assert gamut.contains((first + t * (last - first))[None]).all()
        assert not gamut.contains((first + (t + into_the_gap) * (last - first))[None]).any()
    never = gamut.clip(np.full((1, len(BANDS)), 1.5), np.full((1, len(BANDS)), 0.1))
    assert never == [[]]


def test_the_verdict_says_what_it_proves(device):
    gamut = device_gamut(device, "inks", tolerance=0.02)
    assert gamut.tolerance == 0.02
    assert "sufficient, within the fit of the printer's model, not necessary" in repr(gamut)
    for tolerance in (0, np.inf, np.nan):
        with pytest.raises(ValueError, match=f"tolerance = {tolerance}"):
            ink_gamut(device, tolerance)
    for within in ((1.0, 0.0), (0.0, np.inf), (np.nan, 1.0)):
        with pytest.raises(ValueError, match=r"within = \(.*\): give a finite range, the lower end first"):
            gamut.clip(device.samples[:1], device.samples[1:2], within)
    with pytest.raises(ValueError, match="fit a model to them with fit_halftone"):
        ink_gamut(replace(device, printer=None))


def test_a_fitted_chart_has_recipes():
    press = load_device("synthetic-cmyk", BANDS)
    few = np.random.default_rng(6).permutation(len(press.samples))[:150]
    chart = replace(press, samples=press.samples[few], amounts=press.amounts[few], printer=None, modelled=False)
    gamut = ink_gamut(fit_halftone(chart).device, 1e-3)
    assert gamut.contains(press.samples[::50]).all()


def test_a_tolerance_below_the_models_own_error_proves_nothing():
    # A halftone printer stands for dyes, which it tells to a few percent at best: prints held out show it.
    dyes = load_device("dye3-endura-premier", BANDS)
    chart = replace(dyes, amounts=dyes.amounts / dyes.printer.most, printer=None, modelled=False)
    fitted = fit_halftone(chart)
    assert fitted.held_out == fitted.device.model_error > 0.002
    assert fitted.held_out >= np.percentile(
        np.sqrt(np.mean((fitted.printer.printed(chart.amounts) - chart.samples) ** 2, axis=1)), 90
    )
    strict, lax = (ink_gamut(fitted.device, share * fitted.held_out) for share in (0.5, 2.0))
    assert strict.label.startswith("neither sufficient nor necessary")
    assert f"{fitted.held_out:.4f}" in repr(strict)
    assert lax.label.startswith("sufficient")
