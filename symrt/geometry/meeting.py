"""What rays meet first among many shapes, and whether they meet anything (step 1)."""

from collections.abc import Collection, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Int

from symrt import fast
from symrt.arrays import PerRay
from symrt.geometry.culling import gathered
from symrt.geometry.directions import ROOM, whole_rows
from symrt.geometry.rays import Hits, Kernel, Rays, Surface, intersect, leaves, surface


def meet(
    shape: Any,
    index: int,
    rays: Rays,
    hits: Hits,
    *,
    which: Int[np.ndarray, " chosen"] | None = None,
    low: float = 0.0,
    any_hit: bool = False,
) -> None:
    """Write the crossings with a shape into `hits`, where they are nearer than what is there.

    Compiled where that pays, to the same bits (`symrt.fast`).

    Parameters
    ----------
    index
        What the shape is called in `hits`.
    which
        The rays that are asked; all of them if not given.
    any_hit
        Whether one crossing is as good as another: then a ray that has one need not be asked again.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> ray = Rays(origin=np.array([[0.0], [0.0], [3.0]]), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> hits = no_hits(1)
    >>> meet(Sphere((0, 0, 0), 1, "red"), 7, ray, hits)
    >>> hits.distance, hits.shape
    (array([2.]), array([7], dtype=int32))
    """
    # Rays that leave the shape for good are passed over, where they are enough for copying the others to pay: kernels
    # pass over them by themselves.
    if rays.left is not None and (which is not None or fast.kernels(ROOM, 0) is None):
        others = rays.left != index if which is None else rays.left[which] != index
        if np.count_nonzero(others) < 0.9 * others.size:
            which = np.flatnonzero(others) if which is None else which[others]
            if not which.size:
                return

    # The kernel, and NumPy for all rays or for those that it cannot decide.
    part = rays if which is None else rays[which]
    into = hits if which is None else Hits(hits.distance[which], hits.shape[which], hits.primitive[which])
    undecided = _meet_compiled(shape, index, part, into, low, any_hit)
    if undecided is None or undecided.size:
        chosen = slice(None) if undecided is None else undecided
        crossing = intersect(shape, part if undecided is None else part[undecided], low)
        closer = crossing.distance < into.distance[chosen]
        there = np.flatnonzero(closer) if undecided is None else undecided[closer]
        into.distance[there], into.shape[there] = crossing.distance[closer], index
        into.primitive[there] = crossing.primitive[closer]

    # The answers of some of the rays go among those of all.
    if which is not None:
        hits.distance[which], hits.shape[which], hits.primitive[which] = into.distance, into.shape, into.primitive


def _meet_compiled(
    shape: Any, index: int, rays: Rays, hits: Hits, low: float, any_hit: bool
) -> Int[np.ndarray, " ray"] | None:
    """Let the shape's kernel do it, and name the rays that it cannot decide; None where NumPy is to do it all."""
    kernel: Kernel | None = getattr(shape, "kernel", None)
    kernels = kernel and fast.kernels(kernel.room, len(rays))
    if not (kernel and kernels and rays.origin.dtype == rays.direction.dtype == hits.distance.dtype == np.float64):
        return None
    left = np.full(len(rays), -1, np.int32) if rays.left is None else rays.left
    doubtful = np.empty(len(rays), np.int64)
    asked = (whole_rows(rays.origin), whole_rows(rays.direction), left, low, any_hit, index)
    answered = (hits.distance, hits.shape, hits.primitive, doubtful)
    return doubtful[: getattr(kernels, kernel.name)(*kernel.constants, *asked, *answered)]


def no_hits(count: int) -> Hits:
    """Hits of rays that have met nothing yet.

    Examples
    --------
    >>> no_hits(2).distance
    array([inf, inf])
    """
    return Hits(np.full(count, np.inf), np.full(count, -1, np.int32), np.full(count, -1, np.int32))


def nearest(shapes: Sequence[Any], rays: Rays) -> Hits:
    """The nearest crossing of each ray with any shape; of two at the same distance the first in the list.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> near, far = Sphere((0, 0, -3), 1, "red"), Sphere((0, 0, -9), 1, "blue")
    >>> ray = Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> nearest([far, near], ray).shape
    array([1], dtype=int32)
    """
    among, found = gathered(shapes), no_hits(len(rays))
    for block in among.blocks(len(rays)):
        part, hits = rays[block], Hits(found.distance[block], found.shape[block], found.primitive[block])
        for index, which in among.worth_asking(part, np.inf):
            meet(among[index], index, part, hits, which=which)
    return found


