"""`intersect`, `nearest` and `occluded`, of NumPy and of the kernels: what a test holds of one, it holds of both."""

from importlib.util import find_spec

import numpy as np

from symrt import fast, geometry
from symrt.geometry.meeting import meet, no_hits

COMPILED = find_spec("numba") is not None


def same(one, other, *names):
    for name in names:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)


def intersect(shape, rays, low=0.0):
    found = geometry.intersect(shape, rays, low)
    if COMPILED:
        hits = no_hits(len(rays))
        with fast.use(True):
            meet(shape, 0, rays, hits, low=low)
        same(hits, found, "distance", "primitive")
        np.testing.assert_array_equal(hits.shape == 0, found.distance < np.inf)
    return found


def nearest(shapes, rays):
    with fast.use(False):
        found = geometry.nearest(shapes, rays)
    if COMPILED:
        with fast.use(True):
            same(geometry.nearest(shapes, rays), found, "distance", "shape", "primitive")
    return found


def occluded(shapes, rays, limit):
    with fast.use(False):
        found = geometry.occluded(shapes, rays, limit)
    if COMPILED:
        with fast.use(True):
            np.testing.assert_array_equal(geometry.occluded(shapes, rays, limit), found)
    return found
