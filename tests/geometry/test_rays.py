"""Laws of all shapes: fresh rays never meet what they leave (G7), batches, workers, nan (G14), far scenes (G12)."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from geometry.both import intersect, nearest, occluded
from geometry.oracles import across, directions, inner, rational, rays
from geometry.shapes import gallery, icosphere, random_mesh

from symrt import fast
from symrt.geometry import (
    Cylinder,
    Disk,
    Plane,
    Rays,
    Rectangle,
    Sphere,
    TriangleMesh,
    meeting,
    spawn,
    surfaces,
    translate,
)
from symrt.geometry.meeting import leaving_of
from symrt.geometry.rays import Hits, side_of

DRAWS = [(40, 50), pytest.param((1000, 1000), marks=pytest.mark.exhaustive)]


def sized(kind, generator):
    """A shape with coordinates of ±10^U(−8, 8), its size, and whether leaving it on the outer side is for good."""
    size = float(10 ** generator.uniform(-8, 8))
    # A surface is only there if floats near it are finer than it is.
    away = min(10 ** generator.uniform(-8, 8), 1e9 * size)
    centre = away * generator.normal(size=3)
    axis = directions(generator, 1)[:, 0]
    other = np.cross(axis, directions(generator, 1)[:, 0])
    other /= np.linalg.norm(other)
    at, along = tuple(centre.tolist()), tuple((axis * size).tolist())
    shape = {
        "sphere": lambda: Sphere(at, size, "a"),
        "plane": lambda: Plane(at, along, "a"),
        "disk": lambda: Disk(at, along, size, "a"),
        "rectangle": lambda: Rectangle(at, along, tuple((other * size).tolist()), "a"),
        "cylinder": lambda: Cylinder(at, tuple((centre + axis * size).tolist()), 0.4 * size, "a"),
        "mesh": lambda: icosphere(1, size, centre),
        "embree mesh": lambda: icosphere(2, size, centre),
    }[kind]()
    return shape, size, centre


def exact_sign(a, b):
    """Sign of each inner product, in rational arithmetic where floats may not know it."""
    sign = np.sign((a * b).sum(axis=0))
    for k in np.flatnonzero(np.abs((a * b).sum(axis=0)) < 1e-14):
        sign[k] = float(inner(rational(a[:, k]), rational(b[:, k])).p > 0) * 2 - 1
    return sign


@pytest.mark.parametrize("draws", DRAWS)
@pytest.mark.parametrize("kind", ["sphere", "plane", "disk", "rectangle", "cylinder", "mesh", "embree mesh"])
def test_rays_that_leave_a_surface_never_meet_it_again(kind, draws):
    generator = np.random.default_rng(1)
    shapes, count = draws
    left = 0
    for _ in range(shapes):
        shape, size, centre = sized(kind, generator)
        towards = directions(generator, count)
        start = centre[:, None] + size * (0.3 * generator.normal(size=(3, count)) - 4 * towards)
        seen = rays(start, towards)
        hits = nearest([shape], seen)
        met = np.flatnonzero(hits.shape == 0)
        found = surfaces([shape], seen[met], nearest([shape], seen[met]))
        if kind != "plane":
            assert np.all(2 * found.error <= 1e-3 * size)
        # Leaving a closed shape means outwards, a flat one either way; a tenth of the rays graze the surface.
        out = directions(generator, met.size)
        side = (out * found.normal).sum(axis=0)
        grazing = generator.uniform(size=met.size) < 0.1
        out = out - np.where(grazing, side * (1 - 10 ** generator.uniform(-14, -1, met.size)), 0.0) * found.normal
        out /= np.sqrt((out * out).sum(axis=0))
        if kind not in {"plane", "disk", "rectangle"}:
            out = np.where(exact_sign(out, found.normal) < 0, -out, out)
        fresh = spawn(found.point, found.normal, found.error, out)
        again = intersect(shape, fresh).distance
        assert np.all(again == np.inf), f"{np.sum(again < np.inf)} of {met.size} meet it again"
        assert not occluded([shape], fresh, np.full(met.size, np.inf)).any()
        left += met.size
    assert left > shapes * count / 10


def scaled(shape, scale):
    """A shape made larger about the origin."""
    if isinstance(shape, TriangleMesh):
        return replace(shape, vertices=scale * shape.vertices)
    sizes = {"centre", "point", "radius", "edge_u", "edge_v", "base", "top", "size"}
    names = sizes & {field.name for field in fields(shape)}
    larger = {name: np.multiply(getattr(shape, name), scale).tolist() for name in names}
    return replace(shape, **{name: tuple(v) if isinstance(v, list) else v for name, v in larger.items()})


def fresh_rays(shapes, generator, count, scale):
    """Rays from surfaces to everywhere, a quarter of them grazing, and the shapes that they leave for good."""
    towards = directions(generator, count)
    middle = np.array([[3.0], [-2.0], [5.0]]) + generator.uniform(-3, 3, (3, count))
    seen = rays(scale * (middle - 3 * towards), towards)
    hits = nearest(shapes, seen)
    met = np.flatnonzero(hits.shape >= 0)
    hits = Hits(hits.distance[met], hits.shape[met], hits.primitive[met])
    found = surfaces(shapes, seen[met], hits)
    out = directions(generator, met.size)
    side = (out * found.normal).sum(axis=0)
    grazing = generator.uniform(size=met.size) < 0.25
    out = out - np.where(grazing, side * (1 - 10 ** generator.uniform(-14, -1, met.size)), 0.0) * found.normal
    out /= np.sqrt((out * out).sum(axis=0))
    return spawn(found.point, found.normal, found.error, out, leaving_of(shapes, hits))


@pytest.mark.parametrize("count", [3_000, pytest.param(300_000, marks=pytest.mark.exhaustive)])
@pytest.mark.parametrize("scale", [1e-5, 1.0, 1e5])
def test_rays_that_leave_a_shape_for_good_need_not_be_asked_about_it(scale, count):
    by = np.array([3.0, -2.0, 5.0])
    shapes = [scaled(translate(shape, by), scale) for shape in gallery()]
    fresh = fresh_rays(shapes, np.random.default_rng(8), count, scale)
    left = np.unique(fresh.left)
    # All but the open tube and the meshes are left for good by some, on one side or on both.
    assert {-1, 0, 1, 2, 3, 4, 6} == set(left.tolist())
    asked = replace(fresh, left=None)
    one, other = nearest(shapes, fresh), nearest(shapes, asked)
    for field in fields(one):
        np.testing.assert_array_equal(getattr(one, field.name), getattr(other, field.name))
    limit = scale * np.random.default_rng(9).uniform(0, 6, len(fresh))
    np.testing.assert_array_equal(occluded(shapes, fresh, limit), occluded(shapes, asked, limit))
    for index in left[left >= 0]:
        own = intersect(shapes[index], asked[fresh.left == index])
        assert np.all(own.distance == np.inf), index


def test_numpy_is_not_asked_about_shapes_that_all_rays_leave(monkeypatch):
    floor = Plane((0, 0, 0), (0, 1, 0), "floor")
    up = replace(rays(np.full((3, 5), 1e-9), np.repeat([[0.0], [1.0], [0.0]], 5, axis=1)), left=np.zeros(5, np.int32))
    asked = []
    monkeypatch.setattr(meeting, "intersect", lambda *_: asked.append(1))
    with fast.use(False):
        assert not meeting.occluded([floor], up, np.full(5, np.inf)).any()
    assert asked == []


@pytest.mark.parametrize("count", [2_000, pytest.param(200_000, marks=pytest.mark.exhaustive)])
def test_the_side_that_a_direction_goes_to_is_that_of_exact_arithmetic(count):
    generator = np.random.default_rng(10)
    normal = directions(generator, count)
    towards = across(generator, normal) + generator.choice([-1, 0, 1], count) * 10 ** generator.uniform(-18, -13, count)
    towards = towards / np.sqrt((towards * towards).sum(axis=0))
    sides = side_of(normal, towards)
    for k in range(count):
        true = inner(rational(normal[:, k]), rational(towards[:, k]))
        assert sides[k] == (true > 0) - (true < 0)


def test_a_ray_that_enters_a_sphere_crosses_it():
    generator = np.random.default_rng(2)
    ball = Sphere((1, 2, 3), 0.5, "glass")
    towards = directions(generator, 500)
    seen = rays(np.array([[1.0], [2.0], [3.0]]) - 3 * towards, towards)
    found = surfaces([ball], seen, nearest([ball], seen))
    inside = spawn(found.point, found.normal, found.error, towards)
    np.testing.assert_allclose(intersect(ball, inside).distance, 1.0, rtol=1e-12)


def everything(shapes, seen):
    """All that can be asked about rays, as one list of arrays."""
    hits = nearest(shapes, seen)
    found = surfaces(shapes, seen, hits)
    hidden = occluded(shapes, seen, np.full(len(seen), 5.0))
    return [getattr(hits, f.name) for f in fields(hits)] + [getattr(found, f.name) for f in fields(found)] + [hidden]


def scattered(count):
    generator = np.random.default_rng(3)
    towards = directions(generator, count)
    return rays(generator.uniform(-4, 4, (3, count)) - 3 * towards, towards)


def test_a_batch_may_be_cut_anywhere():
    shapes, seen = gallery(), scattered(1201)
    whole = everything(shapes, seen)
    assert set(np.unique(whole[1])) == {-1, *range(len(shapes))}
    cuts = [0, 1, 2, 5, 64, 65, 600, 1201]
    pieces = [everything(shapes, seen[a:b]) for a, b in pairwise(cuts)]
    for k, array in enumerate(whole):
        np.testing.assert_array_equal(np.concatenate([piece[k] for piece in pieces], axis=-1), array)


@pytest.mark.parametrize("workers", [1, 2, 8])
def test_any_number_of_workers_gives_the_same_bits(workers):
    # Fresh shapes, so that the workers race to build what the meshes keep.
    shapes, seen = gallery(), scattered(800)
    with ThreadPoolExecutor(workers) as pool:
        pieces = list(pool.map(lambda start: everything(shapes, seen[start : start + 50]), range(0, 800, 50)))
    for k, array in enumerate(everything(gallery(), seen)):
        np.testing.assert_array_equal(np.concatenate([piece[k] for piece in pieces], axis=-1), array)


def test_of_two_shapes_at_one_distance_the_first_is_seen():
    disc = Disk((0, 0, 0), (0, 1, 0), 1, "a")
    down = rays(np.array([[0.0], [1.0], [0.0]]), np.array([[0.0], [-1.0], [0.0]]))
    assert nearest([replace(disc, material="b"), disc], down).shape[0] == 0


def test_shadows_end_at_the_light():
    ball = Sphere((0, 0, -5), 1, "a")
    ahead = rays(np.zeros((3, 3)), np.repeat([[0.0], [0.0], [-1.0]], 3, axis=1))
    # The ball is met at 4: a light there is touched, not hidden.
    assert occluded([ball], ahead, np.array([3.0, 4.0, 4.5])).tolist() == [False, False, True]


def test_shadows_agree_with_the_nearest_hits():
    shapes, seen = gallery(), scattered(2000)
    limit = np.random.default_rng(4).uniform(0, 9, 2000)
    np.testing.assert_array_equal(occluded(shapes, seen, limit), nearest(shapes, seen).distance < limit)


@pytest.mark.parametrize("shift", [1e6, 1e8])
def test_a_scene_far_away_is_the_same_scene_seen_from_its_camera(shift):
    generator = np.random.default_rng(5)
    towards = directions(generator, 3000)
    seen = rays(np.zeros((3, 3000)), towards)
    by = shift * np.array([1.0, -2.0, 0.5])
    here = [translate(shape, np.array([0.0, 0.0, -6.0])) for shape in gallery()]
    back = [translate(translate(shape, by), -by) for shape in here]
    first, second = nearest(here, seen), nearest(back, seen)
    # Moved there, coordinates are rounded to 2⁻⁵³ shift; a ray that near to an outline may go either way.
    same = first.shape == second.shape
    assert np.sum(~same) <= 3
    found = surfaces(here, seen, first)
    facing = same & (np.abs((found.normal * towards).sum(axis=0)) > 0.3)
    assert facing.sum() > 500
    np.testing.assert_allclose(second.distance[facing], first.distance[facing], rtol=1e-7)


@pytest.mark.parametrize("shift", [1e6, 1e8])
def test_a_scene_that_can_be_moved_without_rounding_keeps_every_bit(shift):
    generator = np.random.default_rng(6)
    # Coordinates are multiples of 2⁻¹⁶ and the shift of 2⁻¹⁶, so that sums of both are exact.
    grid = generator.integers(-200_000, 200_000, (3, 40)) / 2.0**16
    here = [Sphere(tuple(p.tolist()), 0.5, "a") for p in grid.T] + [
        Cylinder(tuple(p.tolist()), tuple((p + 1).tolist()), 0.25, "a") for p in grid.T
    ]
    by = shift * np.array([1.0, -2.0, 0.5])
    seen = rays(np.zeros((3, 2000)), directions(generator, 2000))
    back = [translate(translate(shape, by), -by) for shape in here]
    np.testing.assert_array_equal(nearest(back, seen).distance, nearest(here, seen).distance)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_rays_must_be_finite_and_of_unit_length(wrong):
    up = np.array([[0.0], [1.0], [0.0]])
    with pytest.raises(ValueError, match="ray 0 starts at"):
        Rays(np.where(up == 1, wrong, 0.0), up)
    with pytest.raises(ValueError, match="use normalise"):
        Rays(up, np.where(up == 1, wrong, 0.0))
    with pytest.raises(ValueError, match="unit length"):
        Rays(up, 1.001 * up)


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf, 1e308])
def test_kernels_miss_with_rays_that_are_no_rays(wrong):
    good = scattered(12)
    for part in ("origin", "direction"):
        broken = good[:]
        values = getattr(good, part).copy()
        values[np.arange(12) % 3, np.arange(12)] = wrong
        values[:, :3] = wrong
        object.__setattr__(broken, part, values)
        for shape in gallery():
            found = intersect(shape, broken)
            assert not np.any(np.isnan(found.distance))
            assert np.array_equal(found.primitive == -1, found.distance == np.inf)
            if not np.isfinite(wrong):
                assert np.all(found.distance == np.inf)


@pytest.mark.parametrize("make", [lambda x: Sphere((x, 0, 0), 1, "a"), lambda x: Disk((0, 0, 0), (0, 1, 0), x, "a")])
def test_sizes_whose_powers_overflow_or_underflow_are_refused(make):
    for size in (1e61, 1e308):
        with pytest.raises(ValueError, match="choose a larger unit of length"):
            make(size)
    with pytest.raises(ValueError, match="choose a smaller unit of length"):
        Cylinder((0, 0, 0), (0, 1, 0), 1e-61, "a")
    with pytest.raises(ValueError, match="must not be zero"):
        Plane((0, 0, 0), (0, 1e-61, 0), "a")


def test_a_plane_that_is_grazed_is_met_within_a_distance_or_not_at_all():
    slope = 10.0 ** -np.arange(15, 320, 5)
    grazing = rays(np.array([[0.0], [1.0], [0.0]]) + 0 * slope, np.stack([0 * slope + 1, -slope, 0 * slope]))
    # The rounded unit normal of an oblique plane knows slopes down to 2⁻⁵¹, one along an axis all of them.
    for normal, least in (((0, 1, 0), 1e-62), ((0, 3, 1e-30), 2.0**-51)):
        floor = Plane((0, 0, 0), normal, "a")
        hits = nearest([floor], grazing)
        found = surfaces([floor], grazing, hits)
        assert np.all(np.isfinite(found.point))
        assert np.array_equal(hits.shape == 0, slope > least)


def test_minus_zero_is_zero():
    ahead = rays(np.zeros((3, 1)), np.array([[0.0], [0.0], [-1.0]]))
    same = rays(np.full((3, 1), -0.0), np.array([[-0.0], [-0.0], [-1.0]]))
    for shape in gallery():
        moved = translate(shape, np.array([0.0, 0.0, -8.0]))
        assert intersect(moved, ahead).distance == intersect(moved, same).distance


def test_no_rays_and_no_shapes_are_fine():
    nothing = scattered(0)
    assert all(array.shape[-1] == 0 for array in everything(gallery(), nothing))
    assert np.all(nearest([], scattered(3)).shape == -1)
    assert not occluded([], scattered(3), np.full(3, np.inf)).any()


def test_what_is_no_shape_is_refused():
    with pytest.raises(TypeError, match="str is not a shape"):
        intersect("sphere", scattered(1))


def test_a_mesh_travels_to_another_process():
    import pickle  # noqa: PLC0415 (what a process pool does)

    mesh, seen = random_mesh(200, 7), scattered(100)
    first = intersect(mesh, seen)
    again = intersect(pickle.loads(pickle.dumps(mesh)), seen)
    np.testing.assert_array_equal(first.distance, again.distance)
