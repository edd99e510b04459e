"""Shapes passed over are those that no ray meets: what is found is the same, bit for bit, as asking every shape."""

import numpy as np
import pytest
from geometry import both
from geometry.both import COMPILED

from symrt import fast
from symrt.arrays import normalise
from symrt.geometry import (
    Box,
    Cylinder,
    Disk,
    Plane,
    Rays,
    Rectangle,
    Sphere,
    TriangleMesh,
    bvh,
    intersect,
    surface,
    surfaces,
)
from symrt.geometry.culling import Shapes, bounds


def shape(kind, at, turned, size):
    """A shape of one of six kinds, at a place and turned."""
    u, v, w = (tuple((size * axis).tolist()) for axis in turned)
    if kind == 0:
        return Sphere(at, size, "red")
    if kind == 1:
        return Cylinder(at, tuple(np.add(at, w).tolist()), size / 2, "red", capped=turned[0, 0] > 0)
    if kind == 2:
        return Rectangle(at, u, v, "red")
    if kind == 3:
        return Disk(at, w, size, "red")
    if kind == 4:
        return Box(at, (size, size / 2, size / 3), "red", rotate=tuple((90 * turned[0]).tolist()))
    return TriangleMesh(np.array([u, v, w]).T + np.array(at)[:, None], np.array([[0], [1], [2]]), ("red",))


def some_shapes(random, count, size=1.0, spread=6.0):
    """Shapes of every kind with an end, turned any way."""
    places = [tuple(random.uniform(-spread, spread, 3).tolist()) for _ in range(count)]
    turns = [np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(count)]
    return [shape(k % 6, places[k], turns[k], size) for k in range(count)]


def beam(random, kind, count=400):
    """Rays of a camera, of a light, of a mirror, and any."""
    origin = np.zeros((3, count)) if kind != "any" else random.uniform(-8, 8, (3, count))
    if kind == "camera":
        away = np.stack([random.uniform(-0.3, 0.1, count), random.uniform(0.1, 0.15, count), np.full(count, -1.0)])
        return Rays(origin + np.array([[0.5], [-1.0], [9.0]]), normalise(away))
    if kind == "lamp":
        origin = np.stack([random.uniform(-3, 3, count), np.full(count, -2.0), random.uniform(-1, 1, count)])
        return Rays(origin, normalise(np.array([[1.0], [9.0], [2.0]]) - origin))
    if kind == "parallel":
        origin = random.uniform(-3, 3, (3, count))
        return Rays(origin, np.broadcast_to([[0.0], [1.0], [0.0]], (3, count)).copy())
    return Rays(origin, normalise(random.normal(size=(3, count))))


@pytest.mark.parametrize("kind", ["camera", "lamp", "parallel", "any"])
@pytest.mark.parametrize("count", [6, 60])
@pytest.mark.parametrize("seed", range(4))
def test_no_shape_that_a_ray_meets_is_passed_over(kind, count, seed):
    random = np.random.default_rng(seed)
    shapes = Shapes((*some_shapes(random, count, spread=3.0), Plane((0, -3, 0), (0, 1, 0), "red")))
    rays, limit = beam(random, kind), random.uniform(0, 12, 400)
    asked = dict(shapes.asked(rays, limit))
    assert list(asked) == sorted(asked)
    for index, shape in enumerate(shapes):
        met = np.flatnonzero(intersect(shape, rays).distance < limit)
        if index in asked:
            chosen = asked[index]
            assert chosen is None or np.isin(met, chosen).all()
        else:
            assert met.size == 0


@pytest.mark.parametrize("seed", range(3))
def test_a_box_holds_its_shape(seed):
    # Points of each surface, where random rays towards the middle meet it.
    random = np.random.default_rng(seed)
    for shape in some_shapes(random, 12):
        low, high = bounds(shape)
        middle = ((low + high) / 2)[:, None]
        way = normalise(random.normal(size=(3, 300)))
        rays = Rays(middle + 5 * way, -way)
        t = intersect(shape, rays).distance
        points = (rays.origin + t * rays.direction)[:, np.isfinite(t)]
        assert np.all((low[:, None] - 1e-12 <= points) & (points <= high[:, None] + 1e-12))
        # No box is more than twice as long as its shape.
        assert points.size == 0 or np.all(high - low <= 2.5)


