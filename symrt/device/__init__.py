"""Devices that show spectra: printers, known by their prints or by a model, measured charts, and monitors."""

from symrt.device.fitting import HalftoneFit, fit_halftone
from symrt.device.halftone import Halftone
from symrt.device.inks import devices, load_device
from symrt.device.monitors import Monitor, load_monitor, monitors
from symrt.device.printing import Device, Printer, reflectance

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
