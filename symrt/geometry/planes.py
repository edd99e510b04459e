"""Planes and disks (step 1).

Surface coordinates of planes and disks are scene units (extent 1) from the shape's point, along two axes that form a
right-handed frame with the normal n: the u axis is a × n, normalised, with a = (1, 0, 0) where |n_z| is the largest
component (or shares that place) and a = (0, 0, 1) otherwise; the v axis is n × u.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Int

from symrt.arrays import PerRay, Point, dot, length, normalise
from symrt.errors import hinting
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.flats import ENDLESS, ROUND, Flat, bounded, flat_surface
from symrt.geometry.rays import (
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
from symrt.geometry.records import Triple, column, finite, has_direction, moved, positive


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

    @cached_property
    def flat(self) -> Flat:
        """The plane made ready for rays."""
        return Flat(column(self.point), column(self.normal))

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form."""
        return self.flat.kernel(ENDLESS)

    @cached_property
    def surface_kernel(self) -> Kernel:
        """The compiled form of its surface."""
        return self.flat.surface_kernel()


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

    @cached_property
    def flat(self) -> Flat:
        """The plane that it lies in, made ready for rays."""
        return Flat(column(self.centre), column(self.normal), float(self.radius))

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form."""
        return self.flat.kernel(ROUND, float(self.radius) ** 2)

    @cached_property
    def surface_kernel(self) -> Kernel:
        """The compiled form of its surface."""
        return self.flat.surface_kernel()


@intersect.register(Plane)
def intersect_plane(plane: Plane, rays: Rays, low: float = 0.0) -> Crossing:
    """Crossing with a plane beyond `low`, within 2 ulp; a ray in the plane misses it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> intersect_plane(Plane((0, 0, 0), (0, 1, 0), "floor"), ray).distance
    array([2.5])
    """
    return bounded(plane.flat, rays, low)


@intersect.register(Disk)
def intersect_disk(disk: Disk, rays: Rays, low: float = 0.0) -> Crossing:
    """Crossing with a disc beyond `low`.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> intersect_disk(Disk((0, 0, 0), (0, 1, 0), 1.0, "base"), ray).distance
    array([inf])
    """
    squared_radius = float(disk.radius) ** 2
    return bounded(disk.flat, rays, low, lambda m: dot(m, m) <= squared_radius)


@surface.register(Plane)
def surface_plane(plane: Plane, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Surface of a plane where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> surface_plane(Plane((0, 0, 0), (0, 1, 0), "floor"), ray, np.array([2.0]), np.zeros(1, np.int32)).uv.T.tolist()
    [[0.0, 3.0]]
    """
    return flat_surface(plane.flat, rays, distance)


@surface.register(Disk)
def surface_disk(disk: Disk, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Surface of a disc where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> surface_disk(Disk((0, 0, 0), (0, 2, 0), 4, "base"), ray, np.array([2.0]), np.zeros(1, np.int32)).normal.T
    array([[0., 1., 0.]])
    """
    return flat_surface(disk.flat, rays, distance)


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


@leaves.register(Plane)
@leaves.register(Disk)
def leaves_flat(shape: Plane | Disk) -> tuple[bool, bool]:  # noqa: ARG001
    """Planes and disks are flat.

    Examples
    --------
    >>> leaves_flat(Disk((0, 0, 0), (0, 1, 0), 1, "base"))
    (True, True)
    """
    return True, True


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
