"""Step 3: spectra by name, products of spectra, and images."""

from symrt.spectra.bands import RGB, Bands, coordinates, wavelengths
from symrt.spectra.display import display_matrix, luminance_weights
from symrt.spectra.files import save_image
from symrt.spectra.fluorescence import Fluorescence
from symrt.spectra.image import SpectralImage
from symrt.spectra.library import bell, spectrum, srgb
from symrt.spectra.metals import conductor_reflectance, metals, optical_constants
from symrt.spectra.palette import Palette
from symrt.spectra.palettes_file import load_palettes, save_palettes
from symrt.spectra.products import gamma
from symrt.spectra.reference import Reference
from symrt.spectra.shading import preview, shade
from symrt.spectra.viewing import clipped, to_rgb

__all__ = [
    "RGB",
    "Bands",
    "Fluorescence",
    "Palette",
    "Reference",
    "SpectralImage",
    "bell",
    "clipped",
    "conductor_reflectance",
    "coordinates",
    "display_matrix",
    "gamma",
    "load_palettes",
    "luminance_weights",
    "metals",
    "optical_constants",
    "preview",
    "save_image",
    "save_palettes",
    "shade",
    "spectrum",
    "srgb",
    "to_rgb",
    "wavelengths",
]
