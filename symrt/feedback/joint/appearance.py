"""The look of an image in print, and the share of it inside a gamut: the figures that `adapt` goes by (step 5).

Colours are compared as prints are looked at: reflectances under D50, beside a perfect diffuser.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float, Int

from symrt.device.colorimetry import lab, tristimulus
from symrt.feedback.limits import reflectances, white_in_every_band
from symrt.feedback.weighing import check_most
from symrt.gamut.interface import ON_BOUNDARY, ConvexGamut
from symrt.gamut.intersections import UnevenGamut
from symrt.gamut.slabs import Gamut
from symrt.spectra.library import colour_difference
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.system import LinearSystem

LIGHT = "illuminant/D50"
"""Under which prints are looked at."""

Pixels = Int[np.ndarray, " pixel"]
Judged = Int[np.ndarray, " judged"]
Reflectances = Float[np.ndarray, "pixel band"]


@dataclass(frozen=True, eq=False)
class Appearance:
    """The image given: its colours at the pixels asked, and everything that it takes to judge other palettes."""

    system: LinearSystem
    palette: Palette
    gamut: ConvexGamut | UnevenGamut
    under: ConvexGamut | UnevenGamut
    white: Float[np.ndarray, " band"]
    pixels: Pixels
    judged: Judged

    @cached_property
    def lab(self) -> Float[np.ndarray, "pixel 3"]:
        """Colours of the image given."""
        return _lab(self.palette, self.seen(self.palette, self.pixels))

    @cached_property
    def luminance(self) -> float:
        """Mean of min(Y, 1) of the image given."""
        return _luminance(self.palette, self.seen(self.palette, self.pixels))

    def seen(self, palette: Palette, pixels: Pixels) -> Reflectances:
        """Reflectances of some pixels."""
        return reflectances(self.system, palette, self.white, pixels)

    def inside(self, palette: Palette) -> float:
        """Share of the pixels judged that are inside."""
        return float(self.under.contains(self.seen(palette, self.judged)).mean()) if self.judged.size else 1.0

    def inside_to_rounding(self, seen: Float[np.ndarray, "judged band"]) -> float:
        """Share of the pixels judged that are inside, or on the boundary to rounding, where they were moved."""
        inside = self.under.contains(seen)
        inside[~inside] = self.under.violation(seen[~inside]) <= ON_BOUNDARY
        return float(inside.mean()) if len(seen) else 1.0

    def figures(self, palette: Palette) -> tuple[float, float, float, float]:
        """Share inside, mean difference, and shares of the lightness and of the luminance kept."""
        return (self.inside(palette), *self.looks(self.seen(palette, self.pixels)))

    def looks(self, seen: Reflectances) -> tuple[float, float, float]:
        """Mean difference of the pixels asked, and shares of their lightness and of their mean min(Y, 1) kept."""
        if not self.pixels.size:
            return 0.0, 1.0, 1.0
        now = _lab(self.palette, seen)
        given, kept = (np.minimum(one[:, 0], 100.0).mean() for one in (self.lab, now))
        luminance = _luminance(self.palette, seen) / self.luminance if self.luminance else 1.0
        return float(colour_difference(self.lab, now).mean()), float(kept / given) if given else 1.0, luminance


def appearance(
    system: LinearSystem, palette: Palette, gamut: ConvexGamut | UnevenGamut, reference: Reference, *, most: int
) -> Appearance:
    """The image given, and at most some of its pixels, drawn evenly, to compare colours on."""
    check_most(most)
    white = white_in_every_band(system, palette, reference, [gamut])

    # Draw the pixels evenly; bounds in each band are quick enough to judge all of them.
    objects = np.flatnonzero(system.object_pixels)
    pixels = objects[np.linspace(0, objects.size - 1, min(most, objects.size)).round().astype(int)]
    return Appearance(
        system=system,
        palette=palette,
        gamut=gamut,
        under=gamut.under(white),
        white=white,
        pixels=pixels,
        judged=objects if isinstance(gamut, Gamut) else pixels,
    )


def _lab(palette: Palette, seen: Reflectances) -> Float[np.ndarray, "pixel 3"]:
    return lab(seen @ tristimulus(palette.bands, LIGHT), LIGHT)


def _luminance(palette: Palette, seen: Reflectances) -> float:
    return float(np.minimum(seen @ tristimulus(palette.bands, LIGHT)[:, 1], 1.0).mean())
