"""The pixels that a question is about, and their weights: step 5 of the paper, shares of an image.

The paper lets "some percentage of out-of-gamut pixels" pass.  Whose percentage is a choice: of all pixels that light
reaches, of an object's, or weighted by what somebody looks at.  Weights are brought to whole numbers, so that their
sums are exact and do not depend on the order.
"""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.interactions import Interaction
from symrt.spectra.bands import Number
from symrt.spectra.palette import did_you_mean
from symrt.symbols import Symbol
from symrt.system import LinearSystem

LARGEST_SUM = 61
"""Weights add up to less than 2⁶², so that no share is off by more than 2⁻⁴³ with half a million pixels."""
SLACK = Fraction(1, 10**9)
"""A share such as 0.05, and a weight such as 0.3, are themselves rounded: so much of a pixel, or of the share."""

Pixels = Int[np.ndarray, " _"]
Mask = Bool[np.ndarray, "height width"]


@dataclass(frozen=True, eq=False)
class Weighed:
    """The pixels that a question is about, in order, and the weight of each.

    Parameters
    ----------
    pixels
        Their numbers, ``y · width + x``.
    weights
        Whole numbers; None if each counts 1.
    note
        The pixels asked about, in words, if they are not all object pixels; else empty.
    """

    pixels: Pixels
    weights: Int[np.ndarray, " _"] | None = None
    note: str = ""

    def of(self, pixels: Pixels) -> Int[np.ndarray, " _"]:
        """The weight of each of some of the pixels."""
        if self.weights is None:
            return np.ones(len(pixels), dtype=np.int64)
        return self.weights[np.searchsorted(self.pixels, pixels)]

    def sum(self, pixels: Pixels) -> int:
        """The sum of the weights of some of the pixels.

        Examples
        --------
        >>> Weighed(np.array([2, 5, 7]), np.array([1, 10, 100])).sum(np.array([2, 7]))
        101
        """
        return len(pixels) if self.weights is None else int(self.of(pixels).sum())

    def allowance(self, share: Number, pixels: Pixels) -> int:
        """The largest sum of weights that is no more than a share of these pixels', but for rounding.

        Examples
        --------
        >>> Weighed(np.arange(20)).allowance(0.05, np.arange(20))
        1
        """
        if self.weights is None:
            return int(share * len(pixels) + float(SLACK))
        return int(self.sum(pixels) * Fraction(float(share)) * (1 + SLACK))


def weighed(
    system: LinearSystem, weights: Float[np.ndarray, "height width"] | None = None, mask: Mask | None = None
) -> Weighed:
    """The object pixels where the mask is true, with their weights; a pixel of weight 0 is left out.

    Raises
    ------
    ValueError
        If weights or mask have another size than the image, or leave nothing to ask about, or if a weight is negative
        or not finite.

    Examples
    --------
    >>> system = LinearSystem.of("0.2*sun*sea.diffuse", "0", "0.3*sun*sea.diffuse", white={"sun": 1.0})
    >>> found = weighed(system, weights=np.array([[1.0, 2.0, 3.0]]))
    >>> found.pixels, (found.weights / found.weights.sum()).tolist()
    (array([0, 2]), [0.25, 0.75])
    """
    # All object pixels, if nothing else is said.
    objects = np.flatnonzero(system.object_pixels)
    if mask is None and weights is None:
        return Weighed(objects)

    # Those in the mask, and of these the ones with a weight.
    pixels, count = objects, len(objects)
    if mask is not None:
        check_mask(system, mask, "the mask")
        # Lights that are seen themselves are no objects, and are asked about where a mask has them.
        pixels = np.flatnonzero(system.pixels_of() & mask.ravel())
        _check_any(pixels, "the mask has no pixel that light reaches: nothing is asked")
    whole = None
    if weights is not None:
        pixels, whole = _whole(system, weights, pixels)

    notes = [f"asked about {len(pixels)} of {count} object pixels"] if len(pixels) < count else []
    return Weighed(pixels, whole, "; ".join([*notes, *(["shares weighted"] if whole is not None else [])]))


