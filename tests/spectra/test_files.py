"""Image files: read back by the libraries of the formats, whole or not there at all."""

import imageio.v3 as imageio
import numpy as np
import OpenEXR
import pytest
from matplotlib.figure import Figure
from PIL import Image

from symrt.spectra.bands import RGB, coordinates, wavelengths
from symrt.spectra.files import png_bytes, save_image
from symrt.spectra.image import SpectralImage
from symrt.spectra.viewing import to_rgb

BANDS = wavelengths(400, 700, 10)


def make_image(bands=BANDS, height=5, width=7):
    values = np.random.default_rng(0).random((height, width, len(bands)))
    whites = {} if bands.kind == "coordinate" else {"sun": np.linspace(0.5, 1, len(bands))}
    return SpectralImage(values, bands, whites, cut_off=np.full(len(bands), 0.01))


@pytest.mark.parametrize("bands", [BANDS, RGB])
def test_a_png_is_the_picture_that_to_rgb_gives(tmp_path, bands):
    image = make_image(bands)
    save_image(tmp_path / "a.png", image, exposure=0.7)
    picture = imageio.imread(tmp_path / "a.png")
    np.testing.assert_array_equal(picture, np.rint(255 * to_rgb(image, exposure=0.7)).astype(np.uint8))


@pytest.mark.parametrize("bands", [BANDS, RGB, coordinates(5)])
def test_a_tiff_holds_the_radiances_in_single_precision(tmp_path, bands):
    image = make_image(bands)
    save_image(tmp_path / "a.tif", image)
    np.testing.assert_array_equal(imageio.imread(tmp_path / "a.tif"), image.values.astype(np.float32))


@pytest.mark.parametrize("bands", [BANDS, RGB, coordinates(5)])
def test_an_npz_holds_everything_exactly_and_no_pickle(tmp_path, bands):
    image = make_image(bands)
    save_image(tmp_path / "a.npz", image)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as file:
        np.testing.assert_array_equal(file["values"], image.values)
        np.testing.assert_array_equal(file["bands"], bands.centres)
        np.testing.assert_array_equal(file.get("white"), image.white)
        np.testing.assert_array_equal(file["cut_off"], image.cut_off)
        assert str(file["kind"]) == bands.kind


def test_an_openexr_file_has_the_spectral_layout(tmp_path):
    image = make_image()
    save_image(tmp_path / "a.exr", image)
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        channels = file.channels()
        # Channel names and attributes: Fichet, Pacanowski and Wilkie 2021, §3.
        assert set(channels) == {f"S0.{nm},000nm" for nm in range(400, 701, 10)}
        assert file.header()["spectralLayoutVersion"] == "1.0"
        np.testing.assert_array_equal(channels["S0.550,000nm"].pixels, image.values[:, :, 15].astype(np.float32))


def test_an_openexr_file_of_three_bands_is_rgb(tmp_path):
    image = make_image(RGB)
    save_image(tmp_path / "a.exr", image)
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        np.testing.assert_array_equal(file.channels()["G"].pixels, image.values[:, :, 1].astype(np.float32))


@pytest.mark.parametrize(
    ("name", "image", "options", "reason"),
    [
        ("a.jpg", make_image(), {}, r"'\.jpg' is not a format: use \.png"),
        ("a", make_image(), {}, "no ending"),
        ("a.tif", make_image(), {"exposure": 2.0}, "holds the radiances as they are"),
        ("a.png", make_image(coordinates(5)), {}, "without basis="),
        ("a.exr", make_image(coordinates(5)), {}, "no layout for basis coordinates"),
        ("a.tif", SpectralImage(np.full((1, 1, 3), 1e39), RGB), {}, "more than float32 holds"),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_no_file(tmp_path, name, image, options, reason):
    with pytest.raises(ValueError, match=reason):
        save_image(tmp_path / name, image, **options)
    assert not list(tmp_path.iterdir())


def test_a_write_that_fails_keeps_the_old_file(tmp_path):
    save_image(tmp_path / "a.png", make_image())
    before = (tmp_path / "a.png").read_bytes()
    with pytest.raises(ValueError, match="exposure"):
        save_image(tmp_path / "a.png", make_image(), exposure=-1.0)
    assert (tmp_path / "a.png").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_a_notebook_shows_colours_but_not_coordinates():
    image = make_image()
    assert image._repr_png_() == png_bytes(image)
    assert make_image(coordinates(5))._repr_png_() is None


def test_a_png_says_that_it_is_srgb(tmp_path):
    save_image(tmp_path / "a.png", make_image())
    data = (tmp_path / "a.png").read_bytes()
    chunks, place = {}, 8
    while place < len(data):
        size = int.from_bytes(data[place : place + 4], "big")
        chunks[data[place + 4 : place + 8]] = data[place + 8 : place + 8 + size]
        place += 12 + size
    names = list(chunks)
    # The specification: before the picture's data; intent 1 is relative colorimetric, gamma 1/2.2 times 100,000.
    assert names.index(b"sRGB") < names.index(b"IDAT")
    assert chunks[b"sRGB"] == b"\x01"
    assert int.from_bytes(chunks[b"gAMA"], "big") == 45455
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.info["srgb"] == 1


def test_an_image_is_a_picture_for_numpy_matplotlib_and_pillow(tmp_path):
    image = make_image()
    save_image(tmp_path / "a.png", image)
    picture = imageio.imread(tmp_path / "a.png")
    np.testing.assert_array_equal(np.asarray(image), picture)
    np.testing.assert_array_equal(np.array(image, dtype=np.float32), picture.astype(np.float32))
    np.testing.assert_array_equal(np.asarray(Image.fromarray(np.asarray(image))), picture)
    shown = Figure().subplots().imshow(image)
    np.testing.assert_array_equal(shown.get_array(), picture)


def test_an_image_that_cannot_be_seen_is_no_picture():
    with pytest.raises(ValueError, match=r"coordinates, which have no colour: it is no picture: take image\.values"):
        np.asarray(SpectralImage(np.ones((2, 2, 5)), coordinates(5)))
    with pytest.raises(ValueError, match="the image has no white"):
        np.asarray(SpectralImage(np.ones((2, 2, 3)), RGB))
    with pytest.raises(ValueError, match="leave out copy=False"):
        np.asarray(make_image(), copy=False)
