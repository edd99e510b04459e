"""The plan of a trace: each effect in one of three states, from not called for to simulated (before step 1).

A plan shows those effects that something calls for, and names the others in a line: the reasons why nothing calls for
them are in the record of each.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape
from math import isfinite
from typing import Literal

from symrt.table import duration, html_table, percent, sentences, text_table

HEAD = ("effect", "", "called for by", "rays at most")
EXPECTED = ("effect", "", "called for by", "rays", "time", "without it pixels miss")
MANY = 8
"""Names beyond which a table shows a few of them only."""
ON_REQUEST = "it was left out on request"

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
    optional
        True if it could be left out, and the error without it bounded.
    """

    name: str
    state: Status
    called_by: tuple[str, ...]
    why: str
    rays: str
    a_sample: int = 0
    optional: bool = False

    @property
    def simulated(self) -> bool:
        """True if the effect is simulated."""
        return self.state == "simulated"

    @property
    def row(self) -> tuple[str, str, str, str]:
        """The effect as a row of the plan's table."""
        names = self.called_by
        shown = ", ".join(names)
        if len(names) > MANY:
            shown = f"{', '.join(names[:3])} … {names[-1]}, {len(names)} in all"
        return self.name, self.state, shown, self.rays


@dataclass(frozen=True)
class Expected:
    """The price that is expected of an effect, and what is lost without it.

    Parameters
    ----------
    rays
        Their number in the whole picture.
    seconds
        Of one processor of the machine that was asked.
    most, mean
        What a pixel misses without it at most, as a share of white, of the pixels that were looked at: the largest, and
        their mean.  None if it cannot be left out.
    certified
        What the certificate of a picture without it would bound its pixels by; infinite if by nothing.
    """

    rays: int
    seconds: float
    most: float | None = None
    mean: float | None = None
    certified: float | None = None

    @property
    def row(self) -> tuple[str, str, str]:
        """Its rays, its time, and what is missed without it, in words."""
        rays = f"{float(f'{self.rays:.2g}'):,.0f}" if self.rays else "none"
        missed = ""
        if self.most is not None and self.mean is not None:
            missed = f"up to {_share(self.most)}, {_share(self.mean)} in the mean" if self.most else "nothing seen"
        return rays, duration(self.seconds), missed


def _share(share: float) -> str:
    """A share with two digits or three."""
    if not isfinite(share):
        return "any share"
    return f"{share:.0%}" if share >= 0.1 else percent(share)


@dataclass(frozen=True)
class Expectation:
    """The prices that are expected of the effects in a plan, from a few rays.

    Parameters
    ----------
    effects
        The camera's own rays first, then the effects that something calls for.
    rays, pixels
        Number of the camera's rays that the prices were expected from, and of the pixels that were compared.
    """

    effects: Mapping[str, Expected]
    rays: int
    pixels: int

    @property
    def note(self) -> str:
        """A sentence about where the numbers come from."""
        seconds = sum(one.seconds for one in self.effects.values())
        return (
            f"expected of {self.rays:,} rays, on one processor of this machine: {duration(seconds)} in all; shares are "
            f"of white, over {self.pixels:,} pixels, for any reflectances up to 1"
        )


@dataclass(frozen=True, repr=False)
class Plan:
    """All effects that symrt knows, each in its state; ``"mirrors" in plan`` is true if mirrors are simulated."""

    effects: tuple[Planned, ...]
    remarks: tuple[str, ...] = ()
    """Sentences about the scene that may surprise whoever made it, such as a camera inside a ball."""
    tolerance: float = TOLERANCE
    """Share of its film sample's light that a ray must carry to be followed; what is not followed is bounded."""

    expectation: Expectation | None = None
    """The price that is expected of each effect, where it was asked for."""

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

    def without(self, name: str, why: str = ON_REQUEST) -> "Plan":
        """The plan with one of its effects left out, for a reason; the error is bounded in the system's tail.

        Raises
        ------
        ValueError
            If the effect is not simulated, or could not be left out.
        """
        if not any(effect.simulated and effect.optional for effect in self.effects if effect.name == name):
            raise ValueError(f"{name} cannot be left out of this plan: it is not simulated, or has no bound")
        effects = tuple(
            replace(effect, state="left out, bounded", why=why, rays="none", a_sample=0)
            if effect.name == name
            else effect
            for effect in self.effects
        )
        return replace(self, effects=effects)

    def restored(self, name: str) -> "Plan":
        """The plan with an effect simulated that was left out, though it need not have been."""
        if not any(effect.optional for effect in self.effects if effect.name == name):
            raise ValueError(f"{name} cannot be part of this plan")
        effects = (replace(one, state="simulated", why="") if one.name == name else one for one in self.effects)
        return replace(self, effects=tuple(effects))

    @property
    def notes(self) -> tuple[str, ...]:
        """The sentences below the plan's table."""
        left_out = (f"{effect.name}: {effect.why}" for effect in self.called_for if not effect.simulated)
        others = ", ".join(effect.name for effect in self.effects if not effect.called_by)
        expected = () if self.expectation is None else (self.expectation.note,)
        return (*left_out, *((f"not called for: {others}",) if others else ()), *expected, *self.remarks)

    @property
    def table(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """The head and the rows of the plan's table: the effects that something calls for."""
        rows = [effect.row for effect in self.called_for]
        if self.expectation is None:
            return HEAD, list(rows)
        expected = self.expectation.effects
        known = [(*row[:-1], *(expected[row[0]].row if row[0] in expected else ("", "", ""))) for row in rows]
        camera = [(name, "", "", *one.row) for name, one in expected.items() if name not in {row[0] for row in rows}]
        return EXPECTED, [*camera, *known]

    def __str__(self) -> str:
        head, rows = self.table
        return "\n".join(([text_table(head, rows)] if rows else []) + [sentences(self.notes)])

    def __repr__(self) -> str:
        return str(self)

    def _repr_html_(self) -> str:
        head, rows = self.table
        return (html_table(head, rows) if rows else "") + "".join(f"<p>{escape(note)}</p>" for note in self.notes)
