"""Probe a scene with a few rays for statistics of the lights, materials and bounces they meet (before step 1).

The paper's §6 proposes it, "to probe a complex scene for light/material interaction statistics before a sophisticated
renderer is applied".
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from symrt.scene.records import Scene
from symrt.table import html_table, text_table
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

NOTHING = "The camera sees nothing that light reaches: look at camera.position and camera.target"
HEAD = ("light", "material", "bounces", "rays that see it", "of these hidden from the light")


@dataclass(frozen=True)
class Meeting:
    """One light at one material after a number of mirror bounces.

    Parameters
    ----------
    share
        Share of the probe's camera rays that see a point of the material that faces the light.
    hidden
        Share of those points that lie in the light's shadow.
    """

    light: str
    material: str
    bounces: int
    share: float
    hidden: float


@dataclass(frozen=True)
class Probe:
    """The meetings of a few rays, most frequent first, and the change that leaving an effect out would make.

    Parameters
    ----------
    rays
        Number of camera rays.
    mirrored
        Share of them that end on a mirror.
    hidden
        Share of the lit points that lie in a shadow.
    """

    meetings: tuple[Meeting, ...]
    rays: int
    mirrored: float
    hidden: float
    seconds: float

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The meetings as rows of text."""
        return [(m.light, m.material, str(m.bounces), f"{m.share:.1%}", f"{m.hidden:.1%}") for m in self.meetings]

    def __str__(self) -> str:
        return f"{text_table(HEAD, self.rows)}\n{self._effects()}" if self.rows else f"{NOTHING}; {self.rays} rays"

    def _effects(self) -> str:
        return (
            f"{self.rays} rays: without shadows {self.hidden:.1%} of the lit points would be too bright, "
            f"without mirrors {self.mirrored:.1%} of the rays would end too soon"
        )

    def _repr_html_(self) -> str:
        return f"{html_table(HEAD, self.rows)}<p>{self._effects()}</p>"


def probe(scene: Scene, rays: int = 4096) -> Probe:
    """Statistics of light, material and depth from about `rays` camera rays on a regular grid of the film.

    A share s is known to about √(s(1 − s)/rays).

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> met = probe(load_scene(shipped_scene("first")), rays=1024)
    >>> [(m.light, m.material, m.bounces) for m in met.meetings]
    [('sun', 'red', 0)]
    """
    if rays < 1:
        raise ValueError(f"rays = {rays}: a probe needs at least one ray")
    start = time.perf_counter()

    # A film of about so many pixels, in the same proportions.
    camera = scene.camera
    across = max(1, round((rays * camera.width / camera.height) ** 0.5))
    coarse = replace(
        camera, width=across, height=max(1, round(across * camera.height / camera.width)), samples=1, lens_samples=2
    )
    tree = trace(replace(scene, camera=coarse))

    # Light by light, material by material; names decide between meetings of equal frequency.
    meetings = sorted(_meetings(tree), key=lambda m: (-m.share, m.bounces, m.light, m.material))
    lit = sum(m.share for m in meetings)
    return Probe(
        meetings=tuple(meetings),
        rays=tree.rays["camera"],
        mirrored=_mirrored(tree) / tree.rays["camera"],
        hidden=sum(m.share * m.hidden for m in meetings) / lit if lit else 0.0,
        seconds=time.perf_counter() - start,
    )


def _mirrored(tree: RayTree) -> int:
    """Number of the camera's rays that end on a mirror."""
    parts = tree.levels[0].points if tree.levels else ()
    return np.unique(np.concatenate([[], *(p.hit for p in parts if tree.materials[p.material].model.sending)])).size


def _meetings(tree: RayTree) -> Iterator[Meeting]:
    """Each light's samples at each material, level by level; those that reach no point are no meeting."""
    rays = tree.rays["camera"]
    parts = ((bounces, points) for bounces, level in enumerate(tree.levels) for points in level.points)
    for bounces, points in parts:
        for lit in points.lit:
            if lit.point.size:
                weight = points.weight[lit.point]
                hidden = float(np.sum(weight * (1 - lit.visible)) / weight.sum())
                yield Meeting(lit.light, points.material, bounces, float(weight.sum() / rays), hidden)
