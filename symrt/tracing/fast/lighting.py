"""The part of a light's sample that reaches some points, compiled: see `symrt.tracing.points` for what is computed."""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled
from symrt.fast.pairs import Triple, dot

TAKES = "686c3bd67c847ec1"
NORMAL, VIEWER, LIGHT, MIRRORED, HALF = 0, 1, 2, 3, 4

Vectors = Float[np.ndarray, "3 _"]
Floats = Float[np.ndarray, " _"]
Whole = Int[np.ndarray, " _"]
Codes = Int[np.ndarray, "factor 3"]


@compiled(
    "int64(int64[::1], int64[::1], float64[::1], float64[::1], int64[::1], int64[::1], float64[::1], float64[::1])"
)
def reach(
    position: Whole,
    hit: Whole,
    irradiance: Floats,
    visible: Floats,
    point: Whole,
    place: Whole,
    falls: Floats,
    seen: Floats,
) -> int:
    """List the points that the sample reaches, with their places among those reached; the answer is their number."""
    count = 0
    for k in range(hit.size):
        at = position[hit[k]]
        if at >= 0:
            point[count], place[count], falls[count], seen[count] = k, at, irradiance[at], visible[at]
            count += 1
    return count


@compiled()
def _vector(letter: int, n: Triple, v: Triple, l: Triple) -> Triple:  # noqa: E741  the equations' own letter
    if letter == NORMAL:
        return n
    if letter == VIEWER:
        return v
    if letter == LIGHT:
        return l
    if letter == MIRRORED:
        twice = 2 * dot(l, n)
        return twice * n[0] - l[0], twice * n[1] - l[1], twice * n[2] - l[2]
    x, y, z = l[0] + v[0], l[1] + v[1], l[2] + v[2]
    size = np.sqrt(x * x + y * y + z * z)
    size = size if size > 0 else 1.0
    return x / size, y / size, z / size


@compiled(
    "void(int64[:, ::1], int64[::1], int64[::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1])"
)
def factors(
    codes: Codes,
    hit: Whole,
    place: Whole,
    normal: Vectors,
    viewer: Vectors,
    direction: Vectors,
    found: Float[np.ndarray, "factor _"],
) -> None:
    """Write the cosine, or 1 less the cosine, between two vectors at each hit, for each factor."""
    for k in range(codes.shape[0]):
        first, second, rest = codes[k, 0], codes[k, 1], codes[k, 2]
        for i in range(hit.size):
            h, p = hit[i], place[i]
            n, v = (normal[0, h], normal[1, h], normal[2, h]), (viewer[0, h], viewer[1, h], viewer[2, h])
            l = direction[0, p], direction[1, p], direction[2, p]  # noqa: E741  the equations' own letter
            # The two vectors of the factor, then their cosine or what is left of 1.
            a, b = _vector(first, n, v, l), _vector(second, n, v, l)
            if rest:
                d = a[0] - b[0], a[1] - b[1], a[2] - b[2]
                half = dot(d, d) / 2
                found[k, i] = half if (half <= 1) | np.isnan(half) else 1.0
            else:
                cosine = dot(a, b)
                cosine = cosine if (cosine > 0) | np.isnan(cosine) else 0.0
                found[k, i] = cosine if (cosine < 1) | np.isnan(cosine) else 1.0
