"""Triangle meshes (step 1): their files, their triangles, and which of them a ray meets first."""

import warnings
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import PerRay, Point, dot, exact, pair_dot, two_sum
from symrt.geometry import bvh, triangles
from symrt.geometry.rays import (
    ROUNDING,
    Crossing,
    Rays,
    Surface,
    Triple,
    clearance,
    encloses,
    finite,
    intersect,
    positive,
    surface,
    translate,
)

__all__ = ["Mesh", "TriangleMesh", "load_mesh"]


@dataclass(frozen=True)
class Mesh:
    """A mesh file and where it stands: ``p' = R (scale p) + translate``, R turning about x, then y, then z (degrees).

    Parameters
    ----------
    file
        Path below the scene's folder, in any format that trimesh reads.
    material
        A name for the whole mesh, or the file's own material names mapped to the scene's.

    Examples
    --------
    >>> Mesh(file="ring.obj", material="brass", rotate=(0, 0, 23.4)).scale
    1
    """

    file: str
    material: str | dict[str, str]
    scale: float | int = 1
    rotate: Triple = (0, 0, 0)
    translate: Triple = (0, 0, 0)
    type: Literal["mesh"] = field(default="mesh", kw_only=True)

    def __post_init__(self) -> None:
        finite("mesh", scale=self.scale, rotate=self.rotate, translate=self.translate)
        positive("mesh", scale=self.scale)


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
        Texture coordinates of the vertices, v down from the top; zeros without.

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
        return bvh.build(self.corners)

    @cached_property
    def is_closed(self) -> bool:
        """Whether every edge, by the positions of its ends, is run through as often one way as the other."""
        _, same = np.unique(self.vertices, axis=1, return_inverse=True)
        faces = same.reshape(-1)[self.faces].astype(np.int64)
        start, end = faces.ravel(), faces[[1, 2, 0]].ravel()
        count = self.vertices.shape[1]
        return bool(np.array_equal(np.sort(start * count + end), np.sort(end * count + start)))


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
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    with np.errstate(all="ignore"):
        ray, triangle = bvh.candidates(mesh.tree, rays, distance)
        found = triangles.crossings(mesh.corners, mesh.unit_normals, rays, ray, triangle)
    met = (found > low) & (found < np.inf)
    ray, triangle, found = ray[met], triangle[met], found[met]
    order = np.lexsort((triangle, found, ray))
    ray, triangle, found = ray[order], triangle[order], found[order]
    first = np.flatnonzero(np.diff(ray, prepend=-1))
    distance[ray[first]], primitive[ray[first]] = found[first], triangle[first]
    return Crossing(distance, primitive)


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
    normal, corner = mesh.unit_normals[:, primitive], mesh.corners[:, :, primitive]
    point = rays.origin + distance * rays.direction
    height = pair_dot(two_sum(point, -corner[0]), exact(normal))[0]
    point = point - height * normal
    weights = triangles.barycentric(corner, normal, point)
    shading = (
        normal
        if mesh.normals is None
        else triangles.blended_normal(mesh.normals[:, mesh.faces[:, primitive]], weights, normal)
    )
    uv = np.zeros((2, len(rays)))
    if mesh.uv is not None:
        uv = sum(mesh.uv[:, mesh.faces[k, primitive]] * weights[k] for k in range(3))
    error = 8 * ROUNDING * (np.abs(point).sum(axis=0) + np.abs(corner).max(axis=0).sum(axis=0))
    return Surface(point, normal, shading, uv, np.ones((2, len(rays))), error)


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
    """Lower bound of the distance from `point` to the mesh: that to the finest boxes around its triangles.

    Examples
    --------
    >>> corners = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
    >>> one = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("red",))
    >>> clearance_mesh(one, np.array([0.2, 0.2, 3.0]))
    3.0
    """
    low, high = mesh.corners.min(axis=0), mesh.corners.max(axis=0)
    outside = np.maximum(np.maximum(low - point.reshape(3, 1), point.reshape(3, 1) - high), 0.0)
    return float(np.sqrt(dot(outside, outside)).min())


def load_mesh(mesh: Mesh, folder: Path) -> TriangleMesh:
    r"""Read a mesh's file below `folder` and put it where the record says.

    Vertex normals are taken from the file if it carries them.  The caller checks that the path stays in the folder.

    Raises
    ------
    ValueError
        If the file is missing, is no mesh, or its materials are not in `mesh.material`.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> _ = (folder / "one.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    >>> load_mesh(Mesh("one.obj", "red", scale=2), folder).vertices.max()
    np.float64(2.0)
    """
    try:
        parts = _read(folder / mesh.file)
        names = _material_names(mesh, [part.material for part in parts])
        return _joined(mesh, parts, names)
    except (OSError, ValueError) as error:
        raise ValueError(f"{mesh.file}: {error}") from error


