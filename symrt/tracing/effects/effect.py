"""The record of an effect: what in a scene calls for it, and the seams of the tracer at which it acts (step 1)."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Int

from symrt.arrays import Vectors
from symrt.geometry.rays import Rays
from symrt.scene.cameras import Camera, Window
from symrt.scene.records import Scene
from symrt.tracing.raytree import Emitted, Film, Points
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View

Hits = Int[np.ndarray, " hit"]
PerHit = Float[np.ndarray, " hit"]


@dataclass(frozen=True)
class Call:
    """What a scene says to an effect.

    Parameters
    ----------
    by
        Names of what calls for it, such as lights or materials; empty where nothing does.
    without
        Why nothing calls for it, in words.
    rays
        How many rays it may cost, in words.
    left_out
        Why it is left out although something calls for it; empty where it is simulated.
    """

    by: tuple[str, ...]
    without: str
    rays: str = "none"
    left_out: str = ""


@dataclass(frozen=True, eq=False)
class Sent:
    """Rays that an effect sends on from hits, to be multiplied by one formula of the materials there.

    Parameters
    ----------
    via
        The formula, a field of `Model`, that says how much of what they bring is sent on to the viewer.
    hit
        The hit that each ray leaves from, ascending.
    weight
        A further share of each ray; over the rays that a hit sends by one formula the weights sum to at most 1.
    factors
        Cosines of each ray's own direction, where the formula names any.
    state
        What effects keep for each ray, where it changes; the rest is inherited.
    """

    via: str
    hit: Int[np.ndarray, " ray"]
    rays: Rays
    weight: Float[np.ndarray, " ray"]
    factors: Mapping[str, Float[np.ndarray, " ray"]] = field(default_factory=dict)
    state: Mapping[str, np.ndarray] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Effect:
    """An effect: a name, what calls for it, and what it does at the seams it has a function for.

    Parameters
    ----------
    call
        What a scene, with materials that may take others' places, says to it.
    needed
        Why it cannot be left out on request; empty where what is left out can be bounded.
    film
        The samples of the film in a window, and their rays from the camera; the pixels' centres without it.
    surface
        The materials that a name stands for at some hits, with their shares; None for a name that is not its own.
    arriving
        The share of a light, in given directions and at given distances, that reaches the given hits, in [0, 1].
    emitted
        What lights send to the viewer by themselves.
    onwards
        The rays that hits send on.
    state
        What it keeps for each ray, by name, with the value that rays of the camera start with.
    """

    name: str
    call: Callable[[Scene, Alternatives], Call]
    needed: str = ""
    film: Callable[[Camera, Window], tuple[Film, Rays]] | None = None
    surface: Callable[[Stage, str, View, Hits], Mapping[str, PerHit] | None] | None = None
    arriving: Callable[[Stage, View, Hits, Vectors, PerHit, Counter[str]], PerHit] | None = None
    emitted: Callable[[Stage, View], tuple[Emitted, ...]] | None = None
    onwards: Callable[[Stage, View, tuple[Points, ...]], tuple[Sent, ...]] | None = None
    state: Mapping[str, float | int] = field(default_factory=dict)
