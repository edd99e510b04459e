"""What many shapes cost, as a ratio to few: a ray is asked about those it may meet."""

import numpy as np
import pytest
from benchmarks.pairs import ratio

import symrt as rt
from symrt import fast

pytestmark = pytest.mark.benchmark


def spheres(count):
    """As many spheres under two lamps, as large together as any other number of them."""
    random = np.random.default_rng(0)
    places, radius = random.uniform((-3, -3, -1), (3, 3, 1), (count, 3)), 0.55 * (20 / count) ** 0.5
    return rt.Scene(
        camera=rt.Camera(position=(0, 0, 9), target=(0, 0, 0), field_of_view=40, width=512, height=512),
        shapes=[rt.Sphere(tuple(place.tolist()), radius, "red") for place in places],
        materials=[rt.Material("red", model="phong", exponent=40)],
        lights=[rt.PointLight("warm", position=(4, 6, 8)), rt.PointLight("cold", position=(-4, 3, 8))],
    )


def test_a_hundred_times_as_many_spheres_cost_a_logarithm(report, benchmark):
    few, many = spheres(20), spheres(2000)
    with fast.use(True if fast.available() else None):
        rt.render(few, progress=False)
        found, one, other = ratio(
            lambda: rt.render(many, progress=False, workers=1),
            lambda: rt.render(few, progress=False, workers=1),
            pairs=5,
        )
    benchmark.pedantic(lambda: rt.render(few, progress=False), rounds=1)
    report(f"2,000 spheres at 512²: {one:.2f} s, {found:.1f} times 20 of them ({other:.2f} s)")
    assert found <= 5
