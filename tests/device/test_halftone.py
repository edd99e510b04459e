"""The model of Yule, Nielsen and Neugebauer against brute force, closed forms and 50 digits, and its fit to charts.

All charts here are synthetic: made by the model itself, with noise or without.  How well the model tells a real press
is for the fit to report, chart by chart.
"""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise, product

import mpmath
import numpy as np
import pytest

from symrt.device.colorimetry import tristimulus
from symrt.device.fitting import fit_halftone
from symrt.device.halftone import Halftone, demichel, synthetic_devices
from symrt.device.inks import load_device
from symrt.device.printing import Device, reflectance
from symrt.gamut.accuracy import basis_report
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.bands import wavelengths
from symrt.spectra.library import colour_science

BANDS = wavelengths(400, 700, 50)


def printer(inks, exponent=2.0, gain=0.0, seed=0):
    primaries = np.random.default_rng(seed).uniform(0.02, 0.9, (2**inks, len(BANDS)))
    return Halftone(BANDS, tuple("CMYKOGVR"[:inks]), primaries, exponent, np.full(inks, gain))


def chart(made_by, prints=120, noise=0.0, seed=1):
    draw = np.random.default_rng(seed)
    inks = len(made_by.inks)
    solids = np.array(list(product([0.0, 1.0], repeat=inks)))
    amounts = np.vstack([solids, draw.uniform(0, 1, (prints, inks))])
    samples = made_by.printed(amounts) + draw.normal(0, noise, (len(amounts), len(made_by.bands)))
    blank = np.zeros(len(made_by.bands), dtype=bool)
    return Device("chart", made_by.bands, samples, amounts, made_by.inks, blank, "made up", "made up", modelled=False)


@pytest.mark.parametrize("inks", range(1, 9))
def test_demichel_shares_are_those_of_all_subsets_of_inks(inks):
    coverage = np.random.default_rng(inks).uniform(0, 1, (3, inks))
    shares = demichel(coverage)
    assert shares.shape == (3, 2**inks)
    for row, covered in enumerate(coverage):
        exact = [Fraction(c) for c in covered]
        for subset in range(2**inks):
            share = Fraction(1)
            for ink, c in enumerate(exact):
                share *= c if subset >> ink & 1 else 1 - c
            assert abs(Fraction(shares[row, subset]) - share) <= share * Fraction(2 * inks, 2**53)
    np.testing.assert_allclose(shares.sum(axis=1), 1, rtol=1e-14)


def test_solid_overprints_print_the_primaries():
    for exponent in (1.0, 1.7, 50.0, np.inf):
        made_by = printer(3, exponent, gain=0.1)
        solids = np.array([[s & 1, s >> 1 & 1, s >> 2 & 1] for s in range(8)], dtype=float)
        np.testing.assert_allclose(made_by.printed(solids), made_by.primaries, rtol=1e-13)


def test_one_ink_that_does_not_spread_is_murray_and_davies():
    made_by = printer(1, exponent=1.0)
    amounts = np.linspace(0, 1, 11)[:, None]
    paper, solid = made_by.primaries
    # A. Murray, "Monochrome reproduction in photoengraving", J. Franklin Institute 221, 1936.
    np.testing.assert_allclose(made_by.printed(amounts), (1 - amounts) * paper + amounts * solid, rtol=1e-14)


@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0, 10.0])
def test_the_model_is_its_formula_to_50_digits(exponent):
    made_by = printer(4, exponent, gain=0.05)
    amounts = np.random.default_rng(3).uniform(0, 1, (5, 4))
    with mpmath.workdps(50):
        n = mpmath.mpf(exponent)
        for row, printed in zip(amounts, made_by.printed(amounts), strict=True):
            covered = [
                a + 4 * mpmath.mpf(g) * a * (1 - a) for a, g in zip(map(mpmath.mpf, row), made_by.gain, strict=True)
            ]
            for band in range(len(BANDS)):
                total = mpmath.mpf(0)
                for subset in range(16):
                    share = mpmath.fprod(c if subset >> i & 1 else 1 - c for i, c in enumerate(covered))
                    total += share * mpmath.mpf(made_by.primaries[subset, band]) ** (1 / n)
                assert abs(printed[band] / total**n - 1) < 1e-14 * exponent


def test_the_limit_of_the_exponent_is_the_geometric_mean():
    amounts = np.random.default_rng(4).uniform(0, 1, (20, 3))
    limit = printer(3, np.inf).printed(amounts)
    geometric = np.exp(demichel(amounts) @ np.log(printer(3).primaries))
    np.testing.assert_allclose(limit, geometric, rtol=1e-14)
    # What is left falls as 1/n.
    gaps = [np.abs(printer(3, n).printed(amounts) - limit).max() for n in (1e2, 1e4, 1e6)]
    assert gaps[0] < 0.01
    np.testing.assert_allclose(np.divide(gaps[:-1], gaps[1:]), 100, rtol=0.02)


