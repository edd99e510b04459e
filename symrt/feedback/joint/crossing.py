"""Lines through the plane of two parameters: what one may be with the other at a value (step 5 of the paper).

A pixel whose lightest image, every spectrum at its largest, is inside never binds and is left out; the others are
clipped on every line as `feasible` clips them, and certified also where only the first parameter has moved them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.feedback.along import Along, along, along_ends
from symrt.feedback.asking import inside_all, spans_inside_all
from symrt.feedback.bounds import Bound
from symrt.feedback.caps import ABOVE_ONE, UNLIMITED, Cap, grouped
from symrt.feedback.intervals import inside_at, intervals
from symrt.feedback.joint.pairs import given_value
from symrt.feedback.limits import Limits
from symrt.feedback.parameters import Parameter, moved, moved_ends, with_spectra
from symrt.feedback.ranges import reason
from symrt.feedback.reasons import Reason
from symrt.feedback.shares import Curve, End, Piece, curve, pieces, shared
from symrt.gamut.clipping import clip_slabs
from symrt.gamut.interface import ROUNDING
from symrt.gamut.looking import Spans
from symrt.spectra.fluorescence import sent_on
from symrt.spectra.palette import Palette
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]
Mask = Bool[np.ndarray, " pixel"]
TILE = 2048
NONE = Spans(np.zeros(0, dtype=int), np.zeros(0), np.zeros(0))
ENDLESS = UNLIMITED._replace(value=-np.inf)


@dataclass(frozen=True, eq=False)
class Plane:
    """Two parameters of an image, their ranges, what a gamut asks of it, and the pixels that count."""

    system: LinearSystem
    palette: Palette
    asked: Limits
    one: Parameter
    other: Parameter
    within: tuple[tuple[float, float], tuple[float, float]]
    cap: bool
    objects: Pixels


class Image(NamedTuple):
    """The pixels that may bind, by number and as a system of their own, and those that nothing helps.

    ``dark`` are those that must stay above black; ``apart`` those with slabs that only the one parameter moves.
    """

    pixels: Pixels
    part: LinearSystem
    dark: Mask
    apart: Mask
    objects: int
    outside: Pixels
    unfixable: Pixels

    def only(self, chosen: Mask) -> "Image":
        """Some of the pixels that may bind."""
        part = self.part.rows(np.flatnonzero(chosen))
        return self._replace(pixels=self.pixels[chosen], part=part, dark=self.dark[chosen], apart=self.apart[chosen])


class Crossing(NamedTuple):
    """One line across the plane: the values that the other parameter may have there, why, and what is outside."""

    pieces: list[Piece]
    reasons: tuple[tuple[Reason, Reason], ...]
    curve: Curve


def image(plane: Plane) -> Image:
    """The pixels that may bind somewhere in the plane."""
    system, dark = plane.system, plane.asked.dark
    objects = plane.objects
    first, second = (along(system, plane.palette, parameter) for parameter in (plane.one, plane.other))
    touched = first.touched | second.touched
    still, moving = objects[~touched[objects]], objects[touched[objects]]
    inside = inside_all(first, plane.asked, still, given_value(plane.one))
    counted = np.zeros(len(moving), dtype=bool)
    if dark is not None:
        counted = inside_at(first.seen(dark.matrix, moving), dark, given_value(plane.one))
    binding = counted | _may_bind(plane, moving, first.signed)
    pixels = moving[binding]
    part, nothing = replace(system, tail=None).rows(pixels), np.zeros(0, dtype=int)
    return Image(pixels, part, counted[binding], _apart(plane, part), len(objects), still[~inside], nothing)


def without_unfixable(plane: Plane, image: Image, values: Float[np.ndarray, " line"]) -> Image:
    """The image, with the pixels that are outside on all of every line set apart."""
    hopeless = np.ones(len(image.pixels), dtype=bool)
    for value in values:
        if not hopeless.any():
            break
        left = image.only(hopeless)
        painted = moved(left.part, plane.palette, plane.one, float(value))
        spans = _spans(left, along(left.part, painted, plane.other), plane.asked, plane.within[1])
        hopeless[np.flatnonzero(hopeless)[np.unique(spans.pixel)]] = False
    return image.only(~hopeless)._replace(unfixable=image.pixels[hopeless])


def line_at(plane: Plane, image: Image, value: float, budget: int) -> Crossing:
    """The values that the other parameter may have with the one at a value, if `budget` pixels may be outside."""
    # The line, and what the gamut allows on it: above, and below where black must be kept.
    painted, within = moved(image.part, plane.palette, plane.one, value), plane.within[1]
    line = along(image.part, painted, plane.other)
    spans = _spans(image, line, plane.asked, within)
    limiting = [pieces(spans, within, len(image.pixels) - max(0, budget), "upper")]
    if plane.asked.dark is not None:
        lit = np.flatnonzero(image.dark)
        found = _sure(image, line, plane.asked.dark, _dark_spans(line, plane.asked.dark, lit, within))
        limiting.append(pieces(found, within, int(image.dark.sum()), "dark"))

    # What stays physical.
    least, most = _caps(plane, painted) if plane.cap else (ENDLESS, UNLIMITED)
    if least.value <= most.value:
        limiting.append([Piece(least.value, most.value, End("cap"), End("cap"))])
    else:
        limiting.append([])

    # All of that at once, and why it ends.
    found_here = reduce(shared, limiting)
    why = _why(plane, image, line)
    always = image.objects - len(image.pixels) - len(image.outside) - len(image.unfixable)
    return Crossing(
        found_here,
        tuple((why(p.below, p.low, least), why(p.above, p.high, most)) for p in found_here),
        curve(spans, always, image.objects),
    )


def spans_of(line: Along, asked: Limits, within: tuple[float, float]) -> Spans:
    """The parts of a line in which each pixel is inside; where it is not touched that is all of it or nothing."""
    touched, still = np.flatnonzero(line.touched), np.flatnonzero(~line.touched)
    found = spans_inside_all(line, asked, touched, within) if len(touched) else NONE
    return _joined(touched, found, still[inside_all(line, asked, still, within[0])], within)


def _dark_spans(line: Along, bound: Bound, lit: Pixels, within: tuple[float, float]) -> Spans:
    """The same for the black that some of the pixels must keep."""
    touched, still = lit[line.touched[lit]], lit[~line.touched[lit]]
    found = intervals(line.seen(bound.matrix, touched), bound, within) if len(touched) else NONE
    return _joined(touched, found, still[inside_at(line.seen(bound.matrix, still), bound, within[0])], within)


def _joined(touched: Pixels, found: Spans, inside: Pixels, within: tuple[float, float]) -> Spans:
    return Spans(
        np.concatenate([touched[found.pixel], inside]),
        np.concatenate([found.low, np.full(len(inside), within[0])]),
        np.concatenate([found.high, np.full(len(inside), within[1])]),
    )


def _may_bind(plane: Plane, pixels: Pixels, signed: bool) -> Mask:
    """Pixels that are not surely inside when every spectrum is at its largest."""
    bound = plane.asked.upper
    if plane.asked.solids or signed or bound.signed or np.isfinite(bound.lower).any():
        return np.ones(len(pixels), dtype=bool)
    lightest = plane.palette
    for parameter, within in zip((plane.one, plane.other), plane.within, strict=True):
        ends = [moved(plane.system, lightest, parameter, t) for t in within]
        names = moved_ends(plane.system, lightest, parameter)
        lightest = with_spectra(lightest, {name: np.maximum(*(palette[name] for palette in ends)) for name in names})
    return ~inside_at(along_ends(plane.system, lightest, {}).seen(bound.matrix, pixels), bound, 1.0, -4.0)


def _apart(plane: Plane, part: LinearSystem) -> Mask:
    """Pixels with slabs that only the one parameter moves, at either end of its range or between."""
    apart = np.zeros(part.width, dtype=bool)
    first, (low, high) = along(part, plane.palette, plane.one), plane.within[0]
    for value in (low, (low + high) / 2, high):
        line = along(part, moved(part, plane.palette, plane.one, value), plane.other)
        for start in range(0, len(apart), TILE):
            rows = slice(start, start + TILE)
            apart[rows] |= (~_moves(line, rows) & _moves(first, rows)).any(axis=1)
    return apart


def _moves(line: Along, rows: slice) -> Bool[np.ndarray, "pixel band"]:
    found = line.coefficients(rows)
    return (found[1:] != (0.0 if line.form == "power" else found[0])).any(axis=0)


def _spans(image: Image, line: Along, asked: Limits, within: tuple[float, float]) -> Spans:
    """The parts of a line in which each pixel is inside, certified also in slabs that only the one has moved."""
    spans = spans_of(line, asked, within)
    for bound in (asked.upper, *(solid.bound for solid in asked.solids if solid.bound is not None)):
        spans = _sure(image, line, bound, spans)
    return spans


def _sure(image: Image, line: Along, bound: Bound, spans: Spans) -> Spans:
    if not (image.apart.any() and len(bound.bands)):
        return spans
    sure = np.ones(len(image.pixels), dtype=bool)
    rows = np.flatnonzero(image.apart)
    sure[rows] = _surely_inside(line.seen(bound.matrix, rows), bound)
    return Spans(*(column[sure[spans.pixel]] for column in spans))


def _surely_inside(line: Along, bound: Bound) -> Mask:
    """Whether what the other parameter does not move is inside whatever its rounding: the one has moved it there."""
    inside = np.ones(len(line.degrees), dtype=bool)
    for start in range(0, len(inside), TILE):
        rows = slice(start, start + TILE)
        still = ~_moves(line, rows)
        values = line.coefficients(rows)[0]
        error = line.terms * ROUNDING
        size = error * np.maximum(np.abs(values).max(axis=1, initial=0)[:, None], line.size(1.0, rows))
        lower = bound.lower + np.where(np.isfinite(bound.lower), error * np.abs(bound.lower) + size, 0.0)
        upper = bound.upper - np.where(np.isfinite(bound.upper), error * np.abs(bound.upper) + size, 0.0)
        inside[rows] = (~still | ((lower <= values) & (values <= upper))).all(axis=1)
    return inside


def _why(plane: Plane, image: Image, line: Along) -> Callable[[End, float, Cap], Reason]:
    def why(end: End, t: float, capped: Cap) -> Reason:
        said = reason(line, plane.asked, end, t, 1, capped)
        if end.pixel < 0:
            return said
        y, x = divmod(int(image.pixels[end.pixel]), plane.system.width)
        return replace(said, x=x, y=y)

    return why


def _caps(plane: Plane, painted: Palette) -> tuple[Cap, Cap]:
    """The least and the largest value of the other parameter at which what either moves stays physical."""
    # The groups of reflectances that count together and that either parameter moves.
    ends = moved_ends(plane.system, painted, plane.other)
    either = {*ends, *moved_ends(plane.system, plane.palette, plane.one)}
    groups = {name: own for name, own in grouped(painted).items() if not either.isdisjoint(own)}
    if not groups:
        return ENDLESS, UNLIMITED

    # Their sums where the other is 0 and where it is 1, and where the line between passes 1.
    first, last = (
        np.array(
            [
                np.sum([sent_on(ends.get(s, (painted[s],) * 2)[k], painted.bands) for s in own], axis=0)
                for own in groups.values()
            ]
        )
        for k in (0, 1)
    )
    bands = len(painted.bands)
    found = clip_slabs(np.full(bands, -np.inf), np.full(bands, ABOVE_ONE), first, last - first)

    def cap(group: int, value: float) -> Cap:
        at = first[group] + (last[group] - first[group]) * (value if np.isfinite(value) else 0.0)
        name = list(groups)[group]
        return Cap(value, name, painted.bands.labels[int(at.argmax())], frozenset(groups[name]))

    least, most = int(found.low.argmax()), int(found.high.argmin())
    return cap(least, float(found.low[least])), cap(most, float(found.high[most]))
