"""Answers as records for a program and as tables for a reader (steps 4 and 5 of the paper)."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int

from symrt.device.printing import Device
from symrt.feedback.joint.adapted import Adapted
from symrt.feedback.joint.boxes import SafeBox
from symrt.feedback.joint.fitted import Fit
from symrt.feedback.joint.pairs import JointRegion
from symrt.feedback.pixelwise import Mapped
from symrt.feedback.reasons import Feasible, Reason, footnote
from symrt.feedback.sensitivity import Move
from symrt.gamut.accuracy import basis_report
from symrt.gamut.basis import uniform_first
from symrt.gamut.files import SavedGamut
from symrt.gamut.intersections import AnyIntersection
from symrt.gamut.monitor import MonitorGamut
from symrt.gamut.slabs import Gamut
from symrt.show.segments import Segment, Segments
from symrt.table import WIDTH, sentences, text_table

LIGHT = re.compile(r", (illuminant/[^,]+)")
"""The light in the name of a fact on colours."""
SHOWN = 8
"""Components whose errors are listed; later ones hardly matter on any device seen."""


def gamut_facts(gamut: SavedGamut) -> dict[str, Any]:
    """Facts of a gamut, of its device and of the basis, ready for JSON.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> facts = gamut_facts(device_gamut(load_device("dye3-endura-premier"), "envelope"))
    >>> facts["bands"], facts["largest c0"], facts["modelled"]
    (36, 5.4, True)
    """
    facts: dict[str, Any] = {
        "gamut": gamut.name,
        "inside proves": inside_proves(gamut),
        "bands": len(gamut.bands),
        "first band": gamut.bands.labels[0],
        "last band": gamut.bands.labels[-1],
    }
    if isinstance(gamut, AnyIntersection):
        return facts | {"parts": [part.name for part in gamut.parts], "devices": [d.title for d in gamut.devices]}
    if isinstance(gamut, MonitorGamut):
        return facts | {"device": gamut.monitor.title, "provenance": gamut.monitor.provenance}
    device = gamut.devices[0]
    facts |= _device_facts(device) | _basis_facts(device)
    if isinstance(gamut, Gamut):
        facts |= {
            "largest c0": float(round(gamut.basis.vectors[0] @ gamut.upper, 12)),
            "volume of the shadow in 3 components": float(gamut.shadow(3).polyhedron().volume),
            "volume of the slice in 3 components": float(gamut.slice(3).polyhedron().volume),
        }
    return facts | {"provenance": device.provenance}


def gamut_table(facts: dict[str, Any]) -> str:
    """The same facts as text: what takes sentences, short ones one a line, lists of numbers side by side, the source.

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
    columns = {name: value for name, value in facts.items() if _is_column(value)}
    texts = {name: _shown(value) for name, value in facts.items() if name not in columns}
    longest = max(map(len, texts))
    long = [name for name, text in texts.items() if longest + 2 + len(text) > WIDTH]
    width = max((len(name) for name in texts if name not in long), default=0)
    lines = "\n".join(f"{name:<{width}}  {text}".rstrip() for name, text in texts.items() if name not in long)
    # What all heads have in common stands above them.
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


def _device_facts(device: Device) -> dict[str, Any]:
    outside = [label for label, guessed in zip(device.bands.labels, device.extrapolated, strict=True) if guessed]
    return {
        "device": device.title,
        "modelled": device.modelled,
        "prints": len(device.samples),
        "extrapolated bands": outside,
        "reflectance of black": float(device.black.min()),
        "reflectance of white": float(device.white.max()),
    }


def _basis_facts(device: Device) -> dict[str, Any]:
    errors = basis_report(device)
    kept = range(min(SHOWN, len(device.bands)))
    return {
        "every entry of the first component": float(uniform_first(device.samples).vectors[0, 0]),
        "rank after the first component": errors.rank,
        "cosine of the free first component with it": errors.cosine,
        "components k": [k + 1 for k in kept],
        "rms error of k components, constant first": [float(errors.rms[k]) for k in kept],
        "rms error of k components, plain": [float(errors.rms_plain[k]) for k in kept],
        f"mean ΔE2000, {errors.light}, constant first": [float(errors.mean[k]) for k in kept],
        f"mean ΔE2000, {errors.light}, plain": [float(errors.mean_plain[k]) for k in kept],
        f"largest ΔE2000, {errors.light}, constant first": [float(errors.largest[k]) for k in kept],
        f"largest ΔE2000, {errors.light}, plain": [float(errors.largest_plain[k]) for k in kept],
        "components for ΔE2000 of 1 at most, constant first": errors.enough()[0],
        "components for ΔE2000 of 1 at most, plain": errors.enough()[1],
    }


