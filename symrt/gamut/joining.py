"""Join the slabs, and the clipped lines, of several gamuts into those of their intersection, for step 4."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from symrt.arrays import PixelBands
from symrt.gamut.clipping import Interval
from symrt.gamut.interface import ConvexGamut, SlabGamut, Slabs, of_one_band, stacked


def merged(each: Sequence[Slabs]) -> Slabs:
    """All slabs; those of the same band alone are one, with the highest lower bound and the lowest upper one.

    Examples
    --------
    >>> no = np.zeros(1, dtype=bool)
    >>> one, other = (
    ...     Slabs(np.eye(1), np.array([a]), np.array([b]), np.array([0]), ("500 nm",), no, no)
    ...     for a, b in ((0.0, 0.8), (0.1, 0.9))
    ... )
    >>> both = merged([one, other])
    >>> both.lower, both.upper
    (array([0.1]), array([0.8]))
    """
    whole = stacked(each, each[0].matrix.shape[0])
    lower, upper, dark, extrapolated = (
        getattr(whole, name).copy() for name in ("lower", "upper", "dark", "extrapolated")
    )

    # Merge each slab of one band alone into the first of that band; its flags are those of the bounds that count.
    bands, alone = whole.bands, of_one_band(whole.matrix)
    taken = []
    for slab, own in enumerate(alone):
        same = np.flatnonzero(alone & (bands == bands[slab])) if own else np.array([slab])
        if same[0] != slab:
            continue
        taken.append(slab)
        highest, lowest = same[lower[same] == lower[same].max()], same[upper[same] == upper[same].min()]
        dark[slab], extrapolated[slab] = dark[highest].any(), extrapolated[np.append(highest, lowest)].any()
        lower[slab], upper[slab] = lower[same].max(), upper[same].min()

    # Leave out the slabs that were merged into others.
    words = tuple(whole.words[slab] for slab in taken)
    return Slabs(
        whole.matrix[:, taken], lower[taken], upper[taken], bands[taken], words, dark[taken], extrapolated[taken]
    )


def named(part: SlabGamut) -> Slabs:
    """A gamut's slabs, with words that say whose they are, but for those of a band alone.

    Examples
    --------
    >>> from symrt.device.monitors import load_monitor
    >>> from symrt.gamut.monitor import monitor_gamut
    >>> named(monitor_gamut(load_monitor("crt-brainard"))).words[0]
    "the monitor's red of the gamut of the monitor crt-brainard"
    """
    slabs = part.slabs
    words = [w if band >= 0 else f"{w} of the {part.name}" for w, band in zip(slabs.words, slabs.bands, strict=True)]
    return replace(slabs, words=tuple(words))


def boxed(slabs: Slabs) -> bool:
    """True where bounds in each single band are all that there is.

    Examples
    --------
    >>> from symrt.device.monitors import load_monitor
    >>> from symrt.gamut.monitor import monitor_gamut
    >>> no = np.zeros(2, dtype=bool)
    >>> box = Slabs(np.eye(2), np.zeros(2), np.ones(2), np.arange(2), ("500 nm", "600 nm"), no, no)
    >>> boxed(box), boxed(monitor_gamut(load_monitor("crt-brainard")).slabs)
    (True, False)
    """
    return bool(of_one_band(slabs.matrix).all() and slabs.matrix.shape[0] == slabs.matrix.shape[1])


def clipped_by_all(parts: Sequence[ConvexGamut], origin: PixelBands, direction: PixelBands) -> Interval:
    """The interval of each line that all parts allow.

    Examples
    --------
    >>> from symrt.device.monitors import load_monitor
    >>> from symrt.gamut.monitor import monitor_gamut
    >>> srgb = monitor_gamut(load_monitor("srgb"))
    >>> clipped_by_all([srgb, srgb], np.zeros((1, 3)), np.full((1, 3), 0.5)).high.round(9)
    array([2.])
    """
    each = [part.clip(origin, direction) for part in parts]
    low, high = np.max([one.low for one in each], axis=0), np.min([one.high for one in each], axis=0)
    empty = low > high
    uncertain = np.any([one.uncertain for one in each], axis=0)
    certainly_empty = np.any([one.empty & ~one.uncertain for one in each], axis=0)
    return Interval(np.where(empty, np.inf, low), np.where(empty, -np.inf, high), uncertain & ~certainly_empty)


def common_intervals(
    one: Sequence[tuple[float, float]], other: Sequence[tuple[float, float]]
) -> list[tuple[float, float]]:
    """The intervals that two lists of them have in common.

    Examples
    --------
    >>> common_intervals([(0.0, 0.4), (0.6, 1.0)], [(0.2, 0.7)])
    [(0.2, 0.4), (0.6, 0.7)]
    """
    both = [(max(a, c), min(b, d)) for a, b in one for c, d in other]
    return sorted((a, b) for a, b in both if a <= b)
