"""The result of a trace: every hit, with the geometric factors that its material's formulas name (step 1).

The tree generalises the parameterised ray tree of Séquin and Smyrl [1]_.  It is stored by level (the camera's hits,
then those of the rays that they send on, and so on), by branch, by material and by light, in arrays: nothing is an
object per pixel.  It holds geometry only; products of symbols appear when it is collapsed.

References
----------
.. [1] C. H. Séquin and E. K. Smyrl, "Parameterized Ray Tracing", SIGGRAPH 1989.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.counts import Counts
from symrt.estimates import Estimate
from symrt.reflection.models import Model
from symrt.scene.lights import Via
from symrt.tracing.plan import Plan
from symrt.windows import SpectralWindow

Index = Int[np.ndarray, " point"]
"""Indices of points, or of hits, one for each point."""
Factors = Mapping[str, Float[np.ndarray, " point"]]


@dataclass(frozen=True, eq=False)
class Lit:
    """One sample of a light at the points of one material that it reaches, with its geometric factors there.

    Parameters
    ----------
    via
        The formula that it meets: ``direct``, ``ambient`` for light from everywhere, or ``emitted`` for that of the
        surface itself.
    point
        Indices into the points of the material.
    irradiance
        Irradiance of a facing surface, per unit of the light's symbol: 1/d² for a point light.
    visible
        The share that nothing hides: 1 in the light, 0 in a shadow.
    factors
        The cosines that the formula names.
    error
        The estimated error of `visible`, where it is not exact: see `Estimate`.
    """

    light: str
    via: Via
    point: Index
    irradiance: Float[np.ndarray, " point"]
    visible: Float[np.ndarray, " point"]
    factors: Factors
    error: Float[np.ndarray, " point"] | None = None


@dataclass(frozen=True, eq=False)
class Points:
    """The points of one level that are made of one material.

    Parameters
    ----------
    hit
        Index of each point's hit in its level, ascending; one hit is several points where a texture blends materials.
    weight
        Share of the material at the point; the shares of a hit sum to 1.
    lit
        Samples of lights, those from a direction first; one light may have several.
    view
        Factors that depend on the viewer only.
    cut
        Samples of lights that an effect which was left out would change or add: they count in the tail.
    """

    material: str
    hit: Index
    weight: Float[np.ndarray, " point"]
    lit: tuple[Lit, ...]
    view: Factors
    cut: tuple[Lit, ...] = ()


@dataclass(frozen=True, eq=False)
class Branch:
    """Rays that one formula sends on from hits of a level.

    Parameters
    ----------
    via
        The formula, a field of `Model`, for the share of the rays' radiance that is sent on to the viewer.
    parent
        The hit that each ray leaves from, on the level above the rays' own hits.
    weight
        A further share of each ray.
    factors
        Cosines of each ray's own direction, where the formula names any.
    materials
        The materials whose formula it is, by the names of their points; None if it is that of all that have it.
    window
        The window of wavelengths of each ray, where rays are split into them; None if it is that of the ray's parent.
    """

    via: str
    parent: Int[np.ndarray, " ray"]
    weight: Float[np.ndarray, " ray"]
    factors: Mapping[str, Float[np.ndarray, " ray"]] = field(default_factory=dict)
    materials: frozenset[str] | None = None
    window: Int[np.ndarray, " ray"] | None = None

    @property
    def size(self) -> int:
        """Number of rays."""
        return self.parent.size

    def sent_by(self, points: Points) -> bool:
        """True if the rays are sent on by the formula of these points, where they leave from them."""
        return self.materials is None or points.material in self.materials


@dataclass(frozen=True, eq=False)
class Emitted:
    """Light that hits send to the viewer by themselves: entries of degree 0, met by no reflectance.

    Parameters
    ----------
    radiance
        Radiance of each hit, per unit of the light's symbol.
    """

    light: str
    hit: Int[np.ndarray, " emitting"]
    radiance: Float[np.ndarray, " emitting"]


@dataclass(frozen=True, eq=False)
class Level:
    """All hits after the same number of rays.

    Parameters
    ----------
    sample
        Film sample of each hit.
    branches
        The rays that led here from the level above: hits are numbered along the branches, one after the other.  The
        camera's level has none.
    points
        The hits by material, and the light that reaches them.
    emitted
        The light that hits send by themselves, other than by a formula of their material.
    cut
        Rays that were sent from these hits but not followed, beyond the depth or by an effect that was left out; their
        parents are hits of this level.
    unlit
        As `emitted`, of an effect that was left out: it counts in the tail.
    inside
        By the name of its transmittance, the length that the ray to each hit went in an absorbing material, or 0.
    gathered, path
        Of each hit, how often diffusers sent its path on to gather light, and the number of that path; None where
        nothing is gathered.
    window
        The window of wavelengths that each hit is seen in, −1 for all of them; None where no glass bends them apart.
    """

    sample: Int[np.ndarray, " hit"]
    branches: tuple[Branch, ...]
    points: tuple[Points, ...]
    emitted: tuple[Emitted, ...] = ()
    cut: tuple[Branch, ...] = ()
    unlit: tuple[Emitted, ...] = ()
    inside: Mapping[str, Float[np.ndarray, " hit"]] = field(default_factory=dict)
    gathered: Int[np.ndarray, " hit"] | None = None
    path: Int[np.ndarray, " hit"] | None = None
    window: Int[np.ndarray, " hit"] | None = None

    @property
    def size(self) -> int:
        """Number of hits."""
        return self.sample.size

    def window_of(self, branch: Branch) -> Int[np.ndarray, " ray"] | None:
        """The window of each ray of a branch that leaves from here; None where there are none."""
        if branch.window is not None or self.window is None:
            return branch.window
        return self.window[branch.parent]


@dataclass(frozen=True, eq=False)
class Film:
    """The samples of a film.

    Parameters
    ----------
    pixel
        The pixel of the window, along rows from the top left, that each sample belongs to, ascending.
    weight
        Weight of each sample; over a pixel the weights sum to 1.
    half
        Where samples are drawn, the half of its pixel's samples that each belongs to, of the same weight as the other:
        what the halves differ by tells the noise of the picture.
    """

    pixel: Int[np.ndarray, " sample"]
    weight: Float[np.ndarray, " sample"]
    half: Bool[np.ndarray, " sample"] | None = None

    @property
    def row(self) -> Int[np.ndarray, " sample"]:
        """The pixel of each sample or, where there are halves, the row of its half if each pixel has two."""
        return self.pixel if self.half is None else 2 * self.pixel + self.half


@dataclass(frozen=True, eq=False)
class MaterialRecord:
    """A material's part in the tree: its formulas and the values of their parameters.

    Parameters
    ----------
    indices
        The refractive index in each window of wavelengths, where it changes with them.
    """

    model: Model
    parameters: Mapping[str, float]
    indices: tuple[float, ...] = ()

    def signature(self) -> str:
        """The model and its parameters as text; two materials that agree here differ in spectra only."""
        formulas = "; ".join(f"{name} = {formula}" for name, formula in self.model.formulas.items() if formula != 0)
        by_window = [f"index by window = {list(self.indices)}"] if self.indices else []
        values = (f"{name} = {value!r}" for name, value in sorted(self.parameters.items()))
        return "; ".join([formulas, *values, *by_window])


@dataclass(frozen=True, eq=False)
class LightRecord:
    """A light's part in the tree.

    Parameters
    ----------
    via
        The formula that it meets.
    white
        The coefficient of a perfect diffuser at the camera's target that faces the light.
    bound
        The largest irradiance of any surface per unit of the light's symbol, which bounds the light cut off.
    shown
        The largest radiance, per unit of the symbol, of the light where it is seen itself; 0 if it never is.
    """

    via: Via
    white: float
    bound: float
    shown: float = 0.0

    @property
    def glowing(self) -> bool:
        """True if it is seen itself, unreflected."""
        return self.via == "emitted" or self.shown > 0


@dataclass(frozen=True, eq=False)
class RayTree:
    """A traced window of a scene: geometry in numbers, lights and materials by name.

    Parameters
    ----------
    levels
        The camera's hits first, then one level for each further ray.
    materials
        Model and parameters of each material, alternatives (``sea>ice``) included.
    lights
        Every light of the scene, in its order.
    window
        ``(x0, y0, x1, y1)``, the pixels that were traced, x1 and y1 excluded.
    sending
        For each material whose surfaces send rays on, whether or not a ray met them, the formulas that say so.
    plan
        The effects that were simulated, and those that were not.
    rays
        Number of rays cast, by effect.
    paths
        Number of paths that gather light at each hit that the camera sees; 0 where none do.
    counts
        The rays, the pixels and the time of each effect that was simulated.
    windows
        The windows of wavelengths that rays are split into, where glass bends them apart.
    """

    levels: tuple[Level, ...]
    materials: Mapping[str, MaterialRecord]
    lights: Mapping[str, LightRecord]
    window: tuple[int, int, int, int]
    film: Film
    sending: Mapping[str, tuple[str, ...]]
    plan: Plan
    rays: Mapping[str, int] = field(default_factory=dict)
    counts: Counts = field(default_factory=Counts)
    seconds: float = 0.0
    windows: tuple[SpectralWindow, ...] = ()
    paths: int = 0

    @property
    def width(self) -> int:
        """Pixels across the window."""
        return self.window[2] - self.window[0]

    @property
    def height(self) -> int:
        """Pixels down the window."""
        return self.window[3] - self.window[1]

    @property
    def white(self) -> dict[str, float]:
        """For each light, the coefficient of a perfect diffuser at the camera's target that faces it."""
        return {name: light.white for name, light in self.lights.items()}

    @property
    def errors(self) -> dict[str, Estimate]:
        """For each light whose share that is seen was estimated, the error of that share over all lit points."""
        lit = [lit for level in self.levels for points in level.points for lit in points.lit if lit.error is not None]
        return {
            name: Estimate.of(np.concatenate([one.error for one in lit if one.light == name and one.error is not None]))
            for name in sorted({one.light for one in lit})
        }

    def __repr__(self) -> str:
        hits = " + ".join(str(level.size) for level in self.levels)
        rays = ", ".join(f"{count} {name}" for name, count in self.rays.items())
        errors = "".join(f"; the share of {name} that is seen errs by {error}" for name, error in self.errors.items())
        return f"RayTree({self.width} × {self.height} pixels, {hits} hits; rays: {rays}{errors})"
