"""Steps 1 and 2 together, tile by tile: the same bits for any number of workers.

The size of a tile never depends on the workers, each tile is computed alone, and columns are merged in their canonical
order.
"""

import time
import warnings
from collections.abc import Mapping
from concurrent.futures import Executor
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from symrt.linear.estimate import check_memory
from symrt.linear.freeing import Free
from symrt.linear.job import make_job
from symrt.linear.program import Values
from symrt.linear.resume import open_tiles
from symrt.linear.stacking import stacked
from symrt.linear.workers import Workers, check, finished
from symrt.scene.records import Scene
from symrt.system import LinearSystem
from symrt.tracing.stage import Alternatives


def render(  # noqa: PLR0913  # a public verb names its options
    scene: Scene,
    *,
    values: Values | None = None,
    free: Free = (),
    error: float | int | None = None,
    lengths: str = "hats",
    alternatives: Alternatives | None = None,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    executor: Executor | None = None,
    workers: Workers = None,
    save: str | Path | None = None,
    memory: float | int | None = None,
    progress: bool = True,
) -> LinearSystem:
    """Trace a scene and collapse it, tile by tile.

    Parameters
    ----------
    values, free, error, lengths
        As in `collapse`.
    alternatives, force, tolerance
        As in `plan`.
    executor
        Any `concurrent.futures.Executor`, such as that of a cluster; its workers are sent the scene with its files
        read, and need symrt, but none of the files.
    workers
        Number of threads if no executor is given; if not given either, this machine's processors, or 1 without the
        extra ``fast``, where more would wait for each other; or ``"processes"`` for a process on each processor.  The
        result depends on none of it.
    save
        A folder to keep finished tiles in: the same call goes on where an interrupted one stopped, to the same bits.
    memory
        Gibibytes that a render may take, this machine's if not given: a picture of a million samples or more is
        estimated beforehand, and refused if it takes more.
    progress
        Whether a bar is shown on standard error once a render has taken a second.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> render(load_scene(shipped_scene("first")), progress=False).lights
    ('sun',)
    """
    start = time.perf_counter()
    check(workers)
    job = make_job(scene, values, free, alternatives, force, tolerance, error, lengths)
    check_memory(job, workers, memory)
    windows = job.windows()
    if save is not None:
        job = replace(job, kept=open_tiles(save, job.picture, windows))

    camera = job.stage.camera
    # Closed by name: an interrupt between two tiles must end the workers, too.
    with closing(finished(job, windows, workers, executor, progress)) as systems:
        system = stacked(systems, camera.width, camera.height)
    if not system.pixels_of().any():
        warnings.warn(
            "every pixel is black: the camera sees nothing that light reaches; look at camera.position, camera.target "
            "and at what probe(scene) meets",
            stacklevel=2,
        )
    return replace(system, seconds={**system.seconds, "render": time.perf_counter() - start})
