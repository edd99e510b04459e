"""Read CGATS.17 text, and Argyll's ``.ti3``, which is the same with other first words: charts for step 4 of the paper.

A head of keywords, the names of the fields between BEGIN_DATA_FORMAT and END_DATA_FORMAT, and the prints between
BEGIN_DATA and END_DATA, a line each.  Fields are separated by tabs or spaces, and may be quoted [1]_, [2]_.  Some
programs leave the keywords out, as for the charts of IFRA: then the first line that names spectra names the fields,
and the prints follow it, up to a line that is empty.

References
----------
.. [1] ISO 28178:2009, "Graphic technology: Exchange format for colour and process control data using XML
   or ASCII text".
.. [2] G. W. Gill, "Argyll .ti3 file format", Argyll CMS documentation.
"""

import re
from dataclasses import dataclass, field, replace

import numpy as np

from symrt.device.measured import UNITS, Measured, Row, check_size, conditions, from_rows, is_spectral, number
from symrt.errors import shown

TOKEN = re.compile(r'"((?:[^"]|"")*)"|(#.*)|([^\s"#]\S*)|(")')
"""A quoted field, a comment, a plain field, or a quote that nothing closes."""
LINES = re.compile(r"\r\n|\r|\n")
"""Ends of lines; other controls, such as 0x85, the … of Windows, are letters of comments."""
CONDITIONS = (
    *("DESCRIPTOR", "ORIGINATOR", "MANUFACTURER", "CREATED", "PRINT_CONDITIONS", "MATERIAL"),
    *("INSTRUMENTATION", "TARGET_INSTRUMENT", "MEASUREMENT_SOURCE", "MEASUREMENT_GEOMETRY", "FILTER", "POLARIZATION"),
    "SAMPLE_BACKING",
)
"""Keywords of the head that say how prints were made and measured."""


@dataclass(frozen=True)
class Table:
    """One table of a file, as far as it has been read."""

    head: dict[str, tuple[int, str]] = field(default_factory=dict)
    fields: list[str] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)


def read_cgats(text: str) -> Measured:
    r"""The prints of the one table of a file that has spectra.

    Raises
    ------
    ValueError
        Naming the line or field, what is wrong with it, and what to do.

    Examples
    --------
    >>> chart = read_cgats('''CTI3
    ... BEGIN_DATA_FORMAT
    ... SAMPLE_ID CMYK_K SPEC_400 SPEC_500
    ... END_DATA_FORMAT
    ... BEGIN_DATA
    ... "paper" 0 80 82
    ... END_DATA''')
    >>> chart.bands.labels, chart.reflectances.tolist()
    (('400 nm', '500 nm'), [[0.8, 0.82]])
    """
    # The tables, as text.
    lines = LINES.split(text)
    tables = _tables(lines) or _bare_table(lines)
    if not tables:
        raise ValueError(
            "no BEGIN_DATA_FORMAT and BEGIN_DATA, nor a line that names fields such as nm380: neither CGATS text nor "
            "CxF; export the chart as one"
        )

    # The one that has spectra.
    charts = [table for table in map(_paired, tables) if any(map(is_spectral, table.fields))]
    if len(charts) > 1:
        raise ValueError(f"{len(charts)} tables with spectra: keep one measurement a file")
    table = charts[0] if charts else tables[0]

    # Its prints, and how the head says that they were measured.
    _check_counts(table)
    chart = from_rows(table.fields, table.rows, _declared(table))
    told = [(keyword, table.head[keyword][1]) for keyword in CONDITIONS if keyword in table.head]
    return replace(chart, note=chart.note + conditions(told))


def decoded(content: bytes) -> str:
    r"""Text in whatever encoding: UTF-8, UTF-16 if marked, else Latin-1, in which every byte is a letter.

    Examples
    --------
    >>> decoded(b"\xef\xbb\xbfCGATS.17"), decoded(b"\xa9 printer")
    ('CGATS.17', '© printer')
    """
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _tables(lines: list[str]) -> list[Table]:
    """Every table that a file holds, in order."""
    tables: list[Table] = []
    waiting: Row = (0, [])
    table, within, tabbed = Table(), "head", False

    # Line by line: keywords of the head, then names of fields, then data.
    for line, text in enumerate(lines, start=1):
        tokens = _fields(text, line, len(table.fields) if within == "data" else 0, tabbed)

        # A keyword opens or ends a part of the file.
        word = tokens[0].upper() if tokens else ""
        if word == "BEGIN_DATA_FORMAT":
            if within == "data":
                raise ValueError(
                    f"line {line}: BEGIN_DATA_FORMAT inside a table, before its END_DATA: add what is missing"
                )
            within, tokens = "format", tokens[1:]
        elif word == "BEGIN_DATA":
            within, tokens = "data", tokens[1:]
        elif word == "END_DATA":
            _check_row(waiting, len(table.fields), line)
            tables.append(table)
            table, within, tabbed = Table(), "head", False
            continue

        # What a line adds to the part that it stands in.
        if within == "format":
            table.fields.extend(t for t in tokens if t.upper() != "END_DATA_FORMAT")
            check_size(0, len(table.fields))
            tabbed = tabbed or "\t" in text.strip()
            within = "head" if tokens and tokens[-1].upper() == "END_DATA_FORMAT" else within
        elif within == "data":
            waiting = _gathered(table, waiting, (line, tokens)) if tokens else waiting
        elif tokens:
            table.head[word] = (line, " ".join(tokens[1:]))
    if within != "head":
        raise ValueError(f"line {len(lines)}: the file ends inside a table, without END_DATA: copy it again, whole")
    return tables


