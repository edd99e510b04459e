"""Bring pixels into a gamut one by one: the last resort, after the parameters have done what they can (step 5).

The paper leaves the choice of a projection open.  A pixel outside moves along a straight line to a grey, to the gamut's
centre, or to the nearest point of the gamut.  Neighbours that move differently can band; `smoothness` evens that out.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from jaxtyping import Bool, Float
from scipy.ndimage import gaussian_filter, minimum_filter
from tqdm.auto import tqdm

from symrt.arrays import Spectrum
from symrt.feedback.limits import check_kinds, described, white_in_every_band
from symrt.gamut.hull import HullGamut
from symrt.gamut.interface import ConvexGamut, clip
from symrt.gamut.intersections import UnevenGamut
from symrt.spectra.bands import Number
from symrt.spectra.image import SpectralImage
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.spectra.shading import shade
from symrt.system import LinearSystem
from symrt.table import sentences

Target = Literal["neutral", "centre", "nearest"]
Reflectances = Float[np.ndarray, "pixel band"]
REACH = 3
"""Standard deviations after which a Gaussian is cut off."""
PULLS = 2.0 ** np.arange(-46, -9, 4)
"""Parts of the way to the gamut's centre, one after another, that rounding may ask for; the first is always taken."""
MOVED_AT_ONCE = 256
"""Pixels outside that are moved at a time."""


@dataclass(frozen=True, eq=False)
class Mapped:
    """An image whose every object pixel is inside a gamut.

    Parameters
    ----------
    image
        The new radiances.
    share
        Share of the object pixels that moved.
    moved
        Root mean square change of reflectance in each pixel, (height, width).
    note
        Gamut, target and smoothness.
    """

    image: SpectralImage
    share: float
    moved: Float[np.ndarray, "height width"]
    note: str
    seconds: float

    def __repr__(self) -> str:
        moved = f"{self.share:.1%} of the object pixels moved, by at most {self.moved.max():.3g} RMS"
        return sentences([f"{moved}: {self.note}"])

    def _repr_png_(self) -> bytes | None:
        return self.image._repr_png_()  # a notebook asks for it by this name


def map_pixels(
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    *,
    towards: Target | str = "neutral",
    smoothness: Number = 0.0,
    reference: Reference | None = None,
    progress: bool = True,
) -> Mapped:
    """Move every pixel that is outside a gamut into it.

    Parameters
    ----------
    towards
        ``"neutral"``: the grey of the pixel's mean reflectance, as far as the gamut has it.  ``"centre"``: the middle
        of the gamut's neutral axis.  ``"nearest"``: the nearest point, by root mean square.
    smoothness
        Standard deviation, in pixels, over which the amount of movement is evened out; pixels inside then move a
        little too.  The convexity of the gamut keeps everything inside.  Not for ``"nearest"``.
    progress
        True to show a bar, if it takes more than a second: a hull, or inks, take some milliseconds for each pixel
        outside.

    Raises
    ------
    ValueError
        If the gamut has no grey, is on other bands, or the options do not fit together; inks, whose gamut is not
        convex, have nearest points only.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.95})
    >>> map_pixels(system, palette, device_gamut(device, "envelope")).image.values[0, :, 20].round(3)
    array([0.475, 0.9  ])
    """
    # Refuse options that do not fit together.
    start = time.perf_counter()
    check_kinds(system, palette, gamut)
    if towards not in get_args(Target):
        raise ValueError(f"towards = {towards!r}: there are {', '.join(map(repr, get_args(Target)))}")
    if towards == "nearest" and smoothness:
        raise ValueError("smoothness: the nearest points have no common amount of movement; choose neutral or centre")
    if not 0 <= smoothness < max(system.height, system.width):
        raise ValueError(f"smoothness = {smoothness}: it must be from 0 to the size of the image, in pixels")

    # Shade, and find the pixels outside.
    reference = as_asked(reference)
    white = white_in_every_band(system, palette, reference, [gamut])
    gamut = gamut.under(white)
    image = shade(system, palette)
    seen = image.values.reshape(-1, len(white))[system.object_pixels] / white
    outside = ~gamut.contains(seen)

    # Move them.
    moved = seen.copy()
    if towards == "nearest":
        moved[outside] = _nearest(gamut, seen[outside], progress)
    elif isinstance(gamut, UnevenGamut):
        raise ValueError(f"{gamut.name}: not convex, so that a line may leave it and return; choose towards='nearest'")
    else:
        moved = _towards(system, gamut, seen, outside, towards, float(smoothness), progress)

    # Turn reflectances back into radiances that are inside for sure; pixels that did not move keep their bits.
    changed = (moved != seen).any(axis=1)
    values = image.values.reshape(-1, len(white)).copy()
    values[np.flatnonzero(system.object_pixels)[changed]] = _landed(gamut, moved[changed] * white, white)

    change = np.zeros(values.shape[0])
    change[system.object_pixels] = np.sqrt(np.mean((moved - seen) ** 2, axis=1))
    return Mapped(
        image=replace(image, values=values.reshape(image.values.shape)),
        share=float(np.mean(changed)) if changed.size else 0.0,
        moved=change.reshape(system.height, system.width),
        note=f"towards {towards}, smoothness {smoothness:g}, in {described(gamut)}",
        seconds=time.perf_counter() - start,
    )


