"""The palette that a fit chose, in words: the value of each scale, and the reason that stopped it there."""

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Int

from symrt.feedback.reasons import Reason, exceptions, footnote, work
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.table import html_table, sentences, text_table

FIT_COLUMNS = ("scale of", "factor", "stopped where")


@dataclass(frozen=True, eq=False)
class Fit:
    """The palette in a range of scales that keeps an image inside a gamut and is best in some respect.

    Parameters
    ----------
    palette
        The spectra that reproduce it: ``shade(system, fit.palette)``.  It carries the white of `reference`, also into a
        file, so that it is seen and asked about as it was fitted.
    reference
        The white and the exposure that the fit was asked with, fixed.
    values
        The factor on the spectra of each scale.
    reasons
        For each scale, the reason that stopped it there.
    verdict
        ``"complete"``: no more pixels are outside than allowed; ``"rest-only"``: more are, whatever the scales;
        ``"unacceptable"``: too little of the image's luminance would be left.
    untouched_outside
        Pixels that are outside and do not depend on the scales.
    unfixable
        Pixels that are outside even with all scales at the low end of the range.
    left_out
        Pixels that other scales would bring inside, and that are outside because a share of them may be.
    dark
        Share of the object pixels that come out darker than the device's black.
    objects
        Number of object pixels, those that light reaches.
    above_one
        Materials that reflect more than they receive.
    optimum
        ``"global"``: no palette in the range is better, or, of the darkest, none that is nowhere above the lightest;
        ``"local"``: none nearby is.
    luminance
        Mean luminance, as a share of the mean of min(Y, 1) of the image given.
    rounds, rows
        Programmes solved, and rows in the last of them; 0 for filling.
    note
        Gamut, reference and exposure, and anything modelled or left out.
    """

    palette: Palette
    values: Mapping[str, float]
    reasons: Mapping[str, Reason]
    objective: str
    within: tuple[float, float]
    verdict: Literal["complete", "rest-only", "unacceptable"]
    untouched_outside: Int[np.ndarray, " outside"]
    unfixable: Int[np.ndarray, " unfixable"]
    left_out: Int[np.ndarray, " left"]
    dark: float
    objects: int
    above_one: tuple[str, ...]
    optimum: Literal["global", "local"]
    luminance: float
    rounds: int
    rows: int
    note: str
    width: int
    reference: Reference
    seconds: float

    @property
    def share_out(self) -> float:
        """Share of the object pixels that are outside."""
        return (len(self.untouched_outside) + len(self.unfixable) + len(self.left_out)) / max(1, self.objects)

    @property
    def table(self) -> list[tuple[str, ...]]:
        """The scales as rows of text: name, factor, and the reason that stopped it there."""
        return [(name, f"{value:.4g}", self.reasons[name].short) for name, value in self.values.items()]

    def __repr__(self) -> str:
        rest = [*footnote(self.reasons.values()), *self._exceptions(), f"Against {self.note}."]
        return "\n".join([sentences([self._answer()]), text_table(FIT_COLUMNS, self.table), sentences(rest)])

    def _repr_html_(self) -> str:
        lines = [*footnote(self.reasons.values()), *self._exceptions()]
        rest = "".join(f"<p>{html.escape(line)}</p>" for line in lines)
        note = f"<p><small>{html.escape(self.note)}</small></p>"
        return f"<p>{html.escape(self._answer())}</p>{html_table(FIT_COLUMNS, self.table)}{rest}{note}"

    def _answer(self) -> str:
        low, high = self.within
        if self.verdict == "unacceptable":
            return (
                f"No acceptable solution with scales in {low:g} … {high:g}: the {self.objective} image inside would "
                f"keep {self.luminance:.1%} of the luminance (min(Y, 1) on average) of the image given."
            )
        whom = "image inside" if self.verdict == "complete" else "image, inside but for some pixels,"
        best = "" if self.optimum == "global" else "; none nearby is better"
        return f"The {self.objective} {whom} with scales in {low:g} … {high:g} ({self.verdict}{best})."

    def _exceptions(self) -> list[str]:
        lines = exceptions(self.untouched_outside, self.unfixable, self.above_one, self.dark, self.objects)
        if len(self.left_out):
            lines.insert(0, f"{len(self.left_out)} of {self.objects} object pixels are left outside, as allowed.")
        if self.objective == "darkest" and any(why.side in ("lower", "luminance") for why in self.reasons.values()):
            lines.append("Single pixels that are above black as given stop it: a larger allowed_dark lets some fall.")
        done = f"{work(self.rounds, self.rows)}{self.seconds:.2f} s"
        return [*lines, f"{done}; mean luminance {self.luminance:.1%} of the image given."]
