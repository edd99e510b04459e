"""How kernels are compiled: every operation is rounded by itself, in the order in which it stands."""

import inspect
from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(signature: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Compile a function to what NumPy would compute: nothing is reordered or contracted, and the lock is let go.

    Without a signature it is a part of other kernels, and compiled into them.
    """

    def compile_(function: Callable[..., Any]) -> Callable[..., Any]:
        # The tests watch the types of every function; Numba must see the function itself.
        plain, part = inspect.unwrap(function), signature is None
        return njit(signature, cache=True, nogil=True, fastmath=False, error_model="numpy", forceinline=part)(plain)

    return compile_
