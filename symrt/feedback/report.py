"""One image through several gamuts: which have it inside, and the claim that each of them proves (steps 4 and 5).

The paper argues that an image perfected on a monitor may be wrong for print: a report says, for each printer's gamut,
how often a monitor would have been content where the printer is not, and the other way round.
"""

import html
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import Spectrum
from symrt.device.colorimetry import lab
from symrt.errors import require_list
from symrt.feedback.limits import reflectances, white_in_every_band
from symrt.feedback.weighing import check_most
from symrt.gamut.colorimetric import ColorimetricGamut
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.monitor import MonitorGamut
from symrt.spectra.bands import Bands
from symrt.spectra.library import colour_difference
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.symbols import Symbol
from symrt.system import LinearSystem
from symrt.table import html_table, percent, sentences, text_table

REPORTED = 2000
"""Object pixels that a gamut is asked about, drawn evenly, if the image has more."""

Pixels = Int[np.ndarray, " pixel"]
Reflectances = Float[np.ndarray, "pixel band"]
VERDICT_COLUMNS = ("gamut", "inside", "worst pixel", "by", "worst band")


@dataclass(frozen=True)
class Verdict:
    """The verdict of one gamut on an image.

    Parameters
    ----------
    gamut, short
        The gamut in words, and its name in tables.
    label
        The claim that being inside proves.
    inside
        Share of the pixels asked that are inside.
    worst
        Column and row of the pixel that is farthest outside; None if all are inside.
    violation
        Its distance from the gamut, in the gamut's own measure.
    delta_e
        That distance in CIEDE2000, where colours are asked: to the nearest reflectance of the gamut, under its viewing
        light, or beside a monitor's white; None where spectra are asked, or RGB.
    band
        The band in which that pixel and the nearest reflectance of the gamut differ most.
    materials
        For each material, the share inside of the pixels that it contributes to.
    contented
        For each monitor, the share of pixels that it shows and this gamut leaves outside, and the share that it
        cannot show and this gamut has inside.
    """

    gamut: str
    short: str
    label: str
    inside: float
    worst: tuple[int, int] | None
    violation: float
    delta_e: float | None
    band: str | None
    materials: Mapping[str, float]
    contented: Mapping[str, tuple[float, float]]
    seconds: float