def feasible_record(found: Feasible) -> dict[str, Any]:
    """A feasible range, with its reasons, ready for JSON."""
    return {
        "parameter": str(found.parameter),
        "within": list(found.within),
        "intervals": [list(interval) for interval in found.intervals],
        "reasons": [{"below": _reason(below), "above": _reason(above)} for below, above in found.reasons],
        "moved by 1 % less": [{"below": _moves(below), "above": _moves(above)} for below, above in found.moves],
        "verdict": found.verdict,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "share darker than black": found.dark,
        "above one": list(found.above_one),
        "note": found.note,
        "seconds": found.seconds,
    }


def ranges_table(ranges: Sequence[Feasible]) -> str:
    """Feasible ranges one below the other, each with its verdict and what stops it."""
    head = ["parameter", "low", "high", "verdict", "outside", "stopped above by", "reflects above 1"]
    rows = [row for found in ranges for row in _rows(found)]
    if all(row[-1] == "-" for row in rows):
        head, rows = head[:-1], [row[:-1] for row in rows]
    reasons = [above for found in ranges for _, above in found.reasons]
    return "\n".join([text_table(head, rows, ruled=True), *footnote(reasons)])


def ranges_text(ranges: Sequence[Feasible]) -> str:
    """Feasible ranges as a table and in words; what all were asked against stands once."""
    alike = len({found.note for found in ranges}) == 1
    parts = [found.words if alike else repr(found) for found in ranges]
    return "\n\n".join([ranges_table(ranges), *parts, *([sentences([f"Against {ranges[0].note}."])] if alike else [])])


def fits_table(fits: Mapping[str, Fit]) -> str:
    """The scales that each fit chose, side by side, with what stopped them in the last."""
    last = list(fits.values())[-1]
    head = ("scale of", *fits, f"stopped in the {last.objective}")
    body = [(n, *(f"{f.values[n]:.4g}" for f in fits.values()), last.reasons[n].short) for n in last.values]
    return "\n".join([text_table(head, body, ruled=True), *footnote(last.reasons.values())])


def fit_record(found: Fit) -> dict[str, Any]:
    """A fit, with its reasons, ready for JSON."""
    return {
        "objective": found.objective,
        "within": list(found.within),
        "values": dict(found.values),
        "reasons": {name: _reason(reason) for name, reason in found.reasons.items()},
        "verdict": found.verdict,
        "optimum": found.optimum,
        "mean luminance kept": found.luminance,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "left out": _places(found, found.left_out),
        "share outside": found.share_out,
        "share darker than black": found.dark,
        "above one": list(found.above_one),
        "note": found.note,
        "seconds": found.seconds,
    }


def adapted_record(found: Adapted) -> dict[str, Any]:
    """The steps of an adaptation, and what was accepted, ready for JSON."""
    keys = ("means", "inside", "difference", "lightness", "luminance", "binds", "exposure", "left_out", "seconds")
    steps = [{key: getattr(step, key) for key in keys} for step in found.steps]
    lacking = [sorted(found.criteria.lacking(step)) for step in found.steps]
    return {
        "criteria": str(found.criteria),
        "verdict": found.verdict,
        "accepted": found.accepted.means if found.accepted else None,
        "steps": [step | {"lacking": names} for step, names in zip(steps, lacking, strict=True)],
        "reachable": dict(found.reachable),
        "note": found.note,
        "seconds": found.seconds,
    }


def box_record(found: SafeBox) -> dict[str, Any]:
    """A safe box, with its reasons, ready for JSON."""
    return {
        "within": list(found.within),
        "box": {name: list(ends) for name, ends in found.box.items()},
        "reasons": {name: {"below": _reason(a), "above": _reason(b)} for name, (a, b) in found.reasons.items()},
        "verdict": found.verdict,
        "optimum": found.optimum,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "share darker than black at the bottom": found.dark,
        "above one at the top": list(found.above_one),
        "note": found.note,
        "seconds": found.seconds,
    }


def mapped_record(found: Mapped) -> dict[str, Any]:
    """What moving pixels one by one did, ready for JSON."""
    return {
        "share moved": found.share,
        "largest move, RMS": float(found.moved.max(initial=0.0)),
        "note": found.note,
        "seconds": found.seconds,
    }


