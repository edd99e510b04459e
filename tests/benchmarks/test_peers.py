"""The first picture in 36 bands, against other ways to make it: an exact kernel written for the scene, and Mitsuba."""

import time

import numpy as np
import pytest
from benchmarks.pairs import ratio

import symrt as rt
from symrt import fast

pytest.importorskip("numba", reason="numba is not installed")

from benchmarks import peer  # it compiles

pytestmark = pytest.mark.benchmark


@pytest.fixture(scope="module")
def first_image():
    """Everything from the scene to 36 bands, as at the first time but for what is compiled once a machine."""
    scene, palette = peer.scene(), peer.palette()

    def made():
        with fast.use(True):
            return rt.shade(rt.collapse(rt.trace(scene)), palette).values

    made()
    return made


def agree(one, other, tolerance):
    """Pixels agree but for a few along the edges of shapes and shadows, where one rounding decides."""
    differing = np.abs(one - other).max(axis=2) > tolerance * other.max()
    assert differing.mean() < 2e-3


def test_trace_and_collapse_of_a_small_scene_are_immediate(report, benchmark):
    scene = peer.scene()
    with fast.use(True):
        found, whole, traced = ratio(lambda: rt.collapse(rt.trace(scene)), lambda: rt.trace(scene), pairs=25)
        benchmark(lambda: rt.collapse(rt.trace(scene)))
    report(f"peer scene, 256²: trace {traced * 1e3:.1f} ms, with its collapse {whole * 1e3:.1f} ms ({found:.2f} times)")
    assert found <= 1.3


def test_the_first_image_costs_little_more_than_by_an_exact_kernel(first_image, report, benchmark):
    agree(first_image(), peer.by_exact_kernel(), 1e-12)
    found, one, other = ratio(first_image, peer.by_exact_kernel, pairs=15)
    benchmark(first_image)
    report(
        f"peer scene, first image in 36 bands: {one * 1e3:.0f} ms, {found:.2f} times an exact kernel of its own "
        f"({other * 1e3:.0f} ms)"
    )


def test_the_first_image_costs_less_than_nine_exact_passes_of_mitsuba(first_image, report, benchmark):
    mi = pytest.importorskip("mitsuba", reason="to be had by pip install mitsuba")
    if "llvm_ad_spectral" not in mi.variants():
        pytest.skip("this mitsuba has no variant llvm_ad_spectral")
    mi.set_variant("llvm_ad_spectral")
    import drjit  # noqa: PLC0415  # it comes with mitsuba

    by_mitsuba = peer.by_mitsuba(mi, drjit)
    agree(first_image(), by_mitsuba(), 1e-4)  # single precision
    found, one, other = ratio(first_image, by_mitsuba, pairs=15)
    work, ours, theirs = ratio(first_image, by_mitsuba, pairs=15, clock=time.process_time)
    benchmark(first_image)
    report(
        f"the same, {one * 1e3:.0f} ms, by nine passes of mitsuba {mi.__version__} {other * 1e3:.0f} ms on "
        f"{drjit.thread_count()} threads: {found:.2f} times; of processors' time {ours * 1e3:.0f} and "
        f"{theirs * 1e3:.0f} ms: {work:.2f} times"
    )
    assert found < 1
