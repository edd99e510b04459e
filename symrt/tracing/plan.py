"""The plan of a trace: each effect in one of three states, from not called for to simulated (before step 1).

A plan shows those effects that something calls for, and names the others in a line: the reasons why nothing calls for
them are in the record of each.
"""

from dataclasses import dataclass
from html import escape
from typing import Literal

from symrt.table import html_table, sentences, text_table

HEAD = ("effect", "", "called for by", "rays at most")

TOLERANCE = 1e-3
"""Share of a film sample's light below which rays are not followed, unless told otherwise."""

Status = Literal["not called for", "simulated", "left out, bounded", "left out, not bounded"]


@dataclass(frozen=True)
class Planned:
    """One effect, its state, and why.

    Parameters
    ----------
    state
        ``not called for``: nothing in the scene needs it, and nothing is lost.  ``left out, bounded``: something does,
        and the error without it is bounded in the system's tail.  ``left out, not bounded``: something
        does, and no bound is known, so that certificates are of everything else.
    called_by
        Names of the lights, materials or textures that call for it.
    why
        The reason that it is not simulated; empty where it is.
    rays
        The largest number of rays that it may cost, in words.
    a_sample
        The number of rays expected of it for each sample of the film, as far as the scene alone tells.
    """

    name: str
    state: Status
    called_by: tuple[str, ...]
    why: str
    rays: str
    a_sample: int = 0

    @property
    def simulated(self) -> bool:
        """True if the effect is simulated."""
        return self.state == "simulated"

    @property
    def row(self) -> tuple[str, str, str, str]:
        """The effect as a row of the plan's table."""
        return self.name, self.state, ", ".join(self.called_by), self.rays


@dataclass(frozen=True, repr=False)
class Plan:
    """All effects that symrt knows, each in its state; ``"mirrors" in plan`` is true if mirrors are simulated."""

    effects: tuple[Planned, ...]
    remarks: tuple[str, ...] = ()
    """Sentences about the scene that may surprise whoever made it, such as a camera inside a ball."""
    tolerance: float = TOLERANCE
    """Share of its film sample's light that a ray must carry to be followed; what is not followed is bounded."""

    def __contains__(self, name: str) -> bool:
        return any(effect.simulated for effect in self.effects if effect.name == name)

    @property
    def rays_a_sample(self) -> int:
        """Rays expected for each sample of the film, the camera's own among them; tiles are sized by it."""
        return 1 + sum(effect.a_sample for effect in self.effects)

    @property
    def left_out(self) -> frozenset[str]:
        """Names of the effects that something calls for, but that are left out and bounded."""
        return frozenset(effect.name for effect in self.effects if effect.state == "left out, bounded")

    @property
    def called_for(self) -> tuple[Planned, ...]:
        """The effects that something in the scene calls for, simulated or left out."""
        return tuple(effect for effect in self.effects if effect.called_by)

    @property
    def notes(self) -> tuple[str, ...]:
        """The sentences below the plan's table."""
        left_out = (f"{effect.name}: {effect.why}" for effect in self.called_for if not effect.simulated)
        others = ", ".join(effect.name for effect in self.effects if not effect.called_by)
        return (*left_out, *((f"not called for: {others}",) if others else ()), *self.remarks)

    def __str__(self) -> str:
        rows = [effect.row for effect in self.called_for]
        return "\n".join(([text_table(HEAD, rows)] if rows else []) + [sentences(self.notes)])

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        rows = [effect.row for effect in self.called_for]
        return (html_table(HEAD, rows) if rows else "") + "".join(f"<p>{escape(note)}</p>" for note in self.notes)
