"""The reference white: what turns the radiances of step 3 into reflectances and display values.

Pixels are radiances, gamuts are reflectances: ``r = exposure · p / w``, where w(λ) is the radiance of a perfect
diffuser that stands at the camera's target, faces the key light, and is lit by it alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from symrt.arrays import Spectrum
from symrt.errors import require, shown
from symrt.spectra.bands import Number
from symrt.spectra.display import check_exposure, white_among
from symrt.spectra.palette import Palette
from symrt.system import LinearSystem


@dataclass(frozen=True)
class Reference:
    """The white that a picture is seen against, and the exposure.

    Parameters
    ----------
    light
        A light of the scene; or ``"equal-energy"``, a constant; or a viewing illuminant such as ``"illuminant/A"``.
        The last two get the luminance of the first white.  None: the white that the palette carries, or else the key
        light's, see `whites`.
    exposure
        Factor on every radiance.
    radiance
        Of a white that is fixed, one number a band, whatever the palette; `light` then only says whose it was.

    Examples
    --------
    >>> Reference("sun", radiance=[1.0, 1.0, 0.5]).radiance
    (1.0, 1.0, 0.5)
    """

    light: str | None = None
    exposure: Number = 1.0
    radiance: Sequence[float] | Spectrum | None = None

    def __post_init__(self) -> None:
        if self.light is not None:
            require("light", self.light, str, "the name of a light, 'equal-energy' or an illuminant, 'illuminant/D65'")
        if self.radiance is not None:
            try:
                values = tuple(float(value) for value in self.radiance)
            except (TypeError, ValueError):
                raise TypeError(f"radiance = {shown(self.radiance)}: give numbers, one a band") from None
            if not (all(np.isfinite(value) and value >= 0 for value in values) and any(values)):
                raise ValueError(f"radiance = {shown(values)}: a white is finite, not negative, and not black")
            object.__setattr__(self, "radiance", values)
        check_exposure(self.exposure)

    def white(self, system: LinearSystem, palette: Palette) -> Spectrum:
        """Radiance w of the reference white, which ``exposure`` does not change.

        Raises
        ------
        ValueError
            If there is no such light, or it gives no light at all.

        Examples
        --------
        A directional light of irradiance π gives a perfect diffuser that faces it radiance 1:

        >>> from scipy import sparse
        >>> from symrt.spectra.bands import RGB
        >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sun": 1 / np.pi})
        >>> Reference("sun").white(system, Palette(RGB, {"sun": np.pi}))
        array([1., 1., 1.])
        """
        # A white that is fixed.
        if self.radiance is not None:
            if len(self.radiance) != len(palette.bands):
                raise ValueError(
                    f"the reference's white has {len(self.radiance)} bands and the palette {palette.bands!r}: give one "
                    "on the same bands"
                )
            return np.array(self.radiance)

        # A light that shines in this palette, or another white as bright as the first.
        shining = whites(system, palette)
        if not shining:
            raise ValueError(f"none of the scene's lights ({', '.join(system.lights)}) shines in this palette")
        if self.light in system.lights and self.light not in shining:
            raise ValueError(f"the reference light {self.light!r} is black: choose another, or 'equal-energy'")
        return white_among(shining, self.light, palette.bands)

    def called(self, system: LinearSystem, palette: Palette) -> str:
        """The white in a word or two: the name of a light, or of what else it is."""
        if self.radiance is not None:
            return f"{self.light} as it was" if self.light else "a fixed white"
        return self.light or next(iter(whites(system, palette)), "")

    def kept(self, system: LinearSystem, palette: Palette) -> "Reference":
        """The same reference with its white fixed, so that no later change of the palette moves it."""
        name = self.light if self.radiance is not None else self.called(system, palette)
        return Reference(name, self.exposure, self.white(system, palette))


GIVEN = "the palette's white"
"""The name of the white that a palette carries; no light can have it."""


def as_asked(reference: Reference | None) -> Reference:
    """The reference given; None, the default one; anything else is refused.

    Examples
    --------
    >>> as_asked(None)
    Reference(light=None, exposure=1.0, radiance=None)
    """
    if reference is None:
        return Reference()
    require("reference", reference, Reference, "Reference('sun', exposure=1.0)")
    return reference


def whites(system: LinearSystem, palette: Palette) -> dict[str, Spectrum]:
    """For each light that shines, the radiance of a perfect diffuser that faces it; the key light's first.

    Before them stands the white that the palette carries, if it does.

    The key light is the first light of the scene that is not ambient.  An ambient one is known by its coefficient, 1: a
    diffuser returns exactly the radiance that surrounds it.  A surface that glows shines on no diffuser: where nothing
    else shines the white is the surface itself.
    """
    shining = {name: value * palette[name] for name, value in system.white.items() if name in palette and value > 0}
    lit = {name: white for name, white in shining.items() if white.any()}
    own = {} if palette.white is None else {GIVEN: np.asarray(palette.white, dtype=float)}
    return own | dict(sorted(lit.items(), key=lambda item: _precedence(system, item[0])))


def _precedence(system: LinearSystem, light: str) -> int:
    """The place among lights: first those that shine on a diffuser, then ambient ones, then surfaces that glow."""
    return 0 if system.white[light] != 1.0 else 2 if light in system.glowing else 1


def key_light(system: LinearSystem, palette: Palette) -> str | None:
    """The first light of the scene that shines and is not ambient; an ambient one if no other does; None if none.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.spectra.bands import RGB
    >>> system = LinearSystem(sparse.csr_array((1, 0)), (), height=1, width=1, white={"sky": 1.0, "sun": 1 / np.pi})
    >>> key_light(system, Palette(RGB, {"sky": 1, "sun": 2}))
    'sun'
    """
    return next((name for name in whites(system, palette) if name != GIVEN), None)
