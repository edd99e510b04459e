"""Commands on gamuts: facts of one, and one image through several (step 4 of the paper)."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import Kind, bands_of, gamut_of, gamuts_of, palette_of, system_of
from symrt.commands.outputs import apart, writable
from symrt.commands.questions import Picture, asking
from symrt.commands.saying import say
from symrt.show.writing import draw, json_text

if TYPE_CHECKING:
    from symrt.gamut.files import SavedGamut
    from symrt.gamut.gamuts import AnyGamut
    from symrt.gamut.intersections import AnyIntersection
    from symrt.spectra.palette import Palette
    from symrt.system import LinearSystem

DRAWN = (0, 1, 2)
"""Components that are drawn if no others are named."""
CHARTS = (".ti3", ".cxf", ".mxf", ".cgats", ".txt", ".csv")
"""Endings of files that hold a device."""


def gamut(  # noqa: PLR0913, PLR0917  # a command names its options
    source: Annotated[
        str | None, typer.Argument(metavar="[SCENE|SYSTEM]", help="Whose materials are asked about; if any.")
    ] = None,
    device: option.DeviceName = option.DEVICE,
    mode: option.Mode = None,
    model: option.ModelName = None,
    black: option.BlackName = None,
    light: option.ViewingLight = None,
    tolerance: option.Tolerance = None,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    within: option.Within = None,
    reference: option.Reference = None,
    exposure: option.Exposure = 1.0,
    components: option.Components = DRAWN,
    size: option.Size = None,
    resample: option.Resample = False,
    save: Annotated[Path | None, typer.Option(help="Write the gamut to a file (.npz).")] = None,
    plot: option.Plot = None,
    as_json: option.Json = False,
) -> None:
    """Facts of a gamut, or the place of a scene's materials in it.

    With a scene, each material's reflectance is scaled, and each blended with each other, in front of the reference
    light: the table says which part of each segment is inside, and --plot draws them in any three components.

    Example: symrt gamut globe --palette macbeth --device dye3-endura-premier --plot segments.png
    """
    # Files that cannot be written are refused before any work.
    for path, ending in ((save, ".npz"), (plot, ".png")):
        if path is not None:
            writable(path, ending, form="symrt-gamut")
    apart({"--save": save, "--plot": plot}, [source, palettes, device])

    kind = Kind(model, black, light, tolerance, mode)
    if source is None:
        # Without a scene: facts of the gamut, which no option on materials concerns.
        about: dict[str, object] = {
            "--palette": palette,
            "--palettes": palettes,
            "--within": within,
            "--reference": reference,
            "--size": size,
            "--resample": resample or None,
            "--exposure": None if exposure == 1 else exposure,
            "--components": None if components == DRAWN else components,
        }
        if given := [name for name, value in about.items() if value is not None]:
            raise ValueError(f"{given[0]} asks about a scene's materials: name the scene, such as symrt gamut globe")
        found = gamut_of(device, kind)
        said, text = _facts(found, plot)
    else:
        # With a scene: its materials' segments, in the gamut on the palette's bands.
        if source in rt.devices() or Path(source).suffix.lower() in CHARTS:
            raise ValueError(f"{source}: a device, where a scene or a system stands: write --device {source}")
        spectra = palette_of(source, palettes, palette)
        spectra = spectra.on(bands_of(device, mode)) if resample else spectra
        found = gamut_of(device, kind, spectra.bands)
        last = len(spectra.bands) - 1
        if len(set(components)) < 3 or not all(0 <= k <= last for k in components):
            raise ValueError(f"--components {' '.join(map(str, components))}: three different ones, from 0 to {last}")
        asked = {"within": within or (0.01, 3.0), "exposure": exposure}
        said, text = _segments(system_of(source, size), spectra, found, reference, asked, components, plot)

    if save is not None:
        rt.save_gamut(save, found)
    say(json_text(said) if as_json else text)


def _facts(found: "SavedGamut", plot: Path | None) -> tuple[dict[str, Any], str]:
    from symrt.show.records import gamut_facts  # noqa: PLC0415  # slow, and --help does not need it
    from symrt.show.tables import gamut_table  # noqa: PLC0415

    if plot is not None:
        draw(plot, "body_figure", found)
    facts = gamut_facts(found)
    return facts, gamut_table(facts)


def _segments(
    system: "LinearSystem",
    spectra: "Palette",
    found: "AnyGamut | AnyIntersection",
    reference: str | None,
    asked: dict[str, Any],
    components: tuple[int, int, int],
    plot: Path | None,
) -> tuple[dict[str, Any], str]:
    from symrt.show.records import segments_record  # noqa: PLC0415  # slow, as above
    from symrt.show.segments import diffuse_materials, segments_of  # noqa: PLC0415
    from symrt.show.study import materials  # noqa: PLC0415
    from symrt.show.tables import segments_table  # noqa: PLC0415
    from symrt.spectra.reference import key_light  # noqa: PLC0415

    light = reference or key_light(system, spectra)
    seen = [name for name in materials(system) if name in diffuse_materials(spectra)]
    segments = segments_of(found, spectra, seen, light=light, **asked)
    if plot is not None:
        draw(plot, "segments_figure", segments, components)
    return segments_record(segments), segments_table(segments)


@asking(Picture)
def report(  # a command names its options
    picture: Picture,
    model: option.Models = None,
    monitor: option.Monitor = "crt-brainard",
    light: option.ViewingLight = None,
    tolerance: option.Tolerance = None,
    plot: Annotated[Path | None, typer.Option(help="Map the pixels outside the first gamut (.png).")] = None,
    as_json: option.Json = False,
) -> None:
    """Take one image through several gamuts: who says yes, who no.

    Example: symrt report globe --palette macbeth --model envelope --model hull
    """
    models = model or ["unit", "envelope", "hull", "colorimetric"]
    kind = Kind(light=light, tolerance=tolerance, mode=picture.mode)
    gamuts = gamuts_of(picture.device, models, monitor, picture.given.bands, kind)
    if plot is not None:
        writable(plot, ".png")
    apart({"--plot": plot}, [*picture.read, monitor])
    system, spectra = picture.rendered()
    said = rt.report(system, spectra, gamuts, picture.seen)
    if plot is not None:
        draw(plot, "out_of_gamut_map", system, spectra, gamuts[0], picture.seen)
    say(json_text(asdict(said)) if as_json else str(said))
