"""Step 3: spectra by name, products of spectra, and images."""

from symrt.spectra.bands import RGB, Bands, coordinates, wavelengths
from symrt.spectra.display import clipped, display_matrix, luminance_weights, to_rgb
from symrt.spectra.files import save_image
from symrt.spectra.image import SpectralImage
from symrt.spectra.library import spectrum
from symrt.spectra.palette import Palette
from symrt.spectra.palettes_file import load_palettes, save_palettes
from symrt.spectra.reference import Reference
from symrt.spectra.shading import gamma, preview, shade

__all__ = [
    "RGB",
    "Bands",
    "Palette",
    "Reference",
    "SpectralImage",
    "clipped",
    "coordinates",
    "display_matrix",
    "gamma",
    "load_palettes",
    "luminance_weights",
    "preview",
    "save_image",
    "save_palettes",
    "shade",
    "spectrum",
    "to_rgb",
    "wavelengths",
]
