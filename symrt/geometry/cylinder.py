"""Cylinders (step 1): the points within `radius` of an axis, between two planes across it.

With A = top − base, m = origin − base and w = direction × A, the ray meets the endless cylinder where
``t²|w|² + 2t (m × A)·w + |m × A|² − r²|A|² = 0``, and the discriminant is ``|A|² (r²|w|² − (m·w)²)``.  A ray nearly
along the axis loses half its digits in w, so all of it is done in pairs of floats.  A capped cylinder is the meeting of
that with a slab: intervals of the ray are intersected, so that no ray slips through the seam between side and cap.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import (
    Pair,
    PerRay,
    Point,
    dot,
    exact,
    length,
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
from symrt.geometry.flats import Flat, flat_surface, plane_axes
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

SIDE, BASE, TOP = 0, 1, 2


@hinting
@dataclass(frozen=True)
class Cylinder:
    """A cylinder from the centre of its base to the centre of its top, closed by discs or, uncapped, an open tube.

    On the side u in [0, 1) runs counter-clockwise seen from above the top, from the side opposite to the u axis that a
    plane with the normal top − base would have (see planes.py), v in [0, 1] down from the top; the extent is (2πr,
    height).  The caps have the coordinates of disks with the outward normal.

    Examples
    --------
    >>> Cylinder(base=(0, 0, 0), top=(0, 1, 0), radius=0.5, material="post").capped
    True
    """

    base: Triple
    top: Triple
    radius: float | int
    material: str
    capped: bool = True
    type: Literal["cylinder"] = field(default="cylinder", kw_only=True)

    def __post_init__(self) -> None:
        finite("cylinder", base=self.base, top=self.top, radius=self.radius)
        positive("cylinder", radius=self.radius)
        if tuple(self.base) == tuple(self.top):
            raise ValueError(f"cylinder: base and top are both {self.base}: they must differ")
        positive("cylinder", height=self.height)

    @cached_property
    def axis(self) -> Pair:
        """From the base's centre to the top's, in pairs."""
        return two_sum(column(self.top), -column(self.base))

    @cached_property
    def height(self) -> float:
        """The length of the axis."""
        return float(length(self.axis[0])[0])

    @cached_property
    def squared_radius(self) -> Pair:
        """The square of the radius, as a pair."""
        return two_product(np.array([self.radius], float), np.array([self.radius], float))

    @cached_property
    def reach(self) -> float:
        """A little more than the distance of its rims from its middle."""
        return 1.001 * float(np.hypot(self.height / 2, float(self.radius)))

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form."""
        ends, axis = (*self.base, *self.top), (*self.axis[0][:, 0], *self.axis[1][:, 0])
        squares = (*self.squared_radius, *pair_dot(self.axis, self.axis))
        plain = (self.height, 1.001 * float(self.radius), self.reach)
        constants = [*ends, *axis, *plain, *(part[0] for part in squares), self.capped]
        return Kernel("symrt.geometry.fast.quadrics", "cylinder", (tuple(map(float, constants)),))


@intersect.register(Cylinder)
def intersect_cylinder(cylinder: Cylinder, rays: Rays, low: float = 0.0) -> Crossing:
    """Nearest crossing with a cylinder beyond `low`: within 10 ulp, also for rays nearly along its axis.

    Primitive 0 is the side, 1 the base, 2 the top.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[3.0], [0.5], [0.0]]), direction=np.array([[-1.0], [0.0], [0.0]]))
    >>> intersect_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post"), ray).distance
    array([2.5])
    """
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    with np.errstate(all="ignore"):
        chosen = np.flatnonzero(_possible(cylinder, rays))
        part = rays[chosen]
        side, slab = _side(cylinder, part), _slab(cylinder, part)
        first, kind = (_closed if cylinder.capped else _open)(side, slab, low)
    distance[chosen] = first
    primitive[chosen] = kind
    return Crossing(distance, primitive)


Interval = tuple[Float[np.ndarray, " ray"], Float[np.ndarray, " ray"]]


def _closed(side: Interval, slab: tuple[PerRay, PerRay, PerRay], low: float) -> tuple[PerRay, np.ndarray]:
    """First crossing with the solid: where the ray is both inside the endless cylinder and between the planes."""
    enter, leave, upward = np.maximum(side[0], slab[0]), np.minimum(side[1], slab[1]), slab[2] > 0
    met = enter <= leave
    first = np.where(met & (enter > low), enter, np.where(met & (leave > low), leave, np.inf))
    at_entry = enter > low
    by_side = np.where(at_entry, side[0] >= slab[0], side[1] <= slab[1])
    cap = np.where(at_entry == upward, BASE, TOP)
    return first, np.where(first == np.inf, -1, np.where(by_side, SIDE, cap)).astype(np.int32)


