"""Supersampling: n × n regular samples a pixel, each with the weight 1/n² (an effect of step 1)."""

from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.film import regular
from symrt.tracing.stage import Alternatives


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  the camera alone calls for it
    camera = scene.camera
    asked = (f"camera.samples = {camera.samples}",) if camera.samples > 1 else ()
    rays = str(camera.width * camera.height * camera.samples**2)
    return Call(asked, without="the pixel's centre is asked for", rays=rays)


SUPERSAMPLING = Effect(
    "supersampling",
    _call,
    needed="between samples nothing is known; set camera.samples = 1",
    film=regular,
)
