"""Textures: surfaces that blend materials, ``M(x) = Σ_j w_j(x) M_j`` with Σ w = 1 (an effect of step 1)."""

from collections.abc import Mapping

import numpy as np

from symrt.geometry.filtering import averaged
from symrt.geometry.textures import weights
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect, PerHit
from symrt.tracing.effects.footprints import ALONG_U, ALONG_V
from symrt.tracing.stage import Alternatives, Stage
from symrt.tracing.view import View, Which


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  an alternative takes a material's place
    return Call(tuple(sorted(scene.used_textures)), without="no surface has one")


def _blend(stage: Stage, name: str, view: View, hit: Which) -> Mapping[str, PerHit] | None:
    """The shares of a texture's materials at some hits; a material that stands twice in it has the sum."""
    texture = stage.textures.get(name)
    if texture is None:
        return None
    place = view.surface.uv[:, hit], view.surface.extent[:, hit]
    if ALONG_U in view.state and getattr(texture, "filtered", False):
        share = averaged(texture, *place, np.stack([view.state[along][hit] for along in (ALONG_U, ALONG_V)]))
    else:
        share = weights(texture, *place)
    blended: dict[str, PerHit] = {}
    for material, row in zip(texture.materials, share, strict=True):  # type: ignore[attr-defined]
        blended[material] = blended.get(material, 0) + row
    return blended


TEXTURES = Effect("textures", _call, needed="a surface with a texture has no other material", surface=_blend)
