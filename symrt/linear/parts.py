"""Parts of a picture that many machines render, each into a file, and one system of them all (steps 1 and 2).

A part is a run of whole rows.  Tiles are cut anew within each, and pixels do not know of their tiles, so that the bits
of the whole do not depend on how it was cut.
"""

import re
import warnings
from collections.abc import Generator, Iterable, Mapping
from concurrent.futures import Executor
from contextlib import closing
from itertools import pairwise
from pathlib import Path

from symrt.linear.estimate import check_memory
from symrt.linear.freeing import Free
from symrt.linear.job import make_job
from symrt.linear.pieces import Picture, Piece, read_piece, write_piece
from symrt.linear.program import Values
from symrt.linear.stacking import stacked
from symrt.linear.tiles import rows_of
from symrt.linear.workers import Workers, check, finished
from symrt.scene.records import Scene
from symrt.system import LinearSystem
from symrt.tracing.stage import Alternatives

NAME = re.compile(r"part-([1-9][0-9]*)-of-([1-9][0-9]*)\.npz")


def render_part(  # noqa: PLR0913  # a public verb names its options
    scene: Scene,
    part: tuple[int, int],
    folder: str | Path,
    *,
    values: Values | None = None,
    free: Free = (),
    error: float | int | None = None,
    lengths: str = "hats",
    alternatives: Alternatives | None = None,
    force: Mapping[str, bool] | None = None,
    tolerance: float | int | None = None,
    executor: Executor | None = None,
    workers: Workers = None,
    memory: float | int | None = None,
    progress: bool = True,
) -> Path:
    """Render one part of a picture into a file; a part that is there already is left as it is.

    Parameters
    ----------
    part
        ``(3, 64)`` for the third of 64, which run from 1 to 64: about as many rows each, from the top.
    folder
        Where the parts of this one picture are, on a disk that all machines see; it is made if need be.
    values, free, error, lengths, alternatives, force, tolerance, executor, workers, memory, progress
        As in `render`.

    Returns
    -------
    Path
        The part's file, ``part-3-of-64.npz``, for `merge_parts`.

    Raises
    ------
    ValueError
        If there is no such part, or the folder holds that of another picture under its name.

    Examples
    --------
    >>> import tempfile
    >>> from symrt.scene import load_scene, shipped_scene
    >>> folder, scene = tempfile.mkdtemp(), load_scene(shipped_scene("first"))
    >>> [render_part(scene, (k, 2), folder, progress=False).name for k in (1, 2)]
    ['part-1-of-2.npz', 'part-2-of-2.npz']
    >>> merge_parts(folder)
    LinearSystem(256 × 256 pixels, 2 interactions, 46664 coefficients, 0.7 a pixel)
    """
    check(workers)
    job = make_job(scene, values, free, alternatives, force, tolerance, error, lengths)
    rows = rows_of(part, job.picture.height)
    folder = Path(folder)
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder}: a file has this name: name a folder for the parts")
    path = folder / f"part-{part[0]}-of-{part[1]}.npz"
    if _there(path, part, job.picture):
        return path

    # Render its tiles, and write it whole or not at all.
    check_memory(job, workers, memory, rows)
    folder.mkdir(parents=True, exist_ok=True)
    width = job.picture.width
    with closing(finished(job, job.windows(rows), workers, executor, progress)) as systems:
        system = stacked(systems, width, rows[1] - rows[0])
    write_piece(path, Piece(job.picture, (0, rows[0], width, rows[1]), part, system))
    return path


def merge_parts(folder: str | Path) -> LinearSystem:
    """The system of a picture whose parts are in a folder: to the bit the one that `render` gives in one go.

    Raises
    ------
    ValueError
        If parts are missing, damaged, or of different pictures, a line each; the last line has the numbers of the parts
        to render, as job arrays take them: ``--array=3,17-19``.

    Examples
    --------
    >>> merge_parts("missing")
    Traceback (most recent call last):
    ValueError: missing: no parts are there: render them with render_part, or symrt render --part 1/64 --out missing
    """
    folder = Path(folder)
    found = {(int(m[1]), int(m[2])): path for path in folder.glob("part-*") if (m := NAME.fullmatch(path.name))}
    counts = sorted({of for _, of in found})
    if not counts:
        raise ValueError(
            f"{folder}: no parts are there: render them with render_part, or symrt render --part 1/64 --out {folder}"
        )
    if len(counts) > 1:
        cuts = " and ".join(f"of {count}" for count in counts)
        raise ValueError(f"{folder}: parts {cuts} are there: remove all but those of one cut")
    picture = _first_picture(found[part] for part in sorted(found))
    return stacked(_systems(folder, found, counts[0], picture), picture.width, picture.height)


def _there(path: Path, part: tuple[int, int], picture: Picture) -> bool:
    """Whether a part was rendered earlier; one that is damaged, or another part, is to be rendered again."""
    # A part of another picture is not ours to overwrite; a damaged one is.
    if not path.exists():
        return False
    try:
        piece = read_piece(path)
    except ValueError as error:
        wrong = str(error)
    else:
        if difference := next(piece.picture.differs(picture), None):
            raise ValueError(f"{path}: a part {difference}: name an empty folder, or empty this one")
        if piece.part == part:
            return True
        wrong = f"{path}: it holds part {_name(piece)}"
    warnings.warn(f"{wrong}: this part is rendered again", stacklevel=3)
    path.unlink()
    return False


def _first_picture(paths: Iterable[Path]) -> Picture:
    """The picture of the first part that can be read."""
    faults = []
    for path in paths:
        try:
            return read_piece(path).picture
        except ValueError as error:
            faults.append(str(error))
    raise ValueError("\n".join(faults))


def _systems(
    folder: Path, found: Mapping[tuple[int, int], Path], count: int, picture: Picture
) -> Generator[LinearSystem, None, None]:
    """The system of each part in turn; what is wrong with any is said at the end, when all have been looked at."""
    # Parts in their order, as long as none is missing; after that only faults are collected.
    faults, wanting = [], []
    for number in range(1, count + 1):
        path = found.get((number, count))
        try:
            piece = None if path is None else read_piece(path)
            wrong = "" if piece is None else _fault(piece, (number, count), picture)
        except ValueError as error:
            piece, wrong = None, str(error)
        else:
            wrong = wrong and f"{path}: {wrong}"
        if wrong:
            faults.append(wrong)
        if piece is None or wrong:
            wanting.append(number)
        elif not wanting:
            yield piece.system
    if wanting:
        left = f"{len(wanting)} of {count} parts are to be rendered"
        raise ValueError("\n".join([*faults, f"{folder}: {left}: --array={runs(wanting)}"]))


def _fault(piece: Piece, part: tuple[int, int], picture: Picture) -> str:
    """The reason that a piece cannot be this part of this picture; empty if it can."""
    if difference := next(piece.picture.differs(picture), None):
        return f"a part {difference}, by the first part there: remove one of the two"
    if piece.part != part or piece.window[1::2] != rows_of(part, picture.height):
        return f"it holds part {_name(piece)}: remove it"
    return ""


def _name(piece: Piece) -> str:
    return "of no number, a tile" if piece.part is None else f"{piece.part[0]} of {piece.part[1]}"


def runs(numbers: list[int]) -> str:
    """Ascending numbers as job arrays take them.

    Examples
    --------
    >>> runs([3, 17, 18, 19])
    '3,17-19'
    """
    breaks = [k + 1 for k, (one, other) in enumerate(pairwise(numbers)) if other > one + 1]
    parts = [numbers[a:b] for a, b in pairwise([0, *breaks, len(numbers)])]
    return ",".join(str(part[0]) if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts)
