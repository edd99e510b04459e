"""An interrupted render goes on where it stopped, to the same bits, and never mixes two scenes."""

import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scenes_for_tests import SCENES, hall_of_mirrors, two_materials

import symrt as rt
from symrt.linear.digests import described
from symrt.linear.pieces import read_piece


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.tiles"), "SAMPLES", 100)


def same_bits(one: rt.LinearSystem, other: rt.LinearSystem) -> bool:
    return one.interactions == other.interactions and all(
        np.array_equal(getattr(one.G, part), getattr(other.G, part)) for part in ("data", "indices", "indptr")
    )


def test_finished_tiles_are_not_traced_again(tmp_path, monkeypatch):
    scene = hall_of_mirrors(3)
    whole = rt.render(scene, progress=False)
    assert same_bits(rt.render(scene, save=tmp_path, progress=False), whole)
    monkeypatch.setattr("symrt.tracing.tracer.nearest", None)
    assert same_bits(rt.render(scene, save=tmp_path, progress=False), whole)


@pytest.mark.parametrize("damage", [b"", b"PK\x03\x04", bytes(100)], ids=["empty", "cut", "zeros"])
def test_a_damaged_tile_is_made_again_with_a_sentence_and_a_missing_one_without(tmp_path, damage):
    scene = hall_of_mirrors(3)
    whole = rt.render(scene, save=tmp_path, progress=False)
    first, second = sorted(tmp_path.glob("tile-*"))[:2]
    first.unlink()
    second.write_bytes(damage)
    with pytest.warns(UserWarning, match=f"{re.escape(str(second))}: not a whole symrt piece .* made again") as said:
        again = rt.render(scene, save=tmp_path, progress=False)
    assert len(said) == 1
    assert same_bits(again, whole)
    assert same_bits(rt.render(scene, save=tmp_path, progress=False), whole)  # and nothing is left to be said


