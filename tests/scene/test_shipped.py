"""The scenes that come with symrt: the Earth the right way round, its brass whole, every symbol with a spectrum."""

import runpy
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import every_scene

import symrt as rt
from symrt.geometry import Hits, Mesh, Sphere, load_mesh, nearest, surfaces, weights
from symrt.geometry.pictures import load_texture
from symrt.scene import load_scene, shipped_scene
from symrt.scene.cameras import camera_rays
from symrt.spectra.palettes_file import load_palettes

TILT = np.radians(23.4)


@pytest.fixture(scope="module")
def globe():
    return load_scene("globe")


@pytest.fixture(scope="module")
def picture(globe):
    """What each pixel of the globe's picture shows: its shape, and longitude and latitude where that is the Earth."""
    shapes = [load_mesh(shape, globe.folder) if isinstance(shape, Mesh) else shape for shape in globe.shapes]
    rays = camera_rays(globe.camera)
    hits = nearest(shapes, rays)
    earth = np.flatnonzero(hits.shape == 0)
    seen = Hits(hits.distance[earth], hits.shape[earth], hits.primitive[earth])
    uv = surfaces(shapes, rays[earth], seen).uv
    return hits.shape, earth, 360 * uv[0] - 180, 90 - 180 * uv[1]


def place(globe, picture, latitude, longitude):
    """The pixel that shows a place on Earth: column and row."""
    _, earth, east, north = picture
    away = np.hypot((east - longitude) * np.cos(np.radians(latitude)), north - latitude)
    assert away.min() < 0.5
    row, column = divmod(int(earth[np.argmin(away)]), globe.camera.width)
    return column, row


# Latitude and longitude in degrees, from any atlas.
ROME, CAIRO, KINSHASA, CAPE_TOWN = (41.9, 12.5), (30.0, 31.2), (-4.3, 15.3), (-33.9, 18.4)
RECIFE, DAKAR, RIYADH = (-8.1, -34.9), (14.7, -17.4), (24.7, 46.7)


def test_africa_lies_under_europe_and_south_america_to_its_left(globe, picture):
    _, rome = place(globe, picture, *ROME)
    _, cairo = place(globe, picture, *CAIRO)
    x, kinshasa = place(globe, picture, *KINSHASA)
    _, cape_town = place(globe, picture, *CAPE_TOWN)
    assert rome < cairo < kinshasa < cape_town
    assert place(globe, picture, *RECIFE)[0] < place(globe, picture, *DAKAR)[0] < x < place(globe, picture, *RIYADH)[0]


def test_europe_and_africa_face_the_camera(globe, picture):
    x, y = place(globe, picture, 15, 10)
    centre = np.flatnonzero(picture[0] == 0)
    rows, columns = np.divmod(centre, globe.camera.width)
    radius = (columns.max() - columns.min()) / 2
    assert np.hypot(x - columns.mean(), y - rows.mean()) < 0.35 * radius


def test_the_globe_fills_the_frame_and_the_sky_stays_black(picture):
    shape = picture[0].reshape(512, 512)
    assert 0.25 < np.mean(shape == 0) < 0.45
    assert np.all(shape[0] == -1)
    seen = np.flatnonzero((shape >= 0) & (shape != 6)).reshape(-1)
    rows, columns = np.divmod(seen, 512)
    assert rows.min() > 10
    assert columns.min() > 10
    assert columns.max() < 501


@pytest.mark.parametrize(
    ("latitude", "longitude", "material"),
    # Elevations in metres from an atlas: the Angola Basin −5,500; the English Channel −60; the Hungarian plain 100;
    # the Kalahari 1,000; the Drakensberg 2,000 to 3,000; inner Greenland 3,000.
    [
        (-15, 3, "deep"),
        (50, -1.5, "shelf"),
        (46.5, 20, "lowland"),
        (-24, 22, "upland"),
        (-30, 28.5, "mountain"),
        (72, -38, "ice"),
    ],
)
def test_places_have_the_material_of_their_elevation(globe, latitude, longitude, material):
    earth = load_texture(globe.textures[0], globe.folder)
    uv = np.array([[(longitude + 180) / 360], [(90 - latitude) / 180]])
    share = weights(earth, uv, np.ones((2, 1)))[:, 0]
    assert earth.materials[int(np.argmax(share))] == material


