"""A bounding-volume hierarchy in arrays: which of many boxes, of triangles or of shapes, a ray may meet (step 1).

Boxes are sorted into a binary tree by median splits along the longest side of each node, all nodes of a level at
once; a ray then walks down three levels at a time, through eight children.  A box is tested by slabs, with room for
rounding, so the hierarchy only ever leaves out what the ray cannot meet.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt import fast
from symrt.arrays import PerRay
from symrt.geometry.rays import ROUNDING, Rays

LEAF = 4
"""Boxes in a leaf."""

WAYS = 8
"""Children of a node."""


Pairs = tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]
"""Rays, and what each of them may meet, by number."""
Kept = tuple[Int[np.ndarray, " kept"], Int[np.ndarray, " kept"]]
"""Some of those."""


@dataclass(frozen=True, eq=False)
class Tree:
    """Boxes of an eight-way tree, coarse to fine.

    Parameters
    ----------
    order
        The number of the box in each slot of the leaves, −1 in slots left over.
    boxes
        For each level its nodes' boxes: low corner, then high corner; left-over nodes are nan, which no ray meets.
    reach
        Size of the largest coordinate.
    each
        The box in each slot, nan in slots left over, where it pays to test them too: what they hold costs more.
    """

    order: Int[np.ndarray, " slot"]
    boxes: tuple[Float[np.ndarray, "2 3 _"], ...]
    reach: float
    each: Float[np.ndarray, "2 3 slot"] | None = None

    @cached_property
    def flat(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The tree as its kernel takes it: families of boxes, the first of each level, the order, the slots' boxes.

        A family is the children of a node side by side; the root is one of its own.
        """
        root = np.full((1, 6, WAYS), np.nan)
        root[0, :, 0] = self.boxes[0].ravel()
        families = [root, *(box.reshape(6, -1, WAYS).transpose(1, 0, 2) for box in self.boxes[1:])]
        starts = np.cumsum([1, *(len(family) for family in families[1:])])
        each = np.empty((0, 6, LEAF)) if self.each is None else self.each.reshape(6, -1, LEAF).transpose(1, 0, 2)
        joined = np.ascontiguousarray(np.concatenate(families))
        return joined, starts, np.ascontiguousarray(self.order), np.ascontiguousarray(each)


def build(low: Float[np.ndarray, "3 box"], high: Float[np.ndarray, "3 box"], *, dear: bool = False) -> Tree:
    """The hierarchy of boxes given by their low and high corners, all of them finite.

    Parameters
    ----------
    dear
        Whether what a box holds costs more to ask about than the box does.

    Examples
    --------
    >>> build(low=np.zeros((3, 1)), high=np.ones((3, 1))).order.tolist()
    [0, -1, -1, -1]
    """
    # Slots for eight children a node; those left over hold a box that is inside out.
    count = low.shape[1]
    depth = 0
    while LEAF * WAYS**depth < count:
        depth += 1
    slots = LEAF * WAYS**depth
    box = np.full((2, 3, slots), np.inf)
    box[1] = -np.inf
    box[0, :, :count], box[1, :, :count] = low, high

    # Each level's boxes hold those of its children.
    order = _sorted(box, count, 3 * depth)
    reach = float(max(np.abs(low).max(), np.abs(high).max()))
    box = box[:, :, order]
    boxes = []
    for level in range(depth + 1):
        grouped = box.reshape(2, 3, WAYS**level, -1)
        joined = np.stack([_over_last(np.minimum, grouped[0]), _over_last(np.maximum, grouped[1])])
        boxes.append(np.where(joined[0] <= joined[1], joined, np.nan))
    each = np.where(box[0] <= box[1], box, np.nan) if dear else None
    return Tree(np.where(order < count, order, -1), tuple(boxes), reach, each)


def _sorted(box: Float[np.ndarray, "2 3 slot"], count: int, levels: int) -> Int[np.ndarray, " slot"]:
    """Slots in the order of the tree: each level halves every node at the median along its longest side."""
    slots = box.shape[2]
    centre = np.full((3, slots), np.inf)
    centre[:, :count] = (box[0, :, :count] + box[1, :, :count]) / 2
    order = np.arange(slots)
    for level in range(levels):
        held = centre[:, order].reshape(3, 2**level, -1)
        filled = np.where(np.isfinite(held), held, np.nan)
        low, high = _over_last(np.fmin, filled), _over_last(np.fmax, filled)
        side = np.argmax(np.nan_to_num(high - low, nan=0.0), axis=0)
        key = np.take_along_axis(held, side[None, :, None], axis=0)[0]
        within = np.argsort(key, axis=1, kind="stable")
        order = np.take_along_axis(order.reshape(2**level, -1), within, axis=1).ravel()
    return order