def other_bits(path):
    """Put other coefficients into a tile, under the header and the digest that it had."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    np.savez_compressed(path, **(arrays | {"G_data": arrays["G_data"] * 2}))


def one_byte(path):
    """Alter one byte in the midst of the file."""
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


def swapped(first, second):
    one, other = first.read_bytes(), second.read_bytes()
    first.write_bytes(other)
    second.write_bytes(one)


def a_system_instead(first, second):
    tile = read_piece(first).system
    second.unlink()
    rt.save_system(second, replace(tile, tail=None))


@pytest.mark.parametrize(
    ("tamper", "says"),
    [
        (lambda first, second: other_bits(first), "its digest is another"),  # noqa: ARG005 -- of two tiles, one is altered
        (lambda first, second: one_byte(first), "not a whole symrt piece"),  # noqa: ARG005 -- as above
        (lambda first, second: second.write_bytes(first.read_bytes()), "a tile of"),
        (swapped, "a tile of"),
        (a_system_instead, "its header does not say"),
    ],
    ids=["altered", "one byte", "renamed", "swapped", "a system"],
)
def test_a_tile_that_is_not_the_one_that_was_kept_is_made_again(tmp_path, tamper, says):
    scene = hall_of_mirrors(3)
    whole = rt.render(scene, save=tmp_path, progress=False)
    tamper(*sorted(tmp_path.glob("tile-*"))[:2])
    with pytest.warns(UserWarning, match=f"{says}.*made again"):
        again = rt.render(scene, save=tmp_path, progress=False)
    assert same_bits(again, whole)
    assert again.tail.interactions == whole.tail.interactions
    np.testing.assert_array_equal(again.tail.bound.toarray(), whole.tail.bound.toarray())


def test_tiles_of_another_scene_are_made_again_even_beside_this_one_s_digest(tmp_path):
    other, scene = two_materials(exponent=20), two_materials(exponent=30)
    rt.render(other, save=tmp_path / "other", progress=False)
    whole = rt.render(scene, save=tmp_path / "this", progress=False)
    for kept in (tmp_path / "other").glob("*-*"):
        kept.replace(tmp_path / "this" / kept.name)
    with pytest.warns(UserWarning, match="a tile of another scene: this tile was made again"):
        assert same_bits(rt.render(scene, save=tmp_path / "this", progress=False), whole)


@pytest.mark.parametrize("cut", [b"", b"0123", b"\xff" * 64])
def test_a_digest_that_was_cut_off_does_not_block_its_folder(tmp_path, monkeypatch, cut):
    scene = two_materials(exponent=20)
    whole = rt.render(scene, save=tmp_path, progress=False)
    (tmp_path / "render.sha256").write_bytes(cut)
    monkeypatch.setattr("symrt.tracing.tracer.nearest", None)  # nothing is traced again
    assert same_bits(rt.render(scene, save=tmp_path, progress=False), whole)


def test_a_folder_in_a_tile_s_place_and_a_file_in_the_folder_s_are_named(tmp_path):
    scene = two_materials(exponent=20)
    (tmp_path / "tiles" / "tile-0-0.npz").mkdir(parents=True)
    with pytest.raises(ValueError, match="holds tiles of another scene"):
        rt.render(scene, save=tmp_path / "tiles", progress=False)
    (tmp_path / "tiles" / "tile-0-0.npz").rmdir()
    rt.render(scene, save=tmp_path / "tiles", progress=False)
    (tmp_path / "tiles" / "tile-0-0.npz").unlink()
    (tmp_path / "tiles" / "tile-0-0.npz").mkdir()
    with pytest.raises(ValueError, match=r"tile-0-0\.npz: a folder has the name of a tile: remove it"):
        rt.render(scene, save=tmp_path / "tiles", progress=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="file: a file has this name: name a folder for the tiles"):
        rt.render(scene, save=tmp_path / "file", progress=False)


@pytest.mark.parametrize("change", ["exponent", "light", "values", "size"])
def test_a_folder_of_another_scene_is_refused(tmp_path, change):
    scene = two_materials(exponent=20)
    rt.render(scene, save=tmp_path, progress=False)
    other = {
        "exponent": two_materials(exponent=np.nextafter(20, 21)),
        "light": replace(scene, lights=[rt.DirectionalLight("sun", direction=(-1, -1, -2.5), shadows=False)]),
        "values": scene,
        "size": replace(scene, camera=replace(scene.camera, width=25)),
    }[change]
    with pytest.raises(ValueError, match="another scene or of other parameters"):
        rt.render(other, values={"shiny.exponent": 21} if change == "values" else None, save=tmp_path, progress=False)


def test_a_killed_render_resumes(tmp_path):
    script = (
        "import sys, importlib, symrt as rt; from dataclasses import replace;"
        "importlib.import_module('symrt.linear.tiles').SAMPLES = 100;"
        "s = rt.load_scene(sys.argv[1]); s = replace(s, camera=replace(s.camera, width=60, height=60));"
        "rt.render(s, save=sys.argv[2], workers=1, progress=False)"
    )
    folder = tmp_path / "tiles"
    environment = os.environ | {"PYTHONPATH": str(SCENES.parent)}
    process = subprocess.Popen([sys.executable, "-c", script, str(SCENES / "globe.toml"), str(folder)], env=environment)
    while len(list(folder.glob("tile-*.npz"))) < 5 and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert 5 <= len(list(folder.glob("tile-*.npz"))) < 60
    scene = rt.load_scene(SCENES / "globe.toml")
    scene = replace(scene, camera=replace(scene.camera, width=60, height=60))
    assert same_bits(rt.render(scene, save=folder, progress=False), rt.render(scene, progress=False))


def test_a_whole_number_of_numpys_is_the_same_whole_number():
    assert list(described(np.int64(3))) == list(described(3))


@pytest.mark.parametrize(("room", "name", "other"), [("tiles", "SAMPLES", 200), ("job", "__version__", "0.0.0")])
def test_a_folder_of_another_version_or_other_tiles_is_refused(tmp_path, monkeypatch, room, name, other):
    scene = two_materials(exponent=20)
    rt.render(scene, save=tmp_path, progress=False)
    monkeypatch.setattr(import_module(f"symrt.linear.{room}"), name, other)
    with pytest.raises(ValueError, match="another scene or of other parameters"):
        rt.render(scene, save=tmp_path, progress=False)