def _open(side: Interval, slab: tuple[PerRay, PerRay, PerRay], low: float) -> tuple[PerRay, np.ndarray]:
    """First crossing with the side between the planes."""
    enter, leave = (np.where((slab[0] <= t) & (t <= slab[1]) & (t > low), t, np.inf) for t in side)
    first = np.fmin(enter, leave)
    return first, np.where(first == np.inf, -1, SIDE).astype(np.int32)


def _possible(cylinder: Cylinder, rays: Rays) -> Bool[np.ndarray, " ray"]:
    """Rays that may meet the cylinder, by plain arithmetic: near its axis, and near its middle."""
    axis, radius, height = cylinder.axis[0], float(cylinder.radius), cylinder.height
    m, d = rays.origin - column(cylinder.base), rays.direction
    size = np.abs(m[0]) + np.abs(m[1]) + np.abs(m[2])
    x, y, z = (d[i] * axis[j] - d[j] * axis[i] for i, j in ((1, 2), (2, 0), (0, 1)))
    passing = np.abs(m[0] * x + m[1] * y + m[2] * z)
    chosen = passing <= 1.001 * radius * np.sqrt(x * x + y * y + z * z) + 64 * ROUNDING * size * height
    near = np.flatnonzero(chosen)
    m, d = m.take(near, axis=1) - axis / 2, d.take(near, axis=1)
    x, y, z = (m[i] * d[j] - m[j] * d[i] for i, j in ((1, 2), (2, 0), (0, 1)))
    chosen[near] = x * x + y * y + z * z <= (cylinder.reach + 32 * ROUNDING * (size[near] + height)) ** 2
    return chosen


def _side(cylinder: Cylinder, rays: Rays) -> Interval:
    """Where each line enters and leaves the endless cylinder; enter > leave where it misses."""
    axis, m, d = cylinder.axis, two_sum(rays.origin, -column(cylinder.base)), exact(rays.direction)
    squared_radius = cylinder.squared_radius
    across, out, squared_axis = pair_cross(d, axis), pair_cross(m, axis), pair_dot(axis, axis)
    a, b = pair_dot(across, across), pair_dot(out, across)[0]
    c = pair_sum(pair_dot(out, out), negative(pair_product(squared_radius, squared_axis)))[0]
    passing = pair_dot(m, across)
    square = pair_sum(pair_product(squared_radius, a), negative(pair_product(passing, passing)))[0]
    root = np.sqrt(np.where(square >= 0, square, 0.0)) * np.sqrt(squared_axis[0])
    q = -(b + np.copysign(root, b))
    larger, smaller = q / a[0], np.where(q == 0, 0.0, c / np.where(q == 0, 1.0, q))
    enter, leave = np.minimum(larger, smaller), np.maximum(larger, smaller)

    # A line parallel to the axis is inside all the way, or never.
    parallel, inside = a[0] == 0, c <= 0
    enter = np.where(parallel, np.where(inside, -np.inf, np.inf), np.where(square >= 0, enter, np.inf))
    leave = np.where(parallel, np.where(inside, np.inf, -np.inf), np.where(square >= 0, leave, -np.inf))
    return enter, leave


def _slab(cylinder: Cylinder, rays: Rays) -> tuple[PerRay, PerRay, PerRay]:
    """Where each line enters and leaves the slab between the planes of base and top, and its slope along the axis."""
    axis = cylinder.axis
    slope = pair_dot(exact(rays.direction), axis)[0]
    above_base, above_top = (pair_dot(two_sum(rays.origin, -column(p)), axis)[0] for p in (cylinder.base, cylinder.top))
    to_base, to_top = -above_base / slope, -above_top / slope
    parallel, inside = slope == 0, (above_base >= 0) & (above_top <= 0)
    enter = np.where(parallel, np.where(inside, -np.inf, np.inf), np.minimum(to_base, to_top))
    leave = np.where(parallel, np.where(inside, np.inf, -np.inf), np.maximum(to_base, to_top))
    return enter, leave, slope


