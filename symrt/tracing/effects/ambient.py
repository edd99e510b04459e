"""Ambient light: equal radiance L from everywhere, of which a diffuser sends on ρ L (an effect of step 1).

It casts no ray: the light's one sample has no direction, and meets the ``ambient`` formulas of all materials.
"""

from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.stage import Alternatives


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  lights alone call for it
    names = tuple(light.name for light in scene.lights if getattr(light, "calls_for", None) == "ambient")
    return Call(names, without="no light is ambient")


AMBIENT = Effect("ambient", _call)
