"""The values of a parameter that keep an image inside a gamut: step 5 of the paper.

Each pixel allows a parameter ``t`` some closed intervals; the image's range is what all its pixels have in common, or
all but a share.  A pixel is *untouched* by the parameter (and is inside or outside whatever t), *fixable*, or
*unfixable* (no t brings it inside).  The range is that of the fixable pixels; it is *complete* only if no more pixels
than allowed are in the way, else it holds for the *rest only*.  Shares are of object pixels, those that light reaches.
"""

import time
from collections.abc import Mapping
from functools import partial, reduce
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.feedback.asking import darker_than_black, drawn, inside_all, met, spans_inside_all
from symrt.feedback.caps import UNLIMITED, Cap, above_one, physical_cap
from symrt.feedback.intervals import inside_at, intervals
from symrt.feedback.limits import Limits, limits
from symrt.feedback.lines import Line, line_of
from symrt.feedback.parameters import Blend, Exposure, Parameter, Scale, moved, moved_ends
from symrt.feedback.reasons import Feasible, Reason
from symrt.feedback.sensitivity import LESS, Sensitivity, sensitivities
from symrt.feedback.shares import Curve, End, Kind, Piece, curve, pieces, shared, tightest
from symrt.feedback.weighing import Weighed, weighed
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.looking import Spans
from symrt.spectra.bands import Number
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " _"]
Range = tuple[Number, Number]
ASKED = 500
"""Pixels that a hull is asked about."""


def feasible(  # noqa: PLR0913  # a public verb names its options
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    parameter: Parameter,
    *,
    within: Range | None = None,
    allowed_out: Number = 0.0,
    allowed_dark: Number = 0.0,
    reference: Reference | None = None,
    cap: bool = True,
    weights: Float[np.ndarray, "height width"] | None = None,
    mask: Bool[np.ndarray, "height width"] | None = None,
    most: int = ASKED,
    progress: bool = True,
) -> Feasible:
    """The values of a parameter that keep the image inside a gamut, and the reasons that stop it beyond them.

    Parameters
    ----------
    parameter
        A `Scale` of a light or a material, a `Blend` of two materials, or the `Exposure`.
    within
        The range to look in: 0.01 … 3 for a scale, 0 … 1 for a blend, if not given.
    allowed_out
        Share of the object pixels that may be outside.
    allowed_dark
        Share of the pixels above black with the palette given that may fall below, if the gamut keeps black.
    reference
        The white and the exposure that make reflectances of radiances.
    cap
        True to keep a material's components from reflecting more than 1 together in any band.
    weights
        The weight of each pixel in every share, finite and not negative; 0 leaves it out, and without weights all
        count the same.
    mask
        The pixels that are asked about, such as `pixels_of` an object; all if not given.
    most
        Pixels that a hull, or inks, are asked about, which must be asked one by one; the note says which.
    progress
        True to show a bar meanwhile, if it takes more than a second.

    Raises
    ------
    ValueError
        If the parameter, the palette, the gamut and the system do not fit together; the message says how.

    Examples
    --------
    >>> from symrt.feedback.parameters import Scale
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.4})
    >>> feasible(system, palette, device_gamut(device), Scale("sea"))
    The scale of sea may be 0.01 … 2.5 to keep the image inside (complete).
    Below 0.01 the range asked for ends; above 2.5 pixel (1, 0) meets the upper bound at 380 nm (where the device's
    data are extrapolated).
    0.0% of the object pixels are darker than the device's black.
    Against unit gamut (0 … 1), black clipped (necessary for a print of any printer; dye-sublimation-like, modelled
    from the dyes of Kodak Professional Endura Premier paper); reference sun, exposure 1.
    """
    # Put the question together, and refuse parts that do not fit.
    start = time.perf_counter()
    within = checked_range(parameter, within)
    check_share(allowed_out, "allowed_out")
    check_share(allowed_dark, "allowed_dark")
    asked = limits(system, palette, gamut, reference)
    line = line_of(system, palette, parameter)

    # Ask every pixel for its intervals.
    now = 0.0 if isinstance(parameter, Blend) else 1.0
    everyone = weighed(system, weights, mask)
    counted = drawn(line, asked, everyone, now, most, extremes=not allowed_out)
    image = _image(line, asked, counted, within, progress)

    # Intersect the values that upper bounds, black and the cap allow.
    budget = counted.allowance(allowed_out, counted.pixels) - counted.sum(image.outside) - counted.sum(image.unfixable)
    constraints = [_upper(image, within, budget), *_dark(line, asked, image, within, allowed_dark, now)]
    symbols = moved_ends(system, palette, parameter).keys()
    capped = physical_cap(palette, symbols) if cap and not isinstance(parameter, Blend) else UNLIMITED
    constraints.append(_alone(Piece(0.0, capped.value, End("range"), End("cap"))))
    found = reduce(shared, [constraint.pieces for constraint in constraints])

    # Keep the question, to tell the reasons and to ask it again.
    stops = _Stops(system, palette, parameter, asked, line, capped)
    kept = (reference or Reference()).kept(system, palette)
    options: dict[str, Any] = {
        "within": within,
        "allowed_out": allowed_out,
        "allowed_dark": allowed_dark,
        "reference": kept,
        "cap": cap,
    }
    options |= {"weights": weights, "mask": mask, "most": most}
    again = partial(_again, system, palette, gamut, parameter, options=options)
    return Feasible(
        parameter=parameter,
        within=within,
        intervals=tuple((piece.low, piece.high) for piece in found),
        reasons=tuple((stops.why(p.below, p.low), stops.why(p.above, p.high)) for p in found),
        conflict=None if found else _conflict(constraints, stops),
        verdict="complete" if budget >= 0 else "rest-only",
        untouched_outside=image.outside,
        unfixable=image.unfixable,
        dark=dark_share(line, asked, everyone.pixels, now, everyone.weights),
        objects=len(counted.pixels),
        above_one=above_one(moved(system, palette, parameter, found[-1].high), symbols) if found else (),
        curve=image.curve,
        note="; ".join(filter(None, [asked.note, counted.note])),
        width=system.width,
        sensitivities=tuple((stops.moves(p.below, p.low), stops.moves(p.above, p.high)) for p in found),
        seconds=time.perf_counter() - start,
        again=None if asked.slow or isinstance(gamut, UnevenGamut) else again,
    )


