"""Triangles and their hierarchy, compiled: see `symrt.geometry.triangles` and `symrt.geometry.bvh`.

One ray walks down at a time, nearest box first; the eight children of a node, and the four triangles of a leaf, lie
side by side.  A ray turns away from a box whose depth, the least that a point of it has along the ray, is beyond the
crossing found so far.  That leaves out nothing: depths are rounded alike for boxes and corners, and rounding keeps
order, so a box's is no larger than that of any corner in it; and a crossing is never put nearer than the nearest corner
of its triangle.
"""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled
from symrt.fast.pairs import Triple, difference, dot, exact, least, most, pair_dot
from symrt.geometry.fast.asking import ASKED, Chosen, Floats, Vectors, Whole

TAKES = "686c3bd67c847ec1"
LEAF, WAYS, DEEPEST = 4, 8, 128
"""As in the hierarchy; DEEPEST is room for the boxes that wait while a ray walks down through up to 17 levels."""
Family = Float[np.ndarray, "6 8"]
"""The low corners of a node's children, then their high ones."""
Leaf = Float[np.ndarray, "9 4"]
"""The first corners of a leaf's triangles, the second and the third; nan in slots left over."""


@compiled()
def _look(
    family: Family, for_low: Triple, for_high: Triple, inverse: Triple, o: Triple, d: Triple, low: float, depth: Floats
) -> None:
    """The depth of each child's box, inf where the ray beyond `low` does not meet it; a box of nan is met by none."""
    for lane in range(depth.size):
        enter, leave = low, np.inf
        to_low, to_high = (family[0, lane] - for_low[0]) * inverse[0], (family[3, lane] - for_high[0]) * inverse[0]
        enter, leave = most(enter, least(to_low, to_high)), least(leave, most(to_low, to_high))
        to_low, to_high = (family[1, lane] - for_low[1]) * inverse[1], (family[4, lane] - for_high[1]) * inverse[1]
        enter, leave = most(enter, least(to_low, to_high)), least(leave, most(to_low, to_high))
        to_low, to_high = (family[2, lane] - for_low[2]) * inverse[2], (family[5, lane] - for_high[2]) * inverse[2]
        enter, leave = most(enter, least(to_low, to_high)), least(leave, most(to_low, to_high))
        x = least((family[0, lane] - o[0]) * d[0], (family[3, lane] - o[0]) * d[0])
        y = least((family[1, lane] - o[1]) * d[1], (family[4, lane] - o[1]) * d[1])
        z = least((family[2, lane] - o[2]) * d[2], (family[5, lane] - o[2]) * d[2])
        depth[lane] = x + y + z if enter <= leave + 1e-12 * abs(leave) else np.inf


@compiled()
def _edges(leaf: Leaf, o: Triple, axis: int, shear: Triple, met: Whole) -> None:
    """Whether a ray passes through each triangle of a leaf, by its edge functions."""
    x, y = (axis + 1) % 3, (axis + 2) % 3
    forward_o = o[0] if axis == 0 else (o[1] if axis == 1 else o[2])
    x_o = o[0] if x == 0 else (o[1] if x == 1 else o[2])
    y_o = o[0] if y == 0 else (o[1] if y == 1 else o[2])
    for lane in range(met.size):
        forward = leaf[axis, lane] - forward_o
        px, py = (leaf[x, lane] - x_o) - shear[1] * forward, (leaf[y, lane] - y_o) - shear[2] * forward
        forward = leaf[3 + axis, lane] - forward_o
        qx, qy = (leaf[3 + x, lane] - x_o) - shear[1] * forward, (leaf[3 + y, lane] - y_o) - shear[2] * forward
        forward = leaf[6 + axis, lane] - forward_o
        rx, ry = (leaf[6 + x, lane] - x_o) - shear[1] * forward, (leaf[6 + y, lane] - y_o) - shear[2] * forward
        u, v, w = rx * qy - ry * qx, px * ry - py * rx, qx * py - qy * px
        inside = ((u >= 0) & (v >= 0) & (w >= 0)) | ((u <= 0) & (v <= 0) & (w <= 0))
        # Three zeros are a triangle seen from its edge.
        met[lane] = inside & ((u != 0) | (v != 0) | (w != 0))


