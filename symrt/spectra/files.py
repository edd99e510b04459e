"""Write images to files, after step 3 of the paper: PNG for the eye, float TIFF and ``.npz`` for further work."""

import imageio.v3 as imageio
import numpy as np

from symrt.spectra.display import to_rgb
from symrt.spectra.image import SpectralImage


def png_bytes(image: SpectralImage) -> bytes:
    """The image as an 8-bit sRGB PNG."""
    return imageio.imwrite("<bytes>", np.rint(255 * to_rgb(image)).astype(np.uint8), extension=".png")
