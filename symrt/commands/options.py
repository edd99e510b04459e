"""Names and help texts of the command line's options, each written once for every command that has it."""

from pathlib import Path
from typing import Annotated, Literal

import typer

DEVICE = "dye3-endura-premier"
"""The device if none is named."""
PICTURES = (".png", ".tif", ".tiff", ".npz", ".exr")
"""Endings of the files that a picture can be written to."""

SceneFile = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file, or globe, metals, spheres or first.")]
Source = Annotated[str, typer.Argument(metavar="SCENE|SYSTEM", help="A scene, or a rendered system (.npz).")]
Size = Annotated[str | None, typer.Option("--size", metavar="W[xH]", help="Pixels; the scene's own if not given.")]
PaletteName = Annotated[str | None, typer.Option("--palette", help="Which palette, if the file has several.")]
PaletteFile = Annotated[str | None, typer.Option("--palettes", help="File with palettes, if not the scene itself.")]
Exposure = Annotated[float, typer.Option("--exposure", help="Factor on every radiance.")]
Reference = Annotated[
    str | None,
    typer.Option("--reference", help="White of a light, equal-energy, illuminant/...; else the key light's."),
]
WhiteOf = Annotated[
    str | None,
    typer.Option("--white-of", help="Seen against the white of this palette of the same file: a dimmed lamp dims."),
]
DeviceName = Annotated[
    str, typer.Option("--device", help="A device, a chart's file, a gamut saved as .npz, or several joined by +.")
]
Mode = Annotated[
    Literal["M0", "M1", "M2", "M3"] | None,
    typer.Option("--mode", help="Which measurements of a chart in CxF3 or .mxf that was measured in several ways."),
]
ModelName = Annotated[
    Literal["unit", "envelope", "hull", "inks", "colorimetric", "monitor"] | None,
    typer.Option("--model", help="Which gamut of the device: a printer's envelope, a monitor's colours."),
]
Models = Annotated[
    list[str] | None,
    typer.Option("--model", help="unit, envelope, hull, colorimetric or inks; may be repeated; the first four."),
]
Monitor = Annotated[str, typer.Option("--monitor", help="A monitor to compare with: crt-brainard, srgb, ...")]
BlackName = Annotated[
    Literal["clip", "luminance", "strict"] | None, typer.Option("--black", help="What becomes of the dark: clip.")
]
ViewingLight = Annotated[
    str | None, typer.Option("--light", help="Viewing light of the model colorimetric; illuminant/D50 if not given.")
]
Tolerance = Annotated[
    float | None,
    typer.Option(
        "--tolerance", help="RMS difference that passes for none in a hull or inks, 0.01; of colours, a share of Y."
    ),
]
Resample = Annotated[
    bool, typer.Option("--resample", help="Bring the palette to the device's bands, where it reaches that far.")
]
Within = Annotated[
    tuple[float, float] | None,
    typer.Option("--within", help="Least and largest value looked at: 0.01 3, for a blend 0 1."),
]
Components = Annotated[
    tuple[int, int, int],
    typer.Option("--components", help="Which three are drawn, the first upright; 0 is the neutral axis."),
]
Parameters = Annotated[
    list[str],
    typer.Option(
        "--parameter", "-p", help="scale:NAME, blend:FROM:TO, blend:FROM:TO:kubelka-munk or exposure; repeatable."
    ),
]
Scales = Annotated[
    list[str], typer.Option("--parameter", "-p", help="scale:NAME of a light, a material or a component; repeatable.")
]
Cap = Annotated[bool, typer.Option("--cap/--no-cap", help="Keep reflectances physical, their sum at most 1.")]
AllowedOut = Annotated[float, typer.Option("--allowed-out", help="Share of pixels that may be outside.")]
LeastInside = Annotated[float, typer.Option("--least-inside", help="Least share of pixels inside.")]
MostDifference = Annotated[
    float | None, typer.Option("--most-difference", help="Largest mean CIEDE2000 from the image given.")
]
LeastLightness = Annotated[
    float | None, typer.Option("--least-lightness", help="Least mean L*, as a share of that of the image given.")
]
MapRest = Annotated[bool, typer.Option("--map-rest", help="At last, pixels may be moved one by one.")]
Out = Annotated[
    Path | None, typer.Option("--out", "-o", help="The picture as it is seen (.png), or radiances (.tif, .npz, .exr).")
]
Towards = Annotated[
    Literal["neutral", "centre", "nearest"], typer.Option("--towards", help="Where pixels outside move.")
]
Smoothness = Annotated[float, typer.Option("--smoothness", help="Pixels over which the amount is evened out.")]
Of = Annotated[str | None, typer.Option("--of", help="Only pixels that this material or light contributes to.")]
Without = Annotated[
    list[str] | None,
    typer.Option(
        "--without",
        metavar="EFFECT",
        help="An effect to leave out, such as shadows; what is lost is bounded. Repeatable.",
    ),
]
Thrift = Annotated[
    float | None,
    typer.Option(
        "--tolerance",
        metavar="SHARE",
        help="Rays that carry less of a sample's light end, 0.001 if not given; if given, effects that are missed by "
        "less are left out. What is lost is bounded.",
    ),
]
Freed = Annotated[
    list[str] | None,
    typer.Option(
        "--free",
        metavar="NAME[=LOW,HIGH]",
        help="Keep a parameter free, as brass.exponent=10,160, or brass.exponent=first-order,36,44; see settle.",
    ),
]
InterpolationError = Annotated[
    float | None,
    typer.Option(
        "--error",
        help="Largest error of free parameters, and of lengths of absorbing glass, 0.001 as a share of light.",
    ),
]
LengthScheme = Annotated[
    Literal["hats", "chebyshev"],
    typer.Option("--lengths", help="How lengths are interpolated: chebyshev is finer, but makes signed columns."),
]
Weights = Annotated[
    Path | None,
    typer.Option("--weights", help="What each pixel counts: a grey picture, white 1; black is left out (.png)."),
]
Curve = Annotated[
    Path | None, typer.Option("--curve", help="Draw what share is outside at each value of one parameter (.png).")
]
Split = Annotated[
    list[str] | None,
    typer.Option(
        "--split",
        metavar="NAME=MATERIAL:X0,Y0,X1,Y1",
        help="Call a material otherwise in a region: columns X0 … X1-1 and rows Y0 … Y1-1, or "
        "NAME=MATERIAL:MASK.png where the mask is white; repeatable.",
    ),
]
PaletteOut = Annotated[Path | None, typer.Option("--palette-out", help="The spectra found, as a palette file (.toml).")]
Json = Annotated[bool, typer.Option("--json", help="For a program to read.")]
Plot = Annotated[Path | None, typer.Option("--plot", help="Draw it (.png).")]
Region = Annotated[
    Path | None, typer.Option("--region", help="Draw which pairs of two parameters keep the picture inside (.png).")
]
Objective = Annotated[
    Literal["lightest", "darkest", "closest", "lexicographic", "brightest", "contrast"],
    typer.Option(
        "--objective",
        help="lexicographic: inside, then as well exposed as may be, then changed least. closest: changed least. "
        "lightest: all scales rise together, each until a pixel stops it. brightest: largest mean luminance. "
        "darkest: all sink together. contrast: largest ratio of light to dark regions.",
    ),
]
LeastLuminance = Annotated[
    float,
    typer.Option(
        "--least-luminance", help="Least acceptable share of the luminance given; 0 for any. Not for darkest."
    ),
]
Together = Annotated[
    bool, typer.Option("--together", help="One box in which all the scales may move freely, not range by range.")
]