def _again(
    system: LinearSystem,
    palette: Palette,
    gamut: ConvexGamut | UnevenGamut,
    parameter: Parameter,
    other: Scale | Exposure,
    options: Mapping[str, Any],
) -> Feasible:
    """The same question with another parameter a little lower, against the same white."""
    return feasible(system, moved(system, palette, other, LESS), gamut, parameter, progress=False, **options)


class _Stops(NamedTuple):
    """A question, to tell the reasons at the ends of its intervals."""

    system: LinearSystem
    palette: Palette
    parameter: Parameter
    asked: Limits
    line: Line
    capped: Cap

    def why(self, end: End, t: float) -> Reason:
        """The reason at an end: pixel, wavelength and side, or the cap, or the range."""
        return reason(self.line, self.asked, end, t, self.system.width, self.capped)

    def moves(self, end: End, t: float) -> tuple[Sensitivity, ...]:
        """The sensitivity of an end to each other parameter; none where no pixel stops it."""
        if end.pixel < 0:
            return ()
        weights = met(self.line, self.asked, end, t, self.system.width).weights
        return sensitivities(self.system, self.palette, self.parameter, t, end.pixel, weights)


class _Image(NamedTuple):
    """The intervals of each pixel asked about, and the pixels that the parameter cannot help."""

    counted: Weighed
    touched: Pixels
    spans: Spans
    outside: Pixels
    unfixable: Pixels

    @property
    def curve(self) -> Curve:
        """The share outside at every value; pixels inside whatever the value are neither touched nor outside."""
        whole = self.counted.sum(self.counted.pixels)
        always = whole - self.counted.sum(self.touched) - self.counted.sum(self.outside)
        return curve(self.spans, always, whole, _weights(self.counted, self.spans))


class _Constraint(NamedTuple):
    """The values that one kind of bound allows, and the pixels that ask for most below and above."""

    pieces: list[Piece]
    tightest: Piece


