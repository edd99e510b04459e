"""Triangle meshes (step 1): which triangle a ray meets first, and what the surface is like there."""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import PerRay, Point, dot, exact, pair_dot, two_sum
from symrt.geometry import bvh, embree, triangles
from symrt.geometry.culling import Corners, bounds
from symrt.geometry.rays import (
    BLOCK,
    ROUNDING,
    Crossing,
    Kernel,
    Rays,
    Surface,
    clearance,
    encloses,
    intersect,
    surface,
    translate,
)
from symrt.geometry.records import LARGEST


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles ready to be met by rays.

    Parameters
    ----------
    vertices
        Corner points, one a column.
    faces
        Indices of each triangle's corners, counter-clockwise seen from outside.
    materials
        Names, chosen for each face by `face_material`.
    face_material
        Index into `materials`, one a face; all 0 by default.
    normals
        Normals at the vertices, interpolated for shading; flat shading without.
    uv
        Texture coordinates of the vertices, v down from the top; without them each triangle's own: its second corner
        is at (1, 0) and its third at (0, 1).

    Raises
    ------
    ValueError
        If there is no triangle, a vertex is not finite, or an index is out of range.

    Notes
    -----
    Degenerate triangles (three points on a line) stay in the arrays, so that indices keep their meaning, and are
    never met.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",)).unit_normals.T
    array([[0., 0., 1.]])
    """

    vertices: Float[np.ndarray, "3 vertex"]
    faces: Int[np.ndarray, "3 face"]
    materials: tuple[str, ...]
    face_material: Int[np.ndarray, " face"] | None = None
    normals: Float[np.ndarray, "3 vertex"] | None = None
    uv: Float[np.ndarray, "2 vertex"] | None = None

    def __post_init__(self) -> None:
        if self.faces.size == 0:
            raise ValueError("it has no triangles; give a mesh with at least one face")
        _all_finite("vertex", self.vertices)
        _in_range("face", self.faces, self.vertices.shape[1])
        if self.face_material is not None:
            _in_range("face_material", self.face_material[None], len(self.materials))
        for name, values in (("normal", self.normals), ("texture coordinate", self.uv)):
            if values is not None:
                _all_finite(name, values)

    def __getstate__(self) -> dict[str, Any]:
        """The record without what was computed from it, which need not travel to another process."""
        return {f.name: getattr(self, f.name) for f in fields(self)}

    @cached_property
    def corners(self) -> Float[np.ndarray, "3 3 face"]:
        """Corner, axis, face."""
        return np.ascontiguousarray(self.vertices[:, self.faces].transpose(1, 0, 2))

    @cached_property
    def unit_normals(self) -> Float[np.ndarray, "3 face"]:
        """Geometric unit normals; zero for a degenerate triangle."""
        return triangles.unit_normals(self.corners)

    @cached_property
    def tree(self) -> bvh.Tree:
        """The hierarchy over the triangles."""
        return bvh.build(self.corners.min(axis=0), self.corners.max(axis=0))

    @cached_property
    def thickened(self) -> embree.Thickened | None:
        """The mesh in Embree, where that is installed and worth it."""
        return embree.thicken(self.vertices, self.faces)

    @cached_property
    def kernel(self) -> Kernel:
        """Its compiled form, which needs no Embree: a node's children, and a leaf's triangles, side by side."""
        # The root, then the children of each node together, as the kernel walks.
        boxes = np.concatenate([level.reshape(6, -1).T for level in self.tree.boxes])
        root = np.full((6, bvh.WAYS), np.nan)
        root[:, 0] = boxes[0]
        families = np.ascontiguousarray(boxes[1:].reshape(-1, bvh.WAYS, 6).transpose(0, 2, 1))

        # The corners of the triangles in each leaf; nan in slots left over, which no ray meets.
        slots = np.where(self.tree.order >= 0, self.corners.reshape(9, -1)[:, self.tree.order], np.nan)
        leaves = np.ascontiguousarray(slots.reshape(9, -1, bvh.LEAF).transpose(1, 0, 2))
        constants = (
            self.tree.order,
            root,
            families,
            leaves,
            np.ascontiguousarray(self.unit_normals.T),
            self.tree.reach,
        )
        return Kernel("symrt.geometry.fast.triangles", "mesh", constants)

    @cached_property
    def is_closed(self) -> bool:
        """Whether every edge, by the positions of its ends, is run through as often one way as the other."""
        return self.open_edge is None

    @property
    def volume(self) -> float:
        """The volume that a closed mesh encloses, below 0 if its triangles are clockwise seen from outside."""
        first, second, third = self.corners - self.vertices.mean(axis=1).reshape(3, 1)
        return float(np.sum(first * np.cross(second, third, axis=0)) / 6)

    @cached_property
    def open_edge(self) -> Float[np.ndarray, "2 3"] | None:
        """Both ends of the first edge that is run through more often one way than the other; None if none is."""
        _, same = np.unique(self.vertices, axis=1, return_inverse=True)
        faces = same.reshape(-1)[self.faces].astype(np.int64)
        start, end, count = faces.ravel(), faces[[1, 2, 0]].ravel(), self.vertices.shape[1]
        there, back = start * count + end, end * count + start
        if np.array_equal(np.sort(there), np.sort(back)):
            return None
        names, which, times = np.unique(np.concatenate([there, back]), return_inverse=True, return_counts=True)
        forwards = np.bincount(which[: there.size], minlength=names.size)
        first = int(np.flatnonzero(2 * forwards[which[: there.size]] > times[which[: there.size]])[0])
        return self.vertices[:, [self.faces.ravel()[first], self.faces[[1, 2, 0]].ravel()[first]]].T


@intersect.register(TriangleMesh)
def intersect_mesh(mesh: TriangleMesh, rays: Rays, low: float = 0.0) -> Crossing:
    """Nearest crossing with a mesh beyond `low`; of two at the same distance the lower triangle.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> intersect_mesh(one, ray)
    Crossing(distance=array([3.]), primitive=array([0], dtype=int32))
    """
    found = Crossing(np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32))
    for start in range(0, len(rays), BLOCK):
        block = slice(start, start + BLOCK)
        with np.errstate(all="ignore"):
            _record(found, block, _intersect_block(mesh, rays[block], low))
    return found


def _intersect_block(mesh: TriangleMesh, rays: Rays, low: float) -> Crossing:
    if mesh.thickened is None:
        return _nearest_between(mesh, rays, np.full(len(rays), low), np.full(len(rays), np.inf))
    return _with_embree(mesh, mesh.thickened, rays, low)


def _with_embree(mesh: TriangleMesh, thickened: embree.Thickened, rays: Rays, low: float) -> Crossing:
    """The triangles that Embree sees first, met again in double precision; where it may misjudge, the hierarchy's."""
    found = Crossing(np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32))
    step = 2.0**-12 * thickened.radius
    chosen, enter = _through_ball(thickened, rays, low)

    # A ray that starts in the midst of the mesh may start above a triangle that it meets at a grazing angle, and pass
    # none of its edges: single precision puts that triangle anywhere, or misses it.
    within = enter <= low
    inside, chosen, enter = chosen[within], chosen[~within], enter[~within]
    _record(
        found, inside, _nearest_between(mesh, rays[inside], np.full(inside.size, low), np.full(inside.size, np.inf))
    )

    seen = embree.first_seen(thickened, rays[chosen], enter)
    chosen, seen = chosen[seen != embree.NOTHING], seen[seen != embree.NOTHING]
    part = rays[chosen]
    depth = np.full(chosen.size, np.inf)
    named = np.flatnonzero(seen >= 0)
    depth[named] = triangles.crossings(mesh.corners, mesh.unit_normals, part, named, seen[named])
    # Surfaces within a step of the one that is named, single precision may have put in the wrong order; those that are
    # grazed, anywhere: a few 2⁻²⁴ of the radius, over the cosine, is less than a step from 2⁻⁸ on.
    cosine = np.abs(dot(mesh.unit_normals.take(np.maximum(seen, 0), axis=1), part.direction))
    sure = (depth > low) & (depth < np.inf) & (cosine >= 2.0**-8)
    first, last = np.where(sure, np.maximum(depth - step, low), low), np.where(sure, depth, np.inf)
    _record(found, chosen, _nearest_between(mesh, part, first, last))
    return found


