"""Read CxF3, the Color Exchange Format: XML charts for step 4 of the paper.

Of every ``Object`` the first ``ReflectanceSpectrum`` is read, its first wavelength from the spectrum or, like the step,
from the ``ColorSpecification`` that it names; and its ink percentages, where it has them [1]_.  A file that declares
entities or a document type is refused before it is read: nothing in it can grow or reach out.

References
----------
.. [1] ISO 17972-1:2015, "Graphic technology: Colour data exchange format: Relationship to CxF3 (CxF/X)".
"""

from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

import numpy as np
from jaxtyping import Float

from symrt.device.measured import Measured, check_size, conditions, fractions, number
from symrt.errors import shown
from symrt.spectra.bands import Bands

__all__ = ["read_cxf"]

DEEPEST = 64
"""Elements within elements; the format needs about ten."""
MOST_ELEMENTS = 1_000_000
"""A print needs about twenty, and each takes memory."""
PROCESS = ("Cyan", "Magenta", "Yellow", "Black")


def read_cxf(content: bytes) -> Measured:
    """The prints of a CxF3 file.

    Raises
    ------
    ValueError
        Naming the line or the object, what is wrong with it, and what to do.
    """
    _check_xml(content)
    root = ET.fromstring(content)
    specifications: dict[str | None, ET.Element] = {}
    for one in root.iterfind(".//{*}ColorSpecification"):
        if specifications.setdefault(one.get("Id"), one) is not one:
            raise ValueError(f"two ColorSpecifications are called {shown(one.get('Id') or '')}: correct their Id")
    ranges = {name: one.find(".//{*}WavelengthRange") for name, one in specifications.items()}
    objects = [(o, o.findall("{*}ColorValues/{*}ReflectanceSpectrum")) for o in root.iterfind(".//{*}Object")]
    prints = [(o, spectra[0]) for o, spectra in objects if spectra]
    check_size(len(prints), 0)
    if not prints:
        raise ValueError("no ReflectanceSpectrum in any Object: a gamut needs spectra; export them with the chart")
    spectra = [_spectrum(o, spectrum, ranges.get(spectrum.get("ColorSpecification"))) for o, spectrum in prints]
    bands = spectra[0][0]
    for (o, _), (others, _) in zip(prints, spectra, strict=True):
        if others != bands:
            raise ValueError(f"{_name(o)}: {others!r}, but {bands!r} before it; keep one measurement a file")
    reflectances, note = fractions(np.array([values for _, values in spectra]), [_name(o) for o, _ in prints])
    told = [_conditions(specifications.get(spectrum.get("ColorSpecification"))) for _, spectrum in prints]
    if odd := [o for (o, _), said in zip(prints, told, strict=True) if said != told[0]]:
        raise ValueError(f"{_name(odd[0])}: measured otherwise than the prints before it; keep one measurement a file")
    more = sum(len(spectra) > 1 for _, spectra in objects)
    inks, amounts = _amounts([o for o, _ in prints])
    ignored = f" {len(objects) - len(prints)} objects have no spectrum." if len(objects) > len(prints) else ""
    ignored += f" {more} objects have more than one, of which the first was read." if more else ""
    return Measured(bands, reflectances, amounts, inks, note + ignored + conditions(told[0]))


def _conditions(specification: ET.Element | None) -> list[tuple[str, str]]:
    """What a specification says of how prints were measured, but for wavelengths."""
    measurement = None if specification is None else specification.find("{*}MeasurementSpec")
    if measurement is None:
        return []
    return [(e.tag.rpartition("}")[2], e.text.strip()) for e in measurement.iter() if (e.text or "").strip() and e.text]


def _check_xml(content: bytes) -> None:
    """Read the file once for its form alone: no document type, no entities, not too deep, not too much."""
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

    parser.StartDoctypeDeclHandler, parser.StartElementHandler, parser.EndElementHandler = refuse, enter, leave
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, LookupError) as error:  # a lookup fails for an encoding that nobody knows
        raise ValueError(f"not whole XML ({error}): copy the file again, or export it anew") from None


def _spectrum(
    print_: ET.Element, spectrum: ET.Element, range_: ET.Element | None
) -> tuple[Bands, Float[np.ndarray, " band"]]:
    where = _name(print_)
    texts = (spectrum.text or "").split()
    if not texts or len(spectrum):
        what = "holds other elements beside its numbers" if len(spectrum) else "is empty"
        raise ValueError(f"{where}: its ReflectanceSpectrum {what}; measure the print again or drop it")
    check_size(1, len(texts))
    values = [number(text, f"{where}, ReflectanceSpectrum") for text in texts]
    first = spectrum.get("StartWL") or (range_.get("StartWL") if range_ is not None else None)
    step = spectrum.get("Increment") or (range_.get("Increment") if range_ is not None else None)
    if first is None or (step is None and len(values) > 1):
        raise ValueError(
            f"{where}: no {'StartWL' if first is None else 'Increment'}, so that its wavelengths are unknown; name a "
            "ColorSpecification with a WavelengthRange"
        )
    start, increment = number(first, f"{where}, StartWL"), number(step or "1", f"{where}, Increment")
    try:
        return Bands(tuple(start + increment * i for i in range(len(values)))), np.array(values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None


def _amounts(prints: list[ET.Element]) -> tuple[tuple[str, ...], Float[np.ndarray, "print ink"]]:
    """Names of the inks and their amounts, if every print has them."""
    values = [_inks(print_) for print_ in prints]
    inks = tuple(values[0])
    if not all(tuple(v) == inks for v in values):
        odd = next(o for o, v in zip(prints, values, strict=True) if tuple(v) != inks)
        names = ", ".join(inks) or "none"
        raise ValueError(f"{_name(odd)}: other inks than the prints before it ({names}); give each print the same inks")
    return inks, np.array([list(v.values()) for v in values], dtype=float).reshape(len(prints), len(inks))


def _inks(print_: ET.Element) -> dict[str, float]:
    """Ink by ink, the amount as a fraction; empty if the print has none."""
    for kind in ("ColorCMYKPlusN", "ColorCMYK"):
        found = print_.find(f"{{*}}DeviceColorValues/{{*}}{kind}")
        if found is None:
            continue
        texts = {name: found.findtext(f"{{*}}{name}") or "" for name in PROCESS}
        for spot in found.iterfind("{*}SpotColor"):
            ink = " ".join((spot.findtext("{*}Name") or "").split())
            if ink in texts:
                raise ValueError(f"{_name(print_)}: {shown(ink)} appears twice; keep one amount an ink")
            texts[ink] = spot.findtext("{*}Percentage") or ""
        amounts = {name: number(text, f"{_name(print_)}, {name}") / 100 for name, text in texts.items()}
        if wrong := [name for name, amount in amounts.items() if not 0 <= amount <= 1]:
            raise ValueError(
                f"{_name(print_)}: {wrong[0]} is {texts[wrong[0]]}: inks are percent, 0 to 100; correct the file"
            )
        return amounts
    return {}


def _name(print_: ET.Element) -> str:
    return f"object {shown(print_.get('Name') or print_.get('Id') or '')}"
