"""Two views of a gamut in few dimensions: step 4 of the paper, its Figure 1.

For k < K basis vectors there are two different objects.  The *slice* ``{c : lower <= B_kᵀ c <= upper}`` is a cut; the
*shadow* ``B_k [lower, upper]`` is a projection, a zonotope with the columns of B_k as its edges [1]_.  The slice lies
in the shadow, and no spectrum of the gamut is ever drawn outside the shadow.

References
----------
.. [1] G. M. Ziegler, "Lectures on Polytopes", Springer 1995, §7.3.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from symrt.arrays import Spectrum

FLAT = 1e-9
"""Faces whose planes differ by less are one face, and rows of B_k that lie in a plane up to this share do."""

Vectors = Float[np.ndarray, "k band"]
Coordinates = Float[np.ndarray, "point k"]


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex solid in three dimensions.

    Parameters
    ----------
    vertices
        Its corners.
    faces
        Triangles, as numbers of their corners.
    edges
        Only true edges: those between triangles of one face are left out.
    volume
        Its volume.
    """

    vertices: Float[np.ndarray, "vertex 3"]
    faces: Int[np.ndarray, "face 3"]
    edges: Int[np.ndarray, "edge 2"]
    volume: float


@dataclass(frozen=True, eq=False)
class Slice:
    """Coordinates in k basis vectors whose spectra, with all other coordinates zero, are in the gamut.

    Examples
    --------
    >>> square = Slice(np.array([[0.6, 0.8]]), np.zeros(2), np.ones(2))
    >>> square.contains(np.array([[1.25], [1.26]]))
    array([ True, False])
    """

    vectors: Vectors
    lower: Spectrum
    upper: Spectrum

    def contains(self, coordinates: Coordinates) -> Bool[np.ndarray, " point"]:
        """Whether each point is in the slice."""
        spectra = coordinates @ self.vectors
        return ((self.lower <= spectra) & (spectra <= self.upper)).all(axis=1)

    def polyhedron(self) -> Polyhedron:
        """The slice as a solid, for k = 3."""
        _check_three(self.vectors)
        planes = np.hstack([self.vectors.T, -self.upper[:, None]])
        halfspaces = np.vstack([planes, np.hstack([-self.vectors.T, self.lower[:, None]])])
        return convex_solid(HalfspaceIntersection(halfspaces, self._centre(halfspaces)).intersections)

    def _centre(self, halfspaces: Float[np.ndarray, "halfspace 4"]) -> Float[np.ndarray, "3"]:
        """The point farthest from all planes: centre of the largest sphere inside."""
        normals = halfspaces[:, :-1]
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        best = linprog([0, 0, 0, -1], np.hstack([normals, lengths]), -halfspaces[:, -1], bounds=[(None, None)] * 4)
        if best.status != 0 or best.x[-1] <= 0:
            raise ValueError(
                "the slice has no inside: no spectrum of three components is in this gamut; draw the shadow"
            )
        return np.array(best.x[:3])


@dataclass(frozen=True, eq=False)
class Shadow:
    """The first k coordinates of all spectra of the gamut.

    Examples
    --------
    >>> square = Shadow(np.array([[0.6, 0.8]]), np.zeros(2), np.ones(2))
    >>> square.support(np.array([[1.0], [-1.0]])).round(12).tolist()
    [1.4, 0.0]
    """

    vectors: Vectors
    lower: Spectrum
    upper: Spectrum

    def support(self, directions: Coordinates) -> Float[np.ndarray, " point"]:
        """The largest inner product of each direction with a point of the shadow: a sum over bands."""
        along = directions @ self.vectors
        return np.where(along > 0, along * self.upper, along * self.lower).sum(axis=1)

    def polyhedron(self) -> Polyhedron:
        """The shadow as a solid, for k = 3.

        Every corner is the farthest point along some direction.  On each face, spanned by two edges, those are told
        apart by a second direction within the face, and then by a third along one of the edges.
        """
        _check_three(self.vectors)

        # The shadow is a sum of segments, one a band: keep those that have a length.
        edges = ((self.upper - self.lower) * self.vectors).T
        edges = edges[np.linalg.norm(edges, axis=1) > 0]
        if np.linalg.matrix_rank(edges, rtol=FLAT) < 3:
            raise ValueError(
                "the shadow is flat: the gamut differs in too few bands; draw that of another device or model"
            )

        # Every pair of segments that are not parallel spans a face, with a normal.
        first, second = (index.ravel() for index in np.indices((len(edges), len(edges))))
        normals = np.cross(edges[first], edges[second])
        spanned = np.linalg.norm(normals, axis=1) > FLAT * np.linalg.norm(edges[first], axis=1) * np.linalg.norm(
            edges[second], axis=1
        )
        normals, along = normals[spanned], edges[first[spanned]]

        # Collect the corners: each takes every segment from the end that lies farther out.
        sides = [_sides(axis, edges) for axis in (normals, np.cross(normals, along), along)]
        corners = []
        for one, two, three in np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T:
            signs = np.where(sides[0] != 0, one * sides[0], np.where(sides[1] != 0, two * sides[1], three * sides[2]))
            corners.append(signs @ edges / 2)

        # Equal corners of different faces are told apart by rounding alone, which is taken away.
        middle = self.vectors @ ((self.lower + self.upper) / 2)
        return convex_solid(np.unique(np.vstack(corners).round(12), axis=0) + middle)


def _sides(axes: Float[np.ndarray, "pair 3"], edges: Float[np.ndarray, "edge 3"]) -> Int[np.ndarray, "pair edge"]:
    """The side of each plane to which each edge points, 1 or -1; 0 within it, up to rounding."""
    along = axes @ edges.T
    size = np.linalg.norm(axes, axis=1)[:, None] * np.linalg.norm(edges, axis=1)
    return np.where(np.abs(along) <= FLAT * size, 0, np.sign(along)).astype(int)


def convex_solid(points: Float[np.ndarray, "point 3"]) -> Polyhedron:
    """The smallest convex solid that holds some points.

    Examples
    --------
    >>> cube = convex_solid(np.array(np.meshgrid([0.0, 1], [0, 1], [0, 1])).reshape(3, 8).T)
    >>> len(cube.faces), len(cube.edges), round(cube.volume, 12)
    (12, 12, 1.0)
    """
    hull = ConvexHull(points)
    number = np.full(len(points), -1)
    number[hull.vertices] = np.arange(len(hull.vertices))
    apart = np.abs(hull.equations[:, None] - hull.equations[hull.neighbors]).max(axis=2) > FLAT
    # The neighbour k of a triangle lies across from its corner k.
    opposite = np.array([[1, 2], [2, 0], [0, 1]])
    edges = np.sort(hull.simplices[:, opposite][apart], axis=1)
    return Polyhedron(
        vertices=points[hull.vertices],
        faces=number[hull.simplices],
        edges=number[np.unique(edges, axis=0)],
        volume=float(hull.volume),
    )


def _check_three(vectors: Vectors) -> None:
    if len(vectors) != 3:
        raise ValueError(
            f"k = {len(vectors)}: only three dimensions can be drawn as a solid; use slice(3) or shadow(3)"
        )
