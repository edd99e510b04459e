"""A free exponent by interpolation: the figures of the method, and its refusals."""

import mpmath
import numpy as np
import pytest

from symrt.nodes import Nodes
from symrt.reflection.nodes import choose_nodes, interpolation_error


@pytest.mark.parametrize(("low", "high", "tolerance"), [(5.0, 80.0, 2e-4), (5.0, 80.0, 3e-6), (1.0, 200.0, 5e-5)])
def test_chosen_nodes_keep_their_tolerance_between_the_nodes(low, high, tolerance):
    nodes = choose_nodes("brass.exponent", low, high, tolerance)
    draws = np.random.default_rng(1).uniform(0, 1, (500, 2))
    for u, cosine in draws:
        s = low * (high / low) ** u
        found = nodes.weights(s) @ cosine ** np.array(nodes.values)
        assert abs(found - float(mpmath.power(cosine, s))) <= 1.5 * tolerance


def test_nodes_in_the_exponent_itself_are_far_worse_than_in_its_logarithm():
    logarithmic = interpolation_error(Nodes("e", 5.0, 80.0, 12, "log"))
    linear = interpolation_error(Nodes("e", 5.0, 80.0, 12, "linear"))
    assert linear > 100 * logarithmic


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 5.0), (5.0, 5.0), (9.0, 5.0), (1.0, float("inf")), (float("nan"), 2.0)]
)
def test_an_impossible_range_is_refused(low, high):
    with pytest.raises(ValueError, match="range of positive numbers"):
        choose_nodes("brass.exponent", low, high)
