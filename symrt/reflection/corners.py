"""The largest share of light that a surface sends on, whatever its cosines: the tail is bounded with it (step 2).

The terms of a Fresnel formula are large in turn: what is not mirrored is let through.  Bounded one by one they would
sum to more than there is.  As polynomials of the cosines they are bounded together: in Bernstein's form they are
averages of a few corners, so that the largest of these sums bounds them all [1]_.

References
----------
.. [1] G. Farin, "Curves and Surfaces for CAGD", 5th ed., 2002, section 6.3 (the convex hull property).
"""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from itertools import product
from math import comb

import sympy

from symrt.reflection.bounds import Known, largest
from symrt.reflection.polynomials import monomials
from symrt.reflection.symbols import ONE_MINUS, Factor, Parameter
from symrt.tails import Shares

Corner = tuple[Fraction, ...]
Ranges = Mapping[str, tuple[float, float]]
MOST = 64
"""Formulas of more corners than this have their coefficients bounded one by one."""


def corners(formula: sympy.Expr, ranges: Ranges) -> tuple[Shares, ...]:
    """Sums that bound the size of a formula over all cosines in [0, 1]: it is at most the largest of them.

    Examples
    --------
    A mirror whose share goes from f0 to everything, and never is both:

    >>> from symrt.reflection.symbols import n_dot_v, reflectance
    >>> f0 = reflectance("f0")
    >>> corners(f0 + (1 - f0) * (1 - n_dot_v), {})
    (((('f0',), 1.0),), (((), 1.0),))
    """
    return _corners(formula, tuple(sorted(ranges.items())))


@lru_cache(maxsize=1024)
def _corners(formula: sympy.Expr, known: Known) -> tuple[Shares, ...]:
    terms, ranges = monomials(formula), dict(known)
    found = _bernstein(list(terms.values()), ranges)
    if found is None:
        return (tuple((met, largest(c, ranges)) for met, c in terms.items()),)

    # A corner's sum and its opposite: the size is the larger of both.  One that only takes away is never the larger.
    shares = {
        tuple((met, _upwards(sign * c)) for met, c in zip(terms, corner, strict=True) if c)
        for corner in found
        for sign in (1, -1)
        if any(sign * c > 0 for c in corner)
    }
    return tuple(sorted(shares, reverse=True))


def _bernstein(coefficients: Sequence[sympy.Expr], ranges: Ranges) -> list[Corner] | None:
    """The coefficients in Bernstein's form over all cosines at once, exactly; None if they are no such polynomials."""
    # Parameters that have one value, and floats, are the fractions that they are.
    known = {
        p: sympy.Float(low)
        for c in coefficients
        for p in c.atoms(Parameter)
        for low, high in [ranges[p.name]]
        if low == high
    }
    settled = [c.xreplace(known) for c in coefficients]
    exact = [c.xreplace({f: sympy.Rational(float(f)) for f in c.atoms(sympy.Float)}) for c in settled]

    # A cosine and what is left of 1 are one variable.
    factors = {factor for c in exact for factor in c.atoms(Factor)}
    left = {f: 1 - Factor(f.name.removeprefix(ONE_MINUS)) for f in factors if f.name.startswith(ONE_MINUS)}
    exact = [c.xreplace(left) for c in exact]
    cosines = sorted({symbol for c in exact for symbol in c.free_symbols}, key=str)
    if not all(isinstance(symbol, Factor) for symbol in cosines) or not all(c.is_polynomial(*cosines) for c in exact):
        return None
    gens = cosines or [sympy.Dummy()]
    polynomials = [sympy.Poly(c, *gens) for c in exact]
    degrees = [max((p.degree(x) for p in polynomials), default=0) for x in gens]
    rational = all(c.is_Rational for p in polynomials for c in p.coeffs())
    if not rational or math.prod(n + 1 for n in degrees) > MOST:
        return None

    # From powers x^i to Bernstein's b_k = Σ_i C(k, i) / C(n, i) c_i, for each cosine.
    powers = [{at: Fraction(int(c.p), int(c.q)) for at, c in p.terms()} for p in polynomials]
    return [
        tuple(
            sum((c * _part(exponents, at, degrees) for exponents, c in terms.items()), Fraction(0)) for terms in powers
        )
        for at in product(*(range(n + 1) for n in degrees))
    ]


def _part(exponents: Sequence[int], at: Sequence[int], degrees: Sequence[int]) -> Fraction:
    return math.prod(
        (Fraction(comb(k, i), comb(n, i)) for i, k, n in zip(exponents, at, degrees, strict=True)), start=Fraction(1)
    )


def _upwards(value: Fraction) -> float:
    """A fraction as a float that is not smaller."""
    nearest = float(value)
    return nearest if Fraction(nearest) >= value else math.nextafter(nearest, math.inf)
