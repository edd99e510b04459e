"""Measured charts from files, each a device for step 4 of the paper: CGATS.17, Argyll's ``.ti3``, CxF3, CSV and NumPy.

What a file is, its content tells; nothing in it is evaluated, and no more is read than a chart can need.
"""

import csv
import io
import zipfile
import zlib
from pathlib import Path

import numpy as np

from symrt.device.cgats import decoded, read_cgats
from symrt.device.cxf import read_cxf
from symrt.device.measured import Measured, fractions, from_rows
from symrt.device.printing import Device
from symrt.errors import shown
from symrt.spectra.bands import Bands

__all__ = ["load_chart"]

LARGEST = 32 << 20
"""Bytes that a chart may have, and that an array of it may unpack to: a hundred times the largest charts in use."""

DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, KeyError, OSError, RuntimeError, MemoryError)
"""What reading an archive raises that was cut, changed, encrypted, or packed in a way unknown."""


def load_chart(path: str | Path) -> Device:
    r"""The device that printed a chart.

    A table's columns are known by their names: ``SPECTRAL_NM380``, ``SPEC_380``, ``nm380`` or ``380`` for reflectances,
    ``CMYK_C`` or ``6CLR_1`` for device values.  A ``.csv`` has them in its first line.  A ``.npz`` holds the arrays
    ``wavelengths`` (nm) and ``reflectances`` (print × band), and, if they are known, ``amounts`` (print × ink) and
    ``inks``, their names.

    Raises
    ------
    ValueError
        In one line, with the file, the line or field, the rule and the remedy.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "mine.csv"
    ...     _ = file.write_text("name,CMYK_K,400,500\npaper,0,0.8,0.82\nink,1,0.04,0.05")
    ...     load_chart(file)
    Device('mine.csv', measured, 2 prints in Bands(2 wavelengths, 400 … 500 nm): 2 prints with amounts of K)
    """
    path = Path(path)
    try:
        chart = _read(path)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}; give the path of a chart") from None
    except ValueError as error:
        raise ValueError(f"{path}: {str(error).splitlines()[0]}") from None
    prints = len(chart.reflectances)
    known = f" with amounts of {', '.join(chart.inks)}" if chart.inks else ""
    return Device(
        name=path.name,
        bands=chart.bands,
        samples=chart.reflectances,
        amounts=chart.amounts,
        inks=chart.inks,
        extrapolated=np.zeros(len(chart.bands), dtype=bool),
        title=f"{prints} prints{known}",
        provenance=f"Measured prints, read from {path.name}. {chart.note}",
        modelled=False,
    )


def _read(path: Path) -> Measured:
    if path.is_file() and path.stat().st_size > LARGEST:
        raise ValueError(f"{path.stat().st_size} bytes: a chart has at most {LARGEST >> 20} MiB; give a smaller one")
    content = path.read_bytes()
    if content.startswith(b"PK"):
        return _read_npz(content)
    text = decoded(content)
    if text.lstrip().startswith("<"):
        return read_cxf(content)
    return _read_csv(text) if path.suffix.lower() == ".csv" else read_cgats(text)


def _read_csv(text: str) -> Measured:
    """Fields named in the first line, a print in each line after it."""
    delimiter = ";" if ";" in text.split("\n", 1)[0] else ","
    try:
        rows = [
            (i, [part.strip() for part in row])
            for i, row in enumerate(csv.reader(io.StringIO(text), delimiter=delimiter), 1)
        ]
    except csv.Error as error:
        raise ValueError(f"not a table ({error}): save it as CSV again") from None
    rows = [(line, row) for line, row in rows if any(row) and not row[0].startswith("#")]
    if not rows:
        raise ValueError("no lines: the first names the columns, such as 380, 390 …")
    fields = rows[0][1]
    for line, row in rows[1:]:
        if len(row) != len(fields):
            raise ValueError(f"line {line}: {len(row)} values for {len(fields)} fields; a print has one value a field")
    return from_rows(fields, rows[1:])


def _read_npz(content: bytes) -> Measured:
    arrays = _arrays(content)
    for name in ("wavelengths", "reflectances"):
        if name not in arrays:
            raise ValueError(f"no array {name!r}, only {', '.join(map(shown, arrays)) or 'none'}: save both of them")
    for name in ("wavelengths", "reflectances", "amounts"):
        if name in arrays and not (arrays[name].dtype.kind in "fiu" and np.all(np.isfinite(arrays[name]))):
            raise ValueError(f"array {name!r} does not hold finite numbers: correct it and save it again")
    nm, values = (arrays[name].astype(float) for name in ("wavelengths", "reflectances"))
    if nm.ndim != 1 or values.ndim != 2 or values.shape[1] != len(nm) or not values.size:
        raise ValueError(f"reflectances are {values.shape} for {nm.shape} wavelengths: give one row a print")
    amounts = arrays.get("amounts", np.empty((len(values), 0))).astype(float)
    names = arrays.get("inks", np.array([str(i + 1) for i in range(amounts.shape[-1])], dtype=str))
    if amounts.shape != (len(values), names.size) or names.dtype.kind != "U":
        raise ValueError(
            f"amounts are {amounts.shape} for {len(values)} prints of {names.size} inks: one column an ink"
        )
    if amounts.size and not (amounts.min() >= 0 and amounts.max() <= 1):
        raise ValueError("amounts are not in [0, 1]: divide percent by 100")
    reflectances, note = fractions(values, [f"row {i}" for i in range(len(values))])
    return Measured(Bands(tuple(nm.tolist())), reflectances, amounts, tuple(str(ink) for ink in names.ravel()), note)


def _arrays(content: bytes) -> dict[str, np.ndarray]:
    """The arrays of a ``.npz``; none that holds objects, or unpacks to more than a chart can need."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            large = [info.filename for info in archive.infolist() if info.file_size > LARGEST]
        if large:
            raise ValueError(f"{shown(large[0])} unpacks to more than {LARGEST >> 20} MiB; no chart is so large")
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    except DAMAGE as error:
        raise ValueError(f"not a whole .npz ({str(error)[:80]}): save it again with numpy.savez") from None
