"""Devices that show spectra: printers, known by their prints or by a model, measured charts, and monitors."""

from symrt.devices.device import Device, Printer, reflectance
from symrt.devices.fitting import HalftoneFit, fit_halftone
from symrt.devices.halftone import Halftone
from symrt.devices.inks import devices, load_device
from symrt.devices.monitors import Monitor, load_monitor, monitors

__all__ = [
    "Device",
    "Halftone",
    "HalftoneFit",
    "Monitor",
    "Printer",
    "devices",
    "fit_halftone",
    "load_device",
    "load_monitor",
    "monitors",
    "reflectance",
]
