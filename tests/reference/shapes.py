"""Shapes: each is a closure that answers "the nearest hit beyond `low`, or None"."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from reference.records import Hit, Shape, Table
from reference.vectors import Vector, add, along, cross, dot, rotation, scale, sub, unit


def sphere(table: Table) -> Shape:
    centre, radius = table["centre"], table["radius"]
    pole = unit(table.get("pole", (0, 1, 0)))
    meridian = table.get("meridian", (0, 0, 1))
    meridian = unit(sub(meridian, scale(dot(meridian, pole), pole)))
    east = cross(pole, meridian)

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        between = sub(centre, origin)
        middle = dot(between, direction)
        # The squared distance from the centre to the line, from the perpendicular: no cancellation.
        perpendicular = sub(between, scale(middle, direction))
        inside = radius * radius - dot(perpendicular, perpendicular)
        if inside < 0:
            return None
        half = math.sqrt(inside)
        distance = next((t for t in (middle - half, middle + half) if t > low), None)
        if distance is None:
            return None
        normal = unit(sub(along(origin, distance, direction), centre))
        longitude = math.atan2(dot(normal, east), dot(normal, meridian))
        latitude = math.atan2(dot(normal, pole), math.hypot(dot(normal, east), dot(normal, meridian)))
        uv = ((longitude / (2 * math.pi) + 0.5) % 1.0, 0.5 - latitude / math.pi)
        point = along(centre, radius, normal)
        extent = (2 * math.pi * radius, math.pi * radius)
        return Hit(distance, point, normal, normal, uv, extent, table["material"])

    return hit


def flat(
    point: Sequence[float], normal: Vector, material: str, where: Callable[[Vector], tuple[Any, Any] | None]
) -> Shape:
    """Part of a plane: `where` gives uv and extent of an offset from `point`, or None outside the part."""

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        slope = dot(direction, normal)
        if slope == 0:
            return None
        distance = dot(sub(point, origin), normal) / slope
        if not distance > low:
            return None
        met = along(origin, distance, direction)
        place = where(sub(met, point))
        return None if place is None else Hit(distance, met, normal, normal, *place, material)

    return hit


def frame(normal: Vector) -> tuple[Vector, Vector]:
    """The u and v axes of a plane: from the z axis, or from the x axis where the normal is mostly along z."""
    sizes = [abs(x) for x in normal]
    helper = (1.0, 0.0, 0.0) if sizes[2] == max(sizes) else (0.0, 0.0, 1.0)
    u = unit(cross(helper, normal))
    return u, cross(normal, u)


def plane(table: Table) -> Shape:
    normal = unit(table["normal"])
    u, v = frame(normal)
    return flat(table["point"], normal, table["material"], lambda p: ((dot(p, u), dot(p, v)), (1.0, 1.0)))


def disk(table: Table) -> Shape:
    normal = unit(table["normal"])
    u, v = frame(normal)
    radius = table["radius"]

    def where(p: Vector) -> tuple[Any, Any] | None:
        return ((dot(p, u), dot(p, v)), (1.0, 1.0)) if dot(p, p) <= radius * radius else None

    return flat(table["centre"], normal, table["material"], where)


def rectangle(table: Table) -> Shape:
    edge_u, edge_v = table["edge_u"], table["edge_v"]
    normal = unit(cross(edge_u, edge_v))
    corner = sub(table["centre"], scale(0.5, add(edge_u, edge_v)))
    # Oblique edges are allowed: solve p = a edge_u + b edge_v by the reciprocal vectors.
    area = dot(cross(edge_u, edge_v), normal)
    for_u, for_v = scale(1 / area, cross(edge_v, normal)), scale(1 / area, cross(normal, edge_u))
    extent = (math.hypot(*edge_u), math.hypot(*edge_v))

    def where(p: Vector) -> tuple[Any, Any] | None:
        a, b = dot(p, for_u), dot(p, for_v)
        return ((a, b), extent) if 0 <= a <= 1 and 0 <= b <= 1 else None

    return flat(corner, normal, table["material"], where)


def cylinder(table: Table) -> Shape:
    base, top, radius = table["base"], table["top"], table["radius"]
    axis, height = unit(sub(top, base)), math.dist(base, top)
    u, v = frame(axis)
    caps = []
    if table.get("capped", True):
        for centre, outward in ((base, scale(-1, axis)), (top, axis)):
            caps.append(disk({"centre": centre, "normal": outward, "radius": radius, "material": table["material"]}))

    def side(origin: Vector, direction: Vector, low: float) -> Hit | None:
        start, across = sub(origin, base), sub(direction, scale(dot(direction, axis), axis))
        out = sub(start, scale(dot(start, axis), axis))
        a, b, c = dot(across, across), dot(across, out), dot(out, out) - radius * radius
        if a == 0 or b * b < a * c:
            return None
        q = -(b + math.copysign(math.sqrt(b * b - a * c), b))
        for distance in sorted((q / a, c / q) if q else (0.0, 0.0)):
            p = along(start, distance, direction)
            along_axis = dot(p, axis)
            if distance > low and 0 <= along_axis <= height:
                normal = unit(sub(p, scale(along_axis, axis)))
                turn = math.atan2(dot(normal, v), dot(normal, u)) / (2 * math.pi) + 0.5
                extent = (2 * math.pi * radius, height)
                uv = (turn % 1.0, 1 - along_axis / height)
                return Hit(distance, along(origin, distance, direction), normal, normal, uv, extent, table["material"])
        return None

    return group([side, *caps])


def box(table: Table) -> Shape:
    """Six walls; u runs to the right and v downwards on each, seen from outside."""
    turn, middle, size = rotation(table.get("rotate", (0, 0, 0))), table["centre"], table["size"]
    names = table["material"]
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    to_the_right = {"front": (x, y), "back": (scale(-1, x), y), "right": (scale(-1, z), y), "left": (z, y)}
    seen = {**to_the_right, "top": (x, scale(-1, z)), "bottom": (x, z)}

    def wall(face: str) -> Shape:
        right, up = seen[face]
        out, wide, high = cross(right, up), abs(dot(right, size)), abs(dot(up, size))
        centre = add(middle, turn(scale(0.5 * abs(dot(out, size)), out)))
        right, up = turn(right), turn(up)

        def where(p: Vector) -> tuple[Any, Any] | None:
            u, v = dot(p, right) / wide + 0.5, 0.5 - dot(p, up) / high
            return ((u, v), (wide, high)) if 0 <= u <= 1 and 0 <= v <= 1 else None

        return flat(centre, turn(out), names if isinstance(names, str) else names.get(face, names.get("others")), where)

    return group([wall(face) for face in seen])


def group(shapes: list[Shape]) -> Shape:
    """The nearest hit of several shapes."""

    def hit(origin: Vector, direction: Vector, low: float) -> Hit | None:
        hits = [found for shape in shapes if (found := shape(origin, direction, low)) is not None]
        return min(hits, key=lambda found: found.distance, default=None)

    return hit
