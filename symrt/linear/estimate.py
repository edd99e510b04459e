"""The memory and the time that a render will take, from a coarse one (before steps 1 and 2)."""

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from symrt.errors import shown
from symrt.linear.collapse import run
from symrt.linear.freeing import Free
from symrt.linear.job import Job, make_job
from symrt.linear.program import Values
from symrt.linear.tiles import RAYS, SAMPLES, rows_of
from symrt.linear.workers import Workers, processors, threads_used
from symrt.scene.records import Scene
from symrt.table import duration, two_digits
from symrt.tracing.stage import Alternatives
from symrt.tracing.tracer import trace_window

GIB = 1 << 30
COARSE = 1 << 14
"""Camera rays of the coarse render."""
LARGE = 1 << 20
"""Samples of a film from which on a render is estimated before it starts."""
GROUP, GROUPS = Path("/proc/self/cgroup"), Path("/sys/fs/cgroup")
"""Where Linux says which group of processes this one is in, and what each group may use."""
START, A_RAY, AN_ENTRY, A_PIXEL = 320 << 20, 250, 13.5, 32
"""Bytes: of Python and the libraries, of a ray in a tile, of a coefficient with its reserve, of a pixel's rows."""


@dataclass(frozen=True)
class Estimate:
    """The cost of a render, roughly: what a coarse one took, as often as there are coarse ones in it.

    Parameters
    ----------
    pixels, rays, coefficients
        Their numbers in all; a ray that casts no shadow is one, too.
    memory
        Bytes at the peak.
    seconds
        Of one processor; several share them.
    """

    pixels: int
    rays: int
    coefficients: int
    memory: int
    seconds: float

    def __str__(self) -> str:
        counts = f"{_round(self.pixels)} pixels, {_round(self.rays)} rays, {_round(self.coefficients)} coefficients"
        return (
            f"about {counts}: {two_digits(self.memory / GIB)} GiB of memory, {duration(self.seconds)} of one processor"
        )


def estimate(  # noqa: PLR0913  # a public verb names its options
    scene: Scene,
    *,
    part: tuple[int, int] | None = None,
    values: Values | None = None,
    free: Free = (),
    error: float | int | None = None,
    lengths: str = "hats",
    alternatives: Alternatives | None = None,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    workers: Workers = None,
) -> Estimate:
    """Estimate the memory and the time of a render, by rendering the picture coarsely.

    Parameters
    ----------
    part
        Of a render in parts, as for `render_part`.
    values, free, error, lengths, alternatives, force, tolerance, workers
        As in `render`.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> estimate(load_scene(shipped_scene("first"))).pixels
    65536
    """
    job = make_job(scene, values, free, alternatives, force, tolerance, error, lengths)
    return of_job(job, workers, None if part is None else rows_of(part, job.stage.camera.height))


def of_job(job: Job, workers: Workers = None, rows: tuple[int, int] | None = None) -> Estimate:
    """The estimate of a job, or of some of its rows, as if all rows were alike."""
    # Render the same view with few pixels, twice: the first time pays for what is paid once.
    camera = job.stage.camera
    # Where a sample has many rays fewer are taken, no more in all than of a tile.
    most = max(1, min(COARSE, RAYS // job.plan.rays_a_sample))
    across = min(camera.width, max(1, round((most * camera.width / camera.height) ** 0.5)))
    down = min(camera.height, max(1, most // across))
    stage = replace(job.stage, camera=replace(camera, width=across, height=down, samples=1, lens_samples=2))
    run(job.program, trace_window(stage, job.plan))
    start = time.perf_counter()
    tree = trace_window(stage, job.plan)
    system = run(job.program, tree)
    spent = time.perf_counter() - start

    # As much for each sample, and for each pixel, of the picture.
    pixels = camera.width * (camera.height if rows is None else rows[1] - rows[0])
    samples, coarse = pixels * camera.rays_a_pixel, across * down * stage.camera.rays_a_pixel
    entries = (system.G.nnz + (system.tail.bound.nnz if system.tail else 0)) * pixels / (across * down)
    in_tiles = min(SAMPLES * job.plan.rays_a_sample, RAYS, samples * job.plan.rays_a_sample)
    working = workers if isinstance(workers, int) else processors() if workers == "processes" else threads_used()
    programs = 1 + working if workers == "processes" else 1
    return Estimate(
        pixels=pixels,
        rays=round(sum(tree.rays.values()) * samples / coarse),
        coefficients=round(system.G.nnz * pixels / (across * down)),
        memory=round(START * programs + AN_ENTRY * entries + A_PIXEL * pixels + working * A_RAY * in_tiles),
        seconds=spent * samples / coarse,
    )


def check_memory(job: Job, workers: Workers, memory: float | int | None, rows: tuple[int, int] | None = None) -> None:
    """Refuse a render of many samples that needs more memory than there is.

    Parameters
    ----------
    memory
        Gibibytes that there are; those of this machine, or of the job that it runs, if not given.
    """
    if memory is not None and not memory > 0:
        raise ValueError(f"memory = {shown(memory)}: give the GiB that there are, more than 0")
    camera = job.stage.camera
    high = camera.height if rows is None else rows[1] - rows[0]
    most = machine_memory() if memory is None else memory * GIB
    if most is None or camera.width * high * camera.rays_a_pixel < LARGE:
        return
    found = of_job(job, workers, rows)
    if found.memory > most:
        raise ValueError(
            f"{found}; {two_digits(most / GIB)} GiB are there: render it smaller, or in parts on larger machines, or "
            "say how much there is: memory=, --memory, in GiB"
        )


def machine_memory() -> float | None:
    """Bytes of memory that this process may use at most, as far as the system tells; None where it does not."""
    known = []
    if hasattr(os, "sysconf") and {"SC_PAGE_SIZE", "SC_PHYS_PAGES"} <= set(os.sysconf_names):
        known.append(float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")))

    # Schedulers and containers give less than the machine has: the limit of a group holds for all groups within it.
    if GROUP.is_file():
        place = GROUPS / GROUP.read_text().strip().rpartition("::")[2].lstrip("/")
        limits = (folder / "memory.max" for folder in (place, *place.parents))
        known += [float(text) for limit in limits if limit.is_file() and (text := limit.read_text().strip()).isdigit()]
    return min(known, default=None)


def _round(count: int) -> str:
    """A number of things in words."""
    for size, word in ((10**9, "thousand million"), (10**6, "million"), (10**3, "thousand")):
        if count >= size:
            return f"{two_digits(count / size)} {word}"
    return str(count)
