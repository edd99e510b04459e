"""Show spectra on a screen: radiances to CIE XYZ to sRGB, after step 3 of the paper.

Everything up to the encoding is linear, so that one matrix C (band × 3) is all it takes, and a preview is ``G (Γ C)``.
The observer is the CIE's of 1931 (2°); the reference white w has Y = 1 and is adapted to D65 by the Bradford transform.

References
----------
IEC 61966-2-1:1999 (sRGB).  K. M. Lam, "Metamerism and colour constancy", PhD thesis, Bradford, 1985.
"""

from collections.abc import Mapping
from functools import cache

import numpy as np
from jaxtyping import Float, Int, UInt8

from symrt.arrays import Spectrum
from symrt.errors import require, shown, suggestion
from symrt.spectra.bands import Bands
from symrt.spectra.library import colour_science, spectrum

CELLS = 1 << 16
"""Cells of the table that encodes to 8 bits; none holds two of the 255 thresholds."""
UNDECIDED = -1


def display_matrix(bands: Bands, white: Spectrum) -> Float[np.ndarray, "band 3"]:
    """The matrix C that takes a radiance to linear sRGB, with `white` at luminance 1.

    Spectra are adapted, so that `white` becomes (1, 1, 1).  RGB bands keep their colours and are only scaled;
    a single band is shown as grey.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> bands = wavelengths(380, 730, 10)
    >>> (np.full(36, 0.5) @ display_matrix(bands, np.ones(36))).round(12)
    array([0.5, 0.5, 0.5])
    """
    white = checked_white(white, bands)
    luminance = float(luminance_weights(bands) @ white)
    if not luminance > 0:
        raise ValueError("the reference white has no luminance: no exposure shows it; choose another reference")
    if bands.kind == "rgb":
        return np.eye(3) / luminance
    observer = _observer(bands) / luminance
    if len(bands) == 1:
        return np.ones((1, 3)) * observer[:, 1:2]
    xyz_to_rgb = np.linalg.inv(_rgb_to_xyz())
    return observer @ (xyz_to_rgb @ _adaptation(white @ observer)).T


def checked_white(white: object, bands: Bands) -> Spectrum:
    """The radiance of a white, one number a band.

    Raises
    ------
    TypeError, ValueError
        If it is no radiance, or one in other bands.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> checked_white([1, 1, 0.5], RGB)
    array([1. , 1. , 0.5])
    """
    try:
        values = np.array(white, dtype=float)
    except (TypeError, ValueError):
        remedy = "give a radiance, such as image.white or reference.white(system, palette)"
        raise TypeError(f"white is a {type(white).__name__}, {shown(white)}: {remedy}") from None
    if values.shape != (len(bands),):
        raise ValueError(f"white = {shown(white)}: a white has one number for each band of {bands!r}")
    if not (np.isfinite(values).all() and values.min() >= 0):
        raise ValueError(f"white = {shown(values.tolist())}: a white is finite and not negative")
    return values


def check_exposure(exposure: object) -> None:
    """Refuse what is no factor on radiances."""
    require("exposure", exposure, (int, float, np.number), "a number above 0; 1 shows the reference white as white")
    if not (np.isfinite(exposure) and exposure > 0):  # type: ignore[operator, call-overload]
        raise ValueError(f"exposure = {exposure}: it must be above 0, and 1 shows the reference white as white")


def luminance_weights(bands: Bands) -> Spectrum:
    """Weights that give the luminance of a spectrum, 1 for a constant 1.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> luminance_weights(RGB).round(4)
    array([0.2126, 0.7152, 0.0722])
    """
    return _rgb_to_xyz()[1] if bands.kind == "rgb" else _observer(bands)[:, 1]


def white_among(whites: Mapping[str, Spectrum], name: str | None, bands: Bands) -> Spectrum:
    """The white that a name means: a light's; None, the key light's; else another one, as bright as the key light's."""
    if not whites:
        raise ValueError("no light shines, so that there is no reference white: give its radiance as white=")
    key = next(iter(whites.values()))
    if name is None or name in whites:
        return key if name is None else whites[name]
    if name != "equal-energy" and not name.lower().startswith("illuminant/"):
        raise ValueError(
            f"no light {name!r}: {suggestion(name, whites)}; or give 'equal-energy' or an illuminant, 'illuminant/D65'"
        )
    return of_same_luminance(name, key, bands)


