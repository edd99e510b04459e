"""Results as tables for a reader (steps 4 and 5 of the paper)."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from symrt.feedback.joint.fitted import Fit
from symrt.feedback.reasons import Feasible, footnote
from symrt.show.records import inside_proves
from symrt.show.segments import Segment, Segments
from symrt.table import WIDTH, sentences, text_table

LIGHT = re.compile(r", (illuminant/[^,]+)")
"""The light in the name of a fact on colours."""


def gamut_table(facts: dict[str, Any]) -> str:
    """Facts as text: long ones as sentences, short ones one a line, lists of numbers side by side, then the source.

    Examples
    --------
    >>> print(gamut_table({"bands": 36, "modelled": True, "components k": [1, 2], "rms": [0.125, 0.01]}))
    bands     36
    modelled  yes
    <BLANKLINE>
    components k  rms
    1             0.125
    2             0.01
    """
    # Lists of numbers are columns; other facts are lines, or sentences where a line is too long.
    columns = {name: value for name, value in facts.items() if _is_column(value)}
    texts = {name: _shown(value) for name, value in facts.items() if name not in columns}
    longest = max(map(len, texts))
    long = [name for name, text in texts.items() if longest + 2 + len(text) > WIDTH]
    width = max((len(name) for name in texts if name not in long), default=0)
    lines = "\n".join(f"{name:<{width}}  {text}".rstrip() for name, text in texts.items() if name not in long)

    # Words that all heads of columns share stand above the table.
    rows = zip(*([_shown(item) for item in column] for column in columns.values()), strict=True)
    lights = sorted({found[1] for name in columns if (found := LIGHT.search(name))})
    above = [f"Of k components, colours under {', '.join(lights)}:"] if lights else []
    heads = tuple(LIGHT.sub("", name).replace(" of k components", "") for name in columns)
    table = ["\n".join([*above, text_table(heads, rows)])] if columns else []

    source = [name for name in long if name == "provenance"]
    said = [sentences(f"{n}: {texts[n]}" for n in some) for some in ([n for n in long if n not in source], source)]
    return "\n\n".join(filter(None, [said[0], lines, *table, said[1]]))


def _is_column(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and not isinstance(value[0], str)


def ranges_table(ranges: Sequence[Feasible]) -> str:
    """Feasible ranges one below the other, each with its verdict and the reason of its upper end."""
    head = ["parameter", "low", "high", "verdict", "outside", "stopped above by", "reflects above 1"]
    rows = [row for found in ranges for row in _rows(found)]
    if all(row[-1] == "-" for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    reasons = [above for found in ranges for _, above in found.reasons]
    return "\n".join([text_table(head, rows, ruled=True), *footnote(reasons)])


def ranges_text(ranges: Sequence[Feasible]) -> str:
    """Feasible ranges as a table and in words; a reference that all share stands once."""
    alike = len({found.note for found in ranges}) == 1
    parts = [found.words if alike else repr(found) for found in ranges]
    return "\n\n".join([ranges_table(ranges), *parts, *([sentences([f"Against {ranges[0].note}."])] if alike else [])])


def fits_table(fits: Mapping[str, Fit]) -> str:
    """The scales that each fit chose, side by side, with the reasons that stopped them in the last fit."""
    last = list(fits.values())[-1]
    head = ("scale of", *fits, f"stopped in the {last.objective}")
    body = [(n, *(f"{f.values[n]:.4g}" for f in fits.values()), last.reasons[n].short) for n in last.values]
    return "\n".join([text_table(head, body, ruled=True), *footnote(last.reasons.values())])


def segments_table(found: Segments) -> str:
    """The parts of the materials' and blends' segments inside a gamut, with the bounds that end them."""
    head = ("low", "high", "stopped below by", "stopped above by")
    named = [("scale of", found.scaled), ("blend of, with", found.blended)]
    tables = [text_table((n, *head), map(_segment_row, _spans(some)), ruled=True) for n, some in named if some]
    facing = f"Facing {found.light}, exposure {found.exposure:g}; no physical cap."
    against = f"Against {found.gamut.name}: inside is {inside_proves(found.gamut)}."
    return "\n\n".join([*tables, sentences([f"{facing} {against}"])])


def _rows(found: Feasible) -> list[tuple[str, ...]]:
    left_out = f"{len(found.untouched_outside) + len(found.unfixable)} of {found.objects}"
    above = ", ".join(found.above_one) or "-"
    if found.none_inside or not found.intervals:
        return [(str(found.parameter), "none", "none", found.verdict, left_out, "-", above)]
    return [
        (str(found.parameter), f"{low:.4g}", f"{high:.4g}", found.verdict, left_out, reason[1].short, above)
        for (low, high), reason in zip(found.intervals, found.reasons, strict=True)
    ]


def _spans(segments: Sequence[Segment]) -> list[tuple[Segment, int | None]]:
    """Pairs of a segment and the number of a part inside; one pair with None if no part is."""
    return [(segment, k) for segment in segments for k in (range(len(segment.inside)) if segment.inside else (None,))]


def _segment_row(part: tuple[Segment, int | None]) -> tuple[str, ...]:
    segment, k = part
    name = ", ".join(segment.names)
    if k is None:
        return name, "none", "none", "-", "-"
    (low, high), (below, above) = segment.inside[k], segment.stops[k]
    return name, f"{low:.4g}", f"{high:.4g}", below or "-", above or "-"


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(_shown(item) for item in value) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
