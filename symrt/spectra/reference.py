"""The reference white: what turns the radiances of step 3 into reflectances and display values.

Pixels are radiances, gamuts are reflectances: ``r = exposure · p / w``, where w(λ) is the radiance of a perfect
diffuser that stands at the camera's target, faces the key light, and is lit by it alone.
"""

from dataclasses import dataclass

import numpy as np

from symrt.arrays import Spectrum
from symrt.spectra.bands import Number
from symrt.spectra.display import white_among
from symrt.spectra.palette import Palette
from symrt.system import LinearSystem

__all__ = ["Reference", "whites"]


@dataclass(frozen=True)
class Reference:
    """Which white a picture is seen against, and how strongly it is exposed.

    Parameters
    ----------
    light
        A light of the scene; or ``"equal-energy"``, a constant; or a viewing illuminant such as ``"illuminant/A"``.
        The last two get the luminance of the key light's white.  None: the key light, see `whites`.
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
        shining = whites(system, palette)
        if not shining:
            raise ValueError(f"none of the scene's lights ({', '.join(system.lights)}) shines in this palette")
        if self.light in system.lights and self.light not in shining:
            raise ValueError(f"the reference light {self.light!r} is black: choose another, or 'equal-energy'")
        return white_among(shining, self.light, palette.bands)


def whites(system: LinearSystem, palette: Palette) -> dict[str, Spectrum]:
    """For each light that shines, the radiance of a perfect diffuser that faces it; the key light's first.

    The key light is the first light of the scene that is not ambient.  An ambient one is known by its coefficient, 1: a
    diffuser returns exactly the radiance that surrounds it.
    """
    shining = {name: value * palette[name] for name, value in system.white.items() if name in palette and value > 0}
    lit = {name: white for name, white in shining.items() if white.any()}
    return dict(sorted(lit.items(), key=lambda item: system.white[item[0]] == 1.0))
