"""Regions and weights on the command line are those of the library, or are refused with a remedy."""

import json

import numpy as np
import pytest
from PIL import Image

import symrt as rt

ASKED = ["--palettes", "first", "--palette", "plain", "--no-cap"]


@pytest.fixture
def spectra():
    return rt.load_palettes("first")["plain"]


@pytest.fixture
def gamut():
    return rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")


def grey(path, levels):
    Image.fromarray(np.asarray(levels)).save(path)


def test_a_region_has_a_range_of_its_own(run, tmp_path, system, spectra, gamut):
    rt.save_system("first.npz", system)
    mask = np.zeros((24, 24), dtype=bool)
    mask[4:20, 10:24] = True
    grey(tmp_path / "mask.png", np.where(mask, 255, 0).astype(np.uint8))
    parted, spectra = rt.split(system, "red", mask, "side"), rt.with_region(spectra, "red", "side")
    for name in ("side", "red"):
        expected = rt.feasible(parted, spectra, gamut, rt.Scale(name), cap=False)
        for where in ("10,4,24,20", "mask.png"):
            words = [*ASKED, "--split", f"side=red:{where}", "-p", f"scale:{name}", "--json"]
            (record,) = json.loads(run("feasible", "first.npz", *words)[1])
            assert record["intervals"] == [list(interval) for interval in expected.intervals]
    words = [*ASKED, "--split", "side=red:mask.png", "-p", "scale:side", "-p", "scale:red", "--exposure", 3, "--json"]
    record = json.loads(run("fit", "first.npz", *words)[1])
    scales = [rt.Scale("side"), rt.Scale("red")]
    assert (
        record["values"] == rt.fit(parted, spectra, gamut, scales, cap=False, reference=rt.Reference(exposure=3)).values
    )
    assert record["values"]["side"] != record["values"]["red"]
    report = json.loads(run("report", "first.npz", *ASKED[:4], "--split", "side=red:mask.png", "--json")[1])
    assert set(report["verdicts"][0]["materials"]) >= {"side", "red"}
    record = json.loads(run("adapt", "first.npz", *words[: words.index("--exposure")], "--json")[1])
    assert record["verdict"] == "reached"


def test_weights_count_in_the_curve_and_in_shares(run, tmp_path, system, spectra, gamut):
    rt.save_system("first.npz", system)
    levels = np.tile(np.arange(24) * 10, (24, 1)).astype(np.uint8)
    grey(tmp_path / "weights.png", levels)
    words = ["feasible", "first.npz", *ASKED, "-p", "scale:red", "--allowed-out", 0.05, "--json"]
    expected = rt.feasible(system, spectra, gamut, rt.Scale("red"), weights=levels / 255, allowed_out=0.05, cap=False)
    code, out, _ = run(*words, "--weights", "weights.png", "--curve", "curve.png", "--plot", "ranges.png")
    assert code == 0
    assert json.loads(out)[0]["intervals"] == [list(interval) for interval in expected.intervals]
    assert json.loads(out)[0]["intervals"] != json.loads(run(*words)[1])[0]["intervals"]
    assert all((tmp_path / f"{name}.png").stat().st_size > 5_000 for name in ("curve", "ranges"))
    plain = rt.feasible(system, spectra, gamut, rt.Scale("red"), allowed_out=0.05, cap=False)
    t = np.linspace(0.5, 3, 9)
    assert not np.array_equal(expected.curve.outside(t), plain.curve.outside(t))


