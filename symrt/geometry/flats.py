"""What all flat shapes share (step 1): ``n · (origin + t direction − point) = 0``.

At grazing incidence both dot products cancel; they are compensated, which leaves at most 2 ulp in the distance.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerRay, Vectors, dot, exact, length, normalise, pair_dot, pair_quotient, two_sum
from symrt.geometry.directions import ROOM
from symrt.geometry.rays import ROUNDING, Crossing, Kernel, Rays, Surface
from symrt.geometry.records import LARGEST

Column = Float[np.ndarray, "3 1"]

ENDLESS, ROUND, CORNERED = 0, 1, 2
"""The part of a plane that is there, as its kernel knows it: all, a disc, a rectangle."""


@dataclass(frozen=True, eq=False)
class Flat:
    """A plane made ready for rays; what of it is there lies within `reach` of its point.

    Examples
    --------
    >>> Flat(np.zeros((3, 1)), np.array([[0.0], [-2.0], [0.0]])).axis
    1
    """

    point: Column
    normal: Column
    reach: float = np.inf

    @cached_property
    def axis(self) -> int | None:
        """The axis that the normal is along: its dot products are single products, and need no care."""
        along = np.flatnonzero(self.normal)
        return int(along[0]) if along.size == 1 else None

    @cached_property
    def size(self) -> Float[np.ndarray, "1"]:
        """The length of the normal."""
        return length(self.normal)

    @cached_property
    def unit(self) -> Column:
        """The unit normal."""
        return normalise(self.normal)

    @cached_property
    def axes(self) -> tuple[Column, Column]:
        """The u and v axes, as `plane_axes` has them."""
        return plane_axes(self.normal)

    def kernel(self, part: int, *constants: float) -> Kernel:
        """The compiled form of `bounded`; the constants are those of the part that is there."""
        plain = (float(self.size[0]), 1.001 * self.reach, LARGEST)
        values = (*self.point[:, 0], *self.normal[:, 0], *plain, *constants, *(0.0,) * (8 - len(constants)))
        axis = -1 if self.axis is None else self.axis
        return Kernel("symrt.geometry.fast.flats", "flat", (part, axis, tuple(map(float, values))))

    def surface_kernel(self, across: float = 1.0, down: float = 1.0) -> Kernel:
        """The compiled form of `flat_surface`, with the extents of a unit of u and of v."""
        vectors = (*self.point[:, 0], *self.normal[:, 0], *self.unit[:, 0])
        return Kernel(ROOM, "flat", (tuple(map(float, (*vectors, np.abs(self.point).sum(), across, down))),))


def plane_distance(flat: Flat, rays: Rays) -> PerRay:
    """Signed distance along each ray to a plane, within 2 ulp; nan or infinite where it is parallel.

    To an oblique plane a ray within 2⁻⁵¹ of parallel is parallel: a unit normal, rounded, does not know the side such
    a ray goes to, and a fresh ray could meet the plane it leaves.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> plane_distance(Flat(np.zeros((3, 1)), np.array([[0.0], [1.0], [0.0]])), ray)
    array([2.5])
    """
    if flat.axis is not None:
        return (flat.point[flat.axis] - rays.origin[flat.axis]) / rays.direction[flat.axis]
    normal = exact(flat.normal)
    height, slope = pair_dot(two_sum(rays.origin, -flat.point), normal), pair_dot(exact(rays.direction), normal)
    return np.where(np.abs(slope[0]) > 4 * ROUNDING * flat.size, -pair_quotient(height, slope), np.inf)


def bounded(flat: Flat, rays: Rays, low: float, inside: Callable[[Vectors], np.ndarray] | None = None) -> Crossing:
    """Crossing with the part of a plane where `inside` holds, told the offset from the plane's point.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> bounded(Flat(np.zeros((3, 1)), np.array([[0.0], [1.0], [0.0]])), ray, 0.0).distance
    array([2.5])
    """
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    with np.errstate(all="ignore"):
        # Across an axis the distance is one division; otherwise it is asked for where the ray may arrive.
        if flat.axis is not None:
            found = plane_distance(flat, rays)
            chosen = np.flatnonzero((found > low) & (found <= LARGEST))
            found = found[chosen]
        else:
            chosen = np.flatnonzero(_possible(flat, rays))
            found = plane_distance(flat, rays[chosen])
            ahead = (found > low) & (found <= LARGEST)
            chosen, found = chosen[ahead], found[ahead]

        # The part of the plane that there is.
        if inside is not None:
            met = inside((rays.origin.take(chosen, axis=1) - flat.point) + found * rays.direction.take(chosen, axis=1))
            chosen, found = chosen[met], found[met]
    distance[chosen] = found
    primitive[chosen] = 0
    return Crossing(distance, primitive)


def _possible(flat: Flat, rays: Rays) -> Bool[np.ndarray, " ray"]:
    """Rays that may meet the plane ahead within its reach: plain arithmetic with room for its rounding."""
    offset = rays.origin - flat.point
    slope = dot(rays.direction, flat.normal)
    rough = -dot(offset, flat.normal) / slope
    x, y, z = (offset[i] + rough * rays.direction[i] for i in range(3))
    # Where the slope keeps six digits or more, so do the plain distance and position.
    room = 1e-8 * (np.abs(offset[0]) + np.abs(offset[1]) + np.abs(offset[2]) + np.abs(rough))
    near = (rough >= -room) & (x * x + y * y + z * z <= (1.001 * flat.reach + room) ** 2)
    return near | (np.abs(slope) <= 1e-6 * flat.size)


def flat_surface(flat: Flat, rays: Rays, distance: PerRay) -> Surface:
    """Surface of a plane where rays meet it, refined onto the plane by an exact residual.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [3.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> flat_surface(Flat(np.zeros((3, 1)), np.array([[0.0], [1.0], [0.0]])), ray, np.array([2.0])).point.T
    array([[0., 0., 3.]])
    """
    point, normal = flat.point, flat.normal
    met = rays.origin + distance * rays.direction
    height = pair_dot(two_sum(met, -point), exact(normal))[0]
    met = met - height / dot(normal, normal) * normal
    unit = np.broadcast_to(flat.unit, met.shape).copy()
    error = 4 * ROUNDING * (np.abs(met).sum(axis=0) + np.abs(point).sum())
    offset, (u, v) = met - point, flat.axes
    return Surface(met, unit, unit, np.stack([dot(offset, u), dot(offset, v)]), np.ones((2, len(rays))), error)


def plane_axes(normal: Column) -> tuple[Column, Column]:
    """The u and v axes of a plane: see `symrt.geometry.planes`.

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
