"""Metals against Fresnel's equations in exact complex arithmetic, and against other measurements."""

import json
import re
from importlib import resources

import mpmath
import numpy as np
import pytest
import sympy
from hypothesis import assume, given
from hypothesis import strategies as st

import symrt as rt
from symrt.reflection import MODELS, metals
from symrt.reflection.symbols import Factor, n_dot_v
from symrt.spectra.library import colour_science, names
from symrt.spectra.metals import conductor_reflectance, optical_constants

colour = colour_science()
BANDS = rt.wavelengths(380, 730, 10)


def fresnel(n, k, cosine) -> mpmath.mpf:
    """Fresnel's equations as textbooks write them, with 40 digits: Snell's law, then both polarisations."""
    with mpmath.workdps(40):
        index, cosine = mpmath.mpc(n, k), mpmath.mpf(cosine)
        inside = mpmath.sqrt(1 - (1 - cosine**2) / index**2)
        s = (cosine - index * inside) / (cosine + index * inside)
        p = (index * cosine - inside) / (index * cosine + inside)
        return (abs(s) ** 2 + abs(p) ** 2) / 2


@given(st.floats(0.01, 10), st.floats(0, 20), st.floats(0, 1))
def test_a_conductor_reflects_by_fresnels_equations(n, k, cosine):
    assume((n, k, cosine) != (1, 0, 0))  # along a surface where nothing changes: 0/0 here, and 0 there
    # Cancellation costs a share of what does not reflect: an absolute error, not one of the last digit.
    assert abs(conductor_reflectance(n, k, cosine) - fresnel(n, k, cosine)) < 1e-15


def test_corners_of_fresnels_equations():
    # Glass: 4 % along the normal; at Brewster's angle, cos θ = 1/√(1 + n²), one polarisation alone, ((n²−1)/(n²+1))².
    assert conductor_reflectance(1.5, 0.0, 1.0) == pytest.approx(0.04, rel=1e-15)
    brewster = 1 / np.sqrt(1 + 1.5**2)
    assert conductor_reflectance(1.5, 0.0, brewster) == pytest.approx(((1.5**2 - 1) / (1.5**2 + 1)) ** 2 / 2, rel=1e-14)
    # Nothing reflects where nothing changes, at any angle; and everything does along a surface.
    assert not conductor_reflectance(1.0, 0.0, np.array([0.0, 1e-12, 1e-3, 0.5, 1.0])).any()
    np.testing.assert_array_equal(conductor_reflectance(np.array([0.2, 3.0]), np.array([3.0, 0.0]), 0.0), 1.0)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ((0.0, 1.0, 1.0), "n = 0.0: an index of refraction is above 0"),
        ((1.0, -0.1, 1.0), "k = -0.1: an extinction coefficient is 0 or more"),
        ((1.0, 0.1, 30.0), "cosine = 30.0: a cosine lies in .0, 1.; give cos θ, not the angle"),
        ((float("nan"), 0.1, 1.0), "n = nan"),
    ],
)
def test_numbers_that_are_no_metals_are_refused(given, says):
    with pytest.raises(ValueError, match=says):
        conductor_reflectance(*given)


@pytest.mark.parametrize("metal", rt.metals())
def test_a_metals_reflectances_are_fresnels_at_its_measured_index(metal):
    table = json.loads((resources.files("symrt") / "data" / "metals.json").read_text(encoding="utf-8"))[metal]
    rows = [row for row in table["nm, n, k"] if 380 <= row[0] <= 780]
    bands = rt.Bands(tuple(float(nm) for nm, _, _ in rows))
    for name, cosine in ((f"metal/{metal}", 1), (f"metal/{metal} f82", mpmath.mpf(1) / 7)):
        exact = [float(fresnel(n, k, cosine)) for _, n, k in rows]
        np.testing.assert_allclose(rt.spectrum(name, bands), exact, rtol=1e-14)
        assert name in names()
    assert re.search(r"\((19|20)\d\d\)$", table["source"])


