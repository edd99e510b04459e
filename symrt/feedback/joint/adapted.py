"""The answer of `adapt`: the means tried, the figures that each reached, and the one accepted (step 5 of the paper)."""

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from symrt.spectra.bands import Number
from symrt.spectra.image import SpectralImage
from symrt.spectra.palette import Palette
from symrt.spectra.shading import shade
from symrt.system import LinearSystem
from symrt.table import html_table, percent, sentences, text_table

FIGURE_ROUNDING = 1e-9
"""Difference of a figure from its criterion that counts as none."""
STEP_COLUMNS = ("means", "inside", "ΔE2000", "lightness", "luminance", "lacking", "s")


@dataclass(frozen=True, eq=False)
class Step:
    """One means tried, and the figures that it reaches.

    Parameters
    ----------
    means
        In words.
    inside
        Share of the object pixels asked that are inside the gamut.
    difference
        Mean CIEDE2000 from the image given.
    lightness
        Mean CIE L*, as a share of that of the image given.
    luminance
        Mean of min(Y, 1), as a share of that of the image given.
    binds
        The scales, pixels and bands that kept it from changing less.
    palette
        Its spectra, all changes included.
    exposure
        The factor on all lights that they include.
    left_out
        Share of the object pixels that it was allowed to leave outside the bounds in each band.
    mapped
        The image, if its pixels were moved one by one.
    """

    means: str
    inside: float
    difference: float
    lightness: float
    luminance: float
    binds: str
    palette: Palette
    exposure: float
    left_out: float
    seconds: float
    mapped: SpectralImage | None = None


@dataclass(frozen=True)
class Criteria:
    """The criteria of an adapted image; None where nothing is asked."""

    least_inside: float = 1.0
    most_difference: Number | None = None
    least_lightness: Number | None = None
    least_luminance: Number = 0.5

    def lacking(self, step: Step) -> frozenset[str]:
        """The criteria that a step does not meet: ``"inside"``, ``"difference"``, ``"lightness"`` and the like."""
        met = {
            "inside": step.inside >= self.least_inside - FIGURE_ROUNDING,
            "difference": self.most_difference is None or step.difference <= self.most_difference + FIGURE_ROUNDING,
            "lightness": self.least_lightness is None or step.lightness >= self.least_lightness - FIGURE_ROUNDING,
            "luminance": step.luminance >= self.least_luminance - FIGURE_ROUNDING,
        }
        return frozenset(name for name, enough in met.items() if not enough)

    def met(self, step: Step) -> bool:
        """Whether a step meets all of them."""
        return not self.lacking(step)

    def __str__(self) -> str:
        every = self.least_inside == 1
        parts = ["every pixel inside" if every else f"at least {self.least_inside:.1%} of the pixels inside"]
        if self.most_difference is not None:
            parts.append(f"a mean ΔE2000 of at most {self.most_difference:g}")
        if self.least_lightness is not None:
            parts.append(f"at least {self.least_lightness:.1%} of the lightness")
        if self.least_luminance:
            parts.append(f"at least {self.least_luminance:.0%} of the luminance")
        return ", ".join(parts)


@dataclass(frozen=True, eq=False)
class Adapted:
    """The simplest change of an image that meets stated criteria, or why none does.

    Parameters
    ----------
    steps
        The means tried, the simplest first; the last is accepted, or none is.
    accepted
        The step that meets all criteria; None if there is none.
    asked, objects
        Number of pixels on which colours were compared, and number of pixels that light reaches.
    note
        The gamut.

    Examples
    --------
    See `adapt`.
    """

    criteria: Criteria
    steps: tuple[Step, ...]
    accepted: Step | None
    asked: int
    objects: int
    note: str
    seconds: float

    @property
    def verdict(self) -> Literal["reached", "not reached"]:
        """``"reached"`` if some step meets all criteria."""
        return "reached" if self.accepted else "not reached"

    @property
    def palette(self) -> Palette:
        """The spectra accepted.

        Raises
        ------
        ValueError
            If no step was accepted.
        """
        return self._accepted().palette

    @property
    def exposure(self) -> float:
        """The factor on all lights that the palette includes."""
        return self._accepted().exposure

    def image(self, system: LinearSystem) -> SpectralImage:
        """The image accepted: the palette's, or the one whose pixels were moved."""
        step = self._accepted()
        return shade(system, step.palette) if step.mapped is None else step.mapped

    @property
    def reachable(self) -> Mapping[str, float | None]:
        """For each criterion that no step met with all others, the best figure of the steps that meet the others."""
        if self.accepted:
            return {}
        best: dict[str, float | None] = {}
        for name in ("inside", "difference", "lightness", "luminance"):
            own = [getattr(step, name) for step in self.steps if self.criteria.lacking(step) <= {name}]
            if any(name in self.criteria.lacking(step) for step in self.steps):
                best[name] = (min(own) if name == "difference" else max(own)) if own else None
        return best

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The steps as rows of text."""
        return [
            (
                step.means + (f", {step.left_out:.2%} left out" if step.left_out else ""),
                percent(step.inside),
                f"{step.difference:.2f}",
                f"{step.lightness:.1%}",
                f"{step.luminance:.1%}",
                ", ".join(sorted(self.criteria.lacking(step))) or "nothing",
                f"{step.seconds:.2f}",
            )
            for step in self.steps
        ]

    def __repr__(self) -> str:
        table = text_table(STEP_COLUMNS, self.rows)
        rest = sentences([*self._reasons(), f"Against {self.note}; {self.seconds:.2f} s."])
        return "\n".join([sentences([self._answer()]), table, rest])

    def _repr_html_(self) -> str:
        lines = "".join(f"<p>{html.escape(line)}</p>" for line in self._reasons())
        note = f"<p><small>Against {html.escape(self.note)}</small></p>"
        return f"<p>{html.escape(self._answer())}</p>{html_table(STEP_COLUMNS, self.rows)}{lines}{note}"

    def _accepted(self) -> Step:
        if self.accepted is None:
            raise ValueError(f"no image with {self.criteria} was found: see .steps, and ask for less: {self.reachable}")
        return self.accepted

    def _answer(self) -> str:
        if self.accepted is None:
            return f"No means tried reaches {self.criteria}."
        return f"Reached by {self.rows[-1][0]}: {self.criteria}."

    def _reasons(self) -> list[str]:
        drawn = "" if self.asked == self.objects else f"Colours of {self.asked} of {self.objects} pixels, drawn evenly."
        lines = [f"{step.means}: {step.binds}." for step in self.steps if step.binds]
        for name, value in self.reachable.items():
            least = "none of the means meets the others" if value is None else f"{_figure(name, value)} at best"
            lines.append(f"With all other criteria met, {name}: {least}.")
        return [*lines, *([drawn] if drawn else [])]


def _figure(name: str, value: float) -> str:
    return f"{value:.2f}" if name == "difference" else percent(value)
