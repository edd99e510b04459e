"""What kernels have in common (step 1): the types they are asked with, which rays are still open, and the answer."""

import numpy as np
from jaxtyping import Float, Int

from symrt.fast.compiling import compiled

Constants = tuple[float, ...]
Vectors = Float[np.ndarray, "3 ray"]
Floats = Float[np.ndarray, " ray"]
Whole = Int[np.ndarray, " ray"]
Chosen = Int[np.ndarray, " chosen"]

ASKED = (
    "float64[:, ::1], float64[:, ::1], int32[::1], float64, boolean, int32, "
    "float64[::1], int32[::1], int32[::1], int64[::1]"
)
"""The end of every kernel's signature, from `origin` to `doubtful`."""


@compiled()
def list_open(t: Floats, left: Whole, any_hit: bool, index: int, shape: Whole, chosen: Chosen) -> int:
    """List the rays whose crossing is nan, without those that need not be asked; the answer is their number."""
    count = 0
    for i in range(t.size):
        if t[i] != t[i] and left[i] != index and not (any_hit and shape[i] >= 0):
            chosen[count] = i
            count += 1
    return count


@compiled()
def gather(origin: Vectors, direction: Vectors, chosen: Chosen, count: int) -> Float[np.ndarray, "6 chosen"]:
    """Origins and directions of the chosen rays, side by side."""
    part = np.empty((6, count))
    for row in range(3):
        for k in range(count):
            part[row, k] = origin[row, chosen[k]]
            part[row + 3, k] = direction[row, chosen[k]]
    return part


@compiled()
def answer(
    t: Floats, left: Whole, any_hit: bool, index: int, distance: Floats, shape: Whole, primitive: Whole, parts: Whole
) -> None:
    """Write the crossings that are nearer than what is there; nan and inf are nearer than nothing."""
    for i in range(t.size):
        if t[i] < distance[i] and left[i] != index and not (any_hit and shape[i] >= 0):
            distance[i], shape[i], primitive[i] = t[i], index, parts[i] if parts.size else 0
