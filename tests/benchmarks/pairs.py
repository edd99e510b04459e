"""Ratios of speed, taken in one run: A and B in turn, so that a machine whose speed drifts spoils neither."""

import os
import platform
import time
from collections.abc import Callable

import numpy as np


def seconds(action: Callable[[], object]) -> float:
    """Wall time of one call."""
    start = time.perf_counter()
    action()
    return time.perf_counter() - start


def ratio(one: Callable[[], object], other: Callable[[], object], pairs: int = 9) -> tuple[float, float, float]:
    """Median of one/other over pairs, and the median seconds of each; the first pair warms up and does not count."""
    times = np.array([(seconds(one), seconds(other)) for _ in range(pairs + 1)])[1:]
    return float(np.median(times[:, 0] / times[:, 1])), *map(float, np.median(times, axis=0))


def machine() -> str:
    """What the seconds were measured on."""
    return (
        f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}, NumPy {np.__version__}"
    )
