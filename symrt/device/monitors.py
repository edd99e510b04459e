"""Monitors, known by what their primaries do to the eye: devices for step 4 of the paper.

References
----------
.. [1] G. M. Machado, "A model for simulation of color vision deficiency", UFRGS 2010: Brainard's tube.
.. [2] M. Fairchild and D. Wyble, "Colorimetric characterization of the Apple Studio Display (flat panel LCD)", 1998.
.. [3] IEC 61966-2-1:1999, "Default RGB colour space - sRGB".
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from symrt.device.colorimetry import tristimulus
from symrt.device.printing import Device
from symrt.errors import require_plain
from symrt.spectra.bands import RGB, Bands, wavelengths
from symrt.spectra.library import display_primaries

DISPLAYS = {
    "crt-brainard": ("Typical CRT Brainard 1997", "a typical cathode ray tube, Brainard 1997"),
    "apple-studio-display": ("Apple Studio Display", "a flat liquid crystal panel, Fairchild and Wyble 1998"),
}
EQUAL_ENERGY = "illuminant/E"
SRGB = "srgb"
CHROMATICITIES = np.array([[0.64, 0.30, 0.15], [0.33, 0.60, 0.06], [0.03, 0.10, 0.79]])
"""x, y and z of the primaries of sRGB, a column each [3]_."""
WHITE = np.array([0.3127, 0.3290, 0.3583])
"""x, y and z of its white, D65."""


@dataclass(frozen=True, eq=False)
class Monitor:
    """A monitor, known by what its primaries do to the eye.

    Parameters
    ----------
    name
        Its name for `load_device`.
    bands
        Wavelengths of the spectra that it is asked to show, or RGB.
    primaries
        XYZ of red, green and blue, a column each, with Y = 1 for their sum; for RGB bands the unit matrix.
    title, provenance
        A line that describes it, and the source of its numbers.
    """

    name: str
    bands: Bands
    primaries: Float[np.ndarray, "3 3"]
    title: str
    provenance: str

    def __post_init__(self) -> None:
        for what in ("name", "title", "provenance"):
            require_plain(f"{what} of a device", getattr(self, what))

    def on(self, bands: Bands) -> "Monitor":
        """The same monitor for spectra at other wavelengths; its primaries do not depend on them."""
        if (bands.kind == "rgb") == (self.bands.kind == "rgb"):
            return replace(self, bands=bands)
        if self.name == SRGB:
            return load_monitor(SRGB, bands)
        raise ValueError(f"{self.name} shows spectra, not {bands!r}: choose 'srgb', or a palette in wavelengths")

    def __repr__(self) -> str:
        return f"Monitor({self.name!r}, {self.bands!r}: {self.title})"


def monitors() -> tuple[str, ...]:
    """Names that `load_monitor` knows.

    Examples
    --------
    >>> monitors()
    ('crt-brainard', 'apple-studio-display', 'srgb')
    """
    return (*DISPLAYS, SRGB)


def load_monitor(name: str, bands: Bands | None = None) -> Monitor:
    """A monitor by name.

    Parameters
    ----------
    name
        One of `monitors`.
    bands
        Wavelengths of the spectra that it is asked to show, 380 … 730 nm by 10 nm if not given; of ``srgb`` also RGB,
        which it shows if not told otherwise.

    Examples
    --------
    >>> load_monitor("crt-brainard")
    Monitor('crt-brainard', Bands(36 wavelengths, 380 … 730 nm): a typical cathode ray tube, Brainard 1997)
    """
    if name == SRGB and (bands is None or bands == RGB):
        return Monitor(name, RGB, np.eye(3), "linear sRGB", "IEC 61966-2-1:1999, red, green and blue as they are.")
    if name == SRGB and bands is not None:
        # Each primary's share of the white, which has Y = 1.
        primaries = CHROMATICITIES * np.linalg.solve(CHROMATICITIES, WHITE / WHITE[1])
        title = "a monitor with the primaries of sRGB"
        return Monitor(name, bands, primaries, title, "IEC 61966-2-1:1999: chromaticities of primaries and white.")
    table, title = DISPLAYS[name]
    nm, spectra = display_primaries(table)
    xyz = spectra @ tristimulus(Bands(tuple(nm.tolist())), EQUAL_ENERGY)
    return Monitor(
        name=name,
        bands=wavelengths(380, 730, 10),
        primaries=(xyz / xyz[:, 1].sum()).T,
        title=title,
        provenance=f"Spectra of the primaries: {table!r} of colour-science, 380 … 780 nm by 5 nm.",
    ).on(bands or wavelengths(380, 730, 10))


def printer_of(device: Device | Monitor) -> Device:
    """The device itself, if it prints.

    Examples
    --------
    >>> printer_of(load_monitor("crt-brainard"))
    Traceback (most recent call last):
    ValueError: crt-brainard is a monitor, which has no prints: give a printer or a chart
    """
    if isinstance(device, Monitor):
        raise ValueError(  # noqa: TRY004 -- to a user all of them are devices
            f"{device.name} is a monitor, which has no prints: give a printer or a chart"
        )
    return device
