"""The sky, infinitely far away: regions of radiance L, each a light of its own (step 1).

`Environment` names regions, and a `Scene` takes it apart: the region ``zenith`` of the environment ``sky`` is the light
``sky_zenith``, whose symbol is its radiance.  A diffuser gets the irradiance n·E from the vector irradiance E of the
part of a region above its horizon (`symrt.scene.skylight`), times the share that is seen of it; a material with
highlights gets the light from each of the region's directions.  They stand in the middle of cells of equal solid angle,
fixed by the region alone.  Elevations and azimuths are in degrees; azimuth 0 is north, 90 east of it, seen from above
clockwise.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar, Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from symrt.arrays import PerRay, dot, length, normalise
from symrt.errors import hinting, refuse, shown
from symrt.geometry import Triple
from symrt.geometry.records import column
from symrt.scene.checks import Number, check_name, check_number, check_triple, check_whole, floats, settle
from symrt.scene.lights import Illumination, Nearest, Points, Via
from symrt.scene.outlines import DARK, Directions
from symrt.scene.skylight import Axes, Patch, axes_of, patch_irradiance
from symrt.scene.wide_lights import WideLight

FEWEST = 16
"""Directions that each region has at least."""
GOLDEN = (math.sqrt(5) - 1) / 2
"""The share of a cell by which each row of directions begins further east."""


@runtime_checkable
class Sky(WideLight, Protocol):
    """The members that the tracer asks of a region of the sky, beside those of every light."""

    @property
    def brightest(self) -> float:
        """Its largest radiance, per unit of its symbol."""
        ...

    @property
    def directions(self) -> Directions:
        """The directions that stand for it."""
        ...

    def radiance(self, directions: Points) -> Float[np.ndarray, " n"]:
        """Its radiance from each of some directions, per unit of its symbol; 0 beside it."""
        ...


@dataclass(frozen=True)
class SkyRegion:
    """A region of the sky between two elevations and two azimuths, of equal radiance: a light.

    Parameters
    ----------
    low, high, west, east
        Its borders in degrees; the whole way round from west to east is 360.
    count
        Number of its directions, about.

    Examples
    --------
    The upper half of the sky gives a floor the irradiance π, and a wall half of it:

    >>> sky = SkyRegion("sky", 0, 90)
    >>> normals = np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    >>> found = sky.facing(np.zeros((3, 2)), normals)
    >>> (found.falloff * np.sum(found.direction * normals, axis=0) / np.pi).round(12).tolist()
    [1.0, 0.5]
    """

    calls_for: ClassVar[str | None] = "environment"
    via: ClassVar[Via] = "direct"
    name: str
    low: float | int
    high: float | int
    west: float | int = 0.0
    east: float | int = 360.0
    up: Triple = (0.0, 1.0, 0.0)
    north: Triple = (0.0, 0.0, -1.0)
    shadows: bool = True
    count: int = 64

    @property
    def brightest(self) -> float:
        """1: its radiance is the same everywhere."""
        return 1.0

    @cached_property
    def patch(self) -> Patch:
        """Its borders in radians."""
        return Patch(*(math.radians(angle) for angle in (self.low, self.high, self.west, self.east)))

    @cached_property
    def axes(self) -> Axes:
        """The directions east, north and up."""
        return axes_of(self.up, self.north)

    @cached_property
    def directions(self) -> Directions:
        """Directions in the middle of cells of equal solid angle: rows, and along each row as many as fit."""
        patch, axes = self.patch, self.axes
        bottom, top = math.sin(patch.low), math.sin(patch.high)
        area = (top - bottom) * patch.width
        rows = max(1, round((patch.high - patch.low) / math.sqrt(area / self.count)))
        edges = np.linspace(bottom, top, rows + 1)
        across = [max(1, round(self.count / rows))] * rows

        # Rows begin at azimuths of their own, so that their directions do not stand above each other.
        found, weight = [], []
        for row, number in enumerate(across):
            shift = row * GOLDEN % 1 if patch.whole else 0.5
            azimuth = patch.west + patch.width * (np.arange(number) + shift) / number
            sine = (edges[row] + edges[row + 1]) / 2
            found.append(axes.out(azimuth, np.full(number, np.arcsin(sine))))
            weight.append(np.full(number, area / rows / number))
        return Directions(np.concatenate(found, axis=1), np.concatenate(weight), bottom, top, axes.up)

    def radiance(self, directions: Points) -> Float[np.ndarray, " n"]:
        """1 within its borders, the lower and the western one included; the zenith belongs to what reaches it."""
        return self.patch.holds(*self.axes.angles(directions)).astype(float)

    def facing(self, points: Points, normals: Points) -> Illumination:
        """One sample that stands for all of it: the vector irradiance of what is above each point's horizon."""
        irradiance = patch_irradiance(self.patch, self.axes, normals)
        size = length(irradiance)
        direction = normalise(np.where(size > 0, irradiance, DARK))
        return Illumination(direction, np.full(points.shape[1], np.inf), size, self.directions)

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """Its directions, by which materials with highlights are lit."""
        count, (towards, weight) = points.shape[1], (self.directions.towards, self.directions.weight)
        return tuple(
            Illumination(np.broadcast_to(towards[:, [k]], (3, count)), np.full(count, np.inf), np.full(count, w))
            for k, w in enumerate(weight.tolist())
        )

    def drawn(self, points: Points, u: PerRay, v: PerRay) -> Illumination:  # noqa: ARG002  one number chooses of a row
        """One of its directions for each point, right on average."""
        towards, weight = self.directions.towards, self.directions.weight
        chosen = np.searchsorted(np.cumsum(weight)[:-1], u * weight.sum(), side="right")
        return Illumination(towards[:, chosen], np.full(u.size, np.inf), np.full(u.size, weight.sum()))

    def moved(self, by: Triple) -> "SkyRegion":  # noqa: ARG002  infinitely far away stays so
        """The region itself: infinitely far away stays so."""
        return self

    def white(self, target: Triple) -> float:  # noqa: ARG002  the same everywhere
        """E/π for a diffuser that faces its middle; 1 for the whole sky."""
        found = self.directions
        middle = np.sum(found.weight * found.towards, axis=1, keepdims=True)
        normal = normalise(middle if length(middle)[0] > 1e-9 * found.weight.sum() else found.up)
        lit = self.facing(np.zeros((3, 1)), normal)
        return float(lit.falloff[0] * max(dot(lit.direction, normal)[0], 0.0)) / np.pi  # type: ignore[arg-type]

    def bound(self, nearest: Nearest) -> float:  # noqa: ARG002  the same at every surface
        """Its solid angle: the sum of its directions' light."""
        return float(self.directions.weight.sum())


