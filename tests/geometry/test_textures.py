"""Textures: known places of the Earth, pictures of every kind, weights that sum to 1, and files that are refused."""

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from symrt.geometry import BandedRelief, Checker, LabelImage, WeightImage, load_texture, weights
from symrt.geometry.textures import elevation

ONES = np.ones((2, 1))


def place(latitude, longitude):
    return np.array([[(longitude + 180) / 360], [(90 - latitude) / 180]])


@pytest.mark.parametrize(
    ("name", "latitude", "longitude", "low", "high"),
    [
        # Any atlas: heights and depths to a few hundred metres, in cells of half a degree.
        ("Tibet", 32.0, 88.0, 4000, 6000),
        ("Andes, Altiplano", -20.0, -68.0, 3500, 5000),
        ("Antarctica, pole", -89.9, 0.0, 2000, 3500),
        ("Greenland", 73.0, -40.0, 2000, 3500),
        ("Amazon basin", -3.0, -62.0, 0, 200),
        ("Sahara, Algeria", 27.0, 1.0, 200, 800),
        ("Arctic Ocean, pole", 89.9, 0.0, -5000, -3000),
        ("Pacific", 0.0, -140.0, -5500, -3500),
        ("Mariana Trench", 11.5, 142.5, -10000, -5000),
        ("North Sea", 56.0, 4.0, -100, 0),
    ],
)
def test_the_continents_are_the_right_way_round(name, latitude, longitude, low, high):
    assert low < elevation(place(latitude, longitude))[0] < high, name


def test_elevation_is_bilinear_and_wraps_at_the_date_line():
    grid = np.load("symrt/data/relief_30min.npz")["e"].astype(float)
    # Row 300 is 300.5 half degrees north of the south pole.
    v = 1 - 300.5 / 360
    np.testing.assert_array_equal(elevation(np.array([[10.5 / 720], [v]])), grid[300, 10])
    np.testing.assert_allclose(elevation(np.array([[0.0], [v]])), (grid[300, 719] + grid[300, 0]) / 2, rtol=1e-12)
    np.testing.assert_allclose(elevation(np.array([[11.0 / 720], [v]])), grid[300, 10:12].mean(), rtol=1e-12)
    np.testing.assert_allclose(
        elevation(np.array([[11.0 / 720], [1 - 301 / 360]])), grid[300:302, 10:12].mean(), rtol=1e-12
    )
    u = np.linspace(0, 1, 50)
    np.testing.assert_array_equal(elevation(np.stack([u, 0 * u])), elevation(np.stack([u, 0 * u + 0.5 / 360])))


def test_bands_follow_their_ramps():
    levels, blend = (-200.0, 0.0, 1500.0), 40.0
    relief = BandedRelief("earth", levels=levels, materials=("deep", "shelf", "low", "high"), blend=blend)
    generator = np.random.default_rng(1)
    uv = generator.uniform(0, 1, (2, 5000))
    share = weights(relief, uv, np.ones((2, 5000)))
    for k in range(0, 5000, 7):
        height = elevation(uv[:, k : k + 1])[0]
        steps = [min(max((height - (level - blend)) / (2 * blend), 0.0), 1.0) for level in levels]
        np.testing.assert_allclose(share[:, k], -np.diff([1.0, *steps, 0.0]), atol=1e-12)
    assert {0, 1, 2, 3} == set(share.argmax(axis=0))


def test_no_blend_is_a_step():
    relief = BandedRelief("earth", levels=(0,), materials=("sea", "land"))
    uv = np.random.default_rng(2).uniform(0, 1, (2, 1000))
    np.testing.assert_array_equal(weights(relief, uv, np.ones((2, 1000)))[1], elevation(uv) >= 0)


@given(st.lists(st.floats(-9000, 8000), min_size=1, max_size=6, unique=True), st.floats(0, 50))
def test_bands_sum_to_one_within_two_ulp(levels, blend):
    kept = []
    for level in sorted(levels):
        if not kept or level - kept[-1] > 2 * blend * (1 + 1e-9) + 1e-9:
            kept.append(level)
    relief = BandedRelief("e", levels=tuple(kept), materials=tuple("abcdefgh"[: len(kept) + 1]), blend=blend)
    share = weights(relief, np.random.default_rng(3).uniform(0, 1, (2, 200)), np.ones((2, 200)))
    assert np.all(share >= 0)
    assert np.all(np.abs(share.sum(axis=0) - 1) <= 2 * np.spacing(1.0))


