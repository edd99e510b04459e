"""Errors against the number of basis spectra, held against truncated decompositions and the colour-science library."""

from dataclasses import replace

import numpy as np
import pytest

from symrt.device import load_device
from symrt.device.printing import Device
from symrt.gamut import basis_report
from symrt.spectra.bands import RGB, wavelengths
from symrt.spectra.library import colour_science

colour = colour_science()
NAMES = ("dye3-endura-premier", "synthetic-cmyk")


def kept(samples, vectors, k):
    return samples @ vectors[:k].T @ vectors[:k]


def plain_components(samples):
    return np.linalg.svd(samples, full_matrices=False)[2]


def constant_first(samples):
    """The constant spectrum and the principal components of what is left: Gram and Schmidt's way, by projection."""
    bands = samples.shape[1]
    project = np.eye(bands) - np.full((bands, bands), 1 / bands)
    return np.vstack(
        [np.full(bands, bands**-0.5), np.linalg.svd(samples @ project, full_matrices=False)[2][: bands - 1]]
    )


def xyz(spectra, bands, light):
    """ASTM E308 as colour-science has it: interpolated to 1 nm and summed up."""
    shape = colour.SpectralShape(bands.centres[0], bands.centres[-1], bands.centres[1] - bands.centres[0])
    table = colour.MultiSpectralDistributions(spectra.T, shape.wavelengths)
    fine = table.interpolate(
        colour.SpectralShape(shape.start, shape.end, 1), interpolator=colour.CubicSplineInterpolator
    )
    fine = fine.extrapolate(
        colour.SpectralShape(380, 780, 1), extrapolator_kwargs={"method": "Constant", "left": None, "right": None}
    )
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(fine.shape).values
    lamp = colour.SDS_ILLUMINANTS[light].copy().align(fine.shape).values
    weights = observer * lamp[:, None]
    return fine.values.T @ weights / weights[:, 1].sum(), weights.sum(axis=0) / weights[:, 1].sum()


def delta_e(one, other, bands, light):
    labs = []
    for spectra in (one, other):
        colours, white = xyz(spectra, bands, light)
        labs.append(colour.XYZ_to_Lab(colours, colour.XYZ_to_xy(white)))
    return colour.difference.delta_E_CIE2000(*labs)


@pytest.mark.parametrize("name", NAMES)
def test_rms_is_that_of_samples_kept_to_their_first_components(name):
    device = load_device(name)
    report = basis_report(device)
    for basis, rms in ((constant_first, report.rms), (plain_components, report.rms_plain)):
        vectors = basis(device.samples)
        for k in (1, 2, 3, 5, 8, 20):
            error = kept(device.samples, vectors, k) - device.samples
            assert rms[k - 1] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("light", ["D50", "A"])
def test_colour_differences_are_those_of_colour_science_for_truncated_spectra(name, light):
    device = load_device(name)
    device = replace(device, samples=device.samples[::29], amounts=device.amounts[::29])
    report = basis_report(device, f"illuminant/{light}")
    assert (report.light, report.prints) == (f"illuminant/{light}", len(device.samples))
    for k in (1, 3, 6, 8):
        for vectors, mean, largest in (
            (constant_first, report.mean, report.largest),
            (plain_components, report.mean_plain, report.largest_plain),
        ):
            found = delta_e(kept(device.samples, vectors(device.samples), k), device.samples, device.bands, light)
            # The library's splines end otherwise (not-a-knot), where the eye hardly sees: a thousandth of ΔE.
            assert mean[k - 1] == pytest.approx(found.mean(), abs=2e-3)
            assert largest[k - 1] == pytest.approx(found.max(), abs=2e-2)


def test_with_all_components_nothing_is_lost_and_with_few_plain_ones_lose_least_reflectance():
    for name in NAMES:
        report = basis_report(load_device(name))
        assert np.all(report.rms_plain <= report.rms * (1 + 1e-9) + 1e-15)
        for errors in (report.rms, report.rms_plain, report.mean, report.mean_plain, report.largest):
            assert len(errors) == 36
            assert errors[-1] < 1e-11
        assert np.all(report.mean <= report.largest)


def test_the_number_that_is_enough_is_the_least_from_which_on_all_are():
    report = basis_report(load_device("dye3-endura-premier"))
    for allowed in (0.5, 1.0, 2.0, 20.0, 1000.0, 0.0):
        for number, errors in zip(report.enough(allowed), (report.largest, report.largest_plain), strict=True):
            assert all(error <= allowed for error in errors[number - 1 : -1])
            assert number == 1 or errors[number - 2] > allowed


def test_what_is_enough_for_any_difference_is_one_component_and_for_none_it_is_no_question():
    report = basis_report(load_device("dye3-endura-premier"))
    assert report.enough(np.inf) == (1, 1)
    for wrong in (np.nan, -1.0):
        with pytest.raises(ValueError, match=rf"delta_e = {wrong}: a colour difference is 0 or more"):
            report.enough(wrong)


def test_a_chart_of_fewer_prints_than_bands_is_told_by_as_many_components():
    prints = np.random.default_rng(0).uniform(0.1, 0.9, (3, 36))
    none = np.zeros(36, dtype=bool)
    chart = Device("three", wavelengths(380, 730, 10), prints, np.empty((3, 0)), (), none, "", "", modelled=False)
    report = basis_report(chart)
    assert (report.rank, report.enough(1e-9)) == (3, (4, 3))
    assert [row[0] for row in report.rows()] == ["components", "1", "2", "3", "4"]
    grey = np.full((2, 36), [[0.5], [0.2]])
    report = basis_report(Device("greys", chart.bands, grey, np.empty((2, 0)), (), none, "", "", modelled=False))
    assert (report.rank, report.enough(1e-9)) == (0, (1, 1))


def test_the_table_shows_what_the_record_holds():
    report = basis_report(load_device("dye3-endura-premier"))
    lines = str(report).splitlines()
    assert lines[3].split() == ["1", "0.166", "0.144", "24.8", "28.5", "41.9", "66.4"]
    assert [line.split()[0] for line in lines[3:-1]] == [*"12345678", "31"]
    assert "the first principal component is 0.9351 constant" in lines[-1]
    html = report._repr_html_()
    assert html.count("<tr>") == 10
    assert f"<td>{report.largest[2]:.3g}</td>" in html


def test_numbers_that_are_no_wavelengths_have_no_colour():
    prints = np.array([[0.1, 0.2, 0.3], [0.5, 0.4, 0.1]])
    chart = Device("rgb", RGB, prints, np.empty((2, 0)), (), np.zeros(3, dtype=bool), "", "", modelled=False)
    with pytest.raises(ValueError, match="only wavelengths do"):
        basis_report(chart)
