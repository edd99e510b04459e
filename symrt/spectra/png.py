"""Pictures as PNG, which say that they are sRGB (after step 3 of the paper).

References
----------
W3C, "Portable Network Graphics (PNG) Specification (Third Edition)", 2025, section 11.3.2: the chunks sRGB, gAMA, cHRM.
"""

import struct

import imageio.v3 as imageio
import numpy as np
from jaxtyping import UInt8
from PIL.PngImagePlugin import PngInfo

COLOUR_SPACE = {
    b"sRGB": b"\x01",  # relative colorimetric: white is white
    b"gAMA": struct.pack(">I", 45455),
    b"cHRM": struct.pack(">8I", 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000),
}
"""The specification's chunks for sRGB; the last two are for readers that do not know the first."""


def srgb_chunks() -> PngInfo:
    """The chunks that Pillow writes into a PNG, so that it names its colour space.

    Examples
    --------
    >>> [chunk[0] for chunk in srgb_chunks().chunks]
    [b'sRGB', b'gAMA', b'cHRM']
    """
    found = PngInfo()
    for name, data in COLOUR_SPACE.items():
        found.add(name, data)
    return found


def encode_png(codes: UInt8[np.ndarray, "height width 3"]) -> bytes:
    """8-bit sRGB, such as a `preview`, as a PNG that names its colour space.

    Examples
    --------
    >>> b"sRGB" in encode_png(np.zeros((1, 1, 3), dtype=np.uint8))
    True
    """
    return imageio.imwrite("<bytes>", codes, extension=".png", pnginfo=srgb_chunks())
