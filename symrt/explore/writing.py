"""Results on their way out: records as JSON, figures and files, each whole or not at all."""

import json
from pathlib import Path
from typing import Any

__all__ = ["draw", "json_text", "write_whole"]


def json_text(record: Any) -> str:
    """A record for a program to read; numbers that are not finite are refused.

    Examples
    --------
    >>> print(json_text({"low": 0.01}))
    {
      "low": 0.01
    }
    """
    return json.dumps(record, indent=2, allow_nan=False, ensure_ascii=False)


def draw(path: Path, figure: str, *arguments: Any) -> None:
    """Draw a figure of `symrt.explore.plots` into a PNG file.

    Examples
    --------
    >>> import tempfile
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     draw(Path(folder) / "gamut.png", "solids_figure", device_gamut(load_device("dye3-endura-premier")))
    ...     (Path(folder) / "gamut.png").stat().st_size > 10_000
    True
    """
    from symrt.explore import plots  # noqa: PLC0415  # matplotlib is slow to import

    write_whole(path, plots.png(getattr(plots, figure)(*arguments)))


def write_whole(path: Path, content: str | bytes) -> None:
    """Write beside the file first, and put it in its place when every byte is on the disk.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_whole(Path(folder) / "a.txt", "r = e p / w")
    ...     [file.name for file in Path(folder).iterdir()]
    ['a.txt']
    """
    partial = path.with_name(path.name + ".partial")
    try:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