def test_sixteen_bits_and_one_bit_are_read_as_they_are(run, tmp_path, system, spectra, gamut):
    rt.save_system("first.npz", system)
    levels = (np.tile(np.arange(24), (24, 1)) * 2700).astype(np.uint16)
    grey(tmp_path / "deep.png", levels)
    grey(tmp_path / "bit.png", levels > 30_000)
    for name, weights in (("deep", levels / 65535), ("bit", (levels > 30_000).astype(float))):
        found = rt.feasible(system, spectra, gamut, rt.Scale("red"), weights=weights, allowed_out=0.1, cap=False)
        words = [*ASKED, "-p", "scale:red", "--allowed-out", 0.1, "--weights", f"{name}.png", "--json"]
        (record,) = json.loads(run("feasible", "first.npz", *words)[1])
        assert record["intervals"] == [list(interval) for interval in found.intervals]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--split", "side"], "write NAME=MATERIAL"),
        (["--split", "side=red:1,2,3"], "a region is X0,Y0,X1,Y1"),
        (["--split", "side=red:5,5,5,9"], "0 <= X0 < X1 <= 24"),
        (["--split", "side=red:0,0,25,9"], "the picture is 24 × 24"),
        (["--split", "side=blue:0,0,4,4"], "no material"),
        (["--split", "red=red:0,0,4,4"], "a name of its own"),
        (["--split", "a b=red:0,0,4,4"], "a name of its own"),
        (["--split", "side=red:missing.png"], "there is no such file"),
        (["--split", "side=red:black.png"], "no pixel is in the region"),
        (["--split", "side=red:small.png"], "give the same size"),
        (["--weights", "small.png"], "it is 5 × 4, the picture 24 × 24"),
        (["--weights", "colour.png"], "save it in grey"),
        (["--weights", "indexed.png"], "save it in grey"),
        (["--weights", "black.png"], "weight 0"),
        (["--weights", "text.png"], "give a whole PNG file"),
        (["--curve", "a.gif"], "must end in .png"),
        (["--curve", "a.png", "-p", "scale:sun"], "--curve draws one parameter"),
        (["--together", "--weights", "black.png", "--allowed-out", "0.1"], "leave out --allowed-out and --weights"),
    ],
)
def test_what_is_no_region_and_no_weight_is_refused(run, tmp_path, system, written, words, message):
    rt.save_system("first.npz", system)
    grey(tmp_path / "black.png", np.zeros((24, 24), dtype=np.uint8))
    grey(tmp_path / "small.png", np.full((4, 5), 255, dtype=np.uint8))
    grey(tmp_path / "colour.png", np.zeros((24, 24, 3), dtype=np.uint8))
    Image.fromarray(np.zeros((24, 24), dtype=np.uint8)).convert("P").save(tmp_path / "indexed.png")
    (tmp_path / "text.png").write_text("no picture")
    before = written(tmp_path)
    code, out, err = run("feasible", "first.npz", *ASKED, "-p", "scale:red", *words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert message in err
    assert written(tmp_path) == before


def test_pixels_are_moved_as_the_library_moves_them(run, tmp_path, system, spectra, gamut):
    rt.save_system("first.npz", system)
    seen = rt.Reference("sun", 2.0)
    words = ["map-pixels", "first.npz", *ASKED[:4], "--exposure", 2, "--towards", "centre", "--smoothness", 1.5]
    code, out, _ = run(*words, "--out", "moved.npz", "--plot", "moved.png", "--json")
    found = rt.map_pixels(system, spectra, gamut, towards="centre", smoothness=1.5, reference=seen)
    assert (code, json.loads(out)["share moved"]) == (0, found.share)
    assert found.share > 0.1
    with np.load(tmp_path / "moved.npz") as saved:
        assert np.array_equal(saved["values"], found.image.values)
    assert (tmp_path / "moved.png").stat().st_size > 5_000
    assert run(*words)[1] == f"{found!r}\n"


def test_an_adaptation_is_drawn_whether_it_is_reached_or_not(run, tmp_path, system):
    rt.save_system("first.npz", system)
    for k, criteria in enumerate((["--least-luminance", 0], ["--most-difference", 0.001])):
        words = [*ASKED, "-p", "scale:red", "--exposure", 2, *criteria, "--plot", f"{k}.png", "--json"]
        record = json.loads(run("adapt", "first.npz", *words)[1])
        assert record["verdict"] == ("reached", "not reached")[k]
        assert (tmp_path / f"{k}.png").stat().st_size > 5_000