def test_the_pole_and_the_mesh_share_the_axis_of_the_earth(globe):
    earth = next(shape for shape in globe.shapes if isinstance(shape, Sphere))
    mesh = next(shape for shape in globe.shapes if isinstance(shape, Mesh))
    pole = np.array(earth.pole) / np.linalg.norm(earth.pole)
    turn = np.radians(mesh.rotate[1])
    # (sin tilt, cos tilt, 0), turned about y as the mesh is.
    axis = [np.sin(TILT) * np.cos(turn), np.cos(TILT), -np.sin(TILT) * np.sin(turn)]
    np.testing.assert_allclose(pole, axis, atol=2e-4)
    assert mesh.translate == earth.centre
    for end in (globe.shapes[1].base, globe.shapes[1].top):
        along = np.subtract(end, earth.centre)
        assert abs(along @ pole) / np.linalg.norm(along) == pytest.approx(1, abs=1e-6)


def test_the_brass_is_smooth_stands_on_its_base_and_leaves_the_globe_free(globe):
    mesh = load_mesh(next(shape for shape in globe.shapes if isinstance(shape, Mesh)), globe.folder)
    radius = np.linalg.norm(mesh.vertices - np.array(globe.shapes[0].centre)[:, None], axis=0)
    assert 1.03 < radius.min() < 1.1
    base = next(shape for shape in globe.shapes if shape.material == "wood")
    assert mesh.vertices[1].min() <= base.top[1] < mesh.vertices[1].min() + 0.02
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=0), 1, atol=2e-5)
    # Smooth: a vertex normal and the faces around it nearly agree, and all of them point outwards.
    agreement = np.einsum("cf,ckf->kf", mesh.unit_normals, mesh.normals[:, mesh.faces])
    assert agreement.min() > np.cos(np.radians(25))
    assert 2000 < mesh.faces.shape[1] < 8000


def test_the_mesh_file_is_what_its_script_makes():
    script = runpy.run_path(str(shipped_scene("globe").with_name("make_meridian.py")))
    made = script["text"]().splitlines()
    kept = shipped_scene("globe").with_name("meridian.obj").read_text().splitlines()
    assert len(made) == len(kept)
    for word in ("v ", "vn ", "f "):
        a, b = (
            [line.replace("//", " ").split()[1:] for line in lines if line.startswith(word)] for lines in (made, kept)
        )
        np.testing.assert_allclose(np.array(a, float), np.array(b, float), atol=2e-5)


@pytest.mark.parametrize("name", every_scene())
def test_every_palette_of_a_shipped_scene_gives_every_symbol_and_no_other(name):
    symbols = load_scene(name).symbols
    for palette in load_palettes(shipped_scene(name)).values():
        assert sorted(palette.spectra) == sorted(symbols)


@pytest.mark.parametrize("name", every_scene())
def test_shipped_scenes_have_the_palettes_that_the_examples_name(name):
    palettes = {
        "first": "plain rgb",
        "metals": "rgb measured",
        "fluorescent": "rgb daylight blacklight",
        "prism": "daylight tube",
    }.get(name, "rgb macbeth")
    tables = tomllib.loads(shipped_scene(name).read_text(encoding="utf-8"))["palettes"]
    assert set(tables) == set(palettes.split())
    for palette, table in tables.items():
        assert table["bands"] == ("rgb" if palette == "rgb" else [380, 730, 10])


def test_the_metals_show_each_other_and_nothing_is_cut_off():
    scene = load_scene("metals")
    scene = replace(scene, camera=replace(scene.camera, width=160, height=90, samples=1))
    system = rt.render(scene, progress=False)
    palette = load_palettes(shipped_scene("metals"))["measured"]
    assert rt.shade(system, palette).certificate == "nothing cut off"
    balls = [material.name for material in scene.materials if material.parameters]
    assert len(balls) == 5
    pairs = {tuple(sorted({name.partition(".")[0] for name in i.met} & set(balls))) for i in system.interactions}
    assert {("copper", "gold"), ("chrome", "gold"), ("gold", "silver"), ("brass", "gold")} <= pairs


def test_gold_is_yellow_along_the_normal_and_shows_grey_as_grey_along_its_edge():
    # Alone in a grey room under grey light: blue against orange is 0.43 where gold is met along the normal.
    scene = load_scene("metals")
    scene = replace(scene, camera=replace(scene.camera, samples=1), shapes=[scene.shapes[0], *scene.shapes[5:]])
    bands = rt.Bands((450.0, 650.0))
    grey = {symbol: "metal/gold" if symbol == "gold.f0" else 0.5 for symbol in scene.symbols if "." in symbol}
    palette = rt.Palette(bands, {**grey, "lamp": 1.0, "fill": 1.0})
    system = rt.collapse(rt.trace(scene, window=(200, 30, 440, 270)))
    blue, orange = np.moveaxis(rt.shade(system, palette).values, -1, 0)
    ratio = (blue / orange)[rt.pixels_of(system, "gold")]
    assert ratio.min() == pytest.approx(np.divide(*rt.spectrum("metal/gold", bands)), rel=0.01)
    assert 0.9 < ratio.max() < 1
    assert 0.02 < np.mean(ratio > 0.6) < 0.2
