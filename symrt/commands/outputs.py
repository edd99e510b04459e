"""Checks, before the work, that a command's files can be written and that no other file would be lost."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from symrt.reading import shipped_scene
from symrt.symbols import NAME


def writable(path: Path, *endings: str, form: str | None = None) -> Path:
    """The path itself, if a file of that kind can be written there.

    Parameters
    ----------
    form
        The form written in a ``.npz``, ``"symrt-system"``, or ``""`` for an image: a file of another is not replaced.
    """
    if path.suffix.lower() not in endings:
        raise ValueError(f"{path}: the name must end in {' or '.join(endings)}")
    if path.is_dir():
        raise ValueError(f"{path}: a folder has this name; give the name of a file")
    if not path.parent.is_dir():
        raise ValueError(f"{path}: there is no folder {path.parent}; make it first, or give another path")
    if form is not None and path.suffix.lower() == ".npz":
        from symrt.archives import check_free  # noqa: PLC0415  # slow, and --help does not need it

        check_free(path, form)
    return path


def apart(outputs: Mapping[str, Path | None], inputs: Sequence[str | Path | None] = ()) -> None:
    """Refuse two outputs in one file, and an output over a file that is read, as one of the two would be lost.

    Examples
    --------
    >>> apart({"--out": Path("a.png"), "--plot": Path("./a.png")})
    Traceback (most recent call last):
    ValueError: --out and --plot are both a.png: give each a name of its own
    >>> apart({"--out": Path("a.npz")}, ["a.npz", None])
    Traceback (most recent call last):
    ValueError: --out a.npz is a file that is read, and would be lost: give another name
    """
    read = {file for word in inputs if word is not None for file in _files(str(word))}
    written: dict[tuple[int, int] | Path, str] = {}
    for option, path in outputs.items():
        if path is None:
            continue
        place = _identity(path)
        if place in {_identity(file) for file in read}:
            raise ValueError(f"{option} {path} is a file that is read, and would be lost: give another name")
        if place in written:
            raise ValueError(f"{written[place]} and {option} are both {path}: give each a name of its own")
        written[place] = option


def _files(word: str) -> list[Path]:
    """Files that a word may mean: its own, or those that ``+`` joins, or the mask of a region, or a shipped scene's."""
    parts = [word, *word.split("+"), word.rpartition(":")[2]]
    if NAME.fullmatch(word) and not Path(word).is_file():
        parts += [str(place) for place in _shipped(word)]
    return [Path(part) for part in parts if part]


def _shipped(word: str) -> list[Path]:
    try:
        return [shipped_scene(word)]
    except ValueError:  # it is the name of something else
        return []


def _identity(path: Path) -> tuple[int, int] | Path:
    """The identity of a file, the same for all its names: its number on the disk, or the path where it will be."""
    try:
        found = path.stat()
    except (OSError, ValueError):  # it is not there yet
        return path.absolute().parent.resolve() / path.name
    return found.st_dev, found.st_ino
