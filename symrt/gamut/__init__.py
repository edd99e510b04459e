"""Step 4: a device's spectral basis and gamut."""

from symrt.gamut.accuracy import BasisReport, basis_report
from symrt.gamut.basis import Basis, uniform_first
from symrt.gamut.colorimetric import ColorimetricGamut, colorimetric_gamut
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.gamuts import device_gamut
from symrt.gamut.hull import HullGamut, hull_gamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import InkIntersection, Intersection, SlabIntersection, intersection
from symrt.gamut.monitor import MonitorGamut, monitor_gamut
from symrt.gamut.recipes import InkGamut, ink_gamut, recipes
from symrt.gamut.slabs import Gamut

__all__ = [
    "Basis",
    "BasisReport",
    "ColorimetricGamut",
    "ConvexGamut",
    "Gamut",
    "HullGamut",
    "InkGamut",
    "InkIntersection",
    "Intersection",
    "MonitorGamut",
    "SlabIntersection",
    "basis_report",
    "colorimetric_gamut",
    "device_gamut",
    "hull_gamut",
    "ink_gamut",
    "intersection",
    "load_gamut",
    "monitor_gamut",
    "recipes",
    "save_gamut",
    "uniform_first",
]
