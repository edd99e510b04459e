"""Rays on their way together, and the hits of one level as the viewer sees them (step 1)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int, Shaped

from symrt import fast
from symrt.arrays import Vectors, dot, turned
from symrt.geometry.directions import ROOM, whole_rows
from symrt.geometry.rays import Rays, Surface
from symrt.reflection.models import LIT
from symrt.tracing.raytree import Branch

Which = Int[np.ndarray, " hit"]
"""Indices of some hits of a level."""
State = Mapping[str, Shaped[np.ndarray, " ray"]]
"""Values that effects keep for each ray, by name; an array is there only if an effect in the plan asks for it."""
WINDOW = "window"
"""The name of the state that keeps the window of wavelengths that a ray is of, counted from 0; −1 for all of them."""


@dataclass(frozen=True, eq=False)
class Batch:
    """Rays that are intersected together: those of the branches, one branch after the other.

    Parameters
    ----------
    sample
        The film sample that each ray contributes to.
    state
        The values that effects keep for each ray.
    """

    rays: Rays
    sample: Int[np.ndarray, " ray"]
    branches: tuple[Branch, ...]
    state: State

    def of(self, found: Which) -> "Batch":
        """Some of the rays, in ascending order."""
        # The rays of each branch, numbered within it.
        branches, first = [], 0
        for branch in self.branches:
            own = found[(first <= found) & (found < first + branch.size)] - first
            factors = {name: values[own] for name, values in branch.factors.items()}
            window = None if branch.window is None else branch.window[own]
            branches.append(
                Branch(branch.via, branch.parent[own], branch.weight[own], factors, branch.materials, window)
            )
            first += branch.size

        rays = self.rays[found]
        state = {name: values[found] for name, values in self.state.items()}
        return Batch(rays, self.sample[found], tuple(branches), state)


@dataclass(frozen=True, eq=False)
class View:
    """Surfaces with both their normals turned to the viewer.

    Parameters
    ----------
    slot
        Index of each hit's material or texture in the stage's slots.
    viewer
        Unit vectors from the hits to their viewer: the camera, or the hit that sent the ray.
    normal, shading_normal
        Unit normals of the true and of the smoothed surface.
    sample, state
        The film sample that each hit contributes to, and the values that effects keep for the ray that met it.
    leaving
        The shape that a ray leaves for good when it starts from a hit on the viewer's side, and on the other, or −1.
    branches
        The rays that met the hits, one branch after the other; none of the camera's.
    """

    surface: Surface
    slot: Int[np.ndarray, " hit"]
    viewer: Vectors
    normal: Vectors
    shading_normal: Vectors
    sample: Int[np.ndarray, " hit"]
    state: State
    leaving: Int[np.ndarray, "2 hit"]
    branches: tuple[Branch, ...]

    @property
    def gathered(self) -> Bool[np.ndarray, " hit"]:
        """True for hits of rays along which a surface gathers light: what it samples as a light counts there."""
        if not self.branches:
            return np.zeros(self.slot.size, dtype=bool)
        return np.repeat([b.via in LIT for b in self.branches], [b.size for b in self.branches])

    def facing(self, hit: Which) -> tuple[Vectors, Vectors]:
        """The normals for shading, and the viewers, of some of the hits."""
        # take is several times faster than an index array in brackets, and leaves whole rows.
        return self.shading_normal.take(hit, axis=1), self.viewer.take(hit, axis=1)


def look(surface: Surface, slot: Int[np.ndarray, " hit"], batch: Batch, leaving: Int[np.ndarray, "2 hit"]) -> View:
    """Turn normals to the viewer: the true surface decides the face, the smoothed normal follows it.

    A file may wind its faces against its own vertex normals, so the two are compared, never assumed to agree.
    """
    kernels = fast.kernels(ROOM, slot.size)
    given = batch.rays.direction, surface.normal, surface.shading_normal
    if kernels and {array.dtype for array in given} == {np.dtype(np.float64)}:
        viewer, normal, shading_normal = (np.empty(array.shape) for array in given)
        behind = np.empty(slot.size, np.bool_)
        kernels.look(*map(whole_rows, given), viewer, normal, shading_normal, behind)
    else:
        viewer = -batch.rays.direction
        normal = turned(surface.normal, viewer)
        shading_normal = turned(surface.shading_normal, normal)
        behind = dot(surface.normal, viewer) < 0
    leaving = np.where(behind, leaving[::-1], leaving)
    return View(surface, slot, viewer, normal, shading_normal, batch.sample, batch.state, leaving, batch.branches)
