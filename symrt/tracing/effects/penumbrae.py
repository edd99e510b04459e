"""Penumbrae: the share that is seen of a light with an area, from a grid of places on it (an effect of step 1).

A hit that no shape's box can stand before sees all of the light, and costs no ray.  From the others rays go to the
corners of a grid on the light.  Cells of which some corners are seen and others are not are cut in four, and where a
seen corner has an unseen neighbour the border between is bisected: in each cell it is then a straight line between two
edges.  A cell counts by its share of the light's irradiance, ``cosθ cosθ′/d²``.  The reported error is the difference
from the same estimate on the coarser grid, with borders bisected once less; it takes no further ray.  **A blocker that
stands between all corners is missed**, by both.

Without penumbrae all of a light is seen: surfaces are too bright by at most the light that reaches them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import Vectors, dot
from symrt.geometry.meeting import occluded
from symrt.geometry.rays import BLOCK, spawn
from symrt.scene.lights import Illumination, Light
from symrt.scene.outlines import Outline, begins, place
from symrt.scene.records import Scene
from symrt.scene.wide_lights import AreaLight
from symrt.tracing.effects.effect import Call, Effect, Passed
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View, Which

BISECTIONS = 4
"""Halvings of an edge between a seen corner and an unseen one: the border is known to 1/32 of the edge."""
ABOVE = 1e-3
"""Share of a figure's way to the horizon by which places below it are drawn above."""
SHORT = 1e-9
"""Share of the distance by which rays end before the light, so that a shape in its own plane does not hide it."""

Lattice = Bool[np.ndarray, "hit u v"]
Looks = Callable[[Which, Float[np.ndarray, " ray"], Float[np.ndarray, " ray"]], Bool[np.ndarray, " ray"]]
"""For some hits and a place each, by its coordinates, whether the place is seen."""


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  whatever a shape is made of, it hides
    wide = [light for light in scene.lights if isinstance(light, AreaLight) and light.shadows]
    without = "there is no shape" if wide else "no light has an area"
    few, most = sum(light.grid**2 for light in wide), sum(_most(light.grid, light.refinement) for light in wide)
    names = tuple(light.name for light in wide)
    return Call(names if scene.shapes else (), without, rays=f"{few} … {most} a hit", a_hit=few)


def _most(grid: int, refinement: int) -> int:
    """The rays of a hit all of whose corners differ from their neighbours."""
    corners = (grid - 1) * 2**refinement + 1
    return corners**2 + BISECTIONS * 2 * corners * (corners - 1)


@dataclass(frozen=True, eq=False)
class _Grid:
    """Corners of cells on a figure, seen or not, and of each edge between neighbours the share that is seen."""

    seen: Lattice
    along_u: Float[np.ndarray, "hit edge v"]
    along_v: Float[np.ndarray, "hit u edge"]


def _visible(stage: Stage, view: View, light: Light, hit: Which, at: Illumination) -> Passed:
    """The share that is seen of a light with an area from each of the given hits, and its estimated error."""
    figure, (grid, refinement) = _given(at), _fineness(light)
    share, error = np.ones(hit.size), np.zeros(hit.size)

    # The hits before which some shape may stand.
    asked = np.flatnonzero(_doubtful(stage, view, hit, figure))
    cast: list[int] = []
    looks = _looking(stage, view, hit, at, cast)

    # Corners of the grid, and the hits that see some of them only.
    side = np.linspace(-1.0, 1.0, grid)
    u, v = (part.ravel() for part in np.meshgrid(side, side, indexing="ij"))
    seen = looks(np.repeat(asked, u.size), np.tile(u, asked.size), np.tile(v, asked.size))
    seen = seen.reshape(asked.size, grid, grid)
    share[asked] = seen[:, 0, 0]
    mixed = np.flatnonzero((seen != seen[:, :1, :1]).any(axis=(1, 2)))
    asked, seen = asked[mixed], seen[mixed]

    # Cells cut in four, borders bisected, and the shares of the fine grid and of the coarse one.
    for _ in range(refinement):
        seen = _cut(seen, asked, looks)
    fine, coarse = _bisected(seen, asked, looks)
    if seen.shape[1] % 2:
        coarse = _coarser(coarse)
    part, normal = figure.of(asked), view.shading_normal[:, hit[asked]]
    share[asked] = _share(fine, part, normal)
    error[asked] = np.abs(share[asked] - _share(coarse, part, normal))
    return Passed(share, error, rays=sum(cast))


PENUMBRAE = Effect("penumbrae", _call, arriving=_visible, figures=Outline)


def _fineness(light: Light) -> tuple[int, int]:
    if not isinstance(light, AreaLight):
        raise TypeError(f"{light.name} is no light with an area: its samples stand for places")
    return light.grid, light.refinement


