"""Charts as text, CGATS.17 and ti3: every variant is read, and every fault ends in one line."""

import numpy as np
import pytest
from device.written import AMOUNTS, SPECTRA, VARIANTS, WHOLE, text_chart

from symrt.device.inks import load_device
from symrt.spectra.bands import wavelengths


@pytest.mark.parametrize("variant", VARIANTS.values(), ids=VARIANTS)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_variant_of_a_text_chart_says_the_same(tmp_path, variant, encoding, end):
    file = tmp_path / "chart.ti3"
    file.write_bytes(text_chart(**variant).replace("\n", end).encode(encoding))
    device = load_device(file)
    assert device.bands == wavelengths(380, 730, 10)
    assert device.inks == ("C", "M", "Y", "K")
    np.testing.assert_allclose(device.samples, SPECTRA, rtol=1e-7)
    np.testing.assert_allclose(device.amounts, AMOUNTS, rtol=1e-7)
    assert not device.modelled
    assert "chart.ti3" in device.provenance
    assert repr(device).startswith("Device('chart.ti3', measured, 7 prints in")


def test_the_provenance_says_how_numbers_were_read(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart(scale=100.0))
    assert "read as percent: the largest is 90." in load_device(file).provenance
    assert "read as fractions of 100: the largest is 100." in load_device(file).provenance


def test_other_device_values_are_known_by_their_names(tmp_path):
    file = tmp_path / "chart.txt"
    for inks, names, scale in (
        (["6CLR_1", "6CLR_2", "6CLR_3"], ("1", "2", "3"), 100),
        (["RGB_R", "RGB_G", "RGB_B"], ("R", "G", "B"), 255),
        (["Cyan", "Magenta", "Orange"], ("cyan", "magenta", "orange"), 1),
        (["CMYKcm_C", "CMYKcm_c"], ("C", "c"), 100),
        ([], (), 1),
    ):
        file.write_text(text_chart(inks=inks, ink_scale=scale))
        device = load_device(file)
        assert device.inks == names
        np.testing.assert_allclose(device.amounts, AMOUNTS[:, : len(names)], rtol=1e-6)


def test_wavelengths_are_the_heads_where_names_carry_them_rounded(tmp_path):
    file = tmp_path / "chart.ti3"
    file.write_text(
        'CTI3\nSPECTRAL_BANDS "4"\nSPECTRAL_START_NM "380"\nSPECTRAL_END_NM "390"\nBEGIN_DATA_FORMAT\n'
        "SPEC_380 SPEC_383 SPEC_387 SPEC_390\nEND_DATA_FORMAT\nBEGIN_DATA\n80 81 82 83\nEND_DATA\n"
    )
    np.testing.assert_allclose(load_device(file).bands.centres, [380, 380 + 10 / 3, 380 + 20 / 3, 390], rtol=1e-15)


def test_pairs_of_wavelength_and_reflectance_are_read(tmp_path):
    file = tmp_path / "chart.cgt"
    fields = "SAMPLE_ID SPECTRAL_NM SPECTRAL_PCT SPECTRAL_NM SPECTRAL_PCT"
    text = (
        f"CGATS.5\nBEGIN_DATA_FORMAT\n{fields}\nEND_DATA_FORMAT\nBEGIN_DATA\n1 400 80 500 81\n2 400 5 500 6\nEND_DATA"
    )
    file.write_text(text)
    device = load_device(file)
    assert device.bands.centres == (400, 500)
    assert device.samples.tolist() == [[0.8, 0.81], [0.05, 0.06]]
    file.write_text(text.replace("2 400", "2 410"))
    with pytest.raises(ValueError, match=r"line 7: wavelength '410', but '400' in line 6"):
        load_device(file)


def test_a_print_may_run_over_lines_and_a_table_without_spectra_stands_aside(tmp_path):
    file = tmp_path / "chart.ti3"
    calibration = "CAL\nBEGIN_DATA_FORMAT\nRGB_R RGB_G\nEND_DATA_FORMAT\nBEGIN_DATA\n0 0\n1 1\nEND_DATA\n"
    fields = "BEGIN_DATA_FORMAT\nid nm400 nm500\nEND_DATA_FORMAT\n"
    chart = f"CTI3\n{fields}BEGIN_DATA\n1\n0.8 0.9 # paper\n2 0.1 0.2\nEND_DATA\n"
    for text in (chart + calibration, calibration + chart):
        file.write_text(text)
        assert load_device(file).samples.tolist() == [[0.8, 0.9], [0.1, 0.2]]