def _record(found: Crossing, chosen: Int[np.ndarray, " part"] | slice, part: Crossing) -> None:
    """Write the crossings of chosen rays among those of all."""
    found.distance[chosen], found.primitive[chosen] = part.distance, part.primitive


def _through_ball(
    thickened: embree.Thickened, rays: Rays, low: float
) -> tuple[Int[np.ndarray, " part"], Float[np.ndarray, " part"]]:
    """Rays that pass through a ball a little larger than the mesh, and where they enter it."""
    m = rays.origin - thickened.centre
    b = dot(m, rays.direction)
    reach = 1.001 * thickened.radius + 16 * ROUNDING * np.abs(m).max(axis=0, initial=0)
    square = reach * reach - (dot(m, m) - b * b)
    # The plain square loses the distance of a far ray; such rays all go on.
    far = np.abs(b) > 1e4 * reach
    root = np.sqrt(np.where(far, reach * reach, np.maximum(square, 0.0)))
    chosen = np.flatnonzero(((square >= 0) | far) & (root - b >= low))
    return chosen, np.maximum(-b - root, low)[chosen]


def _nearest_between(mesh: TriangleMesh, rays: Rays, low: PerRay, high: PerRay) -> Crossing:
    """Nearest crossing beyond `low` and up to `high`, by the hierarchy."""
    pairs = bvh.candidates(mesh.tree, rays, low, high)
    return triangles.first_crossing(mesh.corners, mesh.unit_normals, rays, pairs, low, high)


