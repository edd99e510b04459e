"""Devices and gamuts as plain records, for files of step 4: names and numbers as JSON, and arrays of known shapes.

The parts of each record stand in one table, `PRINTERS`, `DEVICES` and `GAMUTS`: numbers as hexadecimal text, so
that they come back bit for bit, and arrays by the names of their axes.  What is read is held against the same table,
and then against what the record itself must obey.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from symrt.device.dyes import Dyes
from symrt.device.halftone import Halftone
from symrt.device.monitors import Monitor
from symrt.device.printing import Device
from symrt.errors import shown
from symrt.gamut.colorimetric import ColorimetricGamut
from symrt.gamut.gamuts import AnyGamut
from symrt.gamut.hull import HullGamut
from symrt.gamut.monitor import MonitorGamut
from symrt.gamut.recipes import InkGamut
from symrt.gamut.slabs import Gamut
from symrt.spectra.bands import RGB, Bands, coordinates

Header = dict[str, Any]
Arrays = dict[str, np.ndarray]
FACE_MISS = 1e-9
"""Distance by which faces may miss the points that they were laid through."""


@dataclass(frozen=True)
class Form:
    """The parts of a record, by name.

    Parameters
    ----------
    record
        Its class.
    check
        Raises ValueError if its parts contradict each other.
    arrays
        Names of its arrays, and the axes of each.
    numbers, texts
        Names of its numbers and of its texts.
    """

    record: Any
    check: Callable[[Any], None]
    arrays: Mapping[str, str]
    numbers: tuple[str, ...] = ()
    texts: tuple[str, ...] = ()


def _check_printer(printer: Any) -> None:
    _hold(0 < printer.most < np.inf, "the largest amount of an ink is not above 0, or infinite")


def _check_device(device: Device) -> None:
    printer = device.printer
    _hold(printer is None or len(printer.inks) == len(device.inks), "the printer has other inks than the device")
    _hold(0 <= device.model_error < np.inf, "the error of the printer's model is below 0, or not a number")


def _check_monitor(monitor: Monitor) -> None:
    _hold(np.linalg.matrix_rank(monitor.primaries) == 3, "the primaries span no three colours")


def _check_slabs(gamut: Gamut) -> None:
    _hold(np.all(gamut.lower <= gamut.upper), "a lower bound is above the upper one")
    _hold((gamut.black == "luminance") == (gamut.weights is not None), "weights belong to the luminance of black alone")
    if gamut.weights is not None:
        right = np.all(gamut.weights >= 0) and abs(gamut.weights.sum() - 1) <= FACE_MISS
        _hold(right, "the weights of luminance are below 0, or do not sum to 1")
    if gamut.model == "envelope":
        prints = gamut.device.samples
        _hold(np.all((gamut.lower <= prints) & (prints <= gamut.upper)), "the envelope does not hold the prints")


def _check_hull(gamut: HullGamut) -> None:
    _check_gap(gamut.tolerance, gamut.gap, gamut.gap_95, "of 95 % of the prints")


def _check_gap(tolerance: float, gap: float | None, second: float | None, which: str) -> None:
    """Hold a sampling gap, measured in two ways or not at all, against the tolerance that is never less."""
    _hold((gap is None) == (second is None), "the sampling gap is measured in one way and not in the other")
    _hold(0 <= (gap or 0.0) <= tolerance < np.inf, "the tolerance is less than the sampling gap, or not a number")
    _hold(0 <= (second or 0.0) < np.inf, f"the sampling gap {which} is below 0, or not a number")


def _check_inks(gamut: InkGamut) -> None:
    _hold(0 < gamut.tolerance < np.inf, "the tolerance is not above 0")
    _hold(gamut.device.printer is not None, "there is no printer whose inks are meant")


def _check_colorimetric(gamut: ColorimetricGamut) -> None:
    _check_gap(gamut.tolerance, gamut.gap, gamut.gap_delta_e, "in ΔE2000")
    beyond = gamut.colours @ gamut.normals.T - gamut.offsets
    _hold(np.all(beyond <= FACE_MISS), "a corner is outside a face")
    _hold(np.all(np.sum(beyond >= -FACE_MISS, axis=0) >= 3), "a face has fewer than three corners")
    _hold(gamut.violation(gamut.device.samples).max() <= FACE_MISS, "a print's colour is outside")


def _check_drive(gamut: MonitorGamut) -> None:
    _hold(np.linalg.matrix_rank(gamut.drive) == 3, "the drive values span no three colours")


TEXTS = ("name", "title", "provenance")
PRINTERS = {
    "dyes": Form(Dyes, _check_printer, {"densities": "ink band"}, ("most", "paper", "surface")),
    "halftone": Form(Halftone, _check_printer, {"primaries": "primary band", "gain": "ink"}, ("exponent", "most")),
}
PRINTS = {"samples": "print band", "amounts": "print ink", "extrapolated": "band"}
DEVICES = {
    "printer": Form(Device, _check_device, PRINTS, ("model_error",), texts=TEXTS),
    "monitor": Form(Monitor, _check_monitor, {"primaries": "3 3"}, texts=TEXTS),
}
SLABS = Form(Gamut, _check_slabs, {"lower": "band", "upper": "band", "weights": "band"}, texts=("model", "black"))
SOLID = {"colours": "corner 3", "normals": "face 3", "offsets": "face"}
GAMUTS = {
    "unit": SLABS,
    "envelope": SLABS,
    "hull": Form(HullGamut, _check_hull, {}, ("tolerance", "gap", "gap_95")),
    "inks": Form(InkGamut, _check_inks, {}, ("tolerance",)),
    "colorimetric": Form(
        ColorimetricGamut, _check_colorimetric, SOLID, ("tolerance", "gap", "gap_delta_e"), texts=("light",)
    ),
    "monitor": Form(MonitorGamut, _check_drive, {"drive": "3 band"}),
}
OPTIONAL = {"weights", "gap", "gap_95", "gap_delta_e"}
"""Arrays and numbers that a record may be without."""
CHOICES = {"black": ("clip", "luminance", "strict")}
"""The values that some texts are restricted to."""


def record_of_device(device: Device | Monitor, prefix: str, arrays: Arrays) -> Header:
    """A device's names and numbers; its arrays join the others, each name with a prefix.

    Examples
    --------
    >>> from symrt.device.monitors import load_monitor
    >>> arrays: Arrays = {}
    >>> record = record_of_device(load_monitor("srgb"), "device0_", arrays)
    >>> record["kind"], record["bands"]["kind"], list(arrays)
    ('monitor', 'rgb', ['device0_primaries'])
    """
    # A monitor is its bands and primaries.
    kind = "monitor" if isinstance(device, Monitor) else "printer"
    bands = {"kind": device.bands.kind, "centres": [float(centre).hex() for centre in device.bands.centres]}
    record: Header = {"kind": kind, "bands": bands} | _packed(device, DEVICES[kind], prefix, arrays)
    if isinstance(device, Monitor):
        return record

    # A printer has inks, and may have a forward model, of a kind that files know.
    record |= {"inks": list(device.inks), "modelled": bool(device.modelled), "printer": None}
    if device.printer is not None:
        known = [name for name, form in PRINTERS.items() if type(device.printer) is form.record]
        if not known:
            raise ValueError(
                f"{device.name}: its printer is a {type(device.printer).__name__}, and files hold "
                f"{' and '.join(PRINTERS)}: save the device without it, replace(device, printer=None)"
            )
        printer = _packed(device.printer, PRINTERS[known[0]], f"{prefix}printer_", arrays)
        record["printer"] = {"kind": known[0], "inks": list(device.printer.inks)} | printer
    return record


def device_of(record: Header, prefix: str, arrays: Arrays) -> Device | Monitor:
    """The device that `record_of_device` wrote; what it uses of the arrays is taken out of them.

    Raises
    ------
    ValueError, KeyError, TypeError
        If something is missing, or not what it must be.
    """
    bands = _bands(record["bands"])
    form = _form(DEVICES, record["kind"])
    if form.record is Monitor:
        return _unpacked(record, form, prefix, arrays, {"band": len(bands)}, bands=bands)
    printer = record["printer"] and _printer(record["printer"], bands, f"{prefix}printer_", arrays)
    inks = tuple(map(_text, record["inks"]))
    _hold(isinstance(record["modelled"], bool), "whether the prints are modelled is neither true nor false")
    sizes = {"band": len(bands), "ink": len(inks)}
    more = {"bands": bands, "inks": inks, "modelled": record["modelled"], "printer": printer or None}
    return _unpacked(record, form, prefix, arrays, sizes, **more)


def record_of_gamut(gamut: AnyGamut, device: int, prefix: str, arrays: Arrays) -> Header:
    """A gamut's names and numbers, with the place of its device among the devices."""
    return {"model": gamut.model, "device": device} | _packed(gamut, GAMUTS[gamut.model], prefix, arrays)


