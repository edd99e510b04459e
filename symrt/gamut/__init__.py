"""Step 4: a device's spectral basis and gamut."""

from symrt.gamut.basis import Basis, uniform_first
from symrt.gamut.device import Printer
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.fitting import HalftoneFit, fit_halftone
from symrt.gamut.halftone import Halftone
from symrt.gamut.inks import Device, devices, load_device, reflectance
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.monitor import Monitor, MonitorGamut, load_monitor, monitor_gamut, monitors
from symrt.gamut.slabs import Gamut, device_gamut

__all__ = [
    "Basis",
    "ConvexGamut",
    "Device",
    "Gamut",
    "Halftone",
    "HalftoneFit",
    "Monitor",
    "MonitorGamut",
    "Printer",
    "device_gamut",
    "devices",
    "fit_halftone",
    "load_device",
    "load_gamut",
    "load_monitor",
    "monitor_gamut",
    "monitors",
    "reflectance",
    "save_gamut",
    "uniform_first",
]
