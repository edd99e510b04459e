"""Kernels to the bit as NumPy's code where numbers are extreme; the other tests of geometry ask both, too (`both`)."""

import numpy as np
import pytest
from geometry.both import intersect, nearest, occluded, same
from geometry.oracles import across, directions
from geometry.shapes import gallery, icosphere, random_mesh

from symrt import fast
from symrt.geometry import Box, Cylinder, Disk, Plane, Rays, Rectangle, Sphere, TriangleMesh
from symrt.geometry.directions import unit_vectors
from symrt.geometry.meeting import leaving_of, surfaces
from symrt.geometry.rays import spawn

COUNTS = [600, pytest.param(60_000, marks=pytest.mark.exhaustive)]
KINDS = ["sphere", "cylinder", "tube", "plane", "floor", "disk", "rectangle", "box", "mesh", "needles"]


def made(kind, generator, size):
    """A shape of some size near the origin, turned anyhow."""
    axis, other = directions(generator, 2).T
    other = np.cross(axis, other) / np.linalg.norm(np.cross(axis, other))
    at = tuple((size * generator.normal(size=3)).tolist())
    along, aside = tuple((size * axis).tolist()), tuple((size * other).tolist())
    turn = tuple(generator.uniform(0, 360, 3).tolist())
    top = tuple((np.array(at) + size * axis).tolist())
    needles = np.stack([np.zeros((3, 8)), np.ones((3, 8)), generator.choice([0.5, 0.5 + 2.0**-52], (3, 8))])
    return {
        "sphere": lambda: Sphere(at, size, "a"),
        "cylinder": lambda: Cylinder(at, top, 0.4 * size, "a"),
        "tube": lambda: Cylinder(at, top, 0.4 * size, "a", capped=False),
        "plane": lambda: Plane(at, along, "a"),
        "floor": lambda: Plane(at, (0, size, 0), "a"),
        "disk": lambda: Disk(at, along, size, "a"),
        "rectangle": lambda: Rectangle(at, along, aside, "a"),
        "box": lambda: Box(at, (size, 2 * size, 0.5 * size), "a", rotate=turn),
        "mesh": lambda: icosphere(2, size, at),
        "needles": lambda: TriangleMesh(
            size * needles.transpose(1, 0, 2).reshape(3, -1), np.arange(24).reshape(3, 8), ("a",)
        ),
    }[kind]()