def gamut_of(record: Header, devices: list[Device | Monitor], prefix: str, arrays: Arrays) -> AnyGamut:
    """The gamut that `record_of_gamut` wrote; what it uses of the arrays is taken out of them.

    Raises
    ------
    ValueError, KeyError, TypeError
        If something is missing, or not what it must be.
    """
    form, number = _form(GAMUTS, record["model"]), record["device"]
    _hold(type(number) is int and 0 <= number < len(devices), f"there is no device {shown(number)}")
    device = devices[number]
    of = "monitor" if form.record is MonitorGamut else "device"
    _hold((of == "monitor") == isinstance(device, Monitor), f"{record['model']} is no gamut of {device.name[:60]}")
    return _unpacked(record, form, prefix, arrays, {"band": len(device.bands)}, **{of: device})


def _packed(thing: Any, form: Form, prefix: str, arrays: Arrays) -> Header:
    given = {name: getattr(thing, name) for name in form.arrays}
    arrays |= {f"{prefix}{name}": array for name, array in given.items() if array is not None}
    numbers = {name: getattr(thing, name) for name in form.numbers}
    texts = {name: getattr(thing, name) for name in form.texts}
    return texts | {name: None if number is None else float(number).hex() for name, number in numbers.items()}


def _unpacked(record: Header, form: Form, prefix: str, arrays: Arrays, sizes: dict[str, int], **more: Any) -> Any:
    sizes = {"3": 3, "primary": 2 ** min(sizes.get("ink", 0), 63)} | sizes
    parts: dict[str, Any] = {name: _text(record[name]) for name in form.texts}
    for name in CHOICES.keys() & parts.keys():
        _hold(parts[name] in CHOICES[name], f"{name} is {shown(parts[name])}, none of {', '.join(CHOICES[name])}")
    unmeasured = {name for name in form.numbers if name in OPTIONAL and record[name] is None}
    parts |= {name: None if name in unmeasured else float.fromhex(_text(record[name])) for name in form.numbers}
    for name, axes in form.arrays.items():
        if f"{prefix}{name}" in arrays or name not in OPTIONAL:
            parts[name] = _shaped(f"{prefix}{name}", arrays.pop(f"{prefix}{name}"), axes, sizes)
    made = form.record(**parts, **more)
    form.check(made)
    return made


