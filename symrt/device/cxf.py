"""Read CxF3, the Color Exchange Format: XML charts for step 4 of the paper, i1Profiler's ``.mxf`` among them.

Of every ``Object`` the first ``ReflectanceSpectrum`` is read, its first wavelength from the spectrum or, like the step,
from the ``ColorSpecification`` that it names [1]_.  Where prints were measured under several conditions, M0 to M3 [2]_,
one is chosen.  Device values stand in the object itself or in one of its own, a *target*, which has the same place on
the sheet or the same number.  A file that declares entities or a document type is refused before it is read: nothing
in it can grow or reach out.

References
----------
.. [1] ISO 17972-1:2015, "Graphic technology: Colour data exchange format: Relationship to CxF3 (CxF/X)".
.. [2] ISO 13655:2017, "Graphic technology: Spectral measurement and colorimetric computation for graphic arts images".
"""

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple
from xml.etree import ElementTree as ET
from xml.parsers import expat

import numpy as np
from jaxtyping import Float

from symrt.device.measured import Measured, check_size, conditions, fractions, number
from symrt.errors import shown
from symrt.spectra.bands import Bands

DEEPEST = 64
"""Elements within elements; the format needs about ten."""
MOST_ELEMENTS = 1_000_000
"""A print needs about twenty, and each takes memory."""
PROCESS, DRIVES = ("Cyan", "Magenta", "Yellow", "Black"), ("R", "G", "B")
KINDS = ("ColorCMYKPlusN", "ColorCMYK", "ColorRGB")
"""Device values, the first of which counts."""
MODE = re.compile(r"(?<![A-Za-z0-9])M([0-3])(?![0-9])")
"""A condition of measurement in M0_Measurement, M1_Daylight or CS_M2."""
PLACE = ("Page", "Row", "Column")
FIXED = "keep one measurement a file"


class Reading(NamedTuple):
    """A spectrum of a print, as it stands in the file."""

    print_: ET.Element
    spectrum: ET.Element
    specification: ET.Element | None

    @property
    def mode(self) -> str | None:
        """The condition that it was measured under, as far as the file tells it."""
        said = [self.print_.get("ObjectType"), *(text for _, text in _conditions(self.specification))]
        said += [self.spectrum.get("ColorSpecification"), self.spectrum.get("Name")]
        return next((found[0] for text in said if text and (found := MODE.search(text))), None)


def read_cxf(content: bytes, mode: str | None = None) -> Measured:
    """The prints of a CxF3 file.

    Parameters
    ----------
    mode
        ``"M0"`` to ``"M3"``: which measurements are meant, if there are several.

    Raises
    ------
    ValueError
        Naming the line or the object, what is wrong with it, and what to do.
    """
    _check_xml(content)
    root = ET.fromstring(content)

    # Find every spectrum, with how it was measured, and keep those of one condition, the first of each object.
    specifications: dict[str | None, ET.Element] = {}
    for one in root.iterfind(".//{*}ColorSpecification"):
        if specifications.setdefault(one.get("Id"), one) is not one:
            raise ValueError(f"two ColorSpecifications are called {shown(one.get('Id') or '')}: correct their Id")
    objects = list(root.iterfind(".//{*}Object"))
    readings = [
        Reading(one, spectrum, specifications.get(spectrum.get("ColorSpecification")))
        for one in objects
        for spectrum in one.iterfind("{*}ColorValues/{*}ReflectanceSpectrum")
    ]
    if not readings:
        raise ValueError("no ReflectanceSpectrum in any Object: a gamut needs spectra; export them with the chart")
    kept, of_mode = _of_one_mode(readings, mode)
    prints = list({id(reading.print_): reading for reading in reversed(kept)}.values())[::-1]
    check_size(len(prints), 0)

    # Read them, all on the same bands and measured alike.
    spectra = [_spectrum(reading) for reading in prints]
    bands = spectra[0][0]
    for reading, (others, _) in zip(prints, spectra, strict=True):
        if others != bands:
            raise ValueError(f"{_name(reading.print_)}: {others!r}, but {bands!r} before it; {FIXED}")
    reflectances, note = fractions(np.array([values for _, values in spectra]), [_name(r.print_) for r in prints])
    told = [_conditions(reading.specification) for reading in prints]
    if odd := [r for r, said in zip(prints, told, strict=True) if said != told[0]]:
        raise ValueError(f"{_name(odd[0].print_)}: measured otherwise than the prints before it; {FIXED}")

    # Device values, and what was not read.
    measured = {id(reading.print_) for reading in readings}
    targets, joined = _targets([r.print_ for r in prints], [one for one in objects if id(one) not in measured])
    inks, amounts = _amounts(targets)
    without = len(objects) - len(measured) - (len({*map(id, targets)} - measured))
    more = len(kept) - len(prints)
    note += of_mode + joined + (f" {without} objects have no spectrum." if without else "")
    note += f" {more} objects have more than one, of which the first was read." if more else ""
    return Measured(bands, reflectances, amounts, inks, note + conditions(told[0]))


