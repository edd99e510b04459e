"""Points that fill a square evenly, a set of its own for each of many pixels (step 1).

The points are a (0, 2)-sequence: van der Corput's radical inverse, and the second dimension of Sobol's sequence [1]_.
Of the first 2^m points one lies in each rectangle of area 2^-m with sides of powers of two.  Every set has the same
points with some of the bits of both coordinates flipped, which keeps that; a hash [2]_ of the set's number says which.

References
----------
.. [1] T. Kollig and A. Keller, "Efficient Multidimensional Sampling", Computer Graphics Forum 21(3), 2002, section 3.
.. [2] G. L. Steele, D. Lea and C. H. Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014, figure 15.
"""

from functools import cache

import numpy as np
from jaxtyping import Float, Int, UInt

from symrt.tracing.sobol import BITS, sequence


def net(number: Int[np.ndarray, " set"], count: int) -> Float[np.ndarray, "2 set point"]:
    """The points of the numbered sets, in the square from 0 to 1.

    Examples
    --------
    Of four points one is in each quarter:

    >>> (net(np.array([7]), 4)[:, 0] // 0.5).T.tolist()
    [[1.0, 1.0], [0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    """
    flips = hashed(number.astype(np.uint64))
    halves = np.stack([flips >> np.uint64(BITS), flips & np.uint64(2**BITS - 1)])
    # Half a step off the lattice: no coordinate is 0 or 1.
    return ((_sequence(count)[:, None, :] ^ halves[:, :, None]).astype(float) + 0.5) * 2.0**-BITS


def disk(square: Float[np.ndarray, "2 *point"]) -> Float[np.ndarray, "2 *point"]:
    """Points of the square from 0 to 1, brought to the unit disk: areas stay equal, squares become rings [1]_.

    References
    ----------
    .. [1] P. Shirley and K. Chiu, "A Low Distortion Map Between Disk and Square", Journal of Graphics Tools 2(3), 1997.

    Examples
    --------
    >>> disk(np.array([[0.5, 1.0], [0.5, 0.5]]))
    array([[0., 1.],
           [0., 0.]])
    """
    a, b = 2 * square - 1
    # The ring, and the way along it from the nearest of four axes: an eighth of a turn is 1.
    aside = np.abs(a) > np.abs(b)
    radius, other = np.where(aside, a, b), np.where(aside, b, a)
    turn = np.pi / 4 * other / np.where(radius == 0, 1.0, radius)
    along, across = radius * np.cos(turn), radius * np.sin(turn)
    return np.stack([np.where(aside, along, across), np.where(aside, across, along)])


@cache
def _sequence(count: int) -> UInt[np.ndarray, "2 point"]:
    """The first points of the sequence, as whole numbers of 2⁻³²."""
    points = np.stack([sequence(count, dimension) for dimension in (0, 1)]).astype(np.uint64)
    points.flags.writeable = False
    return points


def hashed(number: UInt[np.ndarray, " set"]) -> UInt[np.ndarray, " set"]:
    """64 bits, each of which hangs on all bits of a number: SplitMix64.

    Examples
    --------
    >>> hashed(np.array([0, 1], dtype=np.uint64)).tolist()
    [16294208416658607535, 7960286522194355700]
    """
    z = (number + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ z >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ z >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
    return z ^ z >> np.uint64(31)
