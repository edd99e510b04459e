"""Rays against shapes as textbooks have it, compiled and asked as symrt's kernels are: what exactness is measured by.

One precision, one formula: the quadratic's two roots, a plane's quotient, Möller and Trumbore's triangle, slabs without
room for rounding.  The hierarchy, and the way through it, are those of symrt.
"""

import numpy as np
from numba import njit

from symrt.fast.pairs import dot, least, most
from symrt.geometry.fast.asking import ASKED, answer
from symrt.geometry.fast.flats import CORNERED, ROUND
from symrt.geometry.fast.triangles import DEEPEST, LEAF, WAYS


def compiled(signature=None):
    return njit(signature, nogil=True, error_model="numpy", forceinline=signature is None)


@compiled()
def _first(a, b, c, low):
    """The first root of a t² + 2 b t + c beyond `low`."""
    root = np.sqrt(b * b - a * c)
    enter, leave = (-b - root) / a, (-b + root) / a
    return enter if enter > low else (leave if leave > low else np.inf)


@compiled(f"int64(UniTuple(float64, 8), {ASKED})")
def sphere(k, origin, direction, left, low, any_hit, index, distance, shape, primitive, doubtful):
    t = np.empty(distance.size)
    for i in range(t.size):
        d = direction[0, i], direction[1, i], direction[2, i]
        m = origin[0, i] - k[0], origin[1, i] - k[1], origin[2, i] - k[2]
        t[i] = _first(dot(d, d), dot(m, d), dot(m, m) - k[4], low)
    answer(t, left, any_hit, index, distance, shape, primitive, doubtful[:0])
    return 0


@compiled(f"int64(UniTuple(float64, 20), {ASKED})")
def cylinder(k, origin, direction, left, low, any_hit, index, distance, shape, primitive, doubtful):
    t, kind = np.empty(distance.size), np.zeros(distance.size, np.int32)
    axis = k[6] / k[12], k[7] / k[12], k[8] / k[12]
    for i in range(t.size):
        d = direction[0, i], direction[1, i], direction[2, i]
        m = origin[0, i] - k[0], origin[1, i] - k[1], origin[2, i] - k[2]
        slope, above = dot(d, axis), dot(m, axis)
        x, y, z = d[0] - slope * axis[0], d[1] - slope * axis[1], d[2] - slope * axis[2]
        u, v, w = m[0] - above * axis[0], m[1] - above * axis[1], m[2] - above * axis[2]
        a, b, c = x * x + y * y + z * z, x * u + y * v + z * w, u * u + v * v + w * w - k[15]
        root = np.sqrt(b * b - a * c)
        to_base, to_top = -above / slope, (k[12] - above) / slope
        into, out = (to_base, to_top) if slope > 0 else (to_top, to_base)
        enter, leave = most((-b - root) / a, into), least((-b + root) / a, out)
        first = enter if enter > low else (leave if leave > low else np.inf)
        t[i] = first if enter <= leave else np.inf
        side = first == (-b - root) / a if enter > low else first == (-b + root) / a
        kind[i] = 0 if side else (1 if (enter > low) == (slope > 0) else 2)
    answer(t, left, any_hit, index, distance, shape, primitive, kind)
    return 0


@compiled(f"int64(int64, int64, UniTuple(float64, 17), {ASKED})")
def flat(part, axis, k, origin, direction, left, low, any_hit, index, distance, shape, primitive, doubtful):
    t = np.empty(distance.size)
    normal = k[3], k[4], k[5]
    for i in range(t.size):
        d = direction[0, i], direction[1, i], direction[2, i]
        m = origin[0, i] - k[0], origin[1, i] - k[1], origin[2, i] - k[2]
        found = -dot(m, normal) / dot(d, normal)
        p = m[0] + found * d[0], m[1] + found * d[1], m[2] + found * d[2]
        there = True
        if part == ROUND:
            there = dot(p, p) <= k[9]
        elif part == CORNERED:
            u, v = dot(p, (k[9], k[10], k[11])) / k[15], dot(p, (k[12], k[13], k[14])) / k[16]
            there = (abs(u) <= 0.5) & (abs(v) <= 0.5)
        t[i] = found if there & (found > low) else np.inf
    answer(t, left, any_hit, index, distance, shape, primitive, doubtful[:0])
    return 0


