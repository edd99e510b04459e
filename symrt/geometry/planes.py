"""Planes and disks (step 1), and what all flat shapes share: ``n · (origin + t direction − point) = 0``.

At grazing incidence both dot products cancel; they are compensated, which leaves at most 2 ulp in the distance.

Surface coordinates of planes and disks are scene units (extent 1) from the shape's point, along two axes that form a
right-handed frame with the normal n: the u axis is a × n, normalised, with a = (1, 0, 0) where |n_z| is the largest
component (or shares that place) and a = (0, 0, 1) otherwise; the v axis is n × u.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import (
    PerRay,
    Point,
    Vectors,
    dot,
    exact,
    length,
    normalise,
    pair_dot,
    pair_quotient,
    two_sum,
)
from symrt.errors import hinting
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.rays import ROUNDING, Crossing, Rays, Surface, clearance, encloses, intersect, surface, translate
from symrt.geometry.records import LARGEST, Triple, column, finite, has_direction, moved, positive

Column = Float[np.ndarray, "3 1"]


@hinting
@dataclass(frozen=True)
class Plane:
    """An endless plane through `point`; its normal need not be of unit length.

    Examples
    --------
    >>> Plane(point=(0, 0, 0), normal=(0, 1, 0), material="floor").type
    'plane'
    """

    point: Triple
    normal: Triple
    material: str
    type: Literal["plane"] = field(default="plane", kw_only=True)

    def __post_init__(self) -> None:
        finite("plane", point=self.point, normal=self.normal)
        has_direction("plane", normal=self.normal)


@hinting
@dataclass(frozen=True)
class Disk:
    """A flat disc, its edge included.

    Examples
    --------
    >>> Disk(centre=(0, 0, 0), normal=(0, 1, 0), radius=2, material="base").radius
    2
    """

    centre: Triple
    normal: Triple
    radius: float | int
    material: str
    type: Literal["disk"] = field(default="disk", kw_only=True)

    def __post_init__(self) -> None:
        finite("disk", centre=self.centre, normal=self.normal, radius=self.radius)
        has_direction("disk", normal=self.normal)
        positive("disk", radius=self.radius)


@intersect.register(Plane)
def intersect_plane(plane: Plane, rays: Rays, low: float = 0.0) -> Crossing:
    """Crossing with a plane beyond `low`, within 2 ulp; a ray in the plane misses it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> intersect_plane(Plane((0, 0, 0), (0, 1, 0), "floor"), ray).distance
    array([2.5])
    """
    return bounded(column(plane.point), column(plane.normal), rays, low, np.inf, None)


@intersect.register(Disk)
def intersect_disk(disk: Disk, rays: Rays, low: float = 0.0) -> Crossing:
    """Crossing with a disc beyond `low`.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> intersect_disk(Disk((0, 0, 0), (0, 1, 0), 1.0, "base"), ray).distance
    array([inf])
    """
    radius = float(disk.radius)
    return bounded(column(disk.centre), column(disk.normal), rays, low, radius, lambda m: dot(m, m) <= radius**2)


def plane_distance(point: Column, normal: Column, rays: Rays) -> PerRay:
    """Signed distance along each ray to a plane, within 2 ulp; nan or infinite where it is parallel.

    To an oblique plane a ray within 2⁻⁵¹ of parallel is parallel: a unit normal, rounded, does not know the side such
    a ray goes to, and a fresh ray could meet the plane it leaves.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> plane_distance(np.zeros((3, 1)), np.array([[0.0], [1.0], [0.0]]), ray)
    array([2.5])
    """
    if _is_axis(normal):
        k = int(np.argmax(np.abs(normal)))
        return (point[k] - rays.origin[k]) / rays.direction[k]
    height = pair_dot(two_sum(rays.origin, -point), exact(normal))
    slope = pair_dot(exact(rays.direction), exact(normal))
    return np.where(np.abs(slope[0]) > 4 * ROUNDING * length(normal), -pair_quotient(height, slope), np.inf)


def bounded(
    point: Column, normal: Column, rays: Rays, low: float, reach: float, inside: Callable[[Vectors], np.ndarray] | None
) -> Crossing:
    """Crossing with the part of a plane where `inside`, told the offset from `point`, holds: within `reach` of it."""
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    with np.errstate(all="ignore"):
        if _is_axis(normal):
            found = plane_distance(point, normal, rays)
            chosen = np.flatnonzero((found > low) & (found <= LARGEST))
            found = found[chosen]
        else:
            chosen = np.flatnonzero(_possible(point, normal, rays, reach))
            found = plane_distance(point, normal, rays[chosen])
            ahead = (found > low) & (found <= LARGEST)
            chosen, found = chosen[ahead], found[ahead]
        if inside is not None:
            met = inside((rays.origin.take(chosen, axis=1) - point) + found * rays.direction.take(chosen, axis=1))
            chosen, found = chosen[met], found[met]
    distance[chosen] = found
    primitive[chosen] = 0
    return Crossing(distance, primitive)


def _is_axis(normal: Column) -> bool:
    """Whether the normal is along an axis: its dot products are single products, and need no care."""
    return int(np.count_nonzero(normal)) == 1


def _possible(point: Column, normal: Column, rays: Rays, reach: float) -> Bool[np.ndarray, " ray"]:
    """Rays that may meet the plane ahead within `reach` of `point`: plain arithmetic with room for its rounding."""
    offset = rays.origin - point
    slope = dot(rays.direction, normal)
    rough = -dot(offset, normal) / slope
    x, y, z = (offset[i] + rough * rays.direction[i] for i in range(3))
    # Where the slope keeps six digits or more, so do the plain distance and position.
    room = 1e-8 * (np.abs(offset[0]) + np.abs(offset[1]) + np.abs(offset[2]) + np.abs(rough))
    near = (rough >= -room) & (x * x + y * y + z * z <= (1.001 * reach + room) ** 2)
    return near | (np.abs(slope) <= 1e-6 * length(normal))


@surface.register(Plane)
def surface_plane(plane: Plane, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Surface of a plane where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> surface_plane(Plane((0, 0, 0), (0, 1, 0), "floor"), ray, np.array([2.0]), np.zeros(1, np.int32)).uv.T.tolist()
    [[0.0, 3.0]]
    """
    return flat_surface(column(plane.point), column(plane.normal), rays, distance)


