"""Paths that gather light from other surfaces: what is kept for each of their rays, and the numbers they are drawn by.

All film samples share one set of points of Sobol's sequence, a point for each path; each sample flips binary digits of
its own in them.  Which digits depends on the sample's place in the whole picture alone, so that no tile matters.
"""

import numpy as np
from jaxtyping import Float, Int, UInt64

from symrt.scene.cameras import Camera, Window
from symrt.tracing.nets import hashed
from symrt.tracing.raytree import Film
from symrt.tracing.sobol import BITS, sequence

GATHERED, PATH, SEED = "gathered", "path", "seed"
"""Names of the states of a ray: diffusers that sent its path on, the path's number, its sample's seed."""
DIRECTION, LIGHT = 0, 2
"""Of the four dimensions of each bounce, the first of those that draw a direction, and a place on a light."""

Numbers = Float[np.ndarray, " ray"]


def seeds(film: Film, camera: Camera, window: Window) -> UInt64[np.ndarray, " sample"]:
    """A number for each sample of the film, from its pixel's place in the whole picture and its own in the pixel."""
    down, across = np.divmod(film.pixel, window.width)
    pixel = (window.top + down) * camera.width + window.left + across
    within = np.arange(film.pixel.size) - np.searchsorted(film.pixel, film.pixel)
    return hashed(pixel.astype(np.uint64) << np.uint64(20) | within.astype(np.uint64))


def drawn(
    seed: UInt64[np.ndarray, " ray"], path: Int[np.ndarray, " ray"], paths: int, dimension: int
) -> tuple[Numbers, Numbers]:
    """Two numbers between 0 and 1 for each ray, both ends excluded: those of its path in two dimensions.

    Parameters
    ----------
    seed, path
        Of each ray, the seed of its film sample and the number of its path.
    paths
        Number of paths in all.
    dimension
        The first of the two dimensions.
    """
    # One hash has digits to flip for both.
    flips = hashed(seed + np.uint64(dimension))
    high, low = (flips >> np.uint64(BITS)).astype(np.uint32), flips.astype(np.uint32)
    first, second = (
        (sequence(paths, dimension + k)[path] ^ flip) * 2.0**-BITS + 2.0 ** -(BITS + 1)
        for k, flip in enumerate((high, low))
    )
    return first, second