def _over_last(least: np.ufunc, values: Float[np.ndarray, "*rest size"]) -> Float[np.ndarray, "*rest"]:
    """The least, or the largest, along the last axis, whose size is a power of two: by halves, each one long loop."""
    values = np.ascontiguousarray(values)
    while values.shape[-1] > 1:
        values = least(values[..., ::2], values[..., 1::2])
    return values[..., 0]


def candidates(
    tree: Tree, rays: Rays, low: PerRay, high: PerRay
) -> tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]:
    """Pairs of a ray and a box, by number, that may meet at a distance from `low` to `high`.

    Examples
    --------
    >>> tree = build(low=np.zeros((3, 1)), high=np.ones((3, 1)))
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> candidates(tree, ray, np.array([0.0]), np.array([np.inf]))
    (array([0]), array([0]))
    """
    path = _path(tree, rays, low, high)
    if kernels := fast.kernels("symrt.geometry.fast.boxes", WAYS * len(rays)):
        return _walked(kernels.walk, tree, path)

    # All rays against each of a few boxes need no indexing, which is dearer than the test itself.
    top = tree.boxes[min(1, len(tree.boxes) - 1)]
    kept = [np.flatnonzero(_meets(top[:, :, k : k + 1], path)) for k in range(top.shape[2])]
    ray, node = np.concatenate(kept), np.repeat(np.arange(len(kept)), [len(k) for k in kept])
    for box in tree.boxes[2:]:
        ray = np.repeat(ray, WAYS)
        node = (node[:, None] * WAYS + np.arange(WAYS)).ravel()
        keep = _meets(box.take(node, axis=2), _Path(*(values.take(ray, axis=-1) for values in path)))
        ray, node = ray[keep], node[keep]
    # The leaves' boxes, each by itself if that pays.
    ray, slot = np.repeat(ray, LEAF), (node[:, None] * LEAF + np.arange(LEAF)).ravel()
    if tree.each is not None:
        keep = _meets(tree.each.take(slot, axis=2), _Path(*(values.take(ray, axis=-1) for values in path)))
        ray, slot = ray[keep], slot[keep]
    number = tree.order[slot]
    return ray[number >= 0], number[number >= 0]


def _walked(
    walk: Callable[..., int], tree: Tree, path: "_Path"
) -> tuple[Int[np.ndarray, " pair"], Int[np.ndarray, " pair"]]:
    """The same pairs from the compiled kernel, in the order of the rays."""
    rays = [np.ascontiguousarray(values) for values in path]
    room = 2 * rays[-1].size
    while True:
        pairs = np.empty((2, room), dtype=np.int64)
        count = walk(*tree.flat, *rays, *pairs)
        if count <= room:
            return pairs[0, :count], pairs[1, :count]
        room = count


def confirmed(tree: Tree, rays: Rays, pairs: Pairs, low: PerRay, high: PerRay) -> Kept:
    """Those of some pairs of a ray and a box whose leaf the ray meets: the candidates among them, in a flat tree.

    Examples
    --------
    >>> tree = build(low=np.zeros((3, 1)), high=np.ones((3, 1)))
    >>> ray = Rays(origin=np.array([[0.2], [0.2], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> confirmed(tree, ray, (np.array([0]), np.array([0])), np.array([0.0]), np.array([np.inf]))
    (array([0]), array([0]))
    """
    ray, number = pairs
    slot = np.argsort(tree.order, kind="stable")[np.count_nonzero(tree.order < 0) :]
    box = tree.boxes[-1].take(slot[number] // LEAF, axis=2)
    path = _path(tree, rays, low, high)
    keep = _meets(box, _Path(*(values.take(ray, axis=-1) for values in path)))
    return ray[keep], number[keep]


class _Path(NamedTuple):
    """Rays as the slab test needs them: origins for the low and for the high face, and the stretch that counts."""

    for_low: Float[np.ndarray, "3 ray"]
    for_high: Float[np.ndarray, "3 ray"]
    inverse: Float[np.ndarray, "3 ray"]
    low: Float[np.ndarray, " ray"]
    high: Float[np.ndarray, " ray"]


def _path(tree: Tree, rays: Rays, low: PerRay, high: PerRay) -> _Path:
    # A direction of 0 would make 0·∞ on a box's own face; a tiny one decides the same way without it.
    inverse = 1 / np.where(rays.direction == 0, 1e-290, rays.direction)
    # Boxes are widened by what rounding may move the ray aside in the test of what is inside.
    room = 8 * ROUNDING * (np.abs(rays.origin).max(axis=0, initial=0) + tree.reach)
    return _Path(rays.origin + room, rays.origin - room, inverse, low, high)


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
