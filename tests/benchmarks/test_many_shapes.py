"""What many shapes cost, as a ratio to few: a ray is asked about those it may meet."""

import pytest
from benchmarks.growth import spheres
from benchmarks.pairs import ratio

import symrt as rt
from symrt import fast

pytestmark = pytest.mark.benchmark


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
