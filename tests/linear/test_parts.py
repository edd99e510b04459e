"""Parts of a picture, put together, are the picture to the bit; a part that is not what it says is named."""

import json
import re
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from scenes_for_tests import hall_of_mirrors, small, two_materials

import symrt as rt
from symrt.linear.estimate import machine_memory
from symrt.linear.parts import runs


@pytest.fixture(autouse=True)
def small_tiles(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.tiles"), "SAMPLES", 100)


def assert_same_bits(one: rt.LinearSystem, other: rt.LinearSystem) -> None:
    assert (one.interactions, one.models, one.parameters) == (other.interactions, other.models, other.parameters)
    assert list(one.white.items()) == list(other.white.items())
    for part in ("interactions", "reflected", "passed"):
        assert getattr(one.tail, part) == getattr(other.tail, part)
    for a, b in ((one.G, other.G), (one.tail.bound, other.tail.bound)):
        for part in ("data", "indices", "indptr"):
            assert np.array_equal(getattr(a, part), getattr(b, part))


def rendered(scene, count, folder, **how):
    for number in range(1, count + 1):
        rt.render_part(scene, (number, count), folder, progress=False, **how)


@pytest.mark.parametrize("count", [1, 3, 16])
def test_the_bits_do_not_depend_on_how_a_picture_was_cut(tmp_path, count):
    scene = hall_of_mirrors(3)
    rendered(scene, count, tmp_path)
    assert_same_bits(rt.merge_parts(tmp_path), rt.collapse(rt.trace(scene)))


def test_parts_keep_values_free_parameters_and_alternatives(tmp_path):
    how = {"free": {"shiny.exponent": (10, 40)}, "alternatives": {"dull": ["shiny"]}}
    scene = two_materials(exponent=20)
    rendered(scene, 2, tmp_path, **how)
    assert_same_bits(rt.merge_parts(tmp_path), rt.render(scene, progress=False, **how))


def test_a_lost_part_costs_one_part(tmp_path, monkeypatch):
    scene = two_materials(exponent=20)
    rendered(scene, 12, tmp_path)
    whole = rt.merge_parts(tmp_path)
    for number in (3, 7, 8, 9):
        (tmp_path / f"part-{number}-of-12.npz").unlink()
    with pytest.raises(ValueError, match=r": 4 of 12 parts are to be rendered: --array=3,7-9$"):
        rt.merge_parts(tmp_path)
    for number in (3, 7, 8, 9):
        rt.render_part(scene, (number, 12), tmp_path, progress=False)
    monkeypatch.setattr("symrt.tracing.tracer.nearest", None)  # the same line again traces nothing more
    rendered(scene, 12, tmp_path)
    assert_same_bits(rt.merge_parts(tmp_path), whole)


def one_byte(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


def other_coefficients(path):
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    np.savez_compressed(path, **(arrays | {"G_data": arrays["G_data"] * 2}))


def other_header(path):
    """Say that it is another part, under the digest that it had."""
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays["header"].tobytes()) | {"part": [1, 3]}
    np.savez_compressed(path, **(arrays | {"header": np.frombuffer(json.dumps(header).encode(), dtype=np.uint8)}))


def cut(path):
    path.write_bytes(path.read_bytes()[:-200])


def swapped(path):
    other = path.with_name("part-3-of-3.npz")
    one, two = path.read_bytes(), other.read_bytes()
    path.write_bytes(two)
    other.write_bytes(one)


def a_system(path):
    path.unlink()
    rt.save_system(path, rt.LinearSystem.of("0.5*sun*sea.diffuse"))


DAMAGES = {
    one_byte: "not a whole symrt piece",
    other_coefficients: "its digest is another",
    other_header: "its digest is another",
    cut: "not a whole symrt piece",
    a_system: "its header does not say 'symrt-piece'",
    swapped: "it holds part [23] of 3",
}


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda damage: damage.__name__)
def test_a_part_that_is_not_as_it_was_written_is_named_and_rendered_again(tmp_path, damage):
    scene = two_materials(exponent=20)
    rendered(scene, 3, tmp_path)
    whole = rt.merge_parts(tmp_path)
    damage(tmp_path / "part-2-of-3.npz")
    wanting = "2-3" if damage is swapped else "2"
    with pytest.raises(ValueError, match=re.escape(f"--array={wanting}")) as said:
        rt.merge_parts(tmp_path)
    lines = str(said.value).splitlines()
    assert len(lines) == len(wanting) // 2 + 2
    assert re.search(f"part-2-of-3.npz: .*{DAMAGES[damage]}", lines[0])
    with pytest.warns(UserWarning, match=f"{DAMAGES[damage]}.*: this part is rendered again"):
        rendered(scene, 3, tmp_path)
    assert_same_bits(rt.merge_parts(tmp_path), whole)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("scene", "a part of another scene"),
        ("size", "a part of 24 × 25 pixels, not 24 × 24"),
        ("values", "a part of other values of parameters"),
        ("version", r"a part of symrt 0\.0\.0, not"),
    ],
)
def test_parts_of_different_pictures_are_refused_when_rendered_and_when_merged(tmp_path, monkeypatch, change, says):
    scene, values = two_materials(exponent=20), None
    rendered(scene, 2, tmp_path / "this")
    if change == "scene":
        scene = two_materials(exponent=np.nextafter(20, 21))
    elif change == "size":
        scene = replace(scene, camera=replace(scene.camera, height=25))
    elif change == "values":
        values = {"shiny.exponent": 21}
    else:
        monkeypatch.setattr("symrt.linear.job.__version__", "0.0.0")
    rendered(scene, 2, tmp_path / "other", values=values)
    (tmp_path / "other" / "part-2-of-2.npz").replace(tmp_path / "this" / "part-2-of-2.npz")
    with pytest.raises(ValueError, match=f"part-2-of-2.npz: {says}.*: remove one of the two\n.*--array=2"):
        rt.merge_parts(tmp_path / "this")
    monkeypatch.undo()
    with pytest.raises(ValueError, match=rf"part-2-of-2.npz: {says}.*: name an empty folder, or empty this one"):
        rt.render_part(two_materials(exponent=20), (2, 2), tmp_path / "this", progress=False)


