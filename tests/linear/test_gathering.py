"""Kernels for light at points, paths and entries: to the bit what NumPy's code computes."""

import numpy as np
import pytest
from geometry.oracles import directions

import symrt as rt
from symrt import fast
from symrt.geometry.rays import Surface
from symrt.linear.matrix import Entries
from symrt.linear.paths import Paths, _pairs
from symrt.reflection.symbols import GEOMETRY, ONE_MINUS, VIEW
from symrt.tracing.points import Reached, _lit
from symrt.tracing.view import View

pytestmark = pytest.mark.skipif(not fast.available(), reason="numba is not installed")


NAMES = frozenset(GEOMETRY) | {ONE_MINUS + name for name in GEOMETRY}


def both(action):
    """The results of NumPy and of the kernels."""
    found = []
    for kernels in (False, True):
        with fast.use(kernels):
            found.append(action())
    return found


def same(one, other, *names):
    for name in names:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), strict=True)


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_light_at_points_has_the_bits_of_numpy(share):
    # Some vectors are equal or opposite, so that cosines are 0 and 1 and half vectors vanish.
    generator = np.random.default_rng(5)
    normal, viewer, direction = (directions(generator, 900) for _ in range(3))
    viewer[:, 100:200], direction[:, 200:300], direction[:, 300:400] = normal[:, 100:200], normal[:, 200:300], 0.0
    direction[:, 300:400] = -viewer[:, 300:400]
    reached = np.flatnonzero(generator.uniform(size=900) < share)
    position = np.full(900, -1)
    position[reached] = np.arange(reached.size)
    place, none = Surface(normal, normal, normal, normal[:2], normal[:2], normal[0]), np.zeros((2, 900), np.int32)
    view = View(place, none[0], viewer, normal, normal, none[0], {}, none, branches=())
    values = generator.uniform(size=(3, reached.size))
    light = rt.PointLight("sun", position=(0, 1, 0))
    sample = Reached(light, position, direction.take(reached, axis=1), values[0], values[1], False, values[2])
    hit = np.flatnonzero(generator.uniform(size=900) < 0.7)
    one, other = both(lambda: _lit(view, sample, hit, NAMES))
    same(one, other, "point", "irradiance", "visible", "error")
    assert set(one.factors) == set(other.factors) == NAMES - VIEW
    for name in one.factors:
        np.testing.assert_array_equal(one.factors[name], other.factors[name], strict=True)


@pytest.mark.parametrize("most", [1, 3])
def test_paths_and_entries_have_the_bits_of_numpy(most):
    # Hits that no path leads to, that several do, and hits after the last; entries of 0 and of nan.
    generator = np.random.default_rng(most)
    hit = np.sort(generator.integers(0, 300, 250)) if most > 1 else np.flatnonzero(generator.uniform(size=300) < 0.8)
    products = tuple((f"m{k}.diffuse",) for k in range(most))
    paths = Paths(hit, generator.integers(0, most, hit.size), generator.normal(size=hit.size), products)
    ends, pixel = np.flatnonzero(generator.uniform(size=340) < 0.6), generator.integers(0, 64, 340)
    value = np.where(generator.uniform(size=ends.size) < 0.3, 0.0, generator.normal(size=ends.size))
    one, other = both(lambda: _pairs(ends, value, paths, pixel))
    same(one, other, "which", "product", "pixel", "value")

    columns = [rt.Interaction("sun", product) for product in products]

    def gathered(value):
        entries = Entries()
        entries.add(columns, one.product, one.pixel, value)
        entries.add(columns[:1], None, one.pixel, value)
        entries.add(columns, one.product, one.pixel, np.zeros(value.size))
        return entries

    broken = np.where(np.arange(one.value.size) == 7, np.nan, one.value)
    for given in (one.value, broken, np.zeros(one.value.size)):
        numpy, compiled = both(lambda given=given: gathered(given))
        for name in ("pixel", "column", "value"):
            parts = zip(getattr(numpy, name), getattr(compiled, name), strict=True)
            assert all(np.array_equal(a, b, equal_nan=name == "value") and a.dtype == b.dtype for a, b in parts)
