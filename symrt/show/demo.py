"""The paper's Figures 1, 2 and 3 in files, with the table of ranges, one pixel's formula, the times and a page of all.

Every file names its reference, and tells modelled data from measured.
"""

import os
import platform
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symrt.disk import write_whole
from symrt.feedback import Fit
from symrt.scene import Scene
from symrt.show.page import File, page
from symrt.show.plots import gamut_figure, png, ranges_figure
from symrt.show.study import WITHIN, Study, materials, study
from symrt.show.tables import fits_table, ranges_table
from symrt.spectra import Palette, shade
from symrt.spectra.files import png_bytes
from symrt.spectra.viewing import clipped

SPAN = f"{WITHIN[0]:.2f} … {WITHIN[1]:.2f}"


@dataclass(frozen=True)
class Product:
    """A file that the demo wrote, and its caption."""

    path: Path
    caption: str


def write_demo(
    out: str | Path, scene: Scene, palettes: Mapping[str, Palette], progress: bool = True
) -> tuple[Product, ...]:
    """Study a scene, and write pictures, tables and a page that shows them into a folder.

    Parameters
    ----------
    out
        The folder, which is made if it does not exist.
    palettes
        The scene's palettes, of which the first in RGB and the first in wavelengths are used.
    progress
        True to show a bar on standard error after a second.
    """
    out, start = Path(out), time.perf_counter()
    out.mkdir(parents=True, exist_ok=True)
    found = study(scene, palettes, progress)
    files = [*_pictures(found), *_texts(found)]
    files.append(("times.txt", "what it took", _times(found, time.perf_counter() - start)))
    files.append(("index.html", "everything above on one page", page(files)))
    for name, _, content in files:
        write_whole(out / name, content)
    return tuple(Product(out / name, caption) for name, caption, _ in files)


def _pictures(found: Study) -> Iterator[File]:
    """Figures 1, 2 and 3, and the ranges as a figure."""
    # Figure 1: the gamut with the materials' segments.
    light = next(iter(found.system.white))
    body = gamut_figure(found.gamut, found.spectral, materials(found.system), light=light, within=WITHIN)
    what = f"{found.gamut.name}: its shadow in 3 of {len(found.gamut.bands)} components"
    yield "figure-1.png", f"{what}, with each material scaled by {SPAN} (a) and blended with each other (b)", png(body)

    # Figure 2: one render under two palettes.
    for letter, (name, image) in zip("ab", found.images.items(), strict=True):
        over = f"{clipped(image):.2%} of the pixels are beyond the screen's range"
        once = "the scene, rendered once," if letter == "a" else "the same render"
        what = f"{once} under palette {name} in {len(image.bands)} bands"
        yield f"figure-2{letter}.png", f"{what}; reference {light}, exposure 1; {over}", png_bytes(image)

    # Figure 3: all scales fitted.
    for name, fitted in found.fits.items():
        yield f"{name}.png", _fit_caption(fitted), png_bytes(shade(found.system, fitted.palette))

    drawn = ranges_figure(found.ranges, found.system, found.spectral, found.gamut)
    yield "ranges.png", "feasible ranges, one parameter at a time, and the spectrum that stops each", png(drawn)


def _fit_caption(fitted: Fit) -> str:
    values = ", ".join(f"{name} {value:.3g}" for name, value in fitted.values.items())
    left = len(fitted.untouched_outside) + len(fitted.unfixable)
    rest = f", {left} of {fitted.objects} pixels left out" if left else ""
    above = f"; would reflect more than they receive: {', '.join(fitted.above_one)}" if fitted.above_one else ""
    return f"the {fitted.objective} within {SPAN} ({fitted.verdict}{rest}): {values}{above}. {fitted.note}"


def _texts(found: Study) -> Iterator[File]:
    """The table of ranges, and one pixel as a formula."""
    yield "ranges.txt", f"feasible ranges with their reasons: {found.ranges[0].note}", _ranges_text(found)
    x, y = found.pixel
    yield "formula.txt", f"pixel ({x}, {y}) before and after the collapse", _formula_text(found)


def _ranges_text(found: Study) -> str:
    alone = "One parameter at a time; no physical cap, as in the paper's Figure 3, so materials above 1 are listed."
    left = "Pixels outside: those that the parameter does not touch, and those that no value brings inside."
    dark = f"Darker than the device's black with the palette given: {found.ranges[0].dark:.1%} of the object pixels."
    together = "All materials at once (figures 3a, 3a-black and 3b):"
    details = "\n\n".join(map(repr, found.ranges))
    parts = [f"{found.ranges[0].note}.", f"{alone}\n{left}\n{dark}", ranges_table(found.ranges)]
    return "\n\n".join([*parts, f"{together}\n\n{fits_table(found.fits)}", f"In words:\n\n{details}"]) + "\n"


def _formula_text(found: Study) -> str:
    """The pixel's formula before and after the collapse, in three notations, and its distance from the shaded pixel."""
    x, y = found.pixel
    lines = [f"Pixel ({x}, {y}): column {x} from the left, row {y} from the top."]
    for title, formula in (("Before the collapse", found.before), ("After the collapse", found.after)):
        for form, text in (("text", str(formula)), ("LaTeX", formula.latex()), ("Python", formula.code())):
            lines += [f"\n{title}, as {form}:\n", text]

    # Both formulas are checked against the shaded pixel.
    spectral = found.spectral
    values = [np.asarray(f.evaluate({s: spectral[s] for s in f.symbols})) for f in (found.before, found.after)]
    shaded = list(found.images.values())[1].values[y, x]
    error = max(float(np.abs(value - shaded).max()) for value in values)
    lines.append(f"\nBoth, evaluated in {len(shaded)} bands, are the shaded pixel within {error:.1g}.")
    return "\n".join(lines) + "\n"


def _times(found: Study, total: float) -> str:
    """The time of each step in seconds, under the size of the problem and the machine."""
    rgb, spectral = found.images.values()
    one = [answer.seconds for answer in found.ranges]
    size = f"{found.system.width} × {found.system.height} pixels, {found.system.G.nnz} coefficients"

    # Threads work at once, so that their seconds add up to more than have elapsed.
    rows = {
        "trace (sum over threads)": found.system.seconds["trace"],
        "collapse (sum over threads)": found.system.seconds["collapse"],
        "render (trace and collapse, elapsed)": found.system.seconds["render"],
        f"shade, {len(rgb.bands)} bands": rgb.seconds,
        f"shade, {len(spectral.bands)} bands": spectral.seconds,
        f"clip, {len(spectral.bands)} bands, one parameter (median of {len(one)})": float(np.median(one)),
        "fit, all materials (mean of 3)": float(np.mean([fitted.seconds for fitted in found.fits.values()])),
        "everything": total,
    }
    width = max(map(len, rows))
    table = "\n".join(f"{name:<{width}}  {seconds:9.4f} s" for name, seconds in rows.items())
    return f"{size}\n{_machine()}\n\n{table}\n"


def _machine() -> str:
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{usable} processors, {platform.machine()}, {platform.system()}, Python {platform.python_version()}"
