"""Rays against a hierarchy of boxes, compiled: see `symrt.geometry.bvh` for what is computed."""

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.fast.compiling import compiled
from symrt.fast.pairs import least, most
from symrt.geometry.fast.asking import Floats, Vectors

TAKES = "686c3bd67c847ec1"
LEAF, WAYS, DEEPEST = 4, 8, 20

Families = Float[np.ndarray, "family 6 child"]
Met = Bool[np.ndarray, " child"]
Whole = Int[np.ndarray, " _"]


@compiled()
def _look(family: Float[np.ndarray, "6 child"], ray: Floats, first: float, last: float, met: Met) -> None:
    """Tell of boxes side by side whether the stretch of a ray meets each; one of nan is met by none."""
    for lane in range(met.size):
        enter, leave = first, last
        a, b = (family[0, lane] - ray[0]) * ray[6], (family[3, lane] - ray[3]) * ray[6]
        enter, leave = most(enter, least(a, b)), least(leave, most(a, b))
        a, b = (family[1, lane] - ray[1]) * ray[7], (family[4, lane] - ray[4]) * ray[7]
        enter, leave = most(enter, least(a, b)), least(leave, most(a, b))
        a, b = (family[2, lane] - ray[2]) * ray[8], (family[5, lane] - ray[5]) * ray[8]
        enter, leave = most(enter, least(a, b)), least(leave, most(a, b))
        met[lane] = (family[0, lane] == family[0, lane]) & (enter <= leave + 1e-12 * abs(leave))


@compiled(
    "int64(float64[:, :, ::1], int64[::1], int64[::1], float64[:, :, ::1], float64[:, ::1], float64[:, ::1], "
    "float64[:, ::1], float64[::1], float64[::1], int64[::1], int64[::1])"
)
def walk(
    families: Families,
    starts: Whole,
    order: Whole,
    each: Families,
    low: Vectors,
    high: Vectors,
    inverse: Vectors,
    first: Floats,
    last: Floats,
    ray: Whole,
    number: Whole,
) -> int:
    """Write the pairs of a ray and a box that may meet, as far as there is room, and tell how many there are.

    Families are the root alone, then the children of each node side by side, level by level.
    """
    count, deepest = 0, starts.size - 1
    nodes, levels = np.empty(DEEPEST * WAYS, np.int64), np.empty(DEEPEST * WAYS, np.int64)
    line, met, here = np.empty(9), np.empty(WAYS, np.bool_), np.empty(LEAF, np.bool_)
    for i in range(first.size):
        for axis in range(3):
            line[axis], line[axis + 3], line[axis + 6] = low[axis, i], high[axis, i], inverse[axis, i]
        # Nodes that are met, still to be opened; a single leaf is asked for itself, otherwise its root need not be.
        waiting = 1
        nodes[0], levels[0] = 0, 0
        if deepest == 0:
            _look(families[0], line, first[i], last[i], met)
            waiting = 1 if met[0] else 0
        while waiting > 0:
            waiting -= 1
            node, level = nodes[waiting], levels[waiting]
            if level < deepest:
                _look(families[starts[level] + node], line, first[i], last[i], met)
                for k in range(WAYS):
                    if met[k]:
                        nodes[waiting], levels[waiting] = node * WAYS + k, level + 1
                        waiting += 1
                continue
            if each.shape[0] > 0:
                _look(each[node], line, first[i], last[i], here)
            for k in range(LEAF):
                slot = node * LEAF + k
                if order[slot] >= 0 and (each.shape[0] == 0 or here[k]):
                    if count < ray.size:
                        ray[count], number[count] = i, order[slot]
                    count += 1
    return count