@pytest.mark.parametrize("separator", ["\t", " "])
def test_between_tabs_a_field_may_be_empty_and_have_spaces_whatever_the_names_stand_between(tmp_path, separator):
    file = tmp_path / "chart.txt"
    names = separator.join(["remark", "id", "nm400", "nm500", "note"])
    rows = "\t1\t0.8\t0.9\tbare paper\n\t2\t0.1\t0.2\t\n"
    file.write_text(f"BEGIN_DATA_FORMAT\n{names}\nEND_DATA_FORMAT\nBEGIN_DATA\n{rows}END_DATA\n")
    assert load_device(file).samples.tolist() == [[0.8, 0.9], [0.1, 0.2]]


def test_the_letters_of_windows_end_no_line(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_bytes(text_chart(head='CREATED "today…"').encode("cp1252"))
    np.testing.assert_allclose(load_device(file).samples, SPECTRA, rtol=1e-7)


BROKEN = {
    "device only": (text_chart(prefix="XX"), r"no spectra, only device values \(CMYK_C, .*export them too"),
    "missing band": (WHOLE.replace("SPECTRAL_NM500", "DENSITY"), r"field 510 nm follows 490 nm, but the step is 10 nm"),
    "announced band": (
        text_chart(head='SPECTRAL_BANDS "36"\nSPECTRAL_START_NM "380"\nSPECTRAL_END_NM "730"').replace("NM500", "X"),
        r"no field for 500 nm, but the head announces 36 bands",
    ),
    "twice": (WHOLE.replace("SPECTRAL_NM500", "nm490"), r"490 nm appears twice"),
    "word": (
        WHOLE.replace("0.9\t0.9", "0.9\thigh", 1),
        r"line 12, SPECTRAL_NM390: 'high' is",
    ),
    "comma": (WHOLE.replace("0.9\t0.9", "0.9\t0,9", 1), r"line 12, SPECTRAL_NM390: '0,9' is not .*decimal point"),
    "nan": (WHOLE.replace("0.9\t0.9", "0.9\tnan", 1), r"line 12, SPECTRAL_NM390: 'nan' is not a number"),
    "infinite": (WHOLE.replace("0.9\t0.9", "0.9\t1e999", 1), r"'1e999' is not a number"),
    "underscore": (WHOLE.replace("0.9\t0.9", "0.9\t1_0", 1), r"'1_0' is not a number"),
    "negative": (WHOLE.replace("0.9\t0.9", "0.9\t-0.2", 1), r"line 12: the reflectance -0.2 is not in \[0, 1\]"),
    "short row": (WHOLE.replace("0.9\t0.9", "0.9", 1), r"lines 12 to 13: 89 values for 45 fields"),
    "long row": (WHOLE.replace("0.9\t0.9", "0.9\t0.9\t0.9", 1), r"line 12: 46 values for 45 fields"),
    "cut": (WHOLE[: len(WHOLE) * 2 // 3], r"the file ends inside a table, without END_DATA"),
    "rows": (
        WHOLE.replace('NUMBER_OF_SETS "7"', "NUMBER_OF_SETS 9"),
        r"line 10: NUMBER_OF_SETS is '9', but there are 7",
    ),
    "fields": (WHOLE.replace("FIELDS 45", "FIELDS 44"), r"line 5: NUMBER_OF_FIELDS is '44', but there are 45"),
    "quote": (WHOLE.replace("# a comment", 'CREATED "today'), r"line 4: a quote is not closed"),
    "two charts": (WHOLE + WHOLE, r"2 tables with spectra"),
    "no chart": ("dear printer,\n", r"no BEGIN_DATA_FORMAT"),
    "no prints": ("BEGIN_DATA_FORMAT\nnm400\nEND_DATA_FORMAT\nBEGIN_DATA\nEND_DATA", r"no prints"),
    "empty": ("", r"no BEGIN_DATA_FORMAT"),
    "micrometres": (WHOLE.replace("SPECTRAL_NM", "NM0."), r"no spectra"),
    "too much ink": (text_chart(ink_scale=300.0), r"device values CMYK_C, .*: 300 is not in \[0, 1\] nor \[0, 100\]"),
    "code": (WHOLE.replace("0.9\t0.9", "0.9\t__import__('os').abort()", 1), r"is not a number"),
    "format again": (
        WHOLE.replace("END_DATA\n", "BEGIN_DATA_FORMAT\nnm740\nEND_DATA_FORMAT\nEND_DATA\n"),
        r"line 19: BEGIN_DATA_FORMAT inside a table",
    ),
    "fractions as percent": (text_chart(prefix="SPECTRAL_PCT"), r"its name says percent, but the largest number, 0.9,"),
    "percent as fractions": (
        text_chart(prefix="DEC_", scale=100),
        r"'DEC_380': its name says fractions, .* of percent",
    ),
    "ink twice": (text_chart(inks=["cyan", "cyan"], ink_scale=1), r"field 'cyan' appears twice"),
    "ink in two cases": (text_chart(inks=["Cyan", "cyan"], ink_scale=1), r"two inks are called 'cyan'"),
    "bytes": ("CGATS.17\0\0\0\xff", r"no BEGIN_DATA_FORMAT"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN.values(), ids=BROKEN)
def test_bad_text_charts_end_in_one_line(tmp_path, text, message):
    file = tmp_path / "bad.txt"
    file.write_text(text, encoding="latin-1", newline="")
    with pytest.raises(ValueError, match=message) as error:
        load_device(file)
    assert str(error.value).startswith(f"{file}: ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("separator", ["\t", " ", "    "])
@pytest.mark.parametrize(
    "head", ["", "IFRA chart\nMeasured by Müller, D50 2\u00b0\n\n", "LGOROWLENGTH 7\n# 380 390 400\n"]
)
@pytest.mark.parametrize("foot", ["", "\n\n", "\n\t\t\n# the end\n"])
def test_a_chart_without_keywords_is_read_from_the_line_that_names_its_fields(tmp_path, separator, head, foot):
    # IFRA exports: the fields' names, then the prints, and neither BEGIN_DATA_FORMAT nor BEGIN_DATA.
    lines = text_chart(prefix="nm", separator=separator).splitlines()
    start, end = lines.index("BEGIN_DATA_FORMAT"), lines.index("BEGIN_DATA")
    names = separator.join(lines[start + 1 : start + 3])
    file = tmp_path / "ifra.txt"
    file.write_text(head + "\n".join([names, *lines[end + 1 : -1]]) + foot, encoding="latin-1")
    device = load_device(file)
    assert device.bands == wavelengths(380, 730, 10)
    np.testing.assert_allclose(device.samples, SPECTRA, rtol=1e-7)
    np.testing.assert_allclose(device.amounts, AMOUNTS, rtol=1e-7)


def test_a_chart_without_keywords_that_is_broken_ends_in_one_line(tmp_path):
    file = tmp_path / "ifra.txt"
    for text, message in (
        ("SampleID nm380 nm390\n1 0.5\n", r"line 2: 2 values for 3 fields"),
        ("SampleID nm380 nm390\n1 0.5 high\n", r"line 2, nm390: 'high' is not a number"),
        ("SampleID nm380 nm390\n", r"no prints: the table has no rows"),
        ("380 390 400\n1 2 3\n", r"nor a line that names fields such as nm380: neither CGATS text nor CxF"),
        ("a letter\nof no numbers\n", r"neither CGATS text nor CxF; export the chart as one"),
    ):
        file.write_text(text)
        with pytest.raises(ValueError, match=message) as error:
            load_device(file)
        assert str(error.value).startswith(f"{file}: ")


def test_a_chart_that_lacks_an_ink_of_its_kind_says_so(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart(inks=["CMYK_C", "CMYK_M", "CMYK_Y"]))
    device = load_device(file)
    assert device.inks == ("C", "M", "Y")
    assert device.title == "7 prints with amounts of C, M, Y, read as 3 inks: there is no CMYK_K"
    file.write_text(text_chart())
    assert load_device(file).title == "7 prints with amounts of C, M, Y, K"
    file.write_text(text_chart(inks=["RGB_R", "RGB_G", "RGB_B"], ink_scale=255))
    assert load_device(file).title == "7 prints with amounts of R, G, B"
