"""Gamuts of slabs: membership, support, nearest, against definitions and linear programmes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from symrt.device.inks import load_device
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.slabs import slab_gamut
from symrt.spectra.bands import wavelengths
from symrt.spectra.display import luminance_weights
from symrt.spectra.library import spectrum

MODELS = [(m, b) for m in ("unit", "envelope") for b in ("clip", "luminance", "strict")]


@pytest.fixture(scope="module")
def device():
    return load_device("dye3-endura-premier")


@pytest.fixture(scope="module")
def spectra():
    random = np.random.default_rng(0)
    return random.uniform(-0.1, 1.1, (300, 36)) * random.uniform(0, 1, (300, 1)) ** 4


@pytest.mark.parametrize(("model", "black"), MODELS)
def test_every_print_of_the_device_is_inside_all_of_its_gamuts(device, model, black):
    gamut = device_gamut(device, model, black)
    assert gamut.contains(device.samples).all()
    assert np.all(gamut.violation(device.samples) == 0)


def test_the_boundary_is_inside_and_one_step_further_is_not(device):
    for model in ("unit", "envelope"):
        gamut = device_gamut(device, model, "strict")
        faces = np.array([gamut.lower, gamut.upper])
        assert gamut.contains(faces).all()
        assert not gamut.contains(np.array([np.nextafter(gamut.lower, -1), np.nextafter(gamut.upper, 2)])).any()


@pytest.mark.parametrize(("model", "black"), MODELS)
def test_support_is_the_optimum_of_a_linear_programme(device, model, black):
    gamut = device_gamut(device, model, black)
    directions = np.random.default_rng(1).normal(size=(20, 36)) - 0.3
    bounds = list(zip(gamut.lower, gamut.upper, strict=True))
    rows = {} if gamut.weights is None else {"A_ub": [-gamut.weights], "b_ub": [-gamut.blackest]}
    for direction, found in zip(directions, gamut.support(directions), strict=True):
        assert found == pytest.approx(-linprog(-direction, bounds=bounds, **rows).fun, rel=1e-7, abs=1e-9)


@pytest.mark.parametrize(("model", "black"), MODELS)
def test_nearest_is_inside_and_no_other_is_nearer(device, spectra, model, black):
    gamut = device_gamut(device, model, black)
    nearest = gamut.nearest(spectra)
    assert gamut.violation(nearest).max() <= 1e-15
    assert np.array_equal(nearest[gamut.contains(spectra)], spectra[gamut.contains(spectra)])
    # The nearest point n of a convex set is the one where support(s - n) = (s - n)·n.
    away = spectra - nearest
    np.testing.assert_allclose(gamut.support(away), (away * nearest).sum(axis=1), rtol=0, atol=1e-9)


def test_black_is_told_from_dark_by_luminance_under_the_light(device):
    gamut = device_gamut(device, "unit", "luminance")
    weights = luminance_weights(device.bands)
    assert gamut.blackest == pytest.approx(min(device.samples @ (weights / weights.sum())))
    red_light = gamut.under(np.linspace(0.1, 2, 36))
    assert red_light.weights.sum() == pytest.approx(1)
    assert red_light.blackest != gamut.blackest
    assert gamut.contains(np.full((2, 36), [[gamut.blackest * 1.001], [gamut.blackest * 0.999]])).tolist() == [
        True,
        False,
    ]


def test_all_24_patches_are_in_the_unit_gamut(device):
    names = ("dark skin", "white 9.5 (.05 D)", "black 2 (1.5 D)", "blue", "yellow")
    patches = np.array([spectrum(f"macbeth/{n}", wavelengths(380, 730, 10), reflectance=True) for n in names])
    assert device_gamut(device, "unit").contains(patches).all()
    assert device_gamut(device, "envelope", "strict").contains(patches).tolist() == [True, False, False, False, True]


def test_coordinate_of_the_neutral_axis_runs_from_0_to_6(device):
    # The paper, §2.1: c_0 in [0, 6] with 36 bands.
    gamut = device_gamut(device, "unit")
    axis = gamut.basis.vectors[:1]
    assert gamut.support(axis)[0] == pytest.approx(6, abs=4 * np.spacing(6.0))
    assert gamut.support(-axis)[0] == 0


def test_unknown_models_are_named(device):
    with pytest.raises(ValueError, match="model = 'hull'"):
        slab_gamut(device, "hull")
    with pytest.raises(ValueError, match="black = 'lift'"):
        slab_gamut(device, "unit", "lift")


def test_prints_of_the_blackest_luminance_are_inside_together_and_alone(device):
    for count in (1, 2, 3, 9):
        few = np.random.default_rng(count).uniform(0.1, 0.9, (count, 36))
        chart = replace(device, samples=few, amounts=np.empty((count, 0)), inks=(), printer=None)
        for model in ("unit", "envelope"):
            gamut = device_gamut(chart, model, "luminance")
            assert gamut.contains(few).all()
            assert all(gamut.contains(one[None])[0] for one in few)
            found = gamut.clip(few, np.random.default_rng(1).normal(size=few.shape))
            assert np.all((found.low <= 0) & (found.high >= 0))


def test_a_white_without_luminance_is_named(device):
    with pytest.raises(ValueError, match="reference white has no luminance: choose another"):
        device_gamut(device, "unit", "luminance").under(np.zeros(36))


def test_the_number_of_components_may_be_numpys(device):
    gamut = device_gamut(device)
    np.testing.assert_array_equal(gamut.slice(np.int64(3)).vectors, gamut.basis.vectors[:3])
    np.testing.assert_array_equal(gamut.shadow(np.int64(2)).vectors, gamut.basis.vectors[:2])
