"""A convex solid on paper: an orthographic view, its facets, and places for labels (for Figure 1 of the paper)."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull

from symrt.gamut.views import Polyhedron
from symrt.spectra.bands import Number


@dataclass(frozen=True)
class View:
    """An orthographic view of three coordinates (c0, c1, c2), with c0 upright.

    Parameters
    ----------
    azimuth
        Direction of the viewer, in degrees from c1 towards c2.
    elevation
        Height of the viewer, in degrees above c0 = 0.

    Examples
    --------
    >>> View(azimuth=0, elevation=0).project(np.array([[1.0, 5.0, 2.0]])).tolist()
    [[2.0, 1.0]]
    """

    azimuth: Number = -60.0
    elevation: Number = 20.0

    @property
    def towards(self) -> Float[np.ndarray, "3"]:
        """Unit vector to the viewer."""
        a, e = np.radians(self.azimuth), np.radians(self.elevation)
        return np.array([np.sin(e), np.cos(e) * np.cos(a), np.cos(e) * np.sin(a)])

    @property
    def light(self) -> Float[np.ndarray, "3"]:
        """Unit vector to the lamp that shades the solid, above the viewer's left shoulder."""
        a = np.radians(self.azimuth - 35)
        return np.array([0.6, 0.8 * np.cos(a), 0.8 * np.sin(a)])

    def project(self, points: Float[np.ndarray, "*n 3"]) -> Float[np.ndarray, "*n 2"]:
        """Positions on paper, x to the right and y up, in the solid's own unit."""
        a, e = np.radians(self.azimuth), np.radians(self.elevation)
        right = np.array([0.0, -np.sin(a), np.cos(a)])
        up = np.array([np.cos(e), -np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a)])
        return points @ np.stack([right, up], axis=1)


@dataclass(frozen=True, eq=False)
class Facet:
    """A flat side of a solid: its corners in order round it, and its outward unit normal."""

    corners: Float[np.ndarray, "corner 3"]
    normal: Float[np.ndarray, "3"]


def facets(solid: Polyhedron) -> list[Facet]:
    """The sides of a solid, each joined from triangles that no true edge divides.

    Examples
    --------
    >>> from symrt.gamut.views import Shadow
    >>> cube = Shadow(np.eye(3), np.zeros(3), np.ones(3)).polyhedron()
    >>> len(cube.faces), sorted(len(side.corners) for side in facets(cube))
    (12, [4, 4, 4, 4, 4, 4])
    """
    corners = solid.vertices[solid.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outward = np.sum(normals * (corners.mean(axis=1) - solid.vertices.mean(axis=0)), axis=1)
    normals *= np.where(outward < 0, -1.0, 1.0)[:, None]
    side = _sides(solid)
    return [
        _facet(solid.vertices[np.unique(solid.faces[side == k])], normals[side == k].sum(axis=0))
        for k in range(side.max() + 1)
    ]


def spread(
    wanted: Float[np.ndarray, " label"], gap: float, room: tuple[float, float] = (-math.inf, math.inf)
) -> Float[np.ndarray, " label"]:
    """Positions at least `gap` apart, in the order of those wanted and, together, as near to them as can be.

    Labels that would overlap are pooled and share their mean (the pool-adjacent-violators algorithm).

    Parameters
    ----------
    wanted, gap
        Positions and their least distance, in any one unit.
    room
        The interval that holds all positions; if it is too small, they are equally spaced in it, nearer than `gap`.

    Examples
    --------
    >>> spread(np.array([0.0, 0.2, 5.0]), 1.0).tolist()
    [-0.4, 0.6, 5.0]
    >>> spread(np.array([0.0, 0.2, 5.0]), 1.0, (0.0, 4.0)).tolist()
    [0.0, 1.0, 4.0]
    """
    # Without the gaps, labels in order only have to stay in order.
    low, high = room
    gap = min(gap, (high - low) / max(1, len(wanted) - 1))
    order = np.argsort(wanted, kind="stable")
    free = wanted[order] - gap * np.arange(len(wanted))

    # Pool neighbours that are out of order, as mean and count.
    pools: list[tuple[float, int]] = []
    for value in free.tolist():
        mean, count = value, 1
        while pools and pools[-1][0] > mean:
            before, size = pools.pop()
            mean, count = (before * size + mean * count) / (size + count), size + count
        pools.append((mean, count))

    placed = np.empty(len(wanted))
    level = np.repeat([mean for mean, _ in pools], [count for _, count in pools]) if pools else np.empty(0)
    # Bounded isotonic regression is the unbounded one, clipped.
    placed[order] = np.clip(level, low, high - gap * (len(wanted) - 1)) + gap * np.arange(len(wanted))
    return placed


def _sides(solid: Polyhedron) -> Int[np.ndarray, " face"]:
    """The number of the side that each triangle lies in."""
    # A number for each edge of each triangle, and for each true edge of the solid.
    pairs = np.sort(solid.faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    owner = np.repeat(np.arange(len(solid.faces)), 3)
    size = len(solid.vertices)
    key, true = pairs[:, 0] * size + pairs[:, 1], np.sort(solid.edges, axis=1) @ np.array([size, 1])

    # In a closed solid each edge has two triangles: they are linked where it is no true edge.
    order = np.argsort(key, kind="stable")
    first, second = order[::2], order[1::2]
    inner = ~np.isin(key[first], true)
    count = len(solid.faces)
    links = sparse.coo_array((inner[inner], (owner[first[inner]], owner[second[inner]])), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])


def _facet(corners: Float[np.ndarray, "corner 3"], normal: Float[np.ndarray, "3"]) -> Facet:
    """A side from its corners, which are put in order of their angle round the middle."""
    normal = normal / np.linalg.norm(normal)
    spokes = corners - corners.mean(axis=0)
    along = spokes[0] / np.linalg.norm(spokes[0])
    angle = np.arctan2(spokes @ np.cross(normal, along), spokes @ along)
    return Facet(corners[np.argsort(angle)], normal)


def outline(sides: list[Facet], view: View) -> Float[np.ndarray, "corner 2"]:
    """The contour of a solid on paper."""
    corners = np.vstack([view.project(side.corners) for side in sides])
    return corners[ConvexHull(corners).vertices]


def facing(sides: list[Facet], view: View) -> Bool[np.ndarray, " facet"]:
    """True for each side that the viewer sees from outside."""
    return np.array([side.normal @ view.towards > 0 for side in sides])
