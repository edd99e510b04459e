"""Monitors against mixtures of their own primaries, linear programmes and a general optimiser."""

import numpy as np
import pytest
from scipy.optimize import linprog, minimize

from symrt.device.inks import load_device
from symrt.device.monitors import load_monitor, monitors
from symrt.gamut.monitor import monitor_gamut
from symrt.spectra.bands import RGB, Bands, wavelengths
from symrt.spectra.library import colour_science, display_primaries, spectrum

DRAW = np.random.default_rng(0)
SPECTRAL = [name for name in monitors() if name != "srgb"]
TABLES = {"crt-brainard": "Typical CRT Brainard 1997", "apple-studio-display": "Apple Studio Display"}


@pytest.fixture(scope="module", params=monitors())
def gamut(request):
    return monitor_gamut(load_monitor(request.param))


def draws(gamut, count=50):
    return DRAW.uniform(0, 1.2, (count, len(gamut.bands)))


@pytest.mark.parametrize("name", SPECTRAL)
def test_what_the_primaries_mix_has_the_drive_values_of_the_mixture(name):
    nm, primaries = display_primaries(TABLES[name])
    monitor = load_monitor(name, Bands(tuple(nm.tolist())))
    amounts = DRAW.uniform(0, 1, (20, 3))
    gamut = monitor_gamut(monitor)
    # One exposure makes the white of all three primaries as bright as the reference, whose luminance is 1.
    white = gamut.driven(primaries.sum(axis=0, keepdims=True))[0, 0]
    np.testing.assert_allclose(gamut.driven(amounts @ primaries) / white, amounts, rtol=1e-9)
    assert gamut.contains(amounts @ primaries / white).all()
    assert not gamut.contains((amounts + np.array([1, 0, 0])) @ primaries / white).any()


@pytest.mark.parametrize("name", SPECTRAL)
def test_colours_of_the_primaries_are_those_of_colour_science(name):
    colour = colour_science()
    nm, primaries = display_primaries(TABLES[name])
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    functions = np.stack([np.interp(nm, observer.wavelengths, column) for column in observer.values.T])
    xyz = functions @ primaries.T
    ours = load_monitor(name).primaries
    # Sums every 5 nm against ours every 1 nm: phosphors have lines.
    np.testing.assert_allclose(ours / ours.sum(axis=0), xyz / xyz.sum(axis=0), atol=2e-3)
    assert ours[1].sum() == pytest.approx(1, rel=1e-12)


def test_the_white_of_an_image_is_not_divided_out():
    bands = wavelengths(380, 730, 10)
    gamut = monitor_gamut(load_monitor("crt-brainard", bands))
    grey = np.full((1, 36), 0.5)
    daylight, lamp = (gamut.under(spectrum(f"illuminant/{name}", bands)) for name in ("D65", "A"))
    # A grey keeps its luminance under any light, and takes the light's colour: redder under a lamp than by day.
    assert lamp.driven(grey)[0, 0] > 1 > daylight.driven(grey)[0, 0]
    assert not lamp.contains(grey)[0]
    assert daylight.contains(grey)[0]
    np.testing.assert_allclose(daylight.driven(grey), gamut.under(7 * spectrum("illuminant/D65", bands)).driven(grey))


