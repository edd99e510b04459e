"""The record of an effect: how a scene calls for it, and its functions at the seams of the tracer (step 1)."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import NoneType
from typing import Literal

import numpy as np
from jaxtyping import Float, Int, Shaped

from symrt.geometry.rays import Hits, Rays
from symrt.scene.cameras import Camera, Window
from symrt.scene.lights import Illumination, Light
from symrt.scene.records import Scene
from symrt.tracing.raytree import Emitted, Film, Points
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import Batch, View, Which

PerHit = Float[np.ndarray, " hit"]
Starting = Callable[[Film, Camera, Window], Shaped[np.ndarray, " sample"]]
"""A value for each of the film's samples in a window of the camera's picture."""
CARRIED = "carried"
"""The name of the state that keeps the share of its film sample's light that a ray carries at most.

The tracer multiplies it by the shares of the rays that are sent, and does not follow those that carry too little.
"""


@dataclass(frozen=True)
class Call:
    """A scene's call for an effect.

    Parameters
    ----------
    by
        Names of the lights, materials or textures that call for it; empty where nothing does.
    without
        The reason, in words, where nothing calls for it.
    rays
        The largest number of rays that it may cost, in words.
    left_out
        The reason, in words, that it is left out although something calls for it; empty where it is simulated.
    a_hit
        Rays that end at each hit, such as one to each light that casts shadows.
    onwards
        Rays that each hit sends on, at most; they meet hits of their own, down to the scene's depth.
    gathered
        Rays of paths that gather light for each sample of the film.
    """

    by: tuple[str, ...]
    without: str
    rays: str = "none"
    left_out: str = ""
    a_hit: int = 0
    onwards: int = 0
    gathered: int = 0


@dataclass(frozen=True, eq=False)
class Sent:
    """Rays that an effect sends on from hits, to be multiplied by one formula of the materials there.

    Parameters
    ----------
    via
        The formula, a field of `Model`, for the share of the rays' radiance that is sent on to the viewer.
    hit
        The hit that each ray leaves from, ascending.
    rays
        The rays; None if they are not followed, and what they would bring is bounded in the tail.
    weight
        A further share of each ray.  Over the rays that a hit sends by one formula the weights sum to at most 1; by
        ``direct``, which tells radiance per irradiance, each times the ray's n·l, and they sum to at most π.
    factors
        Cosines of each ray's own direction, where the formula names any.
    state
        Values that effects keep for each ray, where they change; the rest is inherited.
    materials
        The materials whose formula it is, by the names of their points: where a texture blends others with them, those
        send no such ray.  None if it is that of all that have it.
    share
        An upper bound, in [0, 1], of the share of their radiance that all rays of this formula together send on from
        the hit: where `CARRIED` times it falls below the plan's tolerance they are not followed, and what they would
        bring is bounded in the tail.  None if nothing is known to be lost.
    """

    via: str
    hit: Int[np.ndarray, " ray"]
    rays: Rays | None
    weight: Float[np.ndarray, " ray"]
    factors: Mapping[str, Float[np.ndarray, " ray"]] = field(default_factory=dict)
    state: Mapping[str, np.ndarray] = field(default_factory=dict)
    materials: frozenset[str] | None = None
    share: Float[np.ndarray, " ray"] | None = None

    def of(self, which: Int[np.ndarray, " some"]) -> "Sent":
        """Some of the rays, in ascending order."""
        return replace(
            self,
            hit=self.hit[which],
            rays=None if self.rays is None else self.rays[which],
            weight=self.weight[which],
            factors={name: values[which] for name, values in self.factors.items()},
            state={name: values[which] for name, values in self.state.items()},
            share=None if self.share is None else self.share[which],
        )


@dataclass(frozen=True, eq=False)
class Passed:
    """The share of a light that an effect lets through to some hits.

    Parameters
    ----------
    error
        Its estimated error, where it is not exact.
    rays
        Number of rays that were cast to find it.
    """

    share: PerHit
    error: PerHit | None = None
    rays: int = 0


@dataclass(frozen=True, eq=False)
class Segment:
    """What an effect tells of rays on their way to their hits.

    Parameters
    ----------
    inside
        By the name of its transmittance, the length that each ray went in an absorbing material; 0 outside of it.
    state
        Values that the effect keeps for each ray from here on.
    """

    inside: Mapping[str, PerHit]
    state: Mapping[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect: a name, the test whether a scene calls for it, and a function at each seam where it acts.

    Parameters
    ----------
    call
        The call of a scene, with its alternative materials, for this effect.
    needed
        The reason that it cannot be left out on request; empty where the error without it can be bounded.
    unbounded
        True if no bound is known of the error without it: certificates are of everything else then.
    film
        The samples of the film in a window, and their rays from the camera; the pixels' centres without it.
    surface
        The materials that a name stands for at some hits, with their shares; None for a name that is not its own.
    arriving
        The share of a light's sample, as seen from the given hits, that reaches them, in [0, 1].
    figures
        The kind of figure of the samples that `arriving` is for; that of None for samples that stand for a place.
    segment
        What rays met on their way to their hits; asked also where the effect is left out.
    emitted
        The light that hits send to the viewer by themselves.
    onwards
        The rays that hits send on.
    gathers
        Formulas that lights meet, by which `onwards` sends rays on as well: certificates are to count them.
    state
        Names of the values that it keeps for each ray, with those that the camera's rays start with: the same for all,
        or a function of the film's samples.
    """

    name: str
    call: Callable[[Scene, Alternatives], Call]
    needed: str = ""
    unbounded: bool = False
    film: Callable[[Camera, Window], tuple[Film, Rays]] | None = None
    surface: Callable[[Stage, str, View, Which], Mapping[str, PerHit] | None] | None = None
    arriving: Callable[[Stage, View, Light, Which, Illumination], Passed] | None = None
    figures: type = NoneType
    segment: Callable[[Stage, Batch, View, Hits], Segment] | None = None
    emitted: Callable[[Stage, View], tuple[Emitted, ...]] | None = None
    onwards: Callable[[Stage, View, tuple[Points, ...]], tuple[Sent, ...]] | None = None
    gathers: tuple[Literal["direct", "ambient"], ...] = ()
    state: Mapping[str, float | int | Starting] = field(default_factory=dict)

    @property
    def acts(self) -> bool:
        """True if it has a function at some seam, where it is noted which pixels it touches."""
        seams = (self.film, self.surface, self.arriving, self.segment, self.emitted, self.onwards)
        return any(seam is not None for seam in seams)
