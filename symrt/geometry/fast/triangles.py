"""Triangles and their hierarchy, compiled: see `symrt.geometry.triangles` and `symrt.geometry.bvh`.

One ray walks down at a time, nearest box first.  It turns away from a box whose depth, the least that a point of it has
along the ray, is beyond the crossing found so far.  That leaves out nothing: depths are rounded alike for boxes and
corners, and rounding keeps order, so a box's is no larger than that of any corner in it; and a crossing is never put
nearer than the nearest corner of its triangle.
"""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled
from symrt.fast.pairs import Triple, difference, dot, exact, least, most, pair_dot
from symrt.geometry.fast.asking import ASKED, Chosen, Floats, Vectors, Whole

TAKES = "686c3bd67c847ec1"
LEAF, WAYS, DEEPEST = 4, 8, 128
"""As in the hierarchy; DEEPEST is room for the boxes that wait while a ray walks down through up to 17 levels."""
Boxes = Float[np.ndarray, "node 6"]
Corners = Float[np.ndarray, "face 3 3"]
Normals = Float[np.ndarray, "face 3"]


@compiled()
def _meets(box: Floats, for_low: Triple, for_high: Triple, inverse: Triple, low: float) -> bool:
    """Whether the ray beyond `low` meets a box; a box of nan is met by none."""
    enter, leave = low, np.inf
    for axis in range(3):
        to_low = (box[axis] - for_low[axis]) * inverse[axis]
        to_high = (box[3 + axis] - for_high[axis]) * inverse[axis]
        enter, leave = most(enter, least(to_low, to_high)), least(leave, most(to_low, to_high))
    return enter <= leave + 1e-12 * abs(leave)


@compiled()
def _depth(box: Floats, o: Triple, d: Triple) -> float:
    """The least depth of a point in a box, rounded as the depths of corners are."""
    x = min((box[0] - o[0]) * d[0], (box[3] - o[0]) * d[0])
    y = min((box[1] - o[1]) * d[1], (box[4] - o[1]) * d[1])
    z = min((box[2] - o[2]) * d[2], (box[5] - o[2]) * d[2])
    return x + y + z


@compiled()
def _turned(v: Triple, axis: int) -> Triple:
    """A vector's components from `axis` on: forward, x and y of the ray's own frame."""
    if axis == 0:
        return v
    return (v[1], v[2], v[0]) if axis == 1 else (v[2], v[0], v[1])


@compiled()
def _crossing(corners: Floats, normal: Floats, o: Triple, d: Triple, axis: int, shear: Triple) -> float:
    """Signed distance at which a ray meets a triangle, inf where it does not."""
    a = corners[0, 0] - o[0], corners[0, 1] - o[1], corners[0, 2] - o[2]
    b = corners[1, 0] - o[0], corners[1, 1] - o[1], corners[1, 2] - o[2]
    c = corners[2, 0] - o[0], corners[2, 1] - o[1], corners[2, 2] - o[2]
    p, q, r = _turned(a, axis), _turned(b, axis), _turned(c, axis)
    px, py = p[1] - shear[1] * p[0], p[2] - shear[2] * p[0]
    qx, qy = q[1] - shear[1] * q[0], q[2] - shear[2] * q[0]
    rx, ry = r[1] - shear[1] * r[0], r[2] - shear[2] * r[0]
    u, v, w = rx * qy - ry * qx, px * ry - py * rx, qx * py - qy * px
    if not ((u >= 0 and v >= 0 and w >= 0) or (u <= 0 and v <= 0 and w <= 0)):
        return np.inf
    if (u == 0 and v == 0 and w == 0) or (normal[0] == 0 and normal[1] == 0 and normal[2] == 0):
        return np.inf
    low = least(least(dot(a, d), dot(b, d)), dot(c, d))
    high = most(most(dot(a, d), dot(b, d)), dot(c, d))
    unit, corner = exact((normal[0], normal[1], normal[2])), (corners[0, 0], corners[0, 1], corners[0, 2])
    plane = pair_dot(difference(corner, o), unit)[0] / pair_dot(exact(d), unit)[0]
    return least(most(plane if np.isfinite(plane) else low, low), high)


@compiled(f"int64(int64[::1], float64[:, ::1], float64, float64[:, :, ::1], float64[:, ::1], {ASKED})")
def mesh(
    order: Int[np.ndarray, " slot"],
    boxes: Boxes,
    reach: float,
    corners: Corners,
    normals: Normals,
    origin: Vectors,
    direction: Vectors,
    left: Whole,
    low: float,
    any_hit: bool,
    index: int,
    distance: Floats,
    shape: Whole,
    primitive: Whole,
    doubtful: Chosen,  # noqa: ARG001  # none is
) -> int:
    """Rays against the triangles of a mesh."""
    first_leaf = boxes.shape[0] - order.size // LEAF
    waiting, depths = np.empty(DEEPEST, np.int64), np.empty(DEEPEST)
    for i in range(distance.size):
        if left[i] == index or (any_hit and shape[i] >= 0):
            continue

        # The ray's own frame, and its origin as the faces of boxes see it, with room for rounding.
        o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        axis = 0 if abs(d[0]) >= abs(d[1]) and abs(d[0]) >= abs(d[2]) else (1 if abs(d[1]) >= abs(d[2]) else 2)
        turned = _turned(d, axis)
        shear = 0.0, turned[1] / turned[0], turned[2] / turned[0]
        room = 8 * 2.0**-53 * (max(abs(o[0]), abs(o[1]), abs(o[2])) + reach)
        for_low, for_high = (o[0] + room, o[1] + room, o[2] + room), (o[0] - room, o[1] - room, o[2] - room)
        inverse = (
            1 / (d[0] if d[0] != 0 else 1e-290),
            1 / (d[1] if d[1] != 0 else 1e-290),
            1 / (d[2] if d[2] != 0 else 1e-290),
        )
        best, found, bound = np.inf, -1, distance[i]

        # The root is not asked: what meets one of its children meets it.
        waiting[0], depths[0] = 0, -np.inf
        count = 1 if first_leaf > 0 or _meets(boxes[0], for_low, for_high, inverse, low) else 0
        while count:
            count -= 1
            node = waiting[count]
            if depths[count] > bound:
                continue
            if node >= first_leaf:
                first = LEAF * (node - first_leaf)
                for slot in range(first, first + LEAF):
                    face = order[slot]
                    if face < 0:
                        continue
                    t = _crossing(corners[face], normals[face], o, d, axis, shear)
                    if t > low and t < distance[i] and (t < best or (t == best and face < found)):
                        best, found, bound = t, face, t
                if any_hit and found >= 0:
                    break
                continue
            # Children that are met wait, the nearest on top.
            bottom = count
            for child in range(WAYS * node + 1, WAYS * node + 1 + WAYS):
                box = boxes[child]
                if not _meets(box, for_low, for_high, inverse, low):
                    continue
                depth, at = _depth(box, o, d), count
                if depth > bound:
                    continue
                while at > bottom and depths[at - 1] < depth:
                    waiting[at], depths[at] = waiting[at - 1], depths[at - 1]
                    at -= 1
                waiting[at], depths[at] = child, depth
                count += 1
        if found >= 0:
            distance[i], shape[i], primitive[i] = best, index, found
    return 0