@compiled()
def _distance(leaf: Leaf, lane: int, normal: Floats, o: Triple, d: Triple) -> float:
    """Signed distance at which a ray that passes through a triangle meets it, inf for a degenerate one."""
    if normal[0] == 0 and normal[1] == 0 and normal[2] == 0:
        return np.inf
    a = dot((leaf[0, lane] - o[0], leaf[1, lane] - o[1], leaf[2, lane] - o[2]), d)
    b = dot((leaf[3, lane] - o[0], leaf[4, lane] - o[1], leaf[5, lane] - o[2]), d)
    c = dot((leaf[6, lane] - o[0], leaf[7, lane] - o[1], leaf[8, lane] - o[2]), d)
    low, high = least(least(a, b), c), most(most(a, b), c)
    unit, corner = exact((normal[0], normal[1], normal[2])), (leaf[0, lane], leaf[1, lane], leaf[2, lane])
    plane = pair_dot(difference(corner, o), unit)[0] / pair_dot(exact(d), unit)[0]
    return least(most(plane if np.isfinite(plane) else low, low), high)


@compiled(
    f"int64(int64[::1], float64[:, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, ::1], float64, {ASKED})"
)
def mesh(
    order: Int[np.ndarray, " slot"],
    root: Float[np.ndarray, "6 8"],
    families: Float[np.ndarray, "node 6 8"],
    leaves: Float[np.ndarray, "leaf 9 4"],
    normals: Float[np.ndarray, "face 3"],
    reach: float,
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
    inner = families.shape[0]
    waiting, depths, depth, met = (
        np.empty(DEEPEST, np.int64),
        np.empty(DEEPEST),
        np.empty(WAYS),
        np.empty(LEAF, np.int32),
    )
    for i in range(distance.size):
        if left[i] == index or (any_hit and shape[i] >= 0):
            continue

        # The ray's own frame, and its origin as the faces of boxes see it, with room for rounding.
        o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        axis = 0 if abs(d[0]) >= abs(d[1]) and abs(d[0]) >= abs(d[2]) else (1 if abs(d[1]) >= abs(d[2]) else 2)
        along, x, y = direction[axis, i], direction[(axis + 1) % 3, i], direction[(axis + 2) % 3, i]
        shear = along, x / along, y / along
        room = 8 * 2.0**-53 * (max(abs(o[0]), abs(o[1]), abs(o[2])) + reach)
        for_low, for_high = (o[0] + room, o[1] + room, o[2] + room), (o[0] - room, o[1] - room, o[2] - room)
        inverse = (
            1 / (d[0] if d[0] != 0 else 1e-290),
            1 / (d[1] if d[1] != 0 else 1e-290),
            1 / (d[2] if d[2] != 0 else 1e-290),
        )
        best, found, bound = np.inf, -1, distance[i]

        # The root is asked only where it is a leaf: what meets one of its children meets it.
        waiting[0], depths[0], count = 0, -np.inf, 1
        if inner == 0:
            _look(root, for_low, for_high, inverse, o, d, low, depth)
            count = 1 if depth[0] < np.inf else 0
        while count:
            count -= 1
            node = waiting[count]
            if depths[count] > bound:
                continue
            if node >= inner:
                leaf = leaves[node - inner]
                _edges(leaf, o, axis, shear, met)
                for lane in range(LEAF):
                    if met[lane]:
                        face = order[LEAF * (node - inner) + lane]
                        t = _distance(leaf, lane, normals[face], o, d)
                        if t > low and t < distance[i] and (t < best or (t == best and face < found)):
                            best, found, bound = t, face, t
                if any_hit and found >= 0:
                    break
                continue
            # Children that are met wait, the nearest on top.
            _look(families[node], for_low, for_high, inverse, o, d, low, depth)
            bottom = count
            for lane in range(WAYS):
                if not depth[lane] <= bound or depth[lane] == np.inf:
                    continue
                at = count
                while at > bottom and depths[at - 1] < depth[lane]:
                    waiting[at], depths[at] = waiting[at - 1], depths[at - 1]
                    at -= 1
                waiting[at], depths[at] = WAYS * node + 1 + lane, depth[lane]
                count += 1
        if found >= 0:
            distance[i], shape[i], primitive[i] = best, index, found
    return 0
