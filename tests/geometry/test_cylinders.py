"""Cylinders against 50 digits: hard case G8, caps, seams, coordinates."""

import mpmath
import numpy as np
import pytest
from geometry.both import intersect, nearest
from geometry.oracles import across, digits, directions, inner, minus, outer, rational, rays, ulps

from symrt.geometry import Cylinder, clearance, encloses, surfaces

DRAWS = [2_000, pytest.param(100_000, marks=pytest.mark.exhaustive)]
RAYS = 50


def cylinder_distance(origin, direction, base, top, radius, capped):
    """Nearest crossing to 50 digits and the part that is met, or None: both meet as intervals of the line."""
    o, d, p, axis = rational(origin), rational(direction), rational(base), minus(rational(top), rational(base))
    m, w = minus(o, p), outer(d, axis)
    out, slope = outer(m, axis), inner(d, axis)
    a, b, c = inner(w, w), inner(out, w), inner(out, out) - rational(radius)[0] ** 2 * inner(axis, axis)
    if b * b < a * c:
        return None
    root = mpmath.sqrt(digits(b * b - a * c))
    q = -(digits(b) + (root if b > 0 else -root))
    side = sorted((q / digits(a), digits(c) / q))
    slab = sorted((digits(-inner(m, axis) / slope), digits((inner(axis, axis) - inner(m, axis)) / slope)))
    if not capped:
        return next((t for t in side if t > 0 and slab[0] <= t <= slab[1]), None)
    enter, leave = max(side[0], slab[0]), min(side[1], slab[1])
    if enter > leave or leave <= 0:
        return None
    return enter if enter > 0 else leave


