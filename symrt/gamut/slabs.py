"""Gamuts made of slabs, pairs of parallel planes: step 4 of the paper, equation (1).

A reflectance is inside when ``lower <= r(λ) <= upper`` in every band; with ``black="luminance"`` one more slab bounds
its luminance from below.  The set is convex.  Being inside is *necessary* for a print and not sufficient: three dyes
reach a thin, curved part of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from symrt.arrays import Spectrum
from symrt.device.printing import Device
from symrt.gamut.clipping import Interval, clip_slabs
from symrt.gamut.interface import ANY, ON_BOUNDARY, WIDER, Slabs, check_spectra
from symrt.gamut.printed import OfPrinter
from symrt.gamut.views import Shadow, Slice
from symrt.spectra.display import luminance_weights

Model = Literal["unit", "envelope"]
Black = Literal["clip", "luminance", "strict"]
Spectra = Float[np.ndarray, "pixel band"]
BISECTIONS = 80


@dataclass(frozen=True, eq=False)
class Gamut(OfPrinter):
    """The reflectances that a device may be able to print.

    Parameters
    ----------
    model
        ``"unit"``: from 0 to 1 in every band; ``"envelope"``: the range of the device's prints in every band.
    black
        The treatment of the dark.  ``"clip"``: it prints as the device's black, the lower bound is 0.  ``"luminance"``:
        the luminance is at least that of the device's black.  ``"strict"``: no band below its lowest in any print.
    device
        The printer.
    lower, upper
        Bounds of the reflectance in each band.
    weights
        Of each band in the luminance, for ``black="luminance"``; they sum to 1.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> gamut = slab_gamut(load_device("dye3-endura-premier"), "envelope")
    >>> gamut.contains(np.full((2, 36), [[0.5], [0.95]]))
    array([ True, False])
    """

    model: Model
    black: Black
    device: Device
    lower: Spectrum
    upper: Spectrum
    weights: Spectrum | None = None

    @property
    def label(self) -> str:
        """The claim that being inside proves: of the unit gamut none about this printer."""
        return {"unit": "necessary for a print of any printer", "envelope": "necessary for a print"}[self.model]

    @property
    def name(self) -> str:
        """The gamut in words."""
        kept = {"clip": "black clipped", "luminance": "black's luminance kept", "strict": "black kept in every band"}
        what = {"unit": "unit gamut (0 … 1)", "envelope": f"envelope of {self.device.name}"}[self.model]
        return f"{what}, {kept[self.black]}"

    @property
    def slabs(self) -> Slabs:
        """A slab for each band, and one for the luminance if that of black is kept."""
        count = len(self.bands)
        matrix, lower, upper = np.eye(count), self.lower, self.upper
        words, extrapolated = tuple(self.bands.labels), self.device.extrapolated
        if self.weights is not None:
            matrix = np.column_stack([matrix, self.weights])
            lower, upper = np.append(lower, self.blackest), np.append(upper, np.inf)
            words, extrapolated = (*words, "luminance"), np.append(extrapolated, False)
        bands = np.where(np.arange(len(words)) < count, np.arange(len(words)), -1)
        return Slabs(matrix, lower, upper, bands, words, np.full(len(words), self.black != "clip"), extrapolated)

    @property
    def blackest(self) -> float:
        """The lowest luminance that the device prints, of a white's 1."""
        return 0.0 if self.weights is None else float((self.device.samples @ self.weights).min())

    def under(self, white: Spectrum) -> "Gamut":
        """The same gamut seen under a light, on which the luminance of a reflectance depends."""
        if self.weights is None:
            return self
        weights = luminance_weights(self.bands) * white
        if not weights.sum() > 0:
            raise ValueError("the reference white has no luminance: choose another reference")
        return replace(self, weights=weights / weights.sum())

    def contains(self, spectra: Spectra) -> Bool[np.ndarray, " pixel"]:
        """Whether each spectrum is inside; the boundary is."""
        check_spectra(spectra, self.bands)
        inside = np.all((self.lower <= spectra) & (spectra <= self.upper), axis=1)
        return inside if self.weights is None else inside & (self._darker(spectra) == 0)

    def violation(self, spectra: Spectra) -> Float[np.ndarray, " pixel"]:
        """The distance of each spectrum from its worst bound, in a band or in luminance; 0 inside."""
        check_spectra(spectra, self.bands)
        worst = np.maximum(self.lower - spectra, spectra - self.upper).max(axis=1).clip(min=0.0)
        return worst if self.weights is None else np.maximum(worst, self._darker(spectra))

    def clip(self, origin: Spectra, direction: Spectra) -> Interval:
        """The t for which ``origin + t direction`` is inside, certified."""
        if self.weights is not None:
            # Within what counts as on the boundary: a line through black itself is inside.
            return replace(self.slabs, lower=np.append(self.lower, self.blackest - WIDER)).clip(origin, direction)
        return clip_slabs(self.lower, self.upper, origin, direction)

    def support(self, directions: Spectra) -> Float[np.ndarray, " pixel"]:
        """The largest inner product of each direction with a spectrum of the gamut.

        With a bound on luminance it is the least of ``h(d + μ y) − μ Y_black`` over μ >= 0, h the support of the box;
        that is convex and bends only where a component of ``d + μ y`` changes sign.
        """
        check_spectra(directions, self.bands, ANY)
        if self.weights is None:
            return self._box_support(directions)
        with np.errstate(divide="ignore", invalid="ignore"):
            bends = np.nan_to_num(np.maximum(-directions / self.weights, 0), nan=0.0, posinf=0.0)
        values = [
            self._box_support(directions + mu[:, None] * self.weights) - mu * self.blackest
            for mu in (*bends.T, np.zeros(len(directions)))
        ]
        return np.min(values, axis=0)

    def nearest(self, spectra: Spectra) -> Spectra:
        """The spectrum of the gamut that is nearest to each, by root mean square."""
        check_spectra(spectra, self.bands)
        boxed = np.clip(spectra, self.lower, self.upper)
        if self.weights is None:
            return boxed
        dark = self._darker(boxed) > 0
        boxed[dark] = self._lifted(spectra[dark], self.weights)
        return boxed

    def slice(self, k: int | np.integer | Sequence[int]) -> Slice:
        """The cut through the gamut: the first k coordinates, or those named, of spectra inside whose others are 0."""
        return Slice(self._components(k), self.lower, self.upper)

    def shadow(self, k: int | np.integer | Sequence[int]) -> Shadow:
        """The projection of the gamut: these coordinates of all its spectra, luminance's bound left out."""
        return Shadow(self._components(k), self.lower, self.upper)

    def _components(self, k: int | np.integer | Sequence[int]) -> Float[np.ndarray, "component band"]:
        chosen = list(k) if isinstance(k, Sequence) else list(range(k))
        last = len(self.bands) - 1
        if not chosen or len(set(chosen)) < len(chosen) or not all(0 <= i <= last for i in chosen):
            raise ValueError(f"components {k}: name different ones, from 0 to {last}")
        return self.basis.vectors[chosen]

    def _darker(self, spectra: Spectra) -> Float[np.ndarray, " pixel"]:
        """The luminance by which each spectrum is darker than black; 0 if it is not, and within rounding of black."""
        darker = self.blackest - spectra @ self.weights
        return np.where(darker <= ON_BOUNDARY, 0.0, darker)

    def _box_support(self, directions: Spectra) -> Float[np.ndarray, " pixel"]:
        return np.where(directions > 0, directions * self.upper, directions * self.lower).sum(axis=1)

    def _lifted(self, spectra: Spectra, weights: Spectrum) -> Spectra:
        """Spectra clipped to the box after just as much of `weights` is added as black's luminance needs."""
        # Adding `high` times the weights would bring every band to its upper bound.
        low, high = np.zeros(len(spectra)), np.full(len(spectra), 1.0)
        reach = (self.upper - spectra).max(axis=1, initial=0.0) / weights[weights > 0].min()
        high = np.maximum(high, reach)

        # Bisect for the least amount that makes them as light as black.
        for _ in range(BISECTIONS):
            middle = (low + high) / 2
            enough = np.clip(spectra + middle[:, None] * weights, self.lower, self.upper) @ weights >= self.blackest
            low, high = np.where(enough, low, middle), np.where(enough, middle, high)
        return np.clip(spectra + high[:, None] * weights, self.lower, self.upper)

    def __repr__(self) -> str:
        modelled = " (modelled)" if self.device.modelled else ""
        return f"Gamut({self.name}{modelled}; inside is {self.label}, not sufficient)"


def slab_gamut(device: Device, model: Model | str = "unit", black: Black | str = "clip") -> Gamut:
    """The gamut of a device.

    Parameters
    ----------
    device
        From `load_device`.
    model, black
        See `Gamut`.

    Raises
    ------
    ValueError
        If there is no such model, or no such way with black.

    Examples
    --------
    >>> from symrt.device.inks import load_device
    >>> slab_gamut(load_device("dye3-endura-premier"), "envelope", black="strict")
    Gamut(envelope of dye3-endura-premier, black kept in every band (modelled); inside is necessary for a
    print, not sufficient)
    """
    if model not in ("unit", "envelope"):
        raise ValueError(f"model = {model!r}: there are 'unit' and 'envelope'")
    if black not in ("clip", "luminance", "strict"):
        raise ValueError(f"black = {black!r}: there are 'clip', 'luminance' and 'strict'")

    # The bounds follow from the model above, and from the treatment of black below.
    bands = len(device.bands)
    return Gamut(
        model=model,
        black=black,
        device=device,
        lower=device.black if black == "strict" else np.zeros(bands),
        upper=device.white if model == "envelope" else np.ones(bands),
        weights=luminance_weights(device.bands) if black == "luminance" else None,
    )
