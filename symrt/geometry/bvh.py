"""A bounding-volume hierarchy in arrays: which triangles a ray may meet (step 1).

Triangles are sorted into a binary tree by median splits along the longest side of each node, all nodes of a level at
once; a ray then walks down three levels at a time, through eight children.  A box is tested by slabs, with room for
rounding, so the hierarchy only ever leaves out triangles that the ray cannot meet.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import PerRay
from symrt.geometry.rays import ROUNDING, Rays

LEAF = 4
"""Triangles in a leaf."""

WAYS = 8
"""Children of a node."""


@dataclass(frozen=True, eq=False)
class Tree:
    """Boxes of an eight-way tree, coarse to fine.

    Parameters
    ----------
    order
        The triangle in each slot of the leaves, −1 in slots left over.
    boxes
        For each level its nodes' boxes: low corner, then high corner; left-over nodes are nan, which no ray meets.
    reach
        Size of the largest coordinate.
    """

    order: Int[np.ndarray, " slot"]
    boxes: tuple[Float[np.ndarray, "2 3 _"], ...]
    reach: float


def build(corners: Float[np.ndarray, "3 3 face"]) -> Tree:
    """The hierarchy of triangles given by their corners (corner, axis, face).

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> build(corners).order.tolist()
    [0, -1, -1, -1]
    """
    count = corners.shape[2]
    depth = 0
    while LEAF * WAYS**depth < count:
        depth += 1
    slots = LEAF * WAYS**depth
    box = np.full((2, 3, slots), np.inf)
    box[1] = -np.inf
    box[0, :, :count], box[1, :, :count] = corners.min(axis=0), corners.max(axis=0)
    order = _sorted(box, count, 3 * depth)
    reach = float(np.abs(corners).max())
    box = box[:, :, order]
    boxes = []
    for level in range(depth + 1):
        grouped = box.reshape(2, 3, WAYS**level, -1)
        joined = np.stack([grouped[0].min(axis=2), grouped[1].max(axis=2)])
        boxes.append(np.where(joined[0] <= joined[1], joined, np.nan))
    return Tree(np.where(order < count, order, -1), tuple(boxes), reach)


def _sorted(box: Float[np.ndarray, "2 3 slot"], count: int, levels: int) -> Int[np.ndarray, " slot"]:
    """Slots in the order of the tree: each level halves every node at the median along its longest side."""
    slots = box.shape[2]
    centre = np.full((3, slots), np.inf)
    centre[:, :count] = (box[0, :, :count] + box[1, :, :count]) / 2
    order = np.arange(slots)
    for level in range(levels):
        held = centre[:, order].reshape(3, 2**level, -1)
        filled = np.where(np.isfinite(held), held, np.nan)
        low = np.fmin.reduce(filled, axis=2)
        high = np.fmax.reduce(filled, axis=2)
        side = np.argmax(np.nan_to_num(high - low, nan=0.0), axis=0)
        key = np.take_along_axis(held, side[None, :, None], axis=0)[0]
        within = np.argsort(key, axis=1, kind="stable")
        order = np.take_along_axis(order.reshape(2**level, -1), within, axis=1).ravel()
    return order


def candidates(
    tree: Tree, rays: Rays, low: PerRay, high: PerRay
) -> tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]:
    """Pairs of a ray and a triangle that may meet at a distance from `low` to `high`.

    Examples
    --------
    >>> corners = np.array([[[0.0], [0.0], [0.0]], [[1.0], [0.0], [0.0]], [[0.0], [1.0], [0.0]]])
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> candidates(build(corners), ray, np.array([0.0]), np.array([np.inf]))
    (array([0]), array([0]))
    """
    # A direction of 0 would make 0·∞ on a box's own face; a tiny one decides the same way without it.
    inverse = 1 / np.where(rays.direction == 0, 1e-290, rays.direction)
    # Boxes are widened by what rounding may move the ray aside in the triangle's own test.
    room = 8 * ROUNDING * (np.abs(rays.origin).max(axis=0, initial=0) + tree.reach)
    path = _Path(rays.origin + room, rays.origin - room, inverse, low, high)
    # All rays against each of a few boxes need no indexing, which is dearer than the test itself.
    top = tree.boxes[min(1, len(tree.boxes) - 1)]
    kept = [np.flatnonzero(_meets(top[:, :, k : k + 1], path)) for k in range(top.shape[2])]
    ray, node = np.concatenate(kept), np.repeat(np.arange(len(kept)), [len(k) for k in kept])
    for box in tree.boxes[2:]:
        ray = np.repeat(ray, WAYS)
        node = (node[:, None] * WAYS + np.arange(WAYS)).ravel()
        keep = _meets(box.take(node, axis=2), _Path(*(values.take(ray, axis=-1) for values in path)))
        ray, node = ray[keep], node[keep]
    triangle = tree.order[(node[:, None] * LEAF + np.arange(LEAF)).ravel()]
    filled = triangle >= 0
    return np.repeat(ray, LEAF)[filled], triangle[filled]


class _Path(NamedTuple):
    """Rays as the slab test needs them: origins for the low and for the high face, and the stretch that counts."""

    for_low: Float[np.ndarray, "3 ray"]
    for_high: Float[np.ndarray, "3 ray"]
    inverse: Float[np.ndarray, "3 ray"]
    low: Float[np.ndarray, " ray"]
    high: Float[np.ndarray, " ray"]


def _meets(box: Float[np.ndarray, "2 3 #pair"], path: _Path) -> Bool[np.ndarray, " pair"]:
    """Whether the stretch of each ray meets its box; a box of nan is met by none."""
    enter, leave = path.low, path.high
    with np.errstate(over="ignore", invalid="ignore"):
        for axis in range(3):
            to_low = (box[0, axis] - path.for_low[axis]) * path.inverse[axis]
            to_high = (box[1, axis] - path.for_high[axis]) * path.inverse[axis]
            enter = np.maximum(enter, np.minimum(to_low, to_high))
            leave = np.minimum(leave, np.maximum(to_low, to_high))
        return enter <= leave + 1e-12 * np.abs(leave)
