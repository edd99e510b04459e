"""Metals by name: their optical constants, and what they reflect, for step 3 of the paper.

A metal's index of refraction is complex, n + ik, and differs at each wavelength.  Fresnel's equations [1]_ say what its
polished surface reflects of unpolarised light at any angle; at the normal and at about 82° they give the reflectances
``f0`` and ``f82`` of the models ``metal`` and ``metal_f82``.

References
----------
.. [1] M. Born and E. Wolf, "Principles of Optics", 7th edition, 1999, §14.2.
"""

import json
from functools import cache
from importlib import resources

import numpy as np
from jaxtyping import Float, Inexact

from symrt.arrays import Spectrum
from symrt.errors import suggestion
from symrt.spectra.bands import Bands, Number, resample

ANGLES = {"": 1.0, " f82": 1 / 7}
"""Cosine at which a metal's reflectance is meant: ``gold`` is its F0, ``gold f82`` its F82."""

Real = Float[np.ndarray, "..."] | Number
Complex = Inexact[np.ndarray, "..."] | Number | complex


def conductor_reflectance(n: Real, k: Real, cosine: Real) -> Real:
    """Share of unpolarised light that a polished surface of index n + ik reflects in air, by Fresnel's equations.

    Parameters
    ----------
    n, k
        The index of refraction, above 0, and the extinction coefficient, 0 or more; such as one a band.
    cosine
        Of the angle to the normal, in [0, 1]; all three are broadcast.

    Examples
    --------
    At the normal it is ((n − 1)² + k²) / ((n + 1)² + k²), along the surface 1:

    >>> conductor_reflectance(0.2, 3.0, np.array([1.0, 1 / 7, 0.0])).round(4)
    array([0.9234, 0.946 , 1.    ])
    """
    n, k, cosine = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (n, k, cosine)))
    for name, values, right, rule in (
        ("n", n, n > 0, "an index of refraction is above 0"),
        ("k", k, k >= 0, "an extinction coefficient is 0 or more"),
        ("cosine", cosine, (cosine >= 0) & (cosine <= 1), "a cosine lies in [0, 1]; give cos θ, not the angle"),
    ):
        if not np.all(right & np.isfinite(values)):
            raise ValueError(f"{name} = {values[~(right & np.isfinite(values))].flat[0]}: {rule}")

    # The cosine within the metal, times its index; differences of squares are products, as n may be close to k.
    within = np.sqrt(((n - 1) * (n + 1) - k**2 + cosine**2) + 2j * n * k)
    permittivity = (n - k) * (n + k) + 2j * n * k

    # The light whose field lies along the surface, and that whose field lies in the plane of incidence.
    along = _amplitude(cosine, within)
    across = _amplitude(permittivity * cosine, within)
    return (np.abs(along) ** 2 + np.abs(across) ** 2) / 2


def _amplitude(outside: Complex, inside: Complex) -> Complex:
    """(a − b) / (a + b), and 0 where both are 0: light along a surface where nothing changes."""
    total = outside + inside
    return (outside - inside) / np.where(total == 0, 1.0, total)


def metals() -> tuple[str, ...]:
    """Names of the metals whose optical constants are known.

    Examples
    --------
    >>> metals()
    ('gold', 'silver', 'copper', 'brass', 'aluminium', 'chrome', 'iron', 'nickel', 'titanium')
    """
    return tuple(_tables())


def optical_constants(metal: str, bands: Bands) -> tuple[Spectrum, Spectrum]:
    """Index of refraction n and extinction coefficient k of a metal at some wavelengths, linearly interpolated.

    Raises
    ------
    ValueError
        If there is no such metal, or it was not measured at all of the wavelengths.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> n, k = optical_constants("gold", wavelengths(450, 650, 100))
    >>> n.round(3), k.round(3)
    (array([1.383, 0.424, 0.156]), array([1.916, 2.472, 3.602]))
    """
    if metal not in _tables():
        raise ValueError(f"no metal is called {metal!r}: {suggestion(metal, metals())}")
    nm, n, k = _tables()[metal]
    return resample(nm, n, bands, f"metal/{metal}"), resample(nm, k, bands, f"metal/{metal}")


def metal_reflectance(name: str, bands: Bands) -> Spectrum:
    """F0 of a metal, ``gold``, or its reflectance at the angle of cosine 1/7, about 82°, ``gold f82``.

    Examples
    --------
    >>> from symrt.spectra.bands import wavelengths
    >>> metal_reflectance("gold", wavelengths(450, 650, 100)).round(3)
    array([0.408, 0.792, 0.957])
    """
    metal, space, angle = name.partition(" ")
    return np.asarray(conductor_reflectance(*optical_constants(metal, bands), ANGLES[space + angle]))


def metal_names() -> tuple[str, ...]:
    """Names of the reflectances of all metals, ``gold`` and ``gold f82``."""
    return tuple(metal + angle for angle in ANGLES for metal in metals())


@cache
def _tables() -> dict[str, tuple[Float[np.ndarray, " sample"], ...]]:
    text = (resources.files("symrt") / "data" / "metals.json").read_text(encoding="utf-8")
    return {metal: tuple(np.array(table["nm, n, k"]).T) for metal, table in json.loads(text).items()}
