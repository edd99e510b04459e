"""A thin lens: a pixel is seen from many places on it, by rays that meet where it is sharp (an effect of step 1).

Places are spread evenly, and otherwise in each pixel of the whole picture, so that a tile knows nothing of tiles.
Samples across a pixel and places on the lens go together: each film position has places of its own.
"""

import numpy as np

from symrt.geometry.rays import Rays
from symrt.scene.cameras import Camera, Window, lens_rays
from symrt.scene.records import Scene
from symrt.tracing.effects.effect import Call, Effect
from symrt.tracing.nets import disk, net
from symrt.tracing.raytree import Film
from symrt.tracing.stage import Alternatives


def _call(scene: Scene, alternatives: Alternatives) -> Call:  # noqa: ARG001  the camera alone calls for it
    camera = scene.camera
    wide = camera.lens_diameter > 0
    asked = (f"camera.{'aperture' if camera.f_number is None else 'f_number'}",) if wide else ()
    return Call(asked, without="the camera is a pinhole", rays=str(camera.width * camera.height * camera.rays_a_pixel))


def _film(camera: Camera, window: Window) -> tuple[Film, Rays]:
    """A film whose pixels have a place on the lens for each sample, all of one weight."""
    # The pixels' numbers in the whole picture say which places they have.
    row, column = np.divmod(np.arange(window.width * window.height), window.width)
    number = (row + window.top) * camera.width + column + window.left
    each = camera.rays_a_pixel
    lens = disk(net(number, each).reshape(2, -1))

    # The places of each film position follow each other, and are two halves.
    count = number.size * each
    half = np.arange(count) % camera.lens_places >= camera.lens_places // 2
    return Film(np.arange(count) // each, np.full(count, 1 / each), half), lens_rays(camera, window, lens)


LENS = Effect("lens", _call, needed="a lens shows what no pinhole does; set camera.aperture = 0", film=_film)
