"""Write results: records as JSON, and figures as files, each whole or not at all."""

import json
from pathlib import Path
from typing import Any

from symrt.disk import write_whole


def json_text(record: Any) -> str:
    """A record as JSON; numbers that are not finite are refused.

    Examples
    --------
    >>> print(json_text({"low": 0.01}))
    {
      "low": 0.01
    }
    """
    # Letters beyond ASCII are written as escapes: the text passes any terminal, and is the same in any encoding.
    return json.dumps(record, indent=2, allow_nan=False).replace("\x7f", "\\u007f")


def draw(path: Path, figure: str, *arguments: Any) -> None:
    """Draw a figure of `symrt.show.plots` into a PNG file.

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
    from symrt.show import plots  # noqa: PLC0415  # matplotlib is slow to import

    write_whole(path, plots.png(getattr(plots, figure)(*arguments)))
