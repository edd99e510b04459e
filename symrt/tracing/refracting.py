"""Light at a smooth surface between two media: Snell's law and Fresnel's formulas (step 1).

With the angle i to the normal, the angle t beyond it and η = n₁/n₂, sin t = η sin i.  The shares are written without
differences of nearly equal numbers [1]_: since (η cos i)² − cos² t = η² − 1, the amplitude of the polarisation across
the plane of incidence is (η² − 1)/(η cos i + cos t)², and the share that is let through is formed directly.

References
----------
.. [1] M. Born and E. Wolf, "Principles of Optics", 7th ed., 1999, section 1.5.2.
"""

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from symrt.arrays import (
    PerRay,
    Vectors,
    exact,
    negative,
    pair_cross,
    pair_dot,
    pair_product,
    pair_sum,
    two_product,
)


class Interface(NamedTuple):
    """What becomes of light that meets a smooth surface.

    Parameters
    ----------
    bent
        Unit vectors along which the view goes on beyond the surface; zero where it does not.
    mirrored, through
        The shares of unpolarised light that are mirrored and let through; they sum to 1.
    """

    bent: Vectors
    mirrored: PerRay
    through: PerRay


def interface(normal: Vectors, viewer: Vectors, eta: PerRay) -> Interface:
    """Bend views at a surface, and share out the light between both ways.

    Parameters
    ----------
    normal, viewer
        Unit vectors; the normal is on the viewer's side.
    eta
        Index on the viewer's side over that on the other.

    Examples
    --------
    Straight onto glass of index 1.5, 4 % is mirrored; from inside, at 45°, all of it:

    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> interface(up, up, np.array([1 / 1.5])).mirrored.round(12)
    array([0.04])
    >>> interface(up, np.array([[0.5**0.5], [0.5**0.5], [0.0]]), np.array([1.5])).through
    array([0.])
    """
    # The squares of sin t, of the cosines, and the sizes of the vectors, in pairs: near the critical angle and near
    # grazing they are small differences.
    n, v = exact(normal), exact(viewer)
    across = pair_cross(n, v)
    sine, whole = pair_dot(across, across), pair_product(pair_dot(n, n), pair_dot(v, v))
    square = two_product(eta, eta)
    left = pair_sum(whole, negative(pair_product(square, sine)))[0]
    total = _totally_reflected(normal, viewer, eta, left)
    size = np.sqrt(whole[0])
    cos_i = np.abs(pair_dot(n, v)[0]) / size
    cos_t = np.where(total, 0.0, np.sqrt(np.maximum(left, 0.0)) / size)
    cos_t = np.where(eta == 1, cos_i, cos_t)

    # Fresnel's shares of both polarisations; grazing from the thinner side, 0/0 is no light at all.
    with np.errstate(divide="ignore", invalid="ignore"):
        s, p = eta * cos_i + cos_t, cos_i + eta * cos_t
        contrast = (eta - 1) * (eta + 1)
        sine_squared = sine[0] / whole[0]
        mirrored_s = (contrast / (s * s)) ** 2
        mirrored_p = (contrast * (1 - sine_squared * (1 + eta * eta)) / (p * p)) ** 2
        mirrored = np.minimum((mirrored_s + mirrored_p) / 2, 1.0)
        through = np.minimum(2 * eta * cos_i * cos_t * (1 / (s * s) + 1 / (p * p)), 1.0)
    # The smaller share has all its digits, and the other is what it leaves.
    mirrored = np.where(through < mirrored, 1 - through, mirrored)
    through = np.where(through < mirrored, through, 1 - mirrored)
    # Equal indices make no surface.
    nothing, all_of_it = (s == 0) | (p == 0) | total, eta == 1
    mirrored = np.where(all_of_it, 0.0, np.where(nothing, 1.0, mirrored))
    through = np.where(all_of_it, 1.0, np.where(nothing, 0.0, through))

    bent = (eta * cos_i - cos_t) * normal - eta * viewer
    length = np.sqrt(np.sum(bent * bent, axis=0))
    bent = np.where(total, 0.0, bent / np.where(length > 0, length, 1.0))
    return Interface(bent, mirrored, through)


def _totally_reflected(normal: Vectors, viewer: Vectors, eta: PerRay, left: PerRay) -> Bool[np.ndarray, " ray"]:
    """Whether nothing goes through, as in exact arithmetic: ``left`` is what remains below the critical angle."""
    total = left < 0
    # 2⁻⁹⁶ bounds the pairs' rounding of a difference of numbers of about 1, times the largest index squared.
    doubtful = np.flatnonzero(np.abs(left) <= 2.0**-96 * np.maximum(1.0, eta * eta))
    for ray in doubtful[eta[doubtful] > 1]:
        n, v = ([Fraction(float(x)) for x in vector[:, ray]] for vector in (normal, viewer))
        across = [n[i] * v[j] - n[j] * v[i] for i, j in ((1, 2), (2, 0), (0, 1))]
        whole = sum(x * x for x in n) * sum(x * x for x in v)
        total[ray] = Fraction(float(eta[ray])) ** 2 * sum(x * x for x in across) > whole
    return total
