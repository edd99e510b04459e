"""What a trace leaves behind: every hit, with the geometry that its material's formulas ask for (step 1).

The tree generalises the parameterised ray tree of Séquin and Smyrl [1]_.  It is stored by level (the camera's hits,
then what their mirrors see, and so on), by material and by light, in arrays: nothing is an object per pixel.

References
----------
.. [1] C. H. Séquin and E. K. Smyrl, "Parameterized Ray Tracing", SIGGRAPH 1989.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from symrt.reflection.models import Model

Index = Int[np.ndarray, " point"]
Factors = Mapping[str, Float[np.ndarray, " point"]]


@dataclass(frozen=True, eq=False)
class Lit:
    """Where one light faces points of one material: its geometric factors there.

    Parameters
    ----------
    point
        Indices into the points of the material.
    irradiance
        On a facing surface, per unit of the light's symbol: 1/d² for a point light.
    visible
        1 where nothing stands between point and light, else 0.
    factors
        The cosines that the model's formula names.
    """

    light: str
    point: Index
    irradiance: Float[np.ndarray, " point"]
    visible: Float[np.ndarray, " point"]
    factors: Factors


@dataclass(frozen=True, eq=False)
class Points:
    """The points of one level that are made of one material.

    Parameters
    ----------
    hit
        Index of each point's hit in its level; one hit is several points where a texture blends materials.
    weight
        Share of the material at the point; the shares of a hit sum to 1.
    view
        Factors that depend on the viewer only.
    """

    material: str
    hit: Index
    weight: Float[np.ndarray, " point"]
    lit: tuple[Lit, ...]
    view: Factors


@dataclass(frozen=True, eq=False)
class Level:
    """All hits after the same number of bounces.

    Parameters
    ----------
    sample
        Film sample of each hit: pixel · samples² + number of the sample within its pixel.
    parent
        Index of the hit, one level up, that this one is seen from; −1 on the camera's level.
    """

    sample: Int[np.ndarray, " hit"]
    parent: Int[np.ndarray, " hit"]
    points: tuple[Points, ...]

    @property
    def size(self) -> int:
        """Number of hits."""
        return self.sample.size


@dataclass(frozen=True, eq=False)
class MaterialRecord:
    """A material as the tree remembers it: its formulas and the values of their parameters."""

    model: Model
    parameters: Mapping[str, float]

    def signature(self) -> str:
        """The model and its parameters as text; two materials that agree here differ in spectra only."""
        formulas = "; ".join(f"{name} = {formula}" for name, formula in self.model.formulas.items() if formula != 0)
        return "; ".join([formulas, *(f"{name} = {value!r}" for name, value in sorted(self.parameters.items()))])


@dataclass(frozen=True, eq=False)
class RayTree:
    """A traced window of a scene: geometry in numbers, lights and materials by name.

    Parameters
    ----------
    levels
        The camera's hits first, then one level a bounce.
    materials
        Model and parameters of each material, alternatives (``sea>ice``) included.
    lights
        Every light of the scene, and whether it is ambient.
    window
        ``(x0, y0, x1, y1)``, the pixels that were traced, x1 and y1 excluded.
    samples
        Samples along one side of a pixel.
    white
        For each light, the coefficient of a perfect diffuser at the camera's target that faces it.
    irradiance
        For each light, the most that any surface can receive per unit of its symbol: it bounds what the depth limit
        cuts off.
    reflecting
        Materials of surfaces that mirror, whether or not a ray met them.
    rays
        Rays cast, by effect.
    """

    levels: tuple[Level, ...]
    materials: Mapping[str, MaterialRecord]
    lights: Mapping[str, bool]
    window: tuple[int, int, int, int]
    samples: int
    white: Mapping[str, float]
    irradiance: Mapping[str, float]
    depth: int
    reflecting: tuple[str, ...] = ()
    rays: Mapping[str, int] = field(default_factory=dict)
    seconds: float = 0.0

    @property
    def width(self) -> int:
        """Pixels across the window."""
        return self.window[2] - self.window[0]

    @property
    def height(self) -> int:
        """Pixels down the window."""
        return self.window[3] - self.window[1]

    def __repr__(self) -> str:
        hits = " + ".join(str(level.size) for level in self.levels)
        rays = ", ".join(f"{count} {name}" for name, count in self.rays.items())
        return f"RayTree({self.width} × {self.height} pixels, {hits} hits; rays: {rays})"