# Single lines of other people's measurements, as (nm, n, k), and how far films and bulk of a metal may differ.
OTHERS = {
    # H.-J. Hagemann, W. Gudat and C. Kunz, DESY report SR-74/7 (1974).
    "copper": [(476.9, 1.152, 2.50, 0.03), (590.4, 0.468, 2.81, 0.05), (652.5, 0.214, 3.67, 0.03)],
    # E. D. Palik (ed.), "Handbook of Optical Constants of Solids", 1985.
    "aluminium": [(413.28, 0.523, 5.02, 0.01), (551.04, 0.963, 6.70, 0.01), (708.48, 1.91, 8.39, 0.01)],
    "nickel": [(413.27, 1.61, 2.44, 0.05), (563.55, 1.80, 3.33, 0.05), (708.46, 2.21, 4.09, 0.06)],
    "chrome": [(471.41, 2.22, 4.36, 0.05), (582.07, 3.34, 4.38, 0.01), (700.45, 3.84, 4.37, 0.01)],
    # P. B. Johnson and R. W. Christy, Physical Review B 9, 5056 (1974).
    "iron": [(451.0, 2.59, 2.77, 0.07), (549.0, 2.95, 2.93, 0.06), (704.0, 2.86, 3.19, 0.06)],
    # I. D. Mash and G. P. Motulevich, Soviet Physics JETP 36, 516 (1973).
    "titanium": [(440.0, 1.89, 2.59, 0.06), (560.0, 2.27, 2.94, 0.07), (700.0, 2.67, 3.20, 0.09)],
}


@pytest.mark.parametrize("metal", OTHERS)
def test_other_measurements_of_a_metal_agree_within_what_samples_differ(metal):
    for nm, n, k, apart in OTHERS[metal]:
        other = ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2)
        assert abs(rt.spectrum(f"metal/{metal}", rt.Bands((nm,)))[0] - other) < apart, nm


def test_the_errors_of_both_models_are_those_that_are_told():
    told = dict(re.findall(r"^(\w+) +(0\.\d+ +0\.\d+)$", metals.__doc__, re.MULTILINE))
    assert sorted(told) == sorted(rt.metals())
    cosines = np.linspace(0, 1, 1001)[:, None]
    for metal, errors in told.items():
        exact = conductor_reflectance(*optical_constants(metal, BANDS), cosines)
        f0, f82 = (rt.spectrum(f"metal/{metal}{angle}", BANDS) for angle in ("", " f82"))
        found = []
        for model in ("metal", "metal_f82"):
            letters = [n_dot_v, Factor("one_minus_n_dot_v"), rt.reflectance("f0"), rt.reflectance("f82")]
            curve = sympy.lambdify(letters, MODELS[model].reflected)(cosines, 1 - cosines, f0, f82)
            found.append(f"{np.abs(curve - exact).max():.3f}")
        assert found == errors.split(), metal


def test_metals_are_named_as_people_call_them_and_others_are_refused():
    same = rt.spectrum("metal/aluminium f82", BANDS)
    np.testing.assert_array_equal(rt.spectrum("Metal/Aluminum-F82", BANDS), same)
    np.testing.assert_array_equal(rt.spectrum("metal/chromium", BANDS), rt.spectrum("metal/chrome", BANDS))
    with pytest.raises(
        ValueError, match=r"no spectrum is named 'metal/zinc': there are gold, .* conductor_reflectance"
    ):
        rt.spectrum("metal/zinc", BANDS)
    with pytest.raises(ValueError, match=r"metal/gold covers 187.9 … 1937 nm.* choose narrower bands"):
        rt.spectrum("metal/gold", rt.wavelengths(380, 2000, 20))
    with pytest.raises(ValueError, match="'metal/gold' is a reflectance, and a light is wanted"):
        rt.Palette(BANDS, {"sun": "metal/gold"})
    with pytest.raises(ValueError, match="no metal is called 'bras': did you mean 'brass'"):
        optical_constants("bras", BANDS)


def test_in_rgb_a_metal_is_its_colour_by_daylight():
    visible = colour.SpectralShape(380, 780, 5)
    brass = colour.SpectralDistribution(rt.spectrum("metal/brass", rt.wavelengths(380, 780, 5)), visible)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(visible)
    d65 = colour.SDS_ILLUMINANTS["D65"].copy().align(visible)
    expected = colour.XYZ_to_sRGB(colour.sd_to_XYZ(brass, cmfs, d65, method="Integration") / 100)
    found = colour.models.eotf_inverse_sRGB(rt.spectrum("metal/brass", rt.RGB))
    np.testing.assert_allclose(found, expected, atol=1e-3)
    with pytest.raises(ValueError, match="'metal/gold' is outside sRGB"):
        rt.spectrum("metal/gold", rt.RGB)
