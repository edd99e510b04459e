"""Commands on a scene: its plan, a probe, a pixel's formula, a picture, the demo (steps 1 to 3)."""

from dataclasses import asdict
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Annotated, Any

import typer

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import against, formula_of, palette_of, scene_of, system_of
from symrt.commands.outputs import apart, writable
from symrt.commands.saying import say
from symrt.disk import write_whole
from symrt.reading import shipped_scenes
from symrt.show.writing import json_text

if TYPE_CHECKING:
    from symrt.tracing import Planned

WIDEST = 2048
"""Pixels across a scene in a gallery."""


def plan(
    scene: option.SceneFile,
    without: option.Without = None,
    tolerance: option.Thrift = None,
    probe: Annotated[
        bool, typer.Option("--probe/--no-probe", help="Cast a few rays to tell what it will cost.")
    ] = True,
    as_json: option.Json = False,
) -> None:
    """The effects that a scene calls for, with their reasons.

    Example: symrt plan globe
    """
    found = rt.plan(rt.load_scene(scene), force=dict.fromkeys(without or (), False), tolerance=tolerance, probe=probe)
    if as_json:
        expected = None if found.expectation is None else asdict(found.expectation)
        effects = [_record(effect) for effect in found.effects]
        say(json_text({"effects": effects, "expected": expected, "remarks": list(found.remarks)}))
    else:
        say(str(found))


def _record(effect: "Planned") -> dict[str, Any]:
    """An effect of a plan for a program to read."""
    called_by, because = list(effect.called_by), effect.why
    of = {"effect": effect.name, "state": effect.state, "simulated": effect.simulated}
    return of | {"called by": called_by, "because": because, "rays at most": effect.rays}


def probe(
    scene: option.SceneFile,
    rays: Annotated[int, typer.Option("--rays", help="About how many rays.")] = 4096,
    as_json: option.Json = False,
) -> None:
    """Statistics of the lights and materials that a few rays meet.

    Example: symrt probe globe --rays 1024
    """
    found = rt.probe(rt.load_scene(scene), rays=rays)
    record = {"rays": found.rays, "mirrored": found.mirrored, "hidden": found.hidden}
    record |= {"meetings": [asdict(meeting) for meeting in found.meetings]}
    record |= {"branches": [asdict(branching) for branching in found.branches]}
    say(json_text(record) if as_json else str(found))


def formula(  # noqa: PLR0913, PLR0917  # a command names its options
    source: option.Source,
    column: Annotated[int | None, typer.Argument(metavar="X", help="Column from the left, from 0.")] = None,
    row: Annotated[int | None, typer.Argument(metavar="Y", help="Row from the top, from 0.")] = None,
    x: Annotated[int | None, typer.Option("--x", help="The same as X.")] = None,
    y: Annotated[int | None, typer.Option("--y", help="The same as Y.")] = None,
    collapsed: Annotated[bool, typer.Option("--collapsed", help="After the collapse, also from a scene.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="As LaTeX.")] = False,
    python: Annotated[bool, typer.Option("--python", help="As a Python function, every digit kept.")] = False,
    size: option.Size = None,
    as_json: option.Json = False,
) -> None:
    """The formula of one pixel.

    Of a scene with the geometry in letters, of a rendered system the linear form.

    Example: symrt formula globe 210 140
    """
    x, y = _coordinate(column, x, "X"), _coordinate(row, y, "Y")
    found = formula_of(source, size, x, y, collapsed)
    if as_json:
        record = {"x": x, "y": y, "text": found.text(digits=17), "latex": found.latex(), "python": found.code()}
        say(json_text(record | {"symbols": list(found.symbols), "values": found.letters}))
    else:
        say(found.latex() if latex else found.code() if python else str(found))


def _coordinate(given: int | None, named: int | None, name: str) -> int:
    """The column or row of a pixel, given either by position on the command line or by name."""
    found = named if given is None else given
    if found is None or (given is not None and named is not None):
        how = "nowhere" if found is None else "twice"
        raise ValueError(f"the pixel's {name} is given {how}: write for example symrt formula globe 210 140")
    return found


def shade(
    source: option.Source,
    out: Annotated[Path | None, typer.Option("--out", "-o", help=".png, .tif, .npz or .exr.")] = None,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    exposure: option.Exposure = 1.0,
    reference: option.Reference = None,
    white_of: option.WhiteOf = None,
    size: option.Size = None,
) -> None:
    """Make a picture with a palette.

    White is the palette's own if it carries one, or else the key light's, however dim that is: --white-of fixes it.

    Example: symrt shade globe.npz --palettes globe --palette macbeth --out globe.png
    """
    # Words that cannot be obeyed are refused before any work.
    if reference is not None and white_of is not None:
        raise ValueError("--reference and --white-of both choose the white: give one of them")
    spectra = palette_of(source, palettes, palette)
    out = writable(out or Path(f"{Path(source).stem}.png"), *option.PICTURES, form="")
    apart({"--out": out}, [source, palettes])

    # Shade the system, and write the picture against its white.
    system = system_of(source, size)
    if white_of is not None:
        spectra = against(system, spectra, source, palettes, white_of)
    image = rt.shade(system, spectra)
    white = rt.Reference(reference).white(system, spectra) if reference else None
    rt.save_image(out, image, exposure=exposure, white=white)
    say(f"{out}: {image!r}, shaded in {image.seconds:.3f} s")


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the pictures and tables.")] = Path("out"),
    size: Annotated[str, typer.Option("--size", metavar="W[xH]", help="Pixels.")] = "512",
    scene: Annotated[str, typer.Option("--scene", help="A scene with palettes in RGB and in wavelengths.")] = "globe",
) -> None:
    """Write the paper's Figures 1, 2 and 3 into a folder.

    With them go a table of feasible ranges, one pixel's formula, the times, and a page that shows all of it.

    Example: symrt demo --out out
    """
    from symrt.show.demo import write_demo  # noqa: PLC0415  # slow, and --help does not need it

    for product in write_demo(out, scene_of(scene, size), rt.load_palettes(scene)):
        say(f"{product.path}: {shorten(product.caption, 140, placeholder=' …')}")


def gallery(
    scenes: Annotated[list[str] | None, typer.Argument(metavar="[SCENE]...", help="All that come with symrt.")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="A .png.")] = Path("gallery.png"),
    width: Annotated[int, typer.Option("--width", help="Pixels across each scene.")] = 320,
    samples: Annotated[int, typer.Option("--samples", help="Samples along each side of a pixel.")] = 2,
) -> None:
    """Render scenes into one picture, each with the effects that it calls for.

    Example: symrt gallery --out gallery.png
    """
    # Words that cannot be obeyed are refused before any work.
    if not 1 <= width <= WIDEST:
        raise ValueError(f"--width {width}: give a number of pixels from 1 to {WIDEST}")
    writable(out, ".png")
    apart({"--out": out}, scenes or ())

    from symrt.show.gallery import exhibits  # noqa: PLC0415  # slow, and --help does not need it
    from symrt.show.plots import gallery_figure, png  # noqa: PLC0415

    shown = list(exhibits(scenes or list(shipped_scenes()), width, samples))
    if not scenes:
        # Those that call for least come first.
        shown.sort(key=lambda one: (len(one.effects), one.name))
    write_whole(out, png(gallery_figure(shown)))
    for one in shown:
        say(f"{one.name}: {', '.join(one.effects) or 'light and shadow alone'}; {one.seconds:.2f} s")
    say(f"{out}: {len(shown)} scenes")
