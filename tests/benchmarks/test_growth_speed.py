"""How the time of a render grows with pixels, shapes and lights, over two decades; and what processes cost."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks import growth
from benchmarks.pairs import ratio
from scenes_for_tests import lamps

import symrt as rt
from symrt import fast

pytestmark = pytest.mark.benchmark
STEEPEST = 1.05
"""Slope of the time over the number, both as logarithms and over two decades; 1 is in proportion."""
AT_THE_END = 1.1
"""The same over the last of them, where a few milliseconds move it by some hundredths."""


@pytest.mark.parametrize("measure", [growth.with_pixels, growth.with_lights])
def test_time_grows_no_faster_than_pixels_and_lights(measure, report, benchmark):
    found = benchmark.pedantic(measure, rounds=1)
    report(str(found))
    whole, end = found.slopes
    assert whole <= STEEPEST
    assert end <= AT_THE_END


def test_time_grows_far_more_slowly_than_the_shapes(report, benchmark):
    # Rays cost a logarithm; what is made of each shape once, and that each is asked at all, is in proportion.
    found = benchmark.pedantic(growth.with_shapes, rounds=1)
    report(f"{found}, {found.a_doubling * 1e3:.0f} ms each doubling")
    assert max(found.slopes) < 0.5


@pytest.mark.parametrize("compiled", [True, False])
def test_sixty_four_lights_cost_about_twenty_times_one(compiled, report, benchmark):
    town = rt.load_scene("many_lights")
    town = replace(town, camera=replace(town.camera, width=160, height=120), lights=town.lights[:64])
    cases = {
        "a ball": (lamps(1, size=192), lamps(64, size=192)),
        "a town": (replace(town, lights=town.lights[:1]), town),
    }

    def render(case):
        one, many = case
        return growth.spent(one), growth.spent(many)

    with fast.use(compiled):
        times = benchmark.pedantic(lambda: {name: render(case) for name, case in cases.items()}, rounds=1)
    for name, (one, many) in times.items():
        how = "compiled" if compiled else "NumPy alone"
        report(f"64 lights on {name}, {how}: {many / one:.1f} times one ({many * 1e3:.0f} ms of a processor)")
        # Asked: 20.  It is 11 on the town, and 14 to 20 on the ball, whose single light has become cheaper.
        assert many <= 24 * one


def test_processes_give_the_bits_of_threads_and_what_they_cost_is_told(globe, report, benchmark):
    large = replace(globe, camera=replace(globe.camera, width=1024, height=1024))

    def render(workers):
        with fast.use(False):
            return rt.render(large, workers=workers, progress=False)

    found, one, other = ratio(lambda: render(None), lambda: render("processes"), pairs=1)
    two = benchmark.pedantic(render, args=("processes",), rounds=1)
    report(f"NumPy alone, 1024²: threads {one:.2f} s, processes {other:.2f} s with their start: {found:.2f} times")
    assert np.array_equal(two.G.data, render(1).G.data)
