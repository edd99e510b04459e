"""The answer of `feasible`, in words: the values of a parameter that keep an image inside, and why no others."""

import html
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from jaxtyping import Int

from symrt.feedback.parameters import Blend, Exposure, Parameter, Scale
from symrt.feedback.sensitivity import SHOWN, Move, Sensitivity, sentence
from symrt.feedback.shares import Curve
from symrt.table import sentences

FOOTNOTE = "* The device's data are extrapolated there."
Side = Literal["upper", "lower", "luminance", "range", "cap", "objective"]


@dataclass(frozen=True)
class Reason:
    """The reason that stops a parameter at a value.

    Parameters
    ----------
    side
        ``"upper"`` or ``"lower"``: a pixel meets that bound of a band; ``"luminance"``: a pixel meets the luminance of
        the device's black; ``"cap"``: reflectances would sum to more than 1; ``"range"``: the range asked for ends;
        ``"objective"``: nothing better is found beyond.
    x, y
        The pixel: column from the left, row from the top.
    band
        The band, as ``"560 nm"``.
    extrapolated
        True if the device was not measured in that band.
    symbol
        The material or symbol that would pass 1, for a cap.
    of
        The quantity bounded, where it is no single band: ``"the monitor's red"``.
    """

    side: Side
    x: int | None = None
    y: int | None = None
    band: str | None = None
    extrapolated: bool = False
    symbol: str | None = None
    of: str | None = None

    def __str__(self) -> str:
        if self.side == "range":
            return "the range asked for ends"
        if self.side == "objective":
            return "nothing better is found beyond"
        guess = " (where the device's data are extrapolated)" if self.extrapolated else ""
        if self.side == "cap":
            return f"{self.symbol} would reflect more than it receives at {self.band}"
        if self.side == "luminance":
            return f"pixel ({self.x}, {self.y}) meets the luminance of the device's black"
        of, at = (f" of {self.of}" if self.of else ""), (f" at {self.band}" if self.band else "")
        return f"pixel ({self.x}, {self.y}) meets the {self.side} bound{of if at else of.rstrip(',')}{at}{guess}"

    @property
    def short(self) -> str:
        """The same for a table; an asterisk marks what is extrapolated, see `footnote`.

        Examples
        --------
        >>> Reason("upper", 53, 11, "730 nm", extrapolated=True).short
        'pixel (53, 11), upper bound, 730 nm*'
        """
        if self.side in {"range", "objective"}:
            return "end of the range" if self.side == "range" else "nothing better beyond"
        if self.side == "cap":
            return f"{self.symbol} reflects more than all, {self.band}"
        bound = "black's luminance" if self.side == "luminance" else f"{self.side} bound"
        of, at = (f" of {self.of}" if self.of else ""), (f", {self.band}" if self.band else "")
        return f"pixel ({self.x}, {self.y}), {bound}{of}{at}{'*' if self.extrapolated else ''}"