@surface.register(Cylinder)
def surface_cylinder(cylinder: Cylinder, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:
    """Surface of a cylinder where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[3.0], [0.75], [0.0]]), direction=np.array([[-1.0], [0.0], [0.0]]))
    >>> post = Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post")
    >>> found = surface_cylinder(post, ray, np.array([2.5]), np.zeros(1, np.int32))
    >>> found.normal.T, found.uv.T
    (array([[1., 0., 0.]]), array([[0.  , 0.25]]))
    """
    axis = cylinder.axis[0]
    side = _side_surface(cylinder, axis, rays, distance)
    base = flat_surface(Flat(column(cylinder.base), -axis), rays, distance)
    top = flat_surface(Flat(column(cylinder.top), axis), rays, distance)
    return Surface(
        *(
            np.where(primitive == SIDE, s, np.where(primitive == BASE, b, t))
            for s, b, t in (
                (getattr(side, name), getattr(base, name), getattr(top, name)) for name in Surface.__dataclass_fields__
            )
        )
    )


def _side_surface(cylinder: Cylinder, axis: Float[np.ndarray, "3 1"], rays: Rays, distance: PerRay) -> Surface:
    """Points refined onto the side: the foot on the axis, and a radius away from it."""
    base, height, unit = column(cylinder.base), length(axis), normalise(axis)
    offset = (rays.origin - base) + distance * rays.direction
    along = dot(offset, unit)
    normal = _outward(offset - along * unit, unit)
    point = base + along * unit + float(cylinder.radius) * normal
    u_axis, v_axis = plane_axes(axis)
    turn = np.arctan2(dot(normal, v_axis), dot(normal, u_axis)) / (2 * np.pi) + 0.5
    uv = np.stack([np.where(turn >= 1, 0.0, turn), np.clip(1 - along / height, 0.0, 1.0)])
    extent = np.broadcast_to([[2 * np.pi * cylinder.radius], [float(height[0])]], uv.shape).copy()
    size = np.abs(point).sum(axis=0) + np.abs(base).sum() + np.abs(along) + cylinder.radius
    return Surface(point, normal, normal, uv, extent, 8 * ROUNDING * size)


def _outward(out: Float[np.ndarray, "3 ray"], unit: Float[np.ndarray, "3 1"]) -> Float[np.ndarray, "3 ray"]:
    """Unit vectors along `out`, made perpendicular to the axis; a point of a cap on the axis gets any."""
    safe = np.where(np.any(out != 0, axis=0), out, plane_axes(unit)[0])
    normal = normalise(safe)
    return normalise(normal - dot(normal, unit) * unit)


@bounds.register(Cylinder)
def bounds_cylinder(cylinder: Cylinder) -> Corners:
    """The box around the discs at both ends.

    Examples
    --------
    >>> bounds_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post")).tolist()
    [[-0.5, 0.0, -0.5], [0.5, 1.0, 0.5]]
    """
    ends = np.array([cylinder.base, cylinder.top], dtype=float)
    axis = normalise(cylinder.axis[0])[:, 0]
    reach = float(cylinder.radius) * np.sqrt(np.maximum(0.0, 1 - axis**2))
    return np.stack([ends.min(axis=0) - reach, ends.max(axis=0) + reach])


@translate.register(Cylinder)
def translate_cylinder(cylinder: Cylinder, by: Point) -> Cylinder:
    """The cylinder moved `by` a vector.

    Examples
    --------
    >>> translate_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post"), np.array([0.0, 2.0, 0.0])).top
    (0.0, 3.0, 0.0)
    """
    return replace(cylinder, base=moved(cylinder.base, by), top=moved(cylinder.top, by))


@leaves.register(Cylinder)
def leaves_cylinder(cylinder: Cylinder) -> tuple[bool, bool]:
    """A capped cylinder is convex, an open tube is not.

    Examples
    --------
    >>> leaves_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post", capped=False))
    (False, False)
    """
    return cylinder.capped, False


@encloses.register(Cylinder)
def encloses_cylinder(cylinder: Cylinder, point: Point) -> bool:
    """Whether `point` is strictly inside a capped cylinder.

    Examples
    --------
    >>> encloses_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post"), np.array([0.0, 0.5, 0.0]))
    True
    """
    along, out, height = _cylindrical(cylinder, point)
    return cylinder.capped and 0 < along < height and out < cylinder.radius


@clearance.register(Cylinder)
def clearance_cylinder(cylinder: Cylinder, point: Point) -> float:
    """Distance from `point` to the cylinder's surface.

    Examples
    --------
    >>> clearance_cylinder(Cylinder((0, 0, 0), (0, 1, 0), 0.5, "post"), np.array([3.5, 5.0, 0.0]))
    5.0
    """
    along, out, height = _cylindrical(cylinder, point)
    beyond = max(along - height, -along, 0.0)
    to_side = float(np.hypot(beyond, abs(out - cylinder.radius)))
    if not cylinder.capped:
        return to_side
    past = max(out - cylinder.radius, 0.0)
    return min(to_side, float(np.hypot(abs(along), past)), float(np.hypot(abs(along - height), past)))


def _cylindrical(cylinder: Cylinder, point: Point) -> tuple[float, float, float]:
    """Height above the base, distance from the axis, and the height of the cylinder."""
    axis = cylinder.axis[0]
    unit, offset = normalise(axis), point.reshape(3, 1) - column(cylinder.base)
    along = dot(offset, unit)
    return float(along[0]), float(length(offset - along * unit)[0]), float(length(axis)[0])