def check(generator, draws, aim):
    hits = 0
    for index in range(draws // RAYS):
        radius, height = (10 ** generator.uniform(-2, 2, 2)).tolist()
        unit = directions(generator, 1)
        base = generator.normal(size=(3, 1))
        top = base + height * unit
        ray = rays(*aim(unit, base, height, radius))
        capped = bool(index % 2)
        ends = (base[:, 0], top[:, 0])
        cylinder = Cylinder(*(tuple(end.tolist()) for end in ends), radius, "post", capped=capped)
        found = intersect(cylinder, ray).distance
        for k in range(len(ray)):
            true = cylinder_distance(ray.origin[:, k], ray.direction[:, k], *ends, radius, capped)
            assert np.isfinite(found[k]) == (true is not None), f"{found[k]} against {true}"
            if true is not None:
                assert ulps(found[k], true) <= 10
                hits += 1
    assert hits > draws / 10


@pytest.mark.parametrize("draws", DRAWS)
@pytest.mark.parametrize("angle", [1e-8, 1e-4, 0.1])
def test_rays_nearly_along_the_axis(angle, draws):
    generator = np.random.default_rng(1)

    def aim(unit, base, height, radius):
        sideways = across(generator, np.repeat(unit, RAYS, axis=1))
        way = generator.choice([-1, 1], RAYS)
        direction = way * unit + angle * generator.uniform(0.5, 1, RAYS) * sideways
        direction /= np.sqrt((direction * direction).sum(axis=0))
        start = radius * generator.uniform(0, 1.1, RAYS) * across(generator, np.repeat(unit, RAYS, axis=1))
        return base + start + height * generator.uniform(-1, 2, RAYS) * unit, direction

    check(generator, draws, aim)


@pytest.mark.parametrize("draws", DRAWS)
def test_rays_from_anywhere(draws):
    generator = np.random.default_rng(2)

    def aim(unit, base, height, radius):
        direction = directions(generator, RAYS)
        sideways = across(generator, np.repeat(unit, RAYS, axis=1))
        target = (
            base + height * generator.uniform(0, 1, RAYS) * unit + radius * generator.uniform(0, 1, RAYS) * sideways
        )
        return target - (height + radius) * 10 ** generator.uniform(-1, 3, RAYS) * direction, direction

    check(generator, draws, aim)


def test_a_ray_along_the_axis_meets_the_caps_and_nothing_else():
    up = np.array([[0.0] * 3, [1.0] * 3, [0.0] * 3])
    at = np.array([[0.0, 1.0, 1.001], [-2.0] * 3, [0.0] * 3])
    closed, tube = (Cylinder((0, 0, 0), (0, 3, 0), 1, "post", capped=capped) for capped in (True, False))
    found = intersect(closed, rays(at, up))
    assert found.distance.tolist() == [2.0, 2.0, np.inf]
    assert found.primitive.tolist() == [1, 1, -1]
    assert np.all(intersect(tube, rays(at, up)).distance == np.inf)
    inside = intersect(closed, rays(at + np.array([[0.0], [3.0], [0.0]]), up))
    assert inside.distance.tolist() == [2.0, 2.0, np.inf]
    assert inside.primitive.tolist() == [2, 2, -1]


def test_no_ray_slips_through_the_seam_between_side_and_cap():
    generator = np.random.default_rng(3)
    cylinder = Cylinder((0.1, 0.2, 0.3), (0.4, 2.0, 0.1), 0.7, "post")
    axis = np.array([[0.3], [1.8], [-0.2]])
    sideways = across(generator, np.repeat(axis / np.linalg.norm(axis), 4000, axis=1))
    rim = np.array([[0.4], [2.0], [0.1]]) + 0.7 * sideways
    start = np.array([[0.25], [1.1], [0.2]]) + 0.2 * generator.normal(size=(3, 4000))
    direction = rim - start
    direction /= np.sqrt((direction * direction).sum(axis=0))
    assert np.all(np.isfinite(intersect(cylinder, rays(start, direction)).distance))


def test_normals_point_outwards_and_coordinates_run_round_and_down():
    post = Cylinder((0, 0, 0), (0, 4, 0), 1, "post")
    # Planes across y have u = −x and v = +z: u counts from +x, through −z (a quarter), −x (a half) and +z.
    towards = np.array([[1.0, 0.0, -1.0, 0.0], [0.0] * 4, [0.0, -1.0, 0.0, 1.0]])
    ray = rays(3 * towards + np.array([[0.0], [3.0], [0.0]]), -towards)
    found = surfaces([post], ray, nearest([post], ray))
    np.testing.assert_allclose(found.normal, towards, atol=1e-15)
    np.testing.assert_allclose(found.uv, [[0.0, 0.25, 0.5, 0.75], [0.25] * 4], atol=1e-15)
    np.testing.assert_allclose(found.extent, [[2 * np.pi] * 4, [4.0] * 4], rtol=1e-15)
    ends = rays(np.array([[0.5, 0.5], [9.0, -9.0], [0.25, 0.25]]), np.array([[0.0, 0.0], [-1.0, 1.0], [0.0, 0.0]]))
    found = surfaces([post], ends, nearest([post], ends))
    np.testing.assert_array_equal(found.normal, [[0, 0], [1, -1], [0, 0]])
    # The base's outward normal is −y, whose u axis is +x and v axis +z.
    np.testing.assert_allclose(found.uv, [[-0.5, 0.5], [0.25, 0.25]], rtol=1e-12)


def test_inside_and_clearance():
    generator = np.random.default_rng(4)
    post = Cylinder((0, 0, 0), (0, 2, 0), 1, "post")
    tube = Cylinder((0, 0, 0), (0, 2, 0), 1, "post", capped=False)
    turn, height, r = generator.uniform(0, 2 * np.pi, 60_000), generator.uniform(0, 2, 60_000), None
    r = np.sqrt(generator.uniform(size=60_000))
    side = np.stack([np.cos(turn), height, np.sin(turn)])
    caps = np.stack([r * np.cos(turn), 2.0 * (height > 1), r * np.sin(turn)])
    for _ in range(40):
        point = generator.uniform(-2, 3, 3)
        inside = 0 < point[1] < 2 and np.hypot(point[0], point[2]) < 1
        assert encloses(post, point) == inside
        assert not encloses(tube, point)
        for shape, points in ((post, np.concatenate([side, caps], axis=1)), (tube, side)):
            sampled = np.sqrt(((points - point[:, None]) ** 2).sum(axis=0)).min()
            # The samples stand about 0.02 apart.
            assert sampled - 0.04 <= clearance(shape, point) <= sampled * (1 + 1e-12)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"top": (0, 0, 0)}, "must differ"), ({"radius": 0}, "radius = 0"), ({"base": (0, 1e999, 0)}, "finite")],
)
def test_a_cylinder_that_cannot_be_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        Cylinder(**({"base": (0, 0, 0), "top": (0, 1, 0), "radius": 1, "material": "post"} | wrong))
