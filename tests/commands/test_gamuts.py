"""Commands on gamuts say what the library says: gamut, report."""

import json
from dataclasses import replace

import numpy as np
import pytest
from device.written import i1profiler

import symrt as rt

SMALL = ["--size", "24"]


def test_gamut_facts_are_the_librarys(run, tmp_path, written):
    record = json.loads(
        run("gamut", "--device", "dye3-endura-premier", "--save", "g.npz", "--plot", "g.png", "--json")[1]
    )
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    assert record["gamut"] == gamut.name
    assert record["every entry of the first component"] == 1 / 6  # the paper, §2.1: k = 1/36^(1/2)
    assert record["cosine of the free first component with it"] == gamut.basis.cosine
    assert record["volume of the slice in 3 components"] < record["volume of the shadow in 3 components"]
    assert rt.load_gamut(tmp_path / "g.npz").name == gamut.name
    assert written(tmp_path) == ["g.npz", "g.png"]
    assert record["largest ΔE2000, illuminant/D50, plain"] == rt.basis_report(gamut.device).largest_plain[:8].tolist()
    assert "modelled" in run("gamut", "--device", "g.npz")[1]
    for model in ("hull", "inks", "colorimetric"):
        saved = json.loads(
            run("gamut", "--device", "synthetic-cmyk", "--model", model, "--save", f"{model}.npz", "--json")[1]
        )
        assert saved == json.loads(run("gamut", "--device", f"{model}.npz", "--json")[1])
    assert "Brainard" in run("gamut", "--device", "crt-brainard", "--model", "monitor")[1]
    code, out, err = run("gamut", "--device", "srgb", "--model", "monitor", "--plot", "h.png")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "nothing to draw" in err
    for name in ("hull.npz", "colorimetric.npz"):
        assert run("gamut", "--device", name, "--plot", f"{name}.png")[0] == 0
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
    for words in (["--model", "unit"], ["--tolerance", 0.0], ["--light", "illuminant/A"], ["--black", "clip"]):
        code, out, err = run("gamut", "--device", "g.npz", *words)
        assert (code, out, err.count("\n")) == (2, "", 1)


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
    code, out, err = run("gamut", "--device", "chart.txt", "--model", "inks", "--json")
    assert code == 0
    assert "inks of chart.txt" in json.loads(out)["gamut"]
    assert err.startswith("symrt: warning: chart.txt: HalftoneFit(")
    assert "n = 2.00" in err  # the synthetic printer's own exponent


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


def test_materials_of_a_scene_or_a_saved_system_are_segments_that_the_gamut_clips(run, tmp_path, written):
    assert run("render", "globe", *SMALL, "--out", "globe.npz")[0] == 0
    asked = ["--palette", "macbeth", "--exposure", 1.5, "--reference", "fill", "--within", 0.5, 2]
    saved = run("gamut", "globe.npz", "--palettes", "globe", *asked, "--json", "--save", "g.npz", "--plot", "g.png")
    assert saved == run("gamut", "globe", *SMALL, *asked, "--json")
    assert written(tmp_path) == ["g.npz", "g.png", "globe.npz"]
    record, palette = json.loads(saved[1]), rt.load_palettes("globe")["macbeth"]
    gamut = rt.load_gamut(tmp_path / "g.npz")
    assert (record["gamut"], record["reference"], record["exposure"]) == (gamut.name, "fill", 1.5)
    seen = {name.partition(".")[0] for name in rt.load_system(tmp_path / "globe.npz").reflectances}
    assert {segment["materials"][0] for segment in record["scales"]} == seen
    assert len(record["blends"]) == len(seen) * (len(seen) - 1) // 2
    for segment in record["scales"]:
        r = 1.5 * palette[f"{segment['materials'][0]}.diffuse"]
        ratio = gamut.upper / r
        expected = [] if ratio.min() < 0.5 else [[0.5, pytest.approx(min(2, ratio.min()), rel=1e-12)]]
        assert segment["inside"] == expected
        if expected:
            band = None if ratio.min() > 2 else gamut.bands.labels[ratio.argmin()]
            assert segment["stops"] == [{"below": None, "above": band}]
    for segment in record["blends"]:
        first, second = (1.5 * palette[f"{name}.diffuse"] for name in segment["materials"])
        t = np.linspace(0, 1, 1001)
        inside = (first + t[:, None] * (second - first) <= gamut.upper).all(axis=1)
        if segment["inside"]:
            ((low, high),) = segment["inside"]
            assert np.array_equal(inside, (low - 1e-9 <= t) & (t <= high + 1e-9))
        else:
            assert not inside.any()
    table = " ".join(run("gamut", "globe", *SMALL, *asked)[1].split())
    assert "stopped above by" in table
    assert "Facing fill, exposure 1.5; no physical cap. Against envelope of dye3-endura-premier" in table
    assert "inside is necessary for a print, not sufficient." in table


def test_other_components_draw_another_figure(run, tmp_path, system):
    rt.save_system("first.npz", system)
    for name, components in (("a", (0, 1, 2)), ("b", (0, 1, 2)), ("c", (3, 1, 5))):
        words = ["--palettes", "first", "--palette", "plain", "--components", *components, "--plot", f"{name}.png"]
        assert run("gamut", "first.npz", *words)[0] == 0
    one, same, other = ((tmp_path / f"{name}.png").read_bytes() for name in "abc")
    assert one == same != other


