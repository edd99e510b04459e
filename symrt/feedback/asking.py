"""Ask a gamut of any kind about pixels along a parameter: step 5 of the paper.

Slabs answer for every pixel at once.  A hull, or inks, must be asked pixel by pixel, and a picture has too many: those
asked are extreme in many directions of reflectance, or drawn evenly.
"""

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from jaxtyping import Bool, Int

from symrt.arrays import Spectrum
from symrt.feedback.bounds import Bound, nearest_slab
from symrt.feedback.intervals import inside_at, intervals
from symrt.feedback.limits import Limits
from symrt.feedback.lines import Line
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import End
from symrt.feedback.solids import Solid, swept
from symrt.feedback.weighing import Weighed, check_most
from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number

DIRECTIONS = 256
"""Directions of reflectance in which the extreme pixels are looked for."""
SHADED_AT_ONCE = 4096
"""Pixels shaded at a time."""
NO_ROOM = 1e-9
"""Room, as a share of its bound, that leaves no doubt that it is this slab that stops a pixel."""
BEYOND = 1e-3
"""Share of a value beyond which a pixel is certainly outside what it meets there."""

Pixels = Int[np.ndarray, " _"]


def spans_inside_all(
    line: Line, asked: Limits, pixels: Pixels, within: tuple[Number, Number], progress: bool = False
) -> Spans:
    """The parts of `within` that keep each of the pixels, counted from 0, inside every part of a gamut."""
    parts = [solid.spans(line, pixels, within, progress) for solid in asked.solids]
    if len(asked.upper.bands) or not parts:
        parts.append(intervals(line.seen(asked.upper.matrix, pixels), asked.upper, within))
    return parts[0] if len(parts) == 1 else swept(parts, len(parts))


def inside_all(line: Line, asked: Limits, pixels: Pixels, t: Number) -> Bool[np.ndarray, " pixel"]:
    """Whether each of the pixels is inside every part of a gamut at one t."""
    inside = inside_at(line.seen(asked.upper.matrix, pixels), asked.upper, t)
    for solid in asked.solids:
        inside[inside] = solid.inside(line, pixels[inside], t)
    return inside


