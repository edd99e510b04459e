"""Pictures as numbers: textures (step 1), PNG files whose pixels name materials or weigh them; masks and weights.

u runs right and v down from the top row, and outside [0, 1] the picture repeats.
"""

import warnings
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float, Int, Shaped
from PIL import Image

from symrt.disk import ordinary
from symrt.errors import hinting
from symrt.geometry.textures import UV, BandedRelief, Checker, Weights, weights

LARGEST_PICTURE = 1 << 26
"""Pixels a picture may have; a larger one is refused from its header, before it is decoded."""


@hinting
@dataclass(frozen=True)
class LabelImage:
    """A picture whose grey values are indices into `materials`: 0 is the first.

    Each point takes the pixel it lies in, unless the picture is `filtered`.  The file is a grey or palette PNG without
    transparency.

    Examples
    --------
    >>> LabelImage(name="map", file="map.png", materials=("sea", "land")).type
    'label_image'
    """

    name: str
    file: str
    materials: tuple[str, ...]
    filtered: bool = field(default=False, kw_only=True)
    type: Literal["label_image"] = field(default="label_image", kw_only=True)


@hinting
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
    filtered: bool = field(default=False, kw_only=True)
    type: Literal["weight_image"] = field(default="weight_image", kw_only=True)


@dataclass(frozen=True, eq=False)
class LabelRaster:
    """A `LabelImage` that has been read."""

    name: str
    materials: tuple[str, ...]
    labels: Int[np.ndarray, "row column"]
    filtered: bool = False

    @cached_property
    def table(self) -> Float[np.ndarray, "material below right"]:
        """For each material the number of its pixels above and to the left of each corner of pixels."""
        return _summed((self.labels == np.arange(len(self.materials))[:, None, None]).astype(float))


@dataclass(frozen=True, eq=False)
class WeightRaster:
    """A `WeightImage` that has been read: weights that sum to 1 in every pixel."""

    name: str
    materials: tuple[str, ...]
    shares: Float[np.ndarray, "material row column"]
    filtered: bool = False

    @cached_property
    def table(self) -> Float[np.ndarray, "material below right"]:
        """For each material the sum of its weights above and to the left of each corner of pixels."""
        return _summed(self.shares)


Texture = Checker | LabelImage | WeightImage | BandedRelief


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
    row, column = np.floor(uv[1] * rows) % rows, np.floor(uv[0] * columns) % columns
    label = texture.labels[row.astype(np.int64), column.astype(np.int64)]
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
    i, j = (top % rows).astype(np.int64), (left % columns).astype(np.int64)
    corners = [texture.shares[:, (i + a) % rows, (j + b) % columns] for a, b in ((0, 0), (0, 1), (1, 0), (1, 1))]
    upper, lower = corners[0] * (1 - right) + corners[1] * right, corners[2] * (1 - right) + corners[3] * right
    return upper * (1 - down) + lower * down


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
        return LabelRaster(
            texture.name, texture.materials, _labels(texture, _pixels(folder, texture)), texture.filtered
        )
    if isinstance(texture, WeightImage):
        return WeightRaster(
            texture.name, texture.materials, _pixel_shares(texture, _pixels(folder, texture)), texture.filtered
        )
    return texture


def grey_picture(path: str | Path) -> Float[np.ndarray, "row column"]:
    """The grey of each pixel of a PNG file, from 0, black, to 1, white: a mask, or weights.

    Raises
    ------
    ValueError
        If it is no whole PNG file, larger than 2²⁶ pixels, or not grey of 1, 8 or 16 bits without transparency.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     Image.fromarray(np.array([[0, 51, 255]], dtype=np.uint8)).save(Path(folder) / "weights.png")
    ...     grey_picture(Path(folder) / "weights.png").tolist()
    [[0.0, 0.2, 1.0]]
    """
    pixels, palette = _png(Path(path), str(path))
    if pixels.ndim != 2 or palette:
        kind = "a palette" if palette else f"{pixels.shape[2]} channels"
        raise ValueError(f"{path}: it has {kind}; save it in grey, without transparency")
    return pixels / (1 if pixels.dtype.kind == "b" else np.iinfo(pixels.dtype).max)


def _pixels(folder: Path, texture: LabelImage | WeightImage) -> Shaped[np.ndarray, "row column *channel"]:
    return _png(folder / texture.file, f"texture {texture.name}: {texture.file}")[0]


def _png(path: Path, where: str) -> tuple[Shaped[np.ndarray, "row column *channel"], bool]:
    """The pixels of a PNG file as they are stored, 16 bits too, and whether they are indices into a palette."""
    try:
        # Pillow warns of pictures above 89 megapixels; ours are refused by size below, from the header alone.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            image = Image.open(ordinary(path), formats=["PNG"])
        with image:
            _check_size(image)
            pixels = np.asarray(image)
            # Older releases of Pillow hold 16 bits of grey in 32.
            return pixels.astype(np.uint16) if image.mode == "I" else pixels, image.mode == "P"
    except FileNotFoundError as error:
        raise ValueError(f"{where}: there is no such file") from error
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise ValueError(f"{where}: {error}; give a whole PNG file") from error


def _summed(shares: Float[np.ndarray, "material row column"]) -> Float[np.ndarray, "material below right"]:
    """Sums over all rows above and all columns to the left, from none to all of them."""
    return np.pad(shares.cumsum(axis=1).cumsum(axis=2), ((0, 0), (1, 0), (1, 0)))


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
