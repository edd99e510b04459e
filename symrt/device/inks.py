"""Printing devices by name, or from the file of a measured chart: step 4 of the paper begins with one of them."""

from pathlib import Path

from symrt.device.charts import load_chart
from symrt.device.dyes import dye_device, dye_devices
from symrt.device.halftone import synthetic_device, synthetic_devices
from symrt.device.monitors import Monitor, load_monitor, monitors
from symrt.device.printing import Device
from symrt.errors import shown
from symrt.spectra.bands import Bands
from symrt.spectra.palette import did_you_mean


def devices() -> tuple[str, ...]:
    """Names that `load_device` knows.

    Examples
    --------
    >>> {"dye3-endura-premier", "synthetic-cmyk"} <= set(devices())
    True
    """
    return (*dye_devices(), *synthetic_devices(), *monitors())


def load_device(name: str | Path, bands: Bands | None = None, *, mode: str | None = None) -> Device | Monitor:
    """A printer or a monitor by name, or the printer of a measured chart.

    Parameters
    ----------
    name
        One of `devices`; or the path of a chart: CGATS.17 text, Argyll's ``.ti3``, CxF3 (``.cxf``, ``.mxf``), ``.csv``
        or ``.npz``.
    bands
        Wavelengths that its spectra cover; those of its own table or chart if not given.
    mode
        Of a chart in CxF3 with prints measured under several conditions, ``"M0"`` to ``"M3"``: the one that is meant.

    Raises
    ------
    ValueError
        If there is no such device, the file is not a chart with spectra, or they do not cover the bands.

    Examples
    --------
    >>> device = load_device("dye3-endura-premier")
    >>> device
    Device('dye3-endura-premier', modelled, 729 prints in Bands(36 wavelengths, 380 … 730 nm): dye-sublimation-like,
    modelled from the dyes of Kodak Professional Endura Premier paper)
    >>> device.bands.labels[2], device.extrapolated[:3]
    ('400 nm', array([ True,  True, False]))
    """
    # A device that comes with symrt.
    if mode is not None and name in devices():
        raise ValueError(f"mode = {shown(mode)}: {name} is no chart in CxF3, measured under M0 to M3; leave it out")
    if name in dye_devices():
        return dye_device(str(name), bands)
    if name in synthetic_devices():
        return synthetic_device(str(name), bands)
    if name in monitors():
        return load_monitor(str(name), bands)

    # A measured chart.
    if isinstance(name, Path) or Path(name).suffix or len(Path(name).parts) > 1:
        chart = load_chart(name, mode)
        return chart.on(bands) if bands else chart

    # Neither.
    near = did_you_mean([str(name)[:64]], devices())
    raise ValueError(
        f"no device {near if len(str(name)) <= 64 else shown(name)}; there are: {', '.join(devices())}; or give the "
        "path of a chart, such as 'chart.ti3'"
    )
