"""The shares of windows of wavelengths at the bands of a palette, which Γ is multiplied by (step 3 of the paper)."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from symrt.interactions import Interaction
from symrt.spectra.bands import Bands


def hats(interactions: Sequence[Interaction], bands: Bands) -> Float[np.ndarray, "interaction band"]:
    """The share of each interaction's window at each band: 1 where it has none.

    Raises
    ------
    ValueError
        If there are windows, and the bands are no wavelengths, or others.

    Examples
    --------
    >>> from symrt.windows import SpectralWindow
    >>> hats([Interaction("sun"), Interaction("sun", window=SpectralWindow(400, 500, 700))], Bands((450.0, 600.0)))
    array([[1. , 1. ],
           [0.5, 0.5]])
    """
    windows = {interaction.window for interaction in interactions if interaction.window}
    if windows and bands.kind != "wavelength":
        raise ValueError(
            f"the palette's bands are {bands!r}, and glass bends wavelengths apart here: take a palette in nm, such as "
            "wavelengths(380, 730, 10), or render without dispersion, force={'dispersion': False}"
        )
    nm = np.array(bands.centres, dtype=float)
    shares = {window: window.weights(nm) for window in sorted(windows)}
    return np.array([shares[i.window] if i.window else np.ones(len(nm)) for i in interactions]).reshape(-1, len(nm))
