"""Arrays and a header in one ``.npz`` file: what all files that symrt writes of its own have in common.

A file holds NumPy arrays, and one more, ``header``: JSON in UTF-8, as bytes, with ``format``, ``version`` and
``digest``.  Nothing in it is executable.  It appears whole or not at all; and what an array claims to unpack to is
looked at before it is read.
"""

import hashlib
import json
import lzma
import math
import tokenize
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from symrt.disk import ordinary, replacing
from symrt.errors import plain, shown

MOST_MEMBERS = 4096
"""Arrays that a file may hold."""

HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
"""Readers of what stands before the numbers of an array, by the version of NumPy's format."""

DAMAGE = (
    *(zipfile.BadZipFile, zlib.error, KeyError, EOFError, OSError, ValueError, RecursionError, TypeError),
    *(AttributeError, OverflowError, MemoryError, RuntimeError, IndexError, lzma.LZMAError),
    # NumPy reads the head of an array as Python's own literals.
    *(SyntaxError, tokenize.TokenError),
)
"""Exceptions from reading a file that was cut, changed, or is something else."""


@dataclass(frozen=True)
class Kind:
    """A kind of file.

    Parameters
    ----------
    name
        A word for its content, such as ``"system"``; its format is ``"symrt-system"``.
    version
        Of the format; a file of another is refused.
    first
        The way to make such a file, said of one that is not there.
    remedy
        The way to mend one that is damaged.
    """

    name: str
    version: int
    first: str
    remedy: str

    @property
    def format(self) -> str:
        """Its name in the header."""
        return f"symrt-{self.name}"


def write_archive(path: str | Path, kind: Kind, header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> None:
    """Write arrays and a header to one file, which appears whole or not at all.

    Examples
    --------
    >>> import tempfile
    >>> kind = Kind("grey", 1, "write one first", "write it again")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_archive(Path(folder) / "a.npz", kind, {"name": "half"}, {"values": np.full(2, 0.5)})
    ...     read_archive(Path(folder) / "a.npz", kind)
    ({'values': array([0.5, 0.5])}, {'format': 'symrt-grey', 'version': 1, 'name': 'half', 'digest': '...'})
    """
    check_free(path, kind.format)
    sealed = {"format": kind.format, "version": kind.version, **header, "digest": digest(header, arrays)}
    text = np.frombuffer(json.dumps(sealed).encode(), dtype=np.uint8)
    with replacing(path) as file:
        np.savez_compressed(file, allow_pickle=False, header=text, **dict(arrays))


def read_archive(path: str | Path, kind: Kind, largest: int = 1 << 30) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """The arrays and the header of a file; any of `DAMAGE` is raised if it is not whole, see `whole`.

    Parameters
    ----------
    largest
        Bytes that the arrays may unpack to together; a file that claims more is refused before it is read.
    """
    with zipfile.ZipFile(ordinary(path)) as archive:
        check_members(archive, largest)
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays.pop("header").tobytes())
    if not isinstance(header, dict) or header.get("format") != kind.format:
        raise ValueError(f"its header does not say {kind.format!r}")
    if header.get("version") != kind.version:
        raise ValueError(f"it is of version {str(header.get('version'))[:20]}, and this symrt reads {kind.version}")
    # Systems saved before they had a digest have none; what a kind of file demands, its own reader checks.
    if "digest" in header and header["digest"] != digest(header, arrays):
        raise ValueError("it was changed after it was saved: its digest is another")
    return arrays, header


