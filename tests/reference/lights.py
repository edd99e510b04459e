"""Lights: each is a closure that gives the ways on which it reaches a point."""

import math

from reference.records import Illumination, Light, Table
from reference.vectors import Vector, dot, scale, sub, unit


def point_light(table: Table) -> Light:
    def at(point: Vector) -> list[Illumination]:
        to_light = sub(table["position"], point)
        distance = math.sqrt(dot(to_light, to_light))
        return [Illumination(scale(1 / distance, to_light), distance, 1 / distance**2)]

    return at


def directional_light(table: Table) -> Light:
    towards = unit(scale(-1, table["direction"]))
    return lambda _: [Illumination(towards, math.inf, 1.0)]
