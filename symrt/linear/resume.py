"""Keep the tiles of a render on disk, so that an interrupted one goes on where it stopped (steps 1 and 2).

A folder belongs to one render, whose digest stands beside the tiles: over symrt's version, the tiles, the scene made
ready, its plan and its compiled program.  A tile says of which picture it is and where in it, under a digest of its
own: one that was altered, renamed, or put there from another render is made again, and a sentence says so.
"""

import re
from dataclasses import dataclass
from pathlib import Path

from symrt.disk import write_whole
from symrt.linear.digests import digest_of
from symrt.linear.pieces import Picture, Piece, read_piece, write_piece
from symrt.linear.tiles import Window
from symrt.system import LinearSystem

NAME = "render.sha256"
WHOLE = re.compile(r"[0-9a-f]{64}")
"""A digest that was not cut off."""


@dataclass(frozen=True)
class Tiles:
    """A folder of finished tiles, and the picture that they belong to."""

    folder: Path
    picture: Picture

    def path(self, window: Window) -> Path:
        """The file of a tile."""
        return self.folder / f"tile-{window[0]}-{window[1]}.npz"

    def finished(self, window: Window) -> tuple[LinearSystem | None, str]:
        """A tile that was finished earlier, or None; and a sentence about one that cannot be used.

        Raises
        ------
        ValueError
            If the name of the tile is that of a folder.
        """
        # Nothing there, or nothing of ours.
        path = self.path(window)
        if path.is_dir():
            raise ValueError(f"{path}: a folder has the name of a tile: remove it, or name an empty folder")
        if not path.exists():
            return None, ""

        # A tile of this picture and this window is taken; any other goes, and is told.
        try:
            piece = read_piece(path)
            wrong = next(piece.picture.differs(self.picture), "")
            if piece.window != window:
                wrong = wrong or f"of {piece.window}, not {window}"
            if not wrong:
                return piece.system, ""
            wrong = f"{path}: a tile {wrong}"
        except ValueError as error:
            wrong = str(error)
        path.unlink()
        return None, f"{wrong}: this tile was made again"

    def keep(self, window: Window, tile: LinearSystem) -> None:
        """Write a finished tile, whole or not at all."""
        write_piece(self.path(window), Piece(self.picture, window, None, tile))


def open_tiles(folder: str | Path, picture: Picture, windows: list[Window]) -> Tiles:
    """The tiles of one render in a folder, which is made if need be.

    Raises
    ------
    ValueError
        If the folder holds the tiles of another scene, or other parameters.

    Examples
    --------
    >>> import tempfile
    >>> folder = tempfile.mkdtemp()
    >>> open_tiles(folder, Picture("0.1.0", "a scene", "", 8, 8), []).finished((0, 0, 8, 8))
    (None, '')
    >>> open_tiles(folder, Picture("0.1.0", "another scene", "", 8, 8), [])
    Traceback (most recent call last):
    ValueError: ...: it holds tiles of another scene or of other parameters; name an empty folder, or empty this one
    """
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: a file has this name: name a folder for the tiles")
    folder.mkdir(parents=True, exist_ok=True)
    digest, stored = digest_of(picture, windows), folder / NAME
    held = stored.read_bytes().decode("latin-1") if stored.is_file() else None
    # A digest that was cut off, by a full disk, says nothing: each tile tells of which render it is.
    if (held is None and not any(folder.glob("tile-*"))) or (held is not None and not WHOLE.fullmatch(held)):
        write_whole(stored, digest)
        held = digest
    if held != digest:
        raise ValueError(
            f"{folder}: it holds tiles of another scene or of other parameters; name an empty folder, or empty this one"
        )
    return Tiles(folder, picture)
