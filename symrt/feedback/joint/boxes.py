"""A box of scales that is safe, in words: the answer of `symrt.feedback.joint.freedom`, step 5 of the paper."""

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Int

from symrt.feedback.joint.programmes import Optimum
from symrt.feedback.reasons import Reason, exceptions, footnote, work
from symrt.table import html_table, sentences, text_table

BOX_COLUMNS = ("scale of", "from", "to", "stopped below where", "stopped above where")
Pixels = Int[np.ndarray, " _"]
Box = Mapping[str, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class SafeBox:
    """The largest box of scales whose every point keeps the image inside a gamut.

    Parameters
    ----------
    box
        For each scale the least and the largest value: all may be chosen freely between them.
    reasons
        The reasons that stop each scale below, all others at their least, and above, all others at their largest.
    optimum
        ``"global"``: no box inside is larger; ``"local"``: none nearby is, and device's black is kept.
    separate
        The range of each scale with all others as given, if the boxes were to be compared; empty if some scale has
        none.
    separate_inside
        Share of the box of those ranges that is inside.
    verdict, untouched_outside, unfixable, dark, objects, above_one, note
        As for `Feasible`; ``dark`` and ``above_one`` are those of the darkest and of the lightest corner.
    rounds, rows
        Programmes solved, and rows in the last of them.

    Examples
    --------
    See `safe_box`.
    """

    box: Box
    reasons: Mapping[str, tuple[Reason, Reason]]
    optimum: Optimum
    separate: Box | None
    separate_inside: float | None
    within: tuple[float, float]
    verdict: Literal["complete", "rest-only"]
    untouched_outside: Pixels
    unfixable: Pixels
    dark: float
    objects: int
    above_one: tuple[str, ...]
    note: str
    width: int
    rounds: int
    rows: int
    seconds: float

    @property
    def volume(self) -> float:
        """Product of the sides."""
        return float(np.prod([high - low for low, high in self.box.values()]))

    def __contains__(self, values: Mapping[str, float]) -> bool:
        """Whether every scale named is between its ends."""
        return all(self.box[name][0] <= value <= self.box[name][1] for name, value in values.items())

    @property
    def table(self) -> list[tuple[str, ...]]:
        """The sides as rows of text: name, ends, and the reason that stops the scale at either."""
        return [
            (name, f"{low:.4g}", f"{high:.4g}", *(reason.short for reason in self.reasons[name]))
            for name, (low, high) in self.box.items()
        ]

    def __repr__(self) -> str:
        rest = sentences([*self._notes(), f"Against {self.note}."])
        return "\n".join([sentences([self._answer()]), text_table(BOX_COLUMNS, self.table), rest])

    def _repr_html_(self) -> str:
        notes = "".join(f"<p>{html.escape(line)}</p>" for line in self._notes())
        note = f"<p><small>{html.escape(self.note)}</small></p>"
        return f"<p>{html.escape(self._answer())}</p>{html_table(BOX_COLUMNS, self.table)}{notes}{note}"

    def _answer(self) -> str:
        whom = "the image" if self.verdict == "complete" else "the rest of the image"
        best = "none is larger" if self.optimum == "global" else "none nearby is larger"
        return f"All scales may move freely in this box and keep {whom} inside ({self.verdict}; {best})."

    def _notes(self) -> list[str]:
        where = "With all scales at their least, "
        lines = footnote(reason for pair in self.reasons.values() for reason in pair)
        lines += exceptions(self.untouched_outside, self.unfixable, self.above_one, self.dark, self.objects, where)
        if self.separate == {}:
            lines.append("Some scale has no value that would do with all others as given.")
        elif self.separate is not None:
            size = float(np.prod([high - low for low, high in self.separate.values()]))
            lines.append(
                f"The ranges of single scales, others as given, span a box of volume {size:.3g} "
                f"against {self.volume:.3g}; {self.separate_inside:.1%} of it is inside."
            )
        return [*lines, f"{work(self.rounds, self.rows)}{self.seconds:.2f} s."]
