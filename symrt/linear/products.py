"""Products of the reflectances that light meets on a path (step 2)."""

from collections.abc import Callable

from symrt.interactions import normal_order
from symrt.reflection.polynomials import Monomial

Product = Callable[[Monomial, Monomial], Monomial]
"""The product of the reflectances on a path and of those it meets next, further from the eye."""


def commuting(path: Monomial, met: Monomial) -> Monomial:
    """The product of reflectances that commute, sorted so that their order does not matter."""
    return tuple(sorted(path + met))


def around_fluorescence(path: Monomial, met: Monomial) -> Monomial:
    """The product where some reflectance is fluorescent: the others commute, but none with it."""
    return normal_order(met + path)


def in_order(path: Monomial, met: Monomial) -> Monomial:
    """The product in the order in which light meets the reflectances, from the light to the eye."""
    return met + path
