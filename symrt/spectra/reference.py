"""The reference white: what turns the radiances of step 3 into reflectances and display values.

Pixels are radiances, gamuts are reflectances: ``r = exposure · p / w``, where w(λ) is the radiance of a perfect
diffuser that stands at the camera's target, faces the key light, and is lit by it alone.
"""

from dataclasses import dataclass

import numpy as np

from symrt.arrays import Spectrum
from symrt.spectra.bands import Number
from symrt.spectra.display import of_same_luminance
from symrt.spectra.palette import Palette, did_you_mean
from symrt.system import LinearSystem

__all__ = ["Reference", "key_light"]


@dataclass(frozen=True)
class Reference:
    """Which white a picture is seen against, and how strongly it is exposed.

    Parameters
    ----------
    light
        A light of the scene; or ``"equal-energy"``, a constant; or a viewing illuminant such as ``"illuminant/A"``.
        The last two get the luminance of the key light's white.  None: the key light, see `key_light`.
    exposure
        Factor on every radiance.
    """

    light: str | None = None
    exposure: Number = 1.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.exposure) and self.exposure > 0):
            raise ValueError(
                f"exposure = {self.exposure}: it must be above 0, and 1 shows the reference white as white"
            )

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
        whites = {name: value * palette[name] for name, value in system.white.items() if name in palette}
        if self.light in whites:
            return _not_black(str(self.light), whites[str(self.light)])
        key = key_light(system, palette)
        if self.light is None:
            return _not_black(key, whites[key])
        if self.light != "equal-energy" and not self.light.lower().startswith("illuminant/"):
            named = did_you_mean([self.light], whites)
            raise ValueError(f"no light {named} in the scene: give a light, 'equal-energy' or 'illuminant/…'")
        return of_same_luminance(self.light, _not_black(key, whites[key]), palette.bands)


def key_light(system: LinearSystem, palette: Palette) -> str:
    """The first light of the scene that is not ambient and not black.

    An ambient light is known by its white: a diffuser returns exactly its radiance, so that the coefficient is 1.
    """
    lit = [name for name in system.lights if name in palette and palette[name].any()]
    directed = [name for name in lit if system.white[name] != 1.0 and system.white[name] > 0]
    if not lit:
        raise ValueError(f"none of the scene's lights ({', '.join(system.lights)}) shines in this palette")
    return (directed or lit)[0]


def _not_black(name: str, white: Spectrum) -> Spectrum:
    if not white.any():
        raise ValueError(f"the reference light {name!r} is black: choose another, or 'equal-energy'")
    return white