def digest(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> str:
    """SHA-256 over what a header says beside ``format``, ``version`` and ``digest``, and over every array.

    Examples
    --------
    >>> digest({"name": "half"}, {"values": np.full(2, 0.5)})[:8]
    '3e1a9bc8'
    """
    said = {name: value for name, value in header.items() if name not in {"format", "version", "digest"}}
    found = hashlib.sha256(json.dumps(said, sort_keys=True).encode())
    for name, array in sorted(arrays.items()):
        found.update(f"\n{name} {array.dtype.str} {array.shape}\n".encode())
        found.update(np.ascontiguousarray(array).tobytes())
    return found.hexdigest()


def check_free(path: str | Path, form: str) -> None:
    """Refuse a place that holds a file of another kind, which would be lost; one of the same kind may be replaced.

    Parameters
    ----------
    form
        The format in the header of the file to write, such as ``"symrt-system"``; ``""`` for an image, which has none.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "a.npz"
    ...     write_archive(file, Kind("grey", 1, "", ""), {}, {})
    ...     check_free(file, "symrt-grey")
    ...     check_free(file, "")
    Traceback (most recent call last):
    ValueError: ...a.npz: a symrt-grey is there, which would be lost: give another name, or remove that file first
    """
    if Path(path).is_file() and (found := _form(Path(path))) not in {form, None}:
        what = f"a {found}" if found else "an image"
        raise ValueError(f"{path}: {what} is there, which would be lost: give another name, or remove that file first")


def _form(path: Path) -> str | None:
    """The format that the header of a file names, "" for an image; None of an empty file or a damaged archive."""
    try:
        with zipfile.ZipFile(path) as archive:
            names = set(archive.namelist())
            if "header.npy" in names:
                with archive.open("header.npy") as file:
                    header = json.loads(np.lib.format.read_array(file, allow_pickle=False).tobytes())
                return plain(str(header["format"]))[:60]
            return "" if {"values.npy", "bands.npy", "kind.npy"} <= names else "file of other arrays"
    except DAMAGE:
        with path.open("rb") as file:
            start = file.read(2)
        return None if start in {b"", b"PK"} else "file that symrt did not write"


@contextmanager
def whole(path: str | Path, kind: Kind) -> Iterator[None]:
    """Turn whatever goes wrong while a file is read into one line that names the file and the remedy.

    Examples
    --------
    >>> kind = Kind("grey", 1, "write one first", "write it again")
    >>> with whole("a.npz", kind):
    ...     read_archive("a.npz", kind)
    Traceback (most recent call last):
    ValueError: a.npz: no such file; write one first
    """
    try:
        yield
    except FileNotFoundError:
        raise ValueError(f"{path}: no such file; {kind.first}") from None
    except DAMAGE as error:
        reason = f"{error.args[0]!r} is missing" if isinstance(error, KeyError) and error.args else str(error)
        reason = plain(" ".join(reason.split()))[:200] or type(error).__name__
        raise ValueError(f"{path}: not a whole symrt {kind.name} ({reason}); {kind.remedy}") from error


def check_members(archive: zipfile.ZipFile, largest: int) -> None:
    """Refuse arrays that unpack to more than `largest` bytes, or whose shape claims more or less than there is.

    Examples
    --------
    >>> import io
    >>> file = io.BytesIO()
    >>> np.savez_compressed(file, zeros=np.zeros(1000))
    >>> check_members(zipfile.ZipFile(file), 1024)
    Traceback (most recent call last):
    ValueError: 'zeros.npy' claims more than 0.000977 MiB together with what is before it, and is not read
    """
    # A few arrays, each once.
    members = archive.infolist()
    names = [info.filename for info in members]
    if len(names) > MOST_MEMBERS or len(set(names)) < len(names):
        raise ValueError(f"{len(names)} arrays, {len(set(names))} names: too many, or one appears twice")

    # The sizes that they claim, each held against its shape.
    left = largest
    for info in members:
        left -= info.file_size
        if left < 0:
            raise ValueError(
                f"{shown(info.filename)} claims more than {largest / (1 << 20):.3g} MiB together with what is before "
                "it, and is not read"
            )
        with archive.open(info) as file:
            if _claimed(file) != info.file_size:
                raise ValueError(f"the shape of {shown(info.filename)} is not that of its {info.file_size} bytes")


def _claimed(file: BinaryIO | Any) -> int:
    """Bytes that an array has by its shape and type, with what stands before its numbers."""
    version = np.lib.format.read_magic(file)
    if version not in HEADERS:
        raise ValueError(f"an array of version {version}")
    shape, _, dtype = HEADERS[version](file)
    if dtype.hasobject:
        raise ValueError("an array of objects, which is not read")
    return file.tell() + math.prod(shape) * dtype.itemsize
