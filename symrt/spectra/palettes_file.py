"""Palettes in files: the half of a scene file that step 3 of the paper reads, and the other half's reader ignores.

```toml
[palettes.plain]
bands = [380, 730, 10]                # first, last and step in nm, or "rgb", or { centres = [ … ] }
sun = "illuminant/D65"                # a name of the library
sky = { spectrum = "illuminant/D65", scale = 0.3 }
"clay.diffuse" = "#c08a3e"            # a colour as the web writes it, encoded sRGB
"red.diffuse" = { rgb = [0.8, 0.1, 0.1] }
"red.specular" = 0.04                 # the same in all bands; or a list, one value a band
"gold.specular" = { file = "gold.csv" }   # two columns, nm and value, in the scene's folder
lamp = { peak = 400, width = 25, scale = 3 }   # a bell over nm: its middle, its width at half its height, its height
unphysical = true                     # permits reflectances above 1
reference-white = 0.3                 # radiance of the white it is seen against, as a light; else the key light's
[palettes.plain."ink.fluorescence"]   # a dye, or [[…]] for each of several
excitation = { peak = 460, width = 80 }
emission = { peak = 520, width = 50 }
efficiency = 0.8                      # the share of the energy taken in that is given back
```
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from symrt.arrays import Spectrum
from symrt.disk import write_whole
from symrt.errors import SceneError, refuse, require, shown, suggestion
from symrt.reading import number_faults, read_toml, scene_path
from symrt.spectra.bands import RGB, Bands, wavelengths
from symrt.spectra.fluorescence import Donaldson
from symrt.spectra.palette import Given, Palette
from symrt.spectra.sources import SOURCES, fluorescence_of, is_number, spectrum_of
from symrt.symbols import NAME, Symbol, named

WHITE = "reference-white"
KEYS = ("bands", "unphysical", WHITE)
"""Keys of a palette's table that are no symbols."""


class Palettes(dict[str, Palette]):
    """Palettes by name; one that is not there is named, with the nearest that is."""

    def __missing__(self, name: object) -> Palette:
        raise KeyError(f"no palette {shown(name)}: {suggestion(str(name), self)}")


def load_palettes(path: str | Path) -> Palettes:
    r"""The palettes of a file, by name; nothing else in the file is looked at.

    Raises
    ------
    SceneError
        With a line for everything that is wrong: the file, the key, the rule and the remedy.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "a.toml"
    ...     _ = file.write_text('[palettes.plain]\nbands = "rgb"\nsun = 1.0\n"red.diffuse" = [0.8, 0.1, 0.1]')
    ...     load_palettes(file)
    {'plain': Palette(RGB, sun, red.diffuse)}
    """
    # The tables, with numbers that can be used.
    path = scene_path(path)
    tables = read_toml(path).get("palettes")
    if not isinstance(tables, dict) or not tables:
        raise SceneError(f"{path}: palettes: there are none; add a table [palettes.plain] with bands and spectra")
    faults = [f"{path}: {key} {fault}" for key, fault in number_faults({"palettes": tables})]
    if faults:
        raise SceneError("\n".join(faults))

    # Each palette, and every fault.
    palettes = Palettes()
    for name, table in tables.items():
        try:
            palettes[name] = _palette(name, table, path.parent)
        except ValueError as error:
            faults += [f"{path}: palettes.{name if NAME.fullmatch(name) else shown(name)}: {e}" for e in _lines(error)]
    if faults:
        raise SceneError("\n".join(faults))
    return palettes


def save_palettes(path: str | Path, palettes: Mapping[str, Palette]) -> None:
    """Write palettes to a file of their own, whole or not at all; `load_palettes` gives the same bits back.

    Raises
    ------
    ValueError
        If a name is not one, or the file holds something else too, which would be lost.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "own.toml"
    ...     save_palettes(file, {"warm": load_palettes("first")["rgb"].replace(sun=[4.0, 3.0, 2.0])})
    ...     load_palettes(file)["warm"]["sun"]
    array([4., 3., 2.])
    """
    path = Path(path)
    require("palettes", palettes, (dict, Mapping), "palettes by name, {'plain': palette}")
    for palette in palettes.values():
        require("palette", palette, Palette, "Palette(bands, spectra) for each name")
    if wrong := [name for name in palettes if not NAME.fullmatch(name)]:
        raise ValueError(f"{shown(wrong[0])} cannot name a palette: a letter, then letters, digits and '_'")
    check_palettes_free(path, palettes)
    text = tomli_w.dumps({"palettes": {name: _table(palette) for name, palette in palettes.items()}})
    write_whole(path, text)


def check_palettes_free(path: Path, names: Iterable[str]) -> None:
    """Refuse to replace a file that holds a scene, or palettes of other names than those that are to be saved.

    Examples
    --------
    >>> check_palettes_free(Path("missing.toml"), ["warm"])
    """
    if not path.exists():
        return
    held = read_toml(path)
    if set(held) - {"palettes"}:
        raise ValueError(f"{path} holds a scene too, which would be lost: save the palettes to a file of their own")
    others = held.get("palettes", {})
    if lost := sorted(set(others) - set(names)) if isinstance(others, dict) else [others]:
        raise ValueError(
            f"{path} holds other palettes, which would be lost: {shown(lost)}: give another name, or save them too"
        )