def occluded(shapes: Sequence[Any], rays: Rays, limit: PerRay) -> Bool[np.ndarray, " ray"]:
    """Whether anything stands between the start of each ray and the distance `limit`, both ends excluded.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> ball = Sphere((0, 0, -3), 1, "red")
    >>> ray = Rays(origin=np.zeros((3, 1)), direction=np.array([[0.0], [0.0], [-1.0]]))
    >>> occluded([ball], ray, limit=np.array([1.5])), occluded([ball], ray, limit=np.array([np.inf]))
    (array([False]), array([ True]))
    """
    among, blocked = gathered(shapes), np.zeros(len(rays), bool)
    enough = 8 if fast.kernels(ROOM, 0) is None else 2
    for block in among.blocks(len(rays)):
        chosen = np.arange(len(rays))[block]
        part, hits = rays[block], replace(no_hits(chosen.size), distance=limit[chosen])
        for index, which in among.worth_asking(part, limit[chosen]):
            if which is not None:
                meet(among[index], index, part, hits, which=which[hits.shape[which] < 0], any_hit=True)
                continue
            meet(among[index], index, part, hits, any_hit=True)
            hidden = hits.shape >= 0
            # Copying the rays that are left pays once enough of them are done with, if all shapes are asked about all.
            if among.tree is None and np.count_nonzero(hidden) * enough > hidden.size:
                blocked[chosen[hidden]] = True
                chosen, part = chosen[~hidden], part[~hidden]
                hits = replace(no_hits(chosen.size), distance=limit[chosen])
        blocked[chosen[hits.shape >= 0]] = True
    return blocked


def surfaces(shapes: Sequence[Any], rays: Rays, hits: Hits, textured: Collection[int] | None = None) -> Surface:
    """The surface each ray meets, whatever shape it belongs to; zeros for a ray that meets none.

    Parameters
    ----------
    textured
        The shapes whose surface coordinates are asked for, all if not given; those of others are 0.

    Examples
    --------
    >>> from symrt.geometry import Plane, Sphere
    >>> scene = [Sphere((0, 0, -3), 1, "red"), Plane((0, -1, 0), (0, 1, 0), "grey")]
    >>> rays = Rays(np.zeros((3, 2)), np.array([[0.0, 0.0], [0.0, -1.0], [-1.0, 0.0]]))
    >>> surfaces(scene, rays, nearest(scene, rays)).point.T.tolist()
    [[0.0, 0.0, -2.0], [0.0, -1.0, 0.0]]
    """
    count = len(rays)
    point, normal, shading, uv, extent = (np.zeros((rows, count)) for rows in (3, 3, 3, 2, 2))
    whole = Surface(point, normal, shading, uv, extent, np.zeros(count))

    # The rays of each shape that was met, together and in their order.
    order = np.argsort(hits.shape, kind="stable")
    order = order[np.count_nonzero(hits.shape < 0) :]
    first = np.flatnonzero(np.diff(hits.shape[order], prepend=-1))
    for chosen in np.split(order, first)[1:]:
        index = int(hits.shape[chosen[0]])
        shape, plain = shapes[index], textured is not None and index not in textured
        if plain and _surface_compiled(shape, rays, hits, chosen, whole):
            continue
        part = surface(shape, rays[chosen], hits.distance[chosen], hits.primitive[chosen])
        for name in (f.name for f in fields(Surface) if not (plain and f.name == "uv")):
            getattr(whole, name)[..., chosen] = getattr(part, name)
    return whole


def _surface_compiled(shape: Any, rays: Rays, hits: Hits, chosen: Int[np.ndarray, " chosen"], into: Surface) -> bool:
    """Let a kernel write all of a surface but its coordinates, if there is one and it pays."""
    kernel: Kernel | None = getattr(shape, "surface_kernel", None)
    kernels = kernel and fast.kernels(kernel.room, chosen.size)
    if not (kernel and kernels and rays.origin.dtype == rays.direction.dtype == hits.distance.dtype == np.float64):
        return False
    given = whole_rows(rays.origin), whole_rows(rays.direction), hits.distance, chosen
    getattr(kernels, kernel.name)(
        *kernel.constants, *given, into.point, into.normal, into.shading_normal, into.extent, into.error
    )
    return True


def leaving_of(shapes: Sequence[Any], hits: Hits) -> Int[np.ndarray, "2 ray"]:
    """The shape of each hit, where a ray that starts there on the side of its normal leaves it for good, else −1.

    The second row tells the same of the other side.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> shapes = [Sphere((0, 0, -3), 1, "red")]
    >>> leaving_of(shapes, nearest(shapes, Rays(np.zeros((3, 1)), np.array([[0.0], [0.0], [-1.0]])))).tolist()
    [[0], [-1]]
    """
    # The last entry stands for rays that met nothing.
    good = np.array([*map(leaves, shapes), (False, False)]).T
    return np.where(good[:, hits.shape], hits.shape, np.int32(-1))
