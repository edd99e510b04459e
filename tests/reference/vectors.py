"""Vectors of three floats."""

import math
from collections.abc import Callable, Sequence

Vector = tuple[float, float, float]


def add(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def sub(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def scale(k: float, a: Sequence[float]) -> Vector:
    return (k * a[0], k * a[1], k * a[2])


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[float], b: Sequence[float]) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def unit(a: Sequence[float]) -> Vector:
    return scale(1 / math.sqrt(dot(a, a)), a)


def along(origin: Vector, distance: float, direction: Vector) -> Vector:
    return add(origin, scale(distance, direction))


def mirrored(a: Vector, normal: Vector) -> Vector:
    """A direction away from the surface, mirrored about the normal; it points away from the surface again."""
    return sub(scale(2 * dot(a, normal), normal), a)


def rotation(degrees: Sequence[float]) -> Callable[[Vector], Vector]:
    """About x first, then y, then z."""
    (ax, ay, az) = (math.radians(angle) for angle in degrees)

    def turn(p: Vector) -> Vector:
        x, y, z = p
        y, z = y * math.cos(ax) - z * math.sin(ax), y * math.sin(ax) + z * math.cos(ax)
        z, x = z * math.cos(ay) - x * math.sin(ay), z * math.sin(ay) + x * math.cos(ay)
        x, y = x * math.cos(az) - y * math.sin(az), x * math.sin(az) + y * math.cos(az)
        return (x, y, z)

    return turn
