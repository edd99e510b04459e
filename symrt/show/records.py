"""Results as records, ready for JSON (steps 4 and 5 of the paper)."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Int

from symrt.device.printing import Device
from symrt.feedback.joint.adapted import Adapted
from symrt.feedback.joint.boxes import SafeBox
from symrt.feedback.joint.fitted import Fit
from symrt.feedback.joint.pairs import JointRegion
from symrt.feedback.pixelwise import Mapped
from symrt.feedback.reasons import Feasible, Reason
from symrt.feedback.sensitivity import Move
from symrt.gamut.accuracy import basis_report
from symrt.gamut.basis import uniform_first
from symrt.gamut.files import SavedGamut
from symrt.gamut.intersections import AnyIntersection
from symrt.gamut.monitor import MonitorGamut
from symrt.gamut.slabs import Gamut
from symrt.show.segments import Segment, Segments

SHOWN = 8
"""Number of components whose errors are listed; later ones hardly matter on any device seen."""


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
    # Facts of any gamut; intersections and monitors have few others.
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

    # Facts of a printer, and of a gamut that has a shadow and a slice.
    device = gamut.devices[0]
    facts |= _device_facts(device) | _basis_facts(device)
    if isinstance(gamut, Gamut):
        facts |= {
            "largest c0": float(round(gamut.basis.vectors[0] @ gamut.upper, 12)),
            "volume of the shadow in 3 components": float(gamut.shadow(3).polyhedron().volume),
            "volume of the slice in 3 components": float(gamut.slice(3).polyhedron().volume),
        }
    return facts | {"provenance": device.provenance}


def inside_proves(gamut: SavedGamut) -> str:
    """The statement that being inside a gamut proves; bounds in each band are not sufficient."""
    return f"{gamut.label}, not sufficient" if isinstance(gamut, Gamut) else gamut.label


def feasible_record(found: Feasible) -> dict[str, Any]:
    """A feasible range, with its reasons, ready for JSON."""
    return {
        # The range.
        "parameter": str(found.parameter),
        "within": list(found.within),
        "intervals": [list(interval) for interval in found.intervals],
        "reasons": [{"below": _reason(below), "above": _reason(above)} for below, above in found.reasons],
        "moved by 1 % less": [{"below": _moves(below), "above": _moves(above)} for below, above in found.moves],
        # Its verdict, and the pixels that it is about.
        "verdict": found.verdict,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "share darker than black": found.dark,
        "above one": list(found.above_one),
        "note": found.note,
        "seconds": found.seconds,
    }


def fit_record(found: Fit) -> dict[str, Any]:
    """A fit, with its reasons, ready for JSON."""
    return {
        # The scales.
        "objective": found.objective,
        "within": list(found.within),
        "values": dict(found.values),
        "reasons": {name: _reason(reason) for name, reason in found.reasons.items()},
        # The verdict, and the pixels that it is about.
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
    """The steps of an adaptation, and the one accepted, ready for JSON."""
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
        # The box.
        "within": list(found.within),
        "box": {name: list(ends) for name, ends in found.box.items()},
        "reasons": {name: {"below": _reason(a), "above": _reason(b)} for name, (a, b) in found.reasons.items()},
        # The verdict, and the pixels that it is about.
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
    """The result of moving pixels one by one, ready for JSON."""
    return {
        "share moved": found.share,
        "largest move, RMS": float(found.moved.max(initial=0.0)),
        "note": found.note,
        "seconds": found.seconds,
    }


def region_record(found: JointRegion) -> dict[str, Any]:
    """The pairs of two parameters that keep an image inside, line by line, ready for JSON."""
    return {
        # The region as a whole, and beside it the separate ranges and the safe box.
        "parameters": [str(found.one), str(found.other)],
        "within": [list(ends) for ends in found.within],
        "share of all pairs": found.share,
        "error of that share": found.share_error,
        "share of the separate ranges' rectangle": found.separate_inside,
        "error of the rectangle's share": found.separate_error,
        "separate": [[list(interval) for interval in alone.intervals] for alone in found.separate],
        "box": None if found.box is None else {name: list(ends) for name, ends in found.box.box.items()},
        # The feasible intervals of the second parameter at each value of the first.
        "lines": [
            {
                "at": float(value),
                "intervals": [list(interval) for interval in intervals],
                "reasons": [{"below": _reason(below), "above": _reason(above)} for below, above in reasons],
            }
            for value, intervals, reasons in zip(found.values, found.intervals, found.reasons, strict=True)
        ],
        # The verdict, and the pixels that it is about.
        "verdict": found.verdict,
        "object pixels": found.objects,
        "untouched outside": _places(found, found.untouched_outside),
        "unfixable": _places(found, found.unfixable),
        "note": found.note,
        "seconds": found.seconds,
    }


def segments_record(found: Segments) -> dict[str, Any]:
    """Segments, with the parts inside and the bounds that end them, ready for JSON."""
    record: dict[str, Any] = {"gamut": found.gamut.name, "inside proves": inside_proves(found.gamut)}
    record |= {"reference": found.light, "exposure": found.exposure}
    return record | {"scales": _segments(found.scaled), "blends": _segments(found.blended)}


def _device_facts(device: Device) -> dict[str, Any]:
    """Facts of a printer."""
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
    """Facts of a printer's spectral basis, and its errors by the number of components kept."""
    errors = basis_report(device)
    kept = range(min(SHOWN, len(device.bands)))
    return {
        # The constant first component.
        "every entry of the first component": float(uniform_first(device.samples).vectors[0, 0]),
        "rank after the first component": errors.rank,
        "cosine of the free first component with it": errors.cosine,
        # Columns of errors.
        "components k": [k + 1 for k in kept],
        "rms error of k components, constant first": [float(errors.rms[k]) for k in kept],
        "rms error of k components, plain": [float(errors.rms_plain[k]) for k in kept],
        f"mean ΔE2000, {errors.light}, constant first": [float(errors.mean[k]) for k in kept],
        f"mean ΔE2000, {errors.light}, plain": [float(errors.mean_plain[k]) for k in kept],
        f"largest ΔE2000, {errors.light}, constant first": [float(errors.largest[k]) for k in kept],
        f"largest ΔE2000, {errors.light}, plain": [float(errors.largest_plain[k]) for k in kept],
        # Numbers of components that suffice.
        "components for ΔE2000 of 1 at most, constant first": errors.enough()[0],
        "components for ΔE2000 of 1 at most, plain": errors.enough()[1],
    }


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


def _reason(reason: Reason) -> dict[str, Any]:
    keys = ("side", "x", "y", "band", "extrapolated", "symbol")
    return {key: getattr(reason, key) for key in keys} | {"text": str(reason)}


def _moves(found: Sequence[Move]) -> dict[str, float]:
    """Changes of a limit with each other parameter at 0.99, against the same white."""
    return {str(one.parameter): one.change for one in found}


def _places(found: Feasible | Fit | SafeBox | JointRegion, pixels: Int[np.ndarray, " pixel"]) -> list[list[int]]:
    return [[int(n % found.width), int(n // found.width)] for n in pixels]
