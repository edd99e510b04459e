"""Shapes that rays cannot meet are passed over, before any of the rays is looked at (step 1).

Every shape has a box that holds it.  Of a few shapes each is left out where the box that holds all origins and
directions of a batch tells that none of its rays passes; of many a hierarchy tells, ray by ray, which to ask.  Boxes
are wider than what they hold by more than rounding, so that what is found is the same, bit for bit.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, singledispatch
from typing import Any

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt import fast
from symrt.arrays import PerRay
from symrt.geometry import bvh
from symrt.geometry.directions import ROOM
from symrt.geometry.rays import BLOCK, ROUNDING, Rays

FEW = 24
"""Up to as many shapes each is asked about by itself: walking through a hierarchy costs about as much as they do."""
CHEAP = 1 << 15
"""Pairs of a ray and a shape that kernels tell in the time in which culling finds out which shapes may be left out."""
WIDER = 1e-9
"""Share of its size by which a box is wider than its shape."""

Corners = Float[np.ndarray, "2 3"]
Asked = tuple[int, Int[np.ndarray, " chosen"] | None]


@singledispatch
def bounds(shape: object) -> Corners:  # noqa: ARG001 (registered for each shape)
    """The low and the high corner of a box that holds the shape; infinite where it has no end.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> bounds(Sphere(centre=(1, 0, 0), radius=1, material="red")).tolist()
    [[0.0, -1.0, -1.0], [2.0, 1.0, 1.0]]
    """
    # A shape of somebody's own may be anywhere.
    return np.array([[-np.inf] * 3, [np.inf] * 3])


@dataclass(frozen=True, eq=False)
class Shapes(Sequence[Any]):
    """Shapes in the order of a scene, and the boxes that hold them.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> len(Shapes((Sphere((0, 0, 0), 1, "red"), Sphere((9, 0, 0), 1, "blue"))))
    2
    """

    every: tuple[Any, ...]

    def __len__(self) -> int:
        return len(self.every)

    def __getitem__(self, index: Any) -> Any:
        return self.every[index]

    def __getstate__(self) -> dict[str, Any]:
        """The shapes alone: what was computed from them need not travel to another process."""
        return {"every": self.every}

    @cached_property
    def boxes(self) -> Float[np.ndarray, "2 3 shape"]:
        """The low and the high corners of all boxes, wider than the shapes by more than rounding."""
        boxes = np.array([bounds(shape) for shape in self.every]).reshape(-1, 2, 3).transpose(1, 2, 0)
        ends = np.isfinite(boxes)
        known = np.where(ends, boxes, 0.0)
        room = WIDER * (known[1] - known[0]).max(axis=0) + 64 * ROUNDING * np.abs(known).max(axis=(0, 1))
        return np.where(ends, known + room * np.array([-1.0, 1.0])[:, None, None], boxes)

    @cached_property
    def ended(self) -> Int[np.ndarray, " shape"]:
        """The shapes that have an end everywhere."""
        return np.flatnonzero(np.isfinite(self.boxes).all(axis=(0, 1)))

    @cached_property
    def tree(self) -> bvh.Tree | None:
        """A hierarchy of the boxes of those; None where they are few."""
        return bvh.build(*self.boxes[:, :, self.ended], dear=True) if len(self.ended) > FEW else None

    def blocks(self, count: int) -> Iterator[slice]:
        """Parts of as many rays as stay in the cache; all at once where a hierarchy or kernels go through them."""
        size = BLOCK if self.tree is None and fast.kernels(ROOM, 0) is None else max(1, count)
        return (slice(start, start + size) for start in range(0, count, size))

    def worth_asking(self, rays: Rays, limit: PerRay | float) -> Iterator[Asked]:
        """Those `asked`; or all of them, where kernels ask sooner than it is found out which may be left out."""
        if self.tree is None and len(rays) * len(self) < CHEAP and fast.kernels(ROOM, 0) is not None:
            return ((index, None) for index in range(len(self)))
        return self.asked(rays, limit)

    def asked(self, rays: Rays, limit: PerRay | float) -> Iterator[Asked]:
        """The shapes, in their order, that some of the rays may meet before a distance, and which those rays are.

        Rays are not named where all of them are meant.

        Examples
        --------
        >>> from symrt.geometry import Sphere
        >>> shapes = Shapes((Sphere((0, 0, -3), 1, "red"), Sphere((0, 0, 3), 1, "blue")))
        >>> ray = Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]]))
        >>> list(shapes.asked(ray, np.inf))
        [(0, None)]
        """
        if not len(rays):
            return
        if self.tree is None:
            yield from ((int(index), None) for index in np.flatnonzero(_may_meet(self.boxes, rays, limit)))
            return

        # Pairs of rays and shapes from the hierarchy, sorted by shape.
        before = np.broadcast_to(limit, len(rays)) * (1 + WIDER)
        ray, number = bvh.candidates(self.tree, rays, np.zeros(len(rays)), before)
        shape = self.ended[number]
        order = np.argsort(shape, kind="stable")
        ray, shape = ray[order], shape[order]
        first = np.flatnonzero(np.diff(shape, prepend=-1))
        parts = np.split(ray, first)[1:]
        by_shape = dict(zip(shape[first].tolist(), parts, strict=True))
        endless = np.setdiff1d(np.arange(len(self)), self.ended).tolist()
        for index in sorted({*by_shape, *endless}):
            yield index, by_shape.get(index)


def gathered(shapes: Sequence[Any]) -> Shapes:
    """A list of shapes as one record; gather those of a scene once.

    Examples
    --------
    >>> len(gathered([]))
    0
    """
    return shapes if isinstance(shapes, Shapes) else Shapes(tuple(shapes))


def _may_meet(boxes: Float[np.ndarray, "2 3 shape"], rays: Rays, limit: PerRay | float) -> Bool[np.ndarray, " shape"]:
    """Whether some ray may pass through each box: by the interval of all origins, and that of all directions."""
    start, end = rays.origin.min(axis=1)[:, None], rays.origin.max(axis=1)[:, None]
    least, most = rays.direction.min(axis=1)[:, None], rays.direction.max(axis=1)[:, None]
    reach = np.abs(np.where(np.isfinite(boxes), boxes, 0.0)).max(axis=(0, 1))
    room = 64 * ROUNDING * (max(float(np.abs(start).max()), float(np.abs(end).max())) + reach)
    low, high = boxes[0] - end - room, boxes[1] - start + room

    # Along an axis on which all rays go the same way: when the first may enter, when the last has left.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        rising, falling = least > 0, most < 0
        near, far = np.where(falling, -high, low), np.where(falling, -low, high)
        slow, fast = np.where(falling, -most, least), np.where(falling, -least, most)
        enter = np.where(near > 0, near / fast, 0.0)
        leave = np.where(far >= 0, far / slow, -1.0)
        enter = np.where(rising | falling, enter, 0.0).max(axis=0) * (1 - WIDER)
        leave = np.where(rising | falling, leave, np.inf).min(axis=0, initial=np.max(limit)) * (1 + WIDER)

        # In that time the rays pass through the box on every axis.
        from_here = np.where(least < 0, leave * least, enter * least)
        to_there = np.where(most > 0, leave * most, enter * most)
        before = to_there + WIDER * np.abs(to_there) < low
        beyond = from_here - WIDER * np.abs(from_here) > high
    # What overflowed on the way compares as neither, and is asked about.
    return ~(enter > leave) & ~(before | beyond).any(axis=0)
