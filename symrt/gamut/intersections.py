"""Intersections of gamuts, of several devices or of one under several lights: step 4 of the paper.

An intersection of convex gamuts is convex, and one of slabs is made of slabs again: their rows are stacked, and bounds
of the same band alone are merged.  Being inside proves of each part what being inside that part proves; the label says
what follows for all of them together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Protocol

import numpy as np
from jaxtyping import Bool

from symrt.arrays import PerPixel, PixelBands, Spectrum
from symrt.device.printing import Device
from symrt.gamut.alternating import THINNEST, deep_inside, nearest_to_all
from symrt.gamut.clipping import Interval
from symrt.gamut.interface import ANY, ConvexGamut, SlabGamut, Slabs, check_spectra
from symrt.gamut.joining import boxed, clipped_by_all, common_intervals, merged, named
from symrt.gamut.polyhedra import supports
from symrt.gamut.recipes import InkGamut
from symrt.spectra.bands import Bands, Number


class _Parts(Protocol):
    """The answers that all kinds of intersections share."""

    parts: tuple[ConvexGamut | InkGamut, ...]

    @property
    def model(self) -> str:
        """The kind of gamut, in a word."""
        return "intersection"

    @property
    def name(self) -> str:
        """The gamut in words."""
        return f"inside all of: {'; '.join(part.name for part in self.parts)}"

    @property
    def label(self) -> str:
        """The claim that being inside proves, of all parts together and of each."""
        necessary = all(part.label.startswith("necessary") for part in self.parts)
        sufficient = all(part.label.startswith(("sufficient", "necessary and sufficient")) for part in self.parts)
        whole = {
            (True, False): "necessary, not sufficient",
            (False, True): "sufficient",
            (True, True): "necessary and sufficient",
            (False, False): "neither necessary nor sufficient",
        }[necessary, sufficient]
        # Parts that prove the same say it once.
        labels = {part.label for part in self.parts}
        same = f"each: {self.parts[0].label}" if len(labels) == 1 else None
        each = same or "; ".join(f"{part.name}: {part.label}" for part in self.parts)
        return f"{whole} for all of them together ({each})"

    @property
    def bands(self) -> Bands:
        """Wavelengths of its spectra."""
        return self.parts[0].bands

    @property
    def devices(self) -> tuple[Device, ...]:
        """The printers of all parts, each once."""
        found = {id(device): device for part in self.parts for device in part.devices}
        return tuple(found.values())

    def contains(self, spectra: PixelBands) -> Bool[np.ndarray, " pixel"]:
        """Whether each spectrum is inside every part; the boundary is."""
        return np.all([part.contains(spectra) for part in self.parts], axis=0)

    def violation(self, spectra: PixelBands) -> PerPixel:
        """The violation of the part that each spectrum violates most, in that part's own measure; 0 inside."""
        return np.max([part.violation(spectra) for part in self.parts], axis=0)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.name}; inside is {self.label})"


@dataclass(frozen=True, eq=False, repr=False)
class Intersection(_Parts):
    """Spectra that lie in several convex gamuts, some of them not made of slabs.

    Parameters
    ----------
    parts
        The gamuts, all on the same bands.

    Examples
    --------
    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> both = intersection([device_gamut(device, "hull"), device_gamut(device, "envelope", "strict")])
    >>> both.contains(np.array([[0.9] * 36, [0.95] * 36]))
    array([ True, False])
    """

    parts: tuple[ConvexGamut, ...]

    @cached_property
    def inner(self) -> tuple[Spectrum, float]:
        """A point deep inside, and how deep it is at most; not above 1e-9 if the intersection counts as empty."""
        return deep_inside(self.parts)

    def under(self, white: Spectrum) -> "Intersection":
        """The same for reflectances against another white."""
        return replace(self, parts=tuple(part.under(white) for part in self.parts))

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum of the gamut that is nearest to each, by root mean square, to within about 1e-9."""
        return _nearest(self, spectra)

    def support(self, directions: PixelBands) -> PerPixel:  # noqa: ARG002 -- what every convex gamut can be asked
        """Refused, by ValueError: a tolerance around mixtures of prints is no set of planes."""
        curved = next(part.name for part in self.parts if not isinstance(part, SlabGamut))
        raise ValueError(
            f"support of an intersection is that of its planes, and {curved} has none: ask the support of each part, "
            "of which the least is a bound"
        )

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t for which ``origin + t direction`` is inside."""
        return clipped_by_all(self.parts, origin, direction)