@hinting
@dataclass(frozen=True)
class Environment:
    """The sky all around, in regions of equal radiance: each is a light, ``sky_zenith`` for the region ``zenith``.

    Rays that miss everything see it, also in mirrors and through glass.  Where regions overlap their radiances add up.

    Parameters
    ----------
    regions
        For each region its lowest and highest elevation in degrees, and, if it does not go all the way round, its
        western and eastern azimuth.
    up, north
        The directions of elevation 90 and, about, of azimuth 0.
    shadows
        True if shapes block its light.
    samples
        Directions in which it is looked for from each point, over a whole sphere; a region has those of its share.

    Examples
    --------
    >>> sky = Environment("sky", regions={"zenith": (30, 90), "dawn": (0, 30, 60, 120)})
    >>> [light.name for light in sky.lights]
    ['sky_zenith', 'sky_dawn']
    """

    name: str
    regions: Mapping[str, Sequence[Number]]
    up: Triple = (0, 1, 0)
    north: Triple = (0, 0, -1)
    shadows: bool = True
    samples: int = field(default=256, kw_only=True)
    type: Literal["environment"] = field(default="environment", kw_only=True)

    def __post_init__(self) -> None:
        refuse([*check_name("name", self.name), *_region_faults(self.regions), *_frame_faults(self)])
        settle(self, up=floats(self.up), north=floats(self.north), regions=dict(self.regions))

    @property
    def lights(self) -> tuple[SkyRegion, ...]:
        """The regions as lights, in their order."""
        found = []
        for region, borders in self.regions.items():
            low, high, west, east = (*map(float, borders), 0.0, 360.0)[:4]
            share = (math.sin(math.radians(high)) - math.sin(math.radians(low))) * (east - west) / 720
            count = max(FEWEST, round(self.samples * share))
            name = f"{self.name}_{region}"
            found.append(SkyRegion(name, low, high, west, east, self.up, self.north, self.shadows, count))
        return tuple(found)


def _region_faults(regions: Any) -> Iterator[str]:
    # Some regions, each with a name and its borders.
    if not isinstance(regions, Mapping) or not regions:
        yield (
            f"regions = {shown(regions)}: an environment has at least one region, each with its lowest and highest "
            "elevation in degrees; write regions = { sky = [0, 90], ground = [-90, 0] }"
        )
        return
    for name, borders in regions.items():
        key = f"regions.{name}"
        yield from check_name("regions", name)
        parts = list(borders) if isinstance(borders, list | tuple) else []
        faults = [fault for k, part in enumerate(parts) for fault in check_number(f"{key}[{k}]", part)]
        yield from faults
        if len(parts) not in (2, 4):
            yield f"{key} = {shown(borders)}: give two elevations, or these and two azimuths, such as [0, 30, 60, 120]"
        elif not faults and not -90 <= parts[0] < parts[1] <= 90:
            yield f"{key} = {shown(parts)}: elevations rise, from -90 to 90 degrees; write the lower first"
        elif not faults and len(parts) == 4 and not 0 < parts[3] - parts[2] <= 360:
            yield f"{key} = {shown(parts)}: azimuths go east, by at most 360 degrees; past north write 350 and 370"


def _frame_faults(light: Any) -> Iterator[str]:
    """Faults of the fields that say where the sky is and how closely it is looked at."""
    axes = [fault for key in ("up", "north") for fault in check_triple(key, getattr(light, key), direction=True)]
    yield from axes
    if not axes and not np.any(np.cross(normalise(column(light.up)), normalise(column(light.north)), axis=0).round(9)):
        yield f"north = {shown(list(light.north))}: it is along up = {shown(list(light.up))}; turn one of them"
    if not isinstance(light.shadows, bool):
        yield f"shadows = {shown(light.shadows)}: it must be true or false, without quotes"
    yield from check_whole("samples", light.samples, 1 << 14, least=16)
