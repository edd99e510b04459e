"""Textures (step 1): at each point of a surface weights over materials that sum to 1, ``M(x) = Σ_j w_j(x) M_j``.

A texture never holds a colour: it says which materials are where, and the weights go into G.  Pictures are PNG files;
u runs right and v down from the top row, and outside [0, 1] the picture repeats.
"""

import warnings
from dataclasses import dataclass, field
from functools import cache, singledispatch
from importlib import resources
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float, Int, Shaped
from PIL import Image

__all__ = [
    "BandedRelief",
    "Checker",
    "LabelImage",
    "WeightImage",
    "elevation",
    "load_texture",
    "weights",
]

UV = Float[np.ndarray, "2 hit"]
Weights = Float[np.ndarray, "material hit"]

LARGEST_PICTURE = 1 << 26
"""Pixels a picture may have; a larger one is refused from its header, before it is decoded."""


@dataclass(frozen=True)
class Checker:
    """Squares of `size` scene units: the first material where ``floor(u·extent/size) + floor(v·extent/size)`` is even.

    Examples
    --------
    >>> Checker(name="tiles", materials=("white", "black"), size=0.5).type
    'checker'
    """

    name: str
    materials: tuple[str, str]
    size: float | int
    type: Literal["checker"] = field(default="checker", kw_only=True)

    def __post_init__(self) -> None:
        if not 0 < self.size < np.inf:
            raise ValueError(f"texture {self.name}: size = {self.size}: it must be finite and greater than 0")


@dataclass(frozen=True)
class LabelImage:
    """A picture whose grey values are indices into `materials`: 0 is the first.

    Each point takes the pixel it lies in, without filtering.  The file is a grey or palette PNG without transparency.

    Examples
    --------
    >>> LabelImage(name="map", file="map.png", materials=("sea", "land")).type
    'label_image'
    """

    name: str
    file: str
    materials: tuple[str, ...]
    type: Literal["label_image"] = field(default="label_image", kw_only=True)


@dataclass(frozen=True)
class WeightImage:
    """A picture whose channels are the weights of `materials`, in order, divided by their sum.

    Between the pixels' centres the weights are blended bilinearly.  The file is a PNG of one channel for each material,
    8 bits deep or, if grey, 16.  A grey picture also serves two materials: black is the first, white the second.

    Examples
    --------
    >>> WeightImage(name="rust", file="rust.png", materials=("iron", "oxide")).type
    'weight_image'
    """

    name: str
    file: str
    materials: tuple[str, ...]
    type: Literal["weight_image"] = field(default="weight_image", kw_only=True)


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
    type: Literal["banded_relief"] = field(default="banded_relief", kw_only=True)

    def __post_init__(self) -> None:
        rule = f"texture {self.name}: levels = {self.levels}, blend = {self.blend}, {len(self.materials)} materials"
        if len(self.materials) != len(self.levels) + 1:
            raise ValueError(f"{rule}: there must be one material more than levels")
        if not (np.all(np.isfinite(self.levels)) and 0 <= self.blend < np.inf):
            raise ValueError(f"{rule}: levels must be finite, and blend finite and not negative")
        if not np.all(np.diff(self.levels) > 2 * self.blend):
            raise ValueError(f"{rule}: levels must ascend by more than 2 blend; make blend smaller")


@dataclass(frozen=True, eq=False)
class LabelRaster:
    """A `LabelImage` that has been read."""

    name: str
    materials: tuple[str, ...]
    labels: Int[np.ndarray, "row column"]


@dataclass(frozen=True, eq=False)
class WeightRaster:
    """A `WeightImage` that has been read: weights that sum to 1 in every pixel."""

    name: str
    materials: tuple[str, ...]
    shares: Float[np.ndarray, "material row column"]


Texture = Checker | LabelImage | WeightImage | BandedRelief


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


@weights.register(LabelRaster)
def weights_labels(texture: LabelRaster, uv: UV, extent: UV) -> Weights:  # noqa: ARG001
    """The material of the pixel at each point.

    Examples
    --------
    >>> world = LabelRaster("map", ("sea", "land"), np.array([[0, 1]]))
    >>> weights_labels(world, np.array([[0.25, 0.75, 1.25], [0.5, 0.5, 0.5]]), np.ones((2, 3)))
    array([[1., 0., 1.],
           [0., 1., 0.]])
    """
    rows, columns = texture.labels.shape
    label = texture.labels[
        np.floor(uv[1] * rows).astype(np.int64) % rows, np.floor(uv[0] * columns).astype(np.int64) % columns
    ]
    return (label == np.arange(len(texture.materials))[:, None]).astype(float)


