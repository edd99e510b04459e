"""The image that step 3 of the paper makes: a spectrum, a colour or basis coordinates in every pixel."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, UInt8

from symrt.arrays import Spectrum
from symrt.spectra.bands import Bands
from symrt.spectra.display import display_matrix, to_rgb8


@dataclass(frozen=True, eq=False)
class SpectralImage:
    """An image with a spectrum, a colour or basis coordinates in every pixel.

    Parameters
    ----------
    values
        Radiances, (height, width, band); row 0 is at the top.
    bands
        The last axis: wavelengths, red, green and blue, or coordinates.
    whites
        For each light that shines, the radiance of a perfect diffuser that faces it, the key light's first; before
        them the white that the palette carries, if it does.  Empty for coordinates.
    cut_off
        For each band, a bound on what the depth limit, or an effect left out on request, took from any pixel or added
        to it, and on what products lost that underflowed; infinite where there is no certificate, because a material
        may reflect everything, a reflectance passes 1 or a light's irradiance is unknown; None if nothing was cut off.
    missing
        For each band, an estimate of the most that any pixel misses of light that goes from surface to surface more
        often than it was followed, as it falls off from bounce to bounce; infinite where it does not fall off, None
        where there is nothing to estimate from.
    seconds
        Time that shading took.
    """

    values: Float[np.ndarray, "height width band"]
    bands: Bands
    whites: Mapping[str, Spectrum] = field(default_factory=dict)
    cut_off: Spectrum | None = None
    missing: Spectrum | None = None
    seconds: float = 0.0

    def __repr__(self) -> str:
        height, width, _ = self.values.shape
        return f"SpectralImage({width} × {height} pixels, {self.bands!r}, {self.certificate})"

    @property
    def white(self) -> Spectrum | None:
        """Radiance of the reference white: the one that the palette carries, or else the key light's."""
        return next(iter(self.whites.values()), None)

    @property
    def certificate(self) -> str:
        """The bound on what the depth limit cut off, in words."""
        if self.cut_off is None:
            return "nothing cut off"
        known = self.missing is not None and np.isfinite(self.missing).all()
        about = f", about {self.missing.max():.2g} by estimate" if known and self.missing is not None else ""
        if unbounded := int(np.isinf(self.cut_off).sum()):
            return f"no certificate of the depth limit in {unbounded} bands: what is left has no bound{about}"
        if not self.cut_off.any():
            return "nothing cut off"
        return f"radiance of at most {self.cut_off.max():.2g} cut off{about}"

    def _repr_png_(self) -> bytes | None:
        if self.bands.kind == "coordinate" or self.white is None:
            return None
        from symrt.spectra.png import encode_png  # noqa: PLC0415  # only a notebook needs the encoder

        return encode_png(self._codes(self.white))

    def __array__(self, dtype: np.dtype | type | None = None, *, copy: bool | None = None) -> np.ndarray:
        """The picture in 8-bit sRGB, as a notebook shows it, for whatever takes pictures: ``plt.imshow(image)``.

        The radiances, band by band and not clipped, are `values`.

        Examples
        --------
        >>> from symrt.spectra.bands import RGB
        >>> np.asarray(SpectralImage(np.array([[[1.0, 0.5, 0.0]]]), RGB, whites={"sun": np.ones(3)})).tolist()
        [[[255, 188, 0]]]
        """
        if self.bands.kind == "coordinate" or self.white is None:
            lacks = "no white" if self.bands.kind != "coordinate" else "basis coordinates, which have no colour"
            raise ValueError(f"the image has {lacks}: it is no picture: take image.values")
        if copy is False:
            raise ValueError("the picture is made when it is asked for: leave out copy=False, or take image.values")
        return np.asarray(self._codes(self.white), dtype=dtype)

    def _codes(self, white: Spectrum) -> UInt8[np.ndarray, "height width 3"]:
        return to_rgb8(self.values @ display_matrix(self.bands, white))