def _given(at: Illumination) -> Outline:
    if not isinstance(at.figure, Outline):
        raise TypeError("a sample that stands for no figure has no penumbra: ask for its shadow")
    return at.figure


def _doubtful(stage: Stage, view: View, hit: Which, figure: Outline) -> Bool[np.ndarray, " hit"]:
    """Whether some shape may stand between each hit and some place of the figure, by the boxes that hold the shapes.

    On its way from the figure light, with a share t of the way to go, is within t of a box that holds the figure.
    """
    point, own = view.surface.point[:, hit], view.leaving[0, hit]
    size = np.abs(figure.across) + np.abs(figure.up)
    least, most = figure.centre - size, figure.centre + size
    doubtful = np.zeros(hit.size, dtype=bool)
    for index in range(len(stage.shapes)):
        low, high = (stage.shapes.boxes[end, :, index, None] - point for end in (0, 1))
        # Along each axis: t · most ≥ low and t · least ≤ high.
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            first, last = low / most, high / least
        enter = np.maximum(np.where(most > 0, first, 0.0), np.where(least < 0, last, 0.0)).max(axis=0)
        leave = np.minimum(np.where(most < 0, first, 1.0), np.where(least > 0, last, 1.0)).min(axis=0)
        never = ((most == 0) & (low > 0)) | ((least == 0) & (high < 0))
        # A flat or convex shape never stands before itself.
        doubtful |= ~((enter > leave) | never.any(axis=0)) & (own != index)
    return doubtful


def _looking(stage: Stage, view: View, hit: Which, at: Illumination, cast: list[int]) -> Looks:
    """The function that casts rays from the hits to places on a figure, and notes their numbers in `cast`."""
    figure, middle, horizon = _given(at), at.towards, view.shading_normal[:, hit]
    normal, leaving = view.normal[:, hit], view.leaving[:, hit]
    point, error = view.surface.point[:, hit], view.surface.error[hit]

    def looks(which: Which, u: Float[np.ndarray, " ray"], v: Float[np.ndarray, " ray"]) -> Bool[np.ndarray, " ray"]:
        seen = np.zeros(which.size, dtype=bool)
        for start in range(0, which.size, BLOCK):
            block = slice(start, start + BLOCK)
            here = which[block]
            part = figure.of(here)
            towards = place(part, u[block], v[block])[0]
            towards = _raised(towards, part, horizon.take(here, axis=1), middle, here)
            direction, distance = begins(part, towards)

            # What is behind the true surface is hidden by it.
            above = np.flatnonzero(dot(normal.take(here, axis=1), direction) > 0)
            here = here[above]
            from_here = point.take(here, axis=1), normal.take(here, axis=1), error[here]
            rays = spawn(*from_here, direction.take(above, axis=1), leaving.take(here, axis=1))
            seen[start + above] = ~occluded(stage.shapes, rays, distance[above] * (1 - SHORT))
            cast.append(above.size)
        return seen

    return looks


def _raised(
    towards: Vectors,
    figure: Outline,
    horizon: Vectors,
    middle: Float[np.ndarray, "3 hit"],
    here: Int[np.ndarray, " ray"],
) -> Vectors:
    """Vectors to places on a figure; those below the horizon are drawn up, towards the middle of what is above."""
    height = dot(horizon, towards)
    below = np.flatnonzero(height <= 0)
    if not below.size:
        return towards
    part, way = figure.of(below), middle[:, here[below]]
    inner = way * (dot(part.centre, part.normal) / dot(way, part.normal))
    top = dot(horizon[:, below], inner)
    share = (1 - ABOVE) * top / (top - height[below])
    raised = towards.copy()
    raised[:, below] = inner + share * (towards[:, below] - inner)
    return raised


def _cut(seen: Lattice, asked: Which, looks: Looks) -> Bool[np.ndarray, "hit fine_u fine_v"]:
    """Cut the cells in four whose corners differ: a lattice of half the spacing, on which the other cells are alike."""
    size = 2 * seen.shape[1] - 1
    fine = np.empty((len(seen), size, size), dtype=bool)
    fine[:, ::2, ::2], fine[:, 1::2, 1::2] = seen, seen[:, 1:, 1:]
    fine[:, ::2, 1::2], fine[:, 1::2, ::2] = seen[:, :, 1:], seen[:, 1:, :]

    # New corners: the middle of each such cell, and of its edges.
    corners = seen[:, :-1, :-1], seen[:, 1:, :-1], seen[:, :-1, 1:], seen[:, 1:, 1:]
    differ = np.any([corner != corners[0] for corner in corners[1:]], axis=0)
    new = np.zeros_like(fine)
    new[:, 1::2, 1::2] = differ
    new[:, :-1:2, 1::2] |= differ
    new[:, 2::2, 1::2] |= differ
    new[:, 1::2, :-1:2] |= differ
    new[:, 1::2, 2::2] |= differ
    which, i, j = np.nonzero(new)
    side = np.linspace(-1.0, 1.0, size)
    fine[which, i, j] = looks(asked[which], side[i], side[j])
    return fine