def _palette(name: str, table: object, folder: Path) -> Palette:
    """One palette, or a ValueError with a line for each fault."""
    # A name and a table.
    if not NAME.fullmatch(name):
        raise SceneError("not a name: a letter, then letters, digits and '_'")
    if not isinstance(table, dict):
        raise SceneError(f"= {shown(table)}: a palette is a table [palettes.{name}] with bands and spectra")

    # Bands, spectra and white.
    bands = _bands(table.get("bands"))
    unphysical = table.get("unphysical", False)
    if not isinstance(unphysical, bool):
        raise SceneError(f"unphysical = {shown(unphysical)}: write true or false")
    spectra, faults = _spectra(table, bands, folder)
    white = None
    if (given := table.get(WHITE)) is not None:
        try:
            white = spectrum_of(Symbol(light="white"), given, bands, folder)
        except ValueError as error:
            faults += [f"{WHITE} = {shown(given)}: {line}" for line in _lines(error)]

    # All faults together: those of the file, then those of the palette itself.
    try:
        palette = Palette(bands, spectra, unphysical, white)
    except ValueError as error:
        refuse([*faults, *_lines(error)])
        raise
    refuse(faults)
    return palette


def _spectra(table: Mapping[str, Any], bands: Bands, folder: Path) -> tuple[dict[str, Given], list[str]]:
    """Spectra for a palette, by symbol, and a line for each symbol whose value cannot be used."""
    spectra: dict[str, Given] = {}
    faults = []
    for name, value in _symbols(table):
        # Each symbol once, however it is quoted.
        if name in spectra:
            faults.append(f"{_quoted(name)} is given twice, with quotes and without: keep one")
            continue

        # Its spectrum, or its faults.
        try:
            symbol = Symbol.of(name)
        except ValueError as error:
            faults += _lines(error)
            continue
        try:
            read = fluorescence_of if symbol.fluorescent else spectrum_of
            spectra[name] = read(symbol, value, bands, folder)
        except ValueError as error:
            faults += [f"{_quoted(name)} = {shown(value)}: {line}" for line in _lines(error)]
    return spectra, faults


def _bands(value: object) -> Bands:
    if value == "rgb":
        return RGB
    centres = value.get("centres") if isinstance(value, dict) and set(value) == {"centres"} else None
    if isinstance(centres, list) and all(map(is_number, centres)):
        return Bands(tuple(map(float, centres)))
    if isinstance(value, list) and len(value) == 3 and all(map(is_number, value)):
        return wavelengths(*value)
    what = "missing" if value is None else f"= {shown(value)}"
    raise SceneError(f'bands {what}: give first, last and step in nm, such as [380, 730, 10], or "rgb"')


def _symbols(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Symbols and values; ``red.diffuse`` without quotes is the same, although TOML reads a table in a table."""
    for key, value in table.items():
        if key in KEYS:
            continue
        if isinstance(value, dict) and value and not set(value) & {*SOURCES, "scale"} and not _fluorescent(key):
            yield from ((named(key, component), inner) for component, inner in value.items())
        else:
            yield key, value


def _fluorescent(key: str) -> bool:
    try:
        return Symbol.of(key).fluorescent
    except ValueError:
        return False


def _table(palette: Palette) -> dict[str, Any]:
    if palette.bands == RGB:
        bands: Any = "rgb"
    else:
        bands = _evenly(palette.bands) or {"centres": [float(c) for c in palette.bands.centres]}
    spectra = {name: _kept(palette.held(name)) for name in palette}
    fixed = {} if palette.white is None else {WHITE: np.asarray(palette.white).tolist()}
    return {"bands": bands, **({"unphysical": True} if palette.unphysical else {}), **fixed, **spectra}


def _kept(held: Spectrum | Donaldson) -> Any:
    """A spectrum or a fluorescence as a file holds it, to the last bit."""
    if isinstance(held, Donaldson):
        keys = ("excitation", "emission")
        dyes = [dict(zip(keys, map(_kept, dye), strict=True)) | {"per_nm": True} for dye in held.dyes]
        return dyes or {"matrix": held.matrix.tolist()}
    return float(held[0]) if np.all(held == held[0]) else held.tolist()


def _evenly(bands: Bands) -> list[float] | None:
    """First, last and step, if exactly these bands come back from them."""
    if len(bands) < 2:
        return None
    first, last, step = float(bands.centres[0]), float(bands.centres[-1]), float(bands.centres[1] - bands.centres[0])
    steps = (last - first) / step
    same = steps == round(steps) and wavelengths(first, last, step) == bands
    return [first, last, step] if same else None


def _quoted(symbol: str) -> str:
    return json.dumps(symbol[:80], ensure_ascii=False)


def _lines(error: ValueError) -> list[str]:
    return str(error).splitlines()
