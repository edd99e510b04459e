"""Exact rationals and 50 digits for the laws of geometry: nothing here uses symrt's arithmetic."""

import mpmath
import numpy as np
from flint import fmpq

from symrt.geometry import Rays

mpmath.mp.dps = 50


def rational(values):
    """The exact values of floats."""
    ratios = [float(v).as_integer_ratio() for v in np.ravel(values)]
    return [fmpq(*ratio) for ratio in ratios]


def inner(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def outer(a, b):
    return [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]


def minus(a, b):
    return [x - y for x, y in zip(a, b, strict=True)]


def digits(value):
    """A rational to 50 digits."""
    return mpmath.mpf(int(value.p)) / mpmath.mpf(int(value.q))


def first_root(a, b, c):
    """Smallest positive root of a t² + 2 b t + c = 0 to 50 digits, or None; signs are decided exactly."""
    discriminant = b * b - a * c
    if discriminant < 0:
        return None
    root = mpmath.sqrt(digits(discriminant))
    a_, b_, c_ = digits(a), digits(b), digits(c)
    if c > 0:
        # Both roots have the sign of −b; the nearer one without cancellation.
        return c_ / (-b_ + root) if b < 0 else None
    if c < 0:
        return (-b_ + root) / a_ if b < 0 else -c_ / (b_ + root)
    return -2 * b_ / a_ if b < 0 else None


def sphere_distance(origin, direction, centre, radius):
    """Distance to a sphere, or None."""
    d, m = rational(direction), minus(rational(origin), rational(centre))
    return first_root(inner(d, d), inner(m, d), inner(m, m) - rational(radius)[0] ** 2)


def ulps(found, true):
    """Distance of a float from the true value, in units of its last place."""
    return float(abs(mpmath.mpf(float(found)) - true) / mpmath.mpf(float(np.spacing(abs(float(found))))))


def directions(generator, count):
    """Unit vectors, uniform over the sphere."""
    v = generator.normal(size=(3, count))
    return v / np.sqrt((v * v).sum(axis=0))


def across(generator, direction):
    """A unit vector perpendicular to each direction."""
    v = np.cross(direction, directions(generator, direction.shape[1]), axis=0)
    return v / np.sqrt((v * v).sum(axis=0))


def rays(origin, direction):
    return Rays(np.ascontiguousarray(origin), np.ascontiguousarray(direction))
