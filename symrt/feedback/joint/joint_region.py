"""Pairs of two parameters that keep an image inside a gamut: step 5 of the paper, for two parameters at once.

With one parameter at a value, the other's range is found as `feasible` finds it, certified: a line through the plane of
pairs.  Many such lines show the region.
"""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
from jaxtyping import Bool, Float
from tqdm.auto import tqdm

from symrt.errors import require
from symrt.feedback.along import along
from symrt.feedback.asking import drawn
from symrt.feedback.joint.areas import THIN, between_lines, lengths_within
from symrt.feedback.joint.boxes import SafeBox
from symrt.feedback.joint.crossing import Crossing, Image, Plane, image, line_at, spans_of, without_unfixable
from symrt.feedback.joint.freedom import safe_box
from symrt.feedback.joint.pairs import JointRegion, given_value
from symrt.feedback.limits import limits
from symrt.feedback.parameters import Blend, Exposure, Parameter, Scale, mixing_of, moved, moved_ends
from symrt.feedback.ranges import Range, check_share, checked_range, feasible
from symrt.feedback.reasons import Feasible
from symrt.feedback.shares import pieces
from symrt.feedback.weighing import weighed
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

Mask = Bool[np.ndarray, "height width"]
ASKED = 200
"""Pixels that a hull, or inks, are asked about on every line."""
NUDGE = 1e-9
"""By which share lines stand on either side of where a range ends."""
CLOSE = 1e-3
"""Share of the areas that may hide between lines before more of them are drawn."""
EVERYWHERE = ((-np.inf, np.inf),)


def joint_region(  # noqa: PLR0913  # a public verb names its options
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    one: Parameter,
    other: Parameter,
    *,
    within: tuple[Range | None, Range | None] = (None, None),
    steps: int = 49,
    allowed_out: Number = 0.0,
    mask: Mask | None = None,
    reference: Reference | None = None,
    cap: bool = True,
    most: int = ASKED,
    progress: bool = True,
) -> JointRegion:
    """The pairs of values of two parameters that keep the image inside a gamut, and what stops them.

    Parameters
    ----------
    one, other
        Scales, linear blends or the exposure; the other moves what the one has moved already.
    within
        The range of each, its usual one where None is given.
    steps
        Lines drawn evenly over the range of the one; a few more stand where ranges end, and up to as many again where
        the region's edge bends.
    allowed_out, mask, reference, cap
        As for `feasible`.
    most
        Pixels that a gamut without slabs, a hull or inks, is asked about on every line.
    progress
        Whether a bar shows on standard error if it takes over a second.

    Raises
    ------
    ValueError
        If both parameters are the same, or they, the palette, the gamut and the system do not fit together.

    Examples
    --------
    Two materials share a pixel, each with a quarter of the white's light: their scales may sum to 4:

    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*ice.diffuse + 0.25*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "ice.diffuse": 0.5, "sea.diffuse": 0.5})
    >>> found = joint_region(system, palette, device_gamut(device), Scale("ice"), Scale("sea"), cap=False)
    >>> (1, 2.9) in found, (2, 2.5) in found, round(found.separate_inside, 3)
    (True, False, 0.776)
    """
    # What is asked, of which pixels.
    start = time.perf_counter()
    check_share(allowed_out, "allowed_out")
    ranges = _checked(one, other, within, steps)
    asked = limits(system, palette, gamut, reference)
    line = along(system, palette, one)
    counted = drawn(line, asked, weighed(system, None, mask), given_value(one), most, extremes=not allowed_out)
    plane = Plane(system, palette, asked, one, other, ranges, cap, counted.pixels)

    # Each parameter by itself, and both free of each other.
    alone = partial(
        feasible,
        system,
        palette,
        gamut,
        allowed_out=allowed_out,
        mask=mask,
        reference=reference,
        cap=cap,
        most=most,
        progress=progress,
    )
    separate = alone(one, within=ranges[0]), alone(other, within=ranges[1])
    box = None if allowed_out or mask is not None else _box(plane, gamut, reference)

    # Where lines stand, and which pixels may bind on them.
    seen = image(plane)
    values = _values(plane, steps, separate[0], box, seen)
    seen = without_unfixable(plane, seen, values)
    budget = int(allowed_out * seen.objects + 1e-9) - len(seen.outside) - len(seen.unfixable)
    across = np.linspace(*ranges[1], steps)

    # The lines: those, and more where the region ends and where its edge bends.
    lines, hidden = _drawn(plane, seen, values, budget, separate, steps, progress)

    # The answer, line by line.
    found = JointRegion(
        one=one,
        other=other,
        within=ranges,
        values=np.array(list(lines)),
        intervals=tuple(tuple((piece.low, piece.high) for piece in line.pieces) for line in lines.values()),
        reasons=tuple(line.reasons for line in lines.values()),
        across=across,
        outside=np.array([line.curve.outside(across) for line in lines.values()]),
        separate=separate,
        hidden=hidden[0],
        separate_inside=None,
        separate_hidden=hidden[1],
        box=box,
        verdict="complete" if budget >= 0 else "rest-only",
        untouched_outside=seen.outside,
        unfixable=seen.unfixable,
        objects=seen.objects,
        note="; ".join(filter(None, [plane.asked.note, counted.note])),
        width=system.width,
        seconds=0.0,
    )
    return replace(found, separate_inside=_share_of_separate(found), seconds=time.perf_counter() - start)


