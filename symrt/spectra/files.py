"""Write images to files, after step 3 of the paper: PNG for the eye; float TIFF, ``.npz`` and OpenEXR for further work.

References
----------
A. Fichet, R. Pacanowski and A. Wilkie, "An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021.
"""

import importlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

import imageio.v3 as imageio
import numpy as np

from symrt.archives import check_free
from symrt.arrays import Spectrum
from symrt.disk import replacing
from symrt.spectra.bands import Number
from symrt.spectra.display import to_rgb8
from symrt.spectra.image import SpectralImage
from symrt.spectra.png import encode_png
from symrt.spectra.viewing import linear_rgb


def save_image(
    path: str | Path, image: SpectralImage, *, exposure: Number = 1.0, white: Spectrum | str | None = None
) -> None:
    """Write an image to a file, whole or not at all; the name's ending chooses the format.

    ``.png`` is the picture in 8-bit sRGB, seen as `to_rgb` sees it.  The others hold what `shade` computed, and take no
    exposure: ``.npz`` exactly, with bands, white and cut-off beside the values; ``.tif`` and ``.exr`` in float32.

    Examples
    --------
    >>> import tempfile
    >>> from symrt.spectra.bands import RGB
    >>> image = SpectralImage(np.array([[[1.0, 0.5, 0.0]]]), RGB, whites={"sun": np.ones(3)})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_image(Path(folder) / "red.png", image)
    ...     imageio.imread(Path(folder) / "red.png").tolist()
    [[[255, 188, 0]]]
    """
    # A format that can hold what was asked for.
    path = Path(path)
    ending = path.suffix.lower()
    if ending not in (".png", *WRITERS):
        raise ValueError(f"{path}: {ending or 'no ending'!r} is not a format: use .png, .tif, .npz or .exr")
    if ending != ".png" and (exposure != 1 or white is not None):
        raise ValueError(f"{path}: exposure and white are for pictures; {ending} holds the radiances as they are")
    if ending == ".npz":
        check_free(path, "")

    # Write it.
    with replacing(path) as file:
        if ending == ".png":
            file.write(png_bytes(image, exposure, white))
        else:
            WRITERS[ending](file, path, image)


def png_bytes(image: SpectralImage, exposure: Number = 1.0, white: Spectrum | str | None = None) -> bytes:
    """The picture as an 8-bit PNG that says it is sRGB."""
    return encode_png(to_rgb8(linear_rgb(image, exposure, white)))


def _write_npz(file: BinaryIO, _: Path, image: SpectralImage) -> None:
    arrays = {
        "values": image.values,
        "bands": np.array(image.bands.centres, dtype=np.float64),
        "kind": np.array(image.bands.kind),
    }
    arrays |= {name: a for name, a in (("white", image.white), ("cut_off", image.cut_off)) if a is not None}
    np.savez_compressed(file, allow_pickle=False, **arrays)


def _write_tiff(file: BinaryIO, _: Path, image: SpectralImage) -> None:
    description = json.dumps({"bands": image.bands.centres, "kind": image.bands.kind})
    colour = "rgb" if image.bands.kind == "rgb" else "minisblack"
    options = {"plugin": "tifffile", "extension": ".tif", "photometric": colour, "planarconfig": "contig"}
    file.write(imageio.imwrite("<bytes>", _single(image), description=description, metadata=None, **options))


def _write_exr(file: BinaryIO, path: Path, image: SpectralImage) -> None:
    try:
        exr = importlib.import_module("OpenEXR")
    except ImportError:
        raise ValueError(f"{path}: OpenEXR files need the extra: pip install 'symrt[exr]', or save as .npz") from None
    if image.bands.kind == "coordinate":
        raise ValueError(f"{path}: OpenEXR has no layout for basis coordinates: save them as .npz or .tif")
    # S0 is emission, the radiance; the layout writes the decimal point as a comma.
    spectral = image.bands.kind == "wavelength"
    names = ["S0." + f"{c:.3f}nm".replace(".", ",") for c in image.bands.centres] if spectral else "RGB"
    header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}
    if spectral:
        header |= {"spectralLayoutVersion": "1.0", "emissiveUnits": "W.m^-2.sr^-1"}
    planes = np.moveaxis(_single(image), -1, 0)
    channels = {name: np.ascontiguousarray(plane) for name, plane in zip(names, planes, strict=True)}
    # OpenEXR writes by name, into the file that was opened for it, and says what stops it in words of its own.
    try:
        with exr.File(header, channels) as picture:
            picture.write(file.name)
    except RuntimeError as error:
        reason = " ".join(str(error).replace(file.name, path.name).split())
        raise ValueError(f"{path}: it cannot be written ({reason}): look at the disk, or save as .npz") from error


def _single(image: SpectralImage) -> np.ndarray:
    largest = float(np.abs(image.values).max(initial=0.0))
    if largest > float(np.finfo(np.float32).max):
        raise ValueError(f"the image reaches {largest:.3g}, more than float32 holds: save it as .npz")
    return image.values.astype(np.float32)


WRITERS: dict[str, Callable[[BinaryIO, Path, SpectralImage], None]] = {
    ".npz": _write_npz,
    ".tif": _write_tiff,
    ".tiff": _write_tiff,
    ".exr": _write_exr,
}
