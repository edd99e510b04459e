"""Compiled kernels: against NumPy's code, which gives the same bits, and against textbook formulas, which do not."""

import resource
import subprocess
import sys

import numpy as np
import pytest
from benchmarks.pairs import ratio
from geometry.oracles import across, directions
from geometry.shapes import icosphere

import symrt as rt
from symrt import fast
from symrt.gamut.clipping import clip_slabs
from symrt.geometry import Box, Cylinder, Disk, Plane, Rays, Rectangle, Sphere, nearest

pytest.importorskip("numba", reason="numba is not installed")

pytestmark = pytest.mark.benchmark

COUNT = 1 << 16
SHAPES = {
    "sphere": Sphere((0, 0, 0), 1, "a"),
    "cylinder": Cylinder((0, -0.8, 0), (0.3, 0.9, 0.2), 0.6, "a"),
    "plane": Plane((0, 0, 0), (0.3, 1, 0.2), "a"),
    "disk": Disk((0, 0, 0), (0.3, 1, 0.2), 1.0, "a"),
    "rectangle": Rectangle((0, 0, 0), (1.6, 0.1, 0.2), (0.0, 1.0, -0.5), "a"),
    "box": Box((0, 0, 0), (1.2, 1.0, 0.9), "a", rotate=(10, 20, 30)),
    "mesh of 1,280": icosphere(3),
}
BY_TEXTBOOK = [f"symrt.geometry.fast.{name}" for name in ("quadrics", "flats", "triangles")]
TEXTBOOK = {"sphere": 2.0, "mesh of 1,280": 1.6}
"""How many times as long as the textbook's kernel ours may take."""


@pytest.fixture(scope="module")
def seen():
    """Rays from six radii away, half of whose lines pass a ball of radius 1."""
    draw = np.random.default_rng(1)
    towards = directions(draw, COUNT)
    aside = np.sqrt(draw.uniform(0, 2, COUNT))
    return Rays(np.ascontiguousarray(aside * across(draw, towards) - 6 * towards), towards)


@pytest.fixture
def by_textbook(monkeypatch):
    """Let a call be done by the textbook's kernels."""
    from benchmarks import textbook  # noqa: PLC0415  # it compiles

    def do(action):
        with monkeypatch.context() as patched:
            patched.setattr(fast, "_ROOMS", fast._ROOMS | dict.fromkeys(BY_TEXTBOOK, textbook))
            return action()

    return do


@pytest.mark.parametrize("name", SHAPES)
def test_kernels_are_several_times_faster_than_numpy(name, seen, report, benchmark):
    def asked(kernels):
        with fast.use(kernels):
            return nearest([SHAPES[name]], seen)

    found, numpy, compiled = ratio(lambda: asked(False), lambda: asked(True))
    benchmark(lambda: asked(True))
    each = 1e9 / COUNT
    report(f"{name}: {numpy * each:.0f} ns a ray by NumPy, {compiled * each:.0f} compiled, {found:.1f} times less")
    assert found >= 2


@pytest.mark.parametrize("name", TEXTBOOK)
def test_exact_kernels_cost_little_more_than_a_textbook_s(name, seen, by_textbook, report, benchmark):
    shapes = [SHAPES[name]]
    with fast.use(True):
        same = np.mean(nearest(shapes, seen).shape == by_textbook(lambda: nearest(shapes, seen)).shape)
        assert same > 0.999
        found, one, other = ratio(
            lambda: nearest(shapes, seen), lambda: by_textbook(lambda: nearest(shapes, seen)), pairs=25
        )
        benchmark(lambda: nearest(shapes, seen))
    each = 1e9 / COUNT
    report(f"{name}: {one * each:.1f} ns a ray, the textbook's {other * each:.1f}: {found:.2f} times")
    assert found <= TEXTBOOK[name]


def test_the_globe_costs_little_more_than_by_textbook_s_kernels(globe, by_textbook, report, benchmark):
    def render():
        return rt.render(globe, workers=1, progress=False)

    with fast.use(True):
        found, one, _ = ratio(render, lambda: by_textbook(render), pairs=5)
        benchmark.pedantic(render, rounds=1)
    report(f"render of the globe, 512², 1 worker: {one:.2f} s, {found:.2f} times that with a textbook's kernels")
    assert found <= 1.3


def test_the_globe_costs_less_with_the_extra(globe, report, benchmark):
    def render(kernels, workers=1):
        with fast.use(kernels):
            return rt.render(globe, workers=workers, progress=False)

    found, numpy, compiled = ratio(lambda: render(False), lambda: render(True), pairs=5)
    threads, one, two = ratio(lambda: render(True), lambda: render(True, 2), pairs=5)
    benchmark.pedantic(render, args=(True,), rounds=1)
    report(f"render of the globe, 512², 1 worker: {numpy:.2f} s by NumPy, {compiled:.2f} s compiled: {found:.2f} times")
    report(f"with kernels and 1 worker {one:.2f} s, with 2 {two:.2f} s: {threads:.2f} times")
    assert found >= 1.5


def test_a_compiled_clip_costs_less(report, benchmark):
    draw = np.random.default_rng(2)
    lines = np.zeros(36), np.ones(36), draw.uniform(0, 1, (COUNT, 36)), draw.normal(size=(COUNT, 36))

    def clipped(kernels):
        with fast.use(kernels):
            return clip_slabs(*lines)

    found, numpy, compiled = ratio(lambda: clipped(False), lambda: clipped(True))
    benchmark(lambda: clipped(True))
    report(f"clip of 65,536 pixels to 36 slabs: {numpy * 1e3:.0f} ms by NumPy, {compiled * 1e3:.0f} ms compiled")
    assert found >= 1.2


def test_compiling_takes_some_seconds_once(tmp_path, monkeypatch, report, benchmark):
    script = "from symrt import fast; fast.load()"
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def spent(script):
        """Seconds of a processor, which other programs do not lengthen: compiling is one thread's work."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime

    first = spent(script)
    again = benchmark.pedantic(spent, args=(script,), rounds=3)
    bare = spent("import symrt.geometry, symrt.gamut")
    report(f"kernels: {first:.1f} s where nothing is compiled, {again - bare:.2f} s from the cache")
    assert first <= 15
