"""Line segments in a gamut, as drawn in Figure 1 of the paper, between its steps 4 and 5.

A perfect white that faces the reference light has reflectance 1, and a material in its place has its own reflectance r.
Scaling the material moves it along ``t r``, blending two moves it along ``(1 − t) a + t b``: lines through the gamut,
which the gamut clips as a whole, in all bands, whatever few components are drawn.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from jaxtyping import Float
from tqdm.auto import tqdm

from symrt.arrays import Spectrum
from symrt.feedback.parameters import Scale
from symrt.feedback.ranges import checked_range
from symrt.gamut.gamuts import AnyGamut
from symrt.gamut.interface import ConvexGamut, SlabGamut, clip
from symrt.gamut.intersections import AnyIntersection, UnevenGamut
from symrt.spectra.bands import Number
from symrt.spectra.display import display_matrix, encode, white_among
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.symbols import Symbol, named

CHUNK = 8
"""Number of segments that are clipped at a time."""

Span = tuple[Number, Number]
"""An interval of a segment's parameter."""
Ends = tuple[str | None, str | None]
"""Names of the bounds that end an interval below and above."""
Spectra = Float[np.ndarray, "segment band"]


@dataclass(frozen=True, eq=False)
class Segment:
    """The line ``origin + t direction`` that a parameter t draws, and the part of it inside a gamut.

    Parameters
    ----------
    names
        The material that is scaled, or the two that are blended.
    origin, direction
        Reflectances.
    within
        The range of t.
    inside
        The intervals of t inside the gamut, in rising order: at most one if the gamut is convex.
    stops
        The bounds that end each interval below and above, a band or another bound of the gamut.  None where `within`
        ends, or the gamut has no bounds to name.
    colours
        Colours in encoded sRGB at t = 0 and t = 1; a scaled material has the same twice.

    Examples
    --------
    >>> half = ((0.0, 1.0),), ((None, "560 nm"),)
    >>> grey = Segment(("grey",), np.zeros(2), np.ones(2), (0.0, 3.0), *half, np.full((2, 3), 0.7))
    >>> grey.at(0.5).tolist(), grey.outside
    ([0.5, 0.5], ((1.0, 3.0),))
    """

    names: tuple[str, ...]
    origin: Spectrum
    direction: Spectrum
    within: Span
    inside: tuple[Span, ...]
    stops: tuple[Ends, ...]
    colours: Float[np.ndarray, "2 3"]

    def at(self, t: Number) -> Spectrum:
        """The reflectance at t."""
        return self.origin + t * self.direction

    @property
    def outside(self) -> tuple[Span, ...]:
        """The intervals of t outside the gamut."""
        ends = (self.within[0], *(end for span in self.inside for end in span), self.within[1])
        return tuple((low, high) for low, high in list(pairwise(ends))[::2] if low < high)


@dataclass(frozen=True, eq=False)
class Segments:
    """The segments of a palette's materials in a gamut.

    Parameters
    ----------
    light
        The reference light.
    scaled, blended
        A segment for each material, and one for each pair.
    """

    gamut: AnyGamut | AnyIntersection
    light: str
    exposure: Number
    scaled: tuple[Segment, ...]
    blended: tuple[Segment, ...]


def segments_of(
    gamut: AnyGamut | AnyIntersection,
    palette: Palette,
    materials: Sequence[str] | None = None,
    *,
    light: str | None = None,
    within: Span = (0.01, 3.0),
    exposure: Number = 1.0,
    progress: bool = True,
) -> Segments:
    """The segments of all materials in front of a reference light, and of all blends of two of them.

    Parameters
    ----------
    palette
        Source of each material's diffuse reflectance: that of a surface which faces the reference light, unshadowed.
    materials
        Names of materials; all that have a diffuse reflectance if not given.
    light
        A light of the palette, the first that shines if not given, or ``"equal-energy"`` or an illuminant.
    within
        The range of the scales.
    progress
        True to show a bar after a second, as gamuts of inks need.

    Raises
    ------
    ValueError
        If the light or a material does not exist, no material is left, or the range or the exposure is not valid.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"), "envelope")
    >>> palette = Palette(gamut.bands, {"sun": 2, "snow.diffuse": 0.9, "soot.diffuse": 0.02})
    >>> found = segments_of(gamut, palette)
    >>> found.light, [round(segment.inside[0][1], 3) for segment in found.scaled], len(found.blended)
    ('sun', [1.0, 3.0], 1)
    """
    shining = {name: palette[name] for name in palette.lights if palette[name].any()}
    white = white_among(shining, light, palette.bands)

    # The materials to scale and to blend, and the settings, checked.
    names = list(diffuse_materials(palette) if materials is None else materials)
    if not names:
        raise ValueError("no material has a diffuse reflectance: there is no segment to clip")

    seen, within = Reference(light, exposure), checked_range(Scale(names[0]), within)
    return Segments(
        gamut,
        seen.light or next(iter(shining)),
        seen.exposure,
        scale_segments(gamut, palette, names, white, within, seen.exposure, progress),
        blend_segments(gamut, palette, names, white, seen.exposure, progress),
    )


