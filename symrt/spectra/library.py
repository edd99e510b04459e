"""Spectra by name: the colour-science library's tables behind one function, for step 3 of the paper.

Illuminants are relative, so they are scaled to **luminance 1**: as bright as an equal-energy light of constant 1.
Putting ``illuminant/A`` in the place of ``illuminant/D65`` then changes the colour of a picture, not its brightness,
and D65 in linear sRGB is (1, 1, 1).

References
----------
The ColorChecker is "BabelColor Average" (D. Pascale), 380-730 nm by 10 nm; the illuminants are the CIE's.
The metals are those of `symrt.spectra.metals`, whose sources stand beside the table in ``symrt/data``.
From RGB: I. Mallett and C. Yuksel, "Spectral Primary Decomposition for Rendering with sRGB Reflectance", EGSR 2019.
"""

import difflib
import importlib
import re
import warnings
from functools import cache
from typing import Any

import numpy as np
from jaxtyping import Float

from symrt.arrays import Spectrum
from symrt.errors import require, shown
from symrt.spectra.bands import Bands, Number, check_wavelengths, resample, wavelengths
from symrt.spectra.metals import metal_names, metal_reflectance, metals

OBSERVER = "CIE 1931 2 Degree Standard Observer"
REFLECTANCES = ("macbeth", "metal")
"""Groups of spectra that are reflectances; the others are lights."""
SPELLINGS = {"aluminum": "aluminium", "chromium": "chrome"}
"""Other words for metals."""


def spectrum(name: str, bands: Bands, *, reflectance: bool | None = None) -> Spectrum:
    """A spectrum of the library at the given bands.

    Capitals do not matter, and ``-``, ``_`` and a space are the same.  In RGB bands a light is its linear sRGB colour
    and a reflectance the colour it has under D65; one outside sRGB is an error, since its red, green or blue would be
    negative.

    Parameters
    ----------
    name
        ``macbeth/dark skin``, ``illuminant/D65``, ``metal/gold`` …; see `names`.  Or a colour as the web writes it,
        ``#c08a3e``: see `srgb` and `from_rgb`.
    reflectance
        Refuse a light where a reflectance is meant, or the reverse; None takes either.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> spectrum("macbeth/dark_skin", wavelengths(380, 730, 10))[:3]
    array([0.055, 0.058, 0.061])
    >>> spectrum("illuminant/E", wavelengths(400, 700, 100))
    array([1., 1., 1., 1.])
    """
    require("name", name, str, "the name of a spectrum, such as 'macbeth/red', or a colour, '#c08a3e'")

    # A colour, or the one spectrum that has the name.
    if name.lstrip().startswith("#"):
        return from_rgb(srgb(name), bands, reflectance=reflectance is not False)
    group, nm, values, found = _look_up(_key(name), name)
    reflects = group in REFLECTANCES
    if reflectance is not None and reflectance != reflects:
        is_, meant = ("a reflectance", "a light") if reflects else ("a light", "a reflectance")
        raise ValueError(f"{name!r} is {is_}, and {meant} is wanted here: a symbol with a dot is a reflectance")

    # At the bands; in RGB as its colour.
    if bands.kind != "rgb":
        # A metal's n and k are interpolated, not what they reflect.
        metal = found.removeprefix("metal/")
        return metal_reflectance(metal, bands) if group == "metal" else resample(nm, values, bands, repr(found))
    d65 = resample(*_tables()["illuminant"]["D65"], Bands(tuple(nm.tolist())))
    rgb = _linear_srgb(nm, values * d65 if reflects else values) / _linear_srgb(nm, d65)
    if rgb.min() < -1e-6 or (reflects and rgb.max() > 1):
        raise ValueError(
            f"{name!r} is outside sRGB, {rgb.round(3).tolist()}: use bands in nm, or give [red, green, blue]"
        )
    return np.maximum(rgb, 0.0)


def names() -> tuple[str, ...]:
    """Every name that `spectrum` knows.

    Examples
    --------
    >>> [name for name in names() if "skin" in name]
    ['macbeth/dark skin', 'macbeth/light skin']
    """
    return tuple(f"{group}/{name}" for group, tables in _tables().items() for name in tables)


