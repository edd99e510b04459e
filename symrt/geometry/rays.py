"""Rays, what a shape answers about them, and how they start again from it (step 1): ``p(t) = origin + t direction``.

`intersect`, `surface`, `translate`, `encloses` and `clearance` are singledispatch functions; each family of shapes
registers its own beside its record.  No result depends on the other rays of a batch, so tiles may be cut anywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import singledispatch
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from symrt import fast
from symrt.arrays import PerRay, Point, Vectors, dot, exact, pair_dot
from symrt.geometry.directions import ROOM, whole_rows
from symrt.geometry.records import LARGEST

BLOCK = 8192
"""Rays handled at a time: their arrays stay in the cache, which is worth a factor of three."""

ROUNDING = 2.0**-53


@dataclass(frozen=True, eq=False)
class Rays:
    """Half lines with unit directions, one a column.

    Parameters
    ----------
    left
        Of the shapes that the rays will be asked about, the index of one that each ray is leaving for good, so that it
        need not be asked about that, or −1; see `spawn`.

    Raises
    ------
    ValueError
        If an origin is not finite (or beyond 1e60), or a direction is not of unit length.

    Examples
    --------
    >>> len(Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]])))
    1
    """

    origin: Vectors
    direction: Vectors
    left: Int[np.ndarray, " ray"] | None = None

    def __post_init__(self) -> None:
        kernels, given = fast.kernels(ROOM, len(self)), (self.origin, self.direction)
        plain = {array.dtype for array in given} == {np.dtype(np.float64)}
        if kernels and plain and not kernels.unfit(*map(whole_rows, given), LARGEST):
            return
        # Comparisons with nan are false, so that nan is refused as well.
        good = (np.abs(self.origin) <= LARGEST).all(axis=0)
        with np.errstate(over="ignore", invalid="ignore"):
            good &= np.abs(dot(self.direction, self.direction) - 1) < 1e-12
        if not good.all():
            bad = int(np.argmin(good))
            raise ValueError(
                f"ray {bad} starts at {self.origin[:, bad].tolist()} along {self.direction[:, bad].tolist()}: "
                f"the origin must be finite, at most {LARGEST}, and the direction of unit length; use normalise"
            )

    def __len__(self) -> int:
        return self.origin.shape[1]

    def __getitem__(self, chosen: slice | np.ndarray) -> "Rays":
        """The rays chosen by a slice, a mask or indices; they have been checked."""
        part = object.__new__(Rays)
        for name, values in (("origin", self.origin), ("direction", self.direction)):
            # take is several times faster than an index array in brackets; whole rows are what kernels take.
            if isinstance(chosen, slice):
                picked = np.ascontiguousarray(values[:, chosen])
            else:
                picked = values.take(_indices(chosen), axis=1)
            object.__setattr__(part, name, picked)
        object.__setattr__(part, "left", None if self.left is None else self.left[chosen])
        return part


@dataclass(frozen=True, eq=False)
class Crossing:
    """The nearest crossing of each ray with one shape.

    Parameters
    ----------
    distance
        Along the ray, in scene units; inf where the ray misses.
    primitive
        The part of the shape that was met (a triangle, a cap), −1 where the ray misses.
    """

    distance: PerRay
    primitive: Int[np.ndarray, " ray"]


@dataclass(frozen=True, eq=False)
class Hits:
    """The nearest crossing of each ray with a list of shapes.

    Parameters
    ----------
    distance
        Along the ray; inf where everything is missed.
    shape
        Index of the shape in the list, −1 where everything is missed.
    primitive
        The part of that shape, −1 where everything is missed.
    """

    distance: PerRay
    shape: Int[np.ndarray, " ray"]
    primitive: Int[np.ndarray, " ray"]

    def of(self, some: Int[np.ndarray, " some"]) -> "Hits":
        """Those of some rays."""
        return Hits(self.distance[some], self.shape[some], self.primitive[some])


@dataclass(frozen=True, eq=False)
class Surface:
    """What a surface is like where rays meet it.

    Parameters
    ----------
    point
        Refined onto the surface.
    normal
        The geometric unit normal that points out of the shape, whatever side the ray came from.
    shading_normal
        The unit normal for shading: another one only on meshes that carry vertex normals.
    uv
        Surface coordinates; each shape's record says which.
    extent
        Scene units per unit of u and of v.
    error
        Upper bound of the distance between `point` and the true surface.
    """

    point: Float[np.ndarray, "3 hit"]
    normal: Float[np.ndarray, "3 hit"]
    shading_normal: Float[np.ndarray, "3 hit"]
    uv: Float[np.ndarray, "2 hit"]
    extent: Float[np.ndarray, "2 hit"]
    error: Float[np.ndarray, " hit"]


@singledispatch
def intersect(shape: object, rays: Rays, low: float = 0.0) -> Crossing:  # noqa: ARG001 (registered for each shape)
    """The nearest crossing of each ray with `shape` at a distance greater than `low` ≥ 0; nan never comes out.

    What is farther than 1e60, on a plane that the ray grazes, is missed.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> ray = Rays(origin=np.array([[0.0], [0.0], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> intersect(Sphere(centre=(0, 0, 0), radius=1, material="red"), ray).distance
    array([2.])
    """
    raise _unknown(shape)


@singledispatch
def surface(shape: object, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:  # noqa: ARG001
    """Point, normals and surface coordinates of `shape` where each ray meets it.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> ball = Sphere(centre=(0, 0, 0), radius=1, material="red")
    >>> ray = Rays(origin=np.array([[0.0], [0.0], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> found = intersect(ball, ray)
    >>> surface(ball, ray, found.distance, found.primitive).normal.T
    array([[0., 0., 1.]])
    """
    raise _unknown(shape)


@singledispatch
def translate(shape: object, by: Point) -> Any:  # noqa: ARG001 (the same kind of shape)
    """The shape moved `by` a vector: a scene far from the origin is moved to its camera first, where floats are dense.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> translate(Sphere(centre=(1e8, 0, 0), radius=1, material="red"), np.array([-1e8, 0.0, 0.0])).centre
    (0.0, 0.0, 0.0)
    """
    raise _unknown(shape)


@singledispatch
def encloses(shape: object, point: Point) -> bool:  # noqa: ARG001
    """Whether `point` is inside a closed shape; always False for an open one.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> encloses(Sphere(centre=(0, 0, 0), radius=1, material="red"), np.array([0.0, 0.5, 0.0]))
    True
    """
    raise _unknown(shape)


def inside(shape: object, place: Sequence[float | int]) -> bool:
    """Whether a place is inside a closed shape; one so far away that its distance overflows is outside.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> inside(Sphere(centre=(0, 0, 0), radius=1, material="red"), (0, 1e300, 0))
    False
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return encloses(shape, np.array(place, dtype=float))


@singledispatch
def clearance(shape: object, point: Point) -> float:  # noqa: ARG001
    """Distance from `point` to the surface of `shape`, or a lower bound of it.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> clearance(Sphere(centre=(0, 0, 0), radius=1, material="red"), np.array([0.0, 3.0, 0.0]))
    2.0
    """
    raise _unknown(shape)


@singledispatch
def leaves(shape: object) -> tuple[bool, bool]:  # noqa: ARG001
    """Whether rays that start on a shape never meet it again: on the side its normals point to, and on the other.

    Convex shapes are left for good outwards, flat ones on either side.

    Examples
    --------
    >>> from symrt.geometry import Plane, Sphere
    >>> leaves(Sphere((0, 0, 0), 1, "red")), leaves(Plane((0, 0, 0), (0, 1, 0), "floor"))
    ((True, False), (True, True))
    """
    return False, False


@dataclass(frozen=True, eq=False)
class Kernel:
    """The compiled form of a shape's `intersect`: a function of a module of kernels, and the shape's constants."""

    room: str
    name: str
    constants: tuple[Any, ...]


def spawn(
    point: Float[np.ndarray, "3 ray"],
    normal: Float[np.ndarray, "3 ray"],
    error: PerRay,
    direction: Float[np.ndarray, "3 ray"],
    leaving: Int[np.ndarray, "2 ray"] | None = None,
) -> Rays:
    """Rays that leave a surface without meeting it again: started off it, on the side they go to, by its error bound.

    The offset is twice the bound: once for where the surface may be, once for the rounding of the new origin.

    Parameters
    ----------
    leaving
        The shape that a ray leaves for good on the side of its normal, and on the other, or −1: see `leaving_of`.

    Examples
    --------
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> spawn(np.zeros((3, 1)), up, np.array([2.0**-50]), -up).origin.T.tolist() == [[0, -(2.0**-49), 0]]
    True
    """
    kernels = fast.kernels(ROOM, error.size)
    if kernels and {array.dtype for array in (point, normal, error, direction)} == {np.dtype(np.float64)}:
        origin, below = np.empty(point.shape), np.empty(error.size, np.bool_)
        kernels.spawn(*map(whole_rows, (point, normal, error, direction)), origin, below)
        left = None if leaving is None else np.where(below, leaving[1], leaving[0])
        return Rays(origin, direction, left)
    side = side_of(normal, direction)
    left = None if leaving is None else np.where(side < 0, leaving[1], leaving[0])
    return Rays(point + np.where(side < 0, -2.0, 2.0) * error * normal, direction, left)


def side_of(normal: Vectors, direction: Vectors) -> PerRay:
    """The sign of the cosine between two unit vectors, as in exact arithmetic: the side that a direction goes to.

    The plain product of two vectors of length 1, to 1e-12, is off by no more than 3u Σ|nᵢdᵢ| < 4u, u = 2⁻⁵³: each of
    its terms is rounded three times at most, and Σ|nᵢdᵢ| ≤ |n||d|.  Beyond twice that its sign is the true one; within,
    pairs decide, the same that a shape's own intersection uses.

    Examples
    --------
    >>> up, aside = np.array([[0.0], [1.0], [0.0]]), np.array([[1.0], [-1e-300], [0.0]])
    >>> side_of(up, up), side_of(up, aside)
    (array([1.]), array([-1.]))
    """
    cosine = dot(normal, direction)
    close = np.flatnonzero(np.abs(cosine) <= 8 * ROUNDING)
    if close.size:
        pairs = exact(normal.take(close, axis=1)), exact(direction.take(close, axis=1))
        cosine[close] = pair_dot(*pairs)[0]
    return np.sign(cosine)


def _indices(chosen: np.ndarray) -> np.ndarray:
    return np.flatnonzero(chosen) if chosen.dtype == bool else chosen


def _unknown(shape: object) -> TypeError:
    return TypeError(f"{type(shape).__name__} is not a shape; load a Mesh with load_mesh first")
