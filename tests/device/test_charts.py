"""Readers of charts on files that the test writes in every variant, and on one real chart of another library."""

import importlib.util
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from symrt.device import cxf, measured
from symrt.device.colorimetry import lab, tristimulus
from symrt.device.inks import load_device, reflectance
from symrt.gamut.files import load_gamut, save_gamut
from symrt.gamut.slabs import device_gamut
from symrt.spectra.bands import wavelengths

NM = np.arange(380, 731, 10)
DRAW = np.random.default_rng(0)
AMOUNTS = np.vstack([np.zeros(4), np.ones(4), DRAW.uniform(0, 1, (5, 4)).round(4)])
SPECTRA = np.vstack([np.full(36, 0.9), DRAW.uniform(0.02, 0.8, (6, 36)).round(6)])
INKS = ["CMYK_C", "CMYK_M", "CMYK_Y", "CMYK_K"]


def text_chart(
    prefix="SPECTRAL_NM", separator="\t", scale=1.0, ink_scale=100.0, quote="", first="CGATS.17", head="", inks=INKS
):
    """A chart as CGATS text; the prints' names hold a space where the format lets them."""
    names = ["SAMPLE_ID", "SAMPLE_NAME", *inks, "LAB_L", "XYZ_X", "STDE_E", *(f"{prefix}{nm}" for nm in NM)]
    lines = [first, 'ORIGINATOR "A ""printer"" of Müller"', head, "# a comment", f"NUMBER_OF_FIELDS {len(names)}"]
    lines += ["BEGIN_DATA_FORMAT", separator.join(names[:7]), separator.join(names[7:]), "END_DATA_FORMAT"]
    lines += [f'NUMBER_OF_SETS "{len(SPECTRA)}"', "BEGIN_DATA"]
    name = "A 1" if quote or separator == "\t" else "A1"
    for i, (amounts, spectrum) in enumerate(zip(AMOUNTS, SPECTRA, strict=True)):
        values = [*(amounts[: len(inks)] * ink_scale), 50.0, 20.0, 0.1, *(spectrum * scale)]
        fields = [f"{i + 1}", f"{quote}{name}{quote}", *(f"{value:.8g}" for value in values)]
        lines.append(separator.join(fields))
    return "\n".join([*lines, "END_DATA", ""])


VARIANTS = {
    "tabs, fractions": {},
    "spaces, quoted names": {"separator": " ", "quote": '"'},
    "many spaces": {"separator": "   "},
    "percent": {"scale": 100.0},
    "inks as fractions": {"ink_scale": 1.0},
    "Argyll": {
        "prefix": "SPEC_",
        "separator": " ",
        "scale": 100.0,
        "first": "CTI3   ",
        "quote": '"',
        "head": 'DEVICE_CLASS "OUTPUT"\nKEYWORD "SPECTRAL_BANDS"\nSPECTRAL_BANDS "36"\nSPECTRAL_START_NM "380.000000"\n'
        'SPECTRAL_END_NM "730.000000"',
    },
    "nm": {"prefix": "nm"},
    "capitals": {"prefix": "NM_", "separator": " "},
    "bare": {"prefix": ""},
    "old": {"prefix": "SPECTRAL_DEC_"},
    "percent by name": {"prefix": "SPECTRAL_PCT", "scale": 100.0},
}


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


WHOLE = text_chart()
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


def cxf_chart(
    spectrum='StartWL="380" ColorSpecification="CS1"', kind="ColorCMYKPlusN", prefix="cc:", scale=1.0, doctype=""
):
    """A chart as CxF3, one spot colour beside the four inks."""
    p = prefix
    objects = []
    for i, (amounts, values) in enumerate(zip(AMOUNTS, SPECTRA, strict=True)):
        inks = "".join(
            f"<{p}{name}>{100 * amount:.8g}</{p}{name}>"
            for name, amount in zip(("Cyan", "Magenta", "Yellow"), amounts, strict=False)
        )
        inks += f"<{p}Black>0</{p}Black>"
        if kind == "ColorCMYKPlusN":
            spot = f"<{p}Name>Orange</{p}Name><{p}Percentage>{100 * amounts[3]:.8g}</{p}Percentage>"
            inks += f"<{p}SpotColor>{spot}</{p}SpotColor>"
        numbers = " ".join(f"{value:.8g}" for value in values * scale)
        objects.append(
            f'<{p}Object ObjectType="Target" Name="{i + 1}" Id="{i + 1}"><{p}ColorValues><{p}ColorCIELab/>'
            f"<{p}ReflectanceSpectrum {spectrum}>{numbers}</{p}ReflectanceSpectrum></{p}ColorValues>"
            f"<{p}DeviceColorValues><{p}{kind}>{inks}</{p}{kind}></{p}DeviceColorValues></{p}Object>"
        )
    space = f"xmlns:{p[:-1]}" if p else "xmlns"
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>{doctype}\n<{p}CxF {space}="http://colorexchangeformat.com/CxF3-core">'
        f'<{p}Resources><{p}ObjectCollection>{"".join(objects)}<{p}Object Name="substrate"/></{p}ObjectCollection>'
        f'<{p}ColorSpecificationCollection><{p}ColorSpecification Id="CS1"><{p}MeasurementSpec>'
        f'<{p}WavelengthRange StartWL="380" Increment="10"/></{p}MeasurementSpec></{p}ColorSpecification>'
        f"</{p}ColorSpecificationCollection></{p}Resources></{p}CxF>"
    )