@dataclass(frozen=True, repr=False)
class Report:
    """The verdicts of several gamuts on one image.

    Parameters
    ----------
    asked, objects
        Number of pixels asked about, and number of pixels that light reaches.
    note
        The reference and the exposure that made reflectances of radiances, and which devices are modelled.
    """

    verdicts: tuple[Verdict, ...]
    asked: int
    objects: int
    note: str

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """The verdicts as rows of text."""
        return [
            (
                v.short,
                percent(v.inside),
                "-" if v.worst is None else f"({v.worst[0]}, {v.worst[1]})",
                "-" if v.worst is None else f"{v.violation:.3g}" if v.delta_e is None else f"{v.delta_e:.3g} ΔE00",
                v.band or "-",
            )
            for v in self.verdicts
        ]

    @property
    def materials(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """For each material the share of its pixels that is inside each gamut: a head and rows of text."""
        names = sorted({name for v in self.verdicts for name in v.materials})
        rows = [(n, *(percent(v.materials[n]) if n in v.materials else "-" for v in self.verdicts)) for n in names]
        return ("inside, where seen", *(v.short for v in self.verdicts)), rows

    def __repr__(self) -> str:
        tables = text_table(VERDICT_COLUMNS, self.rows), text_table(*self.materials)
        return "\n".join([tables[0], sentences(self._legend()), "", tables[1], "", sentences(self._sentences())])

    def _legend(self) -> list[str]:
        """The meaning of each short name."""
        return [f"{v.short}: {v.gamut}; inside is {v.label}." for v in self.verdicts]

    def _sentences(self) -> list[str]:
        drawn = "" if self.asked == self.objects else ", drawn evenly"
        lines = [f"Asked: {self.asked} of {self.objects} object pixels{drawn}; {self.note}."]
        short = {v.gamut: v.short for v in self.verdicts}
        for monitor in dict.fromkeys(name for v in self.verdicts for name in v.contented):
            shares = {v.short: v.contented[monitor] for v in self.verdicts if monitor in v.contented}
            shown = ", ".join(f"{name} {percent(shown)}" for name, (shown, _) in shares.items())
            kept = ", ".join(f"{name} {percent(kept)}" for name, (_, kept) in shares.items())
            lines.append(f"The {short[monitor]} shows pixels that are outside: {shown}.")
            lines.append(f"The {short[monitor]} cannot show pixels that are inside: {kept}.")
        return lines

    def _repr_html_(self) -> str:
        legend, said = (
            "".join(f"<p>{html.escape(line)}</p>" for line in lines) for lines in (self._legend(), self._sentences())
        )
        return html_table(VERDICT_COLUMNS, self.rows) + legend + html_table(*self.materials) + said


def report(
    system: LinearSystem,
    palette: Palette,
    gamuts: Sequence[ConvexGamut | UnevenGamut],
    reference: Reference | None = None,
    *,
    most: int = REPORTED,
) -> Report:
    """Take one image through several gamuts.

    Parameters
    ----------
    gamuts
        From `device_gamut`, of printers and of monitors, each on the palette's bands.
    most
        Object pixels to ask about: all of them if there are no more, else this many at even distances.  A share that
        some thousand pixels give is known to about a percent.

    Raises
    ------
    ValueError
        If a gamut is on other bands, the reference leaves bands dark, or no pixel is to be asked about.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(device.bands, {"sun": 2, "sea.diffuse": 0.95})
    >>> said = report(system, palette, [device_gamut(device, "unit"), device_gamut(device, "envelope")])
    >>> [(verdict.inside, verdict.worst) for verdict in said.verdicts]
    [(1.0, None), (0.5, (1, 0))]
    """
    # Draw the pixels, and shade them.
    check_most(most)
    require_list("gamuts", gamuts, "[device_gamut(device, 'envelope')]")
    reference = as_asked(reference)
    white = white_in_every_band(system, palette, reference, gamuts)
    objects = np.flatnonzero(system.object_pixels)
    pixels = objects[np.linspace(0, objects.size - 1, min(most, objects.size)).round().astype(int)]
    image = _image(system, palette, pixels, white)

    # Ask each gamut, and compare its answers with those of the monitors.
    answers = [_answer(gamut.under(white), image) for gamut in gamuts]
    monitors = {answer.gamut.name: answer.inside for answer in answers if isinstance(answer.gamut, MonitorGamut)}
    called = _short_names(gamuts)
    verdicts = tuple(_verdict(answer, image, monitors, short) for answer, short in zip(answers, called, strict=True))

    note = f"reference {reference.called(system, palette)}, exposure {reference.exposure:g}"
    if titles := dict.fromkeys(d.title for gamut in gamuts for d in gamut.devices if d.modelled):
        note += f"; modelled: {', '.join(titles)}"
    return Report(verdicts, pixels.size, objects.size, note)


@dataclass(frozen=True, eq=False)
class _Image:
    """The pixels asked about: their places, reflectances, and the materials that contribute to them."""

    places: Int[np.ndarray, "pixel 2"]
    seen: Reflectances
    bands: Bands
    materials: Mapping[str, Bool[np.ndarray, " pixel"]]


@dataclass(frozen=True, eq=False)
class _Answer:
    """The answer of a gamut for each pixel."""

    gamut: ConvexGamut | UnevenGamut
    inside: Bool[np.ndarray, " pixel"]
    violation: Float[np.ndarray, " pixel"]
    seconds: float


def _image(system: LinearSystem, palette: Palette, pixels: Pixels, white: Spectrum) -> _Image:
    part = system.rows(pixels)
    met = [{Symbol.of(symbol).material for symbol in interaction.names[1:]} for interaction in part.interactions]
    materials = {
        name: part.pixels_of(np.array([name in materials for materials in met])) for name in sorted(set().union(*met))
    }
    places = np.stack([pixels % system.width, pixels // system.width], axis=1)
    return _Image(places, reflectances(system, palette, white, pixels), palette.bands, materials)


def _answer(gamut: ConvexGamut | UnevenGamut, image: _Image) -> _Answer:
    start = time.perf_counter()
    inside = gamut.contains(image.seen)
    violation = np.zeros(inside.size)
    violation[~inside] = gamut.violation(image.seen[~inside])
    return _Answer(gamut, inside, violation, time.perf_counter() - start)


def _short_names(gamuts: Sequence[ConvexGamut | UnevenGamut]) -> list[str]:
    """The names of the gamuts in tables: their models, numbered where there are several of one."""
    models = [gamut.model for gamut in gamuts]
    numbers = [models[: k + 1].count(model) for k, model in enumerate(models)]
    return [name if models.count(name) == 1 else f"{name} {k}" for name, k in zip(models, numbers, strict=True)]


def _verdict(answer: _Answer, image: _Image, monitors: Mapping[str, Bool[np.ndarray, " pixel"]], short: str) -> Verdict:
    """The figures of an answer, compared with those of the monitors."""
    # Look at the pixel that is farthest outside.
    inside, gamut = answer.inside, answer.gamut
    worst = None if inside.all() else int(answer.violation.argmax())
    band = delta_e = None
    if worst is not None:
        seen = image.seen[[worst]]
        nearest = gamut.nearest(seen)
        band = image.bands.labels[int(np.abs(seen - nearest)[0].argmax())]
        delta_e = _difference(gamut, seen, nearest)

    # A monitor is not compared with monitors.
    others = {} if isinstance(gamut, MonitorGamut) else monitors
    return Verdict(
        gamut=gamut.name,
        short=short,
        label=gamut.label,
        inside=float(inside.mean()) if inside.size else 1.0,
        worst=None if worst is None else (int(image.places[worst, 0]), int(image.places[worst, 1])),
        violation=float(answer.violation.max(initial=0)),
        delta_e=delta_e,
        band=band,
        materials={name: float(inside[own].mean()) for name, own in image.materials.items() if own.any()},
        contented={name: (_share(shown & ~inside), _share(~shown & inside)) for name, shown in others.items()},
        seconds=answer.seconds,
    )


def _difference(gamut: ConvexGamut | UnevenGamut, seen: Reflectances, nearest: Reflectances) -> float | None:
    """CIEDE2000 between two reflectances, where a gamut is one of colours; of several the largest."""
    if isinstance(gamut, ColorimetricGamut):
        return float(colour_difference(*(lab(one @ gamut.observer, gamut.light) for one in (seen, nearest)))[0])
    if isinstance(gamut, MonitorGamut) and gamut.bands.kind == "wavelength":
        primaries = gamut.monitor.primaries
        shown = (lab(gamut.driven(one) @ primaries.T, primaries.sum(axis=1)) for one in (seen, nearest))
        return float(colour_difference(*shown)[0])
    parts = [_difference(part, seen, nearest) for part in getattr(gamut, "parts", ())]
    found = [part for part in parts if part is not None]
    return max(found) if found and len(found) == len(parts) else None


def _share(pixels: Bool[np.ndarray, " pixel"]) -> float:
    """The share of the pixels asked about; of none it is 0."""
    return float(pixels.mean()) if pixels.size else 0.0
