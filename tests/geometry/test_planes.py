"""Flat shapes against exact rationals: hard case G10, borders, coordinates."""

import numpy as np
import pytest
from geometry.both import intersect, nearest
from geometry.oracles import across, digits, directions, inner, minus, rational, rays, ulps

from symrt.geometry import Disk, Plane, Rectangle, clearance, encloses, surfaces, translate

DRAWS = [2_000, pytest.param(100_000, marks=pytest.mark.exhaustive)]
RAYS = 50


def plane_distance(origin, direction, point, normal):
    """The exact quotient, or None where the plane is behind or parallel."""
    o, d, p, n = rational(origin), rational(direction), rational(point), rational(normal)
    slope = inner(d, n)
    return None if slope == 0 or inner(minus(p, o), n) / slope <= 0 else digits(inner(minus(p, o), n) / slope)


def check(plane, ray):
    found = intersect(plane, ray).distance
    hits = 0
    for k in range(len(ray)):
        true = plane_distance(ray.origin[:, k], ray.direction[:, k], plane.point, plane.normal)
        assert np.isfinite(found[k]) == (true is not None)
        if true is not None:
            assert ulps(found[k], true) <= 2
            hits += 1
    return hits


@pytest.mark.parametrize("draws", DRAWS)
def test_planes_are_met_within_two_ulp_even_at_grazing_incidence(draws):
    generator = np.random.default_rng(1)
    hits = 0
    for _ in range(draws // RAYS):
        normal = generator.normal(size=(3, 1)) * 10 ** generator.uniform(-3, 3)
        unit = normal / np.linalg.norm(normal)
        slope = generator.choice([-1, 1], RAYS) * 10 ** generator.uniform(-12, -0.5, RAYS)
        direction = across(generator, np.repeat(unit, RAYS, axis=1)) + slope * unit
        direction /= np.sqrt((direction * direction).sum(axis=0))
        origin = 1e3 * generator.normal(size=(3, RAYS))
        point = tuple((1e3 * generator.normal(size=3)).tolist())
        hits += check(Plane(point, tuple(normal[:, 0].tolist()), "floor"), rays(origin, direction))
    assert hits > draws / 4


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_planes_across_an_axis_are_met_within_two_ulp(axis):
    generator = np.random.default_rng(2)
    normal = tuple(float(-3.7 * (k == axis)) for k in range(3))
    point = tuple(generator.normal(size=3).tolist())
    assert check(Plane(point, normal, "floor"), rays(generator.normal(size=(3, 500)), directions(generator, 500))) > 100


def test_a_ray_in_the_plane_or_parallel_to_it_misses():
    direction = np.array([[1.0, 0.6], [0.0, 0.8], [0.0, 0.0]])
    for height in (0.0, 1.0, -1.0):
        origin = np.array([[0.0, 0.0], [0.0, 0.0], [height, height]])
        assert np.all(intersect(Plane((5, 5, 0), (0, 0, 1), "floor"), rays(origin, direction)).distance == np.inf)
    # (1, 1, −2) is perpendicular to (1, 1, 1), in floats as well.
    diagonal = np.array([[1.0], [1.0], [-2.0]]) / np.sqrt(6.0)
    assert np.sum(diagonal) == 0
    assert intersect(Plane((1, 0, 0), (1, 1, 1), "floor"), rays(np.zeros((3, 1)), diagonal)).distance[0] == np.inf


def test_borders_belong_to_discs_and_rectangles():
    down = np.repeat([[0.0], [-1.0], [0.0]], 4, axis=1)
    at = np.array([[3.0, 0.0, -3.0, np.nextafter(3.0, 4.0)], [5.0] * 4, [4.0, 5.0, 4.0, 4.0]])
    assert np.isfinite(intersect(Disk((0, 0, 0), (0, 1, 0), 5, "base"), rays(at, down)).distance).tolist() == [
        True,
        True,
        True,
        False,
    ]
    rectangle = Rectangle((0, 0, 0), (6, 0, 0), (0, 0, -8), "base")
    assert np.isfinite(intersect(rectangle, rays(at, down)).distance).tolist() == [True, False, True, False]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_discs_and_rectangles_are_met_where_the_plane_is_met_inside(scale):
    generator = np.random.default_rng(3)
    for _ in range(20):
        normal, u = directions(generator, 1), None
        u = across(generator, normal)
        v = np.cross(normal, u, axis=0)
        centre = scale * generator.normal(size=(3, 1))
        a, b = generator.uniform(-1, 1, (2, 200)) * scale
        direction = directions(generator, 200)
        origin = centre + a * u + b * v - 5 * scale * direction
        ray = rays(origin, direction)
        c = tuple(centre[:, 0].tolist())
        rim = np.abs(np.hypot(a, b) / (0.7 * scale) - 1) > 1e-9
        disc = intersect(Disk(c, tuple(normal[:, 0].tolist()), 0.7 * scale, "base"), ray)
        assert np.array_equal((np.hypot(a, b) <= 0.7 * scale)[rim], np.isfinite(disc.distance)[rim])
        inside = (np.abs(a) <= 0.5 * scale) & (np.abs(b) <= 0.25 * scale)
        edges = (tuple((scale * u[:, 0]).tolist()), tuple((0.5 * scale * v[:, 0]).tolist()))
        rectangle = intersect(Rectangle(c, *edges, "base"), ray)
        assert np.array_equal(inside, np.isfinite(rectangle.distance))


def test_a_rectangle_counts_from_its_corner_along_its_edges():
    floor = Rectangle((10, 0, 0), (20, 0, 0), (0, 0, -10), "floor")
    origin = np.array([[0.0, 5.0, 20.0], [3.0, 3.0, 3.0], [5.0, 0.0, -5.0]])
    ray = rays(origin, np.repeat([[0.0], [-1.0], [0.0]], 3, axis=1))
    found = surfaces([floor], ray, nearest([floor], ray))
    np.testing.assert_array_equal(found.uv, [[0.0, 0.25, 1.0], [0.0, 0.5, 1.0]])
    np.testing.assert_array_equal(found.extent, [[20.0] * 3, [10.0] * 3])
    np.testing.assert_array_equal(found.normal, np.repeat([[0.0], [1.0], [0.0]], 3, axis=1))


@pytest.mark.parametrize(
    ("normal", "u", "v"),
    [((0, 1, 0), (-1, 0, 0), (0, 0, 1)), ((0, 0, 1), (0, -1, 0), (1, 0, 0)), ((2, 0, 0), (0, 1, 0), (0, 0, 1))],
)
def test_plane_coordinates_are_scene_units_in_a_right_handed_frame(normal, u, v):
    plane = Plane((1, 2, 3), normal, "floor")
    target = np.array([1.0, 2.0, 3.0]) + 0.5 * np.array(u) + 4 * np.array(v)
    unit = np.array(normal, float) / np.linalg.norm(normal)
    ray = rays((target + 7 * unit).reshape(3, 1), -unit.reshape(3, 1))
    found = surfaces([plane], ray, nearest([plane], ray))
    np.testing.assert_allclose(found.uv[:, 0], [0.5, 4.0], rtol=1e-12)
    np.testing.assert_array_equal(found.extent[:, 0], [1, 1])
    np.testing.assert_array_equal(np.cross(u, v), unit)


def test_points_lie_on_the_plane_within_their_stated_error():
    generator = np.random.default_rng(4)
    for _ in range(200):
        normal = generator.normal(size=3)
        point = generator.normal(size=3) * 10 ** generator.uniform(-8, 8)
        plane = Plane(tuple(point.tolist()), tuple(normal.tolist()), "floor")
        ray = rays(generator.normal(size=(3, 8)) * 10 ** generator.uniform(-8, 8), directions(generator, 8))
        hits = nearest([plane], ray)
        found = surfaces([plane], ray, hits)
        for j in np.flatnonzero(hits.shape == 0):
            height = inner(minus(rational(found.point[:, j]), rational(point)), rational(normal))
            assert abs(float(digits(height))) / np.linalg.norm(normal) <= found.error[j]


def test_clearance_is_the_distance_to_the_nearest_of_many_points():
    generator = np.random.default_rng(5)
    disc = Disk((1, 0, 0), (0, 2, 0), 1.5, "base")
    rectangle = Rectangle((0, 1, 0), (2, 0, 0), (0, 0, -3), "base")
    r, turn = 1.5 * np.sqrt(generator.uniform(size=100_000)), generator.uniform(0, 2 * np.pi, 100_000)
    on_disc = np.stack([1 + r * np.cos(turn), 0 * r, r * np.sin(turn)])
    a, b = generator.uniform(-0.5, 0.5, (2, 100_000))
    on_rectangle = np.stack([2 * a, 0 * a + 1, -3 * b])
    for shape, points in ((disc, on_disc), (rectangle, on_rectangle)):
        for _ in range(20):
            point = 3 * generator.normal(size=3)
            sampled = np.sqrt(((points - point[:, None]) ** 2).sum(axis=0)).min()
            assert clearance(shape, point) <= sampled * (1 + 1e-12)
            # A hundred thousand points stand about 0.01 apart.
            assert clearance(shape, point) >= sampled - 0.02
        assert not encloses(shape, np.zeros(3))


def test_moving_a_flat_shape_moves_its_hits():
    by = np.array([0.5, -0.25, 2.0])
    ray = rays(np.array([[0.1], [3.0], [0.2]]), np.array([[0.0], [-1.0], [0.0]]))
    there = rays(ray.origin + by[:, None], ray.direction)
    for shape in (
        Plane((0, 0, 0), (0, 1, 0), "a"),
        Disk((0, 0, 0), (0, 1, 0), 1, "a"),
        Rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1), "a"),
    ):
        assert intersect(translate(shape, by), there).distance == intersect(shape, ray).distance


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Plane((0, 0, 0), (0, 0, 0), "a"), "normal = \\(0, 0, 0\\): it must not be zero"),
        (lambda: Plane((0, 0, float("nan")), (0, 1, 0), "a"), "point"),
        (lambda: Disk((0, 0, 0), (0, 1, 0), 0, "a"), "radius = 0"),
        (lambda: Rectangle((0, 0, 0), (1, 0, 0), (1, 1, 0), "a"), "perpendicular"),
        (lambda: Rectangle((0, 0, 0), (1, 0, 0), (0, 0, 0), "a"), "edge_v"),
    ],
)
def test_a_flat_shape_that_cannot_be_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()
