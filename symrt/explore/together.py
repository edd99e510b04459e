"""One box for several scales, as the command line gives it (step 5 of the paper)."""

from collections.abc import Sequence

from symrt.explore.arguments import scale_of
from symrt.explore.tables import box_record
from symrt.explore.writing import json_text
from symrt.feedback import safe_box
from symrt.gamut.slabs import Gamut
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

__all__ = ["box_text"]


def box_text(  # what the command was told
    system: LinearSystem,
    palette: Palette,
    gamut: Gamut,
    words: Sequence[str],
    *,
    within: tuple[float, float] | None,
    reference: Reference,
    cap: bool,
    as_json: bool,
) -> str:
    """The largest box in which the scales that some words name may move freely."""
    scales = [scale_of(word) for word in words]
    found = safe_box(system, palette, gamut, scales, within=within or (0.01, 3.0), reference=reference, cap=cap)
    return json_text(box_record(found)) if as_json else repr(found)
