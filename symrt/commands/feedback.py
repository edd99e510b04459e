"""Commands on an image and a gamut: feasible ranges, fits, adaptations, pixels moved (step 5 of the paper)."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import parameter_of, scale_of
from symrt.commands.masks import weights_of
from symrt.commands.outputs import apart, writable
from symrt.commands.questions import Question, asking
from symrt.commands.saying import say
from symrt.show.writing import draw, json_text

if TYPE_CHECKING:
    from symrt.spectra.image import SpectralImage
    from symrt.spectra.palette import Palette
    from symrt.system import LinearSystem


@asking(Question)
def feasible(  # noqa: PLR0913, PLR0917  # a command names its options
    question: Question,
    parameter: option.Parameters,
    within: option.Within = None,
    allowed_out: option.AllowedOut = 0.0,
    of: option.Of = None,
    weights: option.Weights = None,
    together: option.Together = False,
    cap: option.Cap = True,
    plot: option.Plot = None,
    region: option.Region = None,
    curve: option.Curve = None,
    as_json: option.Json = False,
) -> None:
    """The values of a parameter that a device can print.

    Each range comes with the pixel and the band that end it.

    Example: symrt feasible globe --palette macbeth --parameter scale:brass --no-cap
    """
    from symrt.show import records, tables  # noqa: PLC0415  # slow, and --help does not need it

    # Options that exclude each other, and files that cannot be written, are refused before any work.
    alone: dict[str, object] = {"--plot": plot, "--allowed-out": allowed_out, "--of": of, "--weights": weights}
    _check_options(len(parameter), together, region, curve, alone)
    for path in (plot, region, curve):
        if path is not None:
            writable(path, ".png")
    apart({"--plot": plot, "--region": region, "--curve": curve}, [*question.read, weights])

    asked = [parameter_of(word) for word in parameter]
    gamut, seen = question.gamut, question.seen
    system, spectra = question.rendered(asked)
    options: dict[str, Any] = {"within": within, "cap": cap, "reference": seen}

    # One box for all scales together.
    if together:
        scales = [scale_of(word) for word in parameter]
        box = rt.safe_box(system, spectra, gamut, scales, **(options | {"within": within or (0.01, 3.0)}))
        say(json_text(records.box_record(box)) if as_json else repr(box))
        return
    options |= {"allowed_out": allowed_out, "mask": None if of is None else rt.pixels_of(system, of)}

    # The region of two parameters.
    if region is not None:
        ranges = options | {"within": (within, within)}
        pairs = rt.joint_region(system, spectra, gamut, asked[0], asked[1], **ranges)
        draw(region, "joint_region_figure", pairs, system, spectra, seen)
        say(json_text(records.region_record(pairs)) if as_json else repr(pairs))
        return
    options |= {"weights": weights_of(weights, system)}

    # A range for each parameter by itself.
    found = [rt.feasible(system, spectra, gamut, one, **options) for one in asked]
    if curve is not None:
        draw(curve, "curve_figure", found[0])
    if plot is not None:
        draw(plot, "ranges_figure", found, system, spectra, gamut, seen)
    answers = [records.feasible_record(one) for one in found]
    say(json_text(answers) if as_json else tables.ranges_text(found))


@asking(Question)
def fit(  # noqa: PLR0913, PLR0917  # a command names its options
    question: Question,
    parameter: option.Scales,
    objective: option.Objective = "lexicographic",
    least_luminance: option.LeastLuminance = 0.5,
    out: option.Out = None,
    within: option.Within = None,
    allowed_out: option.AllowedOut = 0.0,
    cap: option.Cap = True,
    palette_out: option.PaletteOut = None,
    plot: option.Plot = None,
    as_json: option.Json = False,
) -> None:
    """The lightest, darkest, closest … picture that it can print.

    The order of the scales makes no difference.

    Example: symrt fit globe --palette macbeth -p scale:upland -p scale:brass --no-cap --out fitted.png
    """
    from symrt.show.records import fit_record  # noqa: PLC0415  # slow, and --help does not need it
    from symrt.spectra.palettes_file import check_palettes_free  # noqa: PLC0415

    # Files that cannot be written are refused before any work.
    _check_files(question, out, plot, palette_out)
    if palette_out is not None:
        check_palettes_free(palette_out, [objective])

    # Fit the scales.
    scales = [scale_of(word) for word in parameter]
    gamut, seen = question.gamut, question.seen
    system, spectra = question.rendered()
    options: dict[str, Any] = {"objective": objective, "within": within or (0.01, 3.0), "cap": cap, "reference": seen}
    options |= {"least_luminance": least_luminance, "allowed_out": allowed_out}
    found = rt.fit(system, spectra, gamut, scales, **options)

    # Write the picture, the palette and the figure.
    written = [_save(out, rt.shade(system, found.palette), question, system, spectra)] if out is not None else []
    if palette_out is not None:
        rt.save_palettes(palette_out, {objective: found.palette})
    if plot is not None:
        draw(plot, "fit_figure", found, system, spectra, seen)
    _answer(fit_record(found), repr(found), written, as_json)


@asking(Question)
def adapt(  # noqa: PLR0913, PLR0917  # a command names its options
    question: Question,
    parameter: option.Scales,
    least_inside: option.LeastInside = 1.0,
    most_difference: option.MostDifference = None,
    least_lightness: option.LeastLightness = None,
    least_luminance: option.LeastLuminance = 0.5,
    map_rest: option.MapRest = False,
    out: option.Out = None,
    within: option.Within = None,
    cap: option.Cap = True,
    plot: option.Plot = None,
    as_json: option.Json = False,
) -> None:
    """The simplest change that makes a picture reproducible.

    It must meet stated criteria; if no change does, the answer says why.

    Example: symrt adapt globe --palette macbeth -p scale:upland -p scale:brass --least-lightness 0.95
    """
    from symrt.show.records import adapted_record  # noqa: PLC0415  # slow, and --help does not need it

    # Files that cannot be written are refused before any work.
    _check_files(question, out, plot)

    # Search for the simplest change.
    scales = [scale_of(word) for word in parameter]
    gamut, seen = question.gamut, question.seen
    system, spectra = question.rendered()
    options: dict[str, Any] = {
        "least_inside": least_inside,
        "most_difference": most_difference,
        "least_lightness": least_lightness,
        "least_luminance": least_luminance,
    }
    options |= {"map_rest": map_rest, "within": within or (0.01, 3.0), "cap": cap, "reference": seen}
    found = rt.adapt(system, spectra, gamut, scales, **options)

    # Write the picture, if one was accepted, and the figure.
    written = [_save(out, found.image(system), question, system, spectra)] if out is not None and found.accepted else []
    if plot is not None:
        draw(plot, "adapted_figure", found, system, spectra, seen)
    _answer(adapted_record(found), repr(found), written, as_json)


@asking(Question)
def map_pixels(  # a command names its options
    question: Question,
    towards: option.Towards = "neutral",
    smoothness: option.Smoothness = 0.0,
    out: option.Out = None,
    plot: option.Plot = None,
    as_json: option.Json = False,
) -> None:
    """Move each pixel outside a gamut into it.

    This is the last resort, when no parameter is to change.

    Example: symrt map-pixels globe --palette macbeth --towards neutral --smoothness 2 --out moved.png
    """
    from symrt.show.records import mapped_record  # noqa: PLC0415  # slow, and --help does not need it

    _check_files(question, out, plot)
    gamut, seen = question.gamut, question.seen
    system, spectra = question.rendered()
    found = rt.map_pixels(system, spectra, gamut, towards=towards, smoothness=smoothness, reference=seen)
    written = [_save(out, found.image, question, system, spectra)] if out is not None else []
    if plot is not None:
        draw(plot, "mapped_figure", found, system, spectra, seen)
    _answer(mapped_record(found), repr(found), written, as_json)


def _check_options(
    parameters: int, together: bool, region: Path | None, curve: Path | None, alone: dict[str, object]
) -> None:
    """Refuse options of `feasible` that exclude each other; those in `alone` are for one parameter at a time."""
    if together and (given := [name for name, value in alone.items() if value]):
        raise ValueError(f"--together gives one box for all pixels: leave out {' and '.join(given)}")
    if region is not None and (parameters != 2 or together or alone["--plot"] or alone["--weights"]):
        raise ValueError("--region draws two parameters, -p A -p B: leave out --together, --plot and --weights")
    if curve is not None and (parameters != 1 or together):
        raise ValueError("--curve draws one parameter: give one -p, and leave out --together")


def _check_files(question: Question, out: Path | None, plot: Path | None, palette_out: Path | None = None) -> None:
    if out is not None:
        writable(out, *option.PICTURES, form="")
    if plot is not None:
        writable(plot, ".png")
    if palette_out is not None:
        writable(palette_out, ".toml")
    apart({"--out": out, "--plot": plot, "--palette-out": palette_out}, question.read)


def _answer(record: dict[str, Any], text: str, written: list[str], as_json: bool) -> None:
    """Say the answer, and a sentence for each file that was written."""
    say(json_text(record | {"written": written}) if as_json else "\n".join([text, *written]))


def _save(out: Path, image: "SpectralImage", question: Question, system: "LinearSystem", palette: "Palette") -> str:
    """Write a picture as it is seen, or radiances as they are, and return a sentence that says which."""
    seen = question.seen
    if out.suffix.lower() == ".png":
        rt.save_image(out, image, exposure=seen.exposure, white=seen.white(system, palette))
        return f"{out}: the picture in sRGB, against {seen.called(system, palette)}, exposure {seen.exposure:g}."
    rt.save_image(out, image)
    return f"{out}: radiances, {image.bands!r}, as they are: no exposure, no white taken out."
