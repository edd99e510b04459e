"""Toy effects and a toy light that tests register: each is one record, and nothing else of symrt changes for them.

`test_against_reference` tells the same rules to the plain tracer, in words of its own.
"""

from dataclasses import dataclass, replace

import numpy as np

import symrt as rt
from symrt.arrays import dot, normalise
from symrt.geometry.rays import spawn
from symrt.tracing.effects import Call, Effect, Sent
from symrt.tracing.factors import factors, reflect
from symrt.tracing.film import regular
from symrt.tracing.raytree import Emitted, Film
from symrt.tracing.stage import senders

MIRRORED, BACK = 0.3, 0.7
"""Shares of the toy glass: along the mirrored view, and straight back to where it is seen from."""
LEANING = (0.48, 0.36, -0.5)
"""Added to a surface's normal, it gives where the toy scatter sends a third ray; shorter than 1, so never into it."""
TENT = (0.0625, 0.125, 0.0625, 0.125, 0.25, 0.125, 0.0625, 0.125, 0.0625)
"""Weights of a pixel's 3 × 3 samples that fall off from its middle."""


def _glass(stage, view, points):
    """Two rays from each hit of a material that reflects, with fixed shares."""
    glassy = [part.hit for part in points if "reflected" in stage.materials[part.material].model.sending]
    hit = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *glassy]))
    ways = ((reflect(view.viewer[:, hit], view.shading_normal[:, hit]), MIRRORED), (view.viewer[:, hit], BACK))
    return tuple(
        _sent("reflected", view, hit, direction, np.full(hit.size, share), bounces=view.state["bounces"][hit] + 1)
        for direction, share in ways
    )


def _scatter(_stage, view, _points):
    """Rays by two formulas: mirrored and straight back by one, with shares by the angle, and aslant by the other.

    The first two are one branch of two rays a hit.
    """
    hit = np.arange(view.slot.size)
    normal, viewer = view.shading_normal, view.viewer
    facing = dot(normal, viewer)
    aslant = normalise(normal + np.array(LEANING)[:, None])
    cosines = factors(["n_dot_l", "one_minus_r_dot_v"], normal, viewer, aslant)
    both = np.stack([reflect(viewer, normal), viewer], axis=2).reshape(3, -1)
    shares = np.stack([facing / 2, 0.5 - facing / 2], axis=1).ravel()
    return (
        _sent("reflected", view, np.repeat(hit, 2), both, shares),
        _sent("direct", view, hit, aslant, 1 - facing / 4, cosines),
    )


def _gather(_stage, view, _points):
    """One ray for all of the half-space, aslant, of the weight that makes its irradiance π times its radiance."""
    aslant = normalise(view.shading_normal + np.array(LEANING)[:, None])
    cosines = factors(["n_dot_l"], view.shading_normal, view.viewer, aslant)
    return (_sent("direct", view, np.arange(view.slot.size), aslant, np.pi / cosines["n_dot_l"], cosines),)


def _sent(via, view, hit, direction, weight, factors=None, **state):
    surface = view.surface
    rays = spawn(surface.point[:, hit], view.normal[:, hit], surface.error[hit], normalise(direction))
    return Sent(via, hit, rays, weight, factors or {}, state)


def _glow(_stage, view):
    """Every hit sends a little light by itself."""
    hit = np.arange(view.slot.size)
    return (Emitted("ember", hit, np.full(hit.size, 0.125)),)


def _facing_glow(_stage, view):
    """Every hit glows by itself towards where it faces."""
    hit = np.arange(view.slot.size)
    return (Emitted("glow", hit, dot(view.normal, view.viewer) / 3),)


def _uneven(camera, window):
    """Nine samples, weighted by a tent, in every other column of pixels, and one in the rest."""
    film, rays = regular(replace(camera, samples=3), window)
    within, column = np.arange(film.pixel.size) % 9, window.left + film.pixel % window.width
    weight = np.where(column % 2 == 0, np.array(TENT)[within], np.where(within == 4, 1.0, 0.0))
    kept = np.flatnonzero(weight)
    return Film(film.pixel[kept], weight[kept]), rays[kept]


def always(_scene, _alternatives):
    """The call of an effect that every scene calls for."""
    return Call(("everything",), without="")


GLASS = Effect(
    "toy glass",
    lambda scene, alternatives: Call(
        senders(scene, alternatives, "reflected"), without="there is no toy glass", rays="2 a hit"
    ),
    onwards=_glass,
    state={"bounces": 0},
)
SCATTER = Effect("toy scatter", always, onwards=_scatter, gathers=("direct",))
GATHER = Effect("toy gathering", always, onwards=_gather, gathers=("direct",))
EMBER = Effect("embers", always, emitted=_glow)
GLOW = Effect("glow", always, emitted=_facing_glow)
UNEVEN = Effect("uneven film", always, film=_uneven)


@dataclass(frozen=True)
class Twin:
    """A light of one's own that reaches every point by two ways."""

    name: str
    shadows: bool = True

    def samples(self, points):
        return tuple(
            replace(one, falloff=one.falloff / 2)
            for x in (-1.0, 1.0)
            for one in rt.PointLight(self.name, position=(x, 4, 2)).samples(points)
        )