def _bare_table(lines: list[str]) -> list[Table]:
    """The table of a file without keywords, if a line of it names spectra."""
    table, tabbed = Table(), False
    for line, text in enumerate(lines, start=1):
        if not table.fields:
            tokens = _fields(text, line, 1, "\t" in text.strip())
            # Numbers alone may be wavelengths, or just numbers: something must be named.
            named = sum(map(is_spectral, tokens)) > 1 and any(not token[:1].isdigit() for token in tokens)
            tabbed = named and "\t" in text.strip()
            table.fields.extend(tokens if named else [])
            if not named and tokens:
                table.head[tokens[0].upper()] = (line, " ".join(tokens[1:]))
            check_size(0, len(table.fields))
            continue
        tokens = _fields(text, line, len(table.fields), tabbed)
        if not any(tokens):
            if table.rows:
                break
            continue
        _check_row((line, tokens), len(table.fields), line)
        table.rows.append((line, tokens))
        check_size(len(table.rows), 0)
    return [table] if table.fields else []


def _gathered(table: Table, waiting: Row, row: Row) -> Row:
    """Add a finished row to the table; what is not finished waits for the next line, as the format permits."""
    start, fields = waiting if waiting[1] else (row[0], [])
    fields += row[1]
    if len(fields) >= len(table.fields):
        _check_row((start, fields), len(table.fields), row[0])
        table.rows.append((start, fields))
        check_size(len(table.rows), 0)
        return 0, []
    return start, fields


def _check_row(row: Row, fields: int, line: int) -> None:
    if row[1] and len(row[1]) != fields:
        lines = f"line {row[0]}" if row[0] == line else f"lines {row[0]} to {line}"
        raise ValueError(f"{lines}: {len(row[1])} values for {fields} fields; a print has one value a field")


def _fields(text: str, line: int, wanted: int, tabbed: bool) -> list[str]:
    """The fields of a line; in data, between tabs, one may have spaces in it without quotes, or be empty."""
    # Between tabs, where there are as many parts as there should be.
    if wanted and "\t" in text.strip() and not text.lstrip().startswith("#"):
        parts = text.split("\t")
        if tabbed or len(parts) == wanted:
            parts = parts if len(parts) == wanted else text.strip().split("\t")
            return [part.strip().strip('"').strip() for part in parts]

    # Between spaces, with quotes, and without comments.
    fields = []
    for found in TOKEN.finditer(text):
        quoted, comment, plain, stray = found.groups()
        if stray:
            raise ValueError(f"line {line}: a quote is not closed in {shown(text.strip())}; close it or take it out")
        if comment is None:
            fields.append(plain if plain is not None else quoted.replace('""', '"').strip())
    return fields


def _paired(table: Table) -> Table:
    """The table with names that hold the wavelengths, where they are numbers: SPECTRAL_NM, then SPECTRAL_PCT."""
    names = [name.upper() for name in table.fields]
    pairs = [i for i in range(len(names) - 1) if names[i] == "SPECTRAL_NM" and names[i + 1][:9] == "SPECTRAL_"]
    if not pairs or not table.rows:
        return table
    line, first = table.rows[0]
    fields = list(table.fields)
    for i in pairs:
        if other := next(((n, row[i]) for n, row in table.rows if row[i] != first[i]), None):
            raise ValueError(f"line {other[0]}: wavelength {shown(other[1])}, but {shown(first[i])} in line {line}")
        unit = names[i + 1][9:] if names[i + 1][9:] in UNITS else "NM"
        fields[i], fields[i + 1] = "WAVELENGTH", f"{unit}{number(first[i], f'line {line}, SPECTRAL_NM'):g}"
    return Table(table.head, fields, table.rows)


def _check_counts(table: Table) -> None:
    for keyword, found in (("NUMBER_OF_FIELDS", len(table.fields)), ("NUMBER_OF_SETS", len(table.rows))):
        line, text = table.head.get(keyword, (0, str(found)))
        if number(text, f"line {line}, {keyword}") != found:
            raise ValueError(
                f"line {line}: {keyword} is {shown(text)}, but there are {found}: copy the file again, whole"
            )


def _declared(table: Table) -> list[float] | None:
    """Wavelengths that the head announces."""
    keys = ("SPECTRAL_BANDS", "SPECTRAL_START_NM", "SPECTRAL_END_NM")
    if not all(key in table.head for key in keys):
        return None
    bands, first, last = (number(table.head[key][1], f"line {table.head[key][0]}, {key}") for key in keys)
    if not (1 <= bands <= len(table.fields) and bands == int(bands)):
        raise ValueError(
            f"line {table.head[keys[0]][0]}: SPECTRAL_BANDS is {bands:g}, but there are {len(table.fields)} fields: "
            "bands are missing; export the chart again"
        )
    return [float(nm) for nm in np.linspace(first, last, int(bands))]
