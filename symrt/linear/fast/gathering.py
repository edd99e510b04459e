"""Paths to points, and entries of G, compiled: see `symrt.linear.paths` and `symrt.linear.matrix`."""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled

TAKES = "686c3bd67c847ec1"

Floats = Float[np.ndarray, " _"]
Whole = Int[np.ndarray, " _"]


@compiled("int64(int64[::1], int64[::1])")
def count(hit: Whole, starts: Whole) -> int:
    """The number of pairs of a point and of a path to its hit."""
    total, beyond = 0, starts.size - 2
    for k in range(hit.size):
        at = min(hit[k], beyond)
        total += starts[at + 1] - starts[at]
    return total


@compiled(
    "void(int64[::1], float64[::1], int64[::1], int64[::1], float64[::1], int64[::1], "
    "int64[::1], int64[::1], int64[::1], float64[::1])"
)
def pairs(
    hit: Whole,
    value: Floats,
    starts: Whole,
    products: Whole,
    coefficient: Floats,
    pixels: Whole,
    which: Whole,
    product: Whole,
    pixel: Whole,
    carried: Floats,
) -> None:
    """Write each of those: the point, the path's product, the hit's pixel, and the path's number times the point's."""
    total, beyond = 0, starts.size - 2
    for k in range(hit.size):
        at = min(hit[k], beyond)
        for path in range(starts[at], starts[at + 1]):
            which[total], product[total], pixel[total] = k, products[path], pixels[hit[k]]
            carried[total] = coefficient[path] * value[k]
            total += 1


@compiled("int64(int64[::1], int64[::1], int32[::1], float64[::1], int32[::1], int32[::1], float64[::1])")
def keep(
    pixel: Whole, which: Whole, number: Whole, value: Floats, pixels: Whole, columns: Whole, values: Floats
) -> int:
    """Write the entries that are not 0; the answer is their number."""
    kept = 0
    for k in range(value.size):
        if value[k] != 0:
            pixels[kept], columns[kept], values[kept] = pixel[k], number[which[k]], value[k]
            kept += 1
    return kept
