"""Spectra and dyes as palette files give them: numbers, names, colours, tables and bells (step 3 of the paper)."""

import math
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
from jaxtyping import Float

from symrt.errors import SceneError, shown, suggestion
from symrt.reading import inside
from symrt.spectra.bands import Bands, resample
from symrt.spectra.fluorescence import Fluorescence, FluorescenceLike, SpectrumLike
from symrt.spectra.library import bell, from_rgb, spectrum
from symrt.symbols import Symbol

SOURCES = ("spectrum", "rgb", "file", "peak")
DYE = ("excitation", "emission", "efficiency", "per_nm")
"""Keys of a fluorescent dye's table; the last two may be left out."""
LARGEST_TABLE = 1 << 20
"""Bytes that a file with one spectrum may have."""


def spectrum_of(symbol: Symbol, value: object, bands: Bands, folder: Path) -> SpectrumLike:
    """The spectrum of a symbol for a palette; everything a file may say is checked here, and only here."""
    # A name, a number, or numbers.
    if isinstance(value, str):
        return spectrum(value, bands, reflectance=symbol.reflectance)
    if is_number(value):
        return float(value)
    if isinstance(value, list):
        return numbers_of(value, len(bands))

    # A table that names one source, and a scale.
    if not isinstance(value, dict):
        raise SceneError('not a spectrum; write a number, a list, a name such as "macbeth/red", or { file = "a.csv" }')
    known = (*SOURCES, "scale", *(["width"] if "peak" in value else []))
    if unknown := sorted(set(value) - set(known)):
        raise SceneError(f"no key {shown(unknown[0])}: {suggestion(unknown[0], known)}")
    if len(set(value) & set(SOURCES)) != 1:
        raise SceneError("give one of spectrum, rgb and file, or a peak, and a scale if you like")
    scale = value.get("scale", 1.0)
    if not is_number(scale) or scale < 0:
        raise SceneError(f"scale = {shown(scale)}: it must be a number, 0 or more")
    return _from_source(symbol, value, bands, folder) * float(scale)


def fluorescence_of(symbol: Symbol, value: object, bands: Bands, folder: Path) -> FluorescenceLike:
    """The dyes of a fluorescent symbol, or its matrix, for a palette."""
    # A matrix, or one dye or several.
    if isinstance(value, dict) and set(value) == {"matrix"}:
        rows = value["matrix"] if isinstance(value["matrix"], list) else []
        return np.array([numbers_of(row if isinstance(row, list) else [], len(bands)) for row in rows])
    dyes: list[Any] = value if isinstance(value, list) else [value]
    if not dyes or not all(isinstance(dye, dict) and {"excitation", "emission"} <= set(dye) for dye in dyes):
        raise SceneError("a fluorescence is { excitation = …, emission = …, efficiency = 0.8 }, or a list of such")
    found = []
    for dye in dyes:
        if unknown := sorted(set(dye) - set(DYE)):
            raise SceneError(f"no key {shown(unknown[0])}: {suggestion(unknown[0], DYE)}")
        if not isinstance(dye.get("per_nm", False), bool):
            raise SceneError(f"per_nm = {shown(dye['per_nm'])}: write true or false")

        # What it takes in is a share as a reflectance is, what it gives back is light.
        excitation = spectrum_of(symbol, dye["excitation"], bands, folder)
        emission = spectrum_of(Symbol.of(symbol.component), dye["emission"], bands, folder)
        found.append(Fluorescence(excitation, emission, dye.get("efficiency", 1.0), dye.get("per_nm", False)))
    return found


def _from_source(symbol: Symbol, value: dict[str, Any], bands: Bands, folder: Path) -> Float[np.ndarray, " band"]:
    # A colour, or a bell.
    if "rgb" in value:
        rgb = numbers_of(value["rgb"] if isinstance(value["rgb"], list) else [], 3)
        return from_rgb(rgb, bands, reflectance=symbol.reflectance)
    if "peak" in value:
        peak, width = value["peak"], value.get("width")
        if not (is_number(peak) and is_number(width)):
            raise SceneError(f"peak = {shown(peak)}, width = {shown(width)}: give both, as numbers in nm")
        return bell(peak, width, bands)

    # A name of the library, or a file's.
    source = value.get("spectrum", value.get("file"))
    if not isinstance(source, str):
        raise SceneError(f"{shown(source)} is not a name: write it in quotes")
    if "spectrum" in value:
        return spectrum(source, bands, reflectance=symbol.reflectance)
    nm, values = _read_table(inside(folder, source), source)
    return resample(nm, values, bands, source)


def _read_table(path: Path, name: str) -> tuple[Float[np.ndarray, " sample"], Float[np.ndarray, " sample"]]:
    """Two columns of numbers, nm and value; a first line of words and lines that begin with # are passed over."""
    # The lines, if the file is of a size that a spectrum may have.
    if path.stat().st_size > LARGEST_TABLE:
        raise SceneError(f"{name} is larger than {LARGEST_TABLE >> 20} MiB: a spectrum is two columns, nm and value")
    try:
        lines = path.read_bytes().decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise SceneError(f"{name}: byte {error.start} is not UTF-8; save the file as UTF-8 text") from None

    # Two numbers a line, but for words at the head and remarks.
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(lines, start=1):
        fields = line.replace(",", " ").replace(";", " ").split()
        if not fields or fields[0].startswith("#"):
            continue
        try:
            nm, value = map(float, fields)
        except ValueError:
            if not rows and not any(map(_reads_as_number, fields)):
                continue
            raise SceneError(f"{name}, line {number}: {shown(line)} is not two numbers, nm and value") from None
        rows.append((nm, value))

    # Enough of them.
    if len(rows) < 2:
        raise SceneError(f"{name} has {len(rows)} samples: a spectrum needs two or more lines of nm and value")
    table = np.array(rows)
    return table[:, 0], table[:, 1]


def numbers_of(values: list[Any], count: int) -> Float[np.ndarray, " number"]:
    """A list of numbers, `count` of them, as an array."""
    if not all(map(is_number, values)):
        wrong = next(v for v in values if not is_number(v))
        raise SceneError(f"{shown(wrong)} is not a number: a list holds one number a band")
    if len(values) != count:
        raise SceneError(f"{len(values)} values where {count} belong: give one a band, or one number for all")
    return np.array(values, dtype=float)


def is_number(value: object) -> TypeGuard[float | int]:
    """Whether a value of a file is a finite number, and neither true nor false."""
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _reads_as_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True
