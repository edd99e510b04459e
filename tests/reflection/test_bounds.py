"""Bounds of formulas hold, and hold what stands in them together."""

import numpy as np
import pytest

from symrt.reflection import MODELS, diffuse, mirror, reflectance
from symrt.reflection.bounds import largest


def test_a_highlight_is_bounded_with_f0_and_1_minus_f0_together():
    # (s + 8)/8π times a reflectance that is at most 1.
    ranges = {"exponent": (40.0, 40.0)}
    assert largest(MODELS["rough_metal"].direct, ranges) == pytest.approx(48 / (8 * np.pi), rel=1e-12)
    assert largest(diffuse - mirror, {}) == 1
    # Where a reflectance stands squared no end of its range is the largest: (1 - d) d is 1/4 at 1/2.
    assert largest(diffuse * (1 - diffuse) * reflectance("coat"), {}) >= 0.25