def drawn(line: Line, asked: Limits, counted: Weighed, now: Number, most: int, extremes: bool) -> Weighed:
    """The pixels that are asked about: all, if slabs answer, else about so many.

    Where a part of the gamut has a black of its own, pixels that are darker with the palette given print as it; they
    are left out, because no parameter lifts the shadows that every picture has.

    Parameters
    ----------
    now
        The parameter's value in the palette given.
    most
        The largest number of pixels to ask about.
    extremes
        True to make half of them those that are extreme in some direction; a share of pixels can only be told from an
        even draw.

    Raises
    ------
    ValueError
        If no pixel is to be asked about.
    """
    # Leave out the pixels that print as the device's black.
    check_most(most)
    if asked.solids:
        darker = darker_than_black(line, asked, counted.pixels, now)
        counted = _taken(counted, np.flatnonzero(~darker), "pixels darker than the device's black print as it")

    # Where pixels are asked about one by one, draw some of them.
    few = counted.pixels
    if not asked.slow or len(few) <= most:
        return counted
    chosen = [_extreme(line, few, most // 2)] if extremes else []
    evenly = np.linspace(0, len(few) - 1, most - sum(map(len, chosen))).round().astype(int)
    taken = np.unique(np.concatenate([*chosen, evenly]))
    how = "extreme ones and others drawn evenly" if extremes else "drawn evenly"
    return _taken(counted, taken, f"asked about {len(taken)} of {len(few)} pixels, {how}")


def darker_than_black(line: Line, asked: Limits, pixels: Pixels, t: Number) -> Bool[np.ndarray, " pixel"]:
    """Whether each of the pixels certainly has less luminance than the device's black at t."""
    black = Bound(asked.luminance[:, None], np.array([-np.inf]), np.array([asked.blackest]), np.array([-1]))
    return inside_at(line.seen(black.matrix, pixels), black, t, -1.0)


def _taken(counted: Weighed, places: Pixels, note: str) -> Weighed:
    """Some of the pixels, with a note that says which."""
    if len(places) == len(counted.pixels):
        return counted
    return replace(
        counted,
        pixels=counted.pixels[places],
        weights=None if counted.weights is None else counted.weights[places],
        note="; ".join(filter(None, [counted.note, note])),
    )


class Met(NamedTuple):
    """The reason that stops a pixel, and the weights of the bands in the quantity bounded there."""

    reason: Reason
    weights: Spectrum


def met(line: Line, asked: Limits, end: End, t: float, width: int) -> Met:
    """The bound that the pixel of an end meets at t: a slab that leaves no room, or else a part of the gamut.

    A part without slabs is met where the nearest spectrum inside differs most, and bounds the difference from it.
    """
    # Ask every part of the gamut for the room that it leaves.
    pixel = np.array([end.pixel])
    at_edge = [
        _slab_met(line, asked, asked.upper if end.kind == "upper" or asked.dark is None else asked.dark, pixel, t)
    ]
    if end.kind == "upper":
        at_edge += [_slab_met(line, asked, solid.bound, pixel, t) for solid in asked.solids if solid.bound is not None]
        at_edge += [_solid_met(line, asked, solid, pixel, t) for solid in asked.solids if solid.bound is None]

    # The part with the least room is met.
    found = min(at_edge, key=lambda pair: pair[0])[1]
    y, x = divmod(end.pixel, width)
    return found._replace(reason=replace(found.reason, x=x, y=y))


def _slab_met(line: Line, asked: Limits, bound: Bound, pixel: Pixels, t: float) -> tuple[float, Met]:
    """The slab that is met most nearly, and the room that it leaves as a share of its bound."""
    if not len(bound.bands):
        return np.inf, Met(Reason("range"), asked.luminance)
    side, slab, room = nearest_slab(bound, line.seen(bound.matrix, pixel).at(t)[0])
    band, word = int(bound.bands[slab]), bound.words[slab]
    guess = bound.extrapolated is not None and bool(bound.extrapolated[slab])
    if word == "luminance":
        reason = Reason("luminance")
    elif band < 0:
        reason = Reason(side, of=word, extrapolated=guess)
    else:
        reason = Reason(side, band=asked.bands.labels[band], extrapolated=guess)
    return room, Met(reason, bound.matrix[:, slab])


def _solid_met(line: Line, asked: Limits, solid: Solid, pixel: Pixels, t: float) -> tuple[float, Met]:
    """The way in which a pixel leaves a part without slabs just beyond t, and no room; much room if it does not."""
    for beyond in (t * (1 + BEYOND), t * (1 - BEYOND)):
        if not solid.inside(line, pixel, beyond)[0]:
            # The band in which the nearest spectrum inside differs most is the one bounded.
            spectrum = solid.reflectances(line, pixel, beyond)
            away = (spectrum - solid.gamut.nearest(spectrum))[0]
            band = int(np.abs(away).argmax())
            guess = any(bool(device.extrapolated[band]) for device in solid.gamut.devices)
            side: Literal["upper", "lower"] = "upper" if away[band] > 0 else "lower"

            # Say whose bound it is, if there are several.
            several = len(asked.solids) > 1
            whose = f"{solid.gamut.devices[0].name}'s {solid.gamut.model}" if several else f"the {solid.gamut.model}"
            reason = Reason(side, band=asked.bands.labels[band], extrapolated=guess, of=whose)
            return NO_ROOM, Met(reason, solid.shown * away)
    return np.inf, Met(Reason("range"), asked.luminance)


def _extreme(line: Line, pixels: Pixels, most: int) -> Pixels:
    """Places in `pixels` of those that reach farthest in seeded random directions and in each band, both ways."""
    # Look along every band, and along random directions.
    bands = line.at(1.0, slice(0, 0)).shape[1]
    random = np.random.default_rng(0).normal(size=(bands, DIRECTIONS))
    directions = np.hstack([np.eye(bands), random])

    # Keep who reaches farthest along each, and against it.
    best = np.full((2, directions.shape[1]), -np.inf)
    who = np.zeros(best.shape, dtype=int)
    for start in range(0, len(pixels), SHADED_AT_ONCE):
        reach = line.seen(directions, pixels[start : start + SHADED_AT_ONCE]).at(1.0)
        for sign, row in ((1, 0), (-1, 1)):
            place = (sign * reach).argmax(axis=0)
            value = sign * reach[place, np.arange(reach.shape[1])]
            farther = value > best[row]
            best[row, farther], who[row, farther] = value[farther], start + place[farther]

    # Of too many, those in single bands come first, and not those at the top of the picture.
    places, first = np.unique(who.ravel(order="F"), return_index=True)
    return np.sort(places[np.argsort(first)][:most])