def srgb(colour: str) -> Float[np.ndarray, "3"]:
    """Linear red, green and blue of a colour as the web writes it, encoded sRGB: ``#c08a3e``, or ``#ca4`` for short.

    In RGB palettes it is a spectrum as it stands; at wavelengths write the text itself, ``"#c08a3e"``, which stands for
    a smooth spectrum of that colour, see `from_rgb`.

    Raises
    ------
    ValueError
        If it is no such colour.

    Examples
    --------
    >>> srgb("#ff8000").round(4)
    array([1.    , 0.2159, 0.    ])
    """
    require("colour", colour, str, "a colour as text, '#c08a3e'")
    digits = colour.strip()[1:]
    if not re.fullmatch(r"\s*#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})\s*", colour):
        raise ValueError(f"{shown(colour)} is no colour: write # and six hexadecimal digits, such as '#c08a3e'")
    pairs = [digit * 2 for digit in digits] if len(digits) == 3 else re.findall("..", digits)
    encoded = np.array([int(pair, 16) for pair in pairs]) / 255
    # The constant 0.04045 is where the standard's straight part joins the power, seen from the encoded side.
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def from_rgb(rgb: Float[np.ndarray, "3"], bands: Bands, *, reflectance: bool) -> Spectrum:
    """A smooth spectrum of a linear sRGB colour: a reflectance under D65, or a light; in RGB, the three numbers.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> from_rgb(np.array([0.5, 0.5, 0.5]), wavelengths(400, 700, 100), reflectance=True)
    array([0.5, 0.5, 0.5, 0.5])
    """
    if not np.all(np.isfinite(rgb)) or rgb.min() < 0 or (reflectance and rgb.max() > 1):
        range_ = "[0, 1]" if reflectance else "[0, ∞)"
        raise ValueError(f"rgb = {rgb.tolist()}: linear red, green and blue lie in {range_} here")
    if bands.kind == "rgb":
        return rgb
    basis = colour_science().recovery.MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
    # The published basis sums to 1 within 1e-8 only; divided by its sum, grey is exactly flat and nothing passes 1.
    values = np.minimum(basis.values @ rgb / basis.values.sum(axis=1), rgb.max())
    values = resample(np.asarray(basis.wavelengths, float), values, bands, "rgb")
    return values if reflectance else values * spectrum("illuminant/D65", bands)


def bell(peak: Number, width: Number, bands: Bands) -> Spectrum:
    """A bell over wavelengths, 1 at its peak and half of that half its `width` beside it.

    A lamp of one colour, or a dye's excitation or emission, is about of this form.

    Raises
    ------
    ValueError
        If the bands are no wavelengths, or the width is not above 0.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> bell(500, 40, wavelengths(460, 540, 20))
    array([0.0625, 0.5   , 1.    , 0.5   , 0.0625])
    """
    if bands.kind != "wavelength":
        raise ValueError(f"a peak at {peak:g} nm has no red, green and blue: give three numbers, or bands in nm")
    check_wavelengths(np.array([float(peak)]), "the peak")
    if not (np.isfinite(width) and width > 0):
        raise ValueError(f"width = {width}: the whole width at half the height, in nm, is above 0")
    return np.exp2(-(((np.array(bands.centres) - peak) / (width / 2)) ** 2))


def _key(name: str) -> str:
    return re.sub(r"[-_ ]+", " ", name.strip().lower())


def _look_up(key: str, name: str) -> tuple[str, Float[np.ndarray, " n"], Float[np.ndarray, " n"], str]:
    """Group, wavelengths, values and full name; a patch's notation and density may be left out: ``macbeth/white``."""
    # Full names, and short ones without notation and density.
    key = re.sub("|".join(SPELLINGS), lambda word: SPELLINGS[word[0]], key) if key.startswith("metal/") else key
    known = {_key(full): full for full in names()}
    short: dict[str, list[str]] = {}
    for full in known.values():
        for part in {re.sub(r" \(.*", "", full), re.sub(r" [\d.]+ \(.*", "", full), full.replace("/FL", "/F")}:
            short.setdefault(_key(part), []).append(full)

    # The one spectrum that has the name, or those that are near it.
    matches = [known[key]] if key in known else short.get(key, [])
    if len(matches) != 1:
        bare = [name for name in known if name.partition("/")[2] == key]
        near = matches or bare or difflib.get_close_matches(key, known, n=3, cutoff=0.5)
        hint = (
            f"did you mean {', '.join(known.get(n, n) for n in near)}?" if near else "see symrt.spectra.library.names()"
        )
        if key.startswith("metal/"):
            hint = f"there are {', '.join(metals())}, and 'gold f82' …; of others give n and k to conductor_reflectance"
        raise ValueError(f"no spectrum is named {name!r}: {hint}")
    group, table = matches[0].split("/", 1)
    return (group, *_tables()[group][table], matches[0])


