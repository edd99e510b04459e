"""The command line: the same verbs as the library, one thin function a command.

Nothing slow is imported before a command needs it, so that ``symrt --help`` answers at once.  Bad input ends in one
line a fault on standard error and exit code 2; results go to standard output, progress to standard error.
"""

import sys
import warnings
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from textwrap import shorten
from typing import Annotated, Any

import typer

import symrt as rt
from symrt.explore import options as option
from symrt.explore.arguments import (
    formula_of,
    gamut_of,
    gamuts_of,
    palette_of,
    parameter_of,
    scale_of,
    scene_of,
    system_of,
    writable,
)
from symrt.explore.writing import draw, json_text

__all__ = ["main"]

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode=None)

# Whatever class the installed typer derives its usage errors from: click's own, or a copy of it.
USAGE_ERROR: Any = next(kind for kind in reversed(typer.BadParameter.__mro__) if hasattr(kind, "format_message"))
BAD_INPUT, INTERRUPTED = 2, 130
LONGEST = 300
"""Letters of a fault's line; what was given may be longer."""
PICTURES = (".png", ".tif", ".tiff", ".npz", ".exr")
DEVICE = "dye3-endura-premier"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0, 2 for bad input, 130 when interrupted.

    Examples
    --------
    >>> main(["--version"])
    symrt 0.1.0
    0
    """
    try:
        with warnings.catch_warnings():
            warnings.showwarning = _warned
            words = sys.argv[1:] if arguments is None else list(arguments)
            return int(app(words or ["--help"], prog_name="symrt", standalone_mode=False) or 0)
    except (KeyboardInterrupt, typer.Abort):
        return INTERRUPTED
    except USAGE_ERROR as error:
        return _refused(error.format_message())
    except OSError as error:
        return _refused(f"{error.filename}: {error.strerror}" if error.filename else str(error))
    except (ValueError, MemoryError) as error:
        return _refused(str(error))


def _show_version(asked: bool) -> bool:
    if asked:
        typer.echo(f"symrt {rt.__version__}")
        raise typer.Exit
    return asked


@app.callback()
def start(
    version: Annotated[  # its callback answers
        bool, typer.Option("--version", help="Show the version and exit.", is_eager=True, callback=_show_version)
    ] = False,
) -> None:
    """Render a scene once, with every light and material left free; then ask.

    Example: symrt demo --out out
    """


@app.command()
def plan(scene: option.SceneFile, as_json: option.Json = False) -> None:
    """Which effects a scene calls for, and by what.

    Example: symrt plan globe
    """
    found = rt.plan(rt.load_scene(scene))
    keys = ("effect", "simulated", "because", "rays at most")
    record = [dict(zip(keys, effect.row, strict=True)) | {"simulated": effect.simulated} for effect in found.effects]
    typer.echo(json_text(record) if as_json else str(found))


@app.command()
def probe(
    scene: option.SceneFile,
    rays: Annotated[int, typer.Option("--rays", help="About how many rays.")] = 4096,
    as_json: option.Json = False,
) -> None:
    """What a few rays meet: lights, materials, bounces.

    Example: symrt probe globe --rays 1024
    """
    found = rt.probe(rt.load_scene(scene), rays=rays)
    record = {"rays": found.rays, "mirrored": found.mirrored, "hidden": found.hidden}
    record |= {"meetings": [asdict(meeting) for meeting in found.meetings]}
    typer.echo(json_text(record) if as_json else str(found))


@app.command()
def render(
    scene: option.SceneFile,
    out: option.SystemOut = None,
    size: option.Size = None,
    samples: Annotated[int | None, typer.Option(help="n for n × n samples a pixel.")] = None,
    workers: Annotated[int | None, typer.Option(help="Threads; the result does not depend on it.")] = None,
    as_json: option.Json = False,
) -> None:
    """Trace and collapse a scene into a linear system.

    The file that it writes is what every other command reads.

    Example: symrt render globe --size 512 --out globe.npz
    """
    out = writable(out or Path(f"{Path(scene).stem}.npz"), ".npz")
    if workers is not None and workers < 1:
        raise ValueError(f"--workers {workers}: at least one thread works")
    system = rt.render(scene_of(scene, size, samples), workers=workers)
    rt.save_system(out, system)
    record = {"system": str(out), "width": system.width, "height": system.height}
    record |= {"interactions": [str(i) for i in system.interactions], "coefficients": int(system.G.nnz)}
    seconds = ", ".join(f"{name} {spent:.2f} s" for name, spent in system.seconds.items())
    typer.echo(json_text(record | {"seconds": dict(system.seconds)}) if as_json else f"{out}: {system!r}; {seconds}")


@app.command()
def formula(
    source: option.Source,
    x: Annotated[int, typer.Option("--x", help="Column from the left, from 0.")],
    y: Annotated[int, typer.Option("--y", help="Row from the top, from 0.")],
    collapsed: Annotated[bool, typer.Option("--collapsed", help="After the collapse, also from a scene.")] = False,
    latex: Annotated[bool, typer.Option("--latex", help="As LaTeX.")] = False,
    python: Annotated[bool, typer.Option("--python", help="As a Python function, every digit kept.")] = False,
    size: option.Size = None,
    as_json: option.Json = False,
) -> None:
    """What one pixel says, as a formula.

    Of a scene with the geometry in letters, of a rendered system the linear form.

    Example: symrt formula globe --x 210 --y 140
    """
    found = formula_of(source, size, x, y, collapsed)
    if as_json:
        record = {"x": x, "y": y, "text": found.text(digits=17), "latex": found.latex(), "python": found.code()}
        typer.echo(json_text(record | {"symbols": list(found.symbols), "values": dict(found.values)}))
    else:
        typer.echo(found.latex() if latex else found.code() if python else str(found))


@app.command()
def shade(
    source: option.Source,
    out: Annotated[Path | None, typer.Option("--out", "-o", help=".png, .tif, .npz or .exr.")] = None,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    exposure: option.Exposure = 1.0,
    reference: option.Reference = None,
    size: option.Size = None,
) -> None:
    """Make a picture with a palette.

    Example: symrt shade globe.npz --palettes globe --palette macbeth --out globe.png
    """
    spectra = palette_of(source, palettes, palette)
    out = writable(out or Path(f"{Path(source).stem}.png"), *PICTURES)
    system = system_of(source, size)
    image = rt.shade(system, spectra)
    white = rt.Reference(reference).white(system, spectra) if reference else None
    rt.save_image(out, image, exposure=exposure, reference=white)
    typer.echo(f"{out}: {image!r}, shaded in {image.seconds:.3f} s")


@app.command()
def gamut(
    device: Annotated[str, typer.Argument(metavar="DEVICE", help="A device, or a gamut saved as .npz.")] = DEVICE,
    model: option.ModelName = None,
    black: option.BlackName = None,
    save: Annotated[Path | None, typer.Option(help="Write the gamut to a file (.npz).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw its shadow and its slice (.png).")] = None,
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
    if save is not None:
        rt.save_gamut(save, found)
    if plot is not None:
        draw(plot, "solids_figure", found)
    facts = gamut_facts(found)
    typer.echo(json_text(facts) if as_json else gamut_table(facts))


@app.command()
def feasible(  # noqa: PLR0913, PLR0917  # a command names its options
    source: option.Source,
    parameter: option.Parameters,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    within: option.Within = None,
    allowed_out: option.AllowedOut = 0.0,
    together: option.Together = False,
    cap: option.Cap = True,
    device: option.DeviceName = DEVICE,
    model: option.ModelName = None,
    black: option.BlackName = None,
    reference: option.Reference = None,
    exposure: option.Exposure = 1.0,
    size: option.Size = None,
    plot: option.Plot = None,
    as_json: option.Json = False,
) -> None:
    """Which values of a parameter a device can print, and which pixel and band end each range.

    Example: symrt feasible globe --palette macbeth --parameter scale:brass --no-cap
    """
    from symrt.explore.tables import feasible_record  # noqa: PLC0415  # slow, and --help does not need it
    from symrt.explore.together import box_text  # noqa: PLC0415  # the same

    if together and (plot is not None or allowed_out):
        raise ValueError("--together gives one box for all pixels: leave out --plot and --allowed-out")
    if plot is not None:
        writable(plot, ".png")
    asked = [parameter_of(word) for word in parameter]
    spectra, limits = palette_of(source, palettes, palette), gamut_of(device, model, black)
    seen = rt.Reference(reference, exposure)
    system = system_of(source, size, asked)
    options = {"within": within, "cap": cap, "reference": seen}
    if together:
        typer.echo(box_text(system, spectra, limits, parameter, as_json=as_json, **options))
        return
    found = [rt.feasible(system, spectra, limits, one, allowed_out=allowed_out, **options) for one in asked]
    if plot is not None:
        draw(plot, "ranges_figure", found, system, spectra, limits, seen)
    answers = [feasible_record(one) for one in found]
    typer.echo(json_text(answers) if as_json else "\n\n".join(map(repr, found)))


@app.command()
def report(  # noqa: PLR0913, PLR0917  # a command names its options
    source: option.Source,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    device: option.DeviceName = DEVICE,
    model: option.Models = None,
    monitor: option.Monitor = "crt-brainard",
    reference: option.Reference = None,
    exposure: option.Exposure = 1.0,
    size: option.Size = None,
    as_json: option.Json = False,
) -> None:
    """Take one image through several gamuts: who says yes, who no.

    Example: symrt report globe --palette macbeth --model envelope --model hull
    """
    spectra = palette_of(source, palettes, palette)
    gamuts = gamuts_of(device, model or ["unit", "envelope", "hull", "colorimetric"], monitor, spectra.bands)
    said = rt.report(system_of(source, size), spectra, gamuts, rt.Reference(reference, exposure))
    typer.echo(json_text(asdict(said)) if as_json else str(said))


@app.command()
def fit(  # noqa: PLR0913, PLR0917  # a command names its options
    source: option.Source,
    parameter: option.Parameters,
    objective: option.Objective = "lightest",
    least_luminance: option.LeastLuminance = 0.5,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The picture (.png, .tif, .npz or .exr).")] = None,
    palette: option.PaletteName = None,
    palettes: option.PaletteFile = None,
    within: option.Within = None,
    cap: option.Cap = True,
    device: option.DeviceName = DEVICE,
    model: option.ModelName = None,
    black: option.BlackName = None,
    reference: option.Reference = None,
    exposure: option.Exposure = 1.0,
    size: option.Size = None,
    as_json: option.Json = False,
) -> None:
    """The lightest, darkest, closest … picture it can print, whatever the order of the scales.

    Example: symrt fit globe --palette macbeth -p scale:upland -p scale:brass --no-cap --out lightest.png
    """
    from symrt.explore.tables import fit_record  # noqa: PLC0415  # slow, and --help does not need it

    if out is not None:
        writable(out, *PICTURES)
    scales = [scale_of(word) for word in parameter]
    spectra, limits = palette_of(source, palettes, palette), gamut_of(device, model, black)
    seen = rt.Reference(reference, exposure)
    system = system_of(source, size)
    options = {"objective": objective, "within": within or (0.01, 3.0), "cap": cap, "reference": seen}
    found = rt.fit(system, spectra, limits, scales, least_luminance=least_luminance, **options)
    if out is not None:
        # A picture is seen as the fit was asked; other files hold the radiances as they are.
        view = {"exposure": exposure, "reference": seen.white(system, spectra)} if out.suffix.lower() == ".png" else {}
        rt.save_image(out, rt.shade(system, found.palette), **view)
    typer.echo(json_text(fit_record(found)) if as_json else repr(found))


@app.command()
def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the pictures and tables.")] = Path("out"),
    size: Annotated[str, typer.Option("--size", metavar="W[xH]", help="Pixels.")] = "512",
    scene: Annotated[str, typer.Option("--scene", help="A scene with palettes in RGB and in wavelengths.")] = "globe",
) -> None:
    """The paper's Figures 1, 2 and 3 into a folder.

    With them go a table of feasible ranges, one pixel's formula, the times, and a page that shows all of it.

    Example: symrt demo --out out
    """
    from symrt.explore.demo import write_demo  # noqa: PLC0415  # slow, and --help does not need it

    for product in write_demo(out, scene_of(scene, size), rt.load_palettes(scene)):
        typer.echo(f"{product.path}: {shorten(product.caption, 140, placeholder=' …')}")


def _warned(message: Warning | str, *_: Any, **__: Any) -> None:
    typer.echo(f"symrt: warning: {message}", err=True)


def _refused(message: str) -> int:
    for line in message.splitlines():
        typer.echo(f"symrt: {line if len(line) <= LONGEST else line[:LONGEST] + '…'}", err=True)
    return BAD_INPUT
