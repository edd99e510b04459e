"""Tiles and workers change nothing: `render` gives the bits of `collapse(trace(scene))`."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pytest
from scenes_for_tests import every_scene, hall_of_mirrors, small, two_materials

import symrt as rt
from symrt.linear.matrix import stack_rows
from symrt.linear.render import tiles


def assert_same_bits(one: rt.LinearSystem, other: rt.LinearSystem) -> None:
    assert one.interactions == other.interactions
    for part in ("data", "indices", "indptr"):
        assert np.array_equal(getattr(one.G, part), getattr(other.G, part))
    assert one.white == other.white
    assert one.models == other.models
    assert (one.tail.bound != other.tail.bound).nnz == 0
    assert (one.tail.interactions, one.tail.reflected) == (other.tail.interactions, other.tail.reflected)


@pytest.fixture
def small_tiles(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.render"), "TILE", 300)


@pytest.mark.usefixtures("small_tiles")
@pytest.mark.parametrize("name", every_scene())
def test_tiles_and_1_2_and_8_workers_give_the_same_bits(name):
    scene = small(name, 33)
    whole = rt.collapse(rt.trace(scene))
    for workers in (1, 2, 8):
        assert_same_bits(rt.render(scene, workers=workers, progress=False), whole)


@pytest.mark.usefixtures("small_tiles")
def test_any_executor_gives_the_same_bits():
    scene = small("first", 33, samples=2)
    whole = rt.render(scene, progress=False)
    with ThreadPoolExecutor(3) as threads:
        assert_same_bits(rt.render(scene, executor=threads, progress=False), whole)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as processes:
        assert_same_bits(rt.render(scene, executor=processes, progress=False), whole)


@pytest.mark.parametrize(
    ("width", "height", "samples"), [(1, 1, 1), (512, 512, 1), (100000, 2, 1), (640, 480, 4), (7, 5, 64)]
)
def test_tiles_cover_every_pixel_once_and_do_not_depend_on_workers(width, height, samples):
    count = np.zeros((height, width), dtype=int)
    for x0, y0, x1, y1 in tiles(width, height, samples):
        count[y0:y1, x0:x1] += 1
    assert np.all(count == 1)


def test_a_values_render_is_a_values_collapse():
    scene = two_materials(exponent=20)
    changed = rt.render(scene, values={"shiny.exponent": 60}, progress=False)
    assert_same_bits(changed, rt.collapse(rt.trace(two_materials(exponent=60))))


@pytest.mark.usefixtures("small_tiles")
def test_a_worker_that_fails_says_why():
    class Broken(ThreadPoolExecutor):
        def submit(self, *_args, **_kwargs):
            return super().submit(lambda: (_ for _ in ()).throw(MemoryError("a worker died")))

    with Broken(1) as broken, pytest.raises(MemoryError, match="a worker died"):
        rt.render(small("first", 33), executor=broken, progress=False)


def test_rows_are_stacked_in_the_order_asked_for():
    one = rt.collapse(rt.trace(small("first", 8)))
    parts = [(one.G[:32], one.interactions), (one.G[32:], one.interactions)]
    backwards = np.arange(64)[::-1]
    stacked, columns = stack_rows(parts, backwards)
    assert columns == one.interactions
    np.testing.assert_array_equal(stacked.toarray(), one.G.toarray()[::-1])


def test_times_of_both_steps_are_kept():
    system = rt.render(hall_of_mirrors(2), progress=False)
    assert set(system.seconds) == {"trace", "collapse", "render"}
    assert all(seconds > 0 for seconds in system.seconds.values())


def test_saved_and_loaded_is_the_same(tmp_path):
    system = rt.render(hall_of_mirrors(2), progress=False)
    rt.save_system(tmp_path / "hall.npz", system)
    assert_same_bits(rt.load_system(tmp_path / "hall.npz"), system)
    assert replace(system, seconds={}).lights == ("lamp", "sky")
