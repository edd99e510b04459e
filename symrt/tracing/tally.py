"""Count, while a window is traced, what each effect costs and which pixels it touches (step 1).

Neither the tracer nor the effects know of it: it stands around the effects' functions.
"""

import time
from collections import Counter
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Int

from symrt.counts import Count, Counts
from symrt.tracing.effects.effect import Effect, Passed, Segment, Sent
from symrt.tracing.raytree import Emitted, Film, Level
from symrt.tracing.view import View, Which
from symrt.tracing.work import AtWork

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
        The effects that take part; of those that act on hits it is told which pixels they touch.
    """

    def __init__(self, film: Film, pixels: int, effects: Sequence[Effect]) -> None:
        self.film, self.pixels = film, pixels
        self.rays: Counter[str] = Counter({CAMERA: film.pixel.size})
        self._ways: dict[str, Counter[str]] = {}
        self._seconds = dict.fromkeys([CAMERA, *(effect.name for effect in effects)], 0.0)
        self._touched = {effect.name: np.zeros(pixels, dtype=bool) for effect in effects if effect.acts}

        # A film of its own touches the pixels with several samples.
        for effect in effects:
            if effect.film is not None:
                self.touch(effect.name, np.flatnonzero(np.bincount(film.pixel)[film.pixel] > 1))

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

    def sent(self, rays: Iterable[tuple[str, Sent]], view: View) -> Counter[str]:
        """Count the rays that effects send on from a level, each for its film sample; their numbers by effect."""
        number: Counter[str] = Counter()
        for name, one in rays:
            number[name] += one.hit.size
            self._ways.setdefault(name, Counter())[one.via] += one.hit.size
            self.touch(name, view.sample[one.hit])
        self.rays += number
        return number

    def shone(self, levels: Iterable[Level], calls_for: Mapping[str, str | None]) -> None:
        """Note what is touched by the lights that call for an effect."""
        for level in levels:
            for points in level.points:
                for lit in points.lit:
                    if effect := calls_for[lit.light]:
                        self.touch(effect, level.sample[points.hit[lit.point]])

    def counts(self) -> Counts:
        """All that was counted."""
        touched = {name: int(np.count_nonzero(pixels)) for name, pixels in self._touched.items()}
        found = {
            name: Count(self.rays[name], seconds, touched.get(name), dict(self._ways.get(name, {})))
            for name, seconds in self._seconds.items()
        }
        return Counts(found, self.pixels)


def watched(effects: AtWork, tally: Tally) -> AtWork:
    """The same effects, of which those simulated tell a tally their time, their rays and the samples they touch."""
    return replace(effects, simulated=tuple(_watched(effect, tally) for effect in effects.simulated))


def _watched(effect: Effect, tally: Tally) -> Effect:
    """An effect with a function around each of its own."""
    own = {seam: getattr(effect, seam) for seam in NOTES}
    around: dict[str, Any] = {seam: _around(act, effect.name, tally, seam) for seam, act in own.items() if act}
    return replace(effect, **around)


def _around(act: Callable[..., Any], name: str, tally: Tally, seam: str) -> Callable[..., Any]:
    note = NOTES[seam]

    def acted(*given: Any) -> Any:
        with tally.timed(name):
            found = act(*given)
        note(tally, name, found, *given)
        return found

    return acted


def _surface(tally: Tally, name: str, blended: Any, _stage: Any, _named: str, view: View, hit: Which) -> None:
    if blended is not None:
        tally.touch(name, view.sample[hit])


def _arriving(  # those of the seam
    tally: Tally, name: str, passed: Passed, _stage: Any, view: View, _light: Any, hit: Which, _at: Any
) -> None:
    tally.rays[name] += passed.rays
    tally.touch(name, view.sample[hit[passed.share < 1]])


def _segment(tally: Tally, name: str, segment: Segment, _stage: Any, _batch: Any, view: View, _hits: Any) -> None:
    for length in segment.inside.values():
        tally.touch(name, view.sample[length > 0])


def _emitted(tally: Tally, name: str, sent: Sequence[Emitted], _stage: Any, view: View) -> None:
    for one in sent:
        tally.touch(name, view.sample[one.hit])


def _onwards(*_: Any) -> None:
    """Nothing: rays are counted once it is known that they are followed."""


NOTES: Mapping[str, Callable[..., None]] = {
    "surface": _surface,
    "arriving": _arriving,
    "segment": _segment,
    "emitted": _emitted,
    "onwards": _onwards,
}
"""What is noted of what an effect's function at each seam found, from it and from what it was given."""
