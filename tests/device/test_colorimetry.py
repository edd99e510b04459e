"""Colours of spectra that are known in part of what the eye sees."""

import numpy as np
import pytest

from symrt.device.colorimetry import tristimulus
from symrt.spectra.bands import Bands, wavelengths
from symrt.spectra.library import colour_science


@pytest.mark.parametrize("bands", [wavelengths(800, 900, 10), wavelengths(380, 500, 10), Bands((550.0,))])
def test_colours_of_what_was_mostly_not_measured_are_refused(bands):
    with pytest.raises(ValueError, match=r"span \d+% of what the eye sees under illuminant/A, .* about 400 … 700 nm"):
        tristimulus(bands, "illuminant/A")


def test_the_share_that_decides_is_that_of_the_luminance():
    colour = colour_science()
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    # Of an equal-energy light, every nanometre; half of what is seen is seen up to this wavelength.
    seen = np.cumsum(observer.values[:, 1]) / observer.values[:, 1].sum()
    half = float(observer.wavelengths[np.searchsorted(seen, 0.5)])
    assert tristimulus(Bands((380.0, half + 2)), "illuminant/E").shape == (2, 3)
    with pytest.raises(ValueError, match=r"span 4[89]%"):
        tristimulus(Bands((380.0, half - 2)), "illuminant/E")