def test_squares_of_a_checker_are_in_scene_units():
    tiles = Checker("tiles", ("white", "black"), size=0.5)
    # A rectangle of 4 × 2 scene units: u counts in quarters of a unit, v in halves.
    uv, extent = np.array([[0.1, 0.13, 0.1, 0.9], [0.1, 0.1, 0.3, 0.9]]), np.array([[4.0] * 4, [2.0] * 4])
    assert weights(tiles, uv, extent)[0].tolist() == [1.0, 0.0, 0.0, 1.0 - (7 + 3) % 2]
    negative = np.array([[-0.1, -0.6], [0.1, -0.1]])
    assert weights(tiles, negative, np.ones((2, 2)))[0].tolist() == [0.0, 0.0]


def save(folder, pixels, mode=None):
    Image.fromarray(pixels, mode=None).save(folder / "picture.png") if mode is None else pixels.save(
        folder / "picture.png"
    )
    return folder


def test_a_label_image_is_read_row_by_row_from_the_top(tmp_path):
    save(tmp_path, np.array([[0, 1, 2], [2, 2, 0]], np.uint8))
    world = load_texture(LabelImage("map", "picture.png", ("a", "b", "c")), tmp_path)
    u = np.array([0.1, 0.5, 0.9, 0.1, 0.9, 1.1, -0.1, 1.0])
    v = np.array([0.1, 0.1, 0.1, 0.9, 0.9, 1.1, -0.9, 0.0])
    assert weights(world, np.stack([u, v]), np.ones((2, 8))).argmax(axis=0).tolist() == [0, 1, 2, 2, 0, 0, 2, 0]


def test_labels_may_have_a_palette_or_16_bits(tmp_path):
    labels = np.array([[0, 1], [2, 1]], np.uint8)
    picture = Image.fromarray(labels).convert("P")
    picture.putpalette([255, 0, 0, 0, 255, 0, 0, 0, 255])
    picture.putdata(labels.ravel().tolist())
    for image in (picture, Image.fromarray(labels.astype(np.uint16))):
        image.save(tmp_path / "picture.png")
        read = load_texture(LabelImage("map", "picture.png", ("a", "b", "c")), tmp_path)
        np.testing.assert_array_equal(read.labels, labels)


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_a_grey_picture_weighs_black_against_white(tmp_path, depth):
    most = np.iinfo(depth).max
    save(tmp_path, np.array([[0, most], [most // 5, 0]], depth))
    rust = load_texture(WeightImage("rust", "picture.png", ("iron", "oxide")), tmp_path)
    uv = np.array([[0.25, 0.75, 0.25, 0.5], [0.25, 0.25, 0.75, 0.25]])
    np.testing.assert_allclose(weights(rust, uv, np.ones((2, 4)))[1], [0, 1, 0.2, 0.5], rtol=1e-12)


@pytest.mark.parametrize("channels", [3, 4])
def test_channels_are_weights_that_sum_to_one(tmp_path, channels):
    generator = np.random.default_rng(4)
    pixels = generator.integers(0, 256, (5, 7, channels), dtype=np.uint8)
    pixels[..., 0] |= 1
    save(tmp_path, pixels)
    picture = load_texture(WeightImage("mix", "picture.png", tuple("abcd"[:channels])), tmp_path)
    share = weights(picture, generator.uniform(-2, 3, (2, 4000)), np.ones((2, 4000)))
    assert np.all(share >= 0)
    assert np.all(np.abs(share.sum(axis=0) - 1) <= 2 * np.spacing(1.0))
    middle = np.array([[(3 + 0.5) / 7], [(2 + 0.5) / 5]])
    np.testing.assert_allclose(weights(picture, middle, ONES)[:, 0], pixels[2, 3] / pixels[2, 3].sum(), rtol=1e-12)


def bomb(width, height):
    """A PNG whose header claims a size that its body does not have."""

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(100))) + chunk(b"IEND", b"")
    )


def faulty(name):
    generator = np.random.default_rng(5)
    if name == "missing":
        return None
    if name.startswith("bomb"):
        return bomb(*{"bomb": (20_000, 20_000), "bomb of 80 megapixels": (10_000, 8_000)}[name])
    if name == "text":
        return b"not a picture"
    if name == "empty":
        return b""
    from io import BytesIO  # noqa: PLC0415

    file = BytesIO()
    if name == "jpeg":
        Image.fromarray(generator.integers(0, 2, (8, 8), dtype=np.uint8)).save(file, "JPEG")
    elif name == "truncated":
        Image.fromarray(generator.integers(0, 2, (64, 64), dtype=np.uint8)).save(file, "PNG")
        return file.getvalue()[:200]
    elif name == "alpha":
        Image.fromarray(np.zeros((2, 2, 2), np.uint8)).save(file, "PNG")
    elif name == "label 7":
        Image.fromarray(np.array([[0, 1], [7, 0]], np.uint8)).save(file, "PNG")
    return file.getvalue()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("missing", "there is no such file"),
        ("bomb", "give a whole PNG"),
        ("bomb of 80 megapixels", "10000 × 8000 pixels"),
        ("text", "cannot identify"),
        ("empty", "cannot identify"),
        ("jpeg", "cannot identify"),
        ("truncated", "whole PNG"),
        ("alpha", "2 channels"),
        ("label 7", "pixel \\(0, 1\\) has the label 7, but there are 2 materials"),
    ],
)
def test_a_picture_that_cannot_serve_is_refused_with_its_name(tmp_path, name, said):
    data = faulty(name)
    if data is not None:
        (tmp_path / "picture.png").write_bytes(data)
    with pytest.raises(ValueError, match=f"texture map: picture.png: .*{said}"):
        load_texture(LabelImage("map", "picture.png", ("a", "b")), tmp_path)