def test_light_that_spreads_darkens_the_print():
    amounts = np.random.default_rng(5).uniform(0, 1, (20, 3))
    prints = [printer(3, n).printed(amounts) for n in (1.0, 2.0, 5.0, np.inf)]
    assert all(np.all(a > b) for a, b in pairwise(prints))


@pytest.mark.parametrize("inks", [1, 3, 4])
@pytest.mark.parametrize("exponent", [1.0, 1.8, 6.0])
def test_a_chart_that_the_model_made_gives_the_model_back(inks, exponent):
    made_by = printer(inks, exponent, gain=0.06, seed=inks)
    fit = fit_halftone(chart(made_by))
    assert fit.printer.exponent == pytest.approx(exponent, rel=1e-3)
    np.testing.assert_allclose(fit.printer.gain, made_by.gain, atol=1e-3)
    np.testing.assert_allclose(fit.printer.primaries, made_by.primaries, atol=1e-4)
    assert fit.rms < 1e-5
    assert fit.worst_delta_e < 0.01
    assert fit.undetermined == 0


def test_noise_in_the_chart_comes_back_as_the_fits_error():
    made_by = printer(3, 2.0, gain=0.04)
    given = chart(made_by, prints=400, noise=0.003)
    fit = fit_halftone(given)
    noise = np.sqrt(np.mean((given.samples - made_by.printed(given.amounts)) ** 2))
    # The fit takes up 60 of 2,856 numbers' worth of noise, and weighs it by R^(1/n - 1), so that some more is left.
    assert fit.rms == pytest.approx(noise, rel=0.02)
    assert fit.rms < fit.worst_rms < 0.01
    seen = [r @ tristimulus(given.bands, fit.light) for r in (fit.printer.printed(given.amounts), given.samples)]
    white = tristimulus(given.bands, fit.light).sum(axis=0)
    colour = colour_science()
    off = colour.delta_E(*(colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(white)) for xyz in seen), method="CIE 2000")
    assert fit.delta_e == pytest.approx(off.mean(), rel=0.01)
    assert fit.worst_delta_e == pytest.approx(off.max(), rel=0.01)
    assert fit.worst_print == off.argmax()
    assert np.mean(off <= fit.delta_e_95 * 1.02) >= 0.95 > np.mean(off <= fit.delta_e_95 * 0.95)
    assert f"worst {fit.worst_delta_e:.3f} (print {fit.worst_print})" in repr(fit)
    fresh = chart(made_by, seed=7)
    assert np.sqrt(np.mean((fit.printer.printed(fresh.amounts) - fresh.samples) ** 2)) < 0.002


def test_no_other_exponent_fits_better():
    given = chart(printer(2, 2.6, gain=0.08), noise=0.002)
    best = fit_halftone(given, dot_gain=False)
    for exponent in np.geomspace(1, 50, 25):
        at = replace(best.printer, exponent=float(exponent))
        shares = demichel(given.amounts)
        powers = np.linalg.lstsq(shares, given.samples ** (1 / exponent), rcond=None)[0]
        rms = np.sqrt(np.mean((np.maximum(shares @ powers, 0) ** at.exponent - given.samples) ** 2))
        assert best.rms <= rms * (1 + 1e-6)
    assert fit_halftone(given).rms <= best.rms


