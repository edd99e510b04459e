"""Kernels to the bit as NumPy's code where numbers are extreme; the other tests of geometry ask both, too (`both`)."""

import numpy as np
import pytest
from geometry.both import intersect, occluded
from geometry.oracles import across, directions
from geometry.shapes import gallery, icosphere, random_mesh

from symrt.geometry import Box, Cylinder, Disk, Plane, Rays, Rectangle, Sphere, TriangleMesh

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