def of_same_luminance(name: str, white: Spectrum, bands: Bands) -> Spectrum:
    """``"equal-energy"`` or an illuminant of the library, as bright as `white`."""
    shape = np.ones(len(bands)) if name == "equal-energy" else spectrum(name, bands, reflectance=False)
    weights = luminance_weights(bands)
    return shape * ((weights @ white) / (weights @ shape))


def encode(linear: Float[np.ndarray, "*pixel 3"]) -> Float[np.ndarray, "*pixel 3"]:
    """Linear sRGB, clipped to [0, 1], to sRGB's curve.

    Examples
    --------
    >>> encode(np.array([[0.0, 0.5, 2.0]])).round(4)
    array([[0.    , 0.7354, 1.    ]])
    """
    x = np.clip(linear, 0.0, 1.0)
    # The constant 0.0031308 is where the standard joins the straight part to the power.
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def to_rgb8(linear: Float[np.ndarray, "*pixel 3"]) -> UInt8[np.ndarray, "*pixel 3"]:
    """Linear sRGB to the nearest of sRGB's 8-bit codes: `encode`, by table, in half the time.

    Examples
    --------
    >>> to_rgb8(np.array([[0.0, 0.5, 2.0]]))
    array([[  0, 188, 255]], dtype=uint8)
    """
    thresholds, table = _code_tables()
    x = np.clip(linear, 0.0, 1.0).ravel()
    codes = table.take((x * CELLS).astype(np.int32))
    # A cell with a threshold inside holds two codes: its few values are looked up one by one.
    undecided = np.flatnonzero(codes == UNDECIDED)
    codes[undecided] = np.searchsorted(thresholds, x[undecided], side="right")
    return codes.astype(np.uint8).reshape(linear.shape)


@cache
def _observer(bands: Bands) -> Float[np.ndarray, "band 3"]:
    """The colour matching functions at the bands' centres, times their widths; their luminance sums to 1."""
    if bands.kind != "wavelength":
        raise ValueError(f"{bands!r} have no colour: only wavelengths and RGB do")
    cmfs = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    # Outside the table, 360 … 830 nm, the observer sees nothing.
    columns = [np.interp(bands.centres, cmfs.wavelengths, c, left=0.0, right=0.0) for c in cmfs.values.T]
    weighted = np.stack(columns, axis=1) * bands.widths[:, None]
    if not weighted[:, 1].sum() > 0:
        raise ValueError(f"{bands!r} are all invisible: the observer sees 360 to 830 nm")
    return weighted / weighted[:, 1].sum()


def _adaptation(white: Float[np.ndarray, "3"]) -> Float[np.ndarray, "3 3"]:
    """Bradford's transform of XYZ that makes a white the screen's."""
    cones = np.asarray(colour_science().CHROMATIC_ADAPTATION_TRANSFORMS["Bradford"], dtype=float)
    seen, wanted = cones @ white, cones @ (_rgb_to_xyz() @ np.ones(3))
    # Whites without blue, say, would need infinite gains.
    if seen.min() < 1e-3 * seen.max():
        raise ValueError(
            "the reference white is too saturated to be adapted to: give another, such as 'illuminant/D65'"
        )
    return np.asarray(np.linalg.solve(cones, (wanted / seen)[:, None] * cones))


@cache
def _rgb_to_xyz() -> Float[np.ndarray, "3 3"]:
    """From the standard's primaries and white, not from its four decimals: white is then white within rounding."""
    srgb = colour_science().models.RGB_COLOURSPACE_sRGB
    return np.asarray(colour_science().models.normalised_primary_matrix(srgb.primaries, srgb.whitepoint), dtype=float)


@cache
def _code_tables() -> tuple[Float[np.ndarray, "255"], Int[np.ndarray, " cell"]]:
    """The linear values between two codes, and the code of each cell, or that it is undecided."""
    halves = (np.arange(1, 256) - 0.5) / 255
    thresholds = np.where(halves <= 0.04045, halves / 12.92, ((halves + 0.055) / 1.055) ** 2.4)
    codes = np.searchsorted(thresholds, np.arange(CELLS + 2) / CELLS, side="right")
    return thresholds, np.where(np.diff(codes) > 0, UNDECIDED, codes[:-1]).astype(np.int16)