@weights.register(WeightRaster)
def weights_shares(texture: WeightRaster, uv: UV, extent: UV) -> Weights:  # noqa: ARG001
    """Weights between the four nearest pixels' centres.

    Examples
    --------
    >>> fade = WeightRaster("fade", ("a", "b"), np.array([[[1.0, 0.0]], [[0.0, 1.0]]]))
    >>> weights_shares(fade, np.array([[0.25, 0.5], [0.5, 0.5]]), np.ones((2, 2)))
    array([[1. , 0.5],
           [0. , 0.5]])
    """
    rows, columns = texture.shares.shape[1:]
    y, x = uv[1] * rows - 0.5, uv[0] * columns - 0.5
    top, left = np.floor(y), np.floor(x)
    down, right = y - top, x - left
    i, j = top.astype(np.int64), left.astype(np.int64)
    corners = [texture.shares[:, (i + a) % rows, (j + b) % columns] for a, b in ((0, 0), (0, 1), (1, 0), (1, 1))]
    upper, lower = corners[0] * (1 - right) + corners[1] * right, corners[2] * (1 - right) + corners[3] * right
    return upper * (1 - down) + lower * down


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
    i, j = low.astype(np.int64), left.astype(np.int64)
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


def load_texture(texture: Texture, folder: Path) -> Checker | LabelRaster | WeightRaster | BandedRelief:
    """The texture with its picture read from below `folder`; one without a picture as it is.

    The caller checks that the path stays in the folder.

    Raises
    ------
    ValueError
        If the picture is missing, truncated, larger than 2²⁶ pixels, or does not fit the materials.

    Examples
    --------
    >>> load_texture(Checker("tiles", ("white", "black"), size=1), Path()).name
    'tiles'
    """
    if isinstance(texture, LabelImage):
        return LabelRaster(texture.name, texture.materials, _labels(texture, _picture(folder, texture)))
    if isinstance(texture, WeightImage):
        return WeightRaster(texture.name, texture.materials, _pixel_shares(texture, _picture(folder, texture)))
    return texture


def _picture(folder: Path, texture: LabelImage | WeightImage) -> Shaped[np.ndarray, "row column *channel"]:
    """The pixels of a PNG file as they are stored: palette indices stay indices, 16 bits stay 16 bits."""
    try:
        # Pillow warns of pictures above 89 megapixels; ours are refused by size below, from the header alone.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(folder / texture.file, formats=["PNG"])
        with image:
            _check_size(image)
            pixels = np.asarray(image)
            # Older releases of Pillow hold 16 bits of grey in 32.
            return pixels.astype(np.uint16) if image.mode == "I" else pixels
    except FileNotFoundError as error:
        raise ValueError(f"texture {texture.name}: {texture.file}: there is no such file") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"texture {texture.name}: {texture.file}: {error}; give a whole PNG file") from error


def _check_size(image: Image.Image) -> None:
    if image.width * image.height > LARGEST_PICTURE:
        raise ValueError(f"it has {image.width} × {image.height} pixels, and at most {LARGEST_PICTURE} are read")
    if ";16" in str(getattr(image, "tile", "")) and image.mode in {"RGB", "RGBA", "LA"}:
        raise ValueError("its channels have 16 bits, which are read from grey pictures only; save it with 8")


def _labels(texture: LabelImage, pixels: Shaped[np.ndarray, "row column *channel"]) -> Int[np.ndarray, "row column"]:
    where = f"texture {texture.name}: {texture.file}"
    if pixels.ndim != 2:
        raise ValueError(
            f"{where}: it has {pixels.shape[2]} channels; a label image is grey or has a palette, without alpha"
        )
    if int(pixels.max()) >= len(texture.materials):
        row, column = np.unravel_index(int(np.argmax(pixels)), pixels.shape)
        raise ValueError(
            f"{where}: pixel ({column}, {row}) has the label {int(pixels.max())}, "
            f"but there are {len(texture.materials)} materials; labels count from 0"
        )
    return pixels.astype(np.int32)


def _pixel_shares(
    texture: WeightImage, pixels: Shaped[np.ndarray, "row column *channel"]
) -> Float[np.ndarray, "material row column"]:
    where = f"texture {texture.name}: {texture.file}"
    largest = np.iinfo(pixels.dtype).max if pixels.dtype.kind in "ui" else 1
    levels = np.atleast_3d(pixels).astype(float) / largest
    channels, count = levels.shape[2], len(texture.materials)
    if channels == 1 and count == 2:
        levels = np.concatenate([1 - levels, levels], axis=2)
    elif channels != count:
        raise ValueError(f"{where}: it has {channels} channels for {count} materials; give one for each")
    sums = levels.sum(axis=2)
    if not np.all(sums > 0):
        row, column = np.unravel_index(int(np.argmin(sums)), sums.shape)
        raise ValueError(f"{where}: pixel ({column}, {row}) gives no material any weight; weights need a positive sum")
    return np.moveaxis(levels / sums[:, :, None], 2, 0)
