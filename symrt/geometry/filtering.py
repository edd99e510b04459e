"""Textures averaged over boxes: weights that a sample sees which covers more than a point (step 1).

A box has sides along u and v.  Over it a checker is known in closed form, and a picture by its summed-area table [1]_:
all of what lies above and to the left of a place, which four places tell apart.

References
----------
.. [1] F. C. Crow, "Summed-Area Tables for Texture Mapping", SIGGRAPH 1984.
"""

from functools import singledispatch

import numpy as np
from jaxtyping import Float

from symrt.geometry.pictures import LabelRaster, WeightRaster
from symrt.geometry.textures import UV, BandedRelief, Checker, Weights, weights

PLACES = 4
"""Places along either side of a box at which a relief is looked at."""


@singledispatch
def averaged(texture: object, uv: UV, extent: UV, sides: UV) -> Weights:  # noqa: ARG001 (registered for each texture)
    """Weights of the texture's materials, averaged over a box around each point: not negative, summing to 1.

    Parameters
    ----------
    extent
        Scene units per unit of u and v.
    sides
        Of the boxes, along u and v, in the units of `uv`; for 0 the weights are those at the point.

    Examples
    --------
    >>> tiles = Checker("tiles", ("white", "black"), size=1)
    >>> averaged(tiles, np.array([[1.0, 0.5], [0.5, 0.5]]), np.ones((2, 2)), np.full((2, 2), 0.5))
    array([[0.5, 1. ],
           [0.5, 0. ]])
    """
    raise TypeError(f"{type(texture).__name__} cannot be averaged; read pictures with load_texture first")


@averaged.register(Checker)
def averaged_checker(texture: Checker, uv: UV, extent: UV, sides: UV) -> Weights:
    """The exact share of squares of either kind in each box.

    With s(x) = 1 where floor(x) is even, else −1, it is half of 1 ± the product of the means of s along u and v.

    Examples
    --------
    >>> tiles = Checker("tiles", ("a", "b"), 1)
    >>> averaged_checker(tiles, np.array([[0.0], [0.25]]), np.ones((2, 1)), np.array([[3.0], [0.0]])).T
    array([[0.5, 0.5]])
    """
    middle, half = uv * extent / texture.size, np.abs(sides * extent) / texture.size / 2
    means = _mean_sign(middle - half, middle + half, middle)
    balance = np.clip(means[0] * means[1], -1.0, 1.0)
    return np.stack([(1 + balance) / 2, (1 - balance) / 2])


def _mean_sign(low: UV, high: UV, middle: UV) -> UV:
    """The mean of s between two places; its integral is a triangle wave, known without rounding from x modulo 2."""
    wide = high - low
    share = (1 - np.abs(1 - np.mod(high, 2))) - (1 - np.abs(1 - np.mod(low, 2)))
    sign = 1 - 2 * np.mod(np.floor(middle), 2)
    within = (np.floor(low) == np.floor(high)) | (wide <= 0)
    return np.where(within, sign, share / np.where(within, 1.0, wide))


@averaged.register(BandedRelief)
def averaged_relief(texture: BandedRelief, uv: UV, extent: UV, sides: UV) -> Weights:
    """The mean of the bands over a regular grid of places in each box, an approximation.

    Examples
    --------
    >>> earth = BandedRelief("earth", levels=(0,), materials=("sea", "land"))
    >>> averaged_relief(earth, np.array([[0.5], [0.5]]), np.ones((2, 1)), np.zeros((2, 1))).T
    array([[1., 0.]])
    """
    within = (np.arange(PLACES) + 0.5) / PLACES - 0.5
    total = np.zeros((len(texture.materials), uv.shape[1]))
    for down in within:
        for right in within:
            there = uv + np.array([[right], [down]]) * sides
            # Beyond a pole the polar row goes on.
            there[1] = np.clip(there[1], 0.0, 1.0)
            total += weights(texture, there, extent)
    return total / PLACES**2


@averaged.register(LabelRaster)
def averaged_labels(texture: LabelRaster, uv: UV, extent: UV, sides: UV) -> Weights:  # noqa: ARG001
    """The share of each label in each box; a box is a sixteenth of a pixel wide at least.

    Examples
    --------
    >>> halves = LabelRaster("halves", ("sea", "land"), np.array([[0, 1]]))
    >>> averaged_labels(halves, np.array([[0.5], [0.5]]), np.ones((2, 1)), np.array([[0.5], [0.5]])).T
    array([[0.5, 0.5]])
    """
    return _means(texture.table, uv, sides, least=1 / 16)


@averaged.register(WeightRaster)
def averaged_shares(texture: WeightRaster, uv: UV, extent: UV, sides: UV) -> Weights:  # noqa: ARG001
    """The mean of the pixels' weights in each box; one of a pixel's size is what blending bilinearly is.

    Examples
    --------
    >>> fade = WeightRaster("fade", ("a", "b"), np.array([[[1.0, 0.0]], [[0.0, 1.0]]]))
    >>> averaged_shares(fade, np.array([[0.25, 0.5], [0.5, 0.5]]), np.ones((2, 2)), np.zeros((2, 2)))
    array([[1. , 0.5],
           [0. , 0.5]])
    """
    return _means(texture.table, uv, sides, least=1.0)


def _means(table: Float[np.ndarray, "material row column"], uv: UV, sides: UV, least: float) -> Weights:
    """Means over boxes of a picture that repeats, from its summed-area table; `least` is a box's side in pixels."""
    size = np.array([table.shape[2] - 1, table.shape[1] - 1])[:, None]
    half = np.maximum(np.abs(sides) * size, least) / 2
    middle = np.mod(uv, 1.0) * size
    (left, top), (right, low) = middle - half, middle + half
    total = _sum_before(table, right, low) - _sum_before(table, left, low)
    total = total - (_sum_before(table, right, top) - _sum_before(table, left, top))
    # A material that is not there may come out below 0 by rounding; the shares are those of what is there.
    total = np.maximum(total, 0.0)
    return total / total.sum(axis=0)


def _sum_before(
    table: Float[np.ndarray, "material row column"], x: Float[np.ndarray, " hit"], y: Float[np.ndarray, " hit"]
) -> Weights:
    """The sum of a picture's weights up to a place, in pixels, whole pictures on the way included."""
    rows, columns = table.shape[1] - 1, table.shape[2] - 1
    (across, x), (down, y) = np.divmod(x, columns), np.divmod(y, rows)
    whole_rows = _between(table, np.full(x.size, float(columns)), y)
    whole_columns = _between(table, x, np.full(y.size, float(rows)))
    corner = table[:, -1:, -1]
    return across * down * corner + across * whole_rows + down * whole_columns + _between(table, x, y)


def _between(
    table: Float[np.ndarray, "material row column"], x: Float[np.ndarray, " hit"], y: Float[np.ndarray, " hit"]
) -> Weights:
    """A summed-area table between its places: bilinear, as weights are alike all over a pixel."""
    i = np.minimum(y.astype(np.int64), table.shape[1] - 2)
    j = np.minimum(x.astype(np.int64), table.shape[2] - 2)
    down, right = y - i, x - j
    upper = table[:, i, j] * (1 - right) + table[:, i, j + 1] * right
    lower = table[:, i + 1, j] * (1 - right) + table[:, i + 1, j + 1] * right
    return upper * (1 - down) + lower * down
