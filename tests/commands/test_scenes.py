"""Commands on a scene say what the library says: plan, probe, render, formula, shade."""

import json
import re

import numpy as np
from scenes_for_tests import SCENES

import symrt as rt

SMALL = ["--size", "24"]


def test_plan_prints_the_librarys_table_and_its_json(run):
    plan = rt.plan(rt.load_scene("globe"))
    assert run("plan", "globe", "--no-probe") == (0, f"{plan}\n", "")
    record = json.loads(run("plan", "globe", "--no-probe", "--json")[1])
    assert record["expected"] is None
    assert [one["effect"] for one in record["effects"]] == [effect.name for effect in plan.effects]
    assert [one["simulated"] for one in record["effects"]] == [effect.simulated for effect in plan.effects]
    assert [one["because"] for one in record["effects"] if not one["simulated"]] == [
        effect.why for effect in plan.effects if not effect.simulated
    ]


def test_the_json_of_a_plan_has_its_remarks(run, tmp_path):
    text = (SCENES / "first.toml").read_text()
    (tmp_path / "inside.toml").write_text(re.sub(r"position = .*", "position = [0.0, 1.0, 0.5]", text, count=1))
    record = json.loads(run("plan", "inside.toml", "--no-probe", "--json")[1])
    assert record["remarks"] == list(rt.plan(rt.load_scene(tmp_path / "inside.toml")).remarks)
    assert "The camera is inside shapes[0]" in record["remarks"][0]


def test_a_plan_tells_what_effects_are_expected_to_cost(run):
    expected = rt.plan(rt.load_scene("first"), probe=True).expectation
    record = json.loads(run("plan", "first", "--json")[1])["expected"]
    assert (record["rays"], record["pixels"]) == (expected.rays, expected.pixels)
    for name, one in expected.effects.items():
        found = record["effects"][name]
        assert (found["rays"], found["most"], found["mean"]) == (one.rays, one.most, one.mean)
    shown = run("plan", "first")[1]
    assert "on one processor of this machine" in shown
    assert "nothing seen" in shown


def test_the_help_says_what_follows_without(run):
    assert "--without EFFECT" in " ".join(run("plan", "--help")[1].split())


def test_probe_gives_the_librarys_shares_as_json(run):
    record = json.loads(run("probe", "first", "--rays", 256, "--json")[1])
    expected = rt.probe(rt.load_scene("first"), rays=256)
    assert record["rays"] == expected.rays
    assert [one["share"] for one in record["meetings"]] == [meeting.share for meeting in expected.meetings]


def test_render_writes_the_librarys_system_for_any_number_of_workers(run, tmp_path, system, written):
    for workers in (1, 2):
        code, out, _ = run("render", "first", *SMALL, "--workers", workers, "--out", f"{workers}.npz", "--json")
        assert code == 0
        assert json.loads(out)["coefficients"] == system.G.nnz
        saved = rt.load_system(tmp_path / f"{workers}.npz")
        assert (saved.G != system.G).nnz == 0
        assert saved.interactions == system.interactions
    assert written(tmp_path) == ["1.npz", "2.npz"]


def test_size_and_samples_change_the_picture_that_is_rendered(run, tmp_path):
    assert run("render", "first", "--size", "32x16", "--samples", 2, "--out", "a.npz")[0] == 0
    saved = rt.load_system(tmp_path / "a.npz")
    assert (saved.width, saved.height) == (32, 16)


def test_formula_is_the_librarys_before_and_after_the_collapse(run, system):
    rt.save_system("first.npz", system)
    after = rt.formula(system, x=12, y=12)
    assert run("formula", "first.npz", "--x", 12, "--y", 12)[1] == f"{after}\n"
    record = json.loads(run("formula", "first.npz", "--x", 12, "--y", 12, "--json")[1])
    assert (record["symbols"], record["python"]) == (list(after.symbols), after.code())
    collapsed = run("formula", "first", *SMALL, "--x", 12, "--y", 12, "--collapsed", "--python")[1]
    assert collapsed == f"{after.code()}\n"
    before = run("formula", "first", *SMALL, "--x", 12, "--y", 12)[1]
    assert "n_dot_l" in before
    assert "n_dot_l" not in run("formula", "first.npz", "--x", 12, "--y", 12)[1]
    assert r"\mathrm{sun}" in run("formula", "first", *SMALL, "--x", 12, "--y", 12, "--latex")[1]


def test_shading_a_scene_and_its_saved_system_gives_the_same_picture(run, tmp_path, system):
    rt.save_system("first.npz", system)
    assert run("shade", "first", *SMALL, "--palette", "plain", "--out", "a.png")[0] == 0
    assert run("shade", "first.npz", "--palettes", "first", "--palette", "plain", "--out", "b.png")[0] == 0
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_radiances_are_written_as_they_are(run, tmp_path, system):
    palette = rt.load_palettes("first")["plain"]
    assert run("shade", "first", *SMALL, "--palette", "plain", "--out", "first.npz")[0] == 0
    with np.load(tmp_path / "first.npz") as saved:
        assert np.array_equal(saved["values"], rt.shade(system, palette).values)


def test_a_pixel_is_named_by_place_or_by_words(run):
    words = run("formula", "first", "--size", "24", "--x", "12", "--y", "10")
    assert words == run("formula", "first", "12", "10", "--size", "24")
    assert words == run("formula", "first", "12", "--y", "10", "--size", "24")
    assert words[0] == 0
    for wrong, says in ((["12"], "Y is given nowhere"), (["12", "10", "--x", "3"], "X is given twice")):
        code, _, said = run("formula", "first", "--size", "24", *wrong)
        assert code == 2
        assert f"the pixel's {says}: write for example symrt formula globe 210 140" in said


def test_an_effect_is_left_out_on_request_and_the_picture_says_what_that_costs(run):
    record = json.loads(run("plan", "spheres", "--without", "mirrors", "--no-probe", "--json")[1])
    record = {one["effect"]: one for one in record["effects"]}
    assert (record["mirrors"]["state"], record["mirrors"]["simulated"]) == ("left out, bounded", False)
    assert run("render", "spheres", "--size", "16", "--without", "mirrors", "--out", "flat.npz")[0] == 0
    flat = rt.load_system("flat.npz")
    assert not any("mirror" in name for name in flat.reflectances)
    shown = run("shade", "flat.npz", "--palettes", "spheres", "--palette", "rgb", "--out", "flat.png")[1]
    assert "cut off" in shown
    assert "nothing cut off" not in shown
    code, _, said = run("render", "spheres", "--size", "16", "--without", "mirors")
    assert code == 2
    assert "there is no effect 'mirors'; did you mean 'mirrors'?" in said