def _of_one_mode(readings: list[Reading], mode: str | None) -> tuple[list[Reading], str]:
    """The readings under one condition, and a sentence if there are others."""
    # The conditions that the file names.
    modes = [reading.mode for reading in readings]
    names = sorted({name for name in modes if name})
    there = " and ".join([*names, *(["some that do not say"] if None in modes else [])]) or "none that says so"

    # One that was asked for must be there, and one of several must be asked for.
    if mode is not None and mode not in names:
        raise ValueError(f"mode = {shown(mode)}: the file has measurements under {there}; choose one of these, or none")
    if mode is None and len(names) > 1:
        odd = next(one for one, name in zip(readings, modes, strict=True) if name != modes[0])
        raise ValueError(
            f"{_name(odd.print_)}: measured otherwise than the prints before it; the file has measurements under "
            f"{there}: choose one with the mode, such as {names[0]}"
        )

    # The readings under it.
    if mode is None or names == [mode] == sorted({*map(str, modes)}):
        return readings, ""
    kept = [reading for reading, name in zip(readings, modes, strict=True) if name == mode]
    return kept, f" Of measurements under {there} those under {mode} were read."


def _targets(prints: list[ET.Element], others: list[ET.Element]) -> tuple[list[ET.Element], str]:
    """The objects that hold the prints' device values: themselves, or a target each; and a sentence about them."""
    # Targets are needed where the prints have no device values themselves.
    targets = [one for one in others if _values(one) is not None]
    if not targets or any(_values(one) is not None for one in prints):
        return prints, ""

    # Join them by the first key that finds one target for each print.
    ways: dict[str, Callable[[ET.Element], str]] = {"page, row and column": _place, "number": _number}
    for way, key in ways.items():
        found: Mapping[str, ET.Element] = {key(one): one for one in targets}
        wanted = [key(one) for one in prints]
        if len(found) == len(targets) and len({*wanted}) == len(wanted) and all(k and k in found for k in wanted):
            return [found[k] for k in wanted], f" Device values were joined from {len(wanted)} targets by {way}."
    return prints, (
        f" {len(targets)} targets hold device values, and neither page, row and column nor a number joins one to each "
        "print: amounts are not known."
    )


def _place(one: ET.Element) -> str:
    tags = {tag.get("Name"): tag.get("Value") or "" for tag in one.iterfind("{*}TagCollection/{*}Tag")}
    return " ".join(tags.get(name) or "0" for name in PLACE) if any(name in tags for name in PLACE) else ""


def _number(one: ET.Element) -> str:
    """The number that an object's name ends with, as in Target12 and M0_Measurement12."""
    found = re.search(r"[0-9]{1,9}$", one.get("Name") or "")
    return str(int(found[0])) if found else ""


def _conditions(specification: ET.Element | None) -> list[tuple[str, str]]:
    """Keywords and texts of how prints were measured, as a specification tells them, but for wavelengths."""
    measurement = None if specification is None else specification.find("{*}MeasurementSpec")
    if measurement is None:
        return []
    return [(e.tag.rpartition("}")[2], e.text.strip()) for e in measurement.iter() if (e.text or "").strip() and e.text]


def _check_xml(content: bytes) -> None:
    """Read the file once for its form alone: no document type, no entities, not too deep, not too much."""
    # A parser that counts elements and their depth, and keeps nothing.
    depth = elements = 0
    parser = expat.ParserCreate(namespace_separator="}")  # as ElementTree has it

    def refuse(*_: Any) -> None:
        raise ValueError(
            f"line {parser.CurrentLineNumber}: a document type (<!DOCTYPE …>); a chart needs none: take it out"
        )

    def enter(*_: Any) -> None:
        nonlocal depth, elements
        depth, elements = depth + 1, elements + 1
        if elements > MOST_ELEMENTS:
            raise ValueError(f"more than {MOST_ELEMENTS} elements: a chart has fewer; take out what are no prints")
        if depth > DEEPEST:
            raise ValueError(f"line {parser.CurrentLineNumber}: elements nested {depth} deep; this is no CxF3 file")

    def leave(_: str) -> None:
        nonlocal depth
        depth -= 1

    # Run it over the whole file.
    parser.StartDoctypeDeclHandler, parser.StartElementHandler, parser.EndElementHandler = refuse, enter, leave
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, LookupError) as error:  # a lookup fails for an encoding that nobody knows
        raise ValueError(f"not whole XML ({error}): copy the file again, or export it anew") from None