@cache
def _tables() -> dict[str, dict[str, tuple[np.ndarray, np.ndarray]]]:
    colour = colour_science()
    observer = colour.MSDS_CMFS[OBSERVER]
    nm_y, y = np.asarray(observer.wavelengths, float), np.asarray(observer.values[:, 1], float)
    tables: dict[str, dict[str, tuple[np.ndarray, np.ndarray]]] = {"macbeth": {}, "illuminant": {}, "metal": {}}
    for name, sd in colour.SDS_COLOURCHECKERS["BabelColor Average"].items():
        tables["macbeth"][name] = (np.asarray(sd.wavelengths, float), np.asarray(sd.values, float))
    for name, sd in colour.SDS_ILLUMINANTS.items():
        nm, values = np.asarray(sd.wavelengths, float), np.asarray(sd.values, float)
        if nm[0] <= 380 and nm[-1] >= 780:
            luminance = y @ np.interp(nm_y, nm, values, left=0, right=0) / y.sum()
            tables["illuminant"][name] = (nm, values / luminance)
    visible = wavelengths(380, 780, 5)
    tables["metal"] = {name: (np.array(visible.centres), metal_reflectance(name, visible)) for name in metal_names()}
    return tables


def _linear_srgb(nm: Float[np.ndarray, " n"], values: Float[np.ndarray, " n"]) -> Float[np.ndarray, "3"]:
    """Colour of a radiance, unadapted, with the luminance of a constant 1 as the unit."""
    colour = colour_science()
    observer = colour.MSDS_CMFS[OBSERVER]
    cmfs = np.stack([np.interp(nm, observer.wavelengths, column, left=0, right=0) for column in observer.values.T])
    xyz = cmfs @ values / cmfs[1].sum()
    return np.asarray(colour.models.RGB_COLOURSPACE_sRGB.matrix_XYZ_to_RGB @ xyz)


def observer() -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
    """The CIE's standard observer of 1931 (2°): wavelengths, every nm, and the three colour matching functions.

    Examples
    --------
    >>> nm, functions = observer()
    >>> nm[functions[:, 1].argmax()].item()
    555.0
    """
    cmfs = colour_science().MSDS_CMFS[OBSERVER]
    return np.asarray(cmfs.wavelengths, float), np.asarray(cmfs.values, float)


def display_primaries(name: str) -> tuple[Float[np.ndarray, " n"], Float[np.ndarray, "3 n"]]:
    """Wavelengths and spectra of the red, green and blue of a display, under colour-science's name for it.

    Examples
    --------
    >>> nm, primaries = display_primaries("Apple Studio Display")
    >>> nm[primaries.argmax(axis=1)].tolist()
    [615.0, 540.0, 435.0]
    """
    table = colour_science().MSDS_DISPLAY_PRIMARIES[name]
    return np.asarray(table.wavelengths, float), np.asarray(table.values, float).T


def colour_difference(one: Float[np.ndarray, "n 3"], other: Float[np.ndarray, "n 3"]) -> Float[np.ndarray, " n"]:
    """CIEDE2000 between colours in L*a*b*.

    Examples
    --------
    The first pair of G. Sharma, W. Wu and E. N. Dalal, Color Research and Application 30(1), 2005:

    >>> colour_difference(np.array([[50, 2.6772, -79.7751]]), np.array([[50, 0.0, -82.7485]])).round(4)
    array([2.0425])
    """
    return np.asarray(colour_science().difference.delta_E_CIE2000(one, other), dtype=float)


def colour_science() -> Any:  # colour puts an object without types in its module's place
    """The colour-science package, imported when first needed: it takes a second, and changes NumPy's print options."""
    with np.printoptions(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return importlib.import_module("colour")