def test_nearest_is_inside_and_no_other_optimiser_comes_nearer(gamut):
    spectra = draws(gamut, 12)
    nearest = gamut.nearest(spectra)
    assert gamut.contains(nearest).all()
    inside = gamut.contains(spectra)
    np.testing.assert_allclose(nearest[inside], spectra[inside], atol=1e-12)
    limits = [
        {"type": "ineq", "fun": lambda r: gamut.drive @ r},
        {"type": "ineq", "fun": lambda r: 1 - gamut.drive @ r},
    ]
    for spectrum_, ours in zip(spectra, nearest, strict=True):
        found = minimize(
            lambda r, target=spectrum_: np.sum((r - target) ** 2),
            ours * 0.9,
            jac=lambda r, target=spectrum_: 2 * (r - target),
            constraints=limits,
            method="SLSQP",
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert np.sum((ours - spectrum_) ** 2) <= found.fun * (1 + 1e-6) + 1e-9


def test_clip_agrees_with_a_linear_programme(gamut):
    origin, direction = draws(gamut, 20), DRAW.normal(0, 1, (20, len(gamut.bands)))
    found = gamut.clip(origin, direction)
    for o, d, a, b in zip(origin, direction, found.low, found.high, strict=True):
        rate, start = gamut.drive @ d, gamut.drive @ o
        rows, bounds = np.concatenate([rate, -rate])[:, None], np.concatenate([1 - start, start])
        ends = [linprog([sign], rows, bounds, bounds=[(None, None)]) for sign in (1, -1)]
        if ends[0].status == 2:
            assert (a, b) == (np.inf, -np.inf)
            continue
        assert (a, b) == pytest.approx((ends[0].x[0], ends[1].x[0]), rel=1e-9, abs=1e-12)
        for t in (a, b):
            point = (o + t * d)[None]
            assert gamut.violation(point)[0] <= 1e-12
            assert not gamut.contains(point + 1e-6 * np.sign(t - (a + b) / 2) * d)[0]


def test_support_is_finite_where_colour_alone_decides(gamut):
    along = DRAW.normal(0, 1, (10, 3))
    support = gamut.support(along @ gamut.drive)
    np.testing.assert_allclose(support, along.clip(min=0).sum(axis=1), rtol=1e-9)
    corners = np.array(np.meshgrid(*[[0.0, 1.0]] * 3)).reshape(3, -1)
    np.testing.assert_allclose(support, (along @ corners).max(axis=1), rtol=1e-9)
    if len(gamut.bands) > 3:
        assert gamut.support(DRAW.normal(0, 1, (1, len(gamut.bands))))[0] == np.inf


def test_srgb_is_the_unit_cube_of_images_in_rgb():
    gamut = monitor_gamut(load_monitor("srgb"))
    colours = np.array([[0, 0, 0], [1, 1, 1], [1, 0, 0], [1.001, 0, 0], [0.5, -0.001, 0.5]])
    np.testing.assert_array_equal(gamut.contains(colours), [True, True, True, False, False])
    # Y of red is 0.2126: a red light of that luminance is shown as bright as white, which red alone is not.
    red = gamut.under(np.array([1.0, 0, 0]))
    assert red.driven(np.ones((1, 3)))[0, 0] == pytest.approx(1 / 0.2126, rel=1e-3)


def test_monitors_and_bands_that_do_not_go_together_are_named():
    with pytest.raises(ValueError, match=r"crt-brainard shows spectra, not RGB: choose 'srgb', or a palette in wave"):
        load_monitor("crt-brainard", RGB)
    with pytest.raises(ValueError, match="crt-brainard shows spectra, not RGB"):
        load_device("crt-brainard", RGB)
    with pytest.raises(ValueError, match="span no three colours"):
        monitor_gamut(load_monitor("crt-brainard", Bands((450.0, 550.0))))
    with pytest.raises(ValueError, match="has no luminance"):
        monitor_gamut(load_monitor("crt-brainard")).under(np.zeros(36))


def test_srgb_shows_spectra_as_colour_science_converts_them_to_srgb():
    # IEC 61966-2-1 rounds its matrix to four digits: 5e-4 is what that can make of drive values around 1.
    bands = wavelengths(380, 780, 5)
    monitor = load_monitor("srgb", bands)
    assert load_device("srgb").on(bands).primaries.tolist() == monitor.primaries.tolist()
    assert load_monitor("srgb").bands == RGB
    light = spectrum("illuminant/D65", bands)
    seen = monitor_gamut(monitor).under(light)
    reflectances = DRAW.uniform(0, 1, (30, len(bands)))
    colour = colour_science()
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(colour.SpectralShape(380, 780, 5))
    xyz = [
        colour.sd_to_XYZ(
            colour.SpectralDistribution(dict(zip(bands.centres, row, strict=True))),
            illuminant=colour.SpectralDistribution(dict(zip(bands.centres, light, strict=True))),
            cmfs=observer,
            method="Integration",
        )
        for row in reflectances
    ]
    wanted = colour.XYZ_to_RGB(
        np.array(xyz) / 100, "sRGB", apply_cctf_encoding=False, chromatic_adaptation_transform=None
    )
    np.testing.assert_allclose(seen.driven(reflectances), wanted, atol=5e-4)
    np.testing.assert_array_equal(seen.contains(reflectances), ((wanted >= 0) & (wanted <= 1)).all(axis=1))
