"""Textures averaged over boxes, against exact rational areas."""

import math
from fractions import Fraction

import numpy as np
import pytest

from symrt.geometry import BandedRelief, Checker, weights
from symrt.geometry.filtering import averaged
from symrt.geometry.pictures import LabelRaster, WeightRaster

RANDOM = np.random.default_rng(4)
PIXELS = RANDOM.integers(0, 3, (5, 7))
SHARES = RANDOM.dirichlet([1.0, 1.0, 1.0], (5, 7)).transpose(2, 0, 1)


def overlaps(low, high):
    """The whole numbers k whose [k, k + 1] meets an interval, and how much of it is within."""
    for k in range(math.floor(low), math.ceil(high)):
        yield k, min(high, Fraction(k + 1)) - max(low, Fraction(k))


def boxes(count, scale, largest):
    middle = RANDOM.uniform(-scale, scale, (2, count))
    return middle, np.exp(RANDOM.uniform(math.log(1e-3), math.log(largest), (2, count)))


@pytest.mark.parametrize("scale", [3.0, 1e4])
def test_a_checker_over_a_box_is_the_exact_share_of_its_squares(scale):
    middle, sides = boxes(200, scale, 9.0)
    found = averaged(Checker("tiles", ("a", "b"), 1), middle, np.ones((2, 200)), sides)
    for k in range(200):
        # The box that the floats say, to the last bit.
        ends = [(Fraction(m - s / 2), Fraction(m + s / 2)) for m, s in zip(middle[:, k], sides[:, k], strict=True)]
        parts = [dict(overlaps(*one)) for one in ends]
        even = sum(a * b for i, a in parts[0].items() for j, b in parts[1].items() if (i + j) % 2 == 0)
        expected = even / ((ends[0][1] - ends[0][0]) * (ends[1][1] - ends[1][0]))
        assert found[0, k] == pytest.approx(float(expected), abs=1e-12)


@pytest.mark.parametrize("kind", ["labels", "weights"])
def test_a_picture_over_a_box_is_the_exact_mean_of_its_pixels(kind):
    names, layers = ("a", "b", "c"), np.eye(3)[PIXELS].transpose(2, 0, 1)
    layers = layers if kind == "labels" else SHARES
    raster = LabelRaster("map", names, PIXELS) if kind == "labels" else WeightRaster("map", names, SHARES)
    uv, sides = boxes(60, 2.0, 3.0)
    found = averaged(raster, uv, np.ones((2, 60)), sides)
    # As wide as a pixel at least for weights, which blends bilinearly, and a sixteenth of one for labels.
    least = Fraction(1) if kind == "weights" else Fraction(1, 16)
    for k in range(60):
        parts = []
        for middle, side, size in zip(uv[:, k], sides[:, k], (7, 5), strict=True):
            half = max(Fraction(side) * size, least) / 2
            at = Fraction(middle) % 1 * size
            parts.append(list(overlaps(at - half, at + half)))
        area = sum(a for _, a in parts[0]) * sum(b for _, b in parts[1])
        for m in range(3):
            total = sum(a * b * Fraction(layers[m, j % 5, i % 7]) for i, a in parts[0] for j, b in parts[1])
            assert found[m, k] == pytest.approx(float(total / area), abs=1e-12)


TEXTURES = {
    "checker": Checker("tiles", ("a", "b"), 0.3),
    "labels": LabelRaster("map", ("a", "b", "c"), PIXELS),
    "weights": WeightRaster("map", ("a", "b", "c"), SHARES),
    "relief": BandedRelief("earth", levels=(-200, 0, 500), materials=("a", "b", "c", "d"), blend=50),
}


@pytest.mark.parametrize("name", TEXTURES)
def test_means_are_shares_and_boxes_of_no_size_are_points(name):
    uv, sides = RANDOM.uniform(0.02, 0.98, (2, 300)), boxes(300, 1.0, 5.0)[1]
    extent = np.full((2, 300), 1.7)
    found = averaged(TEXTURES[name], uv, extent, sides)
    assert found.min() >= 0
    np.testing.assert_allclose(found.sum(axis=0), 1, rtol=0, atol=4 * 2.0**-52)
    point = averaged(TEXTURES[name], uv, extent, np.zeros((2, 300)))
    expected = weights(TEXTURES[name], uv, extent)
    # A label's box is never less than a sixteenth of a pixel wide: near an edge it sees both sides.
    near = np.abs(uv * [[7], [5]] - np.round(uv * [[7], [5]])).min(axis=0) < 1 / 32 if name == "labels" else False
    np.testing.assert_allclose(np.where(near, expected, point), expected, atol=1e-12)


def test_what_is_no_texture_cannot_be_averaged():
    with pytest.raises(TypeError, match="str cannot be averaged; read pictures with load_texture first"):
        averaged("tiles", np.zeros((2, 1)), np.ones((2, 1)), np.ones((2, 1)))
