"""The bounds of a gamut on an image's radiances: step 5 of the paper, between pixels and gamuts.

Pixels are radiances and gamuts are reflectances, ``r = e · p / w``: w(λ) is the radiance of the reference white, taken
once from the palette given and then kept, so that a light's scale does change r; e is the exposure.  Two kinds of
bounds follow.  *Upper* ones hold for every pixel: bounds of each band, or both sides of the slabs of several bands
that bound a monitor or the solid of a printer's colours.  *Dark* ones, if the gamut keeps black, count only for pixels
that are above black with the palette given, because no parameter lifts the shadows that every picture has.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int

from symrt.arrays import PixelBands, Spectrum
from symrt.errors import require
from symrt.feedback.along import check_settled
from symrt.feedback.bounds import Bound, bound_of
from symrt.feedback.solids import Solid
from symrt.gamut.interface import ConvexGamut, SlabGamut, Slabs, stacked
from symrt.gamut.intersections import InkIntersection, UnevenGamut
from symrt.gamut.recipes import InkGamut
from symrt.gamut.slabs import Gamut
from symrt.spectra.bands import Bands
from symrt.spectra.certificate import tail_bound
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, as_asked
from symrt.spectra.shading import check_names, shade
from symrt.system import LinearSystem

Pixels = Int[np.ndarray, " pixel"]
INVISIBLE = 1e-6
"""Bands in which the reference white has less than this share of its maximum say nothing about reflectance."""


@dataclass(frozen=True, eq=False)
class Limits:
    """A gamut, seen against a reference white.

    Parameters
    ----------
    upper
        The upper bounds.
    solids
        Parts of the gamut that have a black of their own.
    dark
        The lower bounds, None where black is clipped.
    luminance
        The weights of a radiance's luminance, of the reference white's 1.
    blackest
        The luminance of the device's black.
    masked
        Bands that the reference white does not light.
    reference
        The reference and the exposure, in words.
    cut_off
        A bound on the reflectance that the depth limit left out of any pixel, and of every result.
    """

    gamut: ConvexGamut | UnevenGamut
    upper: Bound
    dark: Bound | None
    luminance: Spectrum
    blackest: float
    masked: Bool[np.ndarray, " band"]
    reference: str
    cut_off: float = 0.0
    solids: tuple[Solid, ...] = ()

    @property
    def bands(self) -> Bands:
        """Bands of the radiances."""
        return self.gamut.bands

    @property
    def slow(self) -> bool:
        """True if some part of the gamut is no intersection of slabs, so that pixels are asked about one by one."""
        return any(solid.bound is None for solid in self.solids)

    @property
    def note(self) -> str:
        """Gamut, reference and exposure, and anything modelled or left out, in words."""
        labels = [label for label, hidden in zip(self.bands.labels, self.masked, strict=True) if hidden]
        masked = f"; not lit and left out: {', '.join(labels)}" if labels else ""
        cut = f"; the depth limit left out at most {self.cut_off:.2g} of a pixel" if self.cut_off else ""
        return f"{described(self.gamut)}; {self.reference}{masked}{cut}"


def check_kinds(system: LinearSystem, palette: Palette, gamut: ConvexGamut | UnevenGamut) -> None:
    """Refuse a question whose parts were swapped, or not yet made, and warn of names that seem misspelt.

    Raises
    ------
    TypeError
        That says which part is what, and what makes the right one.
    """
    check_names(system, palette)
    require("gamut", gamut, (ConvexGamut, InkGamut, InkIntersection), "device_gamut(load_device(name), model)")


def described(gamut: ConvexGamut | UnevenGamut) -> str:
    """A gamut in words, with what being inside proves, and which of its devices are modelled.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> described(device_gamut(load_device("synthetic-cmyk")))
    'unit gamut (0 … 1), black clipped (necessary for a print of any printer; a synthetic halftone printer of 4 inks)'
    """
    modelled = "".join(f"; {device.title}" for device in gamut.devices if device.modelled)
    return f"{gamut.name} ({gamut.label}{modelled})"


def limits(
    system: LinearSystem, palette: Palette, gamut: ConvexGamut | UnevenGamut, reference: Reference | None = None
) -> Limits:
    """The bounds of a gamut on the radiances of a system.

    Raises
    ------
    ValueError
        If the palette is not on the gamut's bands, the reference leaves bands dark that the gamut needs, or there is
        no such reference.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.device.inks import load_device
    >>> from symrt.gamut.gamuts import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 0.25})
    >>> asked = limits(system, Palette(device.bands, {"sun": 8}), device_gamut(device), Reference(exposure=0.5))
    >>> asked.upper.matrix[0, 0].item(), asked.reference
    (0.25, 'reference sun, exposure 0.5')
    """
    # Refuse spectra on other bands.
    check_kinds(system, palette, gamut)
    if palette.bands != gamut.bands:
        raise ValueError(
            f"the palette is in {palette.bands!r}, {gamut.name} in {gamut.bands!r}: use palette.on(gamut.bands), or "
            "load_device(name, palette.bands)"
        )

    # See the gamut against the white, whose dark bands say nothing about reflectance.
    reference = as_asked(reference)
    white = reference.white(system, palette)
    visible = white >= INVISIBLE * white.max()
    under = gamut.under(white)
    weights = luminance_weights(gamut.bands) * white
    weights = weights / weights.sum()
    shown = np.zeros(len(white))
    shown[visible] = reference.exposure / white[visible]

    # Slabs of all flat parts are asked together, solids one by one.
    parts = _parts(under)
    flat = [part.slabs for part in parts if isinstance(part, SlabGamut) and not _has_own_black(part)]
    slabs = stacked(flat, len(white))
    left_out = None if system.tail is None else tail_bound(system.tail, palette) * shown
    return Limits(
        gamut=under,
        upper=_upper(slabs, shown),
        dark=_dark(slabs, shown),
        luminance=weights * shown,
        blackest=max((float((device.samples @ weights).min()) for device in gamut.devices), default=0.0),
        masked=~visible,
        reference=f"reference {reference.called(system, palette)}, exposure {reference.exposure:g}",
        cut_off=0.0 if left_out is None else float(left_out.max()),
        solids=tuple(_solid(part, shown) for part in parts if _has_own_black(part)),
    )


UNSIGNED = "; or collapse with lengths = 'hats', whose weights are not negative"
"""The way out where lengths in glass are interpolated by Chebyshev's weights."""
OTHERWISE = "; or give the material a model that only adds, 'metal' for 'metal_f82'"
"""The way out of questions that negative coefficients stop, for whoever made the scene."""