def region_record(found: JointRegion) -> dict[str, Any]:
    """The pairs of two parameters that keep an image inside, line by line, ready for JSON."""
    return {
        "parameters": [str(found.one), str(found.other)],
        "within": [list(ends) for ends in found.within],
        "share of all pairs": found.share,
        "error of that share": found.share_error,
        "share of the separate ranges' rectangle": found.separate_inside,
        "error of the rectangle's share": found.separate_error,
        "separate": [[list(interval) for interval in alone.intervals] for alone in found.separate],
        "box": None if found.box is None else {name: list(ends) for name, ends in found.box.box.items()},
        "lines": [
            {
                "at": float(value),
                "intervals": [list(interval) for interval in intervals],
                "reasons": [{"below": _reason(below), "above": _reason(above)} for below, above in reasons],
            }
            for value, intervals, reasons in zip(found.values, found.intervals, found.reasons, strict=True)
        ],
        "verdict": found.verdict,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "note": found.note,
        "seconds": found.seconds,
    }


def segments_table(found: Segments) -> str:
    """The part of each material's segment that a gamut holds, and of each blend's, with what ends it."""
    head = ("low", "high", "stopped below by", "stopped above by")
    named = [("scale of", found.scaled), ("blend of, with", found.blended)]
    tables = [text_table((n, *head), map(_segment_row, _spans(some)), ruled=True) for n, some in named if some]
    facing = f"Facing {found.light}, exposure {found.exposure:g}; no physical cap."
    against = f"Against {found.gamut.name}: inside is {inside_proves(found.gamut)}."
    return "\n\n".join([*tables, sentences([f"{facing} {against}"])])


def segments_record(found: Segments) -> dict[str, Any]:
    """Segments, with the parts inside and what ends them, ready for JSON."""
    record: dict[str, Any] = {"gamut": found.gamut.name, "inside proves": inside_proves(found.gamut)}
    record |= {"reference": found.light, "exposure": found.exposure}
    return record | {"scales": _segments(found.scaled), "blends": _segments(found.blended)}


def inside_proves(gamut: SavedGamut) -> str:
    """What being inside a gamut proves, and for bounds in each band what it does not."""
    return f"{gamut.label}, not sufficient" if isinstance(gamut, Gamut) else gamut.label


def _rows(found: Feasible) -> list[tuple[str, ...]]:
    left_out = f"{len(found.untouched_outside) + len(found.unfixable)} of {found.objects}"
    above = ", ".join(found.above_one) or "-"
    if found.none_inside or not found.intervals:
        return [(str(found.parameter), "none", "none", found.verdict, left_out, "-", above)]
    return [
        (str(found.parameter), f"{low:.4g}", f"{high:.4g}", found.verdict, left_out, reason[1].short, above)
        for (low, high), reason in zip(found.intervals, found.reasons, strict=True)
    ]


def _segments(segments: Sequence[Segment]) -> list[dict[str, Any]]:
    return [
        {
            "materials": list(segment.names),
            "within": list(segment.within),
            "inside": [list(span) for span in segment.inside],
            "stops": [{"below": below, "above": above} for below, above in segment.stops],
        }
        for segment in segments
    ]


def _spans(segments: Sequence[Segment]) -> list[tuple[Segment, int | None]]:
    """Each segment with the number of each of its parts inside; with None if it has none."""
    return [(segment, k) for segment in segments for k in (range(len(segment.inside)) if segment.inside else (None,))]


def _segment_row(part: tuple[Segment, int | None]) -> tuple[str, ...]:
    segment, k = part
    name = ", ".join(segment.names)
    if k is None:
        return name, "none", "none", "-", "-"
    (low, high), (below, above) = segment.inside[k], segment.stops[k]
    return name, f"{low:.4g}", f"{high:.4g}", below or "-", above or "-"


def _reason(reason: Reason) -> dict[str, Any]:
    keys = ("side", "x", "y", "band", "extrapolated", "symbol")
    return {key: getattr(reason, key) for key in keys} | {"text": str(reason)}


def _moves(found: Sequence[Move]) -> dict[str, float]:
    """Change of a limit with each other parameter at 0.99, against the same white."""
    return {str(one.parameter): one.change for one in found}


def _places(found: Feasible | Fit | SafeBox | JointRegion, pixels: Int[np.ndarray, " pixel"]) -> list[list[int]]:
    return [[int(n % found.width), int(n // found.width)] for n in pixels]


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(_shown(item) for item in value) or "none"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