def test_cuts_that_do_not_go_together_and_folders_without_parts_are_refused(tmp_path):
    scene = two_materials(exponent=20)
    with pytest.raises(ValueError, match="no parts are there: render them with render_part, or symrt render --part"):
        rt.merge_parts(tmp_path)
    for part in ((1, 2), (2, 3)):
        rt.render_part(scene, part, tmp_path, progress=False)
    with pytest.raises(ValueError, match="parts of 2 and of 3 are there: remove all but those of one cut"):
        rt.merge_parts(tmp_path)
    for part in ((0, 3), (4, 3), (1, 25)):
        with pytest.raises(ValueError, match="parts run from 1/n to n/n, and the picture's 24 rows make at most 24"):
            rt.render_part(scene, part, tmp_path, progress=False)
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="file: a file has this name: name a folder for the parts"):
        rt.render_part(scene, (1, 2), tmp_path / "file", progress=False)


@pytest.mark.parametrize(("numbers", "text"), [([1], "1"), ([1, 2], "1-2"), ([1, 3, 5, 6, 7, 64], "1,3,5-7,64")])
def test_numbers_are_written_as_job_arrays_take_them(numbers, text):
    assert runs(numbers) == text


def test_a_render_that_needs_more_memory_than_there_is_is_refused_before_it_starts(monkeypatch, tmp_path):
    large = small("first", 1024)
    monkeypatch.setattr("symrt.linear.workers.Job.tile", None)
    for verb in (rt.render, lambda scene, **how: rt.render_part(scene, (1, 1), tmp_path, **how)):
        with pytest.raises(ValueError, match=r"GiB of memory.*; 0\.001 GiB are there: .*--memory, in GiB"):
            verb(large, memory=0.001, progress=False)
        for wrong in (0, -1.0, float("nan")):
            with pytest.raises(ValueError, match=f"memory = {wrong}: give the GiB that there are, more than 0"):
                verb(large, memory=wrong, progress=False)
    assert machine_memory() > 1 << 28


def test_the_memory_of_a_group_is_that_of_the_smallest_it_is_in(tmp_path, monkeypatch):
    (tmp_path / "proc").write_text("0::/slurm/job_7/step\n")
    (tmp_path / "fs" / "slurm" / "job_7" / "step").mkdir(parents=True)
    for folder, limit in (("slurm", "9000"), ("slurm/job_7", "4096"), ("slurm/job_7/step", "max")):
        (tmp_path / "fs" / folder / "memory.max").write_text(f"{limit}\n")
    monkeypatch.setattr(import_module("symrt.linear.estimate"), "GROUP", tmp_path / "proc")
    monkeypatch.setattr(import_module("symrt.linear.estimate"), "GROUPS", tmp_path / "fs")
    assert machine_memory() == 4096


def test_an_estimate_counts_what_a_render_then_has(monkeypatch):
    monkeypatch.setattr(import_module("symrt.linear.tiles"), "SAMPLES", 1 << 15)
    scene = small("spheres", 200)
    found, tree = rt.estimate(scene, workers=1), rt.trace(scene)
    assert found.pixels == 200 * 200
    # What two pixels of five tell of all.
    assert found.coefficients == pytest.approx(rt.collapse(tree).G.nnz, rel=0.02)
    assert found.rays == pytest.approx(sum(tree.rays.values()), rel=0.02)
    half = rt.estimate(scene, part=(1, 2), workers=1)
    assert half.coefficients == pytest.approx(found.coefficients / 2, rel=1e-3)
    assert str(found).startswith("about 40 thousand pixels, ")
