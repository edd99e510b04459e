"""Counts of what effects did in a render, beside what they cost: they stay with a tree, and with its system."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from symrt.table import duration, html_table, percent, text_table

HEAD = ("", "rays", "pixels", "time")


@dataclass(frozen=True)
class Count:
    """An effect's part in a render.

    Parameters
    ----------
    rays
        Number of rays that it cast.
    seconds
        Time spent in it, and with the rays that it sent on; of several workers the sum.
    pixels
        Number of pixels that it touched: where it sent rays on, hid light, blended materials, or let something shine.
        None where it acts on no pixel by itself.
    ways
        Rays that it sent on by more than one formula: their numbers, by the formula's name.
    """

    rays: int
    seconds: float
    pixels: int | None = None
    ways: Mapping[str, int] = field(default_factory=dict)

    def joined(self, other: "Count") -> "Count":
        """The count of this part of a picture and of another."""
        known = [count.pixels for count in (self, other) if count.pixels is not None]
        names = sorted({*self.ways, *other.ways})
        ways = {name: self.ways.get(name, 0) + other.ways.get(name, 0) for name in names}
        return Count(self.rays + other.rays, self.seconds + other.seconds, sum(known) if known else None, ways)

    def row(self, pixels: int) -> tuple[str, str, str]:
        """Its rays, its share of so many pixels and its time, in words."""
        ways = ", ".join(f"{number:,} {name}" for name, number in self.ways.items())
        rays = f"{self.rays:,}" + (f" ({ways})" if len(self.ways) > 1 else "") if self.rays else "none"
        share = "" if self.pixels is None else percent(self.pixels / max(1, pixels))
        return rays, share, duration(self.seconds)


@dataclass(frozen=True, repr=False)
class Counts:
    """The counts of all effects that took part in a render, and of the camera's own rays.

    Parameters
    ----------
    pixels
        Of the picture.

    Examples
    --------
    >>> Counts({"camera": Count(65536, 0.02, 65536), "shadows": Count(23332, 0.004, 1166)}, 65536)
             rays    pixels  time
    camera   65,536  100.0%  0.02 s
    shadows  23,332  1.8%    0.004 s
    """

    effects: Mapping[str, Count] = field(default_factory=dict)
    pixels: int = 0

    def joined(self, other: "Counts") -> "Counts":
        """The counts of two parts of a picture together."""
        both = {**self.effects, **other.effects}
        found = {
            name: self.effects[name].joined(other.effects[name])
            if name in self.effects and name in other.effects
            else count
            for name, count in both.items()
        }
        return Counts(found, self.pixels + other.pixels)

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The counts as rows of a table."""
        return [(name, *count.row(self.pixels)) for name, count in self.effects.items()]

    def __repr__(self) -> str:
        return text_table(HEAD, self.rows)

    def _repr_html_(self) -> str:
        return html_table(HEAD, self.rows)
