"""Keep gamuts of every model in files, one documented format: a ``.npz`` of arrays, with names and numbers as JSON.

The header is an object of

``format``, ``version``
    ``"symrt-gamut"``, 2.
``devices``
    The printers and monitors, each once: their kind, name, title, provenance and bands (kind, and centres); for a
    printer its inks, whether its prints are modelled, and its forward model or null: kind, inks and numbers.
``gamuts``
    Model, device (its place in the list above) and numbers of each; several are the parts of their intersection.
``digest``
    SHA-256 over the header without it, with sorted keys, then the name, type, shape and bytes of each array, by name.

Numbers are hexadecimal text, as `float.hex` writes them.  Arrays are ``device0_samples``, ``device0_printer_gain``,
``gamut0_upper`` …: which there are, and their axes, `symrt.gamut.records` says in one table.
"""

from pathlib import Path

from symrt.archives import Kind, digest, read_archive, whole, write_archive
from symrt.device.monitors import Monitor
from symrt.device.printing import Device
from symrt.gamut.gamuts import AnyGamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import AnyIntersection, UnevenGamut, intersection
from symrt.gamut.monitor import MonitorGamut
from symrt.gamut.records import GAMUTS, Arrays, Header, device_of, gamut_of, record_of_device, record_of_gamut

KIND = Kind("gamut", 3, "save a gamut with save_gamut first", "save it again with save_gamut")
SavedGamut = ConvexGamut | UnevenGamut
LARGEST = 1 << 30
"""Bytes that the arrays of a file may unpack to; a file that claims more is refused before it is read."""


def save_gamut(path: str | Path, gamut: SavedGamut) -> None:
    """Write a gamut of any model, or an intersection, with its devices, to one ``.npz`` file.

    It appears whole or not at all.

    Raises
    ------
    ValueError
        If the gamut, or the model of its printer, is of a kind that files do not hold.

    Examples
    --------
    >>> import tempfile
    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_gamut(Path(folder) / "endura.npz", device_gamut(load_device("dye3-endura-premier"), "envelope"))
    ...     load_gamut(Path(folder) / "endura.npz").name
    'envelope of dye3-endura-premier, black clipped'
    """
    arrays: Arrays = {}
    parts = [_known(part) for part in (gamut.parts if isinstance(gamut, AnyIntersection) else (gamut,))]
    devices = list({id(device): device for device in map(_device, parts)}.values())
    places = [next(i for i, device in enumerate(devices) if device is _device(part)) for part in parts]
    header: Header = {
        "devices": [record_of_device(device, f"device{i}_", arrays) for i, device in enumerate(devices)],
        "gamuts": [record_of_gamut(part, places[i], f"gamut{i}_", arrays) for i, part in enumerate(parts)],
    }
    write_archive(path, KIND, header, arrays)


def load_gamut(path: str | Path) -> SavedGamut:
    """Read a gamut that `save_gamut` wrote: it answers like the one that was saved, bit for bit.

    Raises
    ------
    ValueError
        In one line, if the file is not such a gamut, is truncated or was changed, or its parts contradict each other.

    Examples
    --------
    >>> load_gamut("missing.npz")
    Traceback (most recent call last):
    ValueError: missing.npz: no such file; save a gamut with save_gamut first
    """
    with whole(path, KIND):
        arrays, header = read_archive(path, KIND, LARGEST)
        kept = {name: header[name] for name in ("devices", "gamuts")}
        if header["digest"] != digest(kept, arrays):
            raise ValueError("it was changed after it was saved: its digest is another")
        devices = [device_of(record, f"device{i}_", arrays) for i, record in enumerate(kept["devices"])]
        gamuts = [gamut_of(record, devices, f"gamut{i}_", arrays) for i, record in enumerate(kept["gamuts"])]
        if arrays:
            raise ValueError(f"{min(arrays)} belongs to nothing")
        return intersection(gamuts)


def _known(gamut: SavedGamut) -> AnyGamut:
    if not isinstance(gamut, AnyGamut):
        kinds = f"{', '.join(GAMUTS)} and intersections"
        raise ValueError(f"a {type(gamut).__name__} is not saved: files hold {kinds}")  # noqa: TRY004 -- a bad choice
    return gamut


def _device(gamut: AnyGamut) -> Device | Monitor:
    return gamut.monitor if isinstance(gamut, MonitorGamut) else gamut.device
