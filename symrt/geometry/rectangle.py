"""Rectangles (step 1): a part of a plane, with coordinates along its edges."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import PerRay, Point, Vectors, dot, exact, length, normalise, pair_cross
from symrt.errors import hinting
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.flats import CORNERED, Column, Flat, bounded, flat_surface
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
from symrt.geometry.records import Triple, column, finite, has_direction, moved


@hinting
@dataclass(frozen=True)
class Rectangle:
    """A rectangle with full edges and the normal edge_u × edge_v, its border included.

    Its coordinates run from 0 to 1: u along `edge_u` and v along `edge_v`, from the corner
    centre − edge_u/2 − edge_v/2; the extent is the lengths of the edges.

    Examples
    --------
    >>> Rectangle(centre=(0, 0, 0), edge_u=(20, 0, 0), edge_v=(0, 0, -20), material="floor").edge_u
    (20, 0, 0)
    """

    centre: Triple
    edge_u: Triple
    edge_v: Triple
    material: str
    type: Literal["rectangle"] = field(default="rectangle", kw_only=True)

    def __post_init__(self) -> None:
        finite("rectangle", centre=self.centre, edge_u=self.edge_u, edge_v=self.edge_v)
        has_direction("rectangle", edge_u=self.edge_u, edge_v=self.edge_v)
        u, v = normalise(column(self.edge_u)), normalise(column(self.edge_v))
        if abs(float(dot(u, v)[0])) > 1e-6:
            raise ValueError(
                f"rectangle: edge_u = {self.edge_u} and edge_v = {self.edge_v}: they must be perpendicular"
            )

    @cached_property
    def flat(self) -> Flat:
        """The plane that it lies in, made ready for rays."""
        reach = float(np.hypot(*self.lengths[:, 0]))
        normal = pair_cross(exact(column(self.edge_u)), exact(column(self.edge_v)))[0]
        return Flat(column(self.centre), normal, reach)

    @cached_property
    def lengths(self) -> Float[np.ndarray, "2 1"]:
        """The lengths of its edges."""
        return np.array([[float(np.linalg.norm(self.edge_u))], [float(np.linalg.norm(self.edge_v))]])

    @cached_property
    def shares(self) -> tuple[Column, Column, PerRay, PerRay]:
        """Vectors whose products with an offset from the centre, over two numbers, are its shares of the edges."""
        u, v, normal = column(self.edge_u), column(self.edge_v), self.flat.normal
        for_u, for_v = np.cross(v, normal, axis=0), np.cross(normal, u, axis=0)
        return for_u, for_v, dot(u, for_u), dot(v, for_v)

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form."""
        for_u, for_v, whole_u, whole_v = self.shares
        return self.flat.kernel(CORNERED, *for_u[:, 0], *for_v[:, 0], whole_u[0], whole_v[0])

    @cached_property
    def surface_kernel(self) -> Kernel:
        """The compiled form of its surface."""
        return self.flat.surface_kernel(*self.lengths[:, 0])


@intersect.register(Rectangle)
def intersect_rectangle(rectangle: Rectangle, rays: Rays, low: float = 0.0) -> Crossing:
    """Crossing with a rectangle beyond `low`.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [0.0]]), direction=np.array([[0.6], [-0.8], [0.0]]))
    >>> intersect_rectangle(Rectangle((0, 0, 0), (20, 0, 0), (0, 0, -20), "floor"), ray).distance
    array([2.5])
    """

    def inside(m: Vectors) -> Bool[np.ndarray, " ray"]:
        u, v = np.abs(_rectangle_coordinates(rectangle, m))
        return (u <= 0.5) & (v <= 0.5)

    return bounded(rectangle.flat, rays, low, inside)


@surface.register(Rectangle)
def surface_rectangle(
    rectangle: Rectangle,
    rays: Rays,
    distance: PerRay,
    primitive: Int[np.ndarray, " ray"],  # noqa: ARG001
) -> Surface:
    """Surface of a rectangle where rays meet it.

    Examples
    --------
    >>> ray = Rays(origin=np.array([[0.0], [2.0], [5.0]]), direction=np.array([[0.0], [-1.0], [0.0]]))
    >>> floor = Rectangle((0, 0, 0), (20, 0, 0), (0, 0, -20), "floor")
    >>> surface_rectangle(floor, ray, np.array([2.0]), np.zeros(1, np.int32)).uv.T
    array([[0.5 , 0.25]])
    """
    flat = flat_surface(rectangle.flat, rays, distance)
    uv = np.clip(_rectangle_coordinates(rectangle, flat.point - rectangle.flat.point) + 0.5, 0.0, 1.0)
    return replace(flat, uv=uv, extent=np.broadcast_to(rectangle.lengths, uv.shape).copy())


@bounds.register(Rectangle)
def bounds_rectangle(rectangle: Rectangle) -> Corners:
    """The box around a rectangle.

    Examples
    --------
    >>> bounds_rectangle(Rectangle((0, 0, 0), (20, 0, 0), (0, 0, -20), "floor")).tolist()
    [[-10.0, 0.0, -10.0], [10.0, 0.0, 10.0]]
    """
    centre = np.array(rectangle.centre, dtype=float)
    reach = (np.abs(rectangle.edge_u) + np.abs(rectangle.edge_v)) / 2
    return np.stack([centre - reach, centre + reach])


@translate.register(Rectangle)
def translate_rectangle(rectangle: Rectangle, by: Point) -> Rectangle:
    """The rectangle moved `by` a vector.

    Examples
    --------
    >>> translate_rectangle(Rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1), "a"), np.array([0.0, 2.0, 0.0])).centre
    (0.0, 2.0, 0.0)
    """
    return replace(rectangle, centre=moved(rectangle.centre, by))


@leaves.register(Rectangle)
def leaves_rectangle(rectangle: Rectangle) -> tuple[bool, bool]:  # noqa: ARG001
    """A rectangle is flat.

    Examples
    --------
    >>> leaves_rectangle(Rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1), "a"))
    (True, True)
    """
    return True, True


@encloses.register(Rectangle)
def encloses_rectangle(rectangle: Rectangle, point: Point) -> bool:  # noqa: ARG001
    """Nothing is inside a rectangle.

    Examples
    --------
    >>> encloses_rectangle(Rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1), "a"), np.zeros(3))
    False
    """
    return False


@clearance.register(Rectangle)
def clearance_rectangle(rectangle: Rectangle, point: Point) -> float:
    """Distance from `point` to the rectangle.

    Examples
    --------
    >>> clearance_rectangle(Rectangle((0, 0, 0), (2, 0, 0), (0, 0, -2), "floor"), np.array([4.0, 4.0, 0.0]))
    5.0
    """
    offset = point.reshape(3, 1) - column(rectangle.centre)
    u, v = np.clip(_rectangle_coordinates(rectangle, offset), -0.5, 0.5)
    return float(length(offset - u * column(rectangle.edge_u) - v * column(rectangle.edge_v))[0])


def _rectangle_coordinates(rectangle: Rectangle, offset: Vectors) -> Float[np.ndarray, "2 ray"]:
    """Shares of the two edges in an offset from the centre, from −½ to ½ inside."""
    for_u, for_v, whole_u, whole_v = rectangle.shares
    return np.stack([dot(offset, for_u) / whole_u, dot(offset, for_v) / whole_v])