def pixels_of(system: LinearSystem, name: str) -> Mask:
    """The pixels that a material, one component of it, or a light contributes to: a mask to ask about one object.

    A reflection in a mirror belongs to the material shown and to the mirror.

    Raises
    ------
    ValueError
        If nothing in the picture has that name.

    Examples
    --------
    >>> from scipy import sparse
    >>> from symrt.interactions import Interaction
    >>> columns = (Interaction("sun", ("brass.mirror", "sea.diffuse")), Interaction("sun", ("sea.diffuse",)))
    >>> coefficients = sparse.csr_array([[0.1, 0.2], [0.0, 0.3], [0.0, 0.0]])
    >>> system = LinearSystem(coefficients, columns, height=1, width=3, white={"sun": 1.0})
    >>> pixels_of(system, "sea"), pixels_of(system, "brass.mirror")
    (array([[ True,  True, False]]), array([[ True, False, False]]))
    """
    named = [_names(i) for i in system.interactions]
    if name not in (known := set().union(*named)):
        near = did_you_mean([name], sorted(known))
        whole = sorted(known.difference(system.reflectances))
        there = "" if "did you mean" in near else f"; there are {', '.join(whole)}"
        raise ValueError(f"nothing in the picture is called {near}: name a material or a light{there}")
    columns = np.array([name in names for names in named])
    return system.pixels_of(columns).reshape(system.height, system.width)


def check_most(most: int) -> None:
    """Refuse to ask about no pixels: whatever is said of none is true.

    Examples
    --------
    >>> check_most(0)
    Traceback (most recent call last):
    ValueError: most = 0: it is how many pixels are asked about, 1 or more
    """
    if most < 1:
        raise ValueError(f"most = {most}: it is how many pixels are asked about, 1 or more")


def _names(interaction: Interaction) -> set[str]:
    """The names that a column contributes to; none for ``sea>ice.diffuse``, an alternative to the picture."""
    symbols = [Symbol.of(name) for name in interaction.names[1:]]
    if any(symbol.alternative for symbol in symbols):
        return set()
    return {*interaction.names, *(symbol.material for symbol in symbols)}


def _whole(
    system: LinearSystem, weights: Float[np.ndarray, "height width"], pixels: Pixels
) -> tuple[Pixels, Int[np.ndarray, " _"]]:
    """The pixels that count, and their weights as whole multiples of one power of two, at least 1."""
    # Refuse weights that are none.
    if weights.shape != (size := (system.height, system.width)):
        raise ValueError(f"weights: the shape is {weights.shape}, the image's {size}: give one value a pixel")
    wrong = ~(np.isfinite(weights) & (weights >= 0))
    if wrong.any():
        y, x = np.argwhere(wrong)[0]
        raise ValueError(f"the weight of pixel ({x}, {y}) is {weights[y, x]}: weights are finite and not negative")

    # Keep the pixels that count.
    pixels = pixels[weights.ravel()[pixels] > 0]
    _check_any(pixels, "every object pixel asked about has weight 0: nothing is asked")
    chosen = weights.ravel()[pixels]

    # By way of the exponents, so that neither tiny nor huge weights vanish or overflow on their way.
    mantissa, exponent = np.frexp(chosen)
    share = np.ldexp(mantissa, exponent - exponent.max())
    total = np.frexp(share.sum())[1]
    return pixels, np.maximum(1, np.rint(np.ldexp(share, LARGEST_SUM - int(total)))).astype(np.int64)


def check_mask(system: LinearSystem, mask: np.ndarray, what: str) -> None:
    """Refuse masks that are not true or false for each pixel: numbers would name others.

    Examples
    --------
    >>> from scipy import sparse
    >>> image = LinearSystem(sparse.csr_array((2, 0)), (), height=1, width=2, white={})
    >>> check_mask(image, np.array([[0, 1]]), "the mask")
    Traceback (most recent call last):
    ValueError: the mask is of int64: true or false is asked, such as mask > 0
    """
    if mask.shape != (system.height, system.width):
        raise ValueError(f"{what} is {mask.shape}, the image {(system.height, system.width)}: one value a pixel")
    if mask.dtype != bool:
        raise ValueError(f"{what} is of {mask.dtype}: true or false is asked, such as mask > 0")


def _check_any(pixels: Pixels, message: str) -> None:
    if not len(pixels):
        raise ValueError(message)
