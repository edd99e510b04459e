"""Unit vectors of many (step 1): those of `symrt.arrays`, compiled where that pays, to the same bits."""

import numpy as np

from symrt import fast
from symrt.arrays import PerRay, Vectors, normalise

ROOM = "symrt.geometry.fast.surfaces"
"""The kernels for surfaces, and for what starts there."""


def unit_vectors(v: Vectors) -> Vectors:
    """Unit vectors along `v`, as `normalise` has them.

    Examples
    --------
    >>> unit_vectors(np.array([[0.0], [3.0], [4.0]])).T.tolist()
    [[0.0, 0.6, 0.8]]
    """
    found = by_kernel(v)
    return normalise(v) if found is None else found[0]


def by_kernel(v: Vectors) -> tuple[Vectors, PerRay] | None:
    """Unit vectors along `v`, and its lengths; None where NumPy is to do it.

    That is where kernels do not pay, and where some component is 0, or between 2⁻⁴⁰⁰ and 2⁴⁰⁰ in size, of not all
    vectors, or a vector is zero: scaling by a power of two, which takes care of those, changes no bit of the others.

    Examples
    --------
    >>> by_kernel(np.zeros((3, 1))) is None
    True
    """
    kernels = fast.kernels(ROOM, v.shape[1])
    if kernels is None or v.dtype != np.float64:
        return None
    unit, size = np.empty(v.shape), np.empty(v.shape[1])
    return None if kernels.units(whole_rows(v), unit, size) else (unit, size)


def whole_rows(values: np.ndarray) -> np.ndarray:
    """The same numbers as kernels take them: row by row, in memory that may be written.

    Examples
    --------
    >>> whole_rows(np.ones((2, 3)).T).flags.c_contiguous
    True
    """
    fit = values.flags.c_contiguous and values.flags.writeable
    return values if fit else np.array(values, order="C")