def rising_limits(
    system: LinearSystem, palette: Palette, gamut: ConvexGamut | UnevenGamut, reference: Reference | None = None
) -> Limits:
    """As `limits`, but refuse gamuts in which more light can bring a pixel back inside.

    Raises
    ------
    ValueError
        As `limits` does, if more light may bring a pixel inside, and if more of a material may darken one.

    Examples
    --------
    See `limits`.
    """
    asked = limits(system, palette, gamut, reference)
    check_settled(system)
    if asked.upper.signed or asked.solids:
        raise ValueError(
            f"{asked.gamut.name}: more light may bring a colour inside as well as out, so that scales cannot be fitted "
            "together: use adapt, which fits them to the device's envelope and dims; or feasible, for one parameter"
        )
    # The column that is named is one of few reflectances.
    if column := min(system.signed, key=lambda i: (i.degree, i), default=None):
        raise ValueError(
            f"{column} has negative coefficients ({system.signed[column]}), so that a scale can darken a pixel: ask "
            f"for one scale at a time, with feasible{OTHERWISE if system.subtracting else ''}"
            f"{UNSIGNED if any(how.scheme == 'chebyshev' for how in system.lengths.values()) else ''}"
        )
    return asked


def white_in_every_band(
    system: LinearSystem, palette: Palette, reference: Reference, gamuts: Sequence[ConvexGamut | UnevenGamut]
) -> Spectrum:
    """The radiance that is a reflectance of 1, for gamuts that look at all bands at once.

    Raises
    ------
    ValueError
        If a gamut is on other bands than the palette, or the reference leaves bands dark.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.device.inks import load_device
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 0.25})
    >>> palette = Palette(load_device("dye3-endura-premier").bands, {"sun": 8})
    >>> white_in_every_band(system, palette, Reference(exposure=0.5), [])[0].item()
    4.0
    """
    for gamut in gamuts:
        check_kinds(system, palette, gamut)
        if gamut.bands != palette.bands:
            raise ValueError(
                f"{gamut.name} is on {gamut.bands!r}, the palette on {palette.bands!r}: use the same bands"
            )
    white = reference.white(system, palette)
    if dark := [b for b, w in zip(palette.bands.labels, white, strict=True) if w < INVISIBLE * white.max()]:
        raise ValueError(f"the reference does not light {', '.join(dark)}: use Reference('equal-energy')")
    return white / reference.exposure


def reflectances(system: LinearSystem, palette: Palette, white: Spectrum, pixels: Pixels) -> PixelBands:
    """Reflectances of some of the pixels, seen against a white.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem.of("0.25*sun*sea.diffuse", "0.5*sun*sea.diffuse", white={"sun": 0.5})
    >>> palette = Palette(RGB, {"sun": 2, "sea.diffuse": [0.2, 0.4, 0.8]})
    >>> reflectances(system, palette, np.ones(3), np.array([1]))
    array([[0.2, 0.4, 0.8]])
    """
    return shade(system.rows(pixels), palette).values[0] / white


def _parts(gamut: ConvexGamut | UnevenGamut) -> list[ConvexGamut | UnevenGamut]:
    """The gamuts that one is the intersection of; itself, if it is none."""
    return [part for one in getattr(gamut, "parts", ()) for part in _parts(one)] or [gamut]


def _has_own_black(gamut: ConvexGamut | UnevenGamut) -> bool:
    """True if its dark end is that of prints, and not bounds band by band or a monitor's."""
    return bool(gamut.devices) and not isinstance(gamut, Gamut)


def _solid(gamut: ConvexGamut | UnevenGamut, shown: Spectrum) -> Solid:
    """One of them against the reference."""
    if not isinstance(gamut, SlabGamut) and not shown.all():
        raise ValueError(f"the reference leaves bands dark that {gamut.name} needs: use Reference('equal-energy')")
    bound = None
    if isinstance(gamut, SlabGamut):
        bound = bound_of(gamut.slabs, shown, gamut.slabs.lower, gamut.slabs.upper)
    return Solid(gamut, bound, shown)


def _upper(slabs: Slabs, shown: Spectrum) -> Bound:
    """Bounds that count for every pixel; a lower one that no sum of light can miss is left out."""
    idle = slabs.dark | ((slabs.matrix >= 0).all(axis=0) & (slabs.lower <= 0))
    lower = np.where(idle, -np.inf, slabs.lower)
    return bound_of(slabs, shown, lower, slabs.upper)


def _dark(slabs: Slabs, shown: Spectrum) -> Bound | None:
    lower = np.where(slabs.dark & (slabs.lower > 0), slabs.lower, -np.inf)
    bound = bound_of(slabs, shown, lower, np.full(len(lower), np.inf))
    return bound if len(bound.bands) else None
