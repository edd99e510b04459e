"""Rectangles, disks and spheres that shine: radiance L, the same from every place and in every direction (step 1).

Their symbol stands for the radiance L.  A diffuser gets the irradiance n·E from the vector irradiance E in closed form
(`symrt.scene.irradiance`), times the share that is seen of the light; a material with highlights gets the light from
Gauss points on it.  A light is seen in the picture, in mirrors and through glass if it is to be: `visible`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal

import numpy as np

from symrt.arrays import PerRay, dot, length, normalise
from symrt.errors import hinting, refuse, shown
from symrt.geometry import Disk, Rectangle, Sphere, Triple
from symrt.geometry.flats import plane_axes
from symrt.geometry.records import LARGEST, column, moved
from symrt.scene.checks import Number, check_name, check_number, check_triple, check_whole, floats, settle
from symrt.scene.figures import as_a_whole, drawn_place, gauss_points, perpendicular
from symrt.scene.lights import Illumination, Nearest, Points, Via
from symrt.scene.outlines import DARK, Outline

SQUARE = 1e-6
"""Largest cosine between edges that are perpendicular."""


@hinting
@dataclass(frozen=True)
class RectangleLight:
    """A rectangle that shines to the side of its normal, edge_u × edge_v; its symbol is its radiance.

    It casts no shadow, and is not seen in the picture unless it is to be.

    Parameters
    ----------
    centre, edge_u, edge_v
        Its middle and its full edges, which are perpendicular.
    shadows
        True if other shapes block the light.
    grid
        Corners across the grid of places from which the share that is seen is found.
    refinement
        Number of times that cells of the grid are cut in four where some of their corners are seen and others are not.
    points
        Gauss points across it, for materials with highlights.
    visible
        True if it is seen, also in mirrors and through glass; its back is black then.  In one plane with a wall the
        wall is seen: let it hang a little before it.

    Examples
    --------
    A ceiling without end, almost, gives a floor the irradiance π:

    >>> ceiling = RectangleLight("lamp", centre=(0, 1, 0), edge_u=(1e9, 0, 0), edge_v=(0, 0, 1e9))
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> ceiling.facing(np.zeros((3, 1)), up).falloff.round(6).tolist()
    [3.141593]
    """

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    name: str
    centre: Triple
    edge_u: Triple
    edge_v: Triple
    shadows: bool = True
    grid: int = field(default=3, kw_only=True)
    refinement: int = field(default=1, kw_only=True)
    points: int = field(default=4, kw_only=True)
    visible: bool = field(default=False, kw_only=True)
    type: Literal["rectangle"] = field(default="rectangle", kw_only=True)

    def __post_init__(self) -> None:
        edges = [fault for key in ("edge_u", "edge_v") for fault in _edge_faults(key, getattr(self, key))]
        square = [] if edges else _square_faults(self)
        refuse([*check_name("name", self.name), *check_triple("centre", self.centre), *edges, *square, *_counts(self)])
        settle(self, centre=floats(self.centre), edge_u=floats(self.edge_u), edge_v=floats(self.edge_v))

    @property
    def shape(self) -> Rectangle:
        """The rectangle that is seen."""
        return Rectangle(self.centre, self.edge_u, self.edge_v, self.name)

    def outline(self, points: Points) -> Outline:
        """The rectangle itself, as vectors from each point."""
        u, v = column(self.edge_u), column(self.edge_v)
        normal = normalise(np.cross(normalise(u), normalise(v), axis=0))
        return Outline(column(self.centre) - points, u / 2, v / 2, normal, circular=False)

    def facing(self, points: Points, normals: Points) -> Illumination:
        """One sample that stands for all of it: its vector irradiance."""
        return as_a_whole(self.outline(points), normals)

    def drawn(self, points: Points, u: PerRay, v: PerRay) -> Illumination:
        """One of its places for each point, right on average."""
        return drawn_place(self.outline(points), 2 * u - 1, 2 * v - 1)

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """Its Gauss points, which materials with highlights are lit by."""
        return tuple(gauss_points(self.outline(points), self.points))

    def moved(self, by: Triple) -> "RectangleLight":
        """The light with its centre moved."""
        return replace(self, centre=moved(self.centre, np.array(by, dtype=float)))

    def white(self, target: Triple) -> float:
        """E/π for a diffuser that faces its vector irradiance."""
        return _white(self, target)

    def bound(self, nearest: Nearest) -> float:
        """Its area over the square of the smallest distance at which a surface may be, or 2π for each of its places."""
        u, v = length(column(self.edge_u))[0], length(column(self.edge_v))[0]
        return _bound(self, float(u * v), nearest(np.array(self.centre)) - float(np.hypot(u, v)) / 2)


@hinting
@dataclass(frozen=True)
class DiskLight:
    """A disk that shines to the side of its normal; its symbol is its radiance.

    It casts no shadow, and is not seen in the picture unless it is to be.  The other fields are those of
    `RectangleLight`.

    Examples
    --------
    A disk of radius r at height h gives a floor below its middle π r²/(h² + r²):

    >>> disk = DiskLight("lamp", centre=(0, 2, 0), normal=(0, -1, 0), radius=1)
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> (disk.facing(np.zeros((3, 1)), up).falloff / np.pi).round(12).tolist()
    [0.2]
    """

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    name: str
    centre: Triple
    normal: Triple
    radius: Number
    shadows: bool = True
    grid: int = field(default=3, kw_only=True)
    refinement: int = field(default=1, kw_only=True)
    points: int = field(default=4, kw_only=True)
    visible: bool = field(default=False, kw_only=True)
    type: Literal["disk"] = field(default="disk", kw_only=True)

    def __post_init__(self) -> None:
        places = [*check_triple("centre", self.centre), *check_triple("normal", self.normal, direction=True)]
        refuse([*check_name("name", self.name), *places, *_radius_faults(self.radius), *_counts(self)])
        settle(self, centre=floats(self.centre), normal=floats(self.normal), radius=float(self.radius))

    @property
    def shape(self) -> Disk:
        """The disk that is seen."""
        return Disk(self.centre, self.normal, self.radius, self.name)

    def outline(self, points: Points) -> Outline:
        """The disk itself, as vectors from each point."""
        normal = normalise(column(self.normal))
        u, v = plane_axes(normal)
        return Outline(column(self.centre) - points, self.radius * u, self.radius * v, normal, circular=True)

    def facing(self, points: Points, normals: Points) -> Illumination:
        """One sample that stands for all of it: its vector irradiance."""
        return as_a_whole(self.outline(points), normals)

    def drawn(self, points: Points, u: PerRay, v: PerRay) -> Illumination:
        """One of its places for each point, right on average."""
        return drawn_place(self.outline(points), 2 * u - 1, 2 * v - 1)

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """Its Gauss points, which materials with highlights are lit by."""
        return tuple(gauss_points(self.outline(points), self.points))

    def moved(self, by: Triple) -> "DiskLight":
        """The light with its centre moved."""
        return replace(self, centre=moved(self.centre, np.array(by, dtype=float)))

    def white(self, target: Triple) -> float:
        """E/π for a diffuser that faces its vector irradiance."""
        return _white(self, target)

    def bound(self, nearest: Nearest) -> float:
        """Its area over the square of the smallest distance at which a surface may be, or 2π for each of its places."""
        return _bound(self, np.pi * self.radius**2, nearest(np.array(self.centre)) - self.radius)


@hinting
@dataclass(frozen=True)
class SphereLight:
    """A sphere that shines outwards; its symbol is its radiance.  From outside it is a disk, the one in its silhouette.

    It casts no shadow, and is not seen in the picture unless it is to be; inside of it is darkness.  The other fields
    are those of `RectangleLight`.

    Examples
    --------
    At a distance d it gives a surface that faces it π r²/d²:

    >>> bulb = SphereLight("lamp", centre=(0, 2, 0), radius=1)
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> (bulb.facing(np.zeros((3, 1)), up).falloff / np.pi).round(12).tolist()
    [0.25]
    """

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    name: str
    centre: Triple
    radius: Number
    shadows: bool = True
    grid: int = field(default=3, kw_only=True)
    refinement: int = field(default=1, kw_only=True)
    points: int = field(default=4, kw_only=True)
    visible: bool = field(default=False, kw_only=True)
    type: Literal["sphere"] = field(default="sphere", kw_only=True)

    def __post_init__(self) -> None:
        places = [*check_triple("centre", self.centre), *_radius_faults(self.radius)]
        refuse([*check_name("name", self.name), *places, *_counts(self)])
        settle(self, centre=floats(self.centre), radius=float(self.radius))

    @property
    def shape(self) -> Sphere:
        """The sphere that is seen."""
        return Sphere(self.centre, self.radius, self.name)

    def outline(self, points: Points) -> Outline:
        """The disk inside of its silhouette, in which the cone of directions to it ends."""
        towards = column(self.centre) - points
        distance = length(towards)
        outside = distance > self.radius
        away = np.where(outside, distance, 1.0)
        axis = np.where(outside, towards / away, DARK)

        # cos² of half the angle that it fills; the disk stands where the cone touches the sphere.
        square = np.where(outside, (distance - self.radius) / away * ((distance + self.radius) / away), 1.0)
        across, up = perpendicular(axis)
        radius = self.radius * np.sqrt(square)
        # From inside the disk shows its dark side.
        normal = np.where(outside, -axis, axis)
        return Outline(axis * away * square, radius * across, radius * up, normal, circular=True, ball=self.radius)

    def facing(self, points: Points, normals: Points) -> Illumination:
        """One sample that stands for all of it: its vector irradiance."""
        return as_a_whole(self.outline(points), normals)

    def drawn(self, points: Points, u: PerRay, v: PerRay) -> Illumination:
        """One of its places for each point, right on average."""
        return drawn_place(self.outline(points), 2 * u - 1, 2 * v - 1)

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """Its Gauss points, which materials with highlights are lit by."""
        return tuple(gauss_points(self.outline(points), self.points))

    def moved(self, by: Triple) -> "SphereLight":
        """The light with its centre moved."""
        return replace(self, centre=moved(self.centre, np.array(by, dtype=float)))

    def white(self, target: Triple) -> float:
        """E/π for a diffuser that faces its middle: (r/d)²."""
        return _white(self, target)

    def bound(self, nearest: Nearest) -> float:
        """π r²/(d² − r²) at the nearest surface, or 2π for each of its places."""
        distance = nearest(np.array(self.centre))
        from_border = np.sqrt(max(distance - self.radius, 0.0)) * np.sqrt(distance + self.radius)
        return _bound(self, np.pi * self.radius**2, float(from_border))


def _white(light: Any, target: Triple) -> float:
    place = np.array(target, dtype=float)[:, None]
    towards = light.outline(place).centre
    if not np.any(towards):
        return 0.0
    first = light.facing(place, normalise(towards))
    found = light.facing(place, first.direction)
    return float(found.falloff[0] * max(dot(found.direction, first.direction)[0], 0.0)) / np.pi


def _bound(light: Any, area: float, distance: float) -> float:
    """An upper bound on the sum of a light's samples; diffusers, whose light is exact, get no more than π."""
    most = 2 * np.pi * len(light.samples(np.zeros((3, 1))))
    return min(most, area / distance / distance) if distance > 0 else most