def _spectrum(reading: Reading) -> tuple[Bands, Float[np.ndarray, " band"]]:
    where, spectrum = _name(reading.print_), reading.spectrum
    range_ = None if reading.specification is None else reading.specification.find(".//{*}WavelengthRange")

    # The numbers of the spectrum.
    texts = (spectrum.text or "").split()
    if not texts or len(spectrum):
        what = "holds other elements beside its numbers" if len(spectrum) else "is empty"
        raise ValueError(f"{where}: its ReflectanceSpectrum {what}; measure the print again or drop it")
    check_size(1, len(texts))
    values = [number(text, f"{where}, ReflectanceSpectrum") for text in texts]

    # The wavelengths they begin with and step by: its own, or those of its specification.
    first = spectrum.get("StartWL") or (range_.get("StartWL") if range_ is not None else None)
    step = spectrum.get("Increment") or (range_.get("Increment") if range_ is not None else None)
    if first is None or (step is None and len(values) > 1):
        raise ValueError(
            f"{where}: no {'StartWL' if first is None else 'Increment'}, so that its wavelengths are unknown; name a "
            "ColorSpecification with a WavelengthRange"
        )

    # Bands and values.
    start, increment = number(first, f"{where}, StartWL"), number(step or "1", f"{where}, Increment")
    try:
        return Bands(tuple(start + increment * i for i in range(len(values)))), np.array(values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _amounts(prints: Sequence[ET.Element]) -> tuple[tuple[str, ...], Float[np.ndarray, "print ink"]]:
    """Names of the inks and their amounts, if every print has them."""
    values = [_inks(print_) for print_ in prints]
    inks = tuple(values[0])
    if not all(tuple(v) == inks for v in values):
        odd = next(o for o, v in zip(prints, values, strict=True) if tuple(v) != inks)
        names = ", ".join(inks) or "none"
        raise ValueError(f"{_name(odd)}: other inks than the prints before it ({names}); give each print the same inks")
    return inks, np.array([list(v.values()) for v in values], dtype=float).reshape(len(prints), len(inks))


def _values(one: ET.Element) -> ET.Element | None:
    """Its device values, if it has some."""
    found = (one.find(f"{{*}}DeviceColorValues/{{*}}{kind}") for kind in KINDS)
    return next((values for values in found if values is not None), None)


def _inks(print_: ET.Element) -> dict[str, float]:
    """Ink by ink, the amount as a fraction; empty if the print has none."""
    found = _values(print_)
    if found is None:
        return {}

    # Full red, green and blue have a number of their own; inks are percent.
    where, driven = _name(print_), found.tag.endswith("ColorRGB")
    full = number(found.findtext("{*}MaxRange") or "255", f"{where}, MaxRange") if driven else 100.0

    # The amounts as text: those of the process, then spot colours by name.
    texts = {name: found.findtext(f"{{*}}{name}") or "" for name in (DRIVES if driven else PROCESS)}
    for spot in found.iterfind("{*}SpotColor"):
        ink = " ".join((spot.findtext("{*}Name") or "").split())
        if ink in texts:
            raise ValueError(f"{where}: {shown(ink)} appears twice; keep one amount an ink")
        texts[ink] = spot.findtext("{*}Percentage") or ""

    # As numbers, in range.
    amounts = {name: number(text, f"{where}, {name}") for name, text in texts.items()}
    if not full > 0:
        raise ValueError(f"{where}: MaxRange is {full:g}: it is what full red, green or blue is written as; correct it")
    if wrong := [name for name, amount in amounts.items() if not 0 <= amount <= full]:
        what = f"red, green and blue are 0 to {full:g}" if driven else "inks are percent, 0 to 100"
        raise ValueError(f"{where}: {wrong[0]} is {texts[wrong[0]]}: {what}; correct the file")
    return {name: amount / full for name, amount in amounts.items()}


def _name(print_: ET.Element) -> str:
    return f"object {shown(print_.get('Name') or print_.get('Id') or '')}"
