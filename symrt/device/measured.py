"""Measured prints as a file gives them, and what every format of chart has in common, before step 4 of the paper.

Charts write reflectances as fractions or in percent, and seldom say which: a chart holds its bare paper, so that the
largest number tells.  Device values are fractions, percent, or, for red, green and blue, of 255.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from symrt.errors import shown
from symrt.spectra.bands import Bands

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)
SPECTRAL = re.compile(
    r"(?:SPECTRAL_?|SPEC_?|R_)?(?:NM_?|(PCT_?|DEC_?))?(\d{3,4}(?:\.\d{1,6})?)(?:_?NM)?", re.I | re.ASCII
)
"""Names such as SPECTRAL_NM380, SPEC_380, nm380, 380_NM and 380: a reflectance, and its wavelength."""
INK = re.compile(r"([BCGKLMNORVWYbcgkmorvy]{1,12}|\d{1,2}CLR)_([A-Za-z]|\d{1,2})", re.ASCII)
"""Names such as CMYK_C, CMYKcm_c, RGB_R and 6CLR_1: a device value.  The letters are inks, so that LAB_L is none."""
WORDS = ("cyan", "magenta", "yellow", "black", "orange", "green", "violet", "red", "blue")
NOISE = 0.01
"""Instruments read up to so much below 0 from what is black; such numbers stay as they are."""
MOST = 2.0
"""No reflectance of a print is above this, not even of paper that fluoresces; larger numbers are percent."""
UNITS = {"PCT": "percent", "DEC": "fractions"}
"""The units that the names of some columns tell, in words."""
MOST_PRINTS, MOST_FIELDS = 100_000, 4096
"""Prints that a chart may have, and numbers that each may have; more is no chart, and not read."""
LONGEST_NAME = 64

Row = tuple[int, list[str]]
"""The number of a line, and its fields."""


@dataclass(frozen=True, eq=False)
class Measured:
    """The prints of a chart.

    Parameters
    ----------
    bands
        Wavelengths of the spectra.
    reflectances
        As fractions, one print a row.
    amounts
        Device values as fractions, one print a row; no columns if the chart has none.
    inks
        Names of the device values.
    note
        A sentence on the unit in which the numbers were read.
    lacking
        A remark on device values that one would expect and that are not there, if any.
    """

    bands: Bands
    reflectances: Float[np.ndarray, "print band"]
    amounts: Float[np.ndarray, "print ink"]
    inks: tuple[str, ...]
    note: str
    lacking: str = ""

    def __post_init__(self) -> None:
        for ink in self.inks:
            if not (ink.isprintable() and ink.strip() and len(ink) <= LONGEST_NAME):
                raise ValueError(
                    f"an ink is called {shown(ink)}: give it a name of 1 to {LONGEST_NAME} letters on one line"
                )
            if self.inks.count(ink) > 1:
                raise ValueError(f"two inks are called {shown(ink)}: give each its own name, and one column")


def check_size(prints: int, fields: int) -> None:
    """Refuse what no chart is so large as, before it takes all memory.

    Examples
    --------
    >>> check_size(1, 401)
    >>> check_size(1, 7_000_000)
    Traceback (most recent call last):
    ValueError: 7000000 numbers a print, and a chart has at most 4096: take out what are no measurements of prints
    """
    for count, most, what in ((prints, MOST_PRINTS, "prints"), (fields, MOST_FIELDS, "numbers a print")):
        if count > most:
            raise ValueError(
                f"{count} {what}, and a chart has at most {most}: take out what are no measurements of prints"
            )


def from_rows(fields: Sequence[str], rows: Sequence[Row], declared: Sequence[float] | None = None) -> Measured:
    """The prints of a table whose columns are named.

    Parameters
    ----------
    fields
        Names of the columns.
    rows
        Their numbers, still as text, with the lines that they stand on.
    declared
        Wavelengths that the file's head announces; names of columns carry them rounded.

    Raises
    ------
    ValueError
        Naming the line and the field.

    Examples
    --------
    >>> chart = from_rows(["nm400", "nm500", "CMYK_K"], [(3, ["80", "82", "0"]), (4, ["4", "5", "100"])])
    >>> chart.reflectances.tolist(), chart.amounts.ravel().tolist(), chart.inks
    ([[0.8, 0.82], [0.04, 0.05]], [0.0, 1.0], ('K',))
    """
    # Spectra must be there, by the names of their columns.
    columns = _spectral(fields)
    devices = _device(fields)
    if not columns:
        what = f"only device values ({', '.join(devices)})" if devices else f"fields {', '.join(fields)[:60]}"
        raise ValueError(
            f"no spectra, {what}: a gamut needs reflectances by wavelength; export them too, as SPECTRAL_NM380 …"
        )
    if not rows:
        raise ValueError("no prints: the table has no rows; export the measurements, not only the target")

    # Reflectances at their wavelengths, as fractions.
    nm = _wavelengths(columns, declared)
    values = _numbers(fields, rows, list(columns.values()))
    reflectances, note = fractions(values, [f"line {line}" for line, _ in rows])
    _check_unit([fields[column] for column in columns.values()], values.max())

    # Amounts of the inks, as fractions, and the inks that one would expect beside them.
    amounts, scale = _amounts(devices, _numbers(fields, rows, list(devices.values())))
    inks = tuple(name.rpartition("_")[2] if "_" in name else name.lower() for name in devices)
    kind = next(iter(devices), "").rpartition("_")[0]
    absent = [name for name in kind if name not in inks] if kind in {"CMYK", "RGB"} and len(inks) > 1 else []
    lacking = (
        f", read as {len(inks)} inks: there is no {' nor '.join(f'{kind}_{one}' for one in absent)}" if absent else ""
    )
    return Measured(Bands(tuple(nm)), reflectances, amounts, inks, note + scale, lacking)


def fractions(
    values: Float[np.ndarray, "print band"], where: Sequence[str]
) -> tuple[Float[np.ndarray, "print band"], str]:
    """Reflectances as fractions, and how they were read.

    Examples
    --------
    >>> fractions(np.array([[88.0, 2.0]]), ["line 1"])
    (array([[0.88, 0.02]]), 'Reflectances were read as percent: the largest is 88.')
    """
    percent = values.max() > MOST
    unit = "percent" if percent else "fractions"
    reflectances = values / 100 if percent else values
    wrong = ~((reflectances >= -NOISE) & (reflectances <= MOST))
    if wrong.any():
        row, band = np.argwhere(wrong)[0]
        raise ValueError(
            f"{where[row]}: the reflectance {values[row, band]:g} is not in [0, {100 if percent else 1}]; all are "
            f"{unit}, as the largest, {values.max():g}, tells; correct or drop the print"
        )
    return reflectances, f"Reflectances were read as {unit}: the largest is {values.max():g}."


def conditions(told: Sequence[tuple[str, str]]) -> str:
    """A sentence for the provenance: the making and measuring of prints, as their file tells it.

    Examples
    --------
    >>> conditions([("INSTRUMENTATION", "a spectrophotometer"), ("MEASUREMENT_SOURCE", "M1")])
    " Its head says INSTRUMENTATION 'a spectrophotometer', MEASUREMENT_SOURCE 'M1'."
    >>> conditions([])
    ' Its head does not say how it was measured.'
    """
    said = ", ".join(f"{name} {shown(text)}" for name, text in told if text)
    return f" Its head says {said}." if said else " Its head does not say how it was measured."


def number(text: str, where: str) -> float:
    """A finite number, or an error that says where there is none.

    Examples
    --------
    >>> number("0.25", "line 3, nm400")
    0.25
    >>> number("0,25", "line 3, nm400")
    Traceback (most recent call last):
    ValueError: line 3, nm400: '0,25' is not a number; write it with a decimal point, as in 0.123
    """
    if not NUMBER.fullmatch(text) or not np.isfinite(float(text)):
        raise ValueError(f"{where}: {shown(text)} is not a number; write it with a decimal point, as in 0.123")
    return float(text)


def is_spectral(field: str) -> bool:
    """True if a column's name is that of a reflectance.

    Examples
    --------
    >>> [is_spectral(field) for field in ("SPEC_380", "nm380", "380_NM", "LAB_L")]
    [True, True, True, False]
    """
    return SPECTRAL.fullmatch(field) is not None


def _numbers(fields: Sequence[str], rows: Sequence[Row], columns: Sequence[int]) -> Float[np.ndarray, "print column"]:
    values = [[number(row[c], f"line {line}, {fields[c]}") for c in columns] for line, row in rows]
    return np.array(values, dtype=float).reshape(len(rows), len(columns))


def _spectral(fields: Sequence[str]) -> dict[float, int]:
    """Wavelengths and their columns, in order."""
    columns: dict[float, int] = {}
    for column, field in enumerate(fields):
        if found := SPECTRAL.fullmatch(field):
            nm = float(found[2])
            if nm in columns:
                raise ValueError(f"field {shown(field)}: {nm:g} nm appears twice; keep one measurement a file")
            columns[nm] = column
    return dict(sorted(columns.items()))


def _check_unit(fields: Sequence[str], largest: float) -> None:
    """Refuse numbers that are not what the names of their columns say."""
    unit = UNITS["PCT" if largest > MOST else "DEC"]
    for field in fields:
        found = SPECTRAL.fullmatch(field)
        said = UNITS.get((found[1] or "").strip("_").upper(), unit) if found else unit
        if said != unit:
            raise ValueError(
                f"field {shown(field)}: its name says {said}, but the largest number, {largest:g}, is one of {unit}; "
                "correct the numbers, or name it SPECTRAL_NM"
            )


def _wavelengths(columns: dict[float, int], declared: Sequence[float] | None) -> list[float]:
    """Wavelengths of the columns; as declared, where the names are those rounded."""
    named = list(columns)

    # Names alone tell: no step is left out.
    if declared is None:
        steps = np.diff(named)
        if len(steps) and steps.max() > steps.min() + 1:  # rounded names of even steps differ by up to 1
            before = int(np.argmax(steps))
            raise ValueError(
                f"field {named[before + 1]:g} nm follows {named[before]:g} nm, but the step is {steps.min():g} nm: "
                "bands are missing; export all of them"
            )
        return named

    # The head tells, and each name is near one of its wavelengths.
    wanted = [nm for nm in declared if not any(abs(nm - name) <= 0.51 for name in named)]
    if wanted or len(named) != len(declared):
        which = f"no field for {wanted[0]:g} nm" if wanted else f"{len(named)} fields"
        raise ValueError(
            f"{which}, but the head announces {len(declared)} bands, {declared[0]:g} … {declared[-1]:g} nm: bands are "
            "missing or too many; export the chart again"
        )
    return list(declared)


def _device(fields: Sequence[str]) -> dict[str, int]:
    """Names and columns of the device values; of several sets the first that is not red, green and blue."""
    sets: dict[str, dict[str, int]] = {}
    for column, field in enumerate(fields):
        found = INK.fullmatch(field)

        # The set that a column belongs to, by its name.
        if field.lower() in WORDS:
            kind = "words"
        elif found and (found[2].isdigit() if found[1][-3:] == "CLR" else found[2] in found[1]):
            kind = found[1]
        else:
            continue

        # Each column once.
        if field in sets.setdefault(kind, {}):
            raise ValueError(f"field {shown(field)} appears twice; keep one column an ink")
        sets[kind][field] = column
    return sets[min(sets, key=lambda name: name == "RGB")] if sets else {}


def _amounts(
    devices: dict[str, int], values: Float[np.ndarray, "print column"]
) -> tuple[Float[np.ndarray, "print column"], str]:
    if not devices:
        return values, ""
    largest = values.max()
    full = next((f for f in (1, 100, 255) if largest <= f), 0)
    if values.min() < 0 or not full or (full == 255 and len(devices) != 3):
        wrong = values.min() if values.min() < 0 else largest
        raise ValueError(
            f"device values {', '.join(devices)}: {wrong:g} is not in [0, 1] nor [0, 100]; give fractions or percent"
        )
    return values / full, f" Device values were read as fractions of {full}: the largest is {largest:g}."
