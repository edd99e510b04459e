"""Rays against a hierarchy of boxes, compiled: see `symrt.geometry.bvh` for what is computed."""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled
from symrt.fast.pairs import least, most
from symrt.geometry.fast.asking import Floats, Vectors

TAKES = "686c3bd67c847ec1"
LEAF, WAYS, DEEPEST = 4, 8, 20

Boxes = Float[np.ndarray, "6 box"]
Whole = Int[np.ndarray, " _"]


@compiled()
def _meets(
    boxes: Boxes, k: int, low: Vectors, high: Vectors, inverse: Vectors, i: int, first: float, last: float
) -> bool:
    """Whether the stretch of a ray meets a box; one of nan is met by none."""
    enter, leave = first, last
    for axis in range(3):
        to_low = (boxes[axis, k] - low[axis, i]) * inverse[axis, i]
        to_high = (boxes[axis + 3, k] - high[axis, i]) * inverse[axis, i]
        enter, leave = most(enter, least(to_low, to_high)), least(leave, most(to_low, to_high))
    return (boxes[0, k] == boxes[0, k]) & (enter <= leave + 1e-12 * abs(leave))


@compiled(
    "int64(float64[:, ::1], int64[::1], int64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], "
    "float64[:, ::1], float64[::1], float64[::1], int64[::1], int64[::1])"
)
def walk(
    boxes: Boxes,
    starts: Whole,
    order: Whole,
    each: Boxes,
    low: Vectors,
    high: Vectors,
    inverse: Vectors,
    first: Floats,
    last: Floats,
    ray: Whole,
    number: Whole,
) -> int:
    """Write the pairs of a ray and a box that may meet, as far as there is room, and tell how many there are."""
    count, deepest, top = 0, starts.size - 1, min(1, starts.size - 1)
    nodes, levels = np.empty(DEEPEST * WAYS, np.int64), np.empty(DEEPEST * WAYS, np.int64)
    for i in range(first.size):
        # The nodes still to be looked at; a box that is met gives way to its children.
        waiting = 1 if top == 0 else WAYS
        for k in range(waiting):
            nodes[k], levels[k] = k, top
        while waiting > 0:
            waiting -= 1
            node, level = nodes[waiting], levels[waiting]
            if not _meets(boxes, starts[level] + node, low, high, inverse, i, first[i], last[i]):
                continue
            if level < deepest:
                for k in range(WAYS):
                    nodes[waiting + k], levels[waiting + k] = node * WAYS + k, level + 1
                waiting += WAYS
                continue
            for slot in range(node * LEAF, node * LEAF + LEAF):
                met = order[slot] >= 0
                if met and each.shape[1] > 0:
                    met = _meets(each, slot, low, high, inverse, i, first[i], last[i])
                if met:
                    if count < ray.size:
                        ray[count], number[count] = i, order[slot]
                    count += 1
    return count
