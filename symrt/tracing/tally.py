"""Count, while a window is traced, what each effect costs and which pixels it touches (step 1)."""

import time
from collections import Counter
from collections.abc import Generator, Mapping
from contextlib import contextmanager

import numpy as np
from jaxtyping import Int

from symrt.counts import Count, Counts
from symrt.tracing.raytree import Film

CAMERA = "camera"
"""The name under which the camera's own rays are counted."""


class Tally:
    """Rays, pixels and time of the effects that take part in a trace; it grows with the tree.

    Parameters
    ----------
    film
        The film's samples, whose pixels are those that effects touch.
    pixels
        Number of pixels in the window.
    effects
        Names of the effects that take part; of those that act on hits it is told which pixels they touch.

    Examples
    --------
    >>> tally = Tally(Film(np.array([0, 0, 1]), np.array([0.5, 0.5, 1.0])), 2, {"mirrors": True})
    >>> tally.sent("mirrors", "reflected", np.array([0, 1]))
    >>> tally.counts().effects["mirrors"].pixels, tally.rays["mirrors"]
    (1, 2)
    """

    def __init__(self, film: Film, pixels: int, effects: Mapping[str, bool]) -> None:
        self.film, self.pixels = film, pixels
        self.rays: Counter[str] = Counter({CAMERA: film.pixel.size})
        self._ways: dict[str, Counter[str]] = {}
        self._seconds = dict.fromkeys([CAMERA, *effects], 0.0)
        self._touched = {name: np.zeros(pixels, dtype=bool) for name, acts in effects.items() if acts}

    @contextmanager
    def timed(self, name: str) -> Generator[None, None, None]:
        """Add the time of a block to an effect's."""
        start = time.perf_counter()
        yield
        self._seconds[name] += time.perf_counter() - start

    @contextmanager
    def shared(self, cast: Mapping[str, int]) -> Generator[None, None, None]:
        """Share the time of a block, without that of effects within it, among those that cast so many rays each."""
        start, before = time.perf_counter(), sum(self._seconds.values())
        yield
        own = time.perf_counter() - start - (sum(self._seconds.values()) - before)
        whole = max(1, sum(cast.values()))
        for name, number in cast.items():
            self._seconds[name] += own * number / whole

    def touch(self, name: str, sample: Int[np.ndarray, " hit"]) -> None:
        """Note that an effect acts on some film samples."""
        touched = self._touched.setdefault(name, np.zeros(self.pixels, dtype=bool))
        touched[self.film.pixel[sample]] = True

    def sent(self, name: str, via: str, sample: Int[np.ndarray, " ray"]) -> None:
        """Count rays that an effect sends on by a formula, each for its film sample."""
        self.rays[name] += sample.size
        self._ways.setdefault(name, Counter())[via] += sample.size
        self.touch(name, sample)

    def counts(self) -> Counts:
        """All that was counted."""
        touched = {name: int(np.count_nonzero(pixels)) for name, pixels in self._touched.items()}
        found = {
            name: Count(self.rays[name], seconds, touched.get(name), dict(self._ways.get(name, {})))
            for name, seconds in self._seconds.items()
        }
        return Counts(found, self.pixels)
