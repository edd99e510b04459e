"""The hits of one level as the viewer sees them (step 1)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import Vectors, dot
from symrt.geometry.rays import Hits, Rays, Surface


@dataclass(frozen=True, eq=False)
class View:
    """Surfaces with both their normals turned to the viewer.

    Parameters
    ----------
    slot
        What each hit is made of: an index into the stage's slots.
    viewer
        Unit vectors from the hits to where they are seen from.
    sample
        The film sample that each hit contributes to.
    """

    surface: Surface
    slot: Int[np.ndarray, " hit"]
    viewer: Vectors
    normal: Vectors
    shading_normal: Vectors
    sample: Int[np.ndarray, " hit"]


def look(surface: Surface, slot: Int[np.ndarray, " hit"], rays: Rays, sample: Int[np.ndarray, " hit"]) -> View:
    """Turn normals to the viewer: the true surface decides the face, the smoothed normal follows it.

    A file may wind its faces against its own vertex normals, so the two are compared, never assumed to agree.
    """
    viewer = -rays.direction
    normal = _turned(surface.normal, viewer)
    return View(surface, slot, viewer, normal, _turned(surface.shading_normal, normal), sample)


def _turned(normal: Float[np.ndarray, "3 hit"], towards: Float[np.ndarray, "3 hit"]) -> Float[np.ndarray, "3 hit"]:
    return np.where(dot(normal, towards) < 0, -normal, normal)


def select_rays(rays: Rays, which: Int[np.ndarray, " hit"]) -> Rays:
    """Some of the rays."""
    return Rays(rays.origin[:, which], rays.direction[:, which])


def select_hits(hits: Hits, which: Int[np.ndarray, " hit"]) -> Hits:
    """Some of the hits."""
    return Hits(hits.distance[which], hits.shape[which], hits.primitive[which])
