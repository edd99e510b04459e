"""Mesh files: formats, materials, normals, placement, and files that are refused."""

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from symrt.geometry import Mesh, encloses, load_mesh

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
TWO_MATERIALS = """mtllib two.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
usemtl shiny
f 1 2 3
usemtl dull
f 1 3 4
"""
MTL = "newmtl dull\nKd 1 0 0\nnewmtl shiny\nKd 0 1 0\n"


def write(folder, **files):
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text)
    return folder


@pytest.mark.parametrize("kind", ["obj", "ply", "stl", "off", "glb"])
def test_a_ball_is_the_same_in_every_format(tmp_path, kind):
    ball = trimesh.creation.icosphere(subdivisions=2)
    ball.export(tmp_path / f"ball.{kind}")
    mesh = load_mesh(Mesh(f"ball.{kind}", "red"), tmp_path)
    assert mesh.faces.shape == (3, 320)
    assert mesh.materials == ("red",)
    # OBJ, PLY, STL and GLB keep single precision or eight digits.
    np.testing.assert_allclose(np.sqrt((mesh.vertices**2).sum(axis=0)), 1, rtol=1e-7)
    assert np.all((mesh.unit_normals * mesh.corners.mean(axis=0)).sum(axis=0) > 0.9)


@pytest.mark.parametrize("kind", ["obj", "ply", "glb"])
def test_normals_that_are_in_the_file_are_kept(tmp_path, kind):
    ball = trimesh.creation.icosphere(subdivisions=2)
    odd = np.roll(ball.vertices, 1, axis=1)
    trimesh.Trimesh(ball.vertices, ball.faces, vertex_normals=odd, process=False).export(tmp_path / f"ball.{kind}")
    mesh = load_mesh(Mesh(f"ball.{kind}", "red", rotate=(0, 0, 90)), tmp_path)
    assert mesh.normals is not None
    # Turned by 90° about z: (x, y, z) goes to (−y, x, z).
    x, y, z = mesh.vertices
    turned = np.array([y, -x, z])
    rolled = np.roll(turned, 1, axis=0)
    np.testing.assert_allclose(mesh.normals, np.array([-rolled[1], rolled[0], rolled[2]]), atol=1e-6)


def test_a_file_without_normals_is_flat(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=2)
    _ = ball.vertex_normals
    ball.export(tmp_path / "ball.off")
    assert load_mesh(Mesh("ball.off", "red"), tmp_path).normals is None


def test_a_mesh_is_scaled_then_turned_about_x_y_and_z_then_moved(tmp_path):
    write(tmp_path, one_obj="v 0.1 0.2 0.3\nv 1 -2 0.5\nv 0.25 1 3\nf 1 2 3\n")
    points = np.array([[0.1, 0.2, 0.3], [1, -2, 0.5], [0.25, 1, 3]])
    mesh = load_mesh(Mesh("one.obj", "red", scale=2.5, rotate=(20, -30, 40), translate=(5, 6, 7)), tmp_path)
    # SciPy's lower-case axes are extrinsic: about the fixed x axis first, then y, then z.
    turned = Rotation.from_euler("xyz", [20, -30, 40], degrees=True).apply(2.5 * points)
    np.testing.assert_allclose(mesh.vertices.T, turned + np.array([5, 6, 7]), rtol=1e-12)


def test_the_files_own_materials_are_named_by_ours(tmp_path):
    write(tmp_path, two_obj=TWO_MATERIALS, two_mtl=MTL)
    mesh = load_mesh(Mesh("two.obj", {"shiny": "brass", "dull": "wood"}), tmp_path)
    for face in range(2):
        name = mesh.materials[mesh.face_material[face]]
        # The face of the dull triangle has the corner (0, 1).
        has_corner = np.any(np.all(mesh.corners[:, :, face] == [0, 1, 0], axis=1))
        assert name == ("wood" if has_corner else "brass")
    both = load_mesh(Mesh("two.obj", {"shiny": "brass", "dull": "brass"}), tmp_path)
    assert both.materials == ("brass",)
    assert load_mesh(Mesh("two.obj", "clay"), tmp_path).materials == ("clay",)


