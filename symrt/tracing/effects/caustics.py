"""Caustics: light that glass bends onto other surfaces.  It is not simulated, and the plan says so.

Shadow rays end at glass, so that its shadows are full.  Rays from the eye cannot find a lamp of no size through glass,
and where glass gathers the light of such a lamp there is no end to its irradiance: no bound is known.
"""

from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.stage import Alternatives, refracting


def _call(scene: Scene, alternatives: Alternatives) -> Call:
    shone_through = any(light.shadows for light in scene.lights)
    return Call(
        refracting(scene, alternatives) if shone_through else (),
        without="no light casts shadows of glass" if scene.lights and not shone_through else "no material is of glass",
        left_out="light is not followed through glass: its shadows are full",
    )


CAUSTICS = Effect("caustics", _call, unbounded=True)
