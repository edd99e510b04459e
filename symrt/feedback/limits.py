"""What a gamut asks of an image's radiances: step 5 of the paper, between pixels and gamuts.

Pixels are radiances and gamuts are reflectances, ``r = e · p / w``: w(λ) is the radiance of the reference white, taken
once from the palette given and then kept, so that a light's scale does change r; e is the exposure.  Two kinds of
bounds follow.  *Upper* ones hold in every band.  *Dark* ones, if the gamut keeps black, count only for pixels that are
above black with the palette given, because no parameter lifts the shadows that every picture has.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import Spectrum
from symrt.gamut.interface import ConvexGamut
from symrt.gamut.slabs import Gamut
from symrt.spectra.bands import Bands
from symrt.spectra.display import luminance_weights
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference, whites
from symrt.spectra.shading import tail_bound
from symrt.system import LinearSystem

__all__ = ["Bound", "Limits", "limits"]

INVISIBLE = 1e-6
"""Bands in which the reference white has less than this share of its maximum say nothing about reflectance."""


@dataclass(frozen=True, eq=False)
class Bound:
    """Slabs ``lower <= p A <= upper`` of a radiance p.

    Parameters
    ----------
    matrix
        A: one column a slab.
    bands
        The band that each slab bounds; -1 for luminance.
    """

    matrix: Float[np.ndarray, "band slab"]
    lower: Float[np.ndarray, " slab"]
    upper: Float[np.ndarray, " slab"]
    bands: Int[np.ndarray, " slab"]


@dataclass(frozen=True, eq=False)
class Limits:
    """A gamut, seen against a reference white.

    Parameters
    ----------
    upper
        The upper bounds.
    dark
        The lower bounds, None where black is clipped.
    luminance
        What gives a radiance's luminance, of the reference white's 1.
    blackest
        The luminance of the device's black.
    masked
        Bands that the reference white does not light.
    reference
        The reference and the exposure, in words.
    cut_off
        A bound on the reflectance that the depth limit left out of any pixel, and of every result.
    """

    gamut: Gamut
    upper: Bound
    dark: Bound | None
    luminance: Spectrum
    blackest: float
    masked: Bool[np.ndarray, " band"]
    reference: str
    cut_off: float = 0.0

    @property
    def bands(self) -> Bands:
        """Bands of the radiances."""
        return self.gamut.bands

    @property
    def note(self) -> str:
        """Gamut, reference, exposure, and what is modelled or left out, in words."""
        device = self.gamut.device
        modelled = f"; {device.title}" if device.modelled else ""
        labels = [label for label, hidden in zip(self.bands.labels, self.masked, strict=True) if hidden]
        masked = f"; not lit and left out: {', '.join(labels)}" if labels else ""
        cut = f"; the depth limit left out at most {self.cut_off:.2g} of a pixel" if self.cut_off else ""
        return f"{self.gamut.name} ({self.gamut.label}{modelled}); {self.reference}{masked}{cut}"


def limits(system: LinearSystem, palette: Palette, gamut: object, reference: Reference | None = None) -> Limits:
    """The bounds of a gamut on the radiances of a system.

    Raises
    ------
    ValueError
        If the gamut has no bounds band by band, the palette is not on its bands, or there is no such reference.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.gamut.inks import load_device
    >>> from symrt.gamut.slabs import device_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 0.25})
    >>> asked = limits(system, Palette(device.bands, {"sun": 8}), device_gamut(device), Reference(exposure=0.5))
    >>> asked.upper.matrix[0, 0].item(), asked.reference
    (0.25, 'reference sun, exposure 0.5')
    """
    if not isinstance(gamut, Gamut):
        raise ValueError(  # noqa: TRY004  # another model of the same device is a bad choice, not another type to a user
            f"{getattr(gamut, 'name', gamut)}: ranges and fits need bounds in each band; use device_gamut(device, "
            "'envelope') or 'unit', and report or map_pixels for this one"
        )
    if palette.bands != gamut.bands:
        raise ValueError(
            f"the palette is in {palette.bands!r} and the gamut of {gamut.device.name} in {gamut.bands!r}: use "
            "palette.on(gamut.bands), or load_device(name, palette.bands)"
        )
    reference = reference or Reference()
    name = reference.light or next(iter(whites(system, palette)), "")
    white = reference.white(system, palette)
    visible = np.flatnonzero(white >= INVISIBLE * white.max())
    gamut = gamut.under(white)
    weights = luminance_weights(gamut.bands) * white
    weights = weights / weights.sum()
    shown = np.zeros(len(white))
    shown[visible] = reference.exposure / white[visible]
    reflected = np.diag(shown)[:, visible]
    left_out = None if system.tail is None else tail_bound(system.tail, palette)[visible] * shown[visible]
    return Limits(
        gamut=gamut,
        upper=Bound(reflected, np.full(len(visible), -np.inf), gamut.upper[visible], visible),
        dark=_dark(gamut, reflected, visible, shown),
        luminance=weights * shown,
        blackest=float((gamut.device.samples @ weights).min()),
        masked=shown == 0,
        reference=f"reference {name}, exposure {reference.exposure:g}",
        cut_off=0.0 if left_out is None else float(left_out.max()),
    )


def white_in_every_band(
    system: LinearSystem, palette: Palette, reference: Reference, gamuts: Sequence[ConvexGamut]
) -> Spectrum:
    """The radiance that is a reflectance of 1, for gamuts that look at all bands at once.

    Raises
    ------
    ValueError
        If a gamut is on other bands than the palette, or the reference leaves bands dark.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.gamut.inks import load_device
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 0.25})
    >>> palette = Palette(load_device("dye3-endura-premier").bands, {"sun": 8})
    >>> white_in_every_band(system, palette, Reference(exposure=0.5), [])[0].item()
    4.0
    """
    for gamut in gamuts:
        if gamut.bands != palette.bands:
            raise ValueError(
                f"{gamut.name} is on {gamut.bands!r}, the palette on {palette.bands!r}: use the same bands"
            )
    white = reference.white(system, palette)
    if dark := [b for b, w in zip(palette.bands.labels, white, strict=True) if w < INVISIBLE * white.max()]:
        raise ValueError(f"the reference does not light {', '.join(dark)}: use Reference('equal-energy')")
    return white / reference.exposure


def _dark(
    gamut: Gamut, reflected: Float[np.ndarray, "band slab"], visible: Int[np.ndarray, " slab"], shown: Spectrum
) -> Bound | None:
    if gamut.weights is not None:
        row = (gamut.weights * shown)[:, None]
        return Bound(row, np.array([gamut.blackest]), np.array([np.inf]), np.array([-1]))
    if not gamut.lower.any():
        return None
    return Bound(reflected, gamut.lower[visible], np.full(len(visible), np.inf), visible)