def test_the_order_of_materials_does_not_hang_on_the_hash_seed(tmp_path):
    write(tmp_path, two_obj=TWO_MATERIALS, two_mtl=MTL)
    names = {"shiny": "brass", "dull": "wood"}
    import subprocess  # noqa: PLC0415
    import sys  # noqa: PLC0415

    code = (
        "from symrt.geometry import Mesh, encloses, load_mesh; from pathlib import Path; "
        f"m = load_mesh(Mesh('two.obj', {names}), Path({str(tmp_path)!r})); print(m.materials, m.vertices.tolist())"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={"PYTHONHASHSEED": s}
        ).stdout
        for s in "123"
    }
    assert len(said) == 1


def test_a_mirrored_part_still_faces_outwards(tmp_path):
    scene = trimesh.Scene()
    scene.add_geometry(trimesh.creation.icosphere(subdivisions=1), transform=np.diag([-1.0, 1.0, 2.0, 1.0]))
    scene.export(tmp_path / "ball.glb")
    mesh = load_mesh(Mesh("ball.glb", "red"), tmp_path)
    assert np.all((mesh.unit_normals * mesh.corners.mean(axis=0)).sum(axis=0) > 0)
    np.testing.assert_allclose(np.abs(mesh.vertices[2]).max(), 2 * np.abs(mesh.vertices[0]).max(), rtol=1e-6)


def test_triangles_that_share_corners_in_the_file_share_them_when_turned(tmp_path):
    # An STL file repeats every corner for each of its triangles.
    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "ball.stl")
    placed = Mesh("ball.stl", "red", scale=0.3, rotate=(10, 20, 30), translate=(1, 2, 3))
    mesh = load_mesh(placed, tmp_path)
    # 642 is Euler's V = 2 + F/2 for 1,280 triangles.
    assert np.unique(mesh.vertices, axis=1).shape[1] == 642
    assert mesh.is_closed
    assert encloses(mesh, np.array([1.0, 2.0, 3.0]))


def test_materials_outside_the_folder_are_not_read(tmp_path):
    inside = tmp_path / "inside"
    inside.mkdir()
    write(tmp_path, two_mtl=MTL)
    write(inside, two_obj=TWO_MATERIALS.replace("two.mtl", "../two.mtl"))
    with pytest.raises(ValueError, match="file's materials include"):
        load_mesh(Mesh("two.obj", {"shiny": "brass", "dull": "wood"}), inside)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("missing.obj", None, "there is no such file"),
        ("text.obj", "hello\n", "no triangles"),
        ("empty.obj", "", "no triangles"),
        ("text.ply", "hello\n", "cannot read it"),
        ("empty.stl", "", "no triangles|cannot read"),
        ("points.obj", "v 0 0 0\nv 1 0 0\n", "no triangles"),
        ("nan.obj", TRIANGLE.replace("v 1 0 0", "v 1 nan 0"), "vertex 1 .*finite"),
        ("huge.obj", TRIANGLE.replace("v 1 0 0", "v 1 1e999 0"), "finite"),
        ("range.obj", TRIANGLE.replace("f 1 2 3", "f 1 2 9"), "cannot read|indices"),
        ("what.xyzzy", TRIANGLE, "not the suffix of a mesh"),
        ("archive.zip", "PK", "not the suffix of a mesh"),
    ],
)
def test_a_file_that_is_no_mesh_is_refused_with_its_name(tmp_path, name, text, said):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=f"{name}: .*({said})"):
        load_mesh(Mesh(name, "red"), tmp_path)


def test_every_material_of_the_file_must_be_mapped(tmp_path):
    write(tmp_path, two_obj=TWO_MATERIALS, two_mtl=MTL, one_obj=TRIANGLE)
    with pytest.raises(ValueError, match="include \\['dull'\\]; map every one"):
        load_mesh(Mesh("two.obj", {"shiny": "brass"}), tmp_path)
    with pytest.raises(ValueError, match="map every one"):
        load_mesh(Mesh("one.obj", {"shiny": "brass"}), tmp_path)


@pytest.mark.parametrize("wrong", [{"scale": 0}, {"scale": float("nan")}, {"rotate": (0, float("inf"), 0)}])
def test_a_mesh_record_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Mesh("a.obj", "red", **wrong)