@pytest.mark.parametrize(
    "variant",
    [{}, {"prefix": ""}, {"scale": 100.0}, {"spectrum": 'ColorSpecification="CS1"'}, {"kind": "ColorCMYK"}],
    ids=["prefix", "no prefix", "percent", "range in the specification", "four inks"],
)
def test_every_variant_of_cxf_says_the_same(tmp_path, variant):
    file = tmp_path / "chart.cxf"
    file.write_text(cxf_chart(**variant), encoding="utf-8")
    device = load_device(file)
    assert device.bands == wavelengths(380, 730, 10)
    np.testing.assert_allclose(device.samples, SPECTRA, rtol=1e-7)
    np.testing.assert_allclose(device.amounts[:, :3], AMOUNTS[:, :3], rtol=1e-7)
    assert device.inks == ("Cyan", "Magenta", "Yellow", "Black", "Orange")[: 4 + (variant.get("kind") is None)]
    if len(device.inks) == 5:
        np.testing.assert_allclose(device.amounts[:, 4], AMOUNTS[:, 3], rtol=1e-7)
    assert "1 objects have no spectrum" in device.provenance


def test_the_provenance_says_how_a_chart_was_measured_as_far_as_its_head_does(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart(head='INSTRUMENTATION "Spectro 5"\nMEASUREMENT_SOURCE "Illumination=M1 UVCut=No"'))
    said = load_device(file).provenance
    assert "INSTRUMENTATION 'Spectro 5', MEASUREMENT_SOURCE 'Illumination=M1 UVCut=No'." in said
    cxf = tmp_path / "chart.cxf"
    cxf.write_text(cxf_chart(), encoding="utf-8")
    assert load_device(cxf).provenance.endswith("Its head does not say how it was measured.")
    device = "<cc:Device><cc:DeviceFilter>Filter_None</cc:DeviceFilter>"
    device += "<cc:DeviceIllumination>M1_Daylight</cc:DeviceIllumination></cc:Device>"
    told = cxf_chart().replace("<cc:WavelengthRange", f"{device}<cc:WavelengthRange")
    cxf.write_text(told, encoding="utf-8")
    assert "DeviceFilter 'Filter_None', DeviceIllumination 'M1_Daylight'." in load_device(cxf).provenance
    # The first print under another condition than the rest: colours that nothing would have.
    other = told.replace("CS1", "CS0", 1)
    second = '<cc:ColorSpecification Id="CS0"><cc:MeasurementSpec><cc:Device><cc:DeviceIllumination>M0_Incandescent'
    second += (
        '</cc:DeviceIllumination></cc:Device><cc:WavelengthRange StartWL="380" Increment="10"/></cc:MeasurementSpec>'
    )
    second += "</cc:ColorSpecification>"
    cxf.write_text(
        other.replace("<cc:ColorSpecification Id", f"{second}<cc:ColorSpecification Id", 1), encoding="utf-8"
    )
    with pytest.raises(ValueError, match=r"object '2': measured otherwise than the prints before it"):
        load_device(cxf)


