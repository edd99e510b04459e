"""The gamut of a device by the name of its model, which is the question that is asked: step 4 of the paper."""

from typing import Literal, overload

from symrt.device.monitors import Monitor
from symrt.device.printing import Device
from symrt.errors import shown
from symrt.gamut.colorimetric import ColorimetricGamut, colorimetric_gamut
from symrt.gamut.hull import TOLERANCE, HullGamut, hull_gamut
from symrt.gamut.monitor import MonitorGamut, monitor_gamut
from symrt.gamut.recipes import InkGamut, ink_gamut
from symrt.gamut.slabs import Black, Gamut, slab_gamut
from symrt.spectra.bands import Number

MODELS = ("unit", "envelope", "hull", "inks", "colorimetric", "monitor")

AnyGamut = Gamut | HullGamut | InkGamut | ColorimetricGamut | MonitorGamut


@overload
def device_gamut(
    device: Device | Monitor, model: Literal["unit", "envelope"] = "unit", black: Black | str = "clip"
) -> Gamut: ...
@overload
def device_gamut(
    device: Device | Monitor,
    model: str,
    black: Black | str = "clip",
    *,
    tolerance: Number | None = None,
    light: str = "illuminant/D50",
) -> AnyGamut: ...
def device_gamut(
    device: Device | Monitor,
    model: str = "unit",
    black: Black | str = "clip",
    *,
    tolerance: Number | None = None,
    light: str = "illuminant/D50",
) -> AnyGamut:
    """The gamut of a device.

    Parameters
    ----------
    device
        From `load_device`.
    model
        ``"unit"`` and ``"envelope"``: bounds in each band, see `Gamut`.  ``"hull"``: mixtures of prints, see
        `HullGamut`.  ``"inks"``: the prints of its inks, see `InkGamut`.  ``"colorimetric"``: colours under a viewing
        light, see `ColorimetricGamut`.  ``"monitor"``: the colours that a monitor shows, see `MonitorGamut`.
    black
        The treatment of the dark, for bounds in each band; see `Gamut`.
    tolerance
        Of a hull, or of what inks print: the root mean square difference that passes for none, 0.01 if not given.  Of
        a colorimetric gamut: how far outside the hull of the prints a colour may be, as a share of its luminance, or of
        the lightest print's if that is less.
    light
        Of a colorimetric gamut: the illuminant under which prints are seen.

    Raises
    ------
    ValueError
        If there is no such model, the device has none of the kind, or its black is not to be chosen.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> device_gamut(load_device("dye3-endura-premier"), "colorimetric").label
    'necessary for a colour match under illuminant/D50, as far as the samples are dense'
    """
    # Refuse models that do not exist, or not for this kind of device.
    if model not in MODELS:
        raise ValueError(f"model = {shown(model)}: there are {', '.join(map(repr, MODELS))}")
    if (model == "monitor") != isinstance(device, Monitor):
        what, remedy = ("a printer", "choose another") if model == "monitor" else ("a monitor", "choose 'monitor'")
        raise ValueError(f"model = {model!r}: {device.name} is {what}; {remedy}")

    # Make the gamut of the model named; only bounds in each band leave a choice of black.
    if isinstance(device, Monitor):
        return monitor_gamut(device)
    if model in ("unit", "envelope"):
        return slab_gamut(device, model, black)
    if black != "clip":
        raise ValueError(f"black = {black!r}: model {model!r} has its own black, that of the prints; leave it out")
    if model == "colorimetric":
        return colorimetric_gamut(device, light, 0.0 if tolerance is None else tolerance)
    rms = TOLERANCE if tolerance is None else tolerance
    return hull_gamut(device, rms) if model == "hull" else ink_gamut(device, rms)
