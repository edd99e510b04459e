"""Meshes: exact rationals, watertightness (G5), needles (G6), boxes (G11), Embree and the hierarchy, surfaces."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from geometry.both import intersect, nearest
from geometry.oracles import across, digits, directions, inner, minus, outer, rational, rays, ulps
from geometry.shapes import from_trimesh, icosphere, random_mesh, star, torus

from symrt import geometry
from symrt.geometry import TriangleMesh, clearance, encloses, surfaces, translate, triangles

needs_embree = pytest.mark.skipif(importlib.util.find_spec("embreex") is None, reason="embreex is not installed")
WAYS = ["hierarchy", pytest.param("embree", marks=needs_embree)]


def without_embree(mesh):
    """The same mesh where Embree is not installed."""
    twin = replace(mesh)
    vars(twin)["thickened"] = None
    return twin


def by(way, mesh):
    assert way == "hierarchy" or mesh.thickened is not None
    return without_embree(mesh) if way == "hierarchy" else mesh


def exact_hit(mesh, origin, direction):
    """Nearest triangle and distance in exact rationals (Möller and Trumbore without rounding), or None."""
    o, d = rational(origin), rational(direction)
    best = None
    for face, corners in enumerate(np.moveaxis(mesh.corners, 2, 0)):
        a, b, c = (rational(corner) for corner in corners)
        edge_b, edge_c, offset = minus(b, a), minus(c, a), minus(o, a)
        across = outer(d, edge_c)
        volume = inner(edge_b, across)
        if volume == 0:
            continue
        sideways = outer(offset, edge_b)
        v, w, t = inner(offset, across) / volume, inner(d, sideways) / volume, inner(edge_c, sideways) / volume
        if v >= 0 and w >= 0 and v + w <= 1 and t > 0 and (best is None or t < best[1]):
            best = (face, t)
    return best


def test_triangles_are_met_as_in_exact_arithmetic():
    generator = np.random.default_rng(1)
    mesh = random_mesh(40, 2)
    towards = directions(generator, 150)
    seen = rays(generator.uniform(-1.5, 1.5, (3, 150)) - 4 * towards, towards)
    found = intersect(mesh, seen)
    for k in range(150):
        true = exact_hit(mesh, seen.origin[:, k], seen.direction[:, k])
        assert found.primitive[k] == (-1 if true is None else true[0])
        if true is not None:
            # The triangle's plane is kept as a unit normal, rounded: a few ulp at grazing incidence.
            assert ulps(found.distance[k], digits(true[1])) <= 50


def test_a_ray_through_the_very_middle_of_a_triangle_meets_it():
    # All three edge functions are equal there.
    corner = TriangleMesh(np.eye(3), np.array([[0], [1], [2]]), materials=("a",))
    diagonal = np.full((3, 1), 1 / np.sqrt(3.0))
    for start, towards in ((np.zeros((3, 1)), diagonal), (3 * diagonal, -diagonal)):
        assert intersect(corner, rays(start, towards)).primitive[0] == 0


def edge_points(mesh, count, generator):
    """Points on edges, and all vertices."""
    faces = mesh.faces[:, generator.integers(0, mesh.faces.shape[1], count)]
    share = generator.uniform(0, 1, count)
    share[: count // 4] = 0.5
    a, b = mesh.vertices[:, faces[0]], mesh.vertices[:, faces[1]]
    return np.concatenate([a + share * (b - a), mesh.vertices], axis=1)


@pytest.mark.parametrize("count", [3_000, pytest.param(1_000_000, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_no_ray_slips_through_the_edges_and_corners_of_a_closed_mesh(way, count, scale):
    generator = np.random.default_rng(3)
    for rough in (star(4, 4), icosphere(3)):
        mesh = by(way, replace(rough, vertices=scale * rough.vertices))
        target = edge_points(mesh, count, generator)
        start = scale * generator.uniform(-0.2, 0.2, (3, 1)) + np.zeros_like(target)
        towards = target - start
        towards /= np.sqrt((towards * towards).sum(axis=0))
        assert np.sum(np.isinf(intersect(mesh, rays(start, towards)).distance)) == 0
        # From outside, through the same points, the surface is met as well.
        outside = rays(start + 5 * scale * towards, -towards)
        assert np.all(intersect(mesh, outside).distance < 5 * scale)


@pytest.mark.parametrize("way", WAYS)
def test_rays_exactly_through_the_corners_of_a_grid_meet_it(way):
    # A wall of 32 × 32 squares with exact coordinates, rays exactly at its corners, edges and middles.
    n = 33
    x, y = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n)))
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate([[corner, corner + 1, corner + n], [corner + 1, corner + n + 1, corner + n]], axis=1)
    wall = by(way, TriangleMesh(np.stack([x, y, 0 * x]).astype(float), faces, materials=("a",)))
    at = np.stack(np.meshgrid(np.arange(0, 32.5, 0.5), np.arange(0, 32.5, 0.5))).reshape(2, -1)
    for z in (5.0, -5.0):
        start = np.concatenate([at, np.full((1, at.shape[1]), z)])
        seen = rays(start, np.repeat([[0.0], [0.0], [-np.sign(z)]], at.shape[1], axis=1))
        assert np.all(intersect(wall, seen).distance == 5.0)


@needs_embree
@pytest.mark.parametrize("draws", [4_000, pytest.param(200_000, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize(
    "mesh", [torus(), star(3, 5), icosphere(3), random_mesh(400, 6)], ids=["torus", "star", "ball", "soup"]
)
def test_embree_and_the_hierarchy_give_the_same_hits(mesh, draws):
    generator = np.random.default_rng(7)
    towards = directions(generator, draws)
    inside = generator.uniform(-1.5, 1.5, (3, draws))
    assert mesh.thickened is not None
    edges = edge_points(mesh, draws, generator)[:, :draws]
    for start in (inside, inside - 4 * towards, inside - 1e6 * towards, edges - 3 * towards, edges):
        seen = rays(start, towards)
        one, other = intersect(mesh, seen), intersect(without_embree(mesh), seen)
        np.testing.assert_array_equal(one.primitive, other.primitive)
        np.testing.assert_array_equal(one.distance, other.distance)


@needs_embree
def test_embree_tells_surfaces_apart_that_single_precision_cannot():
    generator = np.random.default_rng(8)
    ball = icosphere(3)
    # A second skin, thinner than single precision can see; the outer one is listed last.
    skins = TriangleMesh(
        np.concatenate([ball.vertices, ball.vertices * (1 + 1e-9)], axis=1),
        np.concatenate([ball.faces, ball.faces + ball.vertices.shape[1]], axis=1),
        materials=("a",),
    )
    towards = directions(generator, 3000)
    seen = rays(0.9 * generator.uniform(-0.5, 0.5, (3, 3000)) - 4 * towards, towards)
    found = intersect(skins, seen)
    assert np.all(found.primitive >= ball.faces.shape[1])
    np.testing.assert_array_equal(found.distance, intersect(without_embree(skins), seen).distance)


@pytest.mark.parametrize("nudge", [0.0, 2.0**-45])
def test_degenerate_and_needle_triangles_make_no_nan_and_no_false_hit(nudge):
    generator = np.random.default_rng(9)
    count = 200
    start, along = generator.normal(size=(3, count)), directions(generator, count)
    share = generator.uniform(size=count)
    # Three points on a line up to rounding, then moved; a tenth of the triangles has two equal corners.
    share[: count // 10] = 0.0
    corners = np.stack([start, start + share * along, start + along]) + nudge * generator.normal(size=(3, 3, count))
    if nudge == 0:
        corners[1, :, : count // 10] = corners[0, :, : count // 10]
    needles = TriangleMesh(
        corners.transpose(1, 0, 2).reshape(3, -1), np.arange(3 * count).reshape(3, count), materials=("a",)
    )
    aim = np.repeat(start, 20, axis=1) + generator.uniform(size=20 * count) * np.repeat(along, 20, axis=1)
    towards = directions(generator, 20 * count)
    seen = rays(aim - 3 * towards, towards)
    for mesh in (needles, without_embree(needles)):
        found = intersect(mesh, seen)
        assert not np.isnan(found.distance).any()
        met = np.flatnonzero(np.isfinite(found.distance))
        assert not np.any(found.primitive[met] < count // 10) or nudge
        # A needle is a segment to within its width: what is met lies on it, as far as a grazing ray can tell.
        point = seen.origin[:, met] + found.distance[met] * seen.direction[:, met]
        offset, unit = point - start[:, found.primitive[met]], along[:, found.primitive[met]]
        beside = offset - (offset * unit).sum(axis=0) * unit
        facing = np.abs((needles.unit_normals[:, found.primitive[met]] * seen.direction[:, met]).sum(axis=0))
        assert np.all(np.sqrt((beside * beside).sum(axis=0)) * facing <= 8 * nudge + 4e-15)
        described = surfaces([mesh], seen, nearest([mesh], seen))
        assert np.all(np.isfinite(described.normal))
        assert np.all(np.isfinite(described.point))


@pytest.mark.parametrize("way", WAYS)
def test_rays_in_the_faces_of_boxes_are_treated_like_any_other(way):
    # Blocks with faces on whole numbers, so that their boxes' faces, and those of groups of them, are shared planes.
    generator = np.random.default_rng(10)
    blocks = [trimesh.creation.box((1, 1, 1)) for _ in range(27)]
    for k, block in enumerate(blocks):
        block.apply_translation([k % 3 * 2, k // 3 % 3 * 2, k // 9 * 2])
    mesh = by(way, from_trimesh(trimesh.util.concatenate(blocks)))
    starts = generator.integers(-4, 12, (3, 600)) / 2.0
    towards = np.eye(3)[:, generator.integers(0, 3, 600)] * generator.choice([-1.0, 1.0], 600)
    diagonal = generator.choice([-1.0, 0.0, 1.0], (3, 600))
    diagonal[:, ~diagonal.any(axis=0)] = 1
    diagonal /= np.sqrt((diagonal * diagonal).sum(axis=0))
    for direction in (towards, diagonal):
        seen = rays(starts, direction)
        ray, face = (a.ravel() for a in np.meshgrid(np.arange(600), np.arange(mesh.faces.shape[1])))
        distance = triangles.crossings(mesh.corners, mesh.unit_normals, seen, ray, face)
        distance = np.where(distance > 0, distance, np.inf).reshape(-1, 600).min(axis=0)
        np.testing.assert_array_equal(intersect(mesh, seen).distance, distance)
        assert np.isfinite(distance).any()


def test_smooth_normals_are_blended_and_flat_ones_are_the_faces():
    ball = icosphere(3)
    smooth = replace(ball, normals=ball.vertices)
    generator = np.random.default_rng(11)
    towards = directions(generator, 400)
    seen = rays(0.5 * generator.uniform(-1, 1, (3, 400)) - 4 * towards, towards)
    hits = nearest([smooth], seen)
    found = surfaces([smooth], seen, hits)
    met = hits.shape == 0
    # On a ball whose vertex normals are its points, the blend is the point's own direction.
    true = found.point[:, met] / np.sqrt((found.point[:, met] ** 2).sum(axis=0))
    np.testing.assert_allclose(found.shading_normal[:, met], true, atol=1e-12)
    np.testing.assert_allclose((found.normal[:, met] * ball.unit_normals[:, hits.primitive[met]]).sum(axis=0), 1, 1e-12)
    flat = surfaces([ball], seen, hits)
    np.testing.assert_array_equal(flat.normal, flat.shading_normal)


def test_texture_coordinates_are_blended_and_default_to_the_triangles_own():
    corners = np.array([[0.0, 2.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])
    plain = TriangleMesh(corners, np.array([[0], [1], [2]]), materials=("a",))
    given = replace(plain, uv=np.array([[10.0, 20.0, 10.0], [1.0, 1.0, 5.0]]))
    down = rays(np.array([[0.5], [1.0], [3.0]]), np.array([[0.0], [0.0], [-1.0]]))
    np.testing.assert_allclose(surfaces([plain], down, nearest([plain], down)).uv[:, 0], [0.25, 0.5], rtol=1e-12)
    np.testing.assert_allclose(surfaces([given], down, nearest([given], down)).uv[:, 0], [12.5, 3.0], rtol=1e-12)


def test_points_lie_on_their_triangle_within_their_stated_error():
    generator = np.random.default_rng(12)
    for exponent in range(-8, 9, 4):
        mesh = random_mesh(30, 13)
        mesh = translate(replace(mesh, vertices=mesh.vertices * 10.0**exponent), generator.normal(size=3))
        towards = directions(generator, 60)
        seen = rays(mesh.vertices.mean(axis=1, keepdims=True) - 4 * 10.0**exponent * towards, towards)
        hits = nearest([mesh], seen)
        found = surfaces([mesh], seen, hits)
        for k in np.flatnonzero(hits.shape == 0):
            a, b, c = (rational(corner) for corner in mesh.corners[:, :, hits.primitive[k]])
            normal = outer(minus(b, a), minus(c, a))
            height = inner(minus(rational(found.point[:, k]), a), normal)
            assert abs(float(digits(height))) / float(digits(inner(normal, normal))) ** 0.5 <= found.error[k]


def test_inside_is_where_the_surface_winds_around():
    ring = torus()
    assert encloses(ring, np.array([1.0, 0.0, 0.1]))
    assert not encloses(ring, np.array([0.0, 0.0, 0.0]))
    assert not encloses(ring, np.array([1.0, 0.0, 0.4]))
    opened = replace(ring, faces=np.ascontiguousarray(ring.faces[:, 1:]))
    assert not encloses(opened, np.array([1.0, 0.0, 0.1]))


def test_clearance_is_that_of_trimesh():
    generator = np.random.default_rng(14)
    rough = star(2, 15)
    made = trimesh.Trimesh(rough.vertices.T, rough.faces.T, process=False)
    for _ in range(30):
        point = generator.uniform(-2, 2, 3)
        distance = np.sqrt(
            ((trimesh.triangles.closest_point(made.triangles, np.tile(point, (len(made.faces), 1))) - point) ** 2).sum(
                1
            )
        ).min()
        np.testing.assert_allclose(clearance(rough, point), distance, rtol=1e-7)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"vertices": np.array([[0, np.nan, 0], [0, 0, 1.0], [0, 0, 0]])}, "vertex 1 is .*finite"),
        ({"faces": np.array([[0], [1], [3]])}, "face 0 is \\[0, 1, 3\\]: indices must be from 0 to 2"),
        ({"faces": np.array([[0], [1], [-1]])}, "face 0"),
        ({"faces": np.zeros((3, 0), int)}, "no triangles"),
        ({"face_material": np.array([1])}, "face_material 0"),
        ({"normals": np.full((3, 3), np.inf)}, "normal 0"),
        ({"uv": np.full((2, 3), np.nan)}, "texture coordinate 0"),
    ],
)
def test_triangles_that_cannot_be_are_refused(change, said):
    good = {
        "vertices": np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]),
        "faces": np.array([[0], [1], [2]]),
        "materials": ("a",),
    }
    with pytest.raises(ValueError, match=said):
        TriangleMesh(**(good | change))


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(2, 40))])
def test_what_is_grazed_is_not_left_to_single_precision(seed):
    # Large triangles in pairs: one that rays graze, from above it or from outside, and one across their way, a little
    # further or nearer.  Single precision may see the first anywhere along the ray, or not at all.
    generator = np.random.default_rng(seed)
    corners, origins, ways = [], [], []
    for _ in range(40):
        place, size = 0.25 * generator.normal(size=3), 10 ** generator.uniform(-1.5, -0.2)
        up = directions(generator, 1)
        along = across(generator, up)
        up, along, aside = up[:, 0], along[:, 0], np.cross(up, along, axis=0)[:, 0]
        shift, gap = generator.uniform(-0.2, 0.2) * size, 2.0 ** generator.uniform(-14, -2)
        other = place + (shift + gap) * along
        for middle, right, top in ((place, along, aside), (other, aside, up)):
            corners += [middle + size * (x * right + y * top) for x, y in ((-1, -0.6), (1, -0.6), (0, 1))]
        count = 25
        angle = 2.0 ** generator.uniform(-30, -5, count) * generator.choice([-1, 1], count)
        way = np.cos(angle) * along[:, None] - np.sin(angle) * up[:, None]
        target = (place + shift * along)[:, None] + 0.1 * size * generator.uniform(-1, 1, count) * aside[:, None]
        origins.append(target - 10 ** generator.uniform(-2, 0.3, count) * way)
        ways.append(way / np.sqrt((way * way).sum(axis=0)))
    vertices, seen = np.array(corners).T, rays(np.concatenate(origins, axis=1), np.concatenate(ways, axis=1))
    faces = np.arange(vertices.shape[1]).reshape(-1, 3).T

    # Each triangle by itself, without Embree or a hierarchy.
    nearest_one = np.full(len(seen), np.inf)
    for face in faces.T:
        alone = TriangleMesh(vertices[:, face], np.array([[0], [1], [2]]), ("a",))
        nearest_one = np.minimum(nearest_one, geometry.intersect(alone, seen).distance)
    found = intersect(TriangleMesh(vertices, faces, ("a",)), seen)
    np.testing.assert_array_equal(found.distance, nearest_one)
    assert np.isfinite(nearest_one).mean() > 0.5
