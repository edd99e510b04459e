"""Rays against triangles (step 1), watertight.

A ray is sheared onto its own axis; then a triangle is met where three edge functions have one sign [1]_.  Triangles
that share an edge compute the very same function with opposite sign, so a ray cannot slip between them, and rounding
cannot turn a sign in a difference of two products, only make it 0, which counts as inside.  The distance comes from the
plane of the triangle with compensated dots: a ray that starts on one side of a triangle and goes away never meets it.

References
----------
.. [1] S. Woop, C. Benthin and I. Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013.
"""

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import PerRay, Point, dot, exact, normalise, pair_cross, pair_dot, two_sum
from symrt.geometry.rays import Crossing, Rays

Corners = Float[np.ndarray, "3 3 face"]
"""Corner, axis, face."""


def unit_normals(corners: Corners) -> Float[np.ndarray, "3 face"]:
    """Unit normals, zero for a degenerate triangle; with exact edges a needle's is as good as any.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[2.0], [0.0], [0.0]], [[0.0], [2.0], [0.0]]])
    >>> unit_normals(corners).T
    array([[0., 0., 1.]])
    """
    cross = pair_cross(two_sum(corners[1], -corners[0]), two_sum(corners[2], -corners[0]))[0]
    degenerate = ~np.any(cross != 0, axis=0)
    unit = normalise(np.where(degenerate, 1.0, cross))
    return np.where(degenerate, 0.0, unit)


def crossings(
    corners: Corners,
    normals: Float[np.ndarray, "3 face"],
    rays: Rays,
    ray: Int[np.ndarray, " pair"],
    triangle: Int[np.ndarray, " pair"],
) -> Float[np.ndarray, " pair"]:
    """Signed distance at which each chosen ray meets the chosen triangle, inf where it does not.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> crossings(corners, unit_normals(corners), ray, np.array([0]), np.array([0]))
    array([3.])
    """
    found = np.full(ray.size, np.inf)
    (u, v, w), depth = _edge_functions(corners, rays, ray, triangle)
    least, most = np.minimum(np.minimum(u, v), w), np.maximum(np.maximum(u, v), w)
    # Three zeros are a triangle seen from its edge.
    met = np.flatnonzero(((least >= 0) | (most <= 0)) & ((least != 0) | (most != 0)))
    if met.size:
        low, high = np.minimum.reduce(depth)[met], np.maximum.reduce(depth)[met]
        plane = _plane_depth(corners[0], normals, rays, ray[met], triangle[met])
        # A grazing ray's quotient is wild where the triangle is not: it lies between its nearest and farthest corner.
        there = np.clip(np.where(np.isfinite(plane), plane, low), low, high)
        found[met] = np.where(normals.take(triangle[met], axis=1).any(axis=0), there, np.inf)
    return found


def first_crossing(
    corners: Corners,
    normals: Float[np.ndarray, "3 face"],
    rays: Rays,
    pairs: tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]],
    low: PerRay,
    high: PerRay,
) -> Crossing:
    """Nearest crossing beyond `low` and up to `high` of rays with triangles, given in pairs; the lower of two alike.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> one = np.array([0]), np.array([0])
    >>> first_crossing(corners, unit_normals(corners), ray, one, np.zeros(1), np.full(1, np.inf)).distance
    array([3.])
    """
    distance, primitive = np.full(len(rays), np.inf), np.full(len(rays), -1, np.int32)
    ray, triangle = pairs
    found = crossings(corners, normals, rays, ray, triangle)
    met = (found > low[ray]) & (found <= high[ray]) & (found < np.inf)
    ray, triangle, found = ray[met], triangle[met], found[met]
    order = np.lexsort((triangle, found, ray))
    ray, triangle, found = ray[order], triangle[order], found[order]
    first = np.flatnonzero(np.diff(ray, prepend=-1))
    distance[ray[first]], primitive[ray[first]] = found[first], triangle[first]
    return Crossing(distance, primitive)


