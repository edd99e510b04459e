"""Tiles and workers change nothing: `render` gives the bits of `collapse(trace(scene))`."""

import platform
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scenes_for_tests import camera, every_scene, hall_of_mirrors, lamps, mirrors, small, two_materials
from scipy import sparse

import symrt as rt
from symrt.linear.stacking import Stack, stacked
from symrt.linear.tiles import tiles


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
    monkeypatch.setattr(import_module("symrt.linear.tiles"), "SAMPLES", 300)


@pytest.mark.usefixtures("small_tiles")
@pytest.mark.parametrize("name", every_scene())
def test_tiles_and_1_2_and_8_workers_give_the_same_bits(name):
    scene = small(name, 33)
    whole = rt.collapse(rt.trace(scene))
    for workers in (1, 2, 8):
        assert_same_bits(rt.render(scene, workers=workers, progress=False), whole)


@pytest.mark.parametrize(
    ("width", "height", "samples"), [(1, 1, 1), (512, 512, 1), (100000, 2, 1), (640, 480, 4), (7, 5, 64)]
)
def test_tiles_cover_every_pixel_once_and_do_not_depend_on_workers(width, height, samples):
    count = np.zeros((height, width), dtype=int)
    for x0, y0, x1, y1 in tiles(width, height, samples):
        count[y0:y1, x0:x1] += 1
    assert np.all(count == 1)


def test_a_tile_holds_no_more_rays_than_the_plan_expects_of_it():
    few, many = (rt.plan(lamps(count)) for count in (1, 100))
    assert (few.rays_a_sample, many.rays_a_sample) == (2, 101)
    assert rt.plan(mirrors(depth=4)).rays_a_sample == 1 + 5 + 4  # five hits look at the sun, four rays are mirrored
    for plan in (few, many):
        for x0, y0, x1, y1 in tiles(4096, 64, 4, plan.rays_a_sample):
            samples = (x1 - x0) * (y1 - y0) * 4
            assert samples <= 65536
            assert samples * plan.rays_a_sample <= 1 << 19


@pytest.mark.parametrize("rows", [(0, 1), (3, 40), (39, 64)])
def test_tiles_of_some_rows_follow_the_order_of_the_pixels(rows):
    pixels = [
        y * 100 + x for x0, y0, x1, y1 in tiles(100, 64, 9, 40, rows) for y in range(y0, y1) for x in range(x0, x1)
    ]
    assert pixels == list(range(rows[0] * 100, rows[1] * 100))


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


def test_stacked_rows_are_those_of_scipy_over_the_union_of_the_columns():
    rng = np.random.default_rng(3)
    union = tuple(sorted(rt.Interaction(light, met) for light in ("sun", "sky") for met in ((), ("a.b",), ("c.d",))))
    stack, dense = Stack(60), []
    for rows in (7, 0, 30, 1, 22):
        own = np.flatnonzero(rng.random(len(union)) < 0.6)
        block = np.zeros((rows, len(union)))
        block[:, own] = rng.random((rows, own.size)) * (rng.random((rows, own.size)) < 0.5)
        dense.append(block)
        stack.add(sparse.csr_array(block[:, own]), tuple(union[k] for k in own))
    matrix, columns = stack.matrix()
    place = [union.index(one) for one in columns]
    expected = sparse.csr_array(np.concatenate(dense)[:, place])
    for part in ("data", "indices", "indptr"):
        assert np.array_equal(getattr(matrix, part), getattr(expected, part))


def test_tiles_are_written_into_their_place_and_never_held_twice():
    tile = rt.LinearSystem(
        sparse.csr_array(np.full((4096, 8), 0.5)), tuple(rt.Interaction(f"light{k}") for k in range(8)), 16, 256, {}
    )
    tracemalloc.start()
    whole = stacked((replace(tile, G=tile.G.copy()) for _ in range(40)), 256, 640)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    held = whole.G.data.nbytes + whole.G.indices.nbytes + 2 * whole.G.indptr.nbytes
    assert held > 40 * 4096 * 8 * 12
    assert peak < 1.35 * held  # an eighth in reserve, and a tile or two


def test_times_of_both_steps_are_kept():
    system = rt.render(hall_of_mirrors(2), progress=False)
    assert set(system.seconds) == {"trace", "collapse", "render"}
    assert all(seconds > 0 for seconds in system.seconds.values())


def test_saved_and_loaded_is_the_same(tmp_path):
    system = rt.render(hall_of_mirrors(2), progress=False)
    rt.save_system(tmp_path / "hall.npz", system)
    assert_same_bits(rt.load_system(tmp_path / "hall.npz"), system)
    assert replace(system, seconds={}).lights == ("lamp", "sky")


def test_branches_that_mostly_leave_the_scene_do_not_make_tiles_tiny():
    # A tile of 512 samples took eight times as long as one of 32768: glass sends on two rays from each hit.
    scene = replace(mirrors(model="glass", index=1.5, depth=12), camera=camera(256))
    expected = rt.plan(scene).rays_a_sample
    cast = sum(rt.trace(scene, window=(0, 64, 256, 192)).rays.values()) / (256 * 128)
    assert cast <= expected <= 16 * cast
    x0, y0, x1, y1 = tiles(256, 256, 1, expected)[0]
    assert (x1 - x0) * (y1 - y0) >= 1 << 13


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other allocators keep memory anyway")
def test_a_render_takes_the_memory_that_the_one_before_let_go():
    # Page by page it would be some 4,000 faults a render.
    resource = pytest.importorskip("resource")
    scene, faults = small("first", 256), []
    for _ in range(4):
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        rt.render(scene, workers=1, progress=False)
        faults.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
    assert min(faults[1:]) < 1000