# --- Checks ---------------------------------------------------------------------------------------------------------


def _edge_faults(key: str, edge: Any) -> Iterator[str]:
    faults = list(check_triple(key, edge))
    yield from faults
    if not faults:
        size = float(length(column(floats(edge)))[0])
        if not 1 / LARGEST <= size <= LARGEST:
            yield (
                f"{key} = {shown(list(edge))}: the light would have no size that can be computed with; give the full "
                'edge, such as [1, 0, 0], or take type = "point"'
            )


def _square_faults(light: RectangleLight) -> Iterator[str]:
    u, v = (normalise(column(floats(edge))) for edge in (light.edge_u, light.edge_v))
    if abs(float(dot(u, v)[0])) > SQUARE:
        yield (
            f"edge_v = {shown(list(light.edge_v))}: it is not perpendicular to edge_u = {shown(list(light.edge_u))}; "
            "turn one of them"
        )


def _radius_faults(radius: Any) -> Iterator[str]:
    faults = list(check_number("radius", radius))
    yield from faults
    if not faults and not 1 / LARGEST <= radius <= LARGEST:
        yield (
            f"radius = {shown(radius)}: the light would have no size that can be computed with; give one above 0, or "
            'take type = "point"'
        )


def _counts(light: Any) -> Iterator[str]:
    yield from check_whole("grid", light.grid, 33, least=2)
    yield from check_whole("refinement", light.refinement, 5, least=0)
    yield from check_whole("points", light.points, 32)
    if not isinstance(light.visible, bool):
        yield f"visible = {shown(light.visible)}: it must be true or false, without quotes"
