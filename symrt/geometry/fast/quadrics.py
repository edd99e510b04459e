"""Spheres and cylinders, compiled: see `symrt.geometry.sphere` and `symrt.geometry.cylinder` for what is computed."""

import numpy as np

from symrt.fast.compiling import compiled
from symrt.fast.pairs import (
    Pairs,
    Triple,
    difference,
    dot,
    exact,
    least,
    most,
    negative,
    pair_cross,
    pair_dot,
    pair_product,
    pair_sum,
    signed,
)
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
SIDE, BASE, TOP = 0, 1, 2


@compiled()
def _plain_sphere(o: Triple, d: Triple, k: Constants, low: float) -> float:
    """The crossing by plain arithmetic, nan where that is not good enough."""
    m = o[0] - k[0], o[1] - k[1], o[2] - k[2]
    x, y, z = m[1] * d[2] - m[2] * d[1], m[2] * d[0] - m[0] * d[2], m[0] * d[1] - m[1] * d[0]
    square = x * x + y * y + z * z
    size, squared_radius, distance = abs(m[0]) + abs(m[1]) + abs(m[2]), k[4], dot(m, m)
    room = k[7] + 16 * 2.0**-53 * size
    sure = (square <= 0.75 * squared_radius) & (distance >= 4 * squared_radius) & (64 * 2.0**-53 * size <= k[3])
    # Where it is sure, b is not 0.
    a, b = dot(d, d), dot(m, d)
    root = np.sqrt(a * squared_radius - square)
    q = -(b + (root if b > 0 else -root))
    larger, smaller = q / a, (distance - squared_radius) / q
    enter, leave = least(larger, smaller), most(larger, smaller)
    first = enter if enter > low else (leave if leave > low else np.inf)
    return (first if sure else np.nan) if square <= room * room else np.inf


@compiled()
def _careful_sphere(o: Triple, d: Triple, k: Constants, low: float) -> float:
    """The crossing in pairs of floats, nan where their sign is in doubt."""
    radius = k[3]
    m, direction = difference(o, (k[0], k[1], k[2])), exact(d)
    head = m[0][0], m[1][0], m[2][0]
    c = pair_sum(pair_dot(m, m), negative((k[5], k[6])))[0]
    gone = (not c < 0) & (dot(head, d) > 1e-9 * most(most(abs(head[0]), abs(head[1])), abs(head[2])))
    a, b = pair_dot(direction, direction), pair_dot(m, direction)[0]
    across = pair_cross(m, direction)
    value = pair_sum(pair_product(a, (k[5], k[6])), negative(pair_dot(across, across)))[0]
    doubtful = abs(value) <= 2.0**-98 * (np.sqrt(dot(head, head)) + radius) * radius + 2.0**-960
    q = -(b + signed(np.sqrt(value), b))
    larger, smaller = q / a[0], 0.0 if q == 0 else c / q
    enter, leave = least(larger, smaller), most(larger, smaller)
    first = enter if enter > low else (leave if leave > low else np.inf)
    return np.inf if gone else (np.nan if doubtful else (first if value >= 0 else np.inf))


