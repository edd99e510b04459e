"""Lights: the irradiance that each sends to a point, per unit of the light's own symbol (step 1).

A point light of intensity I gives a surface that faces it the irradiance I/d², a directional light of irradiance E
gives E.  The spectrum is a symbol, so only the factor 1/d² or 1 is known here.  The tracer asks a light through its
methods, never for its class: any object with a ``name``, ``shadows`` and ``samples`` is a light.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import length, normalise
from symrt.errors import hinting, refuse
from symrt.geometry import Triple
from symrt.geometry.directions import by_kernel
from symrt.scene.checks import check_name, check_triple, floats, settle
from symrt.scene.outlines import Directions, Outline

Points = Float[np.ndarray, "3 n"]
Via = Literal["direct", "ambient", "emitted"]
"""The formula of a model that a light meets: of light from a direction, from everywhere, or from the surface itself."""
Nearest = Callable[[np.ndarray], float]
"""The distance from a place to the nearest surface."""

UNIT = 1e-9
"""Largest deviation from 1 of a unit vector's length."""


@dataclass(frozen=True, eq=False)
class Illumination:
    """One sample of a light, seen from some points.

    Parameters
    ----------
    direction
        Unit vectors from the points to the light; None for light from everywhere.
    distance
        Distance to the light in scene units; infinite for a light infinitely far away.
    falloff
        Irradiance on a surface that faces the light, per unit of the light's symbol.
    figure
        The figure that the light looks like, or the directions that stand for it, where the sample stands for all of
        it; None where it stands for a place.
    """

    direction: Points | None
    distance: Float[np.ndarray, " n"]
    falloff: Float[np.ndarray, " n"]
    figure: Outline | Directions | None = None

    @property
    def towards(self) -> Points:
        """The directions, of a sample that has some."""
        if self.direction is None:
            raise TypeError("light from everywhere has no direction")
        return self.direction

    def of(self, chosen: Int[np.ndarray, " chosen"]) -> "Illumination":
        """The sample as seen from some of the points."""
        direction = None if self.direction is None else self.direction.take(chosen, axis=1)
        figure = None if self.figure is None else self.figure.of(chosen)
        return Illumination(direction, self.distance[chosen], self.falloff[chosen], figure)


@runtime_checkable
class Light(Protocol):
    """The members that a user's own light must have; `answering` adds the rest.

    Examples
    --------
    A spotlight that shines downwards, brightest in the middle:

    >>> @dataclass(frozen=True)
    ... class Spotlight:
    ...     name: str
    ...     position: tuple[float, float, float]
    ...     shadows: bool = True
    ...
    ...     def samples(self, points):
    ...         (bulb,) = PointLight(self.name, position=self.position).samples(points)
    ...         return (replace(bulb, falloff=bulb.falloff * np.clip(bulb.direction[1], 0, 1) ** 8),)
    >>> isinstance(Spotlight("spot", (0, 3, 0)), Light)
    True
    """

    @property
    def name(self) -> str:
        """Name of the symbol that stands for the light's spectrum."""
        ...

    @property
    def shadows(self) -> bool:
        """True if other shapes block the light."""
        ...

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """The light's samples as seen from the points, unshadowed; their number depends on the light alone."""
        ...


@runtime_checkable
class Answering(Light, Protocol):
    """A light with all the members that the tracer asks for, as those defined here have."""

    calls_for: ClassVar[str | None]
    """Name of the effect without which it does not shine, if there is one."""

    via: ClassVar[Via]
    """The formula of a model that reflects it."""

    def moved(self, by: Triple) -> "Answering":
        """The light after the whole scene has moved by the vector `by`."""
        ...

    def white(self, target: Triple) -> float:
        """Radiance of a perfect diffuser at `target` that faces the light, unshadowed, per unit of its symbol."""
        ...

    def bound(self, nearest: Nearest) -> float:
        """An upper bound on the irradiance that any surface receives, per unit of its symbol."""
        ...


