"""Surfaces where rays meet them, and the rays that start there, compiled: see `symrt.geometry` for what is computed.

A kernel does in one loop what NumPy does in a dozen, each of which would let go of the interpreter's lock and ask for
it again: threads that meet there all the time are no faster than one.
"""

import numpy as np
from jaxtyping import Bool

from symrt.fast.compiling import compiled
from symrt.fast.pairs import Triple, difference, dot, exact, most, pair_dot
from symrt.geometry.fast.asking import Chosen, Constants, Floats, Vectors

TAKES = "686c3bd67c847ec1"
SMALLEST, LARGEST = 2.0**-400, 2.0**400


@compiled()
def _plain(x: float) -> bool:
    """Whether neither a square of the number nor a quotient of two such overflows, or loses digits to underflow."""
    return (x == 0) | ((abs(x) >= SMALLEST) & (abs(x) <= LARGEST))


@compiled("int64(float64[:, ::1], float64[:, ::1], float64[::1])")
def units(v: Vectors, unit: Vectors, size: Floats) -> int:
    """Write unit vectors and lengths; the answer is the number of vectors that need more care."""
    careful = 0
    for i in range(size.size):
        x, y, z = v[0, i], v[1, i], v[2, i]
        long = np.sqrt(x * x + y * y + z * z)
        unit[0, i], unit[1, i], unit[2, i], size[i] = x / long, y / long, z / long, long
        careful += 0 if _plain(x) & _plain(y) & _plain(z) & (long > 0) else 1
    return careful


@compiled("int64(float64[:, ::1], float64[:, ::1], float64)")
def unfit(origin: Vectors, direction: Vectors, largest: float) -> int:
    """The number of rays that do not start within `largest`, or have no direction of unit length."""
    count = 0
    for i in range(origin.shape[1]):
        d = direction[0, i], direction[1, i], direction[2, i]
        near = (abs(origin[0, i]) <= largest) & (abs(origin[1, i]) <= largest) & (abs(origin[2, i]) <= largest)
        count += 0 if near & (abs(dot(d, d) - 1) < 1e-12) else 1
    return count


@compiled("void(float64[:, ::1], float64[:, ::1], float64[::1], float64[:, ::1], float64[:, ::1], boolean[::1])")
def spawn(
    point: Vectors, normal: Vectors, error: Floats, direction: Vectors, origin: Vectors, below: Bool[np.ndarray, " ray"]
) -> None:
    """Write where rays start that leave a surface, and whether they leave it on the other side than its normal's."""
    for i in range(error.size):
        n, d = (normal[0, i], normal[1, i], normal[2, i]), (direction[0, i], direction[1, i], direction[2, i])
        cosine = dot(n, d)
        below[i] = cosine < 0
        if abs(cosine) <= 8 * 2.0**-53:
            below[i] = pair_dot(exact(n), exact(d))[0] < 0
    for i in range(error.size):
        step = (-2.0 if below[i] else 2.0) * error[i]
        origin[0, i] = point[0, i] + step * normal[0, i]
        origin[1, i] = point[1, i] + step * normal[1, i]
        origin[2, i] = point[2, i] + step * normal[2, i]


@compiled(
    "void(float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], "
    "boolean[::1])"
)
def look(
    direction: Vectors,
    normal: Vectors,
    shading: Vectors,
    viewer: Vectors,
    turned: Vectors,
    smoothed: Vectors,
    behind: Bool[np.ndarray, " hit"],
) -> None:
    """Write the way to the viewer, both normals turned to it, and whether the true one had to be."""
    for i in range(behind.size):
        v = -direction[0, i], -direction[1, i], -direction[2, i]
        n, s = (normal[0, i], normal[1, i], normal[2, i]), (shading[0, i], shading[1, i], shading[2, i])
        behind[i] = dot(n, v) < 0
        n = (-n[0], -n[1], -n[2]) if behind[i] else n
        s = (-s[0], -s[1], -s[2]) if dot(s, n) < 0 else s
        viewer[0, i], viewer[1, i], viewer[2, i] = v
        turned[0, i], turned[1, i], turned[2, i] = n
        smoothed[0, i], smoothed[1, i], smoothed[2, i] = s


FOUND = (
    "float64[:, ::1], float64[:, ::1], float64[::1], int64[::1], "
    "float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[:, ::1], float64[::1]"
)
"""The end of the signature of a shape's surface: rays, distances, those that meet it; what is written of them."""


@compiled()
def _write(i: int, met: Triple, unit: Triple, point: Vectors, normal: Vectors, shading: Vectors) -> None:
    point[0, i], point[1, i], point[2, i] = met
    normal[0, i], normal[1, i], normal[2, i] = unit
    shading[0, i], shading[1, i], shading[2, i] = unit


@compiled(f"void(UniTuple(float64, 7), {FOUND})")
def sphere(
    constants: Constants,
    origin: Vectors,
    direction: Vectors,
    distance: Floats,
    chosen: Chosen,
    point: Vectors,
    normal: Vectors,
    shading: Vectors,
    extent: Vectors,
    error: Floats,
) -> None:
    """The surface of a sphere, without its coordinates."""
    x, y, z, radius, reach, across, down = constants
    for k in range(chosen.size):
        i = chosen[k]
        t = distance[i]
        a = ((origin[0, i] - x) + t * direction[0, i]) / radius
        b = ((origin[1, i] - y) + t * direction[1, i]) / radius
        c = ((origin[2, i] - z) + t * direction[2, i]) / radius
        # The normal there, and the point pulled back onto the ball along it.
        size = np.sqrt(a * a + b * b + c * c)
        if size == 0:
            a, b, c, size = -direction[0, i], -direction[1, i], -direction[2, i], 1.0
        unit = a / size, b / size, c / size
        met = x + radius * unit[0], y + radius * unit[1], z + radius * unit[2]
        _write(i, met, unit, point, normal, shading)
        extent[0, i], extent[1, i] = across, down
        error[i] = 8 * 2.0**-53 * (most(most(abs(met[0]), abs(met[1])), abs(met[2])) + reach + radius)


@compiled(f"void(UniTuple(float64, 12), {FOUND})")
def flat(
    constants: Constants,
    origin: Vectors,
    direction: Vectors,
    distance: Floats,
    chosen: Chosen,
    point: Vectors,
    normal: Vectors,
    shading: Vectors,
    extent: Vectors,
    error: Floats,
) -> None:
    """The surface of a plane, or of a part of it, without its coordinates."""
    k = constants
    at, along, unit = (k[0], k[1], k[2]), (k[3], k[4], k[5]), (k[6], k[7], k[8])
    square = dot(along, along)
    for one in range(chosen.size):
        i = chosen[one]
        t = distance[i]
        x, y, z = (
            origin[0, i] + t * direction[0, i],
            origin[1, i] + t * direction[1, i],
            origin[2, i] + t * direction[2, i],
        )
        # How far it lies off the plane, by which it is pulled back.
        height = pair_dot(difference((x, y, z), at), exact(along))[0] / square
        met = x - height * along[0], y - height * along[1], z - height * along[2]
        _write(i, met, unit, point, normal, shading)
        extent[0, i], extent[1, i] = k[10], k[11]
        error[i] = 4 * 2.0**-53 * ((abs(met[0]) + abs(met[1]) + abs(met[2])) + k[9])
