"""Pieces of a picture in files: kept tiles, and the parts that many machines render (steps 1 and 2).

A piece is a system of some rows, or of a piece of one, and says of which picture.  One digest goes over all of it: a
file that was cut, altered or renamed is told from the one that was written, and so is a piece of another scene.
"""

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from symrt.archives import Kind, read_archive, whole, write_archive
from symrt.linear.tiles import Window
from symrt.saving import LARGEST, packed, unpacked
from symrt.system import LinearSystem

KIND = Kind("piece", 1, "render it first", "render it again")


@dataclass(frozen=True)
class Picture:
    """The picture that a piece belongs to.

    Parameters
    ----------
    version
        Of the symrt that renders it.
    scene
        Digest of the scene made ready, of its size, and of the plan of its effects.
    values
        Digest of its compiled models, with the values of parameters bound and others left free.
    """

    version: str
    scene: str
    values: str
    width: int
    height: int

    def differs(self, other: "Picture") -> Iterator[str]:
        """The differences from another picture, in words."""
        if self.version != other.version:
            yield f"of symrt {self.version}, not {other.version}"
        if (self.width, self.height) != (other.width, other.height):
            yield f"of {self.width} × {self.height} pixels, not {other.width} × {other.height}"
        elif self.scene != other.scene:
            yield "of another scene"
        if self.values != other.values and self.scene == other.scene:
            yield "of other values of parameters"


@dataclass(frozen=True, eq=False)
class Piece:
    """A system of the pixels in a window, and the picture that they belong to.

    Parameters
    ----------
    part
        ``(3, 64)`` for the third of 64 parts; None of a tile.
    """

    picture: Picture
    window: Window
    part: tuple[int, int] | None
    system: LinearSystem


def write_piece(path: str | Path, piece: Piece) -> None:
    """Write a piece to one ``.npz`` file, which appears whole or not at all."""
    header, arrays = packed(piece.system)
    about = {"picture": asdict(piece.picture), "window": list(piece.window), "part": list(piece.part or ())}
    write_archive(path, KIND, {**header, **about}, arrays)


def read_piece(path: str | Path) -> Piece:
    """Read a piece that `write_piece` wrote.

    Raises
    ------
    ValueError
        If the file is not such a piece, or not as it was written.

    Examples
    --------
    >>> read_piece("missing.npz")
    Traceback (most recent call last):
    ValueError: missing.npz: no such file; render it first
    """
    with whole(path, KIND):
        arrays, header = read_archive(path, KIND, LARGEST)
        if "digest" not in header:
            raise ValueError("it has no digest")
        picture = Picture(**header.pop("picture"))
        x0, y0, x1, y1 = map(int, header.pop("window"))
        part = tuple(map(int, header.pop("part")))
        system = unpacked(arrays, header)
        if len(part) not in {0, 2} or (system.width, system.height) != (x1 - x0, y1 - y0):
            raise ValueError("its parts contradict each other")
        return Piece(picture, (x0, y0, x1, y1), (part[0], part[1]) if part else None, system)