def test_overprints_that_the_chart_leaves_open_are_counted_and_multiply():
    density = np.random.default_rng(2).uniform(0.1, 1.2, (4, len(BANDS)))
    solids = np.array([[s >> i & 1 for i in range(4)] for s in range(16)], dtype=float)
    made_by = replace(printer(4, 2.0), primaries=0.9 * 10 ** -(solids @ density))
    whole = chart(made_by, prints=200)
    ramps = np.count_nonzero(whole.amounts, axis=1) <= 1
    single = np.vstack([np.eye(4)[i] * a for i in range(4) for a in np.linspace(0.1, 1, 10)])
    amounts = np.vstack([whole.amounts[ramps], single])
    given = replace(whole, amounts=amounts, samples=made_by.printed(amounts))
    fit = fit_halftone(given)
    assert fit.undetermined == 16 - 5
    assert fit.rms < 1e-3
    assert "11 overprints not determined" in repr(fit)
    two_inks = fit.printer.printed(np.array([[1.0, 1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(two_inks[0], made_by.primaries[3], atol=0.05)


def test_a_synthetic_chart_in_a_file_is_fitted_from_the_file(tmp_path):
    device = load_device("synthetic-cmyk", BANDS)
    few = np.random.default_rng(0).permutation(len(device.samples))[:200]
    lines = [
        "CTI3",
        "BEGIN_DATA_FORMAT",
        "CMYK_C CMYK_M CMYK_Y CMYK_K " + " ".join(f"SPEC_{c:g}" for c in BANDS.centres),
    ]
    lines += ["END_DATA_FORMAT", "BEGIN_DATA"]
    rows = 100 * np.hstack([device.amounts, device.samples])[few]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in rows] + ["END_DATA"]
    file = tmp_path / "press.ti3"
    file.write_text("\n".join(lines))
    fit = fit_halftone(load_device(file))
    # Of the synthetic printer: n = 2, dot gain 0.03; the file has six decimals of percent.
    assert fit.printer.exponent == pytest.approx(2.0, abs=0.01)
    np.testing.assert_allclose(fit.printer.gain, 0.03, atol=1e-3)
    assert fit.worst_delta_e < 0.01
    assert not fit.device.modelled
    np.testing.assert_allclose(reflectance(fit.device, device.amounts[:9]), device.samples[:9], atol=1e-4)


@pytest.mark.parametrize("name", synthetic_devices())
def test_synthetic_printers_say_what_they_are(name):
    device = load_device(name)
    assert device.modelled
    assert "synthetic" in repr(device)
    assert "no printer was measured" in device.provenance
    assert np.all((device.samples > 0) & (device.samples <= 0.9))
    np.testing.assert_allclose(device.samples, reflectance(device, device.amounts), rtol=1e-15)
    np.testing.assert_allclose(device.samples[0], 0.9, rtol=1e-15)


def test_more_inks_reach_what_four_do_not():
    four, six = load_device("synthetic-cmyk"), load_device("synthetic-cmykog")
    orange = reflectance(six, np.array([[0, 0, 0, 0, 1.0, 0]]))
    # Of 1,296 prints in four inks none comes as near to solid orange as a tenth of its range.
    assert np.sqrt(np.mean((four.samples - orange) ** 2, axis=1)).min() > 0.03
    assert len(six.inks) == 6


def test_other_bands_keep_prints_and_printer_together():
    device = load_device("synthetic-cmyk").on(BANDS)
    assert device.bands == device.printer.bands == BANDS
    np.testing.assert_array_equal(device.samples, device.printer.printed(device.amounts))
    with pytest.raises(ValueError, match="nothing is extrapolated"):
        device.on(wavelengths(390, 700, 10))


def test_saved_gamuts_keep_the_halftone_printer(tmp_path):
    device = load_device("synthetic-cmykog", BANDS)
    save_gamut(tmp_path / "gamut.npz", device_gamut(device, "envelope"))
    again = load_gamut(tmp_path / "gamut.npz").device
    assert again.inks == device.inks
    np.testing.assert_array_equal(reflectance(again, device.amounts), device.samples)


def test_charts_that_no_halftone_can_be_fitted_to_are_named():
    made_by = printer(2)
    given = chart(made_by)
    unknown = replace(given, amounts=given.amounts[:, :0], inks=())
    with pytest.raises(ValueError, match=r"chart: the ink amounts of its prints are not known"):
        fit_halftone(unknown)
    with pytest.raises(ValueError, match=r"chart: amounts are not all in \[0, 1\]"):
        fit_halftone(replace(given, amounts=given.amounts * 2))
    with pytest.raises(ValueError, match=r"chart: 5 prints for 2 inks: give 6 or more"):
        fit_halftone(replace(given, amounts=given.amounts[:5], samples=given.samples[:5]))


def test_a_chart_of_no_more_prints_than_primaries_fits_any_model_and_is_refused():
    solids = chart(printer(4), prints=0)
    assert len(solids.samples) == 16
    with pytest.raises(ValueError, match="chart: 16 prints, which tell 16 primaries and nothing else"):
        fit_halftone(solids)
    # With eight inks and few prints at random every print is a primary's.
    few = chart(printer(8), prints=40)
    few = replace(few, samples=few.samples[256:], amounts=few.amounts[256:])
    with pytest.raises(ValueError, match="40 prints, which tell 40 primaries"):
        fit_halftone(few)
    ramps = np.vstack([np.eye(4)[i] * a for i in range(4) for a in (0.25, 0.5, 1)])
    made_by = printer(4, 1.7)
    amounts = np.vstack([solids.amounts, ramps])
    given = replace(solids, amounts=amounts, samples=made_by.printed(amounts))
    assert fit_halftone(given).printer.exponent == pytest.approx(1.7, rel=1e-2)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"exponent": 0.5}, r"n is 1 or more"),
        ({"exponent": np.nan}, r"n is 1 or more"),
        ({"gain": np.array([0.3, 0.0])}, r"a gain within ±1/4"),
        ({"gain": np.zeros(3)}, r"one gain an ink"),
        ({"primaries": np.ones((3, 7))}, r"a row for each of the 4 overprints"),
        ({"primaries": -np.ones((4, 7))}, r"a primary is below 0"),
        ({"inks": tuple("CMYKOGVRB")}, r"9 inks"),
    ],
)
def test_printers_that_cannot_be_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(printer(2), **change)


def test_amounts_beyond_solid_are_refused():
    with pytest.raises(ValueError, match=r"print 1, M: the amount 1.1 is not in \[0, 1\]"):
        reflectance(printer(2), np.array([[0.0, 0.0], [0.0, 1.1]]))


@pytest.mark.parametrize("ask", [fit_halftone, basis_report])
def test_a_monitor_is_no_printer(ask):
    with pytest.raises(ValueError, match="has no prints: give a printer or a chart"):
        ask(load_device("crt-brainard"))
