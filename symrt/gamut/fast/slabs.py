"""Lines against slabs, compiled (step 5): the quotients of `symrt.gamut.clipping`, and where they can be relied on.

A few pixels are taken slab by slab, side by side, as a processor does them several at a time.
"""

import numpy as np
from jaxtyping import Bool, Float

from symrt.fast.compiling import compiled

TAKES = "686c3bd67c847ec1"
WIDE = 64
"""Pixels side by side."""
SAFE, TINY = 2.0**200, 2.0**-600
"""As in `symrt.gamut.clipping`."""

Row = Float[np.ndarray, " pixel"]


@compiled()
def _narrow(a_: float, b_: float, q: Row, d: Row, near: Row, far: Row) -> None:
    """Intersect the intervals of the pixels with those that a slab allows; nan, where there is any, stays."""
    for j in range(WIDE):
        a, b = (a_ - q[j]) / d[j], (b_ - q[j]) / d[j]
        least, most = (a if a < b else b), (b if a < b else a)
        odd = np.isnan(a) | np.isnan(b) | np.isnan(near[j])
        near[j] = np.nan if odd else (least if least > near[j] else near[j])
        far[j] = most if most < far[j] else far[j]


@compiled()
def _measure(values: Row, least: Row, most: Row) -> None:
    """The smallest size that is not 0, and the largest, of what each pixel has seen."""
    for j in range(WIDE):
        size = abs(values[j])
        most[j] = size if size > most[j] else most[j]
        least[j] = size if (size < least[j]) & (size > 0) else least[j]


@compiled(
    "void(float64[::1], float64[::1], float64[:, ::1], float64[:, ::1], float64[::1], float64[::1], boolean[::1])"
)
def quotients(
    lower: Float[np.ndarray, " slab"],
    upper: Float[np.ndarray, " slab"],
    origin: Float[np.ndarray, "pixel slab"],
    direction: Float[np.ndarray, "pixel slab"],
    low: Row,
    high: Row,
    careful: Bool[np.ndarray, " pixel"],
) -> None:
    """Write the ends of each pixel's interval, unmoved; say for which pixels they cannot be relied on."""
    q, d, near, far = np.zeros(WIDE), np.ones(WIDE), np.empty(WIDE), np.empty(WIDE)
    least_q, most_q, least_d, most_d = np.empty(WIDE), np.empty(WIDE), np.empty(WIDE), np.empty(WIDE)
    for start in range(0, low.size, WIDE):
        count = min(WIDE, low.size - start)
        near[:], far[:], least_q[:], least_d[:], most_q[:], most_d[:] = -np.inf, np.inf, np.inf, np.inf, 0.0, 0.0
        for k in range(lower.size):
            for j in range(count):
                q[j], d[j] = origin[start + j, k], direction[start + j, k]
            _narrow(lower[k], upper[k], q, d, near, far)
            _measure(q, least_q, most_q)
            _measure(d, least_d, most_d)

        # nan stands for 0 / 0, parallel to a slab and on its face, or for a line that is not finite.
        for j in range(count):
            small = (abs(near[j]) < TINY) | (abs(far[j]) < TINY)
            endless = np.isinf(near[j]) | np.isinf(far[j])
            large, tiny = not most_d[j] < SAFE, small & (least_q[j] < TINY * SAFE)
            steep = endless & ((least_d[j] < 1 / SAFE) | (not most_q[j] < SAFE))
            low[start + j], high[start + j] = near[j], far[j]
            careful[start + j] = np.isnan(near[j]) | large | tiny | steep
