"""Glass: the rays that a smooth surface between air and a medium sends on, by Snell's law and Fresnel's formulas."""

import math

from reference.records import Hit, Ray
from reference.vectors import Vector, add, dot, mirrored, scale, unit


def glass_rays(hit: Hit, to_eye: Vector, index: float) -> list[Ray]:
    """The mirrored ray and the bent one, each with its share of unpolarised light."""
    here, beyond = (index, 1.0) if hit.from_inside else (1.0, index)
    cos_i = dot(hit.shading, to_eye)
    sin_t = here / beyond * math.sqrt(max(0.0, 1 - cos_i * cos_i))
    onward = mirrored(to_eye, hit.shading)
    if sin_t > 1:
        return [Ray("reflected", onward)]
    cos_t = math.sqrt(1 - sin_t * sin_t)
    across = (here * cos_i - beyond * cos_t) / (here * cos_i + beyond * cos_t)
    along = (beyond * cos_i - here * cos_t) / (beyond * cos_i + here * cos_t)
    share = (across**2 + along**2) / 2
    bent = add(scale(-here / beyond, to_eye), scale(here / beyond * cos_i - cos_t, hit.shading))
    return [Ray("reflected", onward, share), Ray("transmitted", unit(bent), 1 - share)]
