"""Embree's first guess at the triangle a ray meets (step 1), and when it can be trusted.

Embree computes in single precision, ε = 2⁻²⁴.  Here it sees the mesh centred and scaled to the unit ball, and around
every edge a thin prism.  An edge function of a triangle in that ball is wrong by a few ε|e| at most, which is a
distance of a few ε|e|/|e'| where e' is the edge as the ray sees it.  A ray that crosses a triangle at a distance r from
all of its edges sees every edge longer than 2r.  So r = √(2⁻²⁰|e|) is far enough: a ray that meets no prism before it
meets a triangle has been decided with a margin.  Rays that meet a prism are handed back, for double precision to
decide.  That holds for rays from outside of the mesh: one that starts above a triangle may graze it without passing an
edge.  And the distance to a triangle that is grazed is not to be trusted, only that it is met.
"""

from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import PerRay, dot
from symrt.geometry.rays import Rays

NOTHING, DOUBTFUL = -1, -2
FEWEST = 64
"""Triangles below which the hierarchy alone is as fast."""


@dataclass(frozen=True, eq=False)
class Thickened:
    """A mesh with thickened edges in Embree, scaled by 1/radius about its centre.

    `keep` is the Embree object that owns the triangles of `scene`.
    """

    scene: Any
    keep: Any
    centre: Float[np.ndarray, "3 1"]
    radius: float
    triangles: int


def thicken(vertices: Float[np.ndarray, "3 vertex"], faces: Int[np.ndarray, "3 face"]) -> Thickened | None:
    """The mesh in Embree, or None where Embree is not installed or not worth it.

    Examples
    --------
    >>> thicken(np.eye(3), np.array([[0], [1], [2]])) is None
    True
    """
    if faces.shape[1] < FEWEST or find_spec("embreex") is None:
        return None
    from embreex.mesh_construction import TriangleMesh  # noqa: PLC0415 (only where it is installed)
    from embreex.rtcore_scene import EmbreeScene  # noqa: PLC0415

    centre = (vertices.min(axis=1, keepdims=True) + vertices.max(axis=1, keepdims=True)) / 2
    radius = float(np.sqrt(dot(vertices - centre, vertices - centre)).max())
    if radius == 0:
        return None
    unit = (vertices - centre) / radius
    points, prisms = _prisms(unit, faces)
    scene = EmbreeScene()
    keep = TriangleMesh(
        scene,
        np.ascontiguousarray(np.concatenate([unit, points], axis=1).T, dtype=np.float32),
        np.ascontiguousarray(np.concatenate([faces, prisms + unit.shape[1]], axis=1).T, dtype=np.int32),
    )
    # The first query commits the scene; done here, so that no two threads do it at once.
    scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32))
    return Thickened(scene, keep, centre, radius, faces.shape[1])


def first_seen(mesh: Thickened, rays: Rays, start: PerRay) -> Int[np.ndarray, " ray"]:
    """The triangle each ray meets first from `start` on, `NOTHING`, or `DOUBTFUL` where an edge is too near to tell.

    Examples
    --------
    >>> import pytest
    >>> _ = pytest.importorskip("embreex")
    >>> fan = np.linspace(0, 2 * np.pi, 65)
    >>> rim = np.stack([np.cos(fan), np.sin(fan), 0 * fan])
    >>> faces = np.stack([np.full(64, 65), np.arange(64), np.arange(1, 65)])
    >>> disc = thicken(np.concatenate([rim, np.zeros((3, 1))], axis=1), faces)
    >>> x = np.array([0.8 * np.cos(fan[1] / 2), 0.0, 2.0])
    >>> y = np.array([0.8 * np.sin(fan[1] / 2), 0.0, 0.0])
    >>> rays = Rays(np.stack([x, y, np.full(3, 5.0)]), np.array([[0.0] * 3, [0.0] * 3, [-1.0] * 3]))
    >>> first_seen(disc, rays, np.zeros(3)).tolist() == [0, DOUBTFUL, NOTHING]
    True
    """
    origin = (rays.origin + start * rays.direction - mesh.centre) / mesh.radius
    found = mesh.scene.run(origin.T.astype(np.float32, order="C"), rays.direction.T.astype(np.float32, order="C"))
    # From beyond 2²⁸ radii the point of entry is no longer known to the width of a prism.
    return np.where((found < mesh.triangles) & (start < 2.0**28 * mesh.radius), found, DOUBTFUL).astype(np.int32)


def _prisms(
    vertices: Float[np.ndarray, "3 vertex"], faces: Int[np.ndarray, "3 face"]
) -> tuple[Float[np.ndarray, "3 corner"], Int[np.ndarray, "3 side"]]:
    """Three-sided tubes around all edges, with the corners and triangles of their walls."""
    ends = np.sort(np.concatenate([faces[[0, 1]], faces[[1, 2]], faces[[2, 0]]], axis=1), axis=0)
    ends = np.unique(ends, axis=1)
    start, along = vertices[:, ends[0]], vertices[:, ends[1]] - vertices[:, ends[0]]
    length = np.sqrt(dot(along, along))
    start, along, length = start[:, length > 0], along[:, length > 0], length[length > 0]
    unit = along / length
    helper = np.eye(3)[:, np.argmin(np.abs(unit), axis=0)]
    across = np.cross(unit, helper, axis=0)
    across /= np.sqrt(dot(across, across))
    other = np.cross(unit, across, axis=0)

    # A triangle whose sides are r from its middle has its corners at 2r; the tube sticks out by r at both ends.
    r = np.maximum(np.sqrt(2.0**-20 * length), 2.0**-17)
    rim = [2 * r * (np.cos(turn) * across + np.sin(turn) * other) for turn in 2 * np.pi * np.arange(3) / 3]
    points = [end + out for end in (start - r * unit, start + along + r * unit) for out in rim]
    count = length.size
    walls = [(i, j, i + 3) for i, j in ((0, 1), (1, 2), (2, 0))] + [
        (j, j + 3, i + 3) for i, j in ((0, 1), (1, 2), (2, 0))
    ]
    base = np.arange(count)
    return np.concatenate(points, axis=1), np.concatenate(
        [np.stack([base + count * k for k in wall]) for wall in walls], 1
    )
