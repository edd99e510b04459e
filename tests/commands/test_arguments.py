"""Words of the command line stand for what they say, or are refused with a remedy."""

from dataclasses import replace

import pytest

import symrt as rt
from symrt.commands.arguments import alternatives_of, parameter_of, scene_of, size_of, system_of
from symrt.commands.outputs import writable


@pytest.mark.parametrize(
    ("word", "expected"),
    [("512", (512, 384)), ("1", (1, 1)), ("640x480", (640, 480)), ("7×9", (7, 9)), ("32768x1", (32768, 1))],
)
def test_sizes_are_read_as_widths_that_keep_the_shape_or_as_both(word, expected):
    assert size_of(word, (400, 300)) == expected


@pytest.mark.parametrize("word", ["", "0", "x", "5x", "-5", "1e3", "٣٢", "32769", "12 x 12", "1x2x3", "4x0", " 512"])
def test_other_sizes_are_refused(word):
    with pytest.raises(ValueError, match="--size"):
        size_of(word, (1, 1))


def test_parameters_are_scales_and_blends():
    assert parameter_of("scale:brass.specular") == rt.Scale("brass.specular")
    assert parameter_of("blend:sea:ice") == rt.Blend("sea", "ice")


@pytest.mark.parametrize("word", ["", "scale", "scale:", "scale:a:b", "blend:a", "blend:a:", "blend:a:b:c", "Scale:a"])
def test_other_parameters_are_refused_with_an_example(word):
    with pytest.raises(ValueError, match="write scale:NAME"):
        parameter_of(word)


def test_a_scene_without_changes_is_the_one_in_the_file():
    assert scene_of("first") == rt.load_scene("first")
    changed = scene_of("first", "10x20", samples=3).camera
    assert (changed.width, changed.height, changed.samples) == (10, 20, 3)


def test_a_blend_of_unlike_materials_asks_for_the_columns_that_it_needs():
    # Where models differ, trace(scene, alternatives={"sea": ["ice"]}) adds the missing columns.
    scene = scene_of("globe", "16")
    unlike, alike = rt.Blend("deep", "ice"), rt.Blend("upland", "ice")
    assert alternatives_of(scene, [unlike, alike, rt.Scale("deep"), unlike]) == {"deep": ["ice"]}
    assert alternatives_of(scene, [rt.Blend("deep", "nosuch")]) == {}
    palette, gamut = rt.load_palettes("globe")["macbeth"], rt.device_gamut(rt.load_device("dye3-endura-premier"))
    found = rt.feasible(system_of("globe", "16", [unlike]), palette, gamut, unlike)
    assert found.intervals


def test_a_saved_system_keeps_its_size(tmp_path):
    scene = rt.load_scene("first")
    small = rt.render(replace(scene, camera=replace(scene.camera, width=4, height=4)), progress=False)
    rt.save_system(tmp_path / "a.npz", small)
    assert system_of(str(tmp_path / "a.npz")).width == 4
    with pytest.raises(ValueError, match="has its size already"):
        system_of(str(tmp_path / "a.npz"), "8")


def test_only_files_that_can_be_written_are_accepted(tmp_path):
    assert writable(tmp_path / "a.PNG", ".png") == tmp_path / "a.PNG"
    (tmp_path / "b.png").mkdir()
    for path, rule in (
        (tmp_path / "b.png", "a folder"),
        (tmp_path / "c.gif", "must end"),
        (tmp_path / "d/e.png", "no folder"),
    ):
        with pytest.raises(ValueError, match=rule):
            writable(path, ".png")
