"""Step 4: a device's spectral basis and gamut."""

from symrt.gamut.accuracy import BasisReport, basis_report
from symrt.gamut.basis import Basis, uniform_first
from symrt.gamut.colorimetric import ColorimetricGamut, colorimetric_gamut
from symrt.gamut.device import Printer
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.fitting import HalftoneFit, fit_halftone
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.halftone import Halftone
from symrt.gamut.hull import HullGamut, hull_gamut
from symrt.gamut.inks import Device, devices, load_device, reflectance
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import InkIntersection, Intersection, SlabIntersection, intersection
from symrt.gamut.monitor import Monitor, MonitorGamut, load_monitor, monitor_gamut, monitors
from symrt.gamut.recipes import InkGamut, ink_gamut, recipes
from symrt.gamut.slabs import Gamut

__all__ = [
    "Basis",
    "BasisReport",
    "ColorimetricGamut",
    "ConvexGamut",
    "Device",
    "Gamut",
    "Halftone",
    "HalftoneFit",
    "HullGamut",
    "InkGamut",
    "InkIntersection",
    "Intersection",
    "Monitor",
    "MonitorGamut",
    "Printer",
    "SlabIntersection",
    "basis_report",
    "colorimetric_gamut",
    "device_gamut",
    "devices",
    "fit_halftone",
    "hull_gamut",
    "ink_gamut",
    "intersection",
    "load_device",
    "load_gamut",
    "load_monitor",
    "monitor_gamut",
    "monitors",
    "recipes",
    "reflectance",
    "save_gamut",
    "uniform_first",
]
