"""Monitors: the colours that three primaries mix, a gamut for step 4 of the paper.

A radiance p, exposed by e, is shown if its drive values ``a = M⁻¹ XYZ(e p)`` lie in [0, 1].  The columns of M are the
XYZ of the primaries with their white at luminance 1.  Nothing is divided by the reference white's spectrum,
only by its luminance: a monitor does not adapt.  The set is a parallelepiped in colour space; being inside is necessary
and sufficient for the same *colour*, and says nothing of the spectrum.
"""

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.device.colorimetry import tristimulus
from symrt.device.monitors import EQUAL_ENERGY, Monitor
from symrt.device.printing import Device
from symrt.gamut.clipping import Interval
from symrt.gamut.interface import ANY, ON_BOUNDARY, WIDER, Slabs, beyond_rounding, check_spectra
from symrt.spectra.bands import Bands
from symrt.spectra.display import luminance_weights

Drive = Float[np.ndarray, "pixel 3"]


@dataclass(frozen=True, eq=False)
class MonitorGamut:
    """The reflectances whose colour a monitor shows, against a white of luminance 1.

    Parameters
    ----------
    monitor
        The monitor.
    drive
        The matrix that takes a reflectance to the drive values of red, green and blue.

    Examples
    --------
    >>> from symrt.device.monitors import load_monitor
    >>> gamut = monitor_gamut(load_monitor("srgb"))
    >>> gamut.contains(np.array([[1.0, 0.5, 0.0], [1.01, 0.5, 0.0]]))
    array([ True, False])
    """

    monitor: Monitor
    drive: Float[np.ndarray, "3 band"]

    model = "monitor"
    label = "necessary and sufficient for the same colour, not for the spectrum"
    """The claim that being inside proves."""

    @property
    def name(self) -> str:
        """The gamut in words."""
        return f"gamut of the monitor {self.monitor.name}"

    @property
    def bands(self) -> Bands:
        """Wavelengths of its spectra."""
        return self.monitor.bands

    @property
    def devices(self) -> tuple[Device, ...]:
        """None: a monitor's black is black."""
        return ()

    def under(self, white: Spectrum) -> "MonitorGamut":
        """The same gamut for reflectances against a white, whose luminance is the monitor's white's."""
        luminance = float(white @ _tristimulus(self.bands)[:, 1])
        if not luminance > 0:
            raise ValueError("the reference white has no luminance: choose another reference")
        return replace(self, drive=_drive(self.monitor) * (white / luminance))

    def driven(self, spectra: PixelBands) -> Drive:
        """Drive values a of red, green and blue."""
        check_spectra(spectra, self.bands)
        return spectra @ self.drive.T

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether the monitor shows the colour of each spectrum; it does on the boundary."""
        return self.violation(spectra) == 0

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The distance of the worst drive value of each spectrum from [0, 1]; 0 inside, and within rounding of it."""
        drive = self.driven(spectra)
        worst = np.maximum(-drive, drive - 1).max(axis=1)
        return beyond_rounding(worst, spectra, self.drive.T)

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum nearest to each, by root mean square, among those whose colour is shown."""
        metric = np.linalg.inv(self.drive @ self.drive.T)
        nearest = spectra.copy()
        for _ in range(2):  # the second time takes out what rounding left of the first, far away
            rows = np.flatnonzero(~self.contains(nearest))
            drive = self.driven(nearest[rows])
            nearest[rows] += (_into_cube(drive, metric) - drive) @ metric @ self.drive
        return nearest

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product with a spectrum whose colour is shown; ``inf`` unless colour alone decides it."""
        check_spectra(directions, self.bands, ANY)
        along = np.linalg.lstsq(self.drive.T, directions.T, rcond=None)[0].T
        missed = np.abs(directions - along @ self.drive).max(axis=1)
        decided = missed <= ON_BOUNDARY * np.abs(directions).max(axis=1)
        return np.where(decided, along.clip(min=0).sum(axis=1), np.inf)

    @property
    def slabs(self) -> Slabs:
        """A slab for the drive value of each primary."""
        bands = np.arange(3) if self.bands.kind == "rgb" else np.full(3, -1)
        words = tuple(f"the monitor's {primary}" for primary in ("red", "green", "blue"))
        no = np.zeros(3, dtype=bool)
        return Slabs(self.drive.T, np.full(3, -WIDER), np.full(3, 1 + WIDER), bands, words, no, no)

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t for which the colour of ``origin + t direction`` is shown."""
        return self.slabs.clip(origin, direction)

    def __repr__(self) -> str:
        return f"MonitorGamut({self.name}; inside is {self.label})"


def monitor_gamut(monitor: Monitor) -> MonitorGamut:
    """The gamut of a monitor for reflectances against an equal-energy white; `MonitorGamut.under` gives another white.

    Examples
    --------
    A white diffuser, lit by equal energy, needs more red than the tube's bluish white has:

    >>> from symrt.device.monitors import load_monitor
    >>> gamut = monitor_gamut(load_monitor("crt-brainard"))
    >>> gamut.driven(np.ones((1, 36))).round(2)
    array([[1.42, 0.9 , 0.76]])
    """
    return MonitorGamut(monitor, _drive(monitor)).under(np.ones(len(monitor.bands)))


def _tristimulus(bands: Bands) -> Float[np.ndarray, "band 3"]:
    """XYZ of a radiance, with Y = 1 for a constant 1; of RGB the luminance alone matters."""
    if bands.kind == "rgb":
        return np.repeat(luminance_weights(bands)[:, None], 3, axis=1)
    return tristimulus(bands, EQUAL_ENERGY)


def _drive(monitor: Monitor) -> Float[np.ndarray, "3 band"]:
    """Drive values of a radiance."""
    if monitor.bands.kind == "rgb":
        return np.eye(3)
    if len(monitor.bands) < 3:
        raise ValueError(f"{monitor.bands!r} span no three colours: give three wavelengths or more")
    return np.linalg.solve(monitor.primaries, tristimulus(monitor.bands, EQUAL_ENERGY).T)


def _into_cube(points: Drive, metric: Float[np.ndarray, "3 3"]) -> Drive:
    """The point of the cube [0, 1]³ nearest to each in a metric: the best of those on its faces, edges and corners."""
    best, least = np.clip(points, 0, 1), np.full(len(points), np.inf)
    # Every face, edge and corner holds some coordinates at 0 or 1, and leaves the others free.
    for fixed in product((None, 0.0, 1.0), repeat=3):
        held = [i for i in range(3) if fixed[i] is not None]
        free = [i for i in range(3) if fixed[i] is None]
        moved = points.copy()
        moved[:, held] = [fixed[i] for i in held]
        # The free coordinates go to where the rest of the distance is least.
        if held and free:
            shift = (points - moved)[:, held] @ metric[np.ix_(held, free)] @ np.linalg.inv(metric[np.ix_(free, free)])
            moved[:, free] += shift

        # Keep the nearest point that lies in the cube.
        change = moved - points
        distance = np.einsum("pi,ij,pj->p", change, metric, change)
        better = (distance < least) & np.all((moved >= 0) & (moved <= 1), axis=1)
        best[better], least[better] = moved[better], distance[better]
    return best
