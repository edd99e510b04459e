"""Lamps with an area: Lambert's formula for what is above the horizon, times the share that is seen of the lamp.

The share is found on a grid of places, whose cells are cut in four where some of their corners are seen and others are
not, and whose edges are halved four times where their ends differ; between two edges the border is a straight line.
"""

import math
from collections.abc import Callable

from reference.records import Hit, Illumination, Lamp, Table
from reference.vectors import Vector, add, cross, dot, scale, sub, unit

Looks = Callable[[float, float], bool]
"""Whether a place of a lamp is seen, its coordinates from -1 to 1."""
Corner = tuple[int, int]
Place = tuple[float, float]

HALVINGS = 4
BELOW = 1e-3
"""A place below the horizon is drawn up above it, so much farther than onto it."""


def rectangle_lamp(table: Table) -> Lamp:
    u, v = scale(0.5, table["edge_u"]), scale(0.5, table["edge_v"])
    normal = unit(cross(u, v))

    def ways(hit: Hit, free: Callable[[Vector, float], bool]) -> list[Illumination]:
        middle = sub(table["centre"], hit.point)
        around = [add(middle, add(scale(s, u), scale(t, v))) for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        above = clipped(around, hit.shading)
        if dot(middle, normal) >= 0 or len(above) < 3:
            return []
        total = lambert_vector(above)
        total = total if dot(total, hit.shading) > 0 else scale(-1, total)
        towards, irradiance = unit(total), math.sqrt(dot(total, total))

        def place(s: float, t: float) -> Vector:
            there = add(middle, add(scale(s, u), scale(t, v)))
            height = dot(there, hit.shading)
            if height > 0:
                return there
            inner = scale(dot(middle, normal) / dot(towards, normal), towards)
            top = dot(inner, hit.shading)
            return add(inner, scale((1 - BELOW) * top / (top - height), sub(there, inner)))

        def looks(s: float, t: float) -> bool:
            there = place(s, t)
            distance = math.sqrt(dot(there, there))
            direction = scale(1 / distance, there)
            return dot(direction, hit.normal) > 0 and free(direction, distance * (1 - 1e-9))

        def counts(s: float, t: float) -> float:
            there = add(middle, add(scale(s, u), scale(t, v)))
            return max(0.0, dot(there, hit.shading)) * -dot(there, normal) / dot(there, there) ** 2

        share = seen_share(looks, counts, table.get("grid", 3), table.get("refinement", 1))
        return [Illumination(towards, math.inf, irradiance * share)]

    return ways


def clipped(corners: list[Vector], horizon: Vector) -> list[Vector]:
    """Sutherland and Hodgman's algorithm, for one plane through the origin."""
    kept = []
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        above, then = dot(a, horizon), dot(b, horizon)
        if above >= 0:
            kept.append(a)
        if (above >= 0) != (then >= 0):
            kept.append(add(a, scale(above / (above - then), sub(b, a))))
    return kept


def lambert_vector(corners: list[Vector]) -> Vector:
    """Half the sum of the edges' angles, each along the normal of the plane through the edge and the origin."""
    total = (0.0, 0.0, 0.0)
    for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
        across = cross(a, b)
        sine = math.sqrt(dot(across, across))
        if sine > 0:
            total = add(total, scale(math.atan2(sine, dot(a, b)) / sine / 2, across))
    return total


def seen_share(looks: Looks, counts: Callable[[float, float], float], grid: int, refinement: int) -> float:
    """The share that is seen; `counts` weighs the middle of a cell."""
    last = (grid - 1) * 2**refinement
    seen = corners_seen(looks, last, 2**refinement)
    if len(set(seen.values())) == 1:
        return float(seen[0, 0])
    borders: dict[tuple[Corner, Corner], Place] = {}
    part = whole = 0.0
    for i in range(last):
        for j in range(last):
            weight = counts(2 * (i + 0.5) / last - 1, 2 * (j + 0.5) / last - 1)
            part += weight * cell_area(looks, last, seen, borders, (i, j))
            whole += weight
    return part / whole


def corners_seen(looks: Looks, last: int, step: int) -> dict[Corner, bool]:
    """The corners of the finest grid, numbered from 0 to `last`: of a coarse one, and then of cells cut in four."""

    def look(i: int, j: int) -> bool:
        return looks(2 * i / last - 1, 2 * j / last - 1)

    coarse = range(0, last + 1, step)
    seen = {(i, j): look(i, j) for i in coarse for j in coarse}
    if len(set(seen.values())) == 1:
        return seen
    while step > 1:
        half = step // 2
        cells = [(i, j) for i in range(0, last, step) for j in range(0, last, step)]
        mixed = {(i, j) for i, j in cells if len({seen[i + a, j + b] for a in (0, step) for b in (0, step)}) == 2}
        for i, j in cells:
            for new in ((i + a, j + b) for a, b in ((half, half), (half, 0), (half, step), (0, half), (step, half))):
                if (i, j) in mixed:
                    seen[new] = look(*new)
                else:
                    seen.setdefault(new, seen[i, j])
        step = half
    return seen


def cell_area(
    looks: Looks,
    last: int,
    seen: dict[Corner, bool],
    borders: dict[tuple[Corner, Corner], Place],
    first: Corner,
) -> float:
    """The area that is seen of the cell with a first corner; `borders` keeps where edges change."""
    i, j = first
    turn = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
    pieces: list[list[Place]] = [[]]
    for one, other in zip(turn, turn[1:] + turn[:1], strict=True):
        if seen[one]:
            pieces[-1].append(one)
        if seen[one] != seen[other]:
            key = (min(one, other), max(one, other))
            if key not in borders:
                borders[key] = border(looks, last, seen[key[0]], *key)
            pieces[-1].append(borders[key])
            if seen[one]:
                pieces.append([])
    # The last piece goes on in the first.
    if len(pieces) > 1:
        pieces[0] = pieces.pop() + pieces[0]
    return sum(map(polygon_area, pieces))


def border(looks: Looks, last: int, first: bool, one: Corner, other: Corner) -> Place:
    """Where an edge changes, whose first corner is seen or not."""

    def at(share: float) -> Place:
        return (one[0] + share * (other[0] - one[0]), one[1] + share * (other[1] - one[1]))

    low, high = 0.0, 1.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        i, j = at(middle)
        same = looks(2 * i / last - 1, 2 * j / last - 1) == first
        low, high = (middle, high) if same else (low, middle)
    return at((low + high) / 2)


def polygon_area(corners: list[Place]) -> float:
    pairs = zip(corners, corners[1:] + corners[:1], strict=True)
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in pairs) / 2
