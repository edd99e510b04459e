"""See an image as a screen shows it: radiances to sRGB against a white, after step 3 of the paper."""

import numpy as np
from jaxtyping import Float

from symrt.arrays import Spectrum
from symrt.errors import require
from symrt.spectra.bands import Number
from symrt.spectra.display import check_exposure, display_matrix, encode, white_among
from symrt.spectra.image import SpectralImage


def to_rgb(
    image: SpectralImage, exposure: Number = 1.0, white: Spectrum | str | None = None
) -> Float[np.ndarray, "height width 3"]:
    """The image in encoded sRGB, from 0 to 1; what a screen cannot show is clipped, see `clipped`.

    Parameters
    ----------
    exposure
        Factor on every radiance; at 1 the reference white is the screen's white.
    white
        The radiance shown as the screen's white.  None: the white that the palette carries, or else that of the key
        light *in this palette*, so that a dimmer lamp makes the same picture.  To see it dimmer give a fixed white: its
        radiance, such as another image's ``image.white``.  Or a light of the scene by name; or ``"equal-energy"`` or a
        viewing illuminant such as ``"illuminant/A"``, as bright as the first.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> image = SpectralImage(np.array([[[1.0, 0.5, 0.0]]]), RGB, whites={"sun": np.ones(3)})
    >>> to_rgb(image).round(3).tolist()
    [[[1.0, 0.735, 0.0]]]
    """
    return encode(linear_rgb(image, exposure, white))


def linear_rgb(
    image: SpectralImage, exposure: Number = 1.0, white: Spectrum | str | None = None
) -> Float[np.ndarray, "height width 3"]:
    """The image in linear sRGB, not clipped: below 0 or above 1 where a screen cannot follow."""
    require("image", image, SpectralImage, "shade(system, palette)")
    if image.bands.kind == "coordinate":
        raise ValueError("the image holds basis coordinates: shade it without basis= to see it")
    check_exposure(exposure)
    radiance = white_among(image.whites, white, image.bands) if white is None or isinstance(white, str) else white
    return image.values @ (exposure * display_matrix(image.bands, radiance))


def clipped(image: SpectralImage, exposure: Number = 1.0, white: Spectrum | str | None = None) -> float:
    """The share of pixels that a screen cannot show: some component below 0 or above 1, and clipped by `to_rgb`.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> clipped(SpectralImage(np.array([[[1.0, 0.5, 0.0], [1.5, 1, 1]]]), RGB, whites={"sun": np.ones(3)}))
    0.5
    """
    linear = linear_rgb(image, exposure, white)
    # White itself may come out a few ulp above 1.
    return float(np.mean(((linear < -1e-9) | (linear > 1 + 1e-9)).any(axis=-1)))
