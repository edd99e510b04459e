"""Fresnel's reflectance of metals, approximated by formulas that are affine in reflectances (step 1).

A polished metal mirrors ``f0`` of what arrives along the normal, and everything that grazes it.  In between `schlick`
[1]_ rises steadily; real metals dip first, and `f82` [2]_ is bent to what they reflect at about 82°.  Of the nine
metals of `symrt.spectra.metals`, over all angles and 380 … 730 nm, the largest errors against Fresnel's exact equations
are

=========  =======  =====
metal      schlick  f82
=========  =======  =====
silver     0.007    0.002
gold       0.028    0.022
brass      0.049    0.023
copper     0.050    0.012
aluminium  0.162    0.037
nickel     0.164    0.013
iron       0.170    0.012
titanium   0.197    0.020
chrome     0.245    0.043
=========  =======  =====

References
----------
.. [1] C. Schlick, "An Inexpensive BRDF Model for Physically-based Rendering", Computer Graphics Forum 13(3), 1994.
.. [2] P. Kutz, M. Hašan and J. Edmondson, "Novel Aspects of the Adobe Standard Material", Adobe, 2021 (2023): the F82
   tint, a correction by Lazányi and Szirmay-Kalos's error term that vanishes at 0° and at 90°.
"""

import sympy

from symrt.reflection.symbols import GEOMETRY, ONE_MINUS, Factor, Reflectance

MEETING = sympy.Rational(1, 7)
"""The cosine at which `f82` is exact, of about 82°: there x (1 − x)^6 is largest."""


def schlick(f0: Reflectance | sympy.Expr, cosine: sympy.Expr) -> sympy.Expr:
    """Schlick's approximation, ``f0 + (1 − f0)(1 − x)^5``, with x the cosine to the normal or to the half vector.

    Examples
    --------
    >>> from symrt.reflection.symbols import n_dot_v, reflectance
    >>> schlick(reflectance("f0"), n_dot_v)
    f0 + (1 - n_dot_v)**5*(1 - f0)
    """
    return f0 + (1 - f0) * one_minus(cosine) ** 5


def f82(at_normal: Reflectance | sympy.Expr, at_82: Reflectance | sympy.Expr, cosine: sympy.Expr) -> sympy.Expr:
    """Schlick's approximation, bent by ``w = x (1 − x)^6 / max`` to be `at_82` where x is 1/7; w is 0 at 0° and 90°.

    It is affine in both reflectances, but the constant and the weight of `at_normal` fall to −0.13 at some angles.  So
    the curve dips below 0 where both are nearly black, below 0.11, and passes 1 where `at_82` is far above what
    `schlick` has there: both are a metal's, and belong together.

    Examples
    --------
    >>> from symrt.reflection.symbols import n_dot_v
    >>> f82(sympy.Float(0.5), sympy.Float(0.6), n_dot_v).subs({n_dot_v: 1 / 7, Factor("one_minus_n_dot_v"): 6 / 7})
    0.6...
    """
    x, away = cosine, one_minus(cosine)
    # Floats, which text and LaTeX shorten: as fractions they have six digits above and below the line.
    most = float(MEETING * (1 - MEETING) ** 6)
    schlick_there = at_normal + (1 - at_normal) * sympy.Float(float((1 - MEETING) ** 5))
    return schlick(at_normal, cosine) + sympy.Float(1 / most) * x * away**6 * (at_82 - schlick_there)


def one_minus(cosine: sympy.Expr) -> Factor:
    """The factor 1 − x of a cosine x, which keeps the digits that a cosine near 1 has lost.

    Examples
    --------
    >>> from symrt.reflection.symbols import n_dot_v
    >>> one_minus(n_dot_v)
    (1 - n_dot_v)
    """
    if not isinstance(cosine, Factor) or cosine.name not in GEOMETRY:
        raise ValueError(f"{cosine} is none of the cosines {', '.join(GEOMETRY)}")
    return Factor(ONE_MINUS + cosine.name)
