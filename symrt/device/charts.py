"""Measured charts from files, each a device for step 4 of the paper: CGATS.17, Argyll's ``.ti3``, CxF3, CSV and NumPy.

What a file is, its content tells; nothing in it is evaluated, and no more is read than a chart can need.
"""

import csv
import io
import zipfile
from pathlib import Path

import numpy as np
from jaxtyping import Float

from symrt.archives import DAMAGE, check_members
from symrt.device.cgats import decoded, read_cgats
from symrt.device.cxf import read_cxf
from symrt.device.measured import Measured, Row, check_size, fractions, from_rows
from symrt.device.printing import Device
from symrt.disk import ordinary
from symrt.errors import plain, shown
from symrt.spectra.bands import Bands

LARGEST = 32 << 20
"""Bytes that a chart may have, and that its arrays may unpack to: a hundred times the largest charts in use."""
NEEDED, OPTIONAL = ("wavelengths", "reflectances"), ("amounts", "inks")
"""Arrays of a ``.npz``."""


def load_chart(path: str | Path, mode: str | None = None) -> Device:
    r"""The device that printed a chart.

    A table's columns are known by their names: ``SPECTRAL_NM380``, ``SPEC_380``, ``nm380`` or ``380`` for reflectances,
    ``CMYK_C`` or ``6CLR_1`` for device values.  A ``.csv`` has them in its first line.  A ``.npz`` holds the arrays
    ``wavelengths`` (nm) and ``reflectances`` (print × band), and, if they are known, ``amounts`` (print × ink) and
    ``inks``, their names.

    Parameters
    ----------
    mode
        Of CxF3 with prints measured under several conditions, ``"M0"`` to ``"M3"``: the one that is meant.

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
    # Read the file; whatever is wrong with it is said with its name.
    path = Path(path)
    if "\0" in str(path):
        raise ValueError(f"{shown(str(path))} is not a file name: give the path of a chart")
    try:
        chart = _read(path, mode)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}; give the path of a chart") from None
    except ValueError as error:
        raise ValueError(f"{path}: {str(error).splitlines()[0]}") from None

    # The prints as a device, and what is known of them in words.
    prints = len(chart.reflectances)
    known = f" with amounts of {', '.join(chart.inks)}{plain(chart.lacking)}" if chart.inks else ""
    return Device(
        name=plain(path.name),
        bands=chart.bands,
        samples=chart.reflectances,
        amounts=chart.amounts,
        inks=chart.inks,
        extrapolated=np.zeros(len(chart.bands), dtype=bool),
        title=f"{prints} prints{known}",
        provenance=f"Measured prints, read from {plain(path.name)}. {plain(chart.note)}",
        modelled=False,
    )


def _read(path: Path, mode: str | None) -> Measured:
    with ordinary(path).open("rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"it is too large: a chart has at most {LARGEST >> 20} MiB; give a smaller one")
    text = decoded(content)
    if text.lstrip().startswith("<"):
        return read_cxf(content, mode)
    if mode is not None:
        raise ValueError(f"mode = {shown(mode)}: only CxF3 keeps measurements under several conditions; leave it out")
    if content.startswith(b"PK"):
        return _read_npz(content)
    return _read_csv(text) if path.suffix.lower() == ".csv" else read_cgats(text)


def _read_csv(text: str) -> Measured:
    """Fields named in the first line, a print in each line after it."""
    # The rows, with the lines that they stand on; the first line tells what divides them.
    lines = io.StringIO(text, newline=None)
    delimiter = max(",;\t", key=lines.readline().count)
    lines.seek(0)
    rows: list[Row] = []
    try:
        for line, row in enumerate(csv.reader(lines, delimiter=delimiter), 1):
            if any(row) and not row[0].startswith("#"):
                rows.append((line, [part.strip() for part in row]))
                check_size(len(rows), len(row))
    except csv.Error as error:
        raise ValueError(f"not a table ({error}): save it as CSV again") from None

    # The first names the columns.
    if not rows:
        raise ValueError("no lines: the first names the columns, such as 380, 390 …")
    fields = rows[0][1]
    for line, row in rows[1:]:
        if len(row) != len(fields):
            raise ValueError(f"line {line}: {len(row)} values for {len(fields)} fields; a print has one value a field")
    return from_rows(fields, rows[1:])


def _read_npz(content: bytes) -> Measured:
    # Spectra, one row a print.
    arrays = _arrays(content)
    given = {name: _numbers(name, array) for name, array in arrays.items() if name != "inks"}
    nm, values = (given[name] for name in NEEDED)
    if nm.ndim != 1 or values.ndim != 2 or values.shape[1] != len(nm) or not values.size:
        raise ValueError(f"reflectances are {values.shape} for {nm.shape} wavelengths: give one row a print")
    check_size(*values.shape)

    # Amounts of inks and their names, if there are any.
    amounts = given.get("amounts", np.empty((len(values), 0)))
    names = arrays.get("inks", np.array([str(i + 1) for i in range(amounts.size // len(values))], dtype=str))
    if amounts.shape != (len(values), names.size) or names.dtype.kind != "U":
        raise ValueError(
            f"amounts are {amounts.shape} for {len(values)} prints of {names.size} inks: one column an ink"
        )
    if amounts.size and not (amounts.min() >= 0 and amounts.max() <= 1):
        raise ValueError("amounts are not in [0, 1]: divide percent by 100")

    # As fractions.
    reflectances, note = fractions(values, [f"row {i}" for i in range(len(values))])
    return Measured(Bands(tuple(nm.tolist())), reflectances, amounts, tuple(str(ink) for ink in names.ravel()), note)


def _numbers(name: str, array: np.ndarray) -> Float[np.ndarray, "..."]:
    # A number beyond the range of a float64 becomes infinite, and is refused as such.
    with np.errstate(over="ignore"):
        numbers = array.astype(float) if array.dtype.kind in "fiu" else np.full(1, np.nan)
    if not np.all(np.isfinite(numbers)):
        raise ValueError(f"array {name!r} does not hold finite numbers: correct it and save it again")
    return numbers


def _arrays(content: bytes) -> dict[str, np.ndarray]:
    """The arrays of a ``.npz`` that are a chart's; none that holds objects, or unpacks to more than one can need."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            check_members(archive, LARGEST)
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            found, arrays = file.files, {name: file[name] for name in (*NEEDED, *OPTIONAL) if name in file.files}
    except DAMAGE as error:
        reason = " ".join(str(error).split())[:120]
        raise ValueError(f"not a whole .npz ({reason}): save it again with numpy.savez") from None
    for name in NEEDED:
        if name not in arrays:
            raise ValueError(f"no array {name!r}, only {', '.join(map(shown, found[:9])) or 'none'}: save both of them")
    return arrays
