"""Lights that come from many directions at once, as the tracer asks them (step 1)."""

from typing import Protocol, runtime_checkable

from symrt.arrays import PerRay
from symrt.geometry import Disk, Rectangle, Sphere
from symrt.scene.lights import Answering, Illumination, Points
from symrt.scene.outlines import Outline


@runtime_checkable
class WideLight(Answering, Protocol):
    """A light that comes from many directions at once: a diffuser gets it as a whole."""

    def facing(self, points: Points, normals: Points) -> Illumination:
        """The light as one sample, exact for diffusers: the vector irradiance from above each point's horizon."""
        ...

    def drawn(self, points: Points, u: PerRay, v: PerRay) -> Illumination:
        """One place of it for each point, drawn by pairs of numbers from 0 to 1, that stands for all of it."""
        ...


@runtime_checkable
class AreaLight(WideLight, Protocol):
    """The members that the tracer asks of a light with an area, beside those of every light."""

    @property
    def grid(self) -> int:
        """Corners across the grid of places from which the share that is seen is found."""
        ...

    @property
    def refinement(self) -> int:
        """Number of times that cells of the grid may be cut in four."""
        ...

    def outline(self, points: Points) -> Outline:
        """The flat figure that the light looks like from each point."""
        ...

    @property
    def visible(self) -> bool:
        """True if rays from the eye, from mirrors and from glass see it."""
        ...

    @property
    def shape(self) -> Rectangle | Disk | Sphere:
        """The shape that they meet, which has the light's name in place of a material's."""
        ...