@compiled()
def _look(family, inverse, o, low, bound, enters):
    for lane in range(enters.size):
        a, b = (family[0, lane] - o[0]) * inverse[0], (family[3, lane] - o[0]) * inverse[0]
        enter, leave = most(low, least(a, b)), least(bound, most(a, b))
        a, b = (family[1, lane] - o[1]) * inverse[1], (family[4, lane] - o[1]) * inverse[1]
        enter, leave = most(enter, least(a, b)), least(leave, most(a, b))
        a, b = (family[2, lane] - o[2]) * inverse[2], (family[5, lane] - o[2]) * inverse[2]
        enter, leave = most(enter, least(a, b)), least(leave, most(a, b))
        enters[lane] = enter if enter <= leave else np.inf


@compiled()
def _triangles(leaf, o, d, met):
    """Möller and Trumbore: the distance at which a ray meets each triangle of a leaf, inf where it does not."""
    for lane in range(met.size):
        e = leaf[3, lane] - leaf[0, lane], leaf[4, lane] - leaf[1, lane], leaf[5, lane] - leaf[2, lane]
        f = leaf[6, lane] - leaf[0, lane], leaf[7, lane] - leaf[1, lane], leaf[8, lane] - leaf[2, lane]
        p = d[1] * f[2] - d[2] * f[1], d[2] * f[0] - d[0] * f[2], d[0] * f[1] - d[1] * f[0]
        volume = dot(e, p)
        m = o[0] - leaf[0, lane], o[1] - leaf[1, lane], o[2] - leaf[2, lane]
        u = dot(m, p) / volume
        q = m[1] * e[2] - m[2] * e[1], m[2] * e[0] - m[0] * e[2], m[0] * e[1] - m[1] * e[0]
        v = dot(d, q) / volume
        met[lane] = dot(f, q) / volume if (u >= 0) & (v >= 0) & (u + v <= 1) else np.inf


@compiled(
    f"int64(int64[::1], float64[:, ::1], float64[:, :, ::1], float64[:, :, ::1], float64[:, ::1], float64, {ASKED})"
)
def mesh(
    order, root, families, leaves, normals, reach, origin, direction, left, low, any_hit, index, distance, shape,
    primitive, doubtful,
):  # fmt: skip
    inner = families.shape[0]
    waiting, depths, enters, met = np.empty(DEEPEST, np.int64), np.empty(DEEPEST), np.empty(WAYS), np.empty(LEAF)
    for i in range(distance.size):
        if left[i] == index or (any_hit and shape[i] >= 0):
            continue
        o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        inverse = 1 / d[0], 1 / d[1], 1 / d[2]
        found, bound, count = -1, distance[i], 1
        waiting[0], depths[0] = 0, low
        while count:
            count -= 1
            node = waiting[count]
            if depths[count] > bound:
                continue
            if node >= inner:
                _triangles(leaves[node - inner], o, d, met)
                for lane in range(LEAF):
                    if met[lane] > low and met[lane] < bound:
                        found, bound = order[LEAF * (node - inner) + lane], met[lane]
                if any_hit and found >= 0:
                    break
                continue
            _look(families[node], inverse, o, low, bound, enters)
            bottom = count
            for lane in range(WAYS):
                if enters[lane] < np.inf:
                    at = count
                    while at > bottom and depths[at - 1] < enters[lane]:
                        waiting[at], depths[at] = waiting[at - 1], depths[at - 1]
                        at -= 1
                    waiting[at], depths[at] = WAYS * node + 1 + lane, enters[lane]
                    count += 1
        if found >= 0:
            distance[i], shape[i], primitive[i] = bound, index, found
    return 0
