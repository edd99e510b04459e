"""Surfaces that glow: a light that is sent by all that is made of one material (step 1).

Its symbol stands for a radiance.  The material's formula ``emitted`` says how much of it goes where: all of it in every
direction for the model ``emitter``, less towards the edge for one's own, as a star's.  Such a light is seen, in mirrors
and through glass too; other surfaces it lights only where their light is gathered from what they see.
"""

from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np

from symrt.errors import hinting, refuse
from symrt.geometry import Triple
from symrt.scene.checks import check_name
from symrt.scene.lights import Illumination, Nearest, Points, Via


@hinting
@dataclass(frozen=True)
class SurfaceLight:
    """The light that surfaces of a material send by themselves; its symbol is its radiance.

    Parameters
    ----------
    material
        A material whose model has a formula ``emitted``, as ``["lambert", "emitter"]`` has.  Two lights may name the
        same material: their radiances add up.

    Examples
    --------
    >>> SurfaceLight("glow", material="ember").white((0, 0, 0))
    1.0
    """

    calls_for: ClassVar[str | None] = "emission"
    via: ClassVar[Via] = "emitted"
    shadows: ClassVar[bool] = False
    name: str
    material: str
    type: Literal["surface"] = field(default="surface", kw_only=True)

    def __post_init__(self) -> None:
        refuse(check_name("name", self.name))

    def samples(self, points: Points) -> tuple[Illumination]:
        """The light's one sample: radiance 1 at each point of its material, without a direction."""
        count = points.shape[1]
        return (Illumination(None, np.full(count, np.inf), np.ones(count)),)

    def moved(self, by: Triple) -> "SurfaceLight":  # noqa: ARG002  its surfaces are moved as shapes
        """The light itself: it is where its surfaces are."""
        return self

    def white(self, target: Triple) -> float:  # noqa: ARG002  it shines on nothing there
        """1: where nothing else shines the surface itself is the white."""
        return 1.0

    def bound(self, nearest: Nearest) -> float:  # noqa: ARG002  the same at every surface
        """1, which the formula ``emitted`` multiplies."""
        return 1.0