LAUGHS = "<!DOCTYPE x [<!ENTITY a 'ha'>" + "".join(
    f"<!ENTITY {chr(98 + i)} '{f'&{chr(97 + i)};' * 10}'>" for i in range(12)
)
BROKEN_CXF = {
    "laughs": (cxf_chart(doctype=LAUGHS + "]>").replace(">0.9 0.9", ">&m; 0.9", 1), r"line 1: a document type"),
    "outside": (cxf_chart(doctype='<!DOCTYPE x SYSTEM "secret.dtd">'), r"a document type .*take it out"),
    "cut": (cxf_chart()[:2000], r"not whole XML"),
    "deep": ("<a>" * 100_000, r"nested 65 deep"),
    "other": ("<html></html>", r"no ReflectanceSpectrum"),
    "no spectra": (cxf_chart().replace("ReflectanceSpectrum", "EmissiveSpectrum"), r"no ReflectanceSpectrum"),
    "no step": (cxf_chart(spectrum='StartWL="380"'), r"object '1': no Increment, so that its wavelengths are unknown"),
    "no start": (cxf_chart(spectrum=""), r"object '1': no StartWL"),
    "word": (
        cxf_chart().replace(">0.9 0.9", ">0.9 high", 1),
        r"object '1', ReflectanceSpectrum: 'high' is not a number",
    ),
    "missing band": (cxf_chart().replace(">0.9 0.9", ">0.9", 1), r"object '2': Bands\(36 .* keep one measurement"),
    "ink": (cxf_chart().replace(">100</cc:Cyan>", ">101</cc:Cyan>"), r"object '2': Cyan is 101: inks are percent"),
    "other inks": (cxf_chart().replace("Orange", "Green", 1), r"object '2': other inks"),
    "encoding": (cxf_chart().replace('encoding="UTF-8"', 'encoding="secret"'), r"not whole XML \(unknown encoding"),
    "prefix": (cxf_chart().replace("<cc:Resources>", "<cd:Resources>"), r"not whole XML \(unbound prefix"),
    "ink twice": (cxf_chart().replace("Orange", "Cyan"), r"object '1': 'Cyan' appears twice; keep one amount an ink"),
    "nameless ink": (cxf_chart().replace("Orange", " "), r"an ink is called '': give it a name"),
    "long name": (cxf_chart().replace("Orange", "O" * 1000), r"an ink is called 'OO+': give it a name of 1 to 64"),
    "control": (cxf_chart().replace("Orange", "\x9b31m"), r"an ink is called '.x9b31m': give it a name"),
    "element": (cxf_chart().replace(">0.9 0.9", ">0.9 <cc:Lab/> 0.9", 1), r"object '1': .* holds other elements"),
    "specifications": (
        cxf_chart().replace("</cc:ColorSpecificationC", '<cc:ColorSpecification Id="CS1"/></cc:ColorSpecificationC'),
        r"two ColorSpecifications are called 'CS1'",
    ),
    "step": (cxf_chart().replace('Increment="10"', 'Increment="0"'), r"object '1': bands: .*must increase"),
}


@pytest.mark.parametrize(("text", "message"), BROKEN_CXF.values(), ids=BROKEN_CXF)
def test_bad_cxf_ends_in_one_line(tmp_path, text, message):
    file = tmp_path / "bad.cxf"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message) as error:
        load_device(file)
    assert str(error.value).startswith(f"{file}: ")
    assert "\n" not in str(error.value)


def real_chart():
    if importlib.util.find_spec("colour_cxf") is None:
        pytest.skip("colour-cxf, which carries the real chart, is not installed: pip install symrt[print]")
    origin = importlib.util.find_spec("colour_cxf").origin
    return Path(origin).parent / "tests" / "resources" / "sample.cxf"


def test_the_real_chart_reads_as_by_colour_cxf_and_its_lab_follows_from_its_spectra():
    file = real_chart()
    device = load_device(file)
    assert device.bands == wavelengths(380, 680, 10)
    colour_cxf = importlib.import_module("colour_cxf")
    spectra, labs = [], []
    for one in colour_cxf.read_cxf_from_file(file).resources.object_collection.object_value:
        values = {type(choice).__name__: choice for choice in one.color_values.choice}
        spectra.append(values["ReflectanceSpectrum"].value)
        labs.append([values["ColorCielab"].l, values["ColorCielab"].a, values["ColorCielab"].b])
    assert len(spectra) == 144
    np.testing.assert_array_equal(device.samples, np.array(spectra))
    # The file says: D50, 2°, ASTM E308 table 5, which is the table for bands every 10 nm.
    ours = lab(device.samples @ tristimulus(device.bands, "illuminant/D50"), "illuminant/D50")
    assert np.linalg.norm(ours - np.array(labs), axis=1).max() <= 0.2


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv_names_its_columns_in_the_first_line(tmp_path, delimiter, end):
    file = tmp_path / "chart.csv"
    rows = [["name", *INKS, *map(str, NM)]]
    rows += [["a print", *map(repr, map(float, [*a, *s]))] for a, s in zip(AMOUNTS, SPECTRA, strict=True)]
    file.write_text(end.join(delimiter.join(row) for row in rows), newline="")
    device = load_device(file)
    np.testing.assert_array_equal(device.samples, SPECTRA)
    np.testing.assert_array_equal(device.amounts, AMOUNTS)
    file.write_text("name,400\na,0.5,0.6")
    with pytest.raises(ValueError, match=r"chart.csv: line 2: 3 values for 2 fields"):
        load_device(file)
    file.write_text("")
    with pytest.raises(ValueError, match=r"no lines"):
        load_device(file)


