"""Planes, disks and rectangles, compiled: see `symrt.geometry.flats` for what is computed."""

import numpy as np

from symrt.fast.compiling import compiled
from symrt.fast.pairs import Triple, difference, dot, exact, pair_dot, pair_quotient
from symrt.geometry.fast.asking import (
    ASKED,
    Chosen,
    Constants,
    Floats,
    Vectors,
    Whole,
    answer,
    gather,
    list_open,
)

TAKES = "686c3bd67c847ec1"
ENDLESS, ROUND, CORNERED = 0, 1, 2


@compiled()
def _possible(o: Triple, d: Triple, k: Constants) -> bool:
    """Whether the ray may meet the plane ahead within its reach, by plain arithmetic."""
    m, normal = (o[0] - k[0], o[1] - k[1], o[2] - k[2]), (k[3], k[4], k[5])
    slope = dot(d, normal)
    rough = -dot(m, normal) / slope
    x, y, z = m[0] + rough * d[0], m[1] + rough * d[1], m[2] + rough * d[2]
    room = 1e-8 * (abs(m[0]) + abs(m[1]) + abs(m[2]) + abs(rough))
    across = k[7] + room
    return ((rough >= -room) & (x * x + y * y + z * z <= across * across)) | (abs(slope) <= 1e-6 * k[6])


@compiled()
def _distance(o: Triple, d: Triple, k: Constants) -> float:
    """Signed distance to an oblique plane."""
    point, normal = (k[0], k[1], k[2]), exact((k[3], k[4], k[5]))
    height, slope = pair_dot(difference(o, point), normal), pair_dot(exact(d), normal)
    return -pair_quotient(height, slope) if abs(slope[0]) > 4 * 2.0**-53 * k[6] else np.inf


@compiled()
def _within(t: float, o: Triple, d: Triple, kind: int, k: Constants, low: float) -> float:
    """The distance where it lies ahead and on the part of the plane that is there, else inf."""
    m = (o[0] - k[0]) + t * d[0], (o[1] - k[1]) + t * d[1], (o[2] - k[2]) + t * d[2]
    there = True
    if kind == ROUND:
        there = dot(m, m) <= k[9]
    elif kind == CORNERED:
        u, v = dot(m, (k[9], k[10], k[11])) / k[15], dot(m, (k[12], k[13], k[14])) / k[16]
        there = (abs(u) <= 0.5) & (abs(v) <= 0.5)
    return t if there & (t > low) & (t <= k[8]) else np.inf


@compiled(f"int64(int64, int64, UniTuple(float64, 17), {ASKED})")
def flat(
    kind: int,
    axis: int,
    constants: Constants,
    origin: Vectors,
    direction: Vectors,
    left: Whole,
    low: float,
    any_hit: bool,
    index: int,
    distance: Floats,
    shape: Whole,
    primitive: Whole,
    doubtful: Chosen,
) -> int:
    """Rays against a plane, or the part of it that a disk or a rectangle is; `axis` is −1 if it is oblique."""
    c, t = constants, np.empty(distance.size)
    if axis >= 0:
        for i in range(t.size):
            o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
            t[i] = _within((c[axis] - origin[axis, i]) / direction[axis, i], o, d, kind, c, low)
    else:
        for i in range(t.size):
            o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
            t[i] = np.nan if _possible(o, d, c) else np.inf

        # Those that may meet it, in pairs.
        count = list_open(t, left, any_hit, index, shape, doubtful)
        part, found = gather(origin, direction, doubtful, count), np.empty(count)
        for k in range(count):
            o, d = (part[0, k], part[1, k], part[2, k]), (part[3, k], part[4, k], part[5, k])
            found[k] = _within(_distance(o, d, c), o, d, kind, c, low)
        for k in range(count):
            t[doubtful[k]] = found[k]
    answer(t, left, any_hit, index, distance, shape, primitive, doubtful[:0])
    return 0
