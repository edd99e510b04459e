"""Disks and spheres that shine: the irradiance of a surface, and by brute force the share of it that is not hidden."""

import math
from collections.abc import Callable, Iterator

from reference.lamps import clipped, lambert_vector
from reference.records import Hit, Illumination, Lamp, Table
from reference.vectors import Vector, add, cross, dot, scale, sub, unit

SIDES = 512
"""Corners of the finer of two polygons in place of a disk."""
RINGS, RAYS = 24, 96
"""Places at which a lamp is looked at that something hides."""


def sphere_lamp(table: Table) -> Lamp:
    """Lambert's cosine over the cap of directions, as far as it is above the horizon.

    The closed form is that of S. Lagarde and C. de Rousiers, "Moving Frostbite to Physically Based Rendering",
    SIGGRAPH 2014 course notes, listing 9.
    """

    def ways(hit: Hit, free: Callable[[Vector, float], bool]) -> list[Illumination]:
        middle = sub(table["centre"], hit.point)
        square = table["radius"] ** 2 / dot(middle, middle)
        cosine = dot(unit(middle), hit.shading)
        sine = math.sqrt(1 - cosine**2)
        if square >= 1 or (cosine < 0 and cosine**2 >= square):
            return []
        if cosine**2 >= square:
            irradiance = math.pi * square * cosine
        else:
            x = math.sqrt(1 / square - 1)
            y = -x * cosine / sine
            root = sine * math.sqrt(1 - y * y)
            irradiance = (cosine * math.acos(y) - x * root) * square + math.atan(root / x)

        # The disk in which the cone of directions ends, where it touches the sphere.
        far = math.sqrt(dot(middle, middle))
        away = scale(-1, unit(middle))
        disk = scale(1 - square, middle), table["radius"] * math.sqrt(1 - square), away
        share = seen_share(hit, free, *disk, lambda d: nearer(d, middle, table["radius"], far))
        return [Illumination(hit.shading, math.inf, irradiance * share)]

    return ways


def disk_lamp(table: Table) -> Lamp:
    """Lambert's formula for two polygons of the disk's area at its corners, and what they tend to.

    The error of a polygon falls with the square of its sides: a third of the difference is taken off.
    """
    normal, radius = unit(table["normal"]), table["radius"]

    def ways(hit: Hit, free: Callable[[Vector, float], bool]) -> list[Illumination]:
        middle = sub(table["centre"], hit.point)
        if dot(middle, normal) >= 0:
            return []
        coarse, fine = (
            abs(dot(lambert_vector(above), hit.shading)) if len(above) > 2 else 0.0
            for sides in (SIDES // 2, SIDES)
            for above in [clipped(polygon(middle, normal, radius, sides), hit.shading)]
        )
        share = seen_share(hit, free, middle, radius, normal, lambda d: math.sqrt(dot(d, d)))
        return [Illumination(hit.shading, math.inf, (fine + (fine - coarse) / 3) * share)]

    return ways


def nearer(direction: Vector, middle: Vector, radius: float, far: float) -> float:
    """The distance at which a sphere begins in a direction."""
    along = dot(unit(direction), middle)
    return along - math.sqrt(max(0.0, radius**2 - (far**2 - along**2)))


def polygon(middle: Vector, normal: Vector, radius: float, sides: int) -> list[Vector]:
    """The corners of a regular polygon on a circle."""
    u, v = axes(normal)
    turns = [2 * math.pi * k / sides for k in range(sides)]
    return [add(middle, add(scale(radius * math.cos(t), u), scale(radius * math.sin(t), v))) for t in turns]


def axes(normal: Vector) -> tuple[Vector, Vector]:
    u = unit(cross(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.5 else (0.0, 1.0, 0.0)))
    return u, cross(normal, u)


def places(middle: Vector, radius: float, normal: Vector) -> Iterator[Vector]:
    """Places on a disk that stand for equal areas."""
    u, v = axes(normal)
    for ring in range(RINGS):
        for ray in range(RAYS):
            r, t = radius * math.sqrt((ring + 0.5) / RINGS), 2 * math.pi * (ray + ring / 2) / RAYS
            yield add(middle, add(scale(r * math.cos(t), u), scale(r * math.sin(t), v)))


def seen_share(
    hit: Hit,
    free: Callable[[Vector, float], bool],
    middle: Vector,
    radius: float,
    normal: Vector,
    begins: Callable[[Vector], float],
) -> float:
    """The share of the irradiance that nothing hides: 1 unless one of eight places on the border is hidden."""
    border = [place for place in polygon(middle, normal, radius, 8) if dot(place, hit.shading) > 0]
    if all(free(unit(place), begins(place) * (1 - 1e-9)) for place in border):
        return 1.0
    seen = whole = 0.0
    for place in places(middle, radius, normal):
        counts = max(0.0, dot(place, hit.shading)) * max(0.0, -dot(place, normal)) / dot(place, place) ** 2
        whole += counts
        if counts and free(unit(place), begins(place) * (1 - 1e-9)):
            seen += counts
    return seen / whole if whole else 0.0
