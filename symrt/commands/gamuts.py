"""Commands on gamuts: facts of one, and one image through several (step 4 of the paper)."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import gamut_of, gamuts_of, palette_of, system_of, writable
from symrt.explore.writing import draw, json_text

__all__ = ["gamut", "report"]


def gamut(
    device: Annotated[
        str,
        typer.Argument(
            metavar="DEVICE", help="A device, a chart's file, a gamut saved as .npz, or several joined by +."
        ),
    ] = option.DEVICE,
    model: option.ModelName = None,
    black: option.BlackName = None,
    save: Annotated[Path | None, typer.Option(help="Write the gamut to a file (.npz).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw it: as a body, as prints or as colours (.png).")] = None,
    as_json: option.Json = False,
) -> None:
    """Facts of a device's basis and gamut.

    Example: symrt gamut dye3-endura-premier --model envelope --plot gamut.png
    """
    for path, ending in ((save, ".npz"), (plot, ".png")):
        if path is not None:
            writable(path, ending)
    from symrt.explore.tables import gamut_facts, gamut_table  # noqa: PLC0415  # slow, and --help does not need it

    found = gamut_of(device, model, black)
    if plot is not None:
        draw(plot, "body_figure", found)
    if save is not None:
        rt.save_gamut(save, found)
    facts = gamut_facts(found)
    typer.echo(json_text(facts) if as_json else gamut_table(facts))


def report(  # noqa: PLR0913, PLR0917  # a command names its options
    source: option.Source,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    device: option.DeviceName = option.DEVICE,
    model: option.Models = None,
    monitor: option.Monitor = "crt-brainard",
    reference: option.Reference = None,
    exposure: option.Exposure = 1.0,
    size: option.Size = None,
    plot: Annotated[Path | None, typer.Option(help="Map the pixels outside the first gamut (.png).")] = None,
    as_json: option.Json = False,
) -> None:
    """Take one image through several gamuts: who says yes, who no.

    Example: symrt report globe --palette macbeth --model envelope --model hull
    """
    spectra = palette_of(source, palettes, palette)
    gamuts = gamuts_of(device, model or ["unit", "envelope", "hull", "colorimetric"], monitor, spectra.bands)
    if plot is not None:
        writable(plot, ".png")
    system, seen = system_of(source, size), rt.Reference(reference, exposure)
    said = rt.report(system, spectra, gamuts, seen)
    if plot is not None:
        draw(plot, "out_of_gamut_map", system, spectra, gamuts[0], seen)
    typer.echo(json_text(asdict(said)) if as_json else str(said))
