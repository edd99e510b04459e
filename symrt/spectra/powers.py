"""What absorbing glass leaves of light: powers of its transmittance, which Γ is multiplied by (step 3 of the paper)."""

import numpy as np

from symrt.arrays import Spectrum
from symrt.spectra.palette import Palette

Power = tuple[str, float]
"""A transmittance, and the length that it is raised to."""


def power_of(palette: Palette, power: Power) -> Spectrum:
    """The power of a transmittance that is left after a length.

    Raises
    ------
    ValueError
        If the transmittance passes 1, which only an unphysical palette can hold.

    Examples
    --------
    >>> from symrt.spectra.bands import RGB
    >>> power_of(Palette(RGB, {"wine.transmittance": [1, 0.25, 0]}), ("wine.transmittance", 1.5))
    array([1.   , 0.125, 0.   ])
    """
    name, length = power
    spectrum = palette[name] if name in palette else np.zeros(len(palette.bands))
    if spectrum.max() > 1:
        raise ValueError(
            f"{name} reaches {spectrum.max():g}: light would grow on its way; a transmittance is at most 1"
        )
    return np.asarray(spectrum**length)
