"""Workers on the tiles of a picture: threads, processes, or whatever executor is given (steps 1 and 2)."""

import os
import signal
import threading
import time
import warnings
from collections import deque
from collections.abc import Generator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import closing, contextmanager
from functools import lru_cache, partial
from multiprocessing import resource_tracker
from typing import Literal

from threadpoolctl import threadpool_limits
from tqdm.auto import tqdm

from symrt import fast
from symrt.errors import shown
from symrt.linear.job import Job
from symrt.linear.tiles import Window
from symrt.system import LinearSystem

Workers = int | Literal["processes"] | None
Tile = tuple[LinearSystem, str]
"""The system of a tile, and a sentence if one that was kept could not be used."""


def finished(
    job: Job, windows: list[Window], workers: Workers, executor: Executor | None, progress: bool
) -> Generator[LinearSystem, None, None]:
    """The systems of all windows, in their order; a bar tells of the tiles, warnings of those that had to be redone."""
    bar = tqdm(total=len(windows), desc="render", unit="tile", delay=1, leave=False, disable=not progress)
    with bar, closing(_each(job, windows, workers, executor)) as each:
        for system, remark in each:
            if remark:
                warnings.warn(remark, stacklevel=2)
            bar.update()
            yield system


def check(workers: Workers) -> None:
    """Refuse a number of workers that there cannot be.

    Examples
    --------
    >>> check(0)
    Traceback (most recent call last):
    ValueError: workers = 0: give a number of threads from 1, or "processes"
    """
    counted = isinstance(workers, int) and not isinstance(workers, bool) and workers >= 1
    if not (workers is None or workers == "processes" or counted):
        raise ValueError(f'workers = {shown(workers)}: give a number of threads from 1, or "processes"')


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def threads_used() -> int:
    """Number of threads of a render that is not told: this machine's processors, or 1 where there are no kernels.

    NumPy alone lets go of Python's lock between any two of its calls: two threads took 1.2 to 1.4 times as long as one.
    """
    return processors() if fast.expected() else 1


def _each(job: Job, windows: list[Window], workers: Workers, executor: Executor | None) -> Generator[Tile, None, None]:
    if executor is not None:
        # Its digest goes with the job, so that a worker knows it again without reading all of it.
        _ = job.picture
        yield from executor.map(partial(_sent, job, fast.wanted()), windows)
    elif workers == "processes":
        yield from _by_processes(job, windows)
    elif (count := workers or threads_used()) == 1:
        with threadpool_limits(1):
            yield from map(job.tile, windows)
    else:
        pool = ThreadPoolExecutor(count, initializer=fast.adopt, initargs=(fast.wanted(),))
        with threadpool_limits(1), pool as threads:
            yield from threads.map(job.tile, windows)


def _by_processes(job: Job, windows: list[Window]) -> Generator[Tile, None, None]:
    """The tiles of all windows, by processes that are sent the job once each and end with this one."""
    from loky import ProcessPoolExecutor  # noqa: PLC0415  # only where it is asked for

    begin = partial(_begin, job, fast.wanted(), os.getpid())
    pool = ProcessPoolExecutor(min(processors(), len(windows)), initializer=begin)
    ended = False
    try:
        # An interrupt that was held is raised at the end of this block.
        with _interrupts_held():
            waiting = deque(pool.submit(_next, window) for window in windows)
        while waiting:
            yield waiting.popleft().result()
        ended = True
    finally:
        # Whatever ends the render early, an interrupt too, ends the workers in the midst of their tiles.
        pool.shutdown(wait=True, kill_workers=not ended)


@contextmanager
def _interrupts_held() -> Generator[None, None, None]:
    """Keep interrupts of this thread waiting: processes begun meanwhile inherit that, and never see one."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # Started later, Python's own tracker of semaphores would let interrupts through again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


_begun: list[Job] = []
"""The job of a worker process, as it was sent when the process began."""


def _begin(job: Job, kernels: bool | None, parent: int) -> None:
    # A terminal interrupts all processes at once; this one is ended by its parent, or ends after it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if os.name == "posix":
        threading.Thread(target=_follow, args=(parent,), daemon=True).start()
    threadpool_limits(1)
    fast.adopt(kernels)
    _begun[:] = [job]


def _follow(parent: int) -> None:
    """End this process soon after a parent that was killed, and could end nothing: else it would wait for ever."""
    while os.getppid() == parent:
        time.sleep(1)
    os._exit(1)


def _next(window: Window) -> Tile:
    return _begun[0].tile(window)


def _sent(job: Job, kernels: bool | None, window: Window) -> Tile:
    with threadpool_limits(1), fast.use(kernels):
        return _first(job).tile(window)


@lru_cache(maxsize=1)
def _first(job: Job) -> Job:
    """The copy of a job that a worker was sent first: its functions are compiled already."""
    return job
