"""Steps 1 and 2 together, tile by tile: the same bits for any number of workers.

The size of a tile never depends on the workers, each tile is computed alone, and columns are merged in their canonical
order.
"""

import os
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from jaxtyping import Int
from threadpoolctl import threadpool_limits
from tqdm.auto import tqdm

from symrt import __version__, fast
from symrt.errors import require
from symrt.linear.collapse import run
from symrt.linear.matrix import stack_rows
from symrt.linear.program import Free, Program, Values, make_program
from symrt.linear.resume import Tiles, open_tiles
from symrt.scene.records import Scene
from symrt.system import LinearSystem, Tail
from symrt.tracing.plan import Plan
from symrt.tracing.planner import plan
from symrt.tracing.stage import Alternatives, Stage, make_stage
from symrt.tracing.tracer import trace_window

Window = tuple[int, int, int, int]

TILE = 32768
"""Film samples in a tile, about: enough to amortise NumPy's calls, few enough to stay in cache and be shared out."""


def render(  # noqa: PLR0913  # a public verb names its options
    scene: Scene,
    *,
    values: Values | None = None,
    free: Free = (),
    alternatives: Alternatives | None = None,
    force: Mapping[str, bool] | None = None,
    executor: Executor | None = None,
    workers: int | None = None,
    save: str | Path | None = None,
    progress: bool = True,
) -> LinearSystem:
    """Trace a scene and collapse it, tile by tile.

    Parameters
    ----------
    values, free
        As in `collapse`.
    alternatives, force
        As in `trace`.
    executor
        Any `concurrent.futures.Executor`; threads on this machine's processors if not given.
    workers
        Number of threads if no executor is given; the result does not depend on it.
    save
        A folder to keep finished tiles in: the same call goes on where an interrupted one stopped, to the same bits.
    progress
        Whether a bar is shown on standard error once a render has taken a second.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> render(load_scene(shipped_scene("first")), progress=False).lights
    ('sun',)
    """
    start = time.perf_counter()
    require("scene", scene, Scene, "a Scene, load_scene(path)")
    stage, chosen = make_stage(scene, alternatives), plan(scene, alternatives, force=force)
    program = make_program(stage.materials, values, free)
    windows = tiles(stage.camera.width, stage.camera.height, stage.camera.rays_a_pixel)
    kept = None if save is None else open_tiles(save, __version__, windows, stage, chosen, program)
    bar = tqdm(total=len(windows), desc="render", unit="tile", delay=1, leave=False, disable=not progress)
    with bar, threadpool_limits(1):
        parts = []
        for part in _each(windows, partial(_tile, stage, chosen, program, kept), executor, workers or _processors()):
            parts.append(part)
            bar.update()
    system = _merge(stage, program, windows, parts)
    if not system.G.nnz:
        warnings.warn(
            "every pixel is black: the camera sees nothing that light reaches; look at camera.position, camera.target "
            "and at what probe(scene) meets",
            stacklevel=2,
        )
    return replace(system, seconds={**system.seconds, "render": time.perf_counter() - start})


def tiles(width: int, height: int, rays_a_pixel: int) -> list[Window]:
    """Windows that cover the film: bands of whole rows, cut across where one row is too long.

    Examples
    --------
    >>> tiles(512, 512, 1)[:2]
    [(0, 0, 512, 64), (0, 64, 512, 128)]
    """
    across = max(1, min(width, TILE // rays_a_pixel))
    down = max(1, TILE // (across * rays_a_pixel))
    return [
        (x, y, min(x + across, width), min(y + down, height))
        for y in range(0, height, down)
        for x in range(0, width, across)
    ]


def _each(
    windows: list[Window], task: Callable[[Window], LinearSystem], executor: Executor | None, workers: int
) -> Iterator[LinearSystem]:
    if executor is not None:
        yield from executor.map(task, windows)
    elif workers == 1:
        yield from map(task, windows)
    else:
        with ThreadPoolExecutor(workers, initializer=fast.adopt, initargs=(fast.wanted(),)) as threads:
            yield from threads.map(task, windows)


def _tile(stage: Stage, chosen: Plan, program: Program, kept: Tiles | None, window: Window) -> LinearSystem:
    if kept is not None and (finished := kept.finished(window)) is not None:
        return finished
    tree = trace_window(stage, chosen, window)
    start = time.perf_counter()
    system = run(program, tree)
    tile = replace(system, seconds={"trace": tree.seconds, "collapse": time.perf_counter() - start})
    return tile if kept is None else kept.keep(window, tile)


def _merge(stage: Stage, program: Program, windows: list[Window], parts: list[LinearSystem]) -> LinearSystem:
    width, height = stage.camera.width, stage.camera.height
    order = _row_order(windows, width)
    matrix, interactions = stack_rows([(part.G, part.interactions) for part in parts], order)
    bound, cut = stack_rows([(part.tail.bound, part.tail.interactions) for part in parts if part.tail], order)
    return LinearSystem(
        G=matrix,
        interactions=interactions,
        height=height,
        width=width,
        white={name: light.white for name, light in stage.remembered.items()},
        models=program.signatures,
        parameters=program.nodes,
        tail=replace(parts[0].tail or Tail(bound), bound=bound, interactions=cut),
        seconds={step: sum(part.seconds[step] for part in parts) for step in ("trace", "collapse")},
    )


def _row_order(windows: list[Window], width: int) -> Int[np.ndarray, " pixel"]:
    """For each pixel of the image, the row that it has when the tiles are put under each other."""
    pixels = [(np.arange(y0, y1)[:, None] * width + np.arange(x0, x1)).ravel() for x0, y0, x1, y1 in windows]
    return np.argsort(np.concatenate(pixels), kind="stable")


def _processors() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
