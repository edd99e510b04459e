"""An interrupted render goes on where it stopped, to the same bits, and never mixes two scenes."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scenes_for_tests import SCENES, hall_of_mirrors, small, two_materials

import symrt as rt
from symrt.linear.resume import described


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.render"), "TILE", 100)


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
def test_a_missing_or_damaged_tile_is_made_again(tmp_path, damage):
    scene = hall_of_mirrors(3)
    whole = rt.render(scene, save=tmp_path, progress=False)
    first, second = sorted(tmp_path.glob("tile-*"))[:2]
    first.unlink()
    second.write_bytes(damage)
    assert same_bits(rt.render(scene, save=tmp_path, progress=False), whole)


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
        "importlib.import_module('symrt.linear.render').TILE = 100;"
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
    scene = small("globe", 60)
    assert same_bits(rt.render(scene, save=folder, progress=False), rt.render(scene, progress=False))


def test_a_whole_number_of_numpys_is_the_same_whole_number():
    assert list(described(np.int64(3))) == list(described(3))


@pytest.mark.parametrize(("name", "other"), [("TILE", 200), ("__version__", "0.0.0")])
def test_a_folder_of_another_version_or_other_tiles_is_refused(tmp_path, monkeypatch, name, other):
    scene = two_materials(exponent=20)
    rt.render(scene, save=tmp_path, progress=False)
    monkeypatch.setattr(import_module("symrt.linear.render"), name, other)
    with pytest.raises(ValueError, match="another scene or of other parameters"):
        rt.render(scene, save=tmp_path, progress=False)
