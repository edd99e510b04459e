"""Lights: what reaches a point from each, per unit of the light's own symbol (step 1).

A point light of intensity I gives a surface that faces it the irradiance I/d², a directional light of irradiance E
gives E.  The spectrum is a symbol, so only the factor 1/d² or 1 is known here.  Any object with a ``name``, ``shadows``
and ``illuminate`` is a light.
"""

from dataclasses import dataclass, field, replace
from functools import singledispatch
from typing import Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float

from symrt.arrays import length, normalise
from symrt.errors import refuse
from symrt.scene.checks import Triple, check_name, check_triple, floats, settle

__all__ = ["AmbientLight", "DirectionalLight", "Illumination", "Light", "PointLight", "moved", "white"]


UNIT = 1e-9
"""How far from 1 the length of a unit vector may be."""


@dataclass(frozen=True, eq=False)
class Illumination:
    """What a light does at some points.

    Parameters
    ----------
    direction
        Unit vectors from the points to the light.
    distance
        To the light, in scene units; infinite for a light infinitely far away.
    falloff
        Irradiance on a surface that faces the light, per unit of the light's symbol.
    """

    direction: Float[np.ndarray, "3 n"]
    distance: Float[np.ndarray, " n"]
    falloff: Float[np.ndarray, " n"]


@runtime_checkable
class Light(Protocol):
    """What the tracer asks of a light; a light of one's own needs these three and nothing else.

    Examples
    --------
    A spotlight that shines downwards, brightest in the middle:

    >>> @dataclass(frozen=True)
    ... class Spotlight:
    ...     name: str
    ...     position: tuple[float, float, float]
    ...     shadows: bool = True
    ...
    ...     def illuminate(self, points):
    ...         bulb = PointLight(self.name, position=self.position).illuminate(points)
    ...         return replace(bulb, falloff=bulb.falloff * np.clip(bulb.direction[1], 0, 1) ** 8)
    >>> isinstance(Spotlight("spot", (0, 3, 0)), Light)
    True
    """

    @property
    def name(self) -> str:
        """The symbol of the light's spectrum."""
        ...

    @property
    def shadows(self) -> bool:
        """Whether other shapes block it."""
        ...

    def illuminate(self, points: Float[np.ndarray, "3 n"]) -> Illumination:
        """What reaches the points when nothing is in the way."""
        ...


@dataclass(frozen=True)
class PointLight:
    """A light at a point: irradiance I cosθ/d² for the intensity I that its symbol stands for.

    Examples
    --------
    Three units above a point, a unit light gives a ninth:

    >>> PointLight("warm", position=(0, 3, 0)).illuminate(np.zeros((3, 1))).falloff.round(15).tolist()
    [0.111111111111111]
    """

    name: str
    position: Triple
    shadows: bool = True
    type: Literal["point"] = field(default="point", kw_only=True)

    def __post_init__(self) -> None:
        refuse([*check_name("name", self.name), *check_triple("position", self.position)])
        settle(self, position=floats(self.position))

    def illuminate(self, points: Float[np.ndarray, "3 n"]) -> Illumination:
        """What reaches the points when nothing is in the way.

        A point so near that 1/d² overflows is taken for the light itself: it has no direction, and stays dark.
        """
        towards = np.array(self.position)[:, None] - points
        distance = length(towards)
        with np.errstate(divide="ignore", over="ignore"):
            falloff = 1 / distance / distance
        lit = np.isfinite(falloff)
        direction = normalise(np.where(lit, towards, [[0.0], [1.0], [0.0]]))
        return Illumination(direction, distance, np.where(lit, falloff, 0.0))


@dataclass(frozen=True)
class DirectionalLight:
    """A light infinitely far away: irradiance E cosθ for the irradiance E that its symbol stands for.

    `direction` is the way the light travels: ``(0, -1, 0)`` shines straight down.

    Examples
    --------
    >>> DirectionalLight("sun", direction=(0, -2, 0)).illuminate(np.zeros((3, 1))).direction[1].tolist()
    [1.0]
    """

    name: str
    direction: Triple
    shadows: bool = True
    type: Literal["directional"] = field(default="directional", kw_only=True)

    def __post_init__(self) -> None:
        refuse([*check_name("name", self.name), *check_triple("direction", self.direction, direction=True)])
        settle(self, direction=floats(self.direction))

    def illuminate(self, points: Float[np.ndarray, "3 n"]) -> Illumination:
        """What reaches the points when nothing is in the way."""
        towards = normalise(-np.array(self.direction)[:, None])
        count = points.shape[1]
        return Illumination(np.broadcast_to(towards, (3, count)), np.full(count, np.inf), np.ones(count))


@dataclass(frozen=True)
class AmbientLight:
    """Light of equal radiance L from everywhere, unshadowed: a surface of reflectance ρ sends on ρ L.

    Examples
    --------
    >>> AmbientLight("sky").name
    'sky'
    """

    name: str
    type: Literal["ambient"] = field(default="ambient", kw_only=True)

    def __post_init__(self) -> None:
        refuse(check_name("name", self.name))


@dataclass(frozen=True)
class Moved:
    """A light of one's own, seen from coordinates that were moved by `by`."""

    light: Light
    by: Triple

    @property
    def name(self) -> str:
        """Of the light that was moved."""
        return self.light.name

    @property
    def shadows(self) -> bool:
        """Of the light that was moved."""
        return self.light.shadows

    def illuminate(self, points: Float[np.ndarray, "3 n"]) -> Illumination:
        """What reaches the points, asked in the light's own coordinates."""
        found = self.light.illuminate(points - np.array(self.by, dtype=float)[:, None])
        size = np.sqrt(np.sum(found.direction**2, axis=0))
        lit = found.falloff > 0
        if not (np.all(found.falloff >= 0) and np.all(np.isfinite(found.falloff))):
            raise ValueError(f"the light {self.name}: its falloff must be finite and not negative at every point")
        if not np.all(np.abs(size[lit] - 1) <= UNIT):
            raise ValueError(f"the light {self.name}: its directions must be unit vectors; divide them by their length")
        return found


@singledispatch
def moved(light: Light | AmbientLight, by: Triple) -> Light | AmbientLight:
    """The same light when the whole scene moves by the vector `by` (the tracer moves the camera to the origin).

    Examples
    --------
    >>> moved(PointLight("warm", position=(0, 3, 0)), (1, 0, 0)).position
    (1.0, 3.0, 0.0)
    """
    return Moved(light, by) if isinstance(light, Light) else light


@moved.register
def _(light: PointLight, by: Triple) -> PointLight:
    x, y, z = (a + float(b) for a, b in zip(light.position, by, strict=True))
    return replace(light, position=(x, y, z))


@moved.register
def _(light: DirectionalLight, by: Triple) -> DirectionalLight:  # noqa: ARG001  infinitely far away stays so
    return light


def white(light: Light | AmbientLight, target: Triple) -> float:
    """Radiance of a perfect diffuser at `target` that faces the light, unshadowed, per unit of the light's symbol.

    It is E/π: what turns radiance into reflectance on the other side of the waist (`LinearSystem.white`).

    Examples
    --------
    >>> white(DirectionalLight("sun", direction=(0, -1, 0)), (0, 0, 0)) == 1 / np.pi
    True
    """
    if isinstance(light, AmbientLight):
        return 1.0
    falloff = float(light.illuminate(np.array(target, dtype=float)[:, None]).falloff[0])
    return falloff / np.pi