def diffuse_materials(palette: Palette) -> tuple[str, ...]:
    """Names of the materials that have a diffuse reflectance, in the palette's order.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> diffuse_materials(Palette(RGB, {"sun": 1, "sea.diffuse": 0.1, "sea.mirror": 0.02}))
    ('sea',)
    """
    return tuple(str(s.surface) for s in map(Symbol.of, palette.reflectances) if s.component == "diffuse")


def scale_segments(
    gamut: ConvexGamut | UnevenGamut,
    palette: Palette,
    materials: Sequence[str],
    white: Spectrum,
    within: Span = (0.01, 3.0),
    exposure: Number = 1.0,
    progress: bool = True,
) -> tuple[Segment, ...]:
    """The segment ``t r`` of each material's diffuse reflectance r.

    Parameters
    ----------
    white
        Radiance of the reference white, which the colours are seen against.
    within
        The range of the scales.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"))
    >>> grey = Palette(gamut.bands, {"grey.diffuse": 0.5})
    >>> ((low, high),) = scale_segments(gamut, grey, ["grey"], np.ones(36))[0].inside
    >>> low, round(high, 12)
    (0.01, 2.0)
    """
    spectra = exposure * _diffuse(palette, materials)
    colours = _colours(spectra, palette, white)
    parts = _parts(gamut.under(white), np.zeros_like(spectra), spectra, within, progress)
    return tuple(
        Segment((name,), np.zeros_like(r), r, within, *part, np.array([colour, colour]))
        for name, r, part, colour in zip(materials, spectra, parts, colours, strict=True)
    )


def blend_segments(
    gamut: ConvexGamut | UnevenGamut,
    palette: Palette,
    materials: Sequence[str],
    white: Spectrum,
    exposure: Number = 1.0,
    progress: bool = True,
) -> tuple[Segment, ...]:
    """The segment between each two materials, t from 0 to 1.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> gamut = device_gamut(load_device("dye3-endura-premier"))
    >>> greys = Palette(gamut.bands, {"dark.diffuse": 0.1, "light.diffuse": 0.5})
    >>> [(s.names, s.inside) for s in blend_segments(gamut, greys, ["dark", "light"], np.ones(36))]
    [(('dark', 'light'), ((0.0, 1.0),))]
    """
    spectra = exposure * _diffuse(palette, materials)
    colours = _colours(spectra, palette, white)
    pairs = list(combinations(range(len(materials)), 2))
    if not pairs:
        return ()
    first, second = (list(index) for index in zip(*pairs, strict=True))
    origin, direction = spectra[first], spectra[second] - spectra[first]
    parts = _parts(gamut.under(white), origin, direction, (0.0, 1.0), progress)
    return tuple(
        Segment((materials[a], materials[b]), o, d, (0.0, 1.0), *part, colours[[a, b]])
        for (a, b), o, d, part in zip(pairs, origin, direction, parts, strict=True)
    )


def _diffuse(palette: Palette, materials: Iterable[str]) -> Float[np.ndarray, "material band"]:
    spectra = [palette[named(name, "diffuse")] for name in materials]
    return np.array(spectra).reshape(-1, len(palette.bands))


def _parts(
    gamut: ConvexGamut | UnevenGamut, origin: Spectra, direction: Spectra, within: Span, progress: bool
) -> list[tuple[tuple[Span, ...], tuple[Ends, ...]]]:
    """The intervals of each line inside a gamut, and the bounds that end them."""
    # A gamut that is not convex may hold several intervals, whose ends have no name.
    if isinstance(gamut, UnevenGamut):
        starts = tqdm(
            range(0, len(origin), CHUNK), desc="segments", unit="chunk", delay=1, leave=False, disable=not progress
        )
        parts = [gamut.clip(origin[k : k + CHUNK], direction[k : k + CHUNK], within) for k in starts]
        return [(tuple(line), ((None, None),) * len(line)) for part in parts for line in part]

    # A convex one holds one interval, which is empty where it would end before it begins.
    interval = clip(gamut, origin, direction)
    low, high = np.maximum(interval.low, within[0]), np.minimum(interval.high, within[1])
    below, above = (_stopped(gamut, origin, direction, ends) for ends in (interval.low, interval.high))
    return [
        (((a, b),), ((first if a > within[0] else None, last if b < within[1] else None),)) if a <= b else ((), ())
        for a, b, first, last in zip(low.tolist(), high.tolist(), below, above, strict=True)
    ]


def _stopped(
    gamut: ConvexGamut, origin: Spectra, direction: Spectra, ends: Float[np.ndarray, " segment"]
) -> list[str | None]:
    """The bound that each line meets at its end: the nearest of those that it crosses."""
    if not isinstance(gamut, SlabGamut):
        return [None] * len(ends)
    slabs, known = gamut.slabs, np.isfinite(ends)
    rate = direction @ slabs.matrix
    place = origin @ slabs.matrix + np.where(known, ends, 0.0)[:, None] * rate
    room = np.minimum(slabs.upper - place, place - slabs.lower)
    nearest = np.where(rate != 0, room, np.inf).argmin(axis=1)
    return [slabs.words[k] if ok else None for k, ok in zip(nearest.tolist(), known.tolist(), strict=True)]


def _colours(
    spectra: Float[np.ndarray, "material band"], palette: Palette, white: Spectrum
) -> Float[np.ndarray, "material 3"]:
    return encode((spectra * white) @ display_matrix(palette.bands, white))