@hinting
@dataclass(frozen=True)
class PointLight:
    """A light at a point: irradiance I cosθ/d² for the intensity I that its symbol stands for.

    Examples
    --------
    Three units above a point, a unit light gives a ninth:

    >>> PointLight("warm", position=(0, 3, 0)).samples(np.zeros((3, 1)))[0].falloff.round(15).tolist()
    [0.111111111111111]
    """

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    name: str
    position: Triple
    shadows: bool = True
    type: Literal["point"] = field(default="point", kw_only=True)

    def __post_init__(self) -> None:
        refuse([*check_name("name", self.name), *check_triple("position", self.position)])
        settle(self, position=floats(self.position))

    def samples(self, points: Points) -> tuple[Illumination]:
        """The light's one sample, seen from each point.

        A point so near that 1/d² overflows is taken for the light itself: it has no direction, and stays dark.
        """
        towards = np.array(self.position)[:, None] - points
        unit, distance = by_kernel(towards) or (None, length(towards))
        # Divided twice: d² itself would lose digits, or overflow, before 1/d² does.
        with np.errstate(divide="ignore", over="ignore"):
            falloff = 1 / distance / distance
        lit = np.isfinite(falloff)
        direction = normalise(np.where(lit, towards, [[0.0], [1.0], [0.0]])) if unit is None else unit
        return (Illumination(direction, distance, np.where(lit, falloff, 0.0)),)

    def moved(self, by: Triple) -> "PointLight":
        """The light with its position moved.

        Examples
        --------
        >>> PointLight("warm", position=(0, 3, 0)).moved((1, 0, 0)).position
        (1.0, 3.0, 0.0)
        """
        x, y, z = (a + float(b) for a, b in zip(self.position, by, strict=True))
        return replace(self, position=(x, y, z))

    def white(self, target: Triple) -> float:
        """I/(π d²) for I = 1 and d the distance to the target."""
        return diffuse_white(self, target)

    def bound(self, nearest: Nearest) -> float:
        """1/d² at the nearest surface; infinite where one meets the light."""
        distance = nearest(np.array(self.position))
        return 1 / distance / distance if distance > 0 else float("inf")


@hinting
@dataclass(frozen=True)
class DirectionalLight:
    """A light infinitely far away: irradiance E cosθ for the irradiance E that its symbol stands for.

    `direction` is the way the light travels: ``(0, -1, 0)`` shines straight down.

    Examples
    --------
    >>> DirectionalLight("sun", direction=(0, -2, 0)).samples(np.zeros((3, 1)))[0].direction[1].tolist()
    [1.0]
    """

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    name: str
    direction: Triple
    shadows: bool = True
    type: Literal["directional"] = field(default="directional", kw_only=True)

    def __post_init__(self) -> None:
        refuse([*check_name("name", self.name), *check_triple("direction", self.direction, direction=True)])
        settle(self, direction=floats(self.direction))

    def samples(self, points: Points) -> tuple[Illumination]:
        """The light's one sample, of the same direction everywhere."""
        towards = normalise(-np.array(self.direction)[:, None])
        count = points.shape[1]
        return (Illumination(np.broadcast_to(towards, (3, count)), np.full(count, np.inf), np.ones(count)),)

    def moved(self, by: Triple) -> "DirectionalLight":  # noqa: ARG002  infinitely far away stays so
        """The light itself: infinitely far away stays so."""
        return self

    def white(self, target: Triple) -> float:
        """1/π, wherever the target is.

        Examples
        --------
        >>> DirectionalLight("sun", direction=(0, -1, 0)).white((0, 0, 0)) == 1 / np.pi
        True
        """
        return diffuse_white(self, target)

    def bound(self, nearest: Nearest) -> float:  # noqa: ARG002  the same at every surface
        """1: the irradiance of a surface that faces it."""
        return 1.0


