"""Ratios of speed, taken in one run: A and B in turn, so that a machine whose speed drifts spoils neither."""

import os
import platform
import time
from collections.abc import Callable

import numpy as np


def seconds(action: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Wall time of one call, or what another clock says."""
    start = clock()
    action()
    return clock() - start


def ratio(
    one: Callable[[], object],
    other: Callable[[], object],
    pairs: int = 9,
    clock: Callable[[], float] = time.perf_counter,
) -> tuple[float, float, float]:
    """Median of one/other over pairs, and the median seconds of each; the first pair warms up and does not count."""
    times = np.array([(seconds(one, clock), seconds(other, clock)) for _ in range(pairs + 1)])[1:]
    return float(np.median(times[:, 0] / times[:, 1])), *map(float, np.median(times, axis=0))


def machine() -> str:
    """What the seconds were measured on."""
    return (
        f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}, NumPy {np.__version__}"
    )
