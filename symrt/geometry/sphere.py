"""Spheres (step 1): ``|origin + t direction − centre| = radius``.

A far, small or grazed sphere defeats the textbook discriminant.  Here it comes from the cross product,
``D = r²|d|² − |m × d|²`` with m = origin − centre [1]_: by plain arithmetic where that is enough, in pairs of floats
near the rim and near the surface, and in exact rationals where even the pair's sign is in doubt.

References
----------
.. [1] E. Haines, J. Günther and T. Akenine-Möller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
   Gems, 2019.
"""

from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import (
    Pair,
    PerRay,
    Point,
    dot,
    exact,
    negative,
    normalise,
    pair_cross,
    pair_dot,
    pair_product,
    pair_sum,
    two_product,
    two_sum,
)
from symrt.errors import hinting
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.directions import ROOM
from symrt.geometry.flats import Column
from symrt.geometry.rays import (
    ROUNDING,
    Crossing,
    Kernel,
    Rays,
    Surface,
    clearance,
    encloses,
    intersect,
    leaves,
    surface,
    translate,
)
from symrt.geometry.records import Triple, column, finite, moved, positive


@hinting
@dataclass(frozen=True)
class Sphere:
    """A sphere.

    Its coordinates are geographic: longitude 0 faces the `meridian`, u in [0, 1) runs east (counter-clockwise seen from
    above the pole) from 180° W, v in [0, 1] runs south from the pole.  The extent is that of the equator, 2πr, and of a
    meridian, πr, at every point.  `meridian` is made perpendicular to `pole`.

    Examples
    --------
    >>> Sphere(centre=(0, 1, 0), radius=1, material="red").pole
    (0, 1, 0)
    """

    centre: Triple
    radius: float | int
    material: str
    pole: Triple = (0, 1, 0)
    meridian: Triple = (0, 0, 1)
    type: Literal["sphere"] = field(default="sphere", kw_only=True)

    def __post_init__(self) -> None:
        finite("sphere", centre=self.centre, radius=self.radius, pole=self.pole, meridian=self.meridian)
        positive("sphere", radius=self.radius)
        (a, b, c), (d, e, f) = self.pole, self.meridian
        if not any((b * f - c * e, c * d - a * f, a * e - b * d)):
            raise ValueError(
                f"sphere: pole = {self.pole} and meridian = {self.meridian}: they must not be zero or parallel"
            )

    @cached_property
    def squared_radius(self) -> Pair:
        """The square of the radius, as a pair."""
        return two_product(np.array([self.radius], float), np.array([self.radius], float))

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form."""
        radius, (high, low) = float(self.radius), self.squared_radius
        constants = [*self.centre, radius, radius**2, high[0], low[0], self.radius * (1 + 1e-9)]
        return Kernel("symrt.geometry.fast.quadrics", "sphere", (tuple(map(float, constants)),))

    @cached_property
    def surface_kernel(self) -> Kernel:
        """The compiled form of its surface."""
        radius = float(self.radius)
        reach = np.abs(column(self.centre)).max()
        constants = (*self.centre, radius, reach, 2 * np.pi * radius, np.pi * radius)
        return Kernel(ROOM, "sphere", (tuple(map(float, constants)),))


@intersect.register(Sphere)
def intersect_sphere(sphere: Sphere, rays: Rays, low: float = 0.0) -> Crossing:
    """Nearest crossing with a sphere beyond `low`: within 10 ulp, and hit or miss as in exact arithmetic.

    Examples
    --------
    The ray of this example passes at a distance of exactly one radius, and touches:

    >>> ray = Rays(origin=np.array([[0.0], [1.0], [0.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> intersect_sphere(Sphere((0, 0, -5), 1, "red"), ray).distance
    array([5.])
    """
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        m = rays.origin - column(sphere.centre)
        square = _squared_across(m, rays.direction)
        chosen = np.flatnonzero(square <= _room(sphere, m) ** 2)
        enter, leave, sure = _plain(sphere, m.take(chosen, axis=1), rays.direction.take(chosen, axis=1), square[chosen])
        hard = np.flatnonzero(~sure)
        enter[hard], leave[hard] = _careful(sphere, rays[chosen[hard]])
        first = np.where(enter > low, enter, np.where(leave > low, leave, np.inf))
    distance[chosen] = first
    primitive[chosen[first < np.inf]] = 0
    return Crossing(distance, primitive)


def _squared_across(m: Float[np.ndarray, "3 ray"], d: Float[np.ndarray, "3 ray"]) -> PerRay:
    """``|m × d|²``, the squared distance of each line from the centre, by plain arithmetic."""
    x, y, z = m[1] * d[2] - m[2] * d[1], m[2] * d[0] - m[0] * d[2], m[0] * d[1] - m[1] * d[0]
    return x * x + y * y + z * z


def _room(sphere: Sphere, m: Float[np.ndarray, "3 ray"]) -> PerRay:
    """The largest distance from the centre, by plain arithmetic, of a line that may still meet the sphere."""
    return sphere.radius * (1 + 1e-9) + 16 * ROUNDING * (np.abs(m[0]) + np.abs(m[1]) + np.abs(m[2]))


def _plain(
    sphere: Sphere, m: Float[np.ndarray, "3 ray"], d: Float[np.ndarray, "3 ray"], square: PerRay
) -> tuple[PerRay, PerRay, Bool[np.ndarray, " ray"]]:
    """Both crossings by plain arithmetic, and where they are good.

    That is far from the rim, from a radius away or more, and not so far away that the distance of the line from the
    centre is rounding noise.  The distance is then wrong by 17.9u at most, u = 2⁻⁵³, if all of its 38 roundings were
    the worst, to first order: that is less than 18 units in the last place, and 8 were the most of 6 million rays
    drawn where they add up, at the rim of what is let through.
    """
    squared_radius = float(sphere.radius) ** 2
    a, b, distance = dot(d, d), dot(m, d), dot(m, m)
    sure = (square <= 0.75 * squared_radius) & (distance >= 4 * squared_radius)
    sure &= 64 * ROUNDING * (np.abs(m[0]) + np.abs(m[1]) + np.abs(m[2])) <= sphere.radius
    q = -(b + np.copysign(np.sqrt(a * squared_radius - square), b))
    larger, smaller = q / a, (distance - squared_radius) / q
    return np.minimum(larger, smaller), np.maximum(larger, smaller), sure


def _careful(sphere: Sphere, rays: Rays) -> tuple[PerRay, PerRay]:
    """Both crossings in pairs of floats; nan where a ray misses, or leaves the sphere behind."""
    m, squared_radius = two_sum(rays.origin, -column(sphere.centre)), sphere.squared_radius
    enter, leave = np.full((2, len(rays)), np.nan)
    # A ray that starts outside and goes outwards is done; whether it does start outside, pairs tell if need be.
    outwards = dot(m[0], rays.direction) > 1e-9 * np.abs(m[0]).max(axis=0, initial=0)
    ahead = np.flatnonzero(~(outwards & _surely_outside(sphere, m[0])))
    m = (m[0].take(ahead, axis=1), m[1].take(ahead, axis=1))
    c = pair_sum(pair_dot(m, m), negative(squared_radius))[0]
    open_ = np.flatnonzero((c < 0) | ~outwards[ahead])
    ahead, c, m = ahead[open_], c[open_], (m[0].take(open_, axis=1), m[1].take(open_, axis=1))
    d = exact(rays.direction.take(ahead, axis=1))
    a, b = pair_dot(d, d), pair_dot(m, d)[0]
    root = np.sqrt(_discriminant(sphere, m, d, pair_product(a, squared_radius)))

    # Of the two roots of a t² + 2 b t + c the larger comes without cancellation, the other from their product c/a.
    q = -(b + np.copysign(root, b))
    larger = q / a[0]
    smaller = np.where(q == 0, 0.0, c / np.where(q == 0, 1.0, q))
    enter[ahead], leave[ahead] = np.minimum(larger, smaller), np.maximum(larger, smaller)
    return enter, leave


def _surely_outside(sphere: Sphere, m: Float[np.ndarray, "3 ray"]) -> Bool[np.ndarray, " ray"]:
    """Whether a point at m from the centre, m rounded, is outside whatever the rounding did.

    With u = 2⁻⁵³: rounding m changes |m|² by 2u|m|² and a little, the plain product by 3u|m|², r² by ur², and their
    difference by no more than u(|m|² + r²): in all less than 8u(|m|² + r²), itself rounded.
    """
    square, squared_radius = dot(m, m), float(sphere.radius) ** 2
    return square - squared_radius > 16 * ROUNDING * (square + squared_radius)


def _discriminant(sphere: Sphere, m: Pair, d: Pair, reach: Pair) -> PerRay:
    """``reach − |m × d|²``, nan where it is negative."""
    across = pair_cross(m, d)
    value = pair_sum(reach, negative(pair_dot(across, across)))[0]
    size = np.sqrt(dot(m[0], m[0])) + sphere.radius
    # 2⁻⁹⁸ bounds the pairs' rounding and 2⁻⁹⁶⁰ their underflow; a sign within that is decided exactly.
    doubtful = np.abs(value) <= 2.0**-98 * size * sphere.radius + 2.0**-960
    for ray in np.flatnonzero(doubtful):
        if _misses_exactly(sphere, m, d, int(ray)):
            value[ray] = np.nan
    return np.where(doubtful, np.abs(value), np.where(value >= 0, value, np.nan))


def _misses_exactly(sphere: Sphere, m: Pair, d: Pair, ray: int) -> bool:
    """Whether the line misses the sphere, in rational arithmetic."""
    p = [Fraction(float(m[0][i, ray])) + Fraction(float(m[1][i, ray])) for i in range(3)]
    q = [Fraction(float(d[0][i, ray])) for i in range(3)]
    across = [p[i] * q[j] - p[j] * q[i] for i, j in ((1, 2), (2, 0), (0, 1))]
    return Fraction(sphere.radius) ** 2 * sum(x * x for x in q) < sum(x * x for x in across)


@surface.register(Sphere)
def surface_sphere(sphere: Sphere, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Surface of a sphere where rays meet it, with geographic coordinates.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [0.0], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> surface_sphere(Sphere((0, 0, 0), 1, "red"), ray, np.array([2.0]), np.zeros(1, np.int32)).uv.T
    array([[0.5, 0.5]])
    """
    centre, radius = column(sphere.centre), float(sphere.radius)
    offset = ((rays.origin - centre) + distance * rays.direction) / radius
    size = np.sqrt(dot(offset, offset))
    if not size.all():
        # From so far away that the ray's end, rounded, is the centre: the side that it comes from.
        offset, size = np.where(size > 0, offset, -rays.direction), np.where(size > 0, size, 1.0)
    normal = offset / size
    point = centre + radius * normal
    error = 8 * ROUNDING * (np.abs(point).max(axis=0, initial=0) + np.abs(centre).max() + radius)
    extent = np.broadcast_to([[2 * np.pi * radius], [np.pi * radius]], (2, len(rays))).copy()
    return Surface(point, normal, normal, _geographic(sphere, normal), extent, error)


def _geographic(sphere: Sphere, normal: Float[np.ndarray, "3 ray"]) -> Float[np.ndarray, "2 ray"]:
    meridian, east, pole = _axes(tuple(sphere.pole), tuple(sphere.meridian))
    x, y, up = dot(normal, meridian), dot(normal, east), dot(normal, pole)
    u = np.arctan2(y, x) / (2 * np.pi) + 0.5
    v = np.arctan2(np.hypot(x, y), up) / np.pi
    return np.stack([np.where(u >= 1, 0.0, u), v])


@lru_cache(256)
def _axes(pole: Triple, meridian: Triple) -> tuple[Column, Column, Column]:
    """Unit vectors to the meridian, to the east of it, and to the pole; many spheres share them."""
    up, ahead = normalise(column(pole)), normalise(column(meridian))
    ahead = normalise(ahead - dot(ahead, up) * up)
    return ahead, np.cross(up, ahead, axis=0), up


@bounds.register(Sphere)
def bounds_sphere(sphere: Sphere) -> Corners:
    """The cube around a sphere.

    Examples
    --------
    >>> bounds_sphere(Sphere((0, 0, 0), 1, "red")).tolist()
    [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
    """
    centre = np.array(sphere.centre, dtype=float)
    return np.stack([centre - sphere.radius, centre + sphere.radius])


@translate.register(Sphere)
def translate_sphere(sphere: Sphere, by: Point) -> Sphere:
    """The sphere moved `by` a vector.

    Examples
    --------
    >>> translate_sphere(Sphere((1, 0, 0), 1, "red"), np.array([0.0, 2.0, 0.0])).centre
    (1.0, 2.0, 0.0)
    """
    return replace(sphere, centre=moved(sphere.centre, by))


@leaves.register(Sphere)
def leaves_sphere(sphere: Sphere) -> tuple[bool, bool]:  # noqa: ARG001
    """A sphere is convex.

    Examples
    --------
    >>> leaves_sphere(Sphere((0, 0, 0), 1, "red"))
    (True, False)
    """
    return True, False


@encloses.register(Sphere)
def encloses_sphere(sphere: Sphere, point: Point) -> bool:
    """Whether `point` is strictly inside.

    Examples
    --------
    >>> encloses_sphere(Sphere((0, 0, 0), 1, "red"), np.array([1.0, 0.0, 0.0]))
    False
    """
    return bool(np.linalg.norm(point - np.array(sphere.centre)) < sphere.radius)


@clearance.register(Sphere)
def clearance_sphere(sphere: Sphere, point: Point) -> float:
    """Distance from `point` to the sphere, from outside or inside.

    Examples
    --------
    >>> clearance_sphere(Sphere((0, 0, 0), 1, "red"), np.zeros(3))
    1.0
    """
    return float(abs(np.linalg.norm(point - np.array(sphere.centre)) - sphere.radius))
