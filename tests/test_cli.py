"""The command line says what the library says, and ends bad input in one line."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer

import symrt as rt
from symrt import cli
from symrt.commands.arguments import system_of

SMALL = ["--size", "24"]
HEAVY = {"colour", "imageio", "matplotlib", "numpy", "pydantic", "rich", "scipy", "sympy", "tqdm", "trimesh"}
COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def run(capsys):
    def run(*words: object) -> tuple[int, str, str]:
        code = cli.main([str(word) for word in words])
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


@pytest.fixture
def system():
    scene = rt.load_scene("first")
    return rt.render(replace(scene, camera=replace(scene.camera, width=24, height=24)), progress=False)


def python(*words: str) -> "subprocess.CompletedProcess[str]":
    home = {**os.environ, "PYTHONPATH": str(Path(rt.__file__).parents[1])}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, env=home)


def written(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*"))


BAD_WORDS = [
    ["nope"],
    ["plan"],
    ["plan", "nosuch"],
    ["plan", "missing/scene.toml"],
    ["plan", "globe", "--nope"],
    ["plan", "x" * 5000],
    ["plan", "bad\0name"],
    ["probe", "first", "--rays", "0"],
    ["render", "first", "--size", "0"],
    ["render", "first", "--size", "-3"],
    ["render", "first", "--size", "9" * 40],
    ["render", "first", "--size", "24x"],
    ["render", "first", "--size", "99999"],
    ["render", "first", "--samples", "0"],
    ["render", "first", "--samples", "two"],
    ["render", "first", "--workers", "0"],
    ["render", "first", "--out", "missing/first.npz"],
    ["render", "first", "--out", "first.png"],
    ["render", "first", "--out", "."],
    ["render", "first.npz"],
    ["formula", "first", "--x", "999", "--y", "0"],
    ["formula", "first", "--x", "-1", "--y", "0"],
    ["formula", "first", "--x", "1"],
    ["formula", "missing.npz", "--x", "1", "--y", "1"],
    ["shade", "first", *SMALL],
    ["shade", "first", *SMALL, "--palette", "plan"],
    ["shade", "first", *SMALL, "--palette", "plain", "--exposure", "0"],
    ["shade", "first", *SMALL, "--palette", "plain", "--exposure", "nan"],
    ["shade", "first", *SMALL, "--palette", "plain", "--reference", "moon"],
    ["shade", "first", *SMALL, "--palette", "plain", "--out", "first.gif"],
    ["shade", "missing.npz", "--palettes", "first", "--palette", "plain"],
    ["shade", "missing.npz"],
    ["gamut", "nope"],
    ["gamut", "missing.npz"],
    ["gamut", "--model", "unitt"],
    ["gamut", "--black", "nope"],
    ["gamut", "--model", "nope"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "exposure"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:nothing"],
    ["gamut", "--model", "hull", "--black", "strict"],
    ["gamut", "crt-brainard", "--model", "hull"],
    ["gamut", "crt-brainard", "--black", "strict"],
    ["gamut", "dye3-endura-premier+nope"],
    ["gamut", "dye3-endura-premier+crt-brainard", "--plot", "a.png"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--model", "hull"],
    ["feasible", "first", *SMALL, "--palette", "rgb", "-p", "scale:red", "--device", "crt-brainard"],
    ["report", "first", *SMALL, "--palette", "plain", "--model", "nope"],
    ["report", "first", *SMALL, "--palette", "plain", "--plot", "a.gif"],
    ["gamut", "--plot", "gamut.gif"],
    ["shade", "first", *SMALL, "--palette", "plain", "--out", "first.npz", "--exposure", "2"],
    ["feasible", "first", "--palette", "plain"],
    ["feasible", "globe", *SMALL, "--palette", "macbeth", "-p", "blend:upland:ice", "--within", "0", "3"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:blue"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:__import__('os')"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "blend:red"],
    ["feasible", "globe", *SMALL, "--palette", "macbeth", "-p", "blend:upland:ice:oil"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "blend:red:blue"],
    ["feasible", "first", *SMALL, "--palette", "rgb", "-p", "scale:red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--within", "3", "1"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--allowed-out", "2"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--device", "nope"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "blend:red:red"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:red.diffuse"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--objective", "prettiest"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--together", "--allowed-out", "0.1"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--together", "--of", "red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--of", "nothing"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--region", "region.png"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:red", "--region", "a.png"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:sun", "--region", "a.gif"],
    ["demo", "--scene", "nosuch"],
    ["demo", "--size", "0"],
]


@pytest.mark.parametrize("words", BAD_WORDS, ids=lambda words: " ".join(words)[:60].replace("\0", "0"))
def test_bad_input_ends_in_one_line_and_code_2_with_nothing_written(run, tmp_path, words):
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert err.startswith("symrt: ")
    assert err.count("\n") == 1
    assert len(err) < 400
    assert written(tmp_path) == []


def test_a_scene_with_several_faults_gives_a_line_for_each(run, tmp_path):
    scene = rt.shipped_scene("first").read_text()
    (tmp_path / "bad.toml").write_text(
        scene.replace("radius = 1", "radius = -1").replace("exponent = 40", "exponent = nan")
    )
    code, out, err = run("plan", "bad.toml")
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert len(lines) == 2
    assert all(line.startswith("symrt: bad.toml: ") for line in lines)


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04" + bytes(100)])
def test_damaged_systems_and_gamuts_end_in_one_line(run, tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)
    for words in (["formula", "bad.npz", "--x", 0, "--y", 0], ["gamut", "bad.npz"]):
        code, out, err = run(*words)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "bad.npz" in err


def test_a_folder_that_cannot_be_made_ends_in_one_line(run, tmp_path):
    (tmp_path / "out").write_text("a file stands where the folder should")
    code, out, err = run("demo", "--scene", "globe", "--size", "8", "--out", "out")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "out" in err
    assert written(tmp_path) == ["out"]


def test_a_full_disk_leaves_no_half_written_file(run, tmp_path, monkeypatch):
    def full(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    code, out, err = run("render", "first", *SMALL)
    assert (code, out, err) == (2, "", "symrt: [Errno 28] No space left on device\n")
    assert written(tmp_path) == []


def test_an_interrupt_ends_with_code_130_and_no_traceback(run, monkeypatch):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr(rt, "load_scene", interrupted)
    assert run("render", "first") == (130, "", "")


def test_help_imports_nothing_slow():
    done = python(
        "-c", f"from symrt.cli import main; main(['--help']); import sys; print(sorted({HEAVY} & {{*sys.modules}}))"
    )
    assert "Usage: symrt" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_python_m_symrt_is_the_command_line():
    done = python("-m", "symrt", "--version")
    assert (done.returncode, done.stdout) == (0, f"symrt {rt.__version__}\n")
    bad = python("-m", "symrt", "plan", "nosuch")
    assert (bad.returncode, bad.stdout, bad.stderr.count("\n")) == (2, "", 1)


def test_no_words_show_the_help(run):
    code, out, err = run()
    assert (code, err) == (0, "")
    assert all(name in out for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_shows_an_example_that_it_understands(run, name):
    code, out, _ = run(name, "--help")
    assert code == 0
    example = " ".join(out.split("Example: ")[1].split("Options:")[0].split("Arguments:")[0].split())
    program, command, *words = example.split()
    assert (program, command) == ("symrt", name)
    COMMANDS[name].make_context(name, words)  # raises if it does not


def test_plan_prints_the_librarys_table_and_its_json(run):
    plan = rt.plan(rt.load_scene("globe"))
    assert run("plan", "globe") == (0, f"{plan}\n", "")
    record = json.loads(run("plan", "globe", "--json")[1])
    assert [one["effect"] for one in record] == [effect.name for effect in plan.effects]
    assert [one["simulated"] for one in record] == [effect.simulated for effect in plan.effects]


def test_probe_gives_the_librarys_shares_as_json(run):
    record = json.loads(run("probe", "first", "--rays", 256, "--json")[1])
    expected = rt.probe(rt.load_scene("first"), rays=256)
    assert record["rays"] == expected.rays
    assert [one["share"] for one in record["meetings"]] == [meeting.share for meeting in expected.meetings]


def test_render_writes_the_librarys_system_for_any_number_of_workers(run, tmp_path, system):
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


def test_gamut_facts_are_the_librarys(run, tmp_path):
    record = json.loads(run("gamut", "dye3-endura-premier", "--save", "g.npz", "--plot", "g.png", "--json")[1])
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    assert record["gamut"] == gamut.name
    assert record["every entry of the first component"] == 1 / 6  # the paper, §2.1: k = 1/36^(1/2)
    assert record["cosine of the free first component with it"] == gamut.basis.cosine
    assert record["volume of the slice in 3 components"] < record["volume of the shadow in 3 components"]
    assert rt.load_gamut(tmp_path / "g.npz").name == gamut.name
    assert written(tmp_path) == ["g.npz", "g.png"]
    assert record["largest ΔE2000, illuminant/D50, plain"] == rt.basis_report(gamut.device).largest_plain[:8].tolist()
    assert "modelled" in run("gamut", "g.npz")[1]
    for model in ("hull", "inks", "colorimetric"):
        saved = json.loads(run("gamut", "synthetic-cmyk", "--model", model, "--save", f"{model}.npz", "--json")[1])
        assert saved == json.loads(run("gamut", f"{model}.npz", "--json")[1])
    assert "Brainard" in run("gamut", "crt-brainard", "--model", "monitor")[1]
    code, out, err = run("gamut", "srgb", "--model", "monitor", "--plot", "h.png")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "nothing to draw" in err
    for name in ("hull.npz", "colorimetric.npz"):
        assert run("gamut", name, "--plot", f"{name}.png")[0] == 0
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    code, out, err = run("gamut", "g.npz", "--model", "unit")
    assert (code, out, err.count("\n")) == (2, "", 1)


def test_feasible_answers_as_the_library_does(run, tmp_path, system):
    rt.save_system("first.npz", system)
    asked = ["--palettes", "first", "--palette", "plain", "-p", "scale:red", "-p", "scale:sun"]
    options = [
        "--no-cap",
        "--within",
        "0.5",
        "2.5",
        "--allowed-out",
        "0.01",
        "--exposure",
        "0.8",
        "--black",
        "luminance",
    ]
    code, out, _ = run("feasible", "first.npz", *asked, *options, "--json", "--plot", "ranges.png")
    assert code == 0
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope", "luminance")
    for record, name in zip(json.loads(out), ("red", "sun"), strict=True):
        expected = rt.feasible(
            system,
            palette,
            gamut,
            rt.Scale(name),
            within=(0.5, 2.5),
            allowed_out=0.01,
            reference=rt.Reference(exposure=0.8),
            cap=False,
        )
        assert record["intervals"] == [list(interval) for interval in expected.intervals]
        assert record["verdict"] == expected.verdict
        assert record["reasons"][-1]["above"]["text"] == str(expected.reasons[-1][1])
        assert record["note"] == expected.note
    assert (tmp_path / "ranges.png").stat().st_size > 10_000
    text = run("feasible", "first.npz", *asked)[1]
    assert "reference sun, exposure 1" in text


def test_feasible_of_an_object_asks_about_its_pixels_only(run, system):
    words = ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:sun", "--no-cap", "--json"]
    (whole,), (part,) = (json.loads(run(*words, *more)[1]) for more in ([], ["--of", "red.specular"]))
    assert part["object pixels"] == rt.pixels_of(system, "red.specular").sum() < whole["object pixels"]
    assert part["intervals"][-1][1] >= whole["intervals"][-1][1]
    assert "asked about" in part["note"]
    assert "asked about" not in whole["note"]


def test_a_blend_of_paints_answers_as_the_library_does(run):
    system, palette = system_of("globe", "24"), rt.load_palettes("globe")["macbeth"]
    rt.save_system("globe.npz", system)
    words = ["feasible", "globe.npz", "--palettes", "globe", "--palette", "macbeth"]
    records = [json.loads(run(*words, "-p", f"blend:upland:ice{how}", "--json")[1])[0] for how in ("", ":kubelka-munk")]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    expected = rt.feasible(system, palette, gamut, rt.Blend("upland", "ice", "kubelka-munk"))
    assert records[1]["parameter"] == "blend from upland to ice, mixed as paints"
    assert records[1]["intervals"] == [list(interval) for interval in expected.intervals]
    assert records[0]["parameter"] == "blend from upland to ice"


def test_blends_are_rendered_with_the_columns_that_they_need(run):
    words = [
        "feasible",
        "globe",
        *SMALL,
        "--palette",
        "macbeth",
        "-p",
        "blend:upland:ice",
        "-p",
        "blend:deep:ice",
        "--json",
    ]
    records = json.loads(run(*words)[1])
    assert [record["within"] for record in records] == [[0, 1], [0, 1]]
    assert [record["parameter"] for record in records] == ["blend from upland to ice", "blend from deep to ice"]
    assert all(record["intervals"] for record in records)


def test_fit_answers_as_the_library_does_and_writes_its_picture(run, tmp_path, system):
    words = [
        "fit",
        "first",
        *SMALL,
        "--palette",
        "plain",
        "-p",
        "scale:red",
        "--no-cap",
        "--out",
        "light.png",
        "--plot",
        "fit.png",
        "--json",
    ]
    record = json.loads(run(*words)[1])
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    expected = rt.fit(system, palette, gamut, [rt.Scale("red")], cap=False)
    assert record["values"] == dict(expected.values)
    assert record["verdict"] == expected.verdict
    rt.save_image("same.png", rt.shade(system, expected.palette))
    assert (tmp_path / "light.png").read_bytes() == (tmp_path / "same.png").read_bytes()
    assert (tmp_path / "fit.png").stat().st_size > 10_000


def test_fit_takes_every_objective_and_the_least_luminance(run, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    words = ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--json", "--objective", "closest"]
    record = json.loads(run(*words, "--least-luminance", "0")[1])
    expected = rt.fit(system, palette, gamut, [rt.Scale("red")], objective="closest", least_luminance=0)
    assert record["values"] == dict(expected.values)
    assert record["optimum"] == "global"


def test_fit_leaves_out_what_it_is_allowed_to(run, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    words = ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--no-cap", "--json"]
    record = json.loads(run(*words, "--allowed-out", "0.1", "--least-luminance", "0")[1])
    expected = rt.fit(system, palette, gamut, [rt.Scale("red")], allowed_out=0.1, cap=False, least_luminance=0)
    assert record["values"] == dict(expected.values)
    assert len(record["left out"]) == len(expected.left_out)
    assert record["share outside"] == expected.share_out <= 0.1


def test_adapt_answers_as_the_library_does_and_writes_its_picture(run, tmp_path, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    words = ["adapt", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--json", "--out", "adapted.png"]
    record = json.loads(run(*words, "--least-inside", "0.9", "--most-difference", "20", "--least-lightness", "0.2")[1])
    expected = rt.adapt(
        system, palette, gamut, [rt.Scale("red")], least_inside=0.9, most_difference=20, least_lightness=0.2
    )
    assert record["accepted"] == expected.accepted.means
    assert [step["difference"] for step in record["steps"]] == [step.difference for step in expected.steps]
    assert (tmp_path / "adapted.png").exists()
    refused = json.loads(run(*words[:-2], "--least-lightness", "1", "--most-difference", "0", "--map-rest")[1])
    assert refused["accepted"] is None or refused["steps"][-1]["lacking"] == []


def test_feasible_together_is_the_safe_box(run, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    words = ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--together"]
    record = json.loads(run(*words, "--json")[1])
    expected = rt.safe_box(system, palette, gamut, [rt.Scale("red")])
    assert record["box"] == {"red": list(expected.box["red"])}
    assert run(*words)[1].startswith("All scales may move freely")


def test_feasible_draws_the_region_of_two_parameters(run, tmp_path, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    words = ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:sun", "--json"]
    code, out, _ = run(*words, "--region", "region.png")
    assert code == 0
    record = json.loads(out)
    expected = rt.joint_region(system, palette, gamut, rt.Scale("red"), rt.Scale("sun"), progress=False)
    assert [line["intervals"] for line in record["lines"]] == [[[*i] for i in line] for line in expected.intervals]
    assert record["share of all pairs"] == expected.share
    assert (tmp_path / "region.png").stat().st_size > 10_000


@pytest.mark.parametrize("model", ["unit", "envelope", "hull", "colorimetric", "inks"])
def test_feasible_takes_every_model(run, system, model):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), model)
    words = [
        "feasible",
        "first",
        *SMALL,
        "--palette",
        "plain",
        "-p",
        "scale:sun",
        "--no-cap",
        "--model",
        model,
        "--json",
    ]
    record = json.loads(run(*words)[1])[0]
    expected = rt.feasible(system, palette, gamut, rt.Scale("sun"), cap=False, progress=False)
    assert record["intervals"] == [list(interval) for interval in expected.intervals]
    assert record["note"] == expected.note


def test_devices_joined_by_a_plus_are_intersected_and_a_monitor_is_one(run, system):
    palette = rt.load_palettes("first")["plain"]
    printers = [rt.device_gamut(rt.load_device(name), "envelope") for name in ("dye3-endura-premier", "synthetic-cmyk")]
    monitor = rt.device_gamut(rt.load_device("crt-brainard").on(palette.bands), "monitor")
    ask = ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:sun", "--json", "--device"]
    for device, gamut in (
        ("dye3-endura-premier+synthetic-cmyk", rt.intersection(printers)),
        ("dye3-endura-premier+crt-brainard", rt.intersection([printers[0], monitor])),
        ("crt-brainard", monitor),
    ):
        record = json.loads(run(*ask, device)[1])[0]
        expected = rt.feasible(system, palette, gamut, rt.Scale("sun"), progress=False)
        assert record["intervals"] == [list(interval) for interval in expected.intervals]
        assert record["note"] == expected.note


def test_a_chart_on_other_bands_says_what_to_write_in_the_palette(run, tmp_path):
    rows = [" ".join(f"{v:.3f}" for v in np.linspace(0.1, 0.9, 31)), " ".join(["0.5"] * 31)]
    fields = " ".join(f"SPECTRAL_NM{nm}" for nm in range(400, 701, 10))
    text = f"CGATS.17\nNUMBER_OF_FIELDS 32\nBEGIN_DATA_FORMAT\nSAMPLE_ID {fields}\nEND_DATA_FORMAT\nNUMBER_OF_SETS 2\n"
    (tmp_path / "chart.txt").write_text(text + "BEGIN_DATA\nA1 " + "\nA2 ".join(rows) + "\nEND_DATA\n")
    code, out, err = run("feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:sun", "--device", "chart.txt")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "write bands = [400, 700, 10] in the palette" in err


@pytest.mark.filterwarnings("always:chart.txt")
def test_a_chart_with_amounts_is_asked_for_its_inks_by_a_model_fitted_to_it(run, tmp_path):
    device = rt.load_device("synthetic-cmyk")
    amounts, prints = device.amounts[::9] * 100, device.samples[::9] * 100
    fields = " ".join(f"SPECTRAL_NM{nm:.0f}" for nm in device.bands.centres)
    rows = [
        f"A{i} " + " ".join(f"{v:.6f}" for v in [*ink, *spectrum])
        for i, (ink, spectrum) in enumerate(zip(amounts, prints, strict=True))
    ]
    head = f"CGATS.17\nNUMBER_OF_FIELDS 41\nBEGIN_DATA_FORMAT\nSAMPLE_ID CMYK_C CMYK_M CMYK_Y CMYK_K {fields}\n"
    data = f"END_DATA_FORMAT\nNUMBER_OF_SETS {len(rows)}\nBEGIN_DATA\n" + "\n".join(rows) + "\nEND_DATA\n"
    (tmp_path / "chart.txt").write_text(head + data)
    code, out, err = run("gamut", "chart.txt", "--model", "inks", "--json")
    assert code == 0
    assert "inks of chart.txt" in json.loads(out)["gamut"]
    assert err.startswith("symrt: warning: chart.txt: HalftoneFit(")
    assert "n = 2.00" in err  # the synthetic printer's own exponent


def test_the_exposure_is_a_parameter(run, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    record = json.loads(run("feasible", "first", *SMALL, "--palette", "plain", "-p", "exposure", "--json")[1])[0]
    expected = rt.feasible(system, palette, gamut, rt.Exposure())
    assert record["intervals"] == [list(interval) for interval in expected.intervals]


def test_report_gives_the_librarys_verdicts_as_json(run):
    code, out, _ = run("report", "globe", "--palette", "macbeth", "--size", "32", "--model", "unit", "--json")
    record = json.loads(out)
    assert code == 0
    palette = rt.load_palettes("globe")["macbeth"]
    scene = rt.load_scene("globe")
    small = replace(scene, camera=replace(scene.camera, width=32, height=32))
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "unit")
    verdict = rt.report(rt.render(small, progress=False), palette, [gamut]).verdicts[0]
    assert record["verdicts"][0]["inside"] == verdict.inside
    assert len(record["verdicts"]) == 2


def test_a_picture_too_large_for_the_machine_ends_in_one_line(run, monkeypatch):
    def too_large(*_arguments, **_options):
        raise MemoryError("Unable to allocate 36.0 GiB for an array with shape (134217728, 36)")

    monkeypatch.setattr(rt, "shade", too_large)
    code, _, error = run("shade", "first", "--palette", "plain", "--out", "a.png", "--size", "16")
    assert code == 2
    assert error.splitlines() == ["symrt: Unable to allocate 36.0 GiB for an array with shape (134217728, 36)"]
