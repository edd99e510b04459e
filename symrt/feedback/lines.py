"""Every pixel along a parameter of either kind: step 5 of the paper, polynomials or mixtures of paints."""

from symrt.feedback.along import Along, along
from symrt.feedback.paints import Paints, paints
from symrt.feedback.parameters import Parameter, mixing_of, moved_ends
from symrt.spectra.palette import Palette
from symrt.system import LinearSystem

Line = Along | Paints


def line_of(system: LinearSystem, palette: Palette, parameter: Parameter) -> Line:
    """Every pixel's radiance along a parameter: a polynomial, or a blend of paints.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.feedback.parameters import Blend
    >>> from symrt.spectra.bands import RGB
    >>> from symrt.interactions import Interaction
    >>> columns = (Interaction("key", ("ice.diffuse",)), Interaction("key", ("sea.diffuse",)))
    >>> system = LinearSystem(sparse.csr_array([[0.0, 1.0]]), columns, height=1, width=1, white={"key": 1.0})
    >>> palette = Palette(RGB, {"key": 1.0, "sea.diffuse": 0.5, "ice.diffuse": 1.0})
    >>> line_of(system, palette, Blend("sea", "ice", "kubelka-munk")).at(0.5).round(4)
    array([[0.6096, 0.6096, 0.6096]])
    """
    if mixing_of(parameter) == "linear":
        return along(system, palette, parameter)
    return paints(system, palette, moved_ends(system, palette, parameter))