def _bisected(seen: Lattice, asked: Which, looks: Looks) -> tuple[_Grid, _Grid]:
    """The grid with the border found on each edge between a seen corner and an unseen one, and found half as well."""
    side = np.linspace(-1.0, 1.0, seen.shape[1])
    step = side[1] - side[0]
    edges = [(seen[:, :-1, :], seen[:, 1:, :]), (seen[:, :, :-1], seen[:, :, 1:])]
    places = [np.nonzero(one != other) for one, other in edges]
    which, i, j = (np.concatenate(parts) for parts in zip(*places, strict=True))
    on_u = np.arange(which.size) < places[0][0].size
    first = seen[which, i, j]

    # The border is between low and high, in shares of the edge.
    low, high, before = np.zeros(which.size), np.ones(which.size), np.empty(0)
    for _ in range(BISECTIONS):
        before = middle = (low + high) / 2
        u, v = side[i] + np.where(on_u, step * middle, 0.0), side[j] + np.where(on_u, 0.0, step * middle)
        same = looks(asked[which], u, v) == first
        low, high = np.where(same, middle, low), np.where(same, high, middle)

    grids = []
    for border in ((low + high) / 2, before):
        lengths = [(one & other).astype(float) for one, other in edges]
        for length, there, chosen in zip(lengths, places, (on_u, ~on_u), strict=True):
            length[there] = np.where(first, border, 1 - border)[chosen]
        grids.append(_Grid(seen, *lengths))
    return grids[0], grids[1]


def _coarser(grid: _Grid) -> _Grid:
    """The grid of twice the spacing, whose edges are seen as far as their halves are, where their ends differ."""
    seen = grid.seen[:, ::2, ::2]
    halves = [
        (grid.along_u[:, ::2, ::2] + grid.along_u[:, 1::2, ::2]) / 2,
        (grid.along_v[:, ::2, ::2] + grid.along_v[:, ::2, 1::2]) / 2,
    ]
    ends = [(seen[:, :-1, :], seen[:, 1:, :]), (seen[:, :, :-1], seen[:, :, 1:])]
    lengths = (np.where(a != b, half, a & b) for half, (a, b) in zip(halves, ends, strict=True))
    return _Grid(seen, *lengths)


def _share(grid: _Grid, figure: Outline, normal: Vectors) -> Float[np.ndarray, " hit"]:
    """The share that is seen: that of each cell, weighted by the irradiance from its middle."""
    count = grid.along_u.shape[1]
    middle = (2 * np.arange(count) + 1) / count - 1
    seen, whole = np.zeros(len(grid.seen)), np.zeros(len(grid.seen))
    parts = _cells(grid)
    for i, u in enumerate(middle):
        for j, v in enumerate(middle):
            towards, weight = place(figure, np.full(seen.size, u), np.full(seen.size, v))
            weight = weight * np.maximum(dot(towards, normal), 0.0) / np.sqrt(dot(towards, towards))
            seen += weight * parts[:, i, j]
            whole += weight
    # Where no cell's middle is above the horizon all cells count alike.
    return np.where(whole > 0, seen / np.where(whole > 0, whole, 1.0), parts.mean(axis=(1, 2)))


def _cells(grid: _Grid) -> Float[np.ndarray, "hit cell cell"]:
    """The share of each cell that is seen, its border a straight line between two edges.

    One corner is cut off by a triangle; with two neighbours the cell is cut across; two that are opposite are two
    triangles.
    """
    # Corners in turn, and the seen lengths of the edges before and after each.
    corners = [grid.seen[:, :-1, :-1], grid.seen[:, 1:, :-1], grid.seen[:, 1:, 1:], grid.seen[:, :-1, 1:]]
    edges = [grid.along_u[:, :, :-1], grid.along_v[:, 1:, :], grid.along_u[:, :, 1:], grid.along_v[:, :-1, :]]
    number = np.sum(corners, axis=0, dtype=int)
    seen = sum(corners[k] * edges[k - 1] * edges[k] for k in range(4)) / 2
    unseen = sum(~corners[k] * (1 - edges[k - 1]) * (1 - edges[k]) for k in range(4)) / 2
    opposite = corners[0] == corners[2]
    across = np.where(opposite, seen, (sum(edges) - 1) / 2)
    return np.choose(number, [np.zeros_like(across), seen, across, 1 - unseen, np.ones_like(across)])