@compiled(f"int64(UniTuple(float64, 8), {ASKED})")
def sphere(
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
    """Rays against a sphere."""
    t = np.empty(distance.size)
    for i in range(t.size):
        o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        t[i] = _plain_sphere(o, d, constants, low)

    # Near the rim, near the surface and from very far away.
    count = list_open(t, left, any_hit, index, shape, doubtful)
    part, found = gather(origin, direction, doubtful, count), np.empty(count)
    for k in range(count):
        o, d = (part[0, k], part[1, k], part[2, k]), (part[3, k], part[4, k], part[5, k])
        found[k] = _careful_sphere(o, d, constants, low)
    for k in range(count):
        t[doubtful[k]] = found[k]

    count = list_open(t, left, any_hit, index, shape, doubtful) if count else 0
    answer(t, left, any_hit, index, distance, shape, primitive, doubtful[:0])
    return count


@compiled()
def _near_cylinder(o: Triple, d: Triple, k: Constants) -> bool:
    """Whether the ray may meet the cylinder, by plain arithmetic."""
    m0, m1, m2 = o[0] - k[0], o[1] - k[1], o[2] - k[2]
    a0, a1, a2, height = k[6], k[7], k[8], k[12]
    size = abs(m0) + abs(m1) + abs(m2)
    x, y, z = d[1] * a2 - d[2] * a1, d[2] * a0 - d[0] * a2, d[0] * a1 - d[1] * a0
    passing = abs(m0 * x + m1 * y + m2 * z)
    by_axis = passing <= k[13] * np.sqrt(x * x + y * y + z * z) + 64 * 2.0**-53 * size * height
    m0, m1, m2 = m0 - a0 / 2, m1 - a1 / 2, m2 - a2 / 2
    x, y, z = m1 * d[2] - m2 * d[1], m2 * d[0] - m0 * d[2], m0 * d[1] - m1 * d[0]
    reach = k[14] + 32 * 2.0**-53 * (size + height)
    return by_axis & (x * x + y * y + z * z <= reach * reach)


@compiled()
def _side(o: Triple, d: Triple, axis: Pairs, k: Constants) -> tuple[float, float]:
    """Where the line enters and leaves the endless cylinder; enter > leave where it misses."""
    m = difference(o, (k[0], k[1], k[2]))
    squared_radius, squared_axis = (k[15], k[16]), (k[17], k[18])
    across, out = pair_cross(exact(d), axis), pair_cross(m, axis)
    a, b = pair_dot(across, across), pair_dot(out, across)[0]
    c = pair_sum(pair_dot(out, out), negative(pair_product(squared_radius, squared_axis)))[0]
    passing = pair_dot(m, across)
    square = pair_sum(pair_product(squared_radius, a), negative(pair_product(passing, passing)))[0]
    root = np.sqrt(square if square >= 0 else 0.0) * np.sqrt(squared_axis[0])
    q = -(b + signed(root, b))
    larger, smaller = q / a[0], 0.0 if q == 0 else c / q
    parallel, missed = a[0] == 0, (not c <= 0) if a[0] == 0 else (not square >= 0)
    enter = np.inf if missed else (-np.inf if parallel else least(larger, smaller))
    leave = -np.inf if missed else (np.inf if parallel else most(larger, smaller))
    return enter, leave


@compiled()
def _slab(o: Triple, d: Triple, axis: Pairs, k: Constants) -> tuple[float, float, float]:
    """Where the line enters and leaves the slab between base and top, and its slope along the axis."""
    slope = pair_dot(exact(d), axis)[0]
    above_base = pair_dot(difference(o, (k[0], k[1], k[2])), axis)[0]
    above_top = pair_dot(difference(o, (k[3], k[4], k[5])), axis)[0]
    to_base, to_top = -above_base / slope, -above_top / slope
    parallel, outside = slope == 0, (slope == 0) & (not ((above_base >= 0) & (above_top <= 0)))
    enter = np.inf if outside else (-np.inf if parallel else least(to_base, to_top))
    leave = -np.inf if outside else (np.inf if parallel else most(to_base, to_top))
    return enter, leave, slope


@compiled()
def _closed(side: tuple[float, float], slab: tuple[float, float, float], low: float) -> tuple[float, int]:
    """First crossing with the solid."""
    enter, leave = most(side[0], slab[0]), least(side[1], slab[1])
    at_entry = enter > low
    first = enter if at_entry else (leave if leave > low else np.inf)
    by_side = (side[0] >= slab[0]) if at_entry else (side[1] <= slab[1])
    cap = BASE if at_entry == (slab[2] > 0) else TOP
    return first if enter <= leave else np.inf, SIDE if by_side else cap


@compiled()
def _open(side: tuple[float, float], slab: tuple[float, float, float], low: float) -> tuple[float, int]:
    """First crossing with the side between the planes."""
    enter = side[0] if (slab[0] <= side[0]) & (side[0] <= slab[1]) & (side[0] > low) else np.inf
    leave = side[1] if (slab[0] <= side[1]) & (side[1] <= slab[1]) & (side[1] > low) else np.inf
    return min(enter, leave), SIDE


@compiled(f"int64(UniTuple(float64, 20), {ASKED})")
def cylinder(
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
    """Rays against a cylinder."""
    c, t, kind = constants, np.empty(distance.size), np.zeros(distance.size, np.int32)
    for i in range(t.size):
        o, d = (origin[0, i], origin[1, i], origin[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        t[i] = np.nan if _near_cylinder(o, d, c) else np.inf

    # Those that may meet it, in pairs.
    count = list_open(t, left, any_hit, index, shape, doubtful)
    part, found, met = gather(origin, direction, doubtful, count), np.empty(count), np.empty(count, np.int32)
    axis = (c[6], c[9]), (c[7], c[10]), (c[8], c[11])
    for k in range(count):
        o, d = (part[0, k], part[1, k], part[2, k]), (part[3, k], part[4, k], part[5, k])
        side, slab = _side(o, d, axis, c), _slab(o, d, axis, c)
        found[k], met[k] = _closed(side, slab, low) if c[19] > 0 else _open(side, slab, low)
    for k in range(count):
        t[doubtful[k]], kind[doubtful[k]] = found[k], met[k]
    answer(t, left, any_hit, index, distance, shape, primitive, kind)
    return 0