def test_a_viewing_light_and_a_tolerance_are_those_of_the_library(run, tmp_path, system):
    rt.save_system("first.npz", system)
    device, palette = rt.load_device("dye3-endura-premier"), rt.load_palettes("first")["plain"]
    asked = ["--palettes", "first", "--palette", "plain", "--json"]
    for model, words, options in (
        ("colorimetric", ["--light", "illuminant/A"], {"light": "illuminant/A"}),
        ("hull", ["--tolerance", 0.05], {"tolerance": 0.05}),
        ("inks", ["--tolerance", 0.05], {"tolerance": 0.05}),
    ):
        gamut = rt.device_gamut(device, model, **options)
        assert json.loads(run("gamut", "--model", model, *words, "--json")[1])["gamut"] == gamut.name
        if model == "inks":  # they take long, and are told the same way
            continue
        record = json.loads(run("feasible", "first.npz", *asked, "--model", model, *words, "-p", "scale:red")[1])
        expected = rt.feasible(system, palette, gamut, rt.Scale("red"), progress=False)
        assert record[0]["intervals"] == [list(interval) for interval in expected.intervals]
    both = ["--light", "illuminant/A", "--tolerance", 0.05]
    report = json.loads(run("report", "first.npz", *asked, *both, "--model", "hull", "--model", "colorimetric")[1])
    names = [rt.device_gamut(device, "hull", tolerance=0.05).name]
    names.append(rt.device_gamut(device, "colorimetric", light="illuminant/A").name)
    assert [verdict["gamut"] for verdict in report["verdicts"][:2]] == names
    # Gamuts that were saved can be joined, such as those under two viewing lights.
    for light in ("A", "D50"):
        words = ["--model", "colorimetric", "--light", f"illuminant/{light}", "--save", f"{light}.npz"]
        assert run("gamut", *words)[0] == 0
    joined = json.loads(run("gamut", "--device", "A.npz+D50.npz", "--json")[1])
    assert [part.partition("illuminant/")[2].partition(",")[0] for part in joined["parts"]] == ["A", "D50"]
    assert (tmp_path / "A.npz").exists()


def test_a_palette_is_brought_to_a_charts_bands_if_that_is_asked_for(run, tmp_path, system):
    rt.save_system("first.npz", system)
    head = "SAMPLE_ID," + ",".join(f"nm{nm}" for nm in range(400, 701, 20))
    prints = [f"{k}," + ",".join(["0.1", "0.9"][k % 2] for _ in range(16)) for k in range(4)]
    (tmp_path / "chart.csv").write_text("\n".join([head, *prints]))
    words = ["--palettes", "first", "--palette", "plain", "--device", "chart.csv"]
    for command in (["feasible", "-p", "scale:red"], ["report", "--model", "envelope"], ["gamut"]):
        code, out, err = run(command[0], "first.npz", *words, *command[1:])
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "add --resample, or write bands = [400, 700, 20]" in err
        assert run(command[0], "first.npz", *words, *command[1:], "--resample")[0] == 0
    chart = rt.load_device(tmp_path / "chart.csv")
    palette = rt.load_palettes("first")["plain"].on(chart.bands)
    expected = rt.feasible(system, palette, rt.device_gamut(chart, "envelope"), rt.Scale("red"))
    record = json.loads(run("feasible", "first.npz", *words, "-p", "scale:red", "--resample", "--json")[1])
    assert record[0]["intervals"] == [list(interval) for interval in expected.intervals]


def test_srgb_is_a_monitor_to_compare_spectra_with(run):
    code, out, err = run("report", "globe", *SMALL, "--palette", "macbeth", "--monitor", "srgb", "--model", "unit")
    assert (code, err) == (0, "")
    assert "srgb" in out


def test_a_chart_measured_in_two_ways_is_asked_in_one(run, tmp_path):
    (tmp_path / "chart.mxf").write_text(i1profiler()[0], encoding="utf-8")
    record = json.loads(run("gamut", "--device", "chart.mxf", "--mode", "M2", "--json")[1])
    assert record["device"] == "7 prints with amounts of R, G, B"
    assert "those under M2 were read" in record["provenance"]
    code, out, err = run("gamut", "--device", "chart.mxf")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "choose one with the mode, such as M0" in err
    code, _, err = run("gamut", "globe", "--palette", "macbeth", "--device", "chart.mxf", "--mode", "M9")
    assert code == 2
    words = ["--size", 16, "--palette", "macbeth", "--device", "chart.mxf+crt-brainard", "--mode", "M0", "--json"]
    assert json.loads(run("feasible", "globe", *words, "--resample", "-p", "scale:brass")[1])[0]["parameter"]


@pytest.mark.parametrize(
    "words",
    [
        ["gamut"],
        ["gamut", "globe", *SMALL, "--palette", "macbeth"],
        ["feasible", "globe", *SMALL, "--palette", "macbeth", "-p", "scale:brass", "-p", "scale:key", "--no-cap"],
        ["fit", "globe", *SMALL, "--palette", "macbeth", "-p", "scale:brass", "--no-cap"],
    ],
)
def test_answers_fit_a_terminal_of_80_columns(run, words):
    code, out, _ = run(*words)
    assert code == 0
    assert max(map(len, out.splitlines())) <= 80
    assert out.count("Kodak Professional") <= 1
