"""Colours of prints under a viewing light: CIE XYZ, L*a*b* and their differences, for gamuts and fits of step 4.

A reflectance known every 10 nm is interpolated by a natural cubic spline to every nanometre, held constant beyond its
ends, and weighted there with light and observer [1]_: a matrix, because all of that is linear.  A perfect diffuser has
Y = 1.

References
----------
.. [1] ASTM E308-18, "Standard Practice for Computing the Colors of Objects by Using the CIE System".
.. [2] CIE 15:2018, "Colorimetry", section 8.2.1.1 (L*a*b*).
"""

from functools import cache

import numpy as np
from jaxtyping import Float
from scipy.interpolate import CubicSpline

from symrt.spectra.bands import Bands
from symrt.spectra.library import observer, spectrum

VISIBLE = Bands(tuple(float(nm) for nm in range(380, 781)))
"""Every nanometre that all illuminants are known at; what the observer sees beyond is less than 1e-4 of a white."""
LEAST_SEEN = 0.5
"""Share of the luminance that bands must span: with less, the colour would be that of what was not measured."""
KNEE = (6 / 29) ** 3
"""Where the cube root of L*a*b* gives way to a straight line."""


@cache
def tristimulus(bands: Bands, light: str) -> Float[np.ndarray, "band 3"]:
    """The matrix that takes reflectances to XYZ under a light; a perfect diffuser gets Y = 1.

    Parameters
    ----------
    bands
        Wavelengths of the reflectances.
    light
        An illuminant of the library, such as ``"illuminant/D50"``.

    Raises
    ------
    ValueError
        If there is no such light, or most of what the eye sees is beyond the bands.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> (np.ones(36) @ tristimulus(wavelengths(380, 730, 10), "illuminant/D50")).round(3)
    array([0.964, 1.   , 0.825])
    """
    if bands.kind != "wavelength":
        raise ValueError(f"{bands!r} have no colour under a light: only wavelengths do")

    # Weights of every visible nanometre: the observer times the light.
    fine = np.array(VISIBLE.centres)
    centres = np.array(bands.centres)
    nm, functions = observer()
    weights = functions[(nm >= fine[0]) & (nm <= fine[-1])] * spectrum(light, VISIBLE, reflectance=False)[:, None]

    # The share of them that the bands span.
    spanned = (fine >= centres[0]) & (fine <= centres[-1])
    seen = weights[spanned, 1].sum() / weights[:, 1].sum()
    if seen < LEAST_SEEN:
        raise ValueError(
            f"{bands!r} span {seen:.0%} of what the eye sees under {light}, the rest would be guessed: colours need "
            "spectra of about 400 … 700 nm"
        )

    # Reflectances between the bands by a smooth curve, beyond them as at the ends.
    each = np.eye(len(bands))
    within = np.clip(fine, centres[0], centres[-1])
    spread = CubicSpline(centres, each, bc_type="natural")(within) if len(bands) > 1 else np.ones((len(fine), 1))
    matrix = np.asarray(spread.T @ weights / weights[:, 1].sum())
    matrix.flags.writeable = False
    return matrix


def lab(xyz: Float[np.ndarray, "*n 3"], light: str | Float[np.ndarray, "3"]) -> Float[np.ndarray, "*n 3"]:
    """L*a*b* of colours seen beside a perfect diffuser under a light, or beside a white of which the XYZ are given.

    Examples
    --------
    >>> lab(np.array([[0.0, 0.0, 0.0]]), "illuminant/D50").tolist()
    [[0.0, 0.0, 0.0]]
    """
    white = tristimulus(VISIBLE, light).sum(axis=0) if isinstance(light, str) else light
    ratio = xyz / white
    f = np.where(ratio > KNEE, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)
