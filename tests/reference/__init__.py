"""A plain spectral ray tracer: the oracle that symrt's pictures are held against.

One ray at a time, one float at a time, textbook formulas and recursion.  Nothing of symrt is imported, and spectra are
multiplied as the light travels: there are no symbols, no matrix and no arrays here.  A scene file is read directly;
what a file cannot say, such as a rule that sends on several rays from a hit, is a closure in the `Scene`.

References
----------
.. [1] A. S. Glassner (ed.), "An Introduction to Ray Tracing", Academic Press, 1989.
"""

from reference.files import load, load_palette
from reference.picture import picture, pixel, render
from reference.records import Hit, Illumination, Ray, Sample, Scene
from reference.textures import banded_relief
from reference.tracer import mirror_ray

__all__ = [
    "Hit",
    "Illumination",
    "Ray",
    "Sample",
    "Scene",
    "banded_relief",
    "load",
    "load_palette",
    "mirror_ray",
    "picture",
    "pixel",
    "render",
]
