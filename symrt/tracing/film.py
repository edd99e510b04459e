"""The samples of a film and their rays (step 1)."""

from dataclasses import replace

import numpy as np

from symrt.geometry.rays import Rays
from symrt.scene.cameras import Camera, Window, camera_rays
from symrt.tracing.raytree import Film


def regular(camera: Camera, window: Window) -> tuple[Film, Rays]:
    """A film of n × n equally weighted samples a pixel, and their rays.

    Examples
    --------
    >>> eye = Camera(position=(0, 0, 5), target=(0, 0, 0), width=2, height=1, samples=2)
    >>> film, _ = regular(eye, Window(0, 0, 2, 1))
    >>> film.pixel.tolist(), float(film.weight[0])
    ([0, 0, 0, 0, 1, 1, 1, 1], 0.25)
    """
    rays = camera_rays(camera, window)
    count, each = rays.origin.shape[1], camera.samples**2
    return Film(np.arange(count) // each, np.full(count, 1 / each)), rays


def centres(camera: Camera, window: Window) -> tuple[Film, Rays]:
    """A film with one sample in the middle of each pixel, and the samples' rays."""
    return regular(replace(camera, samples=1), window)