@dataclass(frozen=True, eq=False)
class Feasible:
    """The values of one parameter that keep an image inside a gamut.

    Parameters
    ----------
    parameter
        The parameter asked about.
    within
        The range asked about.
    intervals
        The values found, as closed intervals; none if there are none.
    reasons
        For each interval, the reasons that stop it below and above.
    conflict
        Where there is no value: the least that one bound needs and the most that another allows, with reasons.
    verdict
        ``"complete"``: with these values at most the share allowed is outside.  ``"rest-only"``: more than that is
        outside whatever the value; the intervals hold for the rest.
    untouched_outside
        Pixels that are outside and do not depend on the parameter.
    unfixable
        Pixels that depend on it, and that no value in the range certainly brings inside; a pixel exactly on a bound,
        which rounding cannot tell from outside, is among them.
    dark
        Share of the object pixels that are darker than the device's black with the palette given.
    objects
        Number of object pixels asked about, those that light reaches.
    above_one
        Materials whose scaled components together pass 1 at the highest value found.
    curve
        Share of the object pixels outside, as a function of the value.
    note
        Gamut, reference and exposure, and anything modelled or left out.
    width
        Of the image, to turn pixel numbers into places.
    seconds
        Time it took.
    sensitivities
        For each interval, the sensitivities of its lower and of its upper limit to each other light, material and the
        exposure, as long as the same pixel stops it; none where no pixel does.
    again
        The same question with another parameter at 0.99, against the same white; None where that takes long, of hulls
        and inks and what they are intersected with.
    """

    parameter: Parameter
    within: tuple[float, float]
    intervals: tuple[tuple[float, float], ...]
    reasons: tuple[tuple[Reason, Reason], ...]
    conflict: tuple[tuple[float, Reason], tuple[float, Reason]] | None
    verdict: Literal["complete", "rest-only"]
    untouched_outside: Int[np.ndarray, " outside"]
    unfixable: Int[np.ndarray, " unfixable"]
    dark: float
    objects: int
    above_one: tuple[str, ...]
    curve: Curve
    note: str
    width: int
    seconds: float
    sensitivities: tuple[tuple[tuple[Sensitivity, ...], tuple[Sensitivity, ...]], ...] = ()
    again: "Callable[[Scale | Exposure], Feasible] | None" = None

    @cached_property
    def moves(self) -> tuple[tuple[tuple[Move, ...], tuple[Move, ...]], ...]:
        """For each interval, the moves of its lower and of its upper limit with another parameter at 0.99.

        The parameters that may move a limit most are asked about, when this is first looked at; none where no pixel
        stops the limit, or the intervals become more or fewer, or one ends with the range asked about.
        """
        answers: dict[Scale | Exposure, Feasible] = {}
        return tuple(
            (self._moves(k, 0, below, answers), self._moves(k, 1, above, answers))
            for k, (below, above) in enumerate(self.sensitivities)
        )

    def _moves(
        self, interval: int, side: int, found: Sequence[Sensitivity], answers: "dict[Scale | Exposure, Feasible]"
    ) -> tuple[Move, ...]:
        if self.again is None:
            return ()
        # Ask again, once for each other parameter.
        moves = []
        for one in found[:SHOWN]:
            if one.parameter not in answers:
                answers[one.parameter] = self.again(one.parameter)
            answer, before = answers[one.parameter], self.intervals[interval][side]
            if len(answer.intervals) != len(self.intervals) or answer.reasons[interval][side].side == "range":
                continue

            # A blend moves by a difference, a scale by a ratio, of which there is none at 0.
            after = answer.intervals[interval][side]
            if isinstance(self.parameter, Blend):
                moves.append(Move(one.parameter, after - before))
            elif before:
                moves.append(Move(one.parameter, after / before - 1))
        return tuple(moves)

    @property
    def low(self) -> float | None:
        """The least value found, None if there is none."""
        return self.intervals[0][0] if self.intervals else None

    @property
    def high(self) -> float | None:
        """The largest value found, None if there is none."""
        return self.intervals[-1][1] if self.intervals else None

    @property
    def none_inside(self) -> bool:
        """True if every pixel asked about is outside whatever the value, so that there is no rest to keep inside."""
        return 0 < self.objects == len(self.untouched_outside) + len(self.unfixable)

    def places(self, pixels: Int[np.ndarray, " pixel"]) -> Int[np.ndarray, "pixel 2"]:
        """Columns x and rows y of numbered pixels."""
        return np.stack([pixels % self.width, pixels // self.width], axis=1)

    def __repr__(self) -> str:
        return f"{self.words}\n{sentences([f'Against {self.note}.'])}"

    @property
    def words(self) -> str:
        """The answer in sentences, but for what it was asked against."""
        return sentences([self._answer(), *self._reasons(), *self._exceptions()])

    def _repr_html_(self) -> str:
        rows = "".join(f"<li>{html.escape(line)}</li>" for line in [*self._reasons(), *self._exceptions()])
        return f"<p>{html.escape(self._answer())}</p><ul>{rows}</ul><p><small>{html.escape(self.note)}</small></p>"

    def _answer(self) -> str:
        what = str(self.parameter)
        if self.none_inside:
            return f"No pixel is inside, whatever the {what}: there is no rest to keep inside ({self.verdict})."
        if not self.intervals:
            low, high = self.within
            return f"The {what} has no value in {low:g} … {high:g} that keeps the image inside ({self.verdict})."
        values = " or ".join(f"{low:.4g} … {high:.4g}" for low, high in self.intervals)
        whom = "the image" if self.verdict == "complete" else "the rest of the image"
        return f"The {what} may be {values} to keep {whom} inside ({self.verdict})."

    def _reasons(self) -> list[str]:
        # Without a value, say which two bounds contradict each other.
        if self.conflict is not None:
            (least, needs), (most, allows) = self.conflict
            t, outside = self.curve.least(self.within)
            return [
                f"At least {least:.4g} is needed, where {needs}; at most {most:.4g} is allowed, where {allows}.",
                f"The smallest share outside is {outside:.2%}, at {t:.4g}.",
            ]

        # With values, say what stops each interval, and what would move its limits.
        lines = []
        moves = self.moves or [((), ())] * len(self.intervals)
        for (low, high), (below, above), sides in zip(self.intervals, self.reasons, moves, strict=True):
            lines.append(f"Below {low:.4g} {below}; above {high:.4g} {above}.")
            named = zip(("lower", "upper"), sides, strict=True)
            lines += [sentence(side, name, absolute=isinstance(self.parameter, Blend)) for name, side in named]
        return [line for line in lines if line]

    def _exceptions(self) -> list[str]:
        return exceptions(self.untouched_outside, self.unfixable, self.above_one, self.dark, self.objects)


def footnote(reasons: Iterable[Reason]) -> list[str]:
    """The meaning of the asterisk of `Reason.short`, if there is one."""
    return [FOOTNOTE] if any(reason.extrapolated for reason in reasons) else []


def exceptions(
    untouched: Int[np.ndarray, " outside"],
    unfixable: Int[np.ndarray, " unfixable"],
    above_one: tuple[str, ...],
    dark: float,
    objects: int,
    where: str = "",
) -> list[str]:
    """Sentences about pixels and materials that stay outside the rules; `where` says when pixels are dark."""
    counts = ((len(untouched), "outside and untouched"), (len(unfixable), "outside whatever the value"))
    lines = [f"{n} of {objects} object pixels are {what}." for n, what in counts if n]
    if above_one:
        lines.append(f"More would be reflected than received by {', '.join(above_one)}.")
    return [*lines, f"{where}{dark:.1%} of the object pixels are darker than the device's black."]


def work(rounds: int, rows: int) -> str:
    """The programmes that were solved, if any.

    Examples
    --------
    >>> work(1, 12), work(0, 0)
    ('1 programme of up to 12 rows, ', '')
    """
    return f"{rounds} programme{'' if rounds == 1 else 's'} of up to {rows} rows, " if rounds else ""