@hinting
@dataclass(frozen=True)
class AmbientLight:
    """Light of equal radiance L from everywhere, unshadowed: a surface of reflectance ρ sends on ρ L.

    Examples
    --------
    >>> AmbientLight("sky").samples(np.zeros((3, 1)))[0].falloff
    array([1.])
    """

    calls_for: ClassVar[str | None] = "ambient"
    via: ClassVar[Via] = "ambient"
    shadows: ClassVar[bool] = False
    name: str
    type: Literal["ambient"] = field(default="ambient", kw_only=True)

    def __post_init__(self) -> None:
        refuse(check_name("name", self.name))

    def samples(self, points: Points) -> tuple[Illumination]:
        """The light's one sample: radiance 1 at each point, without a direction."""
        count = points.shape[1]
        return (Illumination(None, np.full(count, np.inf), np.ones(count)),)

    def moved(self, by: Triple) -> "AmbientLight":  # noqa: ARG002  everywhere stays so
        """The light itself: everywhere stays so."""
        return self

    def white(self, target: Triple) -> float:  # noqa: ARG002  the same everywhere
        """1: a perfect diffuser sends on the radiance that arrives."""
        return 1.0

    def bound(self, nearest: Nearest) -> float:  # noqa: ARG002  the same at every surface
        """1: the radiance that arrives at any surface."""
        return 1.0


@dataclass(frozen=True)
class Own:
    """A user's own light with the members that the tracer asks for, in coordinates that were moved by `by`."""

    calls_for: ClassVar[str | None] = None
    via: ClassVar[Via] = "direct"
    light: Light
    by: Triple = (0.0, 0.0, 0.0)

    @property
    def name(self) -> str:
        """The name of the light itself."""
        return self.light.name

    @property
    def shadows(self) -> bool:
        """True if other shapes block the light itself."""
        return self.light.shadows

    def samples(self, points: Points) -> tuple[Illumination, ...]:
        """The light's own samples, taken in its own coordinates, and checked.

        Raises
        ------
        ValueError
            If a falloff is negative or not finite, or a direction is not a unit vector.
        """
        found = tuple(self.light.samples(points - np.array(self.by, dtype=float)[:, None]))
        for sample in found:
            if not (np.all(sample.falloff >= 0) and np.all(np.isfinite(sample.falloff))):
                raise ValueError(f"the light {self.name}: its falloff must be finite and not negative at every point")
            if sample.direction is None:
                raise ValueError(f"the light {self.name}: its samples must have directions; AmbientLight needs none")
            size = np.sqrt(np.sum(sample.direction**2, axis=0))
            if not np.all(np.abs(size[sample.falloff > 0] - 1) <= UNIT):
                raise ValueError(
                    f"the light {self.name}: its directions must be unit vectors; divide them by their length"
                )
        return found

    def moved(self, by: Triple) -> "Own":
        """The light in coordinates that moved once more."""
        x, y, z = (a + float(b) for a, b in zip(self.by, by, strict=True))
        return Own(self.light, (x, y, z))

    def white(self, target: Triple) -> float:
        """The sum of its samples' E/π."""
        return diffuse_white(self, target)

    def bound(self, nearest: Nearest) -> float:  # noqa: ARG002  nothing is known of it
        """Infinity, as no bound is known of a user's own light."""
        return float("inf")


def answering(light: Light) -> Answering:
    """The light itself if it has all the members that the tracer asks for, otherwise wrapped in one that has.

    Examples
    --------
    >>> sun = DirectionalLight("sun", direction=(0, -1, 0))
    >>> answering(sun) is sun
    True
    """
    return light if isinstance(light, Answering) else Own(light)


def diffuse_white(light: Light, target: Triple) -> float:
    """Radiance of a perfect diffuser at `target` that faces each sample of a light, unshadowed: the sum of E/π.

    It turns radiance into reflectance on the other side of the waist (`LinearSystem.white`).

    Examples
    --------
    >>> diffuse_white(PointLight("warm", position=(0, 1, 0)), (0, 0, 0)) == 1 / np.pi
    True
    """
    samples = light.samples(np.array(target, dtype=float)[:, None])
    return sum(float(sample.falloff[0]) for sample in samples) / np.pi