def _shaped(name: str, array: np.ndarray, axes: str, sizes: dict[str, int]) -> np.ndarray:
    """The array, if it is of its type, finite, and as long on every axis as others are on the same one."""
    kind = np.bool_ if name.endswith("extrapolated") else np.float64
    _hold(array.dtype == kind and np.all(np.isfinite(array)), f"{name} does not hold finite {np.dtype(kind)} numbers")
    names = axes.split()
    if array.ndim == len(names):
        for axis, length in zip(names, array.shape, strict=True):
            sizes.setdefault(axis, length)
    wanted = tuple(sizes.get(axis, 0) for axis in names)
    _hold(array.shape == wanted, f"{name} is {array.shape}, not {wanted}: {' by '.join(names)}")
    return array


def _printer(record: Header, bands: Bands, prefix: str, arrays: Arrays) -> Any:
    inks = tuple(map(_text, record["inks"]))
    sizes = {"band": len(bands), "ink": len(inks)}
    return _unpacked(record, _form(PRINTERS, record["kind"]), prefix, arrays, sizes, bands=bands, inks=inks)


def _bands(record: Header) -> Bands:
    centres, kind = tuple(float.fromhex(_text(c)) for c in record["centres"]), record["kind"]
    _hold(kind in ("wavelength", "rgb", "coordinate"), f"bands of kind {shown(kind)}")
    bands = Bands(centres, kind)
    _hold(kind != "rgb" or bands == RGB, "RGB has the bands 0, 1 and 2")
    _hold(kind != "coordinate" or bands == coordinates(len(bands)), "coordinates are counted from 0")
    return bands


def _form(forms: Mapping[str, Form], name: Any) -> Form:
    _hold(isinstance(name, str) and name in forms, f"{shown(name)} is none of {', '.join(forms)}")
    return forms[name]


def _text(value: Any) -> str:
    _hold(isinstance(value, str), f"{shown(value)} is not a text")
    return str(value)


def _hold(condition: Any, otherwise: str) -> None:
    if not condition:
        raise ValueError(otherwise)
