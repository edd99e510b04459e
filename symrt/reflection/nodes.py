"""Choose the nodes that make a nonlinear parameter linear (step 2).

A cosine's power is interpolated in ln s: ``cos^s = Σ_j ℓ_j(ln s) cos^{s_j}`` at Chebyshev nodes.  In s itself the same
number of nodes is orders of magnitude worse.
"""

import numpy as np

from symrt.nodes import Nodes

MOST = 32
"""Largest number of nodes that are tried."""


def choose_nodes(parameter: str, low: float | int, high: float | int, tolerance: float = 1e-6) -> Nodes:
    """The fewest nodes that interpolate every power cos^s, s in [low, high], within `tolerance`.

    Raises
    ------
    ValueError
        If the range is empty or not positive, or needs more than 32 nodes.

    Examples
    --------
    >>> choose_nodes("brass.exponent", 5.0, 80.0, 1e-4).count
    9
    """
    if not 0 < low < high < np.inf:
        raise ValueError(
            f"{parameter} in [{low}, {high}]: a free parameter needs a range of positive numbers, low < high"
        )
    for count in range(2, MOST + 1):
        nodes = Nodes(parameter, float(low), float(high), count)
        if interpolation_error(nodes) <= tolerance:
            return nodes
    raise ValueError(
        f"{parameter} in [{low}, {high}] needs more than {MOST} nodes for {tolerance}; free a smaller range"
    )


def interpolation_error(nodes: Nodes) -> float:
    """The largest error of an interpolated power, measured over cosines and exponents between the nodes.

    Examples
    --------
    >>> interpolation_error(Nodes("brass.exponent", 5.0, 80.0, 12)) < 4e-6
    True
    """
    # Eight exponents to each node, and cosines that lie closest together near 1, where powers change fastest.
    exponents = np.exp(np.linspace(np.log(nodes.low), np.log(nodes.high), 8 * nodes.count + 1))[1:-1]
    cosines = np.concatenate([[0.0], 1 - np.logspace(-6, 0, 400)[:-1], [1.0]])
    exact = cosines[:, None] ** exponents
    at_nodes = cosines[:, None] ** np.array(nodes.values)
    weights = np.stack([nodes.weights(float(s)) for s in exponents])
    return float(np.abs(at_nodes @ weights.T - exact).max())