def _checked(
    one: Parameter, other: Parameter, within: tuple[Range | None, Range | None], steps: int
) -> tuple[tuple[float, float], tuple[float, float]]:
    """The ranges of two parameters that span a plane."""
    for parameter in (one, other):
        require("parameter", parameter, (Scale, Blend, Exposure), "Scale('brass'), Blend('sea', 'ice') or Exposure()")
    if one == other:
        raise ValueError(f"the {one} is named twice: a region needs two parameters")
    for parameter in (one, other):
        if mixing_of(parameter) != "linear":
            raise ValueError(f"the {parameter}: a region takes scales, linear blends and the exposure; ask feasible")
    if steps < 2:
        raise ValueError(f"steps = {steps}: a region needs two lines at least")
    ranges = checked_range(one, within[0]), checked_range(other, within[1])
    if any(low == high for low, high in ranges):
        raise ValueError(f"within = {within}: a region needs room in both ranges, low below high")
    return ranges


def _values(plane: Plane, steps: int, alone: Feasible, box: SafeBox | None, seen: Image) -> Float[np.ndarray, " line"]:
    """Where lines are drawn: evenly, at the palette given, and on both sides of where the one's ranges end."""
    low, high = plane.within[0]
    ends = [*alone.intervals]
    if box is not None and isinstance(plane.one, Scale):
        ends.append(box.box[plane.one.name])
    for value in plane.within[1]:
        # With the other at either end of its range, the one may go this far.
        line = along(seen.part, moved(seen.part, plane.palette, plane.other, value), plane.one)
        spans = spans_of(line, plane.asked, plane.within[0])
        ends += [(piece.low, piece.high) for piece in pieces(spans, plane.within[0], len(seen.pixels), "upper")]
    kinks = [end * nudged for pair in ends for end in pair for nudged in (1 - NUDGE, 1 + NUDGE)]
    values = np.unique([*np.linspace(low, high, steps), given_value(plane.one), *kinks])
    return values[(low <= values) & (values <= high)]


def _drawn(  # the state of one question, taken apart
    plane: Plane,
    seen: Image,
    values: Float[np.ndarray, " line"],
    budget: int,
    separate: tuple[Feasible, Feasible],
    steps: int,
    progress: bool,
) -> tuple[dict[float, Crossing], tuple[float, float]]:
    """The lines by the one's value, ascending, and the areas that may hide between them."""
    bar = tqdm(total=len(values), desc="joint region", unit="line", delay=1, leave=False, disable=not progress)
    with bar:

        def draw(value: float) -> Crossing:
            bar.update()
            return line_at(plane, seen, value, budget=budget)

        lines = _to_its_ends(draw, values)
        hidden = _where_it_bends(draw, lines, separate, most=steps)
    return {value: lines[value] for value in sorted(lines)}, hidden