@dataclass(frozen=True, eq=False)
class _Part:
    """The triangles of one material of a file, with its rows (vertex, axis) as trimesh gives them."""

    material: str | None
    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None
    uv: np.ndarray | None


def _read(path: Path) -> list[_Part]:
    """The parts of a mesh file, each in the file's own coordinates."""
    import trimesh  # noqa: PLC0415 (half a second, only for scenes with meshes)

    if not path.is_file():
        raise ValueError("there is no such file; give a path below the scene's folder")
    try:
        # The readers warn of nan and of empty files, which are errors here, found below.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(path, process=False)
    except Exception as error:
        raise ValueError(f"trimesh cannot read it ({error}); give an OBJ, PLY, STL, OFF or GLB file") from error
    nodes = [(scene.graph[node], node) for node in sorted(scene.graph.nodes_geometry)]
    parts = [_part(scene.geometry[name], matrix) for (matrix, name), _ in nodes]
    if not any(len(part.faces) for part in parts):
        raise ValueError("it has no triangles; give a mesh file with at least one face")
    return [part for part in parts if len(part.faces)]


def _part(
    geometry: Any,
    matrix: np.ndarray,
) -> _Part:
    """One geometry of a trimesh scene, put where the file's own transformation says."""
    faces = np.asarray(getattr(geometry, "faces", np.zeros((0, 3))), dtype=np.int64)
    vertices = np.asarray(geometry.vertices, dtype=float)
    linear = np.asarray(matrix[:3, :3], dtype=float)
    # trimesh computes normals when asked; only those in its cache were in the file.
    carried = "vertex_normals" in geometry._cache  # noqa: SLF001
    normals = np.asarray(geometry.vertex_normals, dtype=float) @ _cofactors(linear).T if carried else None
    if np.linalg.det(linear) < 0:
        faces = faces[:, ::-1]
    visual = getattr(geometry, "visual", None)
    uv = getattr(visual, "uv", None)
    return _Part(
        material=getattr(getattr(visual, "material", None), "name", None),
        vertices=vertices @ linear.T + matrix[:3, 3],
        faces=faces,
        normals=normals,
        uv=None if uv is None else np.asarray(uv, dtype=float),
    )


def _cofactors(linear: np.ndarray) -> np.ndarray:
    """The matrix that takes normals along with ``p' = linear p``, mirror images included."""
    rows = [np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)]
    return np.array(rows) * np.sign(np.linalg.det(linear))


def _material_names(mesh: Mesh, found: list[str | None]) -> list[str]:
    """Our name for the material of each part."""
    if isinstance(mesh.material, str):
        return [mesh.material] * len(found)
    missing = sorted({str(name) for name in found if name not in mesh.material})
    if missing:
        raise ValueError(
            f"material maps {sorted(mesh.material)}, but the file's materials include {missing}; "
            "map every one, or give a single name (an OBJ names its materials in its .mtl)"
        )
    return [mesh.material[name] for name in found if name is not None]


def _joined(mesh: Mesh, parts: list[_Part], names: list[str]) -> TriangleMesh:
    """All parts as one mesh, scaled, turned and moved."""
    materials = tuple(dict.fromkeys(names))
    turn = _rotation(mesh.rotate)
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    normals = uv = None
    if all(part.normals is not None for part in parts):
        normals = turn @ np.concatenate([np.asarray(part.normals) for part in parts]).T
        # A file may round its normals or weigh them; between corners only their directions are blended.
        lengths = np.linalg.norm(normals, axis=0)
        normals = normals / np.where(lengths > 0, lengths, 1.0)
    if all(part.uv is not None for part in parts):
        uv = np.concatenate([np.asarray(part.uv) for part in parts]).T
        # Files count v from the bottom of the picture, we from its top.
        uv = np.stack([uv[0], 1 - uv[1]])
    points = np.concatenate([part.vertices for part in parts]).T
    return TriangleMesh(
        vertices=turn @ (mesh.scale * points) + np.array(mesh.translate, dtype=float).reshape(3, 1),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]).T,
        materials=materials,
        face_material=np.repeat([materials.index(name) for name in names], [len(part.faces) for part in parts]),
        normals=normals,
        uv=uv,
    )


def _rotation(degrees: Triple) -> np.ndarray:
    """``Rz Ry Rx``: about x first, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def _all_finite(name: str, values: Float[np.ndarray, "_ _"]) -> None:
    good = np.isfinite(values).all(axis=0)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(f"{name} {bad} is {values[:, bad].tolist()}: coordinates must be finite; repair the mesh")


def _in_range(name: str, values: Int[np.ndarray, "_ _"], count: int) -> None:
    good = ((values >= 0) & (values < count)).all(axis=0)
    if not good.all():
        bad = int(np.argmin(good))
        raise ValueError(f"{name} {bad} is {values[:, bad].tolist()}: indices must be from 0 to {count - 1}")
