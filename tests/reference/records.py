"""Nouns that the other files share: a hit, a light's arrival, a ray sent on, a sample of the film, and a scene."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from reference.vectors import Vector

Spectrum = list[float]
Table = Mapping[str, Any]


class Hit(NamedTuple):
    """A point where a ray meets a shape; `normal` is the surface's own, `shading` that of what it stands for.

    `from_inside` is true where the ray comes from the side that the surface's own normal points away from.
    """

    distance: float
    point: Vector
    normal: Vector
    shading: Vector
    uv: tuple[float, float]
    extent: tuple[float, float]
    material: str
    from_inside: bool = False


class Illumination(NamedTuple):
    """Unit direction to a light, its distance, and the irradiance on what faces it, per unit of its spectrum."""

    direction: Vector
    distance: float
    irradiance: float


class Ray(NamedTuple):
    """A ray that a hit sends on: the formula that multiplies what it brings, its unit direction, and its share.

    The formula is that of the hit's materials in `of`, or of all of them if it is None.
    """

    via: str
    direction: Vector
    weight: float = 1.0
    of: frozenset[str] | None = None


class Sample(NamedTuple):
    """A point of the film, in pixels from the left and from the top of the picture, and its weight in its pixel.

    `lens` is a place on the lens, right and up, in units of its radius.
    """

    across: float
    down: float
    weight: float
    lens: tuple[float, float] = (0.0, 0.0)


Shape = Callable[[Vector, Vector, float], Hit | None]
"""The nearest hit of a ray, given by origin and direction, beyond a distance."""
Light = Callable[[Vector], list[Illumination]]
"""All the ways on which a light reaches a point."""
Lamp = Callable[[Hit, Callable[[Vector, float], bool]], list[Illumination]]
"""The ways on which a lamp with an area reaches a hit, told whether nothing stands in a direction before a distance."""
Texture = Callable[[Hit], dict[str, float]]
"""The weights of materials at a hit."""
Sending = Callable[[Hit, Vector], list[Ray]]
"""The rays that a hit, seen from a direction, sends on."""
Emitting = Callable[[Hit, Vector], dict[str, float]]
"""The radiance that a hit sends towards a direction by itself, per unit of each light's spectrum."""
Film = Callable[[int, int], list[Sample]]
"""The samples of the pixel in a column and a row."""


class Scene(NamedTuple):
    """A scene as closures: a shape answers a ray, a light a point, a texture a hit.

    `sending` are the rules by which hits send rays on, `emitting` those by which they shine; `film` takes the place of
    the camera's regular samples.  `glowing` names the material of each light that surfaces send by themselves;
    `lanterns` are the shapes of lamps that are seen, with the lamp's name for a material: they hide nothing from light;
    `skies` give the radiance of lights from a direction in which nothing is met.
    `beyond` names a spectrum: the radiance that each ray brings which the depth cuts
    off; black if it is None.  Rays that carry less than `least` of what their sample of the film sees are not followed.
    """

    camera: Table
    shapes: list[Shape]
    lights: dict[str, Light]
    ambient: list[str]
    unshadowed: set[str]
    materials: dict[str, Table]
    textures: dict[str, Texture]
    depth: int
    sending: tuple[Sending, ...]
    emitting: tuple[Emitting, ...] = ()
    lamps: Mapping[str, Lamp] = {}
    glowing: Mapping[str, str] = {}
    skies: tuple[Callable[[Vector], dict[str, float]], ...] = ()
    lanterns: tuple[Shape, ...] = ()
    film: Film | None = None
    beyond: str | None = None
    least: float = 0.0
