"""Step 4: a device's spectral basis and gamut."""

from symrt.gamut.basis import Basis, uniform_first
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.inks import Device, devices, load_device, reflectance
from symrt.gamut.slabs import Gamut, device_gamut

__all__ = [
    "Basis",
    "Device",
    "Gamut",
    "device_gamut",
    "devices",
    "load_device",
    "load_gamut",
    "reflectance",
    "save_gamut",
    "uniform_first",
]