@surface.register(Disk)
def surface_disk(disk: Disk, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Surface of a disc where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> surface_disk(Disk((0, 0, 0), (0, 2, 0), 4, "base"), ray, np.array([2.0]), np.zeros(1, np.int32)).normal.T
    array([[0., 1., 0.]])
    """
    return flat_surface(column(disk.centre), column(disk.normal), rays, distance)


def flat_surface(point: Column, normal: Column, rays: Rays, distance: PerRay) -> Surface:
    """Surface of the plane through `point` where rays meet it, refined onto the plane by an exact residual.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> flat_surface(np.zeros((3, 1)), np.array([[0.0], [1.0], [0.0]]), ray, np.array([2.0])).point.T
    array([[0., 0., 3.]])
    """
    met = rays.origin + distance * rays.direction
    height = pair_dot(two_sum(met, -point), exact(normal))[0]
    met = met - height / dot(normal, normal) * normal
    unit = np.broadcast_to(normalise(normal), met.shape).copy()
    error = 4 * ROUNDING * (np.abs(met).sum(axis=0) + np.abs(point).sum())
    return Surface(met, unit, unit, _plane_coordinates(normal, met - point), np.ones((2, len(rays))), error)


def plane_axes(normal: Column) -> tuple[Column, Column]:
    """The u and v axes of a plane, as the module's docstring defines them.

    Examples
    --------
    On a floor u runs to −x and v to +z:

    >>> u, v = plane_axes(np.array([[0.0], [1.0], [0.0]]))
    >>> bool(np.all(u.T == [[-1, 0, 0]])), bool(np.all(v.T == [[0, 0, 1]]))
    (True, True)
    """
    unit = normalise(normal)
    away = [[1.0], [0.0], [0.0]] if np.abs(unit[2, 0]) == np.abs(unit).max() else [[0.0], [0.0], [1.0]]
    u = normalise(np.cross(np.array(away), unit, axis=0))
    return u, np.cross(unit, u, axis=0)


def _plane_coordinates(normal: Column, offset: Vectors) -> Float[np.ndarray, "2 ray"]:
    u, v = plane_axes(normal)
    return np.stack([dot(offset, u), dot(offset, v)])


@bounds.register(Plane)
def bounds_plane(plane: Plane) -> Corners:
    """All of space, or no more than its height where a plane lies across an axis.

    Examples
    --------
    >>> bounds_plane(Plane((0, 2, 0), (0, 1, 0), "floor")).tolist()
    [[-inf, 2.0, -inf], [inf, 2.0, inf]]
    """
    across = np.count_nonzero(plane.normal) == 1
    low = np.where(np.array(plane.normal, dtype=bool) & across, np.array(plane.point, dtype=float), -np.inf)
    return np.stack([low, np.where(np.isfinite(low), low, np.inf)])


@bounds.register(Disk)
def bounds_disk(disk: Disk) -> Corners:
    """The box around a disc.

    Examples
    --------
    >>> bounds_disk(Disk((0, 0, 0), (0, 1, 0), 2, "base")).tolist()
    [[-2.0, 0.0, -2.0], [2.0, 0.0, 2.0]]
    """
    centre, normal = np.array(disk.centre, dtype=float), normalise(column(disk.normal))[:, 0]
    reach = float(disk.radius) * np.sqrt(np.maximum(0.0, 1 - normal**2))
    return np.stack([centre - reach, centre + reach])


@translate.register(Plane)
def translate_plane(plane: Plane, by: Point) -> Plane:
    """The plane moved `by` a vector.

    Examples
    --------
    >>> translate_plane(Plane((0, 0, 0), (0, 1, 0), "floor"), np.array([0.0, 2.0, 0.0])).point
    (0.0, 2.0, 0.0)
    """
    return replace(plane, point=moved(plane.point, by))


@translate.register(Disk)
def translate_disk(disk: Disk, by: Point) -> Disk:
    """The disc moved `by` a vector.

    Examples
    --------
    >>> translate_disk(Disk((0, 0, 0), (0, 1, 0), 1, "base"), np.array([0.0, 2.0, 0.0])).centre
    (0.0, 2.0, 0.0)
    """
    return replace(disk, centre=moved(disk.centre, by))


@encloses.register(Plane)
@encloses.register(Disk)
def encloses_flat(shape: Plane | Disk, point: Point) -> bool:  # noqa: ARG001
    """Nothing is inside a flat shape.

    Examples
    --------
    >>> encloses_flat(Plane((0, 0, 0), (0, 1, 0), "floor"), np.array([0.0, -1.0, 0.0]))
    False
    """
    return False


@clearance.register(Plane)
def clearance_plane(plane: Plane, point: Point) -> float:
    """Distance from `point` to the plane.

    Examples
    --------
    >>> clearance_plane(Plane((0, 0, 0), (0, 2, 0), "floor"), np.array([5.0, -3.0, 0.0]))
    3.0
    """
    return abs(float(dot(point.reshape(3, 1) - column(plane.point), normalise(column(plane.normal)))[0]))


@clearance.register(Disk)
def clearance_disk(disk: Disk, point: Point) -> float:
    """Distance from `point` to the disc.

    Examples
    --------
    >>> clearance_disk(Disk((0, 0, 0), (0, 1, 0), 1, "base"), np.array([4.0, 4.0, 0.0]))
    5.0
    """
    offset, unit = point.reshape(3, 1) - column(disk.centre), normalise(column(disk.normal))
    height = dot(offset, unit)
    outside = np.maximum(length(offset - height * unit) - float(disk.radius), 0.0)
    return float(np.hypot(height, outside)[0])
