"""Keep gamuts in files: one ``.npz`` of arrays, with names and numbers as JSON; nothing in it is executable.

Beside a header the file holds the arrays ``lower``, ``upper`` and, if the luminance of black is kept, ``weights`` of
the gamut; ``samples``, ``amounts`` and ``extrapolated`` of its device; and those of its printer, if it has one.
"""

import dataclasses
import json
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from symrt.gamut.charts import DAMAGE
from symrt.gamut.device import Device, Printer
from symrt.gamut.dyes import Dyes
from symrt.gamut.halftone import Halftone
from symrt.gamut.slabs import Gamut
from symrt.spectra.bands import Bands

__all__ = ["load_gamut", "save_gamut"]

FORMAT = "symrt-gamut"
VERSION = 1
LARGEST_MEMBER = 1 << 30
"""Bytes that one array of a file may unpack to; a file that claims more is refused before it is read."""
ARRAYS = ("samples", "amounts", "extrapolated")
TEXTS = ("name", "title", "provenance")
OF_PRINTER = "printer_"
PRINTERS: dict[str, type[Printer]] = {"dyes": Dyes, "halftone": Halftone}


def save_gamut(path: str | Path, gamut: Gamut) -> None:
    """Write a gamut, with its device, to one ``.npz`` file, which appears whole or not at all.

    Examples
    --------
    >>> import tempfile
    >>> from symrt.gamut.inks import load_device
    >>> from symrt.gamut.slabs import device_gamut
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_gamut(Path(folder) / "endura.npz", device_gamut(load_device("dye3-endura-premier"), "envelope"))
    ...     load_gamut(Path(folder) / "endura.npz").name
    'envelope of dye3-endura-premier, black clipped'
    """
    device = gamut.device
    header = {
        "format": FORMAT,
        "version": VERSION,
        "model": gamut.model,
        "black": gamut.black,
        "bands": [float(centre).hex() for centre in device.bands.centres],
        "kind": device.bands.kind,
        "modelled": device.modelled,
        "inks": device.inks,
        **{name: getattr(device, name) for name in TEXTS},
    }
    arrays = {name: getattr(device, name) for name in ARRAYS} | {"lower": gamut.lower, "upper": gamut.upper}
    for kind, model in PRINTERS.items():
        if isinstance(device.printer, model):
            numbers, more = _parts(device.printer)
            header |= {"printer": kind, "numbers": numbers, "printer_inks": device.printer.inks}
            arrays |= more
    if gamut.weights is not None:
        arrays["weights"] = gamut.weights
    path = Path(path)
    partial = path.with_name(path.name + ".partial")
    try:
        with partial.open("wb") as file:
            np.savez_compressed(
                file, allow_pickle=False, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays
            )
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def load_gamut(path: str | Path) -> Gamut:
    """Read a gamut that `save_gamut` wrote, bit for bit.

    Raises
    ------
    ValueError
        If the file is not such a gamut, is truncated, or its parts contradict each other.

    Examples
    --------
    >>> load_gamut("missing.npz")
    Traceback (most recent call last):
    ValueError: missing.npz: no such file; save a gamut with save_gamut first
    """
    path = Path(path)
    try:
        arrays, header = _read(path)
        return _gamut(arrays, header)
    except FileNotFoundError:
        raise ValueError(f"{path}: no such file; save a gamut with save_gamut first") from None
    except (*DAMAGE, TypeError, AttributeError, ValueError) as error:
        raise ValueError(f"{path}: not a whole symrt gamut ({error}); save it again with save_gamut") from error


def _read(path: Path) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    with zipfile.ZipFile(path) as archive:
        too_large = [info.filename for info in archive.infolist() if info.file_size > LARGEST_MEMBER]
    if too_large:
        raise ValueError(f"{too_large[0]} claims more than {LARGEST_MEMBER >> 30} GiB")
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays.pop("header").tobytes())
    if not isinstance(header, dict) or header.get("format") != FORMAT or header.get("version") != VERSION:
        raise ValueError(f"not of version {VERSION}")
    return arrays, header


def _gamut(arrays: dict[str, np.ndarray], header: dict[str, Any]) -> Gamut:
    bands = Bands(tuple(float.fromhex(c) for c in header["bands"]), header["kind"])
    _check_arrays(arrays, len(bands))
    if header["model"] not in ("unit", "envelope") or header["black"] not in ("clip", "luminance", "strict"):
        raise ValueError(f"model {header['model']!r} or black {header['black']!r} is unknown")
    if (header["black"] == "luminance") != ("weights" in arrays):
        raise ValueError("weights of luminance belong to black='luminance' and to nothing else")
    device: dict[str, Any] = {name: arrays[name] for name in ARRAYS}
    device |= {name: str(header[name]) for name in TEXTS} | {"inks": tuple(map(str, header["inks"]))}
    printer = _printer(arrays, header, bands) if "printer" in header else None
    return Gamut(
        model=header["model"],
        black=header["black"],
        device=Device(bands=bands, modelled=bool(header["modelled"]), printer=printer, **device),
        lower=arrays["lower"],
        upper=arrays["upper"],
        weights=arrays.get("weights"),
    )


def _parts(printer: Any) -> tuple[dict[str, str], dict[str, np.ndarray]]:
    """Numbers and arrays of a printer's record, but for bands and inks, which the header holds."""
    values = {f.name: getattr(printer, f.name) for f in dataclasses.fields(printer) if f.name not in ("bands", "inks")}
    arrays = {f"{OF_PRINTER}{name}": value for name, value in values.items() if isinstance(value, np.ndarray)}
    return {name: float(value).hex() for name, value in values.items() if f"{OF_PRINTER}{name}" not in arrays}, arrays


def _printer(arrays: dict[str, np.ndarray], header: dict[str, Any], bands: Bands) -> Printer:
    values: dict[str, Any] = {name: float.fromhex(value) for name, value in header["numbers"].items()}
    values |= {n.removeprefix(OF_PRINTER): array for n, array in arrays.items() if n.startswith(OF_PRINTER)}
    model: Any = PRINTERS[header["printer"]]
    return model(bands=bands, inks=tuple(map(str, header["printer_inks"])), **values)


def _check_arrays(arrays: dict[str, np.ndarray], bands: int) -> None:
    for name, array in arrays.items():
        if array.dtype != (np.bool_ if name == "extrapolated" else np.float64) or not np.all(np.isfinite(array)):
            raise ValueError(f"{name} does not hold finite float64 numbers")
    prints = len(arrays["samples"])
    one_a_band = ("lower", "upper", "extrapolated", "weights")
    shapes = {"samples": (prints, bands)} | dict.fromkeys(one_a_band, (bands,))
    for name, shape in shapes.items():
        if name in arrays and arrays[name].shape != shape:
            raise ValueError(f"{name} is {arrays[name].shape}, not {shape}")
    if prints == 0 or not np.all(arrays["lower"] <= arrays["upper"]):
        raise ValueError("there are no prints, or a lower bound is above the upper one")
