"""Boxes: no ray slips through a seam (G15), rays in their faces (G11), exact rationals, self-hits (G7), surfaces."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from geometry.both import intersect, nearest
from geometry.oracles import digits, directions, rational, rays, ulps

from symrt.geometry import Box, clearance, encloses, spawn, surfaces, translate

TURNS = [(0, 0, 0), (20, 30, 40), (45, 0, 0), (0, 0, 1e-7), (90, 180, 270)]


def corners(box):
    """The corners, and points on the twelve edges between them."""
    at = box.mesh.vertices
    first = np.arange(0, 24, 4)[:, None]
    start = (first + np.arange(4)).ravel()
    end = (first + np.array([1, 2, 3, 0])).ravel()
    shares = np.concatenate([[0.0, 0.5], np.random.default_rng(2).uniform(0, 1, 30)])
    return np.concatenate([at[:, start] + share * (at[:, end] - at[:, start]) for share in shares], axis=1)


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("size", [(2, 2, 2), (1e-6, 3, 1e4), (0.1, 0.7, 0.3)])
def test_no_ray_aimed_at_an_edge_or_a_corner_escapes(turn, size):
    box = Box((0.3, -0.2, 0.1), size, "white", rotate=turn)
    target = corners(box)
    middle = np.reshape(box.centre, (3, 1))
    for share in (0.0, 0.3, 0.97):
        # From the middle and from close to every corner, at every point of the edges.
        for corner in box.mesh.vertices[:, :8].T:
            start = np.broadcast_to(middle + share * (corner[:, None] - middle), target.shape)
            towards = target - start
            towards = towards / np.sqrt((towards * towards).sum(axis=0))
            assert np.isfinite(intersect(box, rays(start, towards)).distance).all()
            # From outside, through the same points.
            outside = rays(start + 3 * np.sum(size) * towards, -towards)
            assert np.isfinite(intersect(box, outside).distance).all()


def test_walls_that_meet_have_the_very_same_corners():
    for turn in TURNS:
        mesh = Box((1 / 3, 1e5, -7.7), (0.1, 0.7, 1e3), "white", rotate=turn).mesh
        assert np.unique(mesh.vertices, axis=1).shape[1] == 8
        assert mesh.is_closed


def test_no_ray_meets_the_wall_that_it_leaves():
    generator = np.random.default_rng(4)
    for turn in TURNS:
        box = Box((3e3, -2e2, 1e3), (2, 5, 3), "white", rotate=turn)
        start = np.reshape(box.centre, (3, 1)) + np.zeros((3, 500))
        onwards = rays(start, directions(generator, 500))
        for _ in range(5):
            hits = nearest([box], onwards)
            assert np.all(hits.shape == 0)
            found = surfaces([box], onwards, hits)
            assert found.error.max() < 1e-10
            towards = directions(generator, 500)
            towards = np.where(np.sum(towards * found.normal, axis=0) > 0, -towards, towards)
            onwards = spawn(found.point, -found.normal, found.error, towards)
            wall = intersect(box, onwards).primitive // 2
            assert not np.any(wall == hits.primitive // 2)


def slabs(low, high, origin, direction):
    """The first crossing of a ray with the walls of a box, in exact rationals; None where it misses."""
    enter, leave = None, None
    for a, b, o, d in zip(low, high, origin, direction, strict=True):
        if d == 0:
            if o < a or o > b:
                return None
            continue
        near, far = sorted([(a - o) / d, (b - o) / d])
        enter = near if enter is None or near > enter else enter
        leave = far if leave is None or far < leave else leave
    if enter > leave or leave <= 0:
        return None
    return enter if enter > 0 else leave


@pytest.mark.parametrize("draws", [1_000, pytest.param(100_000, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("where", ["inside", "outside", "far"])
def test_boxes_are_met_as_exact_rationals_say(where, draws):
    generator = np.random.default_rng(5)
    box = Box((0.5, -0.25, 1.0), (1.0, 2.0, 0.5), "white")
    low, high = rational([0.0, -1.25, 0.75]), rational([1.0, 0.75, 1.25])
    reach = {"inside": 0.2, "outside": 4.0, "far": 1e7}[where]
    start = np.array([[0.5], [-0.25], [1.0]]) + reach * directions(generator, draws)
    aim = np.array([[0.5], [-0.25], [1.0]]) + generator.uniform(-1.2, 1.2, (3, draws))
    if where == "outside":  # a third of them in the plane of a face, or parallel to it
        start[0, ::6] = aim[0, ::6] = 1.0
        start[1, 1::6] = aim[1, 1::6] = generator.choice([0.75, 0.75000001, 0.1], len(aim[1, 1::6]))
    towards = aim - start
    towards /= np.sqrt((towards * towards).sum(axis=0))
    found = intersect(box, rays(start, towards)).distance
    for i in range(draws):
        expected = slabs(low, high, rational(start[:, i]), rational(towards[:, i]))
        assert np.isfinite(found[i]) == (expected is not None), i
        if expected is not None:
            assert ulps(found[i], digits(expected)) <= 10


def test_every_face_has_its_material_its_normal_and_its_coordinates():
    names = ("left", "right", "bottom", "top", "back", "front")
    box = Box((0, 0, 0), (4, 2, 6), {name: name.upper() for name in names})
    outwards = np.array([[-1, 1, 0, 0, 0, 0], [0, 0, -1, 1, 0, 0], [0, 0, 0, 0, -1, 1]], dtype=float)
    # A ray inwards, at a point a quarter along +x, +y and +z from the middle.
    place = np.where(outwards == 0, [[1.0], [0.5], [1.5]], 10 * outwards)
    inwards = rays(place, -outwards)
    hits = nearest([box], inwards)
    found = surfaces([box], inwards, hits)
    assert [box.materials[i] for i in box.face_material[hits.primitive]] == [name.upper() for name in names]
    np.testing.assert_array_equal(found.normal, outwards)
    # By hand, as seen from outside: u to the right, v downwards.
    np.testing.assert_allclose(
        found.uv.T, [[0.75, 0.25], [0.25, 0.25], [0.75, 0.25], [0.75, 0.75], [0.25, 0.25], [0.75, 0.25]], rtol=1e-12
    )
    np.testing.assert_array_equal(found.extent.T, [[6, 2], [6, 2], [4, 6], [4, 6], [4, 2], [4, 2]])


def test_inside_and_clearance():
    box = Box((1, 2, 3), (2, 4, 6), "white", rotate=(0, 90, 0))
    assert encloses(box, np.array([3.9, 3.9, 3.9]))
    assert not encloses(box, np.array([1.0, 2.0, 4.1]))
    assert clearance(box, np.array([1.0, 2.0, 3.0])) == pytest.approx(1, rel=1e-12)
    assert clearance(box, np.array([1.0, 2.0, 8.0])) == pytest.approx(4, rel=1e-12)
    assert clearance(box, np.array([7.0, 8.0, 3.0])) == pytest.approx(5, rel=1e-12)


def test_a_moved_box_is_met_where_it_was_moved_to():
    box = Box((1e8, 0, 0), (2, 2, 2), "white", rotate=(0, 30, 0))
    moved = translate(box, np.array([-1e8, 0.0, 0.0]))
    assert moved == replace(box, centre=(0, 0, 0))
    seen = rays(np.zeros((3, 200)), directions(np.random.default_rng(6), 200))
    assert np.isfinite(intersect(moved, seen).distance).all()


def test_a_box_travels_without_its_triangles():
    box = Box((0, 0, 0), (2, 2, 2), "white")
    assert box.mesh is box.mesh
    assert "mesh" not in vars(pickle.loads(pickle.dumps(box)))
    assert pickle.loads(pickle.dumps(box)) == box


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"size": (1, 0, 2)}, r"size\[1\] = 0: it must be greater than 0"),
        ({"size": 4}, "size = 4: it must be three numbers"),
        ({"size": (1, 2)}, r"size = \(1, 2\): it must be three numbers"),
        ({"size": (1, "2", 3)}, "it must be made of numbers"),
        ({"centre": (True, 0, 0)}, "it must be made of numbers"),
        ({"centre": (0, float("nan"), 0)}, "centre .*: it must be finite"),
        ({"rotate": "abc"}, "rotate = 'abc': it must be three numbers"),
        ({"size": (1e60, 1e60, 1e60)}, "choose a larger unit of length"),
        ({"material": 3}, "material = 3: it must be a name"),
        ({"material": {"lft": "red", "others": "red"}}, "there is no face 'lft'; name left, right"),
        ({"material": {"left": "red"}}, "right, bottom, top, back, front must have a material, too"),
    ],
)
def test_a_box_that_cannot_be_says_why(change, line):
    given = {"centre": (0, 0, 0), "size": (1, 1, 1), "material": "white", "rotate": (0, 0, 0)} | change
    # Tests check the types of arguments before a record sees them; a user's Python does not.
    box = object.__new__(Box)
    for name, value in given.items():
        object.__setattr__(box, name, value)
    with pytest.raises(ValueError, match=line):
        box.__post_init__()


@pytest.mark.parametrize("draws", [40, pytest.param(2_000, marks=pytest.mark.exhaustive)])
def test_a_box_is_met_as_its_triangles_are(draws):
    # Faces are chosen by plain arithmetic first: thin boxes, far away, and rays almost along a face must not be lost.
    generator = np.random.default_rng(7)
    for _ in range(draws):
        size = 10 ** generator.uniform(-4, 4, 3)
        turn = generator.choice([0.0, 90.0, 45.0, float(generator.uniform(0, 360))], 3)
        box = Box(tuple(generator.normal(size=3) * size.max()), tuple(size.tolist()), "white", rotate=tuple(turn))
        # Aimed at corners, edges, faces and beside them, from inside, near and far.
        share = generator.choice([-1.0, 1.0, 1 + 1e-12, 0.0, float(generator.uniform(-1.2, 1.2))], (3, 200))
        target = box.turn @ (share * size[:, None] / 2) + np.reshape(box.centre, (3, 1))
        towards = directions(generator, 200)
        along, grazing = generator.integers(0, 3, 200), generator.uniform(size=200) < 0.5
        towards[along[grazing], np.flatnonzero(grazing)] *= 10 ** generator.uniform(-20, -6, np.sum(grazing))
        towards = box.turn @ towards
        towards /= np.sqrt((towards * towards).sum(axis=0))
        start = target - size.max() * 10 ** generator.uniform(-6, 4, 200) * towards
        seen = rays(start, towards)
        found, true = intersect(box, seen), intersect(box.mesh, seen)
        np.testing.assert_array_equal(found.distance, true.distance)
        np.testing.assert_array_equal(found.primitive, true.primitive)
