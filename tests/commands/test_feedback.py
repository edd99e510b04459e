"""Commands that ask an image and a gamut say what the library says: feasible, fit, adapt."""

import json

import imageio.v3 as imageio
import numpy as np
import pytest

import symrt as rt
from symrt.commands.arguments import system_of

SMALL = ["--size", "24"]


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
    assert run("render", "globe", *SMALL, "--alternative", "deep:ice", "--out", "globe.npz")[0] == 0
    saved = run(
        "feasible", "globe.npz", "--palettes", "globe", "--palette", "macbeth", "-p", "blend:deep:ice", "--json"
    )
    (record,) = json.loads(saved[1])
    assert record["intervals"] == records[1]["intervals"]


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


def test_the_exposure_is_a_parameter(run, system):
    palette = rt.load_palettes("first")["plain"]
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    record = json.loads(run("feasible", "first", *SMALL, "--palette", "plain", "-p", "exposure", "--json")[1])[0]
    expected = rt.feasible(system, palette, gamut, rt.Exposure())
    assert record["intervals"] == [list(interval) for interval in expected.intervals]


def test_the_spectra_of_a_fit_are_a_palette_to_go_on_with(run, tmp_path, system):
    words = ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--exposure", 2, "--no-cap"]
    assert run(*words, "--palette-out", "fitted.toml")[0] == 0
    palette, seen = rt.load_palettes("first")["plain"], rt.Reference(exposure=2)
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    expected = rt.fit(system, palette, gamut, [rt.Scale("red")], reference=seen, cap=False).palette
    saved = rt.load_palettes(tmp_path / "fitted.toml")["lexicographic"]
    assert all(np.array_equal(saved[name], expected[name]) for name in expected)
    code, out, err = run(*words, "--palette-out", "fitted.png")
    assert (code, out, err.count("\n")) == (2, "", 1)


def test_a_fit_that_moves_a_light_is_inside_when_its_palette_is_read_back(run, tmp_path, system):
    rt.save_system("first.npz", system)
    words = ["--palettes", "first", "--palette", "plain", "--exposure", "2"]
    code, out, _ = run(
        "fit", "first.npz", *words, "-p", "scale:sun", "--objective", "closest", "--least-luminance", "0",
        "--palette-out", "found.toml", "--out", "found.png", "--json",
    )  # fmt: skip
    assert code == 0
    assert json.loads(out)["values"]["sun"] < 0.95
    back = ["--palettes", "found.toml", "--exposure", "2"]
    (answer,) = json.loads(run("feasible", "first.npz", *back, "-p", "exposure", "--json")[1])
    assert answer["verdict"] == "complete"
    assert answer["intervals"][-1][1] >= 1
    assert run("shade", "first.npz", *back, "--out", "again.png")[0] == 0
    assert (tmp_path / "again.png").read_bytes() == (tmp_path / "found.png").read_bytes()


def test_a_dimmed_lamp_dims_the_picture_against_the_white_of_another_palette(run, tmp_path, system):
    rt.save_system("first.npz", system)
    plain = rt.load_palettes("first")["plain"]
    rt.save_palettes("both.toml", {"plain": plain, "dim": plain.replace(sun=0.1 * plain["sun"])})

    def picture(*words):
        assert run("shade", "first.npz", "--palettes", "both.toml", *words, "--out", "seen.png")[0] == 0
        return imageio.imread(tmp_path / "seen.png").astype(int)

    given, same = picture("--palette", "plain"), picture("--palette", "dim")
    dimmed = picture("--palette", "dim", "--white-of", "plain")
    assert np.array_equal(given, same)
    assert dimmed.sum() < 0.5 * given.sum()
    asked = ["feasible", "first.npz", "--palettes", "both.toml", "--palette", "dim", "-p", "scale:sun", "--json"]
    limits = [json.loads(run(*asked, "--within", "0.01", "100", *more)[1])[0]["intervals"][-1][1]
              for more in ([], ["--white-of", "plain"])]  # fmt: skip
    assert limits[1] == pytest.approx(10 * limits[0], rel=1e-9)
    code, _, said = run("shade", "first.npz", "--palettes", "both.toml", "--palette", "dim", "--white-of", "plain",
                        "--reference", "sun", "--out", "seen.png")  # fmt: skip
    assert code == 2
    assert "both choose the white" in said


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("a.png", "the picture in sRGB, against sun, exposure 0.5."),
        ("a.tif", "radiances, Bands(36 wavelengths, 380 … 730 nm), as they are: no exposure, no white taken out."),
    ],
)
def test_what_is_written_beside_a_fit_is_said(run, name, said):
    words = ["first", *SMALL, "--palette", "plain", "--exposure", 0.5, "-o", name]
    fitted = [*words, "-p", "scale:red", "--no-cap"]
    assert run("fit", *fitted)[1].endswith(f"{name}: {said}\n")
    assert json.loads(run("fit", *fitted, "--json")[1])["written"] == [f"{name}: {said}"]
    assert run("map-pixels", *words)[1].endswith(f"{name}: {said}\n")


def test_the_white_of_another_palette_is_resampled_with_the_palette(run, system):
    rt.save_system("first.npz", system)
    plain = rt.load_palettes("first")["plain"]
    bands = rt.wavelengths(380, 740, 20)
    coarse = rt.Palette(bands, {name: np.interp(bands.centres, plain.bands.centres, plain[name]) for name in plain})
    rt.save_palettes("coarse.toml", {"bright": coarse, "dim": coarse.replace(sun=0.1 * coarse["sun"])})
    asked = ["feasible", "first.npz", "--palettes", "coarse.toml", "--palette", "dim", "--white-of", "bright"]
    code, out, _ = run(*asked, "-p", "exposure", "--resample", "--within", "0.1", "100", "--json")
    assert code == 0
    assert json.loads(out)[0]["intervals"][-1][1] > 5
    code, out, err = run(*asked[:-1], "brigth", "-p", "exposure", "--resample")
    assert (code, out) == (2, "")
    assert err == "symrt: --white-of 'brigth': coarse.toml has none of this name; did you mean 'bright'?\n"


@pytest.mark.filterwarnings("always:the palette's")
def test_a_misspelt_entry_is_named_once_on_the_command_line(run, system):
    rt.save_system("first.npz", system)
    plain = rt.load_palettes("first")["plain"]
    rt.save_palettes("typo.toml", {"plain": plain.add({"redd.diffuse": 0.5})})
    for words in (
        ["shade", "--out", "a.png"],
        ["feasible", "-p", "scale:red"],
        ["report", "--device", "synthetic-cmyk"],
    ):
        code, _, err = run(words[0], "first.npz", "--palettes", "typo.toml", *words[1:])
        assert code == 0
        assert (
            err
            == "symrt: warning: the palette's 'redd.diffuse' is nothing in this scene: did you mean 'red.diffuse'?\n"
        )