def test_rays_that_graze_and_touch_are_asked_about():
    # A ray through the very corner of a box, along its faces, and along the edge of a tangent.
    balls = [Sphere((float(k), 0.0, 0.0), 0.5, "red") for k in range(40)]
    up = np.array([[0.0], [0.0], [1.0]])
    rays = Rays(np.array([[k + 0.5, 0.0, -9.0] for k in range(40)]).T, np.broadcast_to(up, (3, 40)).copy())
    alone = np.array([intersect(ball, rays).distance for ball in balls])
    asked = dict(Shapes(tuple(balls)).asked(rays, np.inf))
    for index in range(40):
        met = np.flatnonzero(np.isfinite(alone[index]))
        assert met.size
        assert np.isin(met, asked[index]).all()


def test_a_camera_that_looks_elsewhere_asks_about_little():
    random = np.random.default_rng(1)
    few = Shapes((Sphere((0, 0, -5), 1, "red"), Sphere((0, 0, 5), 1, "red"), Plane((0, -1.5, 0), (0, 1, 0), "red")))
    ahead = beam(random, "camera")  # slightly upwards
    assert [index for index, _ in few.asked(ahead, np.inf)] == [0, 1]
    assert [index for index, _ in few.asked(ahead, 2.0)] == []
    many = Shapes(tuple(some_shapes(random, 600, size=0.2)))
    pairs = sum(len(chosen) for _, chosen in many.asked(ahead, np.inf))
    assert pairs < 600 * 400 / 50


def test_what_has_no_end_and_no_rays_are_answered():
    class Cloud:
        """A shape of somebody's own."""

    shapes = Shapes((Plane((0, 0, 0), (0, 1, 1), "red"), Cloud(), *some_shapes(np.random.default_rng(0), 30)))
    rays = Rays(np.array([[0.0], [900.0], [0.0]]), np.array([[0.0], [1.0], [0.0]]))
    assert list(shapes.asked(rays, np.inf)) == [(0, None), (1, None)]
    assert list(shapes.asked(rays[:0], np.inf)) == []
    assert list(Shapes(()).asked(rays, np.inf)) == []


@pytest.mark.skipif(not COMPILED, reason="numba is not installed")
@pytest.mark.parametrize("count", [1, 5, 70, 600])
@pytest.mark.parametrize("dear", [False, True])
def test_the_compiled_walk_names_the_same_pairs(count, dear):
    random = np.random.default_rng(count)
    low = random.uniform(-4, 4, (3, count))
    tree = bvh.build(low, low + random.exponential(3.0, (3, count)), dear=dear)
    for kind in ("camera", "parallel", "any"):
        rays, last = beam(random, kind), random.choice([2.0, 7.0, np.inf], 400)
        pairs = []
        for compiled in (False, True):
            with fast.use(compiled):
                ray, number = bvh.candidates(tree, rays, np.zeros(400), last)
            pairs.append(sorted(zip(ray.tolist(), number.tolist(), strict=True)))
        assert pairs[0] == pairs[1]
        assert kind != "any" or count < 600 or len(pairs[0]) > 800  # more than there is room for at first


@pytest.mark.parametrize("count", [6, 60])
@pytest.mark.parametrize("kind", ["camera", "lamp", "any"])
def test_what_is_met_first_and_what_hides_are_those_of_every_shape_by_itself(kind, count):
    random = np.random.default_rng(7)
    shapes = [*some_shapes(random, count, spread=3.0), Plane((0, -3, 0), (0, 1, 0), "red")]
    rays, limit = beam(random, kind), random.uniform(0, 12, 400)
    alone = np.array([intersect(shape, rays).distance for shape in shapes])
    hits = both.nearest(shapes, rays)
    np.testing.assert_array_equal(hits.distance, alone.min(axis=0))
    np.testing.assert_array_equal(hits.shape, np.where(np.isfinite(hits.distance), alone.argmin(axis=0), -1))
    np.testing.assert_array_equal(both.occluded(shapes, rays, limit), (alone < limit).any(axis=0))
    found = surfaces(shapes, rays, hits)
    for index in np.unique(hits.shape[hits.shape >= 0]).tolist():
        own = np.flatnonzero(hits.shape == index)
        one = surface(shapes[index], rays[own], hits.distance[own], hits.primitive[own])
        np.testing.assert_array_equal(found.point[:, own], one.point)
        np.testing.assert_array_equal(found.normal[:, own], one.normal)
