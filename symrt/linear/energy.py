"""The energy that models send on, as shares of what they receive: no surface should brighten light (before step 1).

Of a lamp's light a surface sends on ``∫ direct · (n·v) dω / (n·l)``, which is looked at from many directions; of light
from everywhere its ``ambient``; of further rays' light all formulas by which it sends them on, together.  A material's
reflectances may sum to 1, so that one of them is 1 at a time, or none is.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache

import numpy as np
from jaxtyping import Float

from symrt.arrays import normalise, reflect
from symrt.linear.compiled import Compiled, compile_formula
from symrt.reflection.models import Model
from symrt.reflection.symbols import FRESNEL
from symrt.scene.records import Scene
from symrt.symbols import halves
from symrt.tracing.factors import factors

ROUNDING = 2e-3
"""Share above 1 that passes for none: integrals err by less."""
ANGLES = np.radians([0.5, *range(10, 90, 10), 85, 89])
"""Angles between the normal and the light."""
RINGS, SPOKES = 64, 64
"""Directions to the viewer: rings about the light's mirror image, closest where a highlight is, and places on each."""


def brightening(scene: Scene) -> Iterator[str]:
    """Sentences about materials of some shape that can send on more light than they receive.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> list(brightening(load_scene(shipped_scene("first"))))
    []
    """
    # Materials that do so in the same way are told of together.
    found: dict[tuple[str, str], dict[str, float]] = {}
    for material in scene.materials:
        if material.name in scene.used_materials:
            parameters = tuple(sorted(material.parameters.items()))
            for light, (share, alone) in _shares(material.reflection, parameters).items():
                if share > 1 + ROUNDING:
                    found.setdefault((light, alone), {})[material.name] = share
    for (light, alone), shares in found.items():
        names, more = ", ".join(shares), 100 * (max(shares.values()) - 1)
        where = f"where {alone} is 1" if alone else "whatever the reflectances are"
        yield f"{names}: of the light of {light} up to {more:.2g} % more is sent on than is received, {where}."


@lru_cache(256)
def _shares(model: Model, parameters: tuple[tuple[str, float], ...]) -> Mapping[str, tuple[float, str]]:
    """For each kind of light the largest share that is sent on, and the reflectance that is 1 there."""
    direct, ambient, onwards = (
        compile_formula(formula, "x", dict(parameters)) for formula in (model.direct, model.ambient, model.sent_on())
    )
    facing = np.linspace(0.0, 1.0, 257)
    seen = {"n_dot_v": facing, "one_minus_n_dot_v": 1 - facing}
    ends = [
        seen | {"fresnel": np.full(facing.size, f), "transmission": np.full(facing.size, 1 - f)} for f in (0.0, 1.0)
    ]
    names = model.factors - FRESNEL
    return {
        "lamps": max(_of_lamp(direct, names, float(angle)) for angle in ANGLES) if direct.terms else (0.0, ""),
        "other surfaces": max(_largest(onwards, at) for at in ends),
        "a sky": _largest(ambient, seen),
    }


def _of_lamp(direct: Compiled, names: frozenset[str], angle: float) -> tuple[float, str]:
    """The share of a lamp's light from one direction that is sent on to all others."""
    # Directions about the mirrored one, with the solid angle that each stands for; those below the surface see nothing.
    nodes, weights = np.polynomial.legendre.leggauss(RINGS)
    place, share = (nodes + 1) / 2, weights / 2
    polar = np.repeat(np.pi * place**3, SPOKES)
    solid = np.repeat(3 * np.pi * place**2 * share, SPOKES) * np.sin(polar) * 2 * np.pi / SPOKES
    round_ = np.tile(2 * np.pi * (np.arange(SPOKES) + 0.5) / SPOKES, RINGS)
    normal, light = np.array([[0.0], [0.0], [1.0]]), np.array([[np.sin(angle)], [0.0], [np.cos(angle)]])
    axis = reflect(light, normal)
    across = np.array([[axis[2, 0]], [0.0], [-axis[0, 0]]])
    side = np.array([[0.0], [1.0], [0.0]])
    viewer = np.cos(polar) * axis + np.sin(polar) * (np.cos(round_) * across + np.sin(round_) * side)
    above = np.flatnonzero(viewer[2] > 0)
    viewer, solid = normalise(viewer[:, above]), solid[above]

    at = factors(names, np.broadcast_to(normal, viewer.shape), viewer, np.broadcast_to(light, viewer.shape))
    return _largest(direct, at, solid * viewer[2] / np.cos(angle))


def _largest(
    formula: Compiled, at: Mapping[str, Float[np.ndarray, " place"]], weight: Float[np.ndarray, " place"] | None = None
) -> tuple[float, str]:
    """The largest value of a formula, or of its integral, with one reflectance 1 or none, and that reflectance."""
    size = next(iter(at.values())).size if weight is None else weight.size
    terms = list(zip(formula.terms, formula.coefficients(at, size), strict=True))
    found = [(0.0, "")]
    for alone in ("", *sorted({name for (met, _), _ in terms for name in met})):
        values = sum((c for (met, _), c in terms if set(met) <= {alone}), np.zeros(size))
        found.append((float(values.max() if weight is None else np.sum(weight * values)), halves(alone)[1]))
    return max(found)
