"""The same bits, whoever renders, by kernels or NumPy: threads, processes, a cluster's, machines with a part each."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from multiprocessing import get_context

import numpy as np
import pytest
from scenes_for_tests import SCENES, small

import symrt as rt
from symrt import fast

ENVIRONMENT = os.environ | {"PYTHONPATH": str(SCENES.parent)}


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.tiles"), "SAMPLES", 150)


@pytest.fixture(params=[False, True], ids=["numpy", "kernels"])
def either(request):
    """Kernels used or not, by whoever renders."""
    if request.param and not fast.available():
        pytest.skip("numba is not installed")
    with fast.use(request.param):
        yield


@pytest.fixture(scope="module")
def scene():
    return small("spheres", 22)


@pytest.fixture(scope="module")
def whole(scene):
    with fast.use(False):
        return rt.collapse(rt.trace(scene))


def assert_same_bits(one: rt.LinearSystem, other: rt.LinearSystem) -> None:
    assert (one.interactions, one.models) == (other.interactions, other.models)
    assert list(one.white.items()) == list(other.white.items())
    assert (one.tail.interactions, one.tail.reflected) == (other.tail.interactions, other.tail.reflected)
    for a, b in ((one.G, other.G), (one.tail.bound, other.tail.bound)):
        for part in ("data", "indices", "indptr"):
            assert np.array_equal(getattr(a, part), getattr(b, part))


def spawned():
    return ProcessPoolExecutor(2, mp_context=get_context("spawn"))


@contextmanager
def cluster():
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as local,
        distributed.Client(local) as client,
    ):
        yield client.get_executor()


@pytest.mark.usefixtures("either")
@pytest.mark.parametrize("workers", [1, 2, 8, "processes"])
def test_threads_and_processes_give_the_same_bits(scene, whole, workers):
    assert_same_bits(rt.render(scene, workers=workers, progress=False), whole)


@pytest.mark.parametrize("executor", [lambda: ThreadPoolExecutor(3), spawned, cluster])
def test_executors_of_threads_of_processes_and_of_a_cluster_give_the_same_bits(scene, whole, executor):
    with executor() as workers:
        for kernels in (False, fast.available()):
            with fast.use(kernels):
                assert_same_bits(rt.render(scene, executor=workers, progress=False), whole)


def test_parts_of_several_machines_give_the_same_bits(scene, whole, tmp_path):
    for number, workers, kernels in ((1, 1, True), (2, 8, False), (3, 2, True)):
        with fast.use(kernels and fast.available()):
            rt.render_part(scene, (number, 3), tmp_path, workers=workers, progress=False)
    assert_same_bits(rt.merge_parts(tmp_path), whole)


def test_an_interrupt_that_was_held_ends_the_workers(scene, monkeypatch):
    # It is raised as soon as the last tile has been handed out, before the first is waited for.
    class Pool:
        ended = None

        def __init__(self, *_args, **_named):
            pass

        def submit(self, *_args):
            return Future()

        def shutdown(self, *, wait, kill_workers):
            Pool.ended = wait and kill_workers

    @contextmanager
    def held():
        yield
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("loky"), "ProcessPoolExecutor", Pool)
    monkeypatch.setattr(import_module("symrt.linear.workers"), "_interrupts_held", held)
    with pytest.raises(KeyboardInterrupt):
        rt.render(scene, workers="processes", progress=False)
    assert Pool.ended


def children(parent: int) -> set[int]:
    """Processes below one, those below them included, as the system lists them."""
    listed = subprocess.run(["ps", "-A", "-o", "pid=,ppid=,stat="], capture_output=True, text=True, check=True).stdout
    above = {
        int(pid): int(ppid) for pid, ppid, stat in (line.split() for line in listed.splitlines()) if "Z" not in stat
    }
    found, new = set(), {parent}
    while new:
        new = {pid for pid, ppid in above.items() if ppid in new}
        found |= new
    return found


@pytest.mark.skipif(os.name != "posix", reason="a process is ended by signals here")
@pytest.mark.parametrize("how", ["interrupted", "interrupted as the workers begin", "killed"])
def test_a_script_without_a_guard_uses_processes_and_leaves_none_behind(tmp_path, how):
    script = tmp_path / "script.py"
    script.write_text(
        "import symrt as rt\n"
        "from dataclasses import replace\n"
        f"s = rt.load_scene({str(SCENES / 'first.toml')!r})\n"
        "s = replace(s, camera=replace(s.camera, width=4096, height=4096))\n"
        f"rt.render(s, workers='processes', save={str(tmp_path / 'tiles')!r}, progress=False)\n"
    )
    process = subprocess.Popen(
        [sys.executable, str(script)], env=ENVIRONMENT, start_new_session=True, stderr=subprocess.PIPE, text=True
    )
    begins = how.endswith("begin")
    while not (list(tmp_path.glob("tiles/tile-*.npz")) or (begins and len(children(process.pid)) > 3)):
        assert process.poll() is None
        time.sleep(0.02)
    below = children(process.pid)
    assert len(below) >= 2
    if how != "killed":
        os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    else:
        process.kill()
    said = process.communicate(timeout=30)[1]
    assert process.returncode != 0
    if how != "killed":
        assert said.count("Traceback") == 1  # the script's own, none of a worker's
        assert "KeyboardInterrupt" in said
    end = time.monotonic() + 20
    while (left := {pid for pid in below if alive(pid)}) and time.monotonic() < end:
        time.sleep(0.05)
    assert not left


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True
