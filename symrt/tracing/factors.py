"""Geometric factors: the cosines between normal, light, viewer, half vector and mirrored light (step 1).

Only the factors that a material's formulas name are computed.  ``one_minus_…`` is 1 − a·b = |a − b|²/2 for unit
vectors, which keeps its digits where the cosine is close to 1.
"""

from collections.abc import Iterable

import numpy as np
from jaxtyping import Float

from symrt.arrays import PerRay, Vectors, dot

Direction = Float[np.ndarray, "3 ray"]


def factors(names: Iterable[str], normal: Direction, viewer: Direction, light: Direction | None) -> dict[str, PerRay]:
    """The named factors for each point; vectors are unit and point away from the surface.

    Examples
    --------
    >>> up = np.array([[0.0], [1.0], [0.0]])
    >>> factors(["n_dot_l", "one_minus_r_dot_v"], up, up, up)
    {'n_dot_l': array([1.]), 'one_minus_r_dot_v': array([0.])}
    """
    vectors = {"n": normal, "v": viewer, "l": light}
    return {name: _factor(name, vectors) for name in sorted(names)}


def coded(name: str) -> tuple[int, int, int]:
    """A factor as its kernel knows it: two of the vectors ``nvlrh``, and whether their cosine is taken from 1.

    Examples
    --------
    >>> coded("one_minus_r_dot_v")
    (3, 1, 1)
    """
    cosine = name.removeprefix("one_minus_")
    return "nvlrh".index(cosine[0]), "nvlrh".index(cosine[-1]), int(cosine != name)


def _factor(name: str, vectors: dict[str, Direction | None]) -> PerRay:
    cosine = name.removeprefix("one_minus_")
    first, second = (_vector(letter, vectors) for letter in (cosine[0], cosine[-1]))
    if cosine == name:
        return np.clip(dot(first, second), 0.0, 1.0)
    difference = first - second
    return np.minimum(dot(difference, difference) / 2, 1.0)


def _vector(letter: str, vectors: dict[str, Direction | None]) -> Direction:
    found = vectors.get(letter)
    if found is not None:
        return found
    normal, light = vectors["n"], vectors["l"]
    if normal is None or light is None:
        raise ValueError(f"the vector {letter} needs a light")
    if letter == "r":
        vectors["r"] = reflect(light, normal)
    else:
        vectors["h"] = _half(light, vectors["v"])
    return _vector(letter, vectors)


def reflect(direction: Vectors, normal: Vectors) -> Vectors:
    """Mirror a unit vector that points away from the surface about the normal; the result points away too."""
    return 2 * dot(direction, normal) * normal - direction


def _half(light: Direction, viewer: Direction | None) -> Direction:
    if viewer is None:
        raise ValueError("the half vector needs a viewer")
    total = light + viewer
    size = np.sqrt(dot(total, total))
    # Light and viewer exactly opposite have no half vector: the zero vector, whose cosines are 0, is the dark limit.
    return total / np.where(size > 0, size, 1.0)