def aimed(generator, size, count):
    """Rays from anywhere at a shape: tangent, grazing, along axes, with components that vanish or nearly."""
    towards = directions(generator, count)
    tiny = generator.choice([0.0, -0.0, 5e-324, -1e-310, 1e-300, 1e-17], (3, count))
    towards = np.where(generator.uniform(size=(3, count)) < 0.2, tiny, towards)
    towards[:, ~(np.abs(towards) > 1e-3).any(axis=0)] = np.array([[0.0], [-1.0], [0.0]])
    towards /= np.sqrt((towards * towards).sum(axis=0))
    impact = generator.choice([0.0, 0.5, 1.0, 3.0], count) * (1 + 10 ** generator.uniform(-17, -1, count))
    away = generator.choice([-1.0, 1.0], count) * 10 ** generator.uniform(-17, 17, count)
    target = size * (generator.normal(size=(3, 1)) + impact * across(generator, towards))
    return Rays(target - size * away * towards, towards)


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("size", [1e-40, 1.0, 1e40])
@pytest.mark.parametrize("kind", KINDS)
def test_a_kernel_gives_the_bits_of_numpy_s_code_at_any_size(kind, size, count):
    generator = np.random.default_rng(KINDS.index(kind))
    met = 0
    for _ in range(4):
        shape, seen = made(kind, generator, size), aimed(generator, size, count // 4)
        for low in (0.0, size):
            found = intersect(shape, seen, low)
            assert np.all(found.distance > low)
            met += np.count_nonzero(found.distance < np.inf)
        occluded([shape], seen, generator.choice([0.0, size, np.inf, 1e-300], len(seen)))
    assert met > 0 or kind == "needles"


def test_rays_in_memory_of_any_kind_are_met_alike():
    generator = np.random.default_rng(1)
    seen = aimed(generator, 1.0, 500)
    still = Rays(np.asfortranarray(seen.origin), np.repeat(seen.direction, 2, axis=1)[:, ::2])
    still.origin.flags.writeable = False
    for shape in [*gallery(), random_mesh(70, 3)]:
        one, other = intersect(shape, seen), intersect(shape, still)
        np.testing.assert_array_equal(one.distance, other.distance)
        np.testing.assert_array_equal(one.primitive, other.primitive)


def both(action):
    """The results of NumPy and of the kernels."""
    pytest.importorskip("numba", reason="numba is not installed")
    found = []
    for kernels in (False, True):
        with fast.use(kernels):
            found.append(action())
    return found


@pytest.mark.parametrize("size", [1e-40, 1.0, 1e40])
@pytest.mark.parametrize("kind", KINDS)
def test_surfaces_and_the_rays_that_start_there_are_numpy_s_to_the_bit(kind, size):
    generator = np.random.default_rng(KINDS.index(kind))
    shape, seen = made(kind, generator, size), aimed(generator, size, 800)
    hits = nearest([shape], seen)
    one, other = both(lambda: surfaces([shape], seen, hits, textured=()))
    same(one, other, "point", "normal", "shading_normal", "uv", "extent", "error")
    whole = surfaces([shape], seen, hits)
    same(whole, other, "point", "normal", "shading_normal", "extent", "error")
    assert not other.uv.any()

    # Rays from there: half of them along the surface, up to rounding.
    met = np.flatnonzero(hits.shape == 0)
    place = one.point[:, met], one.normal[:, met], one.error[met]
    way = directions(generator, met.size)
    way[:, ::2] = across(generator, place[1])[:, ::2]
    one, other = both(lambda: spawn(*place, way, leaving_of([shape], hits)[:, met]))
    same(one, other, "origin", "direction", "left")


def test_unit_vectors_are_numpy_s_to_the_bit_however_long_they_are():
    generator = np.random.default_rng(3)
    vectors = directions(generator, 4000)
    vectors = np.where(
        generator.uniform(size=(3, 4000)) < 0.2, generator.choice([0.0, -0.0, 1e-17], (3, 4000)), vectors
    )
    vectors[:, ~(np.abs(vectors) > 1e-3).any(axis=0)] = 1.0
    for exponent in (-1060, -900, -401, -399, 0, 399, 401, 1000):
        one, other = both(lambda e=exponent: unit_vectors(np.ldexp(vectors, e)))
        np.testing.assert_array_equal(one, other)
    for exponents in (generator.integers(-30, 30, (3, 4000)), generator.integers(-500, 500, (3, 4000))):
        one, other = both(lambda e=exponents: unit_vectors(np.ldexp(vectors, e)))
        np.testing.assert_array_equal(one, other)
    for bad in (0.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="a direction must be finite and not zero"):
            both(lambda value=bad: unit_vectors(np.array([[1.0, value], [0.0, value], [0.0, value]])))


@pytest.mark.parametrize(
    ("where", "value"), [("origin", 1e61), ("origin", np.nan), ("direction", 0.9), ("direction", np.nan)]
)
def test_rays_that_are_none_are_refused_alike(where, value):
    pytest.importorskip("numba", reason="numba is not installed")
    given = {"origin": np.zeros((3, 5)), "direction": np.repeat([[0.0], [1.0], [0.0]], 5, axis=1)}
    given[where][1, 3] = value
    said = []
    for kernels in (False, True):
        with fast.use(kernels), pytest.raises(ValueError, match=r"^ray 3 starts at") as error:
            Rays(**given)
        said.append(str(error.value))
    assert said[0] == said[1]
