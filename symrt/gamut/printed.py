"""The answers that all gamuts of one printer share: step 4 of the paper."""

from functools import cached_property
from typing import TypeVar

from symrt.arrays import Spectrum
from symrt.device.printing import Device
from symrt.gamut.basis import Basis, uniform_first
from symrt.spectra.bands import Bands

Own = TypeVar("Own", bound="OfPrinter")


class OfPrinter:
    """A gamut of one device, seen as it prints whatever lights the scene."""

    device: Device

    @property
    def bands(self) -> Bands:
        """Wavelengths of its spectra."""
        return self.device.bands

    @property
    def devices(self) -> tuple[Device, ...]:
        """The printer."""
        return (self.device,)

    @cached_property
    def basis(self) -> Basis:
        """The device's basis, constant spectrum first."""
        return uniform_first(self.device.samples)

    def under(self: Own, white: Spectrum) -> Own:  # noqa: ARG002 -- what every gamut can be asked
        """The gamut itself: the reflectances that a device prints do not depend on the light."""
        return self