@surface.register(TriangleMesh)
def surface_mesh(mesh: TriangleMesh, rays: Rays, distance: PerRay, primitive: Int[np.ndarray, " ray"]) -> Surface:
    """Surface of a mesh where rays meet it: face normal, interpolated shading normal and texture coordinates.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> surface_mesh(one, ray, np.array([3.0]), np.zeros(1, np.int32)).point.T
    array([[0.2, 0.2, 0. ]])
    """
    # The point, moved onto the plane of its triangle.
    normal, corner = mesh.unit_normals.take(primitive, axis=1), mesh.corners.take(primitive, axis=2)
    point = rays.origin + distance * rays.direction
    height = pair_dot(two_sum(point, -corner[0]), exact(normal))[0]
    point = point - height * normal

    # What vertices carry, blended.
    weights = triangles.barycentric(corner, normal, point)
    shading = (
        normal
        if mesh.normals is None
        else triangles.blended_normal(mesh.normals[:, mesh.faces[:, primitive]], weights, normal)
    )
    uv = weights[1:]
    if mesh.uv is not None:
        at = mesh.uv[:, mesh.faces[:, primitive]]
        uv = at[:, 0] * weights[0] + at[:, 1] * weights[1] + at[:, 2] * weights[2]
    error = 8 * ROUNDING * (np.abs(point).sum(axis=0) + np.abs(corner).max(axis=0).sum(axis=0))
    return Surface(point, normal, shading, uv, np.ones((2, len(rays))), error)


@bounds.register(TriangleMesh)
def bounds_mesh(mesh: TriangleMesh) -> Corners:
    """The box around all vertices.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> bounds_mesh(TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))).tolist()
    [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
    """
    return np.stack([mesh.vertices.min(axis=1), mesh.vertices.max(axis=1)])


@translate.register(TriangleMesh)
def translate_mesh(mesh: TriangleMesh, by: Point) -> TriangleMesh:
    """The mesh moved `by` a vector; its hierarchy is built anew, so move a scene once, not once a tile.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> translate_mesh(one, np.array([0.0, 0.0, 5.0])).vertices[2].tolist()
    [5.0, 5.0, 5.0]
    """
    return replace(mesh, vertices=mesh.vertices + by.reshape(3, 1))


@encloses.register(TriangleMesh)
def encloses_mesh(mesh: TriangleMesh, point: Point) -> bool:
    """Whether `point` is inside a mesh: its triangles wind around the point (solid angle above 2π).

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> encloses_mesh(one, np.array([0.2, 0.2, -0.1]))
    False
    """
    return mesh.is_closed and abs(triangles.solid_angle(mesh.corners, point)) > 2 * np.pi


@clearance.register(TriangleMesh)
def clearance_mesh(mesh: TriangleMesh, point: Point) -> float:
    """Distance from `point` to the nearest triangle.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> clearance_mesh(one, np.array([0.2, 0.2, 3.0])), clearance_mesh(one, np.array([-3.0, 0.0, 4.0]))
    (3.0, 5.0)
    """
    return triangles.distance_to(mesh.corners, mesh.unit_normals, point)


def _all_finite(name: str, values: Float[np.ndarray, "_ _"]) -> None:
    good = (np.abs(values) <= LARGEST).all(axis=0)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(
            f"{name} {bad} is {values[:, bad].tolist()}: coordinates must be finite, at most {LARGEST}; repair the mesh"
        )


def _in_range(name: str, values: Int[np.ndarray, "_ _"], count: int) -> None:
    good = ((values >= 0) & (values < count)).all(axis=0)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(f"{name} {bad} is {values[:, bad].tolist()}: indices must be from 0 to {count - 1}")
