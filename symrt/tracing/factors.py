"""Geometric factors: the cosines between normal, light, viewer, half vector and mirrored light (step 1).

Only the factors that a material's formulas name are computed.
"""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Float

from symrt.arrays import PerRay, cosine, half_way, one_minus_cosine, reflect
from symrt.reflection.symbols import ONE_MINUS

Direction = Float[np.ndarray, "3 ray"]


def factors(names: Iterable[str], normal: Direction, viewer: Direction, light: Direction | None) -> dict[str, PerRay]:
    """The named factors for each point; vectors are unit and point away from the surface.

    Examples
    --------
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> factors(["n_dot_l", "one_minus_r_dot_v"], up, up, up)
    {'n_dot_l': array([1.]), 'one_minus_r_dot_v': array([0.])}
    """
    # Each name ends in its two vectors, then the cosine of each pair.
    pairs = {name: (name.removeprefix(ONE_MINUS)[0], name[-1]) for name in sorted(names)}
    vectors = {
        letter: _vector(letter, normal, viewer, light)
        for letter in sorted({letter for pair in pairs.values() for letter in pair})
    }
    return {
        name: (one_minus_cosine if name.startswith(ONE_MINUS) else cosine)(vectors[first], vectors[second])
        for name, (first, second) in pairs.items()
    }


def coded(name: str) -> tuple[int, int, int]:
    """A factor as its kernel knows it: two of the vectors ``nvlrh``, and whether their cosine is taken from 1.

    Examples
    --------
    >>> coded("one_minus_r_dot_v")
    (3, 1, 1)
    """
    plain = name.removeprefix(ONE_MINUS)
    return "nvlrh".index(plain[0]), "nvlrh".index(plain[-1]), int(plain != name)


def _vector(letter: str, normal: Direction, viewer: Direction, light: Direction | None) -> Direction:
    """The unit vector of a letter: n, v, l, the half vector h, or r, the mirrored light."""
    if letter == "n":
        return normal
    if letter == "v":
        return viewer
    if light is None:
        raise ValueError(f"the vector {letter} needs a light")
    return light if letter == "l" else reflect(light, normal) if letter == "r" else half_way(light, viewer)
