"""Files on the disk: only ordinary ones are read, and what is written appears whole or not at all."""

import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO


def ordinary(path: str | Path) -> Path:
    """The path itself, unless a pipe, a socket or a device has its name: reading from those may never end.

    Examples
    --------
    >>> ordinary("missing.toml").name
    'missing.toml'
    >>> ordinary("/dev/null")
    Traceback (most recent call last):
    ValueError: a pipe or a device, not a file: save what comes from it to a file, and name that
    """
    path = Path(path)
    try:
        mode = path.stat().st_mode
    except (OSError, ValueError):  # whoever opens it says why it cannot be read
        return path
    if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
        raise ValueError("a pipe or a device, not a file: save what comes from it to a file, and name that")
    return path


@contextmanager
def replacing(path: str | Path) -> Iterator[BinaryIO]:
    """A new file to write into, which takes the place of `path` once every byte of it is on the disk.

    Two writers never share one, and if anything goes wrong, `path` is as it was.  Faults of the disk name `path`.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(Path(folder) / "a.txt") as file:
    ...         _ = file.write(b"r = e p / w")
    ...     [file.name for file in Path(folder).iterdir()]
    ['a.txt']
    """
    path = Path(path)
    partial = path.with_name(f".{secrets.token_hex(8)}.partial")
    try:
        # A name of its own for each writer, opened exclusively: whatever has that name, a link too, is not followed.
        with partial.open("xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        if error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        partial.unlink(missing_ok=True)


def write_whole(path: str | Path, content: str | bytes) -> None:
    """Write a file whole or not at all; text in UTF-8.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_whole(Path(folder) / "a.txt", "r = e p / w")
    ...     (Path(folder) / "a.txt").read_text()
    'r = e p / w'
    """
    with replacing(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)
