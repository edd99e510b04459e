"""Textures (step 1): at each point of a surface weights over materials that sum to 1, ``M(x) = Σ_j w_j(x) M_j``.

A texture never holds a colour: it says which materials are where, and the weights go into G.
"""

from dataclasses import dataclass, field
from functools import cache, singledispatch
from importlib import resources
from typing import Literal

import numpy as np
from jaxtyping import Float

from symrt.errors import hinting

UV = Float[np.ndarray, "2 hit"]
Weights = Float[np.ndarray, "material hit"]


@hinting
@dataclass(frozen=True)
class Checker:
    """Squares of `size` scene units: the first material where ``floor(u·extent/size) + floor(v·extent/size)`` is even.

    A texture that is `filtered` shows its mean over all that a sample of the film covers, not what is in the middle.

    Examples
    --------
    >>> Checker(name="tiles", materials=("white", "black"), size=0.5).type
    'checker'
    """

    name: str
    materials: tuple[str, str]
    size: float | int
    filtered: bool = field(default=False, kw_only=True)
    type: Literal["checker"] = field(default="checker", kw_only=True)

    def __post_init__(self) -> None:
        if not 0 < self.size < np.inf:
            raise ValueError(f"texture {self.name}: size = {self.size}: it must be finite and greater than 0")


@hinting
@dataclass(frozen=True)
class BandedRelief:
    """Elevation bands of the Earth, lowest first, on geographic coordinates as a sphere has them.

    Around each of the ascending `levels` (metres) the weight passes from one material to the next by a linear ramp,
    from level − blend to level + blend; the levels are further apart than 2 blend.

    Examples
    --------
    >>> earth = BandedRelief(name="earth", levels=(0,), materials=("sea", "land"), blend=100)
    >>> earth.relief
    'etopo5'
    """

    name: str
    relief: Literal["etopo5"] = "etopo5"
    levels: tuple[float | int, ...] = (0,)
    materials: tuple[str, ...] = ("sea", "land")
    blend: float | int = 0
    filtered: bool = field(default=False, kw_only=True)
    type: Literal["banded_relief"] = field(default="banded_relief", kw_only=True)

    def __post_init__(self) -> None:
        rule = f"texture {self.name}: levels = {self.levels}, blend = {self.blend}, {len(self.materials)} materials"
        if len(self.materials) != len(self.levels) + 1:
            raise ValueError(f"{rule}: there must be one material more than levels")
        if not (np.all(np.isfinite(self.levels)) and 0 <= self.blend < np.inf):
            raise ValueError(f"{rule}: levels must be finite, and blend finite and not negative")
        if not np.all(np.diff(self.levels) > 2 * self.blend):
            raise ValueError(f"{rule}: levels must ascend by more than 2 blend; make blend smaller")


@singledispatch
def weights(texture: object, uv: UV, extent: UV) -> Weights:  # noqa: ARG001 (registered for each texture)
    """Weights of the texture's materials at surface coordinates: not negative, summing to 1 within 2 ulp.

    Parameters
    ----------
    extent
        Scene units per unit of u and v.

    Examples
    --------
    >>> tiles = Checker("tiles", ("white", "black"), size=1)
    >>> weights(tiles, np.array([[0.5, 1.5], [0.5, 0.5]]), np.ones((2, 2)))
    array([[1., 0.],
           [0., 1.]])
    """
    raise TypeError(f"{type(texture).__name__} cannot be sampled; read pictures with load_texture first")


@weights.register(Checker)
def weights_checker(texture: Checker, uv: UV, extent: UV) -> Weights:
    """One material or the other.

    Examples
    --------
    >>> weights_checker(Checker("tiles", ("a", "b"), 1), np.array([[-0.5], [0.5]]), np.ones((2, 1))).T
    array([[0., 1.]])
    """
    odd = np.floor(uv * extent / texture.size).sum(axis=0) % 2
    return np.stack([1 - odd, odd])


@weights.register(BandedRelief)
def weights_relief(texture: BandedRelief, uv: UV, extent: UV) -> Weights:  # noqa: ARG001
    """Elevation bands with linear ramps between them.

    Examples
    --------
    The Gulf of Guinea at 0° N 0° E, and the Sahara at 22.5° N 0° E:

    >>> earth = BandedRelief("earth", levels=(0,), materials=("sea", "land"), blend=50)
    >>> weights_relief(earth, np.array([[0.5, 0.5], [0.5, 0.375]]), np.ones((2, 2)))
    array([[1., 0.],
           [0., 1.]])
    """
    height = elevation(uv)
    levels = np.array(texture.levels, dtype=float)[:, None]
    if texture.blend > 0:
        with np.errstate(over="ignore"):
            ramps = np.clip((height - (levels - texture.blend)) / (2 * texture.blend), 0.0, 1.0)
    else:
        ramps = (height >= levels).astype(float)
    ones, zeros = np.ones((1, uv.shape[1])), np.zeros((1, uv.shape[1]))
    return np.concatenate([ones, ramps]) - np.concatenate([ramps, zeros])


def elevation(uv: UV) -> Float[np.ndarray, " hit"]:
    """Elevation of the Earth in metres, bilinear between half-degree cells of ETOPO5, negative below the sea.

    u in [0, 1] runs east from 180° W, v south from the north pole.  Longitudes wrap; beyond the centres of the polar
    rows, a quarter of a degree from the poles, those rows go on.

    Examples
    --------
    The Himalayas at 28.25° N 86.75° E stand above 5 km:

    >>> bool(elevation(np.array([[(180 + 86.75) / 360], [(90 - 28.25) / 180]]))[0] > 5000)
    True
    """
    grid = _relief()
    rows, columns = grid.shape
    y = np.clip((1 - uv[1]) * rows - 0.5, 0.0, rows - 1.0)
    x = uv[0] * columns - 0.5
    low, left = np.minimum(np.floor(y), rows - 2), np.floor(x)
    i, j = low.astype(np.int64), (left % columns).astype(np.int64)
    up, right = y - low, x - left
    south = grid[i, j % columns] * (1 - right) + grid[i, (j + 1) % columns] * right
    north = grid[i + 1, j % columns] * (1 - right) + grid[i + 1, (j + 1) % columns] * right
    return south * (1 - up) + north * up


@cache
def _relief() -> Float[np.ndarray, "row column"]:
    """Elevations in metres at the cells' centres; row 0 is the southernmost, column 0 starts at 180° W."""
    with resources.files("symrt.data").joinpath("relief_30min.npz").open("rb") as file, np.load(file) as stored:
        grid = stored["e"].astype(float)
    grid.flags.writeable = False
    return grid
