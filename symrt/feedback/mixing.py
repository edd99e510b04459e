"""Mixtures of two spectra in a blend: along a straight line, or as Kubelka and Munk's paints (step 5 of the paper).

Of an opaque layer the ratio of absorption to scattering, ``q = K/S = (1 − r)² / 2r``, is what mixes linearly [1]_:

    q(t) = (1 − t) q_a + t q_b,        r = 1 + q − √(q² + 2q) = 1 / (1 + q + √(q² + 2q))

The second form of r loses no digits.  In each band r(t) goes one way, from r_a to r_b, below the straight line.

References
----------
.. [1] P. Kubelka and F. Munk, "Ein Beitrag zur Optik der Farbanstriche", Zeitschrift für technische Physik 12, 1931,
   pp. 593-601.
"""

from typing import Literal

import numpy as np
from jaxtyping import Float

from symrt.arrays import Spectrum
from symrt.spectra.bands import Number

Mixing = Literal["linear", "kubelka-munk"]

BLACK = 1e-100
"""A reflectance below this is none; its K/S would be more than floats hold the square of."""

Values = Float[np.ndarray, "*any"]


def absorption(r: Values) -> Values:
    """K/S of an opaque layer of reflectance r; infinite for a reflectance of 0.

    Examples
    --------
    >>> absorption(np.array([0.0, 0.5, 1.0]))
    array([ inf, 0.25, 0.  ])
    """
    with np.errstate(divide="ignore"):
        return (1 - r) ** 2 / (2 * r)


def reflected(q: Values) -> Values:
    """The reflectance of an opaque layer of this K/S.

    Examples
    --------
    >>> reflected(np.array([0.0, 0.25, np.inf]))
    array([1. , 0.5, 0. ])
    """
    return 1 / (1 + q + np.sqrt(q * (q + 2)))


def mixed(first: Values, last: Values, t: Number, mixing: Mixing = "linear") -> Values:
    """The spectrum, or matrix, at t between two, with `first` at 0 and `last` at 1 to the last bit.

    Raises
    ------
    ValueError
        If one of two paints reflects nothing in a band where the other does, or reflects more than it receives.

    Examples
    --------
    >>> white, grey = np.array([1.0]), np.array([0.5])
    >>> mixed(white, grey, 0.5), mixed(white, grey, 0.5, "kubelka-munk").round(4)
    (array([0.75]), array([0.6096]))
    """
    if mixing == "linear":
        return first * (1 - t) + last * t
    check_paints(first, last)
    return painted(first, last, np.array([t]))[0]


def painted(first: Values, last: Values, t: Float[np.ndarray, " value"]) -> Float[np.ndarray, "value ..."]:
    """Mixtures of two paints at several t, pure ones beyond 0 and 1; where both are alike, no digit changes."""
    share = t.reshape(-1, *[1] * np.ndim(first))
    moves = (first != last) & (share > 0) & (share < 1)
    q = np.where(moves, (1 - share) * _finite(absorption(first)) + share * _finite(absorption(last)), 0.0)
    return np.where(moves, reflected(q), np.where(share >= 1, last, first))


def slopes(first: Values, last: Values, t: Number, mixing: Mixing = "linear") -> tuple[Values, Values, Values]:
    """Derivatives of the mixture: by t, and by a relative change of `first` and of `last`.

    Examples
    --------
    >>> one, other = np.array([0.25]), np.array([0.75])
    >>> slopes(one, other, 0.5)
    (array([0.5]), array([0.125]), array([0.375]))
    """
    if mixing == "linear":
        return last - first, (1 - t) * first, t * last
    r = mixed(first, last, t, mixing)
    # dq/dr is −(1 − r)(1 + r) / 2r²; where both paints are alike, or the mixture white or black, a line is as good.
    straight = (first == last) | (r == 1) | (r == 0)
    safe, one, other = (np.where(straight, 0.5, spectrum) for spectrum in (r, first, last))
    size = -2 * safe * safe / ((1 - safe) * (1 + safe))

    def part(share: Number, paint: Spectrum) -> Spectrum:
        return size * share * -(1 - paint) * (1 + paint) / (2 * paint)

    by_t = size * (absorption(other) - absorption(one))
    return (
        np.where(straight, last - first, by_t),
        np.where(straight, (1 - t) * first, part(1 - t, one)),
        np.where(straight, t * last, part(t, other)),
    )


def check_paints(first: Spectrum, last: Spectrum, name: str = "the mixture") -> None:
    """Refuse pairs of paints that the theory has no mixture of."""
    if (first > 1).any() or (last > 1).any():
        raise ValueError(
            f"{name}: a paint reflects more than it receives; Kubelka and Munk's theory ends at 1; mix 'linear'"
        )
    if (((first < BLACK) | (last < BLACK)) & (first != last)).any():
        raise ValueError(
            f"{name}: one of two paints reflects nothing where the other does, and would blacken it at once: give it a "
            "little, such as 0.001, or mix 'linear'"
        )


def _finite(q: Values) -> Values:
    """K/S with 0 for infinity: a paint of reflectance 0 is only ever mixed with another of reflectance 0."""
    return np.where(np.isfinite(q), q, 0.0)