def _to_its_ends(draw: Callable[[float], Crossing], values: Float[np.ndarray, " line"]) -> dict[float, Crossing]:
    """The lines at some values, and lines between one that holds pairs and one that holds none until they are close.

    So a sum over the lines ends where the region does, not half a step beyond.
    """
    lines = {value: draw(value) for value in values.tolist()}
    least = THIN * (values[-1] - values[0])
    for first, last in pairwise(values.tolist()):
        while last - first > least and bool(lines[first].pieces) != bool(lines[last].pieces):
            middle = (first + last) / 2
            lines[middle] = draw(middle)
            same = bool(lines[middle].pieces) == bool(lines[first].pieces)
            first, last = (middle, last) if same else (first, middle)  # noqa: PLW2901  the pair closes in
    return lines


def _where_it_bends(
    draw: Callable[[float], Crossing], lines: dict[float, Crossing], separate: tuple[Feasible, Feasible], most: int
) -> tuple[float, float]:
    """Draw lines in the gaps that may hide most of the area, at most `most`; the areas that may be hidden still.

    They are of the region, and of what of it lies in the separate ranges.
    """
    left = most
    while True:
        # What each gap may hide of either area.
        values = np.array(sorted(lines))
        intervals = tuple(tuple((piece.low, piece.high) for piece in lines[value].pieces) for value in values.tolist())
        region = lengths_within(intervals, EVERYWHERE)
        shared = lengths_within(intervals, separate[1].intervals)
        shared[~_inside(values, separate[0].intervals)] = 0
        hidden = [between_lines(values, lengths) for lengths in (region, shared)]

        # Enough is known, or the next line halves the gap that hides the largest share.
        areas = [np.trapezoid(lengths, values) for lengths in (region, shared)]
        shares = [gaps / area if area else np.zeros_like(gaps) for gaps, area in zip(hidden, areas, strict=True)]
        if not left or max(share.sum() for share in shares) <= CLOSE:
            return float(hidden[0].sum()), float(hidden[1].sum())
        worst = int(np.maximum(*shares).argmax())
        middle = float(values[worst] + values[worst + 1]) / 2
        lines[middle] = draw(middle)
        left -= 1


def _inside(values: Float[np.ndarray, " line"], ranges: tuple[tuple[float, float], ...]) -> Bool[np.ndarray, " line"]:
    return np.any([(low <= values) & (values <= high) for low, high in ranges] or [values < -np.inf], axis=0)


def _box(plane: Plane, gamut: ConvexGamut | UnevenGamut, reference: Reference | None) -> SafeBox | None:
    """The safe box of two scales of different spectra over one range."""
    one, other, within = plane.one, plane.other, plane.within
    if not (isinstance(one, Scale) and isinstance(other, Scale) and within[0] == within[1]):
        return None
    if plane.asked.upper.signed or plane.asked.solids:
        return None
    first, second = (moved_ends(plane.system, plane.palette, scale).keys() for scale in (one, other))
    if not first.isdisjoint(second):
        return None
    scales = [one, other]
    return safe_box(plane.system, plane.palette, gamut, scales, within=within[0], reference=reference, cap=plane.cap)


def _share_of_separate(found: JointRegion) -> float | None:
    """Share of the rectangle of the separate ranges that the region covers."""
    first, second = (alone.intervals for alone in found.separate)
    lengths = lengths_within(found.intervals, second)
    covered = 0.0
    for low, high in first:
        at = np.unique([low, *found.values[(low < found.values) & (found.values < high)], high])
        covered += float(np.trapezoid(np.interp(at, found.values, lengths), at))
    whole = found.separate_area
    return covered / whole if whole else None
