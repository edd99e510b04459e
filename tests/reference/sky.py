"""The sky in bands of elevation: the radiance that rays see, and the light that a hit gets of each band.

The irradiance is an integral over the elevation by Gauss points; along a circle of one elevation it is elementary.
The share that is seen is that of a number of directions, in the middle of cells of equal solid angle.
"""

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from reference.records import Hit, Illumination, Lamp, Table
from reference.vectors import Vector, add, cross, dot, scale, sub, unit

GAUSS = list(zip(*(part.tolist() for part in np.polynomial.legendre.leggauss(40)), strict=True))
GOLDEN = (math.sqrt(5) - 1) / 2


def bands(name: str, table: Table) -> dict[str, tuple[float, float]]:
    """The light of each region, with its lowest and its highest elevation in radians."""
    return {f"{name}_{region}": tuple(map(math.radians, ends)) for region, ends in table["regions"].items()}


def seen_sky(name: str, table: Table) -> Callable[[Vector], dict[str, float]]:
    """The radiance of each region from a direction."""

    def radiance(direction: Vector) -> dict[str, float]:
        height = dot(direction, unit(table.get("up", (0, 1, 0))))
        found = {}
        for light, (low, high) in bands(name, table).items():
            if (height >= math.sin(low) or low <= -math.pi / 2) and (height < math.sin(high) or high >= math.pi / 2):
                found[light] = 1.0
        return found

    return radiance


def sky_lamps(name: str, table: Table) -> dict[str, Lamp]:
    """The regions as lamps."""
    return {light: band_lamp(low, high, table) for light, (low, high) in bands(name, table).items()}


def band_lamp(low: float, high: float, table: Table) -> Lamp:
    up, north = unit(table.get("up", (0, 1, 0))), table.get("north", (0, 0, -1))
    north = unit(sub(north, scale(dot(north, up), up)))
    east = cross(north, up)
    share_of_all = (math.sin(high) - math.sin(low)) / 2
    directions = places(low, high, max(16, round(table.get("samples", 256) * share_of_all)))
    towards = [
        add(
            scale(math.sqrt(1 - s * s), add(scale(math.sin(a), east), scale(math.cos(a), north))),
            scale(s, up),
        )
        for a, s in directions
    ]

    def ways(hit: Hit, free: Callable[[Vector, float], bool]) -> list[Illumination]:
        whole = sum(max(0.0, dot(hit.shading, way)) for way in towards)
        seen = sum(
            dot(hit.shading, way)
            for way in towards
            if dot(hit.shading, way) > 0 and dot(hit.normal, way) > 0 and free(way, math.inf)
        )
        lit = irradiance(low, high, dot(hit.shading, up))
        return [Illumination(hit.shading, math.inf, lit * (seen / whole if whole else 1.0))]

    return ways


def places(low: float, high: float, count: int) -> list[tuple[float, float]]:
    """Azimuths and sines of elevations in the middle of cells, row by row."""
    bottom, top = math.sin(low), math.sin(high)
    rows = max(1, round((high - low) / math.sqrt(2 * math.pi * (top - bottom) / count)))
    along = max(1, round(count / rows))
    return [
        (2 * math.pi * (k + row * GOLDEN % 1) / along, bottom + (top - bottom) * (row + 0.5) / rows)
        for row in range(rows)
        for k in range(along)
    ]


def irradiance(low: float, high: float, b: float) -> float:
    """Irradiance of a surface whose normal has the cosine b to the way up, from all between two elevations."""
    h = math.sqrt(max(0.0, 1 - b * b))
    steep = math.atan2(h, abs(b))
    ends = sorted({low, high, *(e for e in (-steep, steep) if low < e < high)})

    def circle(e: float) -> float:
        upright, level = b * math.sin(e), h * math.cos(e)
        if upright >= level:
            return 2 * math.pi * upright
        if upright <= -level:
            return 0.0
        half = math.acos(-upright / level)
        return 2 * (half * upright + level * math.sin(half))

    total = 0.0
    for start, end in pairwise(ends):
        middle, half = (start + end) / 2, (end - start) / 2
        for x, weight in GAUSS:
            # Where the horizon touches a circle the integrand has the slope of a square root: t smooths it.
            t = math.pi / 2 * x
            e = middle + half * math.sin(t)
            total += weight * math.pi / 2 * half * math.cos(t) * circle(e) * math.cos(e)
    return total
