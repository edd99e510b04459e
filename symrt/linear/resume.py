"""Keep the tiles of a render on disk, so that an interrupted one goes on where it stopped (steps 1 and 2).

A folder belongs to one render: a digest of symrt's version, the tiles, the scene made ready and its compiled program
stands beside the tiles.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path

import numpy as np
import sympy

from symrt.saving import load_system, save_system
from symrt.system import LinearSystem

Window = tuple[int, int, int, int]
NAME = "render.sha256"


@dataclass(frozen=True)
class Tiles:
    """A folder of finished tiles."""

    folder: Path

    def path(self, window: Window) -> Path:
        """The file of a tile."""
        return self.folder / f"tile-{window[0]}-{window[1]}.npz"

    def finished(self, window: Window) -> LinearSystem | None:
        """A tile that was finished earlier, or None; one that is damaged counts as unfinished."""
        if not self.path(window).is_file():
            return None
        try:
            return load_system(self.path(window))
        except ValueError:
            self.path(window).unlink()
            return None

    def keep(self, window: Window, tile: LinearSystem) -> LinearSystem:
        """Write a finished tile, whole or not at all."""
        save_system(self.path(window), tile)
        return tile


def open_tiles(folder: str | Path, *parts: object) -> Tiles:
    """The tiles of one render in a folder, which is made if need be.

    Raises
    ------
    ValueError
        If the folder holds the tiles of another scene, or other parameters.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> open_tiles(folder, "a scene").finished((0, 0, 8, 8)) is None
    True
    >>> open_tiles(folder, "another scene")
    Traceback (most recent call last):
    ValueError: ...: it holds tiles of another scene or of other parameters; name an empty folder, or empty this one
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    digest, stored = hashlib.sha256(b"".join(described(parts))).hexdigest(), folder / NAME
    if not stored.is_file() and not any(folder.glob("tile-*")):
        stored.write_text(digest)
    if not stored.is_file() or stored.read_text() != digest:
        raise ValueError(
            f"{folder}: it holds tiles of another scene or of other parameters; name an empty folder, or empty this one"
        )
    return Tiles(folder)


def described(thing: object) -> Iterator[bytes]:
    """Everything that a record holds, as bytes: two records give the same only if they are the same, bit for bit.

    Examples
    --------
    >>> list(described((1.5, "sun")))
    [b'tuple[', b'0x1.8000000000000p+0;', b"'sun';", b']']
    """
    if isinstance(thing, sympy.Basic):
        yield f"{sympy.srepr(thing)};".encode()
    elif isinstance(thing, np.ndarray):
        yield f"{thing.dtype}{thing.shape};".encode() + np.ascontiguousarray(thing).tobytes()
    elif isinstance(thing, float | np.floating):
        yield f"{float(thing).hex()};".encode()
    elif isinstance(thing, np.integer):
        yield from described(int(thing))
    elif thing is None or isinstance(thing, str | bool | int | Path):
        yield f"{str(thing) if isinstance(thing, Path) else thing!r};".encode()
    else:
        yield f"{type(thing).__name__}[".encode()
        for part in _parts(thing):
            yield from described(part)
        yield b"]"


def _parts(thing: object) -> list[object]:
    if isinstance(thing, Mapping):
        return [part for key in sorted(thing) for part in (key, thing[key])]
    if isinstance(thing, tuple | list):
        return list(thing)
    if isinstance(thing, frozenset | set):
        return sorted(thing)
    if is_dataclass(thing):
        return [getattr(thing, field.name) for field in fields(thing)]
    raise ValueError(f"{thing!r} cannot be recognised when a render is resumed; make it a dataclass")
