"""Keep the tiles of a render on disk, so that an interrupted one goes on where it stopped (steps 1 and 2).

A folder belongs to one render: a digest of symrt's version, the tiles, the scene made ready and its compiled program
stands beside the tiles.  Each tile has a seal, a digest over that one, its window and every byte of its file: a tile
that was altered, renamed, or put there from another render is made again.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path

import numpy as np
import sympy

from symrt.disk import write_whole
from symrt.saving import load_system, save_system
from symrt.system import LinearSystem

Window = tuple[int, int, int, int]
NAME = "render.sha256"
WHOLE = re.compile(r"[0-9a-f]{64}")
"""A digest that was not cut off."""


@dataclass(frozen=True)
class Tiles:
    """A folder of finished tiles, and the digest of the render that they belong to."""

    folder: Path
    digest: str

    def path(self, window: Window) -> Path:
        """The file of a tile."""
        return self.folder / f"tile-{window[0]}-{window[1]}.npz"

    def seal(self, window: Window) -> Path:
        """The file of its seal."""
        return self.folder / f"seal-{window[0]}-{window[1]}.sha256"

    def finished(self, window: Window) -> LinearSystem | None:
        """A tile that was finished earlier, or None; one that is damaged, or not this tile, counts as unfinished.

        Raises
        ------
        ValueError
            If the name of the tile, or of its seal, is that of a folder.
        """
        path, seal = self.path(window), self.seal(window)
        for place in (path, seal):
            if place.is_dir():
                raise ValueError(f"{place}: a folder has the name of a tile: remove it, or name an empty folder")
        if path.is_file() and seal.is_file() and seal.read_bytes() == self._sealed(window).encode():
            try:
                return load_system(path)
            except ValueError:  # sealed by a symrt that wrote otherwise
                pass
        path.unlink(missing_ok=True)
        return None

    def keep(self, window: Window, tile: LinearSystem) -> LinearSystem:
        """Write a finished tile, whole or not at all, and then its seal."""
        save_system(self.path(window), tile)
        write_whole(self.seal(window), self._sealed(window))
        return tile

    def _sealed(self, window: Window) -> str:
        return hashlib.sha256(f"{self.digest} {window}\n".encode() + self.path(window).read_bytes()).hexdigest()


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
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: a file has this name: name a folder for the tiles")
    folder.mkdir(parents=True, exist_ok=True)
    digest, stored = hashlib.sha256(b"".join(described(parts))).hexdigest(), folder / NAME
    held = stored.read_bytes().decode("latin-1") if stored.is_file() else None
    # A digest that was cut off, by a full disk, says nothing: the seals tell which tiles are of this render.
    if (held is None and not any(folder.glob("tile-*"))) or (held is not None and not WHOLE.fullmatch(held)):
        write_whole(stored, digest)
        held = digest
    if held != digest:
        raise ValueError(
            f"{folder}: it holds tiles of another scene or of other parameters; name an empty folder, or empty this one"
        )
    return Tiles(folder, digest)


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