def _image(line: Line, asked: Limits, counted: Weighed, within: Range, progress: bool) -> _Image:
    objects = counted.pixels
    touched, untouched = objects[line.touched[objects]], objects[~line.touched[objects]]
    found = spans_inside_all(line, asked, touched, within, progress)
    fixable = np.zeros(len(touched), dtype=bool)
    fixable[found.pixel] = True
    return _Image(
        counted=counted,
        touched=touched,
        spans=found._replace(pixel=touched[found.pixel]),
        outside=untouched[~inside_all(line, asked, untouched, 0.0)],
        unfixable=touched[~fixable],
    )


def dark_share(
    line: Line, asked: Limits, objects: Pixels, t: float, weights: Int[np.ndarray, " _"] | None = None
) -> float:
    """Share of the object pixels that are darker than the device's black at t, by their weights if given."""
    darker = darker_than_black(line, asked, objects, t)
    if not len(objects):
        return 0.0
    return float(darker.mean()) if weights is None else float(weights[darker].sum() / weights.sum())


def _upper(image: _Image, within: Range, budget: int) -> _Constraint:
    fixable = image.counted.sum(image.touched) - image.counted.sum(image.unfixable)
    return _constraint(image.spans, within, fixable - max(0, budget), "upper", image.counted)


def _dark(line: Line, asked: Limits, image: _Image, within: Range, allowed: Number, now: float) -> list[_Constraint]:
    """The values at which no more than the share allowed of the pixels above black have fallen below."""
    if asked.dark is None:
        return []
    bound, objects = asked.dark, image.counted.pixels
    lit = objects[inside_at(line.seen(bound.matrix, objects), bound, now)]
    touched = lit[line.touched[lit]]
    found = intervals(line.seen(bound.matrix, touched), bound, within)
    needed = image.counted.sum(touched) - image.counted.allowance(allowed, lit)
    return [_constraint(found._replace(pixel=touched[found.pixel]), within, needed, "dark", image.counted)]


def _constraint(spans: Spans, within: Range, needed: int, kind: Kind, counted: Weighed) -> _Constraint:
    found = pieces(spans, within, needed, kind, _weights(counted, spans))
    if found:
        return _Constraint(found, Piece(found[0].low, found[-1].high, found[0].below, found[-1].above))
    whole = Piece(within[0], within[1], End("range"), End("range"))
    return _Constraint(found, tightest(spans, kind) if len(spans.pixel) else whole)


def _weights(counted: Weighed, spans: Spans) -> Int[np.ndarray, " _"] | None:
    return None if counted.weights is None else counted.of(spans.pixel)


def _alone(piece: Piece) -> _Constraint:
    return _Constraint([piece], piece)


def _conflict(constraints: list[_Constraint], stops: _Stops) -> tuple[tuple[float, Reason], tuple[float, Reason]]:
    least = max((c.tightest for c in constraints), key=lambda piece: piece.low)
    most = min((c.tightest for c in constraints), key=lambda piece: piece.high)
    return (least.low, stops.why(least.below, least.low)), (most.high, stops.why(most.above, most.high))


def reason(line: Line, asked: Limits, end: End, t: float, width: int, capped: Cap = UNLIMITED) -> Reason:
    """The reason that ends an interval at t: for a pixel, the bound that its spectrum meets most nearly there."""
    if end.kind == "range":
        return Reason("range")
    if end.kind == "cap":
        return Reason("cap", band=capped.band, symbol=capped.symbol)
    return met(line, asked, end, t, width).reason


def checked_range(parameter: Parameter, within: Range | None) -> tuple[float, float]:
    """The range to look in, the parameter's usual one if none is given."""
    low, high = within or ((0.0, 1.0) if isinstance(parameter, Blend) else (0.01, 3.0))
    if not (0 <= low <= high and np.isfinite(high) and high > 0) or (isinstance(parameter, Blend) and high > 1):
        most = "at most 1" if isinstance(parameter, Blend) else "finite"
        rule = f"0 <= low <= high, high above 0 and {most}"
        raise ValueError(f"within = ({low}, {high}): the {parameter} needs {rule}")
    return float(low), float(high)


def check_share(value: Number, name: str) -> None:
    """Refuse numbers that are no share of pixels."""
    if not 0 <= value <= 1:
        raise ValueError(f"{name} = {value}: it is a share of pixels, from 0 to 1; for 5 % give 0.05")
