"""The pairs of two parameters that keep an image inside, in words: step 5 of the paper, for `joint_region`."""

import html
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float, Int

from symrt.feedback.joint.boxes import SafeBox
from symrt.feedback.parameters import Blend, Parameter
from symrt.feedback.reasons import Feasible, Reason
from symrt.spectra.bands import Number
from symrt.table import sentences

Ends = tuple[float, float]
Pair = tuple[Number, Number]
Pixels = Int[np.ndarray, " _"]
SHOWS = 0.0005
"""An error from which on a share's first decimal place may be another."""


def given_value(parameter: Parameter) -> float:
    """The value at which a parameter leaves the palette as it is: 0 for a blend, 1 for any other."""
    return 0.0 if isinstance(parameter, Blend) else 1.0


@dataclass(frozen=True, eq=False)
class JointRegion:
    """The pairs of values of two parameters that keep an image inside a gamut, line by line.

    Parameters
    ----------
    one, other
        The parameters; the other moves what the one has moved already.
    within
        The range of each.
    values
        The values of the one at which lines were drawn, ascending.
    intervals
        For each line, the values of the other that keep the image inside there, certified.
    reasons
        For each of those intervals, what stops the other below and above.
    across
        Values of the other, evenly over its range.
    outside
        The share of the object pixels outside at each line and each of `across`.
    separate
        The range of each parameter with the other as given.
    hidden
        The area that may hide between lines, or be too much: a bound where the region is convex, else an estimate.
    separate_inside
        Share of the rectangle of those ranges that keeps the image inside; None where a range is empty or a point.
    separate_hidden
        As `hidden`, of what lies in that rectangle.
    box
        The largest rectangle in which both may move freely; None if they are not scales over one range.
    verdict, untouched_outside, unfixable, objects, note, width, seconds
        As for `Feasible`; ``unfixable`` pixels are outside on all of every line.

    Examples
    --------
    See `joint_region`.
    """

    one: Parameter
    other: Parameter
    within: tuple[Ends, Ends]
    values: Float[np.ndarray, " line"]
    intervals: tuple[tuple[Ends, ...], ...]
    reasons: tuple[tuple[tuple[Reason, Reason], ...], ...]
    across: Float[np.ndarray, " step"]
    outside: Float[np.ndarray, "line step"]
    separate: tuple[Feasible, Feasible]
    hidden: float
    separate_inside: float | None
    separate_hidden: float
    box: SafeBox | None
    verdict: Literal["complete", "rest-only"]
    untouched_outside: Pixels
    unfixable: Pixels
    objects: int
    note: str
    width: int
    seconds: float

    @property
    def given(self) -> Ends:
        """The pair at which the palette is as given."""
        return given_value(self.one), given_value(self.other)

    @property
    def share(self) -> float:
        """Share of all pairs asked about that keep the image inside."""
        lengths = [sum(b - a for a, b in line) for line in self.intervals]
        return float(np.trapezoid(lengths, self.values)) / self._area

    @property
    def share_error(self) -> float:
        """By how much `share` may be off: a bound where the region is convex, an estimate where it is not."""
        return self.hidden / self._area

    @property
    def separate_area(self) -> float:
        """The area of the rectangle of the separate ranges."""
        first, second = (sum(high - low for low, high in alone.intervals) for alone in self.separate)
        return first * second

    @property
    def separate_error(self) -> float | None:
        """By how much `separate_inside` may be off, as `share_error`."""
        return None if self.separate_inside is None else self.separate_hidden / self.separate_area

    @property
    def _area(self) -> float:
        (low, high), (bottom, top) = self.within
        return (high - low) * (top - bottom)

    def __contains__(self, pair: Pair) -> bool:
        """Whether a pair lies in the intervals of its line, or of the lines on both its sides."""
        first, second = pair
        after = int(np.searchsorted(self.values, first))
        if after == len(self.values) or first < self.values[0]:
            return False
        before = after if self.values[after] == first else after - 1
        return all(any(a <= second <= b for a, b in self.intervals[k]) for k in (before, after))

    def __repr__(self) -> str:
        return sentences([*self._lines(), f"Against {self.note}."])

    def _repr_html_(self) -> str:
        rows = "".join(f"<p>{html.escape(line)}</p>" for line in self._lines())
        return f"{rows}<p><small>{html.escape(self.note)}</small></p>"

    def _lines(self) -> list[str]:
        # The share of all pairs.
        whom = "the image" if self.verdict == "complete" else "the rest of the image"
        (low, high), (bottom, top) = self.within
        lines = [
            f"Of all pairs, {self.one} in {low:g} … {high:g} and {self.other} in {bottom:g} … {top:g}, "
            f"{_measured(self.share, self.share_error)} keep {whom} inside ({self.verdict})."
        ]

        # The ranges one by one, their rectangle, and the box in which both are free.
        ranges = [" or ".join(f"{a:.4g} … {b:.4g}" for a, b in found.intervals) or "none" for found in self.separate]
        lines.append(f"One by one, {self.one}: {ranges[0]}; {self.other}: {ranges[1]}.")
        if self.separate_inside is not None and self.separate_error is not None:
            share = _measured(self.separate_inside, self.separate_error)
            lines.append(f"Of the rectangle of these ranges {share} is inside.")
        if self.box is not None:
            sides = "; ".join(f"{name} {a:.4g} … {b:.4g}" for name, (a, b) in self.box.box.items())
            lines.append(f"Both are free of each other in {sides}.")

        # The pixels that are outside whatever the pair.
        counts = (
            (len(self.untouched_outside), "outside and untouched"),
            (len(self.unfixable), "outside on every line"),
        )
        return lines + [f"{n} of {self.objects} object pixels are {what}." for n, what in counts if n]


def _measured(share: float, error: float) -> str:
    """A share, with its error where that shows."""
    return f"{share:.1%}" + (f" (± {error:.1%})" if error >= SHOWS else "")