def _nearest(gamut: ConvexGamut | UnevenGamut, outside: Reflectances, progress: bool) -> Reflectances:
    parts = [gamut.nearest(outside[rows]) for rows in _chunks(len(outside), progress)]
    return np.concatenate([outside[:0], *parts])


def _towards(
    system: LinearSystem,
    gamut: ConvexGamut,
    seen: Reflectances,
    outside: Bool[np.ndarray, " pixel"],
    towards: str,
    smoothness: float,
    progress: bool,
) -> Reflectances:
    """Every pixel, moved along the line from its grey as far as the gamut, and the smoothness, allow."""
    # Choose a grey inside the gamut for each pixel.
    low, high = _greys(gamut, seen.shape[1])
    grey = np.full(len(seen), (low + high) / 2) if towards == "centre" else np.clip(seen.mean(axis=1), low, high)
    origin = np.repeat(grey[:, None], seen.shape[1], axis=1)
    direction = seen - origin

    # Clip the lines of the pixels outside, in chunks.
    reach, rows = np.ones(len(seen)), np.flatnonzero(outside)
    for part in _chunks(len(rows), progress):
        reach[rows[part]] = _reach(gamut, origin[rows[part]], direction[rows[part]])
    if smoothness:
        reach = _evened(system, reach, smoothness)
    return np.where(reach[:, None] == 1, seen, origin + reach[:, None] * direction)


def _reach(gamut: ConvexGamut, origin: Reflectances, direction: Reflectances) -> Float[np.ndarray, " pixel"]:
    """The largest part of the way from a grey inside to each spectrum that is inside, at most 1."""
    if isinstance(gamut, HullGamut):
        return gamut.reach(origin, direction)
    return np.clip(clip(gamut, origin, direction).high, 0.0, 1.0)


def _landed(gamut: ConvexGamut | UnevenGamut, radiances: Reflectances, white: Spectrum) -> Reflectances:
    """Pixels on the boundary, drawn towards the gamut's centre by as little as it takes to be inside for sure."""
    grey = None if isinstance(gamut, UnevenGamut) else clip(gamut, *_neutral(len(white)))
    if grey is None or grey.empty[0]:
        return radiances
    centre = (max(0.0, float(grey.low[0])) + float(grey.high[0])) / 2 * white
    out = np.arange(len(radiances))
    for share in PULLS:
        radiances[out] += share * (centre - radiances[out])
        out = np.flatnonzero(~gamut.contains(radiances / white))
        if not len(out):
            break
    return radiances


def _neutral(bands: int) -> tuple[Reflectances, Reflectances]:
    """Black, and the direction of the greys."""
    return np.zeros((1, bands)), np.ones((1, bands))


def _chunks(count: int, progress: bool) -> Iterator[slice]:
    starts = range(0, count, MOVED_AT_ONCE)
    for start in tqdm(starts, desc="map pixels", unit="chunk", delay=1, leave=False, disable=not progress):
        yield slice(start, start + MOVED_AT_ONCE)


def _greys(gamut: ConvexGamut, bands: int) -> tuple[float, float]:
    """The darkest and the lightest grey inside."""
    span = clip(gamut, *_neutral(bands))
    if span.empty[0]:
        raise ValueError(f"{gamut.name} has no grey to move towards: choose towards='nearest'")
    return max(0.0, float(span.low[0])), float(span.high[0])


def _evened(system: LinearSystem, reach: Float[np.ndarray, " pixel"], smoothness: float) -> Float[np.ndarray, " pixel"]:
    """The part of the way that each pixel keeps towards its own colour, smooth and nowhere more than before."""
    picture = np.ones(system.height * system.width)
    picture[system.object_pixels] = reach
    radius = int(REACH * smoothness + 0.5)
    # The least within the Gaussian's reach is averaged, so that the average is never above any pixel's own.
    least = minimum_filter(picture.reshape(system.height, system.width), size=2 * radius + 1, mode="nearest")
    even = gaussian_filter(least, smoothness, radius=radius, mode="nearest").ravel()
    return np.minimum(even[system.object_pixels], reach)