def test_weights_must_fit_the_channels_and_have_a_sum(tmp_path):
    save(tmp_path, np.array([[[1, 2, 3], [0, 0, 0]]], np.uint8))
    with pytest.raises(ValueError, match="3 channels for 2 materials"):
        load_texture(WeightImage("mix", "picture.png", ("a", "b")), tmp_path)
    with pytest.raises(ValueError, match="pixel \\(1, 0\\) gives no material any weight"):
        load_texture(WeightImage("mix", "picture.png", ("a", "b", "c")), tmp_path)


def test_colours_of_16_bits_are_refused_not_rounded(tmp_path):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    header = struct.pack(">IIBBBBB", 1, 1, 16, 2, 0, 0, 0)
    body = zlib.compress(b"\0" + struct.pack(">HHH", 1, 2, 3))
    data = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
    (tmp_path / "picture.png").write_bytes(data)
    with pytest.raises(ValueError, match="16 bits"):
        load_texture(WeightImage("mix", "picture.png", ("a", "b", "c")), tmp_path)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Checker("tiles", ("a", "b"), 0), "size = 0"),
        (lambda: Checker("tiles", ("a", "b"), float("nan")), "size = nan"),
        (lambda: BandedRelief("e", levels=(0, 1), materials=("a", "b")), "one material more than levels"),
        (lambda: BandedRelief("e", levels=(0, 10), materials=("a", "b", "c"), blend=5), "ascend by more than 2 blend"),
        (lambda: BandedRelief("e", levels=(10, 0), materials=("a", "b", "c")), "ascend"),
        (lambda: BandedRelief("e", levels=(float("nan"),), materials=("a", "b")), "finite"),
        (lambda: BandedRelief("e", levels=(0,), materials=("a", "b"), blend=-1), "not negative"),
    ],
)
def test_a_texture_that_cannot_be_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()


def test_a_picture_must_be_read_before_it_is_sampled():
    with pytest.raises(TypeError, match="LabelImage cannot be sampled; read pictures with load_texture first"):
        weights(LabelImage("map", "map.png", ("a",)), ONES, ONES)
