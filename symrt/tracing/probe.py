"""Probe a scene with a few rays for statistics of the lights, materials and bounces they meet (before step 1).

The paper's §6 proposes it, "to probe a complex scene for light/material interaction statistics before a sophisticated
renderer is applied".
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np

from symrt.reflection.models import LIT
from symrt.scene.records import Scene
from symrt.table import html_table, text_table
from symrt.tracing.raytree import RayTree
from symrt.tracing.tracer import trace

NOTHING = "The camera sees nothing that light reaches: look at camera.position and camera.target"
HEAD = ("light", "material", "bounces", "rays that see it", "of these hidden from the light")
SENT = ("rays sent on", "by", "bounces", "that meet something", "not followed", "windows")
GATHERED = "gathered"
"""The word for rays by a formula that lights meet: they gather light from other surfaces."""


@dataclass(frozen=True)
class Meeting:
    """One light at one material after a number of bounces.

    Parameters
    ----------
    share
        For each of the probe's camera rays, the rays that see a point of the material that faces the light.
    hidden
        Share of those points that lie in the light's shadow.
    """

    light: str
    material: str
    bounces: int
    share: float
    hidden: float


@dataclass(frozen=True)
class Branching:
    """Rays that one material sends on in one way after a number of bounces.

    Parameters
    ----------
    via
        The formula by which they are sent on, ``reflected`` or ``transmitted``, or ``gathered`` where it is one that
        lights meet.
    share
        For each of the probe's camera rays, those that were followed and met something.
    cut
        For each of the probe's camera rays, those that were not followed: beyond the depth, or carrying too little.
    windows
        The number of windows of wavelengths that they were split into; 0 for rays of all wavelengths.
    """

    via: str
    material: str
    bounces: int
    share: float
    cut: float
    windows: int


@dataclass(frozen=True)
class Probe:
    """The meetings of a few rays, most frequent first, and the change that leaving an effect out would make.

    Parameters
    ----------
    branches
        The rays that materials send on, in the order of bounces.
    rays
        Number of camera rays.
    mirrored
        Share of them that end on a surface that sends rays on, as a mirror does.
    hidden
        Share of the lit points that lie in a shadow.
    """

    meetings: tuple[Meeting, ...]
    branches: tuple[Branching, ...]
    rays: int
    mirrored: float
    hidden: float
    seconds: float

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The meetings as rows of text."""
        return [(m.light, m.material, str(m.bounces), f"{m.share:.1%}", f"{m.hidden:.1%}") for m in self.meetings]

    @property
    def sent(self) -> list[tuple[str, ...]]:
        """The branches as rows of text."""
        return [
            (b.via, b.material, str(b.bounces), f"{b.share:.1%}", f"{b.cut:.1%}", str(b.windows or ""))
            for b in self.branches
        ]

    def __str__(self) -> str:
        if not self.rows:
            return f"{NOTHING}; {self.rays} rays"
        sent = [text_table(SENT, self.sent)] if self.branches else []
        return "\n".join([text_table(HEAD, self.rows), *sent, self._effects()])

    def _effects(self) -> str:
        shadows = f"{self.rays} rays: without shadows {self.hidden:.1%} of the lit points would be too bright"
        ended = f", and {self.mirrored:.1%} of the rays would end too soon if surfaces sent none on"
        return shadows + (ended if self.mirrored else "")

    def _repr_html_(self) -> str:
        sent = html_table(SENT, self.sent) if self.branches else ""
        return f"{html_table(HEAD, self.rows)}{sent}<p>{self._effects()}</p>"


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
        branches=tuple(sorted(_branches(tree), key=lambda b: (b.bounces, -b.share - b.cut, b.material, b.via))),
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
    """Each light at each material, level by level; those that reach no point are no meeting."""
    rays = tree.rays["camera"]
    parts = ((bounces, points) for bounces, level in enumerate(tree.levels) for points in level.points)
    for bounces, points in parts:
        for light in dict.fromkeys(lit.light for lit in points.lit):
            # A light of several samples is met as often as they are on average.
            samples = [lit for lit in points.lit if lit.light == light]
            weights = [points.weight[lit.point] for lit in samples]
            met = sum(float(weight.sum()) for weight in weights)
            if met:
                dark = sum(float(np.sum(w * (1 - lit.visible))) for w, lit in zip(weights, samples, strict=True))
                yield Meeting(light, points.material, bounces, met / len(samples) / rays, dark / met)


def _branches(tree: RayTree) -> Iterator[Branching]:
    """The rays that each material sends on by each formula, level by level."""
    rays = tree.rays["camera"]
    for bounces, (level, below) in enumerate(zip_longest(tree.levels, tree.levels[1:])):
        followed = () if below is None else below.branches
        for points in level.points:
            for via in sorted(tree.materials[points.material].model.formulas):
                # The rays that this material sends by this formula, followed and cut, and their windows.
                own = [branch for branch in (*followed, *level.cut) if branch.via == via and branch.sent_by(points)]
                weight = np.zeros(level.size)
                weight[points.hit] = points.weight
                share, cut = (
                    sum(float(weight[branch.parent].sum()) for branch in own if branch in kind) / rays
                    for kind in (followed, level.cut)
                )
                split = [branch.window[weight[branch.parent] > 0] for branch in own if branch.window is not None]
                windows = np.unique(np.concatenate(split)).size if split else 0
                if share or cut:
                    name = GATHERED if via in LIT else via
                    yield Branching(name, points.material, bounces, share, cut, windows)
