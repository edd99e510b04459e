"""Gamuts of every model, and intersections of some, on few bands, for tests that ask all of them alike."""

from symrt.device import load_device
from symrt.gamut import device_gamut, intersection
from symrt.spectra.bands import wavelengths
from symrt.spectra.library import spectrum

BANDS = wavelengths(400, 700, 50)

SINGLE = (
    *(f"{model}/{black}" for model in ("unit", "envelope") for black in ("clip", "luminance", "strict")),
    *("hull", "inks", "colorimetric/D50", "colorimetric/A", "monitor", "lamp", "srgb"),
)
PARTS = {
    "boxes": ("envelope/strict", "other/envelope"),
    "luminances": ("envelope/luminance", "other/unit"),
    "shown": ("envelope", "monitor"),
    "lights": ("colorimetric/D50", "colorimetric/A"),
    "everything": ("envelope/luminance", "monitor", "colorimetric/D50", "colorimetric/A", "other/envelope/strict"),
    "hulls": ("hull", "other/envelope", "monitor"),
    "two hulls": ("hull", "other/hull"),
    "printed": ("inks", "other/envelope", "monitor"),
}
EVERY = (*SINGLE, *PARTS)


def made(name):
    """A gamut by its name: a model, what is to be said of it, or an intersection of several."""
    if name in PARTS:
        return intersection([made(part) for part in PARTS[name]])
    model, _, rest = name.partition("/")
    if model == "srgb":
        return device_gamut(load_device("srgb"), "monitor")
    device = load_device({"other": "synthetic-cmyk"}.get(model, "dye3-endura-premier"), BANDS)
    if model in {"monitor", "lamp"}:
        shown = device_gamut(load_device("crt-brainard", BANDS), "monitor")
        return shown if model == "monitor" else shown.under(spectrum("illuminant/A", BANDS))
    if model == "other":
        return device_gamut(device, *rest.split("/"))
    if model == "colorimetric":
        return device_gamut(device, model, light=f"illuminant/{rest}")
    return device_gamut(device, model, rest or "clip")
