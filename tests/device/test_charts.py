"""Charts of any kind: what is too much, damaged, missing or on other bands; and their gamuts."""

import io

import numpy as np
import pytest
from device.written import AMOUNTS, INKS, NM, SPECTRA, VARIANTS, cxf_chart, text_chart

from symrt.device import cxf, measured
from symrt.device.inks import load_device
from symrt.device.printing import reflectance
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.gamuts import device_gamut
from symrt.spectra.bands import wavelengths

HUGE = {
    "endless.txt": ("BEGIN_DATA_FORMAT\nnm400\nEND_DATA_FORMAT\nBEGIN_DATA\n" + "1\n" * 1001, "1001 prints"),
    "wide.txt": ("BEGIN_DATA_FORMAT\n" + "x\n" * 5000, "5000 numbers|4097 numbers a print"),
    "endless.csv": ("400\n" + "1\n" * 1001, "1001 prints"),
    "wide.csv": (",".join(map(str, range(100, 6000))), "5900 numbers a print"),
    "crowd.cxf": ("<a>" + "<b/>" * 2000, "more than 1000 elements"),
    "long.cxf": (
        "<Object><ColorValues><ReflectanceSpectrum>" + "1 " * 5000 + "</ReflectanceSpectrum></ColorValues></Object>",
        "5000 numbers a print",
    ),
}


@pytest.mark.parametrize("name", HUGE)
def test_what_is_too_much_for_a_chart_is_refused_before_all_of_it_is_kept(tmp_path, monkeypatch, name):
    monkeypatch.setattr(measured, "MOST_PRINTS", 1000)
    monkeypatch.setattr(cxf, "MOST_ELEMENTS", 1000)
    text, message = HUGE[name]
    (tmp_path / name).write_text(f"<r>{text}</r>" if name == "long.cxf" else text)
    with pytest.raises(ValueError, match=message) as error:
        load_device(tmp_path / name)
    assert "\n" not in str(error.value)


def test_a_device_that_never_ends_is_not_read_to_its_end():
    with pytest.raises(ValueError, match=r"/dev/zero: a pipe or a device, not a file"):
        load_device("/dev/zero")


def whole_files():
    """A file of each kind."""
    archive = io.BytesIO()
    np.savez_compressed(archive, wavelengths=NM, reflectances=SPECTRA, amounts=AMOUNTS)
    table = "\n".join(",".join(map(str, row)) for row in [list(NM), *SPECTRA.tolist()])
    texts = {"a.ti3": text_chart(**VARIANTS["Argyll"]), "b.txt": text_chart(), "c.cxf": cxf_chart(), "d.csv": table}
    return {name: text.encode() for name, text in texts.items()} | {"e.npz": archive.getvalue()}


def damaged(content, draw):
    """The file with some bytes changed, lost, doubled or cut off, or a word thrown in."""
    first = int(draw.integers(len(content)))
    last = first + int(draw.integers(1, 40))
    word = [b"nan", b"1e999", b'"', b"\t", b"\n", b"END_DATA\n", b"<", b"&x;", b"-", b"9" * 99][draw.integers(10)]
    return [
        content[:first] + content[last:],
        content[:first] + draw.bytes(1) + content[first + 1 :],
        content[:last] + content[first:],
        content[:first],
        content[:first] + word + content[first:],
    ][draw.integers(5)]


@pytest.mark.parametrize("name", whole_files())
def test_damaged_files_are_read_or_refused_in_one_line(tmp_path, name):
    file, whole = tmp_path / name, whole_files()[name]
    draw = np.random.default_rng(0)
    refused = []
    for _ in range(150):
        file.write_bytes(damaged(whole, draw))
        try:
            device = load_device(file)
        except ValueError as error:
            refused.append(str(error))
        else:
            assert np.isfinite(device.samples).all()
            assert (device.samples.min(), device.samples.max()) >= (-0.01, 0)
    assert len(refused) > 75
    assert all(line.startswith(f"{file}: ") and "\n" not in line and len(line) < 500 for line in refused)


def test_paths_that_lead_to_no_chart_are_named(tmp_path):
    with pytest.raises(ValueError, match=r"none.ti3: cannot be read: No such file"):
        load_device(tmp_path / "none.ti3")
    with pytest.raises(ValueError, match=r"cannot be read: Is a directory"):
        load_device(tmp_path)
    with pytest.raises(ValueError, match=r"^'a.x00.ti3' is not a file name: give the path of a chart"):
        load_device("a\0.ti3")
    with pytest.raises(ValueError, match=r"no device 'chart'; there are: .*or give the path of a chart"):
        load_device("chart")


def test_other_bands_are_interpolated_and_never_extrapolated(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart())
    fine = load_device(file, wavelengths(400, 700, 5))
    np.testing.assert_allclose(fine.samples[:, ::2], load_device(file).samples[:, 2:33], rtol=1e-12)
    middle = (load_device(file).samples[:, 2] + load_device(file).samples[:, 3]) / 2
    np.testing.assert_allclose(fine.samples[:, 1], middle, rtol=1e-12)
    with pytest.raises(ValueError, match=r"chart.txt covers 380 … 730 nm, .*nothing is extrapolated"):
        load_device(file, wavelengths(370, 730, 10))


@pytest.mark.parametrize("inks", [INKS, []])
def test_the_gamut_of_a_chart_is_saved_and_comes_back(tmp_path, inks):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart(inks=inks))
    gamut = device_gamut(load_device(file), "envelope", "strict")
    save_gamut(tmp_path / "gamut.npz", gamut)
    again = load_gamut(tmp_path / "gamut.npz")
    assert repr(again) == repr(gamut)
    assert (again.device.inks, again.device.printer) == (gamut.device.inks, None)
    np.testing.assert_array_equal(again.device.samples, gamut.device.samples)
    np.testing.assert_array_equal(again.lower, SPECTRA.min(axis=0).round(8))


def test_a_chart_alone_has_no_model(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart())
    with pytest.raises(ValueError, match=r"known by its samples alone: fit a model"):
        reflectance(load_device(file), AMOUNTS)
