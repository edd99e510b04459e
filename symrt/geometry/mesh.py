"""Mesh files (step 1): read by trimesh, named materials and vertex normals kept, and put where the scene says."""

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from symrt.errors import hinting
from symrt.geometry.records import Triple, finite, positive
from symrt.geometry.triangle_mesh import TriangleMesh

FORMATS = (".obj", ".ply", ".stl", ".off", ".glb", ".gltf")


@hinting
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
        # Numbers that are no numbers, or too large, are found in the end, by the record of triangles.
        with np.errstate(all="ignore"):
            parts = _read(folder / mesh.file)
            return _joined(mesh, parts, _material_names(mesh, [part.material for part in parts]))
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
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path.suffix!r} is not the suffix of a mesh that is read: {', '.join(FORMATS)}")
    try:
        # The readers warn of nan and of empty files, which are errors here, found below.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            scene = trimesh.load_scene(path, process=False)
    except Exception as error:
        raise ValueError(f"trimesh cannot read it ({error}); is it whole, and what its suffix says?") from error
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
        vertices=(transformed(linear, vertices.T) + matrix[:3, 3:]).T,
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
    turn = rotation(mesh.rotate)
    starts = np.cumsum([0] + [len(part.vertices) for part in parts])
    normals = uv = None
    if all(part.normals is not None for part in parts):
        normals = transformed(turn, np.concatenate([np.asarray(part.normals) for part in parts]).T)
        # A file may round its normals or weigh them; between corners only their directions are blended.
        lengths = np.linalg.norm(normals, axis=0)
        normals = normals / np.where(lengths > 0, lengths, 1.0)
    if all(part.uv is not None for part in parts):
        uv = np.concatenate([np.asarray(part.uv) for part in parts]).T
        # Files count v from the bottom of the picture, we from its top.
        uv = np.stack([uv[0], 1 - uv[1]])
    points = np.concatenate([part.vertices for part in parts]).T
    return TriangleMesh(
        vertices=transformed(turn, mesh.scale * points) + np.array(mesh.translate, dtype=float).reshape(3, 1),
        faces=np.concatenate([part.faces + start for part, start in zip(parts, starts[:-1], strict=True)]).T,
        materials=materials,
        face_material=np.repeat([materials.index(name) for name in names], [len(part.faces) for part in parts]),
        normals=normals,
        uv=uv,
    )


def transformed(matrix: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """``matrix · v`` for each column; without BLAS, which may round equal columns differently and open seams.

    Examples
    --------
    >>> transformed(np.eye(3), np.array([[1.0], [2.0], [3.0]])).T
    array([[1., 2., 3.]])
    """
    return np.stack([row[0] * vectors[0] + row[1] * vectors[1] + row[2] * vectors[2] for row in matrix])


def rotation(degrees: Triple) -> np.ndarray:
    """``Rz Ry Rx``: about x first, then y, then z.

    Examples
    --------
    >>> rotation((0, 0, 90)).round(15)[:, 0].tolist()
    [0.0, 1.0, 0.0]
    """
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_x = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x
