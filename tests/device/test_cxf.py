"""Charts in CxF3: every variant is read, and every fault ends in one line."""

import importlib.util

import numpy as np
import pytest
from device.written import AMOUNTS, SPECTRA, cxf_chart, i1profiler, real_chart, text_chart

from symrt.device.colorimetry import lab, tristimulus
from symrt.device.inks import load_device
from symrt.spectra.bands import wavelengths


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


@pytest.mark.parametrize("joined", ["place", "number"])
@pytest.mark.parametrize("drive", ["RGB", "10 bits", "CMYK"])
def test_of_a_chart_measured_in_two_ways_one_is_chosen_and_its_targets_are_joined(tmp_path, joined, drive):
    text, order = i1profiler(joined, drive=drive)
    file = tmp_path / "chart.mxf"
    file.write_text(text, encoding="utf-8")
    for mode, part in (("M0", 1), ("M2", 2)):
        device = load_device(file, mode=mode)
        np.testing.assert_allclose(device.samples, SPECTRA[order] / part, rtol=1e-11)
        inks = 4 if drive == "CMYK" else 3
        np.testing.assert_allclose(device.amounts, AMOUNTS[order, :inks], rtol=1e-11, atol=1e-15)
        assert device.inks == (("Cyan", "Magenta", "Yellow", "Black") if drive == "CMYK" else ("R", "G", "B"))
        assert f"Of measurements under M0 and M2 those under {mode} were read." in device.provenance
        assert f"joined from 7 targets by {'page, row and column' if joined == 'place' else 'number'}" in (
            device.provenance
        )
        assert "objects have no spectrum" not in device.provenance
        assert f"DeviceIllumination '{mode}_Light'" in device.provenance
    with pytest.raises(ValueError, match=r"the file has measurements under M0 and M2: choose one with the mode"):
        load_device(file)
    with pytest.raises(ValueError, match=r"mode = 'M1': the file has measurements under M0 and M2; choose one of th"):
        load_device(file, mode="M1")


def test_targets_that_nothing_joins_to_prints_are_left_and_said_to_be(tmp_path):
    file = tmp_path / "chart.mxf"
    text, order = i1profiler("nothing", modes=["M1"])
    file.write_text(text, encoding="utf-8")
    device = load_device(file, mode="M1")
    assert device.inks == ()
    assert "7 targets hold device values, and neither page, row and column nor a number joins" in device.provenance
    np.testing.assert_array_equal(load_device(file).samples, SPECTRA[order])


def test_a_mode_is_for_charts_that_have_one(tmp_path):
    file = tmp_path / "chart.txt"
    file.write_text(text_chart())
    with pytest.raises(ValueError, match=r"chart\.txt: mode = 'M0': only CxF3 keeps measurements under several"):
        load_device(file, mode="M0")
    with pytest.raises(ValueError, match=r"mode = 'M0': synthetic-cmyk is no chart in CxF3"):
        load_device("synthetic-cmyk", mode="M0")
    file = tmp_path / "chart.mxf"
    file.write_text(i1profiler(drive="10 bits")[0].replace(">1023<", ">0<"), encoding="utf-8")
    with pytest.raises(ValueError, match=r"object 'Target[1-7]': MaxRange is 0"):
        load_device(file, mode="M0")