def test_numpy_archives_hold_reflectances_by_name(tmp_path):
    file = tmp_path / "chart.npz"
    np.savez(file, wavelengths=NM, reflectances=SPECTRA, amounts=AMOUNTS, inks=np.array(["c", "m", "y", "k"]))
    device = load_device(file)
    np.testing.assert_array_equal(device.samples, SPECTRA)
    np.testing.assert_array_equal(device.amounts, AMOUNTS)
    assert device.inks == ("c", "m", "y", "k")
    for arrays, message in (
        ({"reflectances": SPECTRA}, r"no array 'wavelengths', only 'reflectances'"),
        ({"wavelengths": NM, "reflectances": SPECTRA * np.nan}, r"'reflectances' does not hold finite numbers"),
        ({"wavelengths": NM, "reflectances": np.array([object()])}, r"not a whole|allow_pickle"),
        ({"wavelengths": NM / 1000, "reflectances": SPECTRA}, r"look like micrometres"),
        ({"wavelengths": NM[::-1], "reflectances": SPECTRA}, r"wavelengths must increase"),
        ({"wavelengths": NM[:9], "reflectances": SPECTRA}, r"reflectances are \(7, 36\) for \(9,\) wavelengths"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS[:3]}, r"amounts are \(3, 4\) for 7 prints"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS * 100}, r"divide percent by 100"),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": np.float64(0.5)}, r"amounts are \(\) for 7 prints"),
        (
            {"wavelengths": NM, "reflectances": SPECTRA.astype(np.longdouble) * np.longdouble("1e4000")},
            r"finite numbers",
        ),
        ({"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS, "inks": np.array(list("CCMY"))}, "two inks"),
        (
            {"wavelengths": NM, "reflectances": SPECTRA, "amounts": AMOUNTS[:, :1], "inks": np.array(["a\nb"])},
            r"an ink is called 'a\\nb'",
        ),
    ):
        np.savez(file, **arrays)
        with pytest.raises(ValueError, match=message) as error:
            load_device(file)
        assert "\n" not in str(error.value)


def test_archives_of_something_else_are_refused(tmp_path):
    file, head = tmp_path / "other.npz", io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
    for content, message in (
        (b"hello", r"not a whole .npz \("),
        (head.getvalue(), r"the shape of 'reflectances' is not"),
    ):
        with zipfile.ZipFile(file, "w") as archive:
            archive.writestr("reflectances", content)
            archive.writestr("wavelengths", content)
        with pytest.raises(ValueError, match=message) as error:
            load_device(file)
        assert str(error.value).endswith("save it again with numpy.savez")


def test_bombs_are_refused_before_they_unfold(tmp_path):
    file = tmp_path / "bomb.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("reflectances.npy", bytes(33 << 20))
    with pytest.raises(ValueError, match=r"'reflectances.npy' claims more than 32 MiB"):
        load_device(file)
    file = tmp_path / "long.txt"
    with file.open("wb") as out:
        out.truncate(33 << 20)
    with pytest.raises(ValueError, match=r"a chart has at most 32 MiB"):
        load_device(file)
    # Many arrays, each within the limit, and not needed.
    zeros = io.BytesIO()
    np.save(zeros, np.zeros(1 << 20))
    file = tmp_path / "many.npz"
    np.savez(file, wavelengths=NM, reflectances=SPECTRA)
    with zipfile.ZipFile(file, "a", zipfile.ZIP_DEFLATED) as archive:
        for i in range(5):
            archive.writestr(f"zeros{i}.npy", zeros.getvalue())
    with pytest.raises(ValueError, match=r"'zeros3.npy' claims more than 32 MiB together"):
        load_device(file)


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
    with pytest.raises(ValueError, match=r"/dev/zero: it is too large"):
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
