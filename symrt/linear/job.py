"""A render as a thing that can be sent: a scene made ready, its plan and its program (steps 1 and 2).

A tile is computed alone, from a job and a window: its bits depend on neither who computes it nor when.
"""

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from symrt import __version__
from symrt.errors import require
from symrt.linear.collapse import run
from symrt.linear.digests import digest_of
from symrt.linear.freeing import Free
from symrt.linear.pieces import Picture
from symrt.linear.planning import thrifty
from symrt.linear.program import Program, Values, make_program
from symrt.linear.resume import Tiles
from symrt.linear.tiles import Window, tiles
from symrt.scene.records import Scene
from symrt.system import LinearSystem
from symrt.tracing.plan import Plan
from symrt.tracing.planner import first_plan
from symrt.tracing.stage import Alternatives, Stage, make_stage
from symrt.tracing.tracer import trace_window
from symrt.tracing.work import at_work


@dataclass(frozen=True, eq=False)
class Job:
    """A scene made ready, its plan and its compiled program, and the folder that finished tiles are kept in.

    Two jobs are equal if they give the same tiles, bit for bit.
    """

    stage: Stage
    plan: Plan
    program: Program
    kept: Tiles | None = None

    @cached_property
    def picture(self) -> Picture:
        """The picture that the tiles belong to."""
        camera = self.stage.camera
        scene, values = digest_of(self.stage, self.plan), digest_of(self.program)
        return Picture(__version__, scene, values, camera.width, camera.height)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Job) and (self.picture, self.kept) == (other.picture, other.kept)

    def __hash__(self) -> int:
        return hash(self.picture)

    def windows(self, rows: tuple[int, int] | None = None) -> list[Window]:
        """The tiles of the picture, or of some of its rows, in the order of its pixels."""
        camera = self.stage.camera
        return tiles(camera.width, camera.height, camera.rays_a_pixel, self.plan.rays_a_sample, rows)

    def tile(self, window: Window) -> tuple[LinearSystem, str]:
        """The system of a window, traced and collapsed unless it is kept, and a sentence if what was kept is no use."""
        kept, remark = (None, "") if self.kept is None else self.kept.finished(window)
        if kept is not None:
            return kept, remark
        tree = trace_window(self.stage, self.plan, window)
        start = time.perf_counter()
        system = run(self.program, tree)
        tile = replace(system, seconds={"trace": tree.seconds, "collapse": time.perf_counter() - start})
        if self.kept is not None:
            self.kept.keep(window, tile)
        return tile, remark


def make_job(
    scene: Scene,
    values: Values | None = None,
    free: Free = (),
    alternatives: Alternatives | None = None,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    error: float | int | None = None,
    lengths: str = "hats",
) -> Job:
    """Read a scene's files, plan its trace, and compile its models.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> job = make_job(load_scene(shipped_scene("first")))
    >>> job.tile((120, 90, 140, 110))[0]
    LinearSystem(20 × 20 pixels, 2 interactions, 800 coefficients, 2.0 a pixel)
    """
    require("scene", scene, Scene, "a Scene, load_scene(path)")
    chosen, stage = first_plan(scene, alternatives, force=force, tolerance=tolerance), make_stage(scene, alternatives)
    chosen = thrifty(chosen, stage, tolerance, force or {}, values)
    program = make_program(stage.materials, values, free, at_work(chosen).gathered, error, lengths)
    return Job(stage, chosen, program)
