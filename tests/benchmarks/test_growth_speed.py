"""How the time of a render grows, over two decades of pixels and of lights; and what a pool of processes is worth."""

import time
from dataclasses import replace

import numpy as np
import pytest
from benchmarks.pairs import ratio
from scenes_for_tests import lamps

import symrt as rt
from symrt import fast

pytestmark = pytest.mark.benchmark
STEEPEST = 1.05
"""Slope of the time over the number, both as logarithms; 1 is in proportion."""


def spent(scene: rt.Scene) -> float:
    """Processor seconds of a render by one worker: the least of three, after one that pays for what is paid once."""
    found = []
    for _ in range(4):
        start = time.process_time()
        rt.render(scene, workers=1, progress=False)
        found.append(time.process_time() - start)
    return min(found[1:])


def slopes(counts: list[int], times: list[float]) -> tuple[float, float]:
    """The slope of the line through all of them, and through their last half, where what is fixed counts less."""
    x, y = np.log(counts), np.log(times)
    half = len(counts) // 2
    return float(np.polyfit(x, y, 1)[0]), float(np.polyfit(x[half:], y[half:], 1)[0])


def table(counts: list[int], times: list[float]) -> str:
    return ", ".join(f"{count}: {seconds * 1e3:.0f} ms" for count, seconds in zip(counts, times, strict=True))


def test_time_grows_no_faster_than_the_pixels(globe, report, benchmark):
    sides = [160, 285, 506, 900, 1600]  # 1 : 100 in pixels
    scenes = [replace(globe, camera=replace(globe.camera, width=side, height=side)) for side in sides]
    times = benchmark.pedantic(lambda: [spent(scene) for scene in scenes], rounds=1)
    counts = [side * side for side in sides]
    found = slopes(counts, times)
    report(f"growth with pixels of the globe, slope {found[0]:.2f}, at the end {found[1]:.2f} ({table(counts, times)})")
    assert max(found) <= STEEPEST


def test_time_grows_no_faster_than_the_lights(report, benchmark):
    counts = [1, 3, 10, 32, 100]
    times = benchmark.pedantic(lambda: [spent(lamps(count, size=192)) for count in counts], rounds=1)
    found = slopes(counts, times)
    report(f"growth with lights, slope {found[0]:.2f}, at the end {found[1]:.2f} ({table(counts, times)})")
    assert max(found) <= STEEPEST


def test_processes_give_the_bits_of_threads_and_what_they_cost_is_told(globe, report, benchmark):
    large = replace(globe, camera=replace(globe.camera, width=1024, height=1024))

    def render(workers):
        with fast.use(False):
            return rt.render(large, workers=workers, progress=False)

    found, one, other = ratio(lambda: render(None), lambda: render("processes"), pairs=1)
    two = benchmark.pedantic(render, args=("processes",), rounds=1)
    report(f"NumPy alone, 1024²: threads {one:.2f} s, processes {other:.2f} s with their start: {found:.2f} times")
    assert np.array_equal(two.G.data, render(1).G.data)