@dataclass(frozen=True, eq=False, repr=False)
class SlabIntersection(_Parts):
    """Spectra that lie in several gamuts made of slabs: devices, monitors, colours under several lights.

    Parameters
    ----------
    parts
        The gamuts, all on the same bands.

    Examples
    --------
    What a dye printer and a halftone printer may both print:

    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> both = intersection(
    ...     [device_gamut(load_device(n), "envelope") for n in ("dye3-portra-endura", "synthetic-cmyk")]
    ... )
    >>> both.slabs.matrix.shape, both.contains(np.full((2, 36), [[0.5], [0.95]]))
    ((36, 36), array([ True, False]))
    """

    parts: tuple[SlabGamut, ...]

    @cached_property
    def slabs(self) -> Slabs:
        """The slabs of all parts; those that bound the same band alone are one, with the narrower bounds."""
        return merged([named(part) for part in self.parts])

    @cached_property
    def inner(self) -> tuple[Spectrum, float]:
        """A point deep inside, and how deep it is; not above 1e-9 if the intersection counts as empty."""
        return deep_inside(self.parts)

    def under(self, white: Spectrum) -> "SlabIntersection":
        """The same for reflectances against another white."""
        return replace(self, parts=tuple(part.under(white) for part in self.parts))

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """The spectrum of the gamut that is nearest to each, by root mean square."""
        if boxed(self.slabs):
            check_spectra(spectra, self.bands)
            return np.clip(spectra, self.slabs.lower, self.slabs.upper)
        return _nearest(self, spectra)

    def support(self, directions: PixelBands) -> PerPixel:
        """The largest inner product of each direction with a spectrum of the gamut; ``inf`` where there is none."""
        check_spectra(directions, self.bands, ANY)
        slabs = self.slabs
        if boxed(slabs):
            return np.where(directions > 0, directions * slabs.upper, directions * slabs.lower).sum(axis=1)
        return supports(slabs.matrix, slabs.lower, slabs.upper, directions)

    def clip(self, origin: PixelBands, direction: PixelBands) -> Interval:
        """The t for which ``origin + t direction`` is inside."""
        return clipped_by_all(self.parts, origin, direction)


@dataclass(frozen=True, eq=False, repr=False)
class InkIntersection(_Parts):
    """Spectra that lie in several gamuts, one or more of which are what inks print: not convex, and without support.

    Parameters
    ----------
    parts
        The gamuts, all on the same bands.

    Examples
    --------
    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> both = intersection([device_gamut(device, "inks"), device_gamut(load_device("crt-brainard"), "monitor")])
    >>> both.label.partition(" (")[0]
    'sufficient for all of them together'
    """

    parts: tuple[ConvexGamut | InkGamut, ...]

    @cached_property
    def prints(self) -> PixelBands:
        """Prints of the devices that lie in every part."""
        samples = np.vstack([part.device.samples for part in self.parts if isinstance(part, InkGamut)])
        return samples[self.contains(samples)]

    def under(self, white: Spectrum) -> "InkIntersection":
        """The same for reflectances against another white."""
        return replace(self, parts=tuple(part.under(white) for part in self.parts))

    def nearest(self, spectra: PixelBands) -> PixelBands:
        """Each spectrum, or, if it is outside, the nearest of the devices' prints that lie in every part."""
        if not len(self.prints):
            raise ValueError(f"{self.name}: none of the devices' prints is inside, so that none is the nearest")
        outside = np.flatnonzero(~self.contains(spectra))
        far = np.sum(self.prints**2, axis=1) - 2 * (spectra[outside] @ self.prints.T)
        moved = spectra.copy()
        moved[outside] = self.prints[far.argmin(axis=1)]
        return moved

    def clip(
        self, origin: PixelBands, direction: PixelBands, within: tuple[Number, Number] = (0.0, 1.0)
    ) -> list[list[tuple[float, float]]]:
        """For each line ``origin + t direction`` the intervals of t inside, between two values of t.

        What inks print may be missed as `InkGamut.clip` says.
        """
        # Every line begins with the whole range, and keeps what each part allows of it.
        first, last = (np.full(len(origin), float(t)) for t in within)
        lines: list[list[tuple[float, float]]] = [[(a, b)] for a, b in zip(first.tolist(), last.tolist(), strict=True)]
        for part in self.parts:
            if isinstance(part, InkGamut):
                found = part.clip(origin, direction, within)
            else:
                interval = part.clip(origin, direction)
                found = [
                    [(float(a), float(b))] if a <= b else [] for a, b in zip(interval.low, interval.high, strict=True)
                ]
            lines = [common_intervals(one, other) for one, other in zip(lines, found, strict=True)]
        return lines


