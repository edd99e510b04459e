"""Regions and weights of a picture's pixels, from words and grey pictures on the command line."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import symrt as rt
from symrt.errors import shown

if TYPE_CHECKING:
    import numpy as np
    from jaxtyping import Bool, Float

    from symrt.spectra.palette import Palette
    from symrt.system import LinearSystem

    Mask = Bool[np.ndarray, "height width"]
    Grey = Float[np.ndarray, "height width"]

WHITE = 0.5
"""Grey above which a pixel of a mask is in the region."""


def parted(system: "LinearSystem", palette: "Palette", words: Sequence[str] | None) -> tuple["LinearSystem", "Palette"]:
    """Split regions off materials, by words such as ``bay=sea:0,0,64,32``, in the system and in the palette."""
    for word in words or ():
        # The new name, the material, and its region.
        found = re.fullmatch(r"([^=:]*)=([^=:]*):(.+)", word)
        if not found:
            raise ValueError(
                f"--split {shown(word)}: write NAME=MATERIAL:X0,Y0,X1,Y1 or NAME=MATERIAL:MASK.png, "
                "such as bay=sea:0,0,64,32"
            )
        name, material, where = found.groups()
        mask = _mask(where, (system.height, system.width))
        if not mask.any():
            raise ValueError(f"--split {shown(word)}: no pixel is in the region")

        system, palette = rt.split(system, material, mask, name), rt.with_region(palette, material, name)
    return system, palette


def _mask(word: str, shape: tuple[int, int]) -> "Mask":
    """A region from the path of a grey picture, or from the corners of a rectangle."""
    import numpy as np  # noqa: PLC0415  # slow, and --help does not need it

    if Path(word).suffix.lower() == ".png":
        return _picture(Path(word), shape) > WHITE

    # Corners must lie in the picture, and hold at least one pixel.
    corners = re.fullmatch(r"([0-9]{1,5}),([0-9]{1,5}),([0-9]{1,5}),([0-9]{1,5})", word)
    if not corners:
        raise ValueError(f"--split {shown(word)}: a region is X0,Y0,X1,Y1, whole numbers, or the path of a .png")
    left, top, right, bottom = map(int, corners.groups())
    height, width = shape
    if not (left < right <= width and top < bottom <= height):
        raise ValueError(
            f"--split {word}: the picture is {width} × {height}: 0 <= X0 < X1 <= {width} and 0 <= Y0 < Y1 <= {height}"
        )

    mask = np.zeros(shape, dtype=bool)
    mask[top:bottom, left:right] = True
    return mask


def weights_of(path: Path | None, system: "LinearSystem") -> "Grey | None":
    """The weight of each pixel from a grey picture of the image's size; None if no picture is given."""
    return None if path is None else _picture(path, (system.height, system.width))


def _picture(path: Path, shape: tuple[int, int]) -> "Grey":
    from symrt.geometry.pictures import grey_picture  # noqa: PLC0415  # slow, as above

    found = grey_picture(path)
    if found.shape != shape:
        height, width = found.shape
        raise ValueError(f"{path}: it is {width} × {height}, the picture {shape[1]} × {shape[0]}: give the same size")
    return found
