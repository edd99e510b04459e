"""Meshes: Wavefront OBJ files, as triangles in a tree of boxes.

References
----------
.. [1] T. Möller and B. Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", JGT 2(1), 1997, pp. 21-28.
"""

import itertools
import math
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from reference.records import Hit, Shape, Table
from reference.shapes import group
from reference.vectors import Vector, add, cross, dot, rotation, scale, sub, unit


class Corner(NamedTuple):
    """A corner of a triangle."""

    position: Vector
    uv: tuple[float, float]
    normal: Vector | None


def mesh(table: Table, folder: Path) -> Shape:
    turn = rotation(table.get("rotate", (0, 0, 0)))
    size, shift, names = table.get("scale", 1), table.get("translate", (0, 0, 0)), table["material"]

    def placed(corner: Corner) -> Corner:
        normal = None if corner.normal is None else unit(turn(corner.normal))
        return Corner(add(turn(scale(size, corner.position)), shift), corner.uv, normal)

    return boxed(
        [
            triangle(*(placed(corner) for corner in corners), names if isinstance(names, str) else names[name])
            for corners, name in read_obj(folder / table["file"])
        ]
    )


def read_obj(path: Path) -> Iterable[tuple[tuple[Corner, Corner, Corner], str]]:
    """Triangles of a file and the file's name of their material; polygons become fans."""
    positions: list[Vector] = []
    uvs: list[Vector] = []
    normals: list[Vector] = []
    name = ""
    for line in path.read_text().splitlines():
        word, *rest = line.split() or ["#"]
        if word == "v":
            positions.append((float(rest[0]), float(rest[1]), float(rest[2])))
        elif word == "vt":  # v counts up from the bottom in the file, and down from the top here
            uvs.append((float(rest[0]), 1 - float(rest[1]), 0.0))
        elif word == "vn":
            normals.append((float(rest[0]), float(rest[1]), float(rest[2])))
        elif word == "usemtl":
            name = " ".join(rest)
        elif word == "f":
            corners = [_corner(text, positions, uvs, normals) for text in rest]
            for second, third in itertools.pairwise(corners[1:]):
                yield (corners[0], second, third), name


def _corner(text: str, positions: list[Vector], uvs: list[Vector], normals: list[Vector]) -> Corner:
    """From its numbers ``position/uv/normal``, the last two may be missing; they count from 1, or from the end."""
    position, uv, normal = (*text.split("/"), "", "")[:3]

    def pick(items: list[Vector], number: str) -> Vector:
        return items[int(number) - 1 if int(number) > 0 else int(number)]

    u, v, _ = pick(uvs, uv) if uv else (0.0, 0.0, 0.0)
    return Corner(pick(positions, position), (u, v), pick(normals, normal) if normal else None)


class Bounded(NamedTuple):
    """A shape and the box around it."""

    low: Vector
    high: Vector
    shape: Shape


def triangle(a: Corner, b: Corner, c: Corner, material: str) -> Bounded:
    """Möller and Trumbore's test [1]_, with the tolerance that keeps a ray from slipping between two neighbours."""
    origin, edge_b, edge_c = a.position, sub(b.position, a.position), sub(c.position, a.position)
    area = cross(edge_b, edge_c)
    slack = 1e-12

    def hit(start: Vector, direction: Vector, low: float) -> Hit | None:
        across = cross(direction, edge_c)
        volume = dot(edge_b, across)
        if volume == 0:
            return None
        offset = sub(start, origin)
        v = dot(offset, across) / volume
        if v < -slack or v > 1 + slack:
            return None
        sideways = cross(offset, edge_b)
        w = dot(direction, sideways) / volume
        if w < -slack or v + w > 1 + slack:
            return None
        distance = dot(edge_c, sideways) / volume
        if not distance > low:
            return None
        normal = unit(area)
        point = add(origin, add(scale(v, edge_b), scale(w, edge_c)))
        shading = normal
        if a.normal is not None and b.normal is not None and c.normal is not None:
            shading = unit(add(scale(1 - v - w, a.normal), add(scale(v, b.normal), scale(w, c.normal))))
        uv = tuple((1 - v - w) * a.uv[k] + v * b.uv[k] + w * c.uv[k] for k in range(2))
        return Hit(distance, point, normal, shading, uv, (1.0, 1.0), material)  # type: ignore[arg-type]

    corners = [a.position, b.position, c.position]
    return Bounded(tuple(map(min, *corners)), tuple(map(max, *corners)), hit)  # type: ignore[arg-type]


def boxed(parts: list[Bounded]) -> Shape:
    """A tree of boxes, halved at the median along its longest side; a ray asks only the boxes that it passes."""
    return _tree(parts).shape


def _tree(parts: list[Bounded]) -> Bounded:
    low: Vector = tuple(min(part.low[k] for part in parts) for k in range(3))  # type: ignore[assignment]
    high: Vector = tuple(max(part.high[k] for part in parts) for k in range(3))  # type: ignore[assignment]
    if len(parts) > 4:
        axis = max(range(3), key=lambda k: high[k] - low[k])
        ordered = sorted(parts, key=lambda part: part.low[axis] + part.high[axis])
        parts = [_tree(ordered[: len(ordered) // 2]), _tree(ordered[len(ordered) // 2 :])]
    inner = group([part.shape for part in parts])
    margin = 1e-9 * max(map(abs, (*low, *high)))

    def hit(origin: Vector, direction: Vector, least: float) -> Hit | None:
        enter, leave = least, math.inf
        for k in range(3):
            if direction[k] == 0:
                if not low[k] - margin <= origin[k] <= high[k] + margin:
                    return None
                continue
            first, second = (low[k] - margin - origin[k]) / direction[k], (high[k] + margin - origin[k]) / direction[k]
            enter, leave = max(enter, min(first, second)), min(leave, max(first, second))
        return inner(origin, direction, least) if enter <= leave else None

    return Bounded(low, high, hit)