AnyIntersection = Intersection | SlabIntersection | InkIntersection

UnevenGamut = InkGamut | InkIntersection
"""Gamuts that are not convex: single spectra can be asked, and lines may leave them and return."""


def intersection(
    gamuts: Sequence[ConvexGamut | UnevenGamut],
) -> ConvexGamut | UnevenGamut:
    """The intersection of several gamuts, of several devices or under several viewing lights.

    Parameters
    ----------
    gamuts
        On the same bands; intersections among them count as their parts.

    Raises
    ------
    ValueError
        If there are none, their bands differ, or nothing lies inside all of them.

    Examples
    --------
    Colours that a printer matches by daylight and by lamplight:

    >>> from symrt.gamut.gamuts import device_gamut
    >>> from symrt.device.inks import load_device
    >>> device = load_device("dye3-endura-premier")
    >>> both = intersection([device_gamut(device, "colorimetric", light=f"illuminant/{name}") for name in ("D50", "A")])
    >>> both.label.partition(" (")[0]
    'necessary, not sufficient for all of them together'
    """
    # Take intersections among the gamuts apart.
    parts: list[ConvexGamut | InkGamut] = []
    for gamut in gamuts:
        parts += gamut.parts if isinstance(gamut, AnyIntersection) else [gamut]

    # Refuse parts that have no spectra in common.
    if not parts:
        raise ValueError("no gamuts to intersect: give for example [device_gamut(a), device_gamut(b)]")
    for part in parts[1:]:
        if part.bands != parts[0].bands:
            raise ValueError(
                f"{parts[0].name} is in {parts[0].bands!r}, {part.name} in {part.bands!r}: make both of devices on the "
                "same bands, with load_device(name, bands) or device.on(bands)"
            )
    if len(parts) == 1:
        return parts[0]

    # The kind of intersection follows from the kinds of its parts.
    convex = [part for part in parts if not isinstance(part, InkGamut)]
    if len(convex) < len(parts):
        # Whether inks reach into the rest is not known; whether there is a rest, is.
        if len(convex) > 1:
            _filled(convex)
        return InkIntersection(tuple(parts))
    return _filled(convex)


def _filled(parts: Sequence[ConvexGamut]) -> Intersection | SlabIntersection:
    """The intersection of convex gamuts, if it is not empty."""
    found = _of(parts)
    if _empty(found):
        apart = next((list(pair) for pair in combinations(parts, 2) if _empty(_of(pair))), parts)
        raise ValueError(
            f"nothing is inside all of: {'; '.join(part.name for part in apart)}: leave one of them out, or ask a "
            f"wider model of its device (what holds no ball of radius {THINNEST:g} counts as nothing)"
        )
    return found


def _of(parts: Sequence[ConvexGamut]) -> Intersection | SlabIntersection:
    slabs = [part for part in parts if isinstance(part, SlabGamut)]
    return SlabIntersection(tuple(slabs)) if len(slabs) == len(parts) else Intersection(tuple(parts))


def _empty(found: Intersection | SlabIntersection) -> bool:
    if isinstance(found, SlabIntersection) and boxed(found.slabs):
        return bool(np.any(found.slabs.lower > found.slabs.upper))
    return found.inner[1] <= THINNEST


def _nearest(found: Intersection | SlabIntersection, spectra: PixelBands) -> PixelBands:
    check_spectra(spectra, found.bands)
    if _empty(found):
        raise ValueError(f"{found.name}: nothing is inside under this white, so that nothing is the nearest")
    return nearest_to_all(found.parts, found.inner[0], spectra)
