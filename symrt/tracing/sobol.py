"""Sobol's sequence in base 2: points that fill a cube evenly, in any number (step 1).

In each of the first dimensions 2^m consecutive points stand one in each of 2^m equal intervals, and the first two
dimensions together are a (0, 2)-sequence.  Flipping the same binary digits in all points keeps this [1]_.

References
----------
.. [1] T. Kollig and A. Keller, "Efficient Multidimensional Sampling", Computer Graphics Forum 21(3), 2002.
.. [2] S. Joe and F. Y. Kuo, "Constructing Sobol sequences with better two-dimensional projections", SIAM J. Sci.
   Comput. 30, 2008: primitive polynomials and initial direction numbers, new-joe-kuo-6.21201.
"""

from functools import cache

import numpy as np
from jaxtyping import UInt32

BITS = 32
"""Binary digits of each coordinate."""
TABLE = (
    "1:1 3:1 7:1,3 11:1,3,1 13:1,1,1 19:1,1,3,3 25:1,3,5,13 37:1,1,5,5,17 41:1,1,5,5,5 47:1,1,7,11,19 "
    "55:1,1,5,1,1 59:1,1,1,3,11 61:1,3,5,5,31 67:1,3,3,9,7,49 91:1,1,1,15,21,21 97:1,3,1,13,27,49 "
    "103:1,1,1,15,7,5 109:1,3,1,15,13,25 115:1,1,5,5,19,61 131:1,3,7,11,23,15,103 137:1,3,7,13,13,15,69 "
    "143:1,1,3,13,7,35,63 145:1,3,5,9,1,25,53 157:1,3,1,13,9,35,107 167:1,3,1,5,27,61,31 171:1,1,5,11,19,41,61 "
    "185:1,3,5,3,3,13,69 191:1,1,7,13,1,19,1 193:1,3,7,5,13,19,59 203:1,1,3,9,25,29,41 211:1,3,5,13,23,1,55 "
    "213:1,3,7,3,13,59,17"
)
"""Of each dimension the primitive polynomial, as a binary number, and its initial direction numbers [2]_."""
DIMENSIONS = len(TABLE.split())


@cache
def sequence(count: int, dimension: int) -> UInt32[np.ndarray, " count"]:
    """The first points of the sequence in one dimension, as binary fractions of 32 digits.

    Examples
    --------
    >>> (sequence(4, 0) / 2**32).tolist(), (sequence(4, 1) / 2**32).tolist()
    ([0.0, 0.5, 0.25, 0.75], [0.0, 0.5, 0.75, 0.25])
    """
    numbers, points = np.arange(count), np.zeros(count, dtype=np.uint32)
    for digit, direction in enumerate(_directions(dimension)[: max(1, count - 1).bit_length()]):
        points ^= np.where(numbers >> digit & 1, direction, np.uint32(0))
    return points


def _directions(dimension: int) -> UInt32[np.ndarray, " digit"]:
    """Direction numbers: one is added, without carrying, for each binary digit that the point's number has."""
    if dimension == 0:
        return np.uint32(1) << np.arange(BITS - 1, -1, -1, dtype=np.uint32)
    polynomial, initial = TABLE.split()[dimension].split(":")
    degree, found = int(polynomial).bit_length() - 1, [int(m) for m in initial.split(",")]

    # Bratley and Fox's recurrence, in whole numbers of growing length.
    for k in range(degree, BITS):
        number = found[k - degree] ^ found[k - degree] << degree
        for j in range(1, degree):
            if int(polynomial) >> (degree - j) & 1:
                number ^= found[k - j] << j
        found.append(number)
    return np.array([m << (BITS - 1 - k) for k, m in enumerate(found)], dtype=np.uint32)