def _edge_functions(
    corners: Corners, rays: Rays, ray: Int[np.ndarray, " pair"], triangle: Int[np.ndarray, " pair"]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The three edge functions of Woop, Benthin and Wald, and the depth of each corner along the ray."""
    # Shear space so that the ray goes along its longest axis.
    direction, origin = rays.direction.take(ray, axis=1), rays.origin.take(ray, axis=1)
    axis = np.argmax(np.abs(direction), axis=0)
    pairs = np.arange(ray.size)
    along = direction[axis, pairs]
    x, y = (axis + 1) % 3, (axis + 2) % 3
    shear_x, shear_y = direction[x, pairs] / along, direction[y, pairs] / along

    # The corners there, and the areas that each edge makes with the ray.
    px, py, depth = [], [], []
    for corner in corners:
        offset = corner.take(triangle, axis=1) - origin
        forward = offset[axis, pairs]
        px.append(offset[x, pairs] - shear_x * forward)
        py.append(offset[y, pairs] - shear_y * forward)
        depth.append(dot(offset, direction))
    weights = [px[j] * py[k] - py[j] * px[k] for j, k in ((2, 1), (0, 2), (1, 0))]
    return weights, depth


def _plane_depth(
    corner: Float[np.ndarray, "3 face"],
    normals: Float[np.ndarray, "3 face"],
    rays: Rays,
    ray: Int[np.ndarray, " pair"],
    triangle: Int[np.ndarray, " pair"],
) -> Float[np.ndarray, " pair"]:
    """Signed distance to the plane of a triangle, with compensated dots."""
    normal, direction = exact(normals.take(triangle, axis=1)), exact(rays.direction.take(ray, axis=1))
    offset = two_sum(corner.take(triangle, axis=1), -rays.origin.take(ray, axis=1))
    return pair_dot(offset, normal)[0] / pair_dot(direction, normal)[0]


def barycentric(
    corner: Float[np.ndarray, "3 3 ray"], normal: Float[np.ndarray, "3 ray"], point: Float[np.ndarray, "3 ray"]
) -> Float[np.ndarray, "3 ray"]:
    """Shares of the three corners in a point of each triangle, clipped to the triangle.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> barycentric(corners, np.array([[0.0], [0.0], [1.0]]), np.array([[0.25], [0.25], [0.0]])).T
    array([[0.5 , 0.25, 0.25]])
    """
    spokes = corner - point
    areas = [np.maximum(dot(np.cross(spokes[j], spokes[k], axis=0), normal), 0.0) for j, k in ((1, 2), (2, 0), (0, 1))]
    total = areas[0] + areas[1] + areas[2]
    return np.stack([np.where(total > 0, a / np.where(total > 0, total, 1.0), 1 / 3) for a in areas])


def blended_normal(
    normals: Float[np.ndarray, "3 3 ray"], weights: Float[np.ndarray, "3 ray"], flat: Float[np.ndarray, "3 ray"]
) -> Float[np.ndarray, "3 ray"]:
    """Vertex normals (axis, corner, ray) blended and normalised; the face's where they cancel.

    Examples
    --------
    >>> normals = np.array([[[0.0], [0.0], [0.0]], [[0.0], [0.0], [0.0]], [[1.0], [1.0], [1.0]]])
    >>> blended_normal(normals, np.full((3, 1), 1 / 3), np.array([[0.0], [0.0], [1.0]])).T
    array([[0., 0., 1.]])
    """
    blend = normals[:, 0] * weights[0] + normals[:, 1] * weights[1] + normals[:, 2] * weights[2]
    return normalise(np.where(np.any(np.abs(blend) > 1e-12, axis=0), blend, flat))


def solid_angle(corners: Corners, point: Point) -> float:
    """Solid angle of all the triangles seen from `point`: ±4π inside a closed mesh, 0 outside [1]_.

    References
    ----------
    .. [1] A. van Oosterom and J. Strackee, "The Solid Angle of a Plane Triangle", IEEE Trans. Biomed. Eng. 30(2), 1983.

    Examples
    --------
    One face of a cube, seen from the cube's centre, in two triangles:

    >>> square = np.array([[[1.0, 1], [-1, -1], [-1, -1]], [[1, 1], [1, 1], [-1, 1]], [[1, 1], [1, -1], [1, 1]]])
    >>> round(abs(solid_angle(square, np.zeros(3))) / (4 * np.pi), 12) == round(1 / 6, 12)
    True
    """
    a, b, c = corners - point.reshape(3, 1)
    la, lb, lc = (np.sqrt(dot(v, v)) for v in (a, b, c))
    volume = dot(a, np.cross(b, c, axis=0))
    angle = 2 * np.arctan2(volume, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return float(angle.sum())


def distance_to(corners: Corners, normals: Float[np.ndarray, "3 face"], point: Point) -> float:
    """Distance from `point` to the nearest of the triangles.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> distance_to(corners, unit_normals(corners), np.array([0.5, -2.0, 0.0]))
    2.0
    """
    spokes = corners - point.reshape(3, 1)
    above = np.any(normals != 0, axis=0)
    nearest = []
    for start, end in zip(spokes, spokes[[1, 2, 0]], strict=True):
        edge = end - start
        size = dot(edge, edge)
        share = np.clip(-dot(start, edge) / np.where(size > 0, size, 1.0), 0.0, 1.0)
        foot = start + share * edge
        nearest.append(dot(foot, foot))
        above &= dot(np.cross(edge, normals, axis=0), start) >= 0
    height = np.where(above, np.abs(dot(spokes[0], normals)), np.inf)
    return float(np.minimum(height, np.sqrt(np.minimum.reduce(nearest))).min())
