"""Scenes, systems, palettes, devices and parameters from the words on a command line.

A word that is wrong is refused in one line, with the word to write instead.  Nothing slow is imported here.
"""

import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import symrt as rt
from symrt.errors import shown, suggestion

if TYPE_CHECKING:
    from symrt.device.monitors import Monitor
    from symrt.device.printing import Device
    from symrt.feedback.parameters import Parameter, Scale
    from symrt.gamut.gamuts import AnyGamut
    from symrt.gamut.intersections import AnyIntersection
    from symrt.linear.formulas import Formula
    from symrt.scene.records import Scene
    from symrt.spectra.bands import Bands
    from symrt.spectra.palette import Palette
    from symrt.system import LinearSystem


def is_file(word: str) -> bool:
    """True if a word is the path of a system or gamut saved as ``.npz``, and not a scene or a name.

    Examples
    --------
    >>> is_file("out/globe.npz"), is_file("globe")
    (True, False)
    """
    return Path(word).suffix.lower() == ".npz"


def size_of(word: str, shape: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a picture; if only the width is given, in the proportions of `shape`.

    Examples
    --------
    >>> size_of("640x480", (1, 1)), size_of("512", (400, 300))
    ((640, 480), (512, 384))
    """
    from symrt.scene.camera_checks import LARGEST  # noqa: PLC0415  # slow, and --help does not need it

    found = re.fullmatch(r"([0-9]{1,5})(?:[x×]([0-9]{1,5}))?", word)
    if not found:
        raise ValueError(f"--size {shown(word)}: give a width such as 512, or width and height such as 640x480")
    width = int(found[1])
    height = int(found[2]) if found[2] else max(1, round(width * shape[1] / shape[0]))
    if not (0 < width <= LARGEST and 0 < height <= LARGEST):
        raise ValueError(f"--size {word}: a picture has from 1 to {LARGEST} pixels on a side")
    return width, height


def scene_of(word: str, size: str | None = None, samples: int | None = None) -> "Scene":
    """The scene of a file or name, with another size or number of samples if they are given."""
    if is_file(word):
        raise ValueError(f"{word}: a rendered system stands here where a scene is needed: give its .toml file")
    scene = rt.load_scene(word)
    camera = scene.camera
    if size is not None:
        width, height = size_of(size, (camera.width, camera.height))
        camera = replace(camera, width=width, height=height)
    if samples is not None:
        camera = replace(camera, samples=samples)
    return scene if camera is scene.camera else replace(scene, camera=camera)


def system_of(word: str, size: str | None = None, asked: Sequence["Parameter"] = ()) -> "LinearSystem":
    """A saved system, or a scene rendered now, with the alternatives that blends among the parameters `asked` need."""
    if not is_file(word):
        scene = scene_of(word, size)
        return rt.render(scene, alternatives=alternatives_of(scene, asked))
    if size is not None:
        raise ValueError(f"--size {size}: {word} has its size already: render the scene again at another")
    return rt.load_system(word)


def alternatives_of(scene: "Scene", asked: Sequence["Parameter"]) -> dict[str, list[str]]:
    """The alternatives that `trace` must record for blends of materials that differ in more than their spectra."""
    made = {material.name: (material.model, dict(material.parameters)) for material in scene.materials}
    pairs = [(one.material, one.other) for one in asked if isinstance(one, rt.Blend) and one.mixing == "linear"]
    found: dict[str, list[str]] = {}
    for material, other in dict.fromkeys(pairs):
        if material in made and other in made and made[material] != made[other]:
            found.setdefault(material, []).append(other)
    return found


def pairs_of(words: Sequence[str]) -> dict[str, list[str]]:
    """For each material the others that it may be blended with, from words such as ``brass:deep``.

    Examples
    --------
    >>> pairs_of(["brass:deep", "brass:ice"])
    {'brass': ['deep', 'ice']}
    """
    found: dict[str, list[str]] = {}
    for word in words:
        material, _, other = word.partition(":")
        if not (material and other):
            raise ValueError(f"--alternative {shown(word)}: write FROM:TO, two materials, such as brass:deep")
        found.setdefault(material, []).append(other)
    return found


def palette_of(source: str, file: str | None = None, name: str | None = None) -> "Palette":
    """The palette of a given name, or the only one there is, from a file or from the scene itself."""
    if file is None and is_file(source):
        raise ValueError(f"{source} holds no spectra: add --palettes FILE, such as the scene it was rendered from")
    where = source if file is None else file
    palettes = rt.load_palettes(where)
    if name is None and len(palettes) == 1:
        return next(iter(palettes.values()))
    if name is None:
        raise ValueError(f"{where} has several palettes: choose one with --palette: {', '.join(palettes)}")
    if name not in palettes:
        raise ValueError(f"--palette {shown(name)}: {where} has none of this name; {suggestion(name, palettes)}")
    return palettes[name]


def against(
    system: "LinearSystem", palette: "Palette", source: str, file: str | None, name: str, resample: bool = False
) -> "Palette":
    """The palette with the white of another palette of the same file under the scene's lights."""
    palettes = rt.load_palettes(source if file is None else file)
    if name not in palettes:
        raise ValueError(
            f"--white-of {shown(name)}: {file or source} has none of this name; {suggestion(name, palettes)}"
        )
    other = palettes[name].on(palette.bands) if resample else palettes[name]
    if other.bands != palette.bands:
        raise ValueError(
            f"--white-of {shown(name)}: it is in {other.bands!r} and the palette in {palette.bands!r}: name one on the "
            "same bands"
        )
    return replace(palette, white=rt.Reference().white(system, other))


class Kind(NamedTuple):
    """A choice among the gamuts of a device; fields that are None follow the library."""

    model: str | None = None
    black: str | None = None
    light: str | None = None
    tolerance: float | None = None
    mode: str | None = None

    def options(self, model: str) -> dict[str, Any]:
        """The light and the tolerance, if the model takes them."""
        takes = {"light": ("colorimetric",), "tolerance": ("hull", "inks", "colorimetric")}
        given = {name: value for name in takes if (value := getattr(self, name)) is not None}
        for name in given:
            if model not in takes[name]:
                raise ValueError(f"--{name}: only for --model {' or '.join(takes[name])}, and this is {model}")
        return given


def gamut_of(word: str, kind: Kind = Kind(), bands: "Bands | None" = None) -> "AnyGamut | AnyIntersection":  # noqa: B008
    """A saved gamut, the gamut of a device, or the intersection of those of several devices joined by ``+``.

    If `kind` leaves it open, a printer's gamut is its envelope with black clipped.

    Parameters
    ----------
    bands
        The palette's bands: a monitor shows any, a printer must have them.
    """
    words = _joined(word)
    found = [_one_gamut(one, kind, bands, several=len(words) > 1) for one in words]
    return found[0] if len(found) == 1 else rt.intersection(found)


def _joined(word: str) -> list[str]:
    return [word] if Path(word).exists() else word.split("+")


def bands_of(word: str, mode: str | None = None) -> "Bands":
    """The bands that a palette must have for a device: those of the first of several that is no monitor."""
    words = _joined(word)
    for one in words:
        found = rt.load_gamut(one) if is_file(one) else _device(one, mode, several=len(words) > 1)
        if not hasattr(found, "primaries"):
            return found.bands
    raise ValueError(f"--resample: {word} is a monitor, which shows spectra on any bands: leave it out")


def _device(word: str, mode: str | None, *, several: bool) -> "Device | Monitor":
    """The device of a name or file; if it is one of several, a mode applies to charts only."""
    return rt.load_device(word, mode=None if several and word in rt.devices() else mode)


def _one_gamut(word: str, kind: Kind, bands: "Bands | None", *, several: bool) -> "AnyGamut | AnyIntersection":
    """A saved gamut, or the gamut of one device; if it is one of several, a choice applies to printers only."""
    # A saved gamut leaves nothing to choose.
    if is_file(word):
        if any(value is not None for value in kind):
            raise ValueError(
                f"{word}: a saved gamut has its model and all that goes with it: leave out --model, --black, "
                "--light, --tolerance and --mode"
            )
        return rt.load_gamut(word)

    # A monitor has one gamut, and no black of its own.
    device = _device(word, kind.mode, several=several)
    if hasattr(device, "primaries"):
        if kind.black and not several:
            raise ValueError(f"--black {kind.black}: {word} is a monitor, whose black is black: leave it out")
        model = (not several and kind.model) or "monitor"
        options = {} if several else kind.options(model)
        return rt.device_gamut(device.on(bands) if bands else device, model, **options)

    # A printer must have the palette's bands; inks need a printer, which is fitted where a chart has none.
    if bands and device.bands != bands:
        raise ValueError(_other_bands(word, device.bands, bands))
    if kind.model == "inks" and device.printer is None and device.inks:
        fitted = rt.fit_halftone(device)
        warnings.warn(f"{word}: {fitted!r} stands for the printer", stacklevel=2)
        device = fitted.device
    model = kind.model or "envelope"
    return rt.device_gamut(device, model, kind.black or "clip", **kind.options(model))


def _other_bands(word: str, own: "Bands", bands: "Bands") -> str:
    """The message for a palette whose bands are not the device's, with the line that would mend it."""
    if own.kind != bands.kind or own.kind != "wavelength":
        return f"{word} is in {own!r} and the palette in {bands!r}: choose a palette in wavelengths with --palette"
    steps = {round(b - a, 9) for a, b in pairwise(own.centres)}
    numbers = [own.centres[0], own.centres[-1], *steps] if len(steps) == 1 else list(own.centres)
    written = ", ".join(f"{number:g}" for number in numbers)
    how = f"add --resample, or write bands = [{written}] in the palette"
    return f"{word} is in {own!r} and the palette in {bands!r}: {how}"


def gamuts_of(
    device: str, models: Sequence[str], monitor: str, bands: "Bands", asked: Kind
) -> "list[AnyGamut | AnyIntersection]":
    """Several gamuts of a device, and a monitor's; a light and a tolerance go to the models that take one."""
    kinds = [
        Kind(
            model,
            light=asked.light if model == "colorimetric" else None,
            tolerance=asked.tolerance if model in {"hull", "inks"} else None,
            mode=asked.mode,
        )
        for model in models
    ]
    return [*(gamut_of(device, kind, bands) for kind in kinds), gamut_of(monitor, Kind("monitor"), bands)]


def formula_of(source: str, size: str | None, x: int, y: int, collapsed: bool) -> "Formula":
    """The formula of a pixel: of a scene with the geometry in letters or collapsed, of a system the linear form."""
    if is_file(source):
        return rt.formula(system_of(source, size), x=x, y=y)
    scene = scene_of(source, size)
    before = rt.formula(scene, x=x, y=y)
    if not collapsed:
        return before
    return rt.formula(rt.collapse(rt.trace(scene, window=(x, y, x + 1, y + 1))), x=0, y=0)


def parameter_of(word: str) -> "Parameter":
    """A parameter from ``scale:brass``, ``scale:brass.specular``, ``scale:sun`` or ``blend:sea:ice``.

    ``blend:sea:ice:kubelka-munk`` mixes the two as paints; ``exposure`` is the factor on all lights.

    Examples
    --------
    >>> parameter_of("scale:brass")
    Scale(name='brass')
    """
    kind, *names = word.split(":")
    if word == "exposure":
        return rt.Exposure()
    if kind == "scale" and len(names) == 1 and names[0]:
        return rt.Scale(names[0])
    if kind == "blend" and len(names) in (2, 3) and all(names) and names[2:] in ([], ["linear"], ["kubelka-munk"]):
        return rt.Blend(*names)
    raise ValueError(
        f"--parameter {shown(word)}: write scale:NAME, such as scale:brass, or blend:FROM:TO, for paints "
        "blend:FROM:TO:kubelka-munk, or exposure"
    )


def scale_of(word: str) -> "Scale":
    """A scale from ``scale:NAME``; other parameters are refused."""
    found = parameter_of(word)
    if isinstance(found, rt.Scale):
        return found
    raise ValueError(f"--parameter {shown(word)}: only scales are fitted: write scale:NAME, such as scale:brass")
