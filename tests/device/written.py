"""Charts written for tests: the same prints as text, and as CxF."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

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

WHOLE = text_chart()


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


def i1profiler(joined="place", modes=("M0", "M2"), drive="RGB", extra=""):
    """A chart as i1Profiler exports it: targets with device values, then measurements in each mode, another order."""
    order = np.random.default_rng(1).permutation(len(SPECTRA))

    def tags(i):
        tags = {"Page": i // 4, "Row": i % 4, "Column": 7} if joined == "place" else {}
        inner = "".join(f'<cc:Tag Name="{name}" Value="{value}"/>' for name, value in tags.items())
        return f'<cc:TagCollection Name="Location">{inner}</cc:TagCollection>'

    objects = []
    for i, (c, m, y, k) in enumerate(AMOUNTS):
        values = {"R": 255 * c, "G": 255 * m, "B": 255 * y}
        if drive == "CMYK":
            values = {"Cyan": 100 * c, "Magenta": 100 * m, "Yellow": 100 * y, "Black": 100 * k}
        inner = "".join(f"<cc:{name}>{value:.12g}</cc:{name}>" for name, value in values.items())
        if drive == "10 bits":
            inner = f"<cc:MaxRange>1023</cc:MaxRange><cc:R>{1023 * c:.12g}</cc:R><cc:G>{1023 * m:.12g}</cc:G>"
            inner += f"<cc:B>{1023 * y:.12g}</cc:B>"
        kind = "ColorCMYK" if drive == "CMYK" else "ColorRGB"
        objects.append(
            f'<cc:Object ObjectType="Target" Name="Target{i + 1}" Id="c{i}"><cc:DeviceColorValues><cc:{kind}>{inner}'
            f"</cc:{kind}></cc:DeviceColorValues>{tags(i)}</cc:Object>"
        )
    for number, mode in enumerate(modes):
        for i in order:
            text = " ".join(f"{value / (1 + number):.12g}" for value in SPECTRA[i])
            name = f"{mode}_Measurement{i + 1}" if joined != "nothing" else f"{mode}_Measurement"
            objects.append(
                f'<cc:Object ObjectType="{mode}_Measurement" Name="{name}" Id="c{mode}{i}"><cc:ColorValues>'
                f'<cc:ReflectanceSpectrum StartWL="380" ColorSpecification="CS_{mode}">{text}</cc:ReflectanceSpectrum>'
                f"</cc:ColorValues>{tags(i)}</cc:Object>"
            )
    specifications = "".join(
        f'<cc:ColorSpecification Id="CS_{mode}"><cc:MeasurementSpec><cc:Device><cc:DeviceIllumination>{mode}_Light'
        '</cc:DeviceIllumination></cc:Device><cc:WavelengthRange StartWL="380" Increment="10"/></cc:MeasurementSpec>'
        "</cc:ColorSpecification>"
        for mode in modes
    )
    text = (
        '<?xml version="1.0" encoding="UTF-8"?><cc:CxF xmlns:cc="http://colorexchangeformat.com/CxF3-core">'
        f"<cc:Resources><cc:ObjectCollection>{''.join(objects)}{extra}</cc:ObjectCollection>"
        f"<cc:ColorSpecificationCollection>{specifications}</cc:ColorSpecificationCollection></cc:Resources></cc:CxF>"
    )
    return text, order


def real_chart():
    if importlib.util.find_spec("colour_cxf") is None:
        pytest.skip("colour-cxf, which carries the real chart, is not installed: pip install symrt[print]")
    origin = importlib.util.find_spec("colour_cxf").origin
    return Path(origin).parent / "tests" / "resources" / "sample.cxf"
