"""Palettes: a spectrum for every light and reflectance symbol, the input of step 3 of the paper.

A symbol with a dot, ``sea.diffuse``, is a reflectance and lies in [0, 1]; one without, ``sun``, is a light and is not
negative.  ``sea>ice.diffuse`` is ice's reflectance at a point of sea, which a blend of the two materials gives weight.
"""

import difflib
import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float, Int

from symrt.arrays import Spectrum
from symrt.errors import require, shown
from symrt.spectra.bands import Bands, resample
from symrt.spectra.library import spectrum as library_spectrum
from symrt.symbols import RESERVED, Symbol

SpectrumLike = (
    Float[np.ndarray, " _"] | Int[np.ndarray, " _"] | Sequence[float | int | np.number] | float | int | np.number | str
)
"""An array or list with one value a band, a number for all bands, or a name such as ``macbeth/dark skin``."""


@dataclass(frozen=True, eq=False)
class Palette:
    """Spectra by symbol name.

    Parameters
    ----------
    bands
        Wavelengths, or RGB.
    spectra
        For each symbol an array with one value a band, a number for all bands, or a name of the library.
        Afterwards every one of them is a read-only float64 array.
    unphysical
        Permits reflectances above 1; it is carried along by `replace`, `add` and `on`.
    white
        Radiance of the white that the spectra are meant to be seen against, as `Fit` found them: it stays when a light
        is replaced, so that a dimmer lamp makes a dimmer picture.  None: the key light's, whatever it is; with
        ``dataclasses.replace(palette, white=None)`` a palette lets go of its own.

    Examples
    --------
    >>> import symrt.spectra.bands as b
    >>> palette = Palette(b.RGB, {"sun": 1, "red.diffuse": [0.8, 0.1, 0.1]})
    >>> palette.replace(sun=[1, 0.9, 0.5])["sun"]
    array([1. , 0.9, 0.5])
    """

    bands: Bands
    spectra: Mapping[str, SpectrumLike]
    unphysical: bool = False
    white: SpectrumLike | None = None

    def __post_init__(self) -> None:
        # Arguments of the right kinds.
        require("bands", self.bands, Bands, "wavelengths(380, 730, 10) or RGB")
        require("spectra", self.spectra, Mapping, "a spectrum for each symbol, {'sun': 1, 'red.diffuse': 0.5}")
        if self.bands.kind == "coordinate":
            raise ValueError(
                "a palette in coordinates: their products are wrong; give spectra here, and the basis to shade"
            )

        # Every spectrum as an array, and every fault.
        arrays, faults = {}, []
        for name, value in self.spectra.items():
            try:
                arrays[name] = _checked(name, value, self.bands, self.unphysical)
            except ValueError as error:
                faults.append(str(error))

        # The white that it carries.
        if self.white is not None:
            try:
                object.__setattr__(self, "white", _checked("white", self.white, self.bands, unphysical=True))
            except ValueError as error:
                faults.append(f"the palette's white: {error}")
            else:
                if not np.asarray(self.white).any():
                    faults.append("the palette's white is black: give its radiance, or None for the key light's")
        if faults:
            raise ValueError("\n".join(faults))
        object.__setattr__(self, "spectra", MappingProxyType(arrays))

    @property
    def lights(self) -> tuple[str, ...]:
        """Names of the symbols that are lights."""
        return tuple(name for name in self if Symbol.of(name).light)

    @property
    def reflectances(self) -> tuple[str, ...]:
        """Names of the symbols that are reflectances."""
        return tuple(name for name in self if Symbol.of(name).reflectance)

    @property
    def above_one(self) -> tuple[str, ...]:
        """Reflectances that pass 1 in some band, which only an unphysical palette can hold."""
        return tuple(name for name in self.reflectances if self[name].max() > 1)

    def replace(self, spectra: Mapping[str, SpectrumLike] | None = None, /, **lights: SpectrumLike) -> "Palette":
        """A copy with other spectra for some of its symbols.

        Examples
        --------
        >>> from symrt.spectra.bands import RGB
        >>> Palette(RGB, {"sun": 1.0}).replace(son=2.0)
        Traceback (most recent call last):
        ValueError: the palette has no 'son' (did you mean 'sun'?): to bring in a new symbol use add
        """
        changes = {**(spectra or {}), **lights}
        if unknown := [name for name in changes if name not in self]:
            raise ValueError(f"the palette has no {did_you_mean(unknown, self)}: to bring in a new symbol use add")
        return replace(self, spectra={**self.spectra, **changes})

    def add(self, spectra: Mapping[str, SpectrumLike] | None = None, /, **lights: SpectrumLike) -> "Palette":
        """A copy with more symbols, or with other spectra for those that it has."""
        return replace(self, spectra={**self.spectra, **(spectra or {}), **lights})

    def on(self, bands: Bands) -> "Palette":
        """The same spectra at other wavelengths, linearly interpolated, never extrapolated.

        Examples
        --------
        >>> from symrt.spectra.bands import wavelengths
        >>> palette = Palette(wavelengths(400, 600, 100), {"sea.diffuse": [0.1, 0.2, 0.4]})
        >>> palette.on(wavelengths(450, 550, 50))["sea.diffuse"]
        array([0.15, 0.2 , 0.3 ])
        """
        if bands == self.bands:
            return self
        if self.bands.kind != "wavelength":
            raise ValueError(f"a palette in {self.bands!r} has no spectra to resample to {bands!r}: give wavelengths")
        nm = np.array(self.bands.centres)
        spectra = {name: resample(nm, self[name], bands, repr(name)) for name in self}
        white = None if self.white is None else resample(nm, np.asarray(self.white), bands, "the palette's white")
        return replace(self, bands=bands, spectra=spectra, white=white)

    def __getitem__(self, name: str) -> Spectrum:
        if name not in self.spectra:
            raise KeyError(f"the palette has no {did_you_mean([name], self)}")
        return self.spectra[name]  # type: ignore[return-value]  # arrays since __post_init__

    def __contains__(self, name: object) -> bool:
        return name in self.spectra

    def __iter__(self) -> Iterator[str]:
        return iter(self.spectra)

    def __len__(self) -> int:
        return len(self.spectra)

    def _ipython_key_completions_(self) -> list[str]:
        """The symbols, for ``palette["<Tab>``."""
        return list(self)

    def __repr__(self) -> str:
        above = ", unphysical" if self.unphysical else ""
        fixed = "" if self.white is None else ", with its white"
        return f"Palette({self.bands!r}, {', '.join(self)}{above}{fixed})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td><code>{html.escape(name)}</code></td><td>{_curve(self[name])}</td>"
            f"<td>{self[name].min():.3g} … {self[name].max():.3g}</td></tr>"
            for name in self
        )
        return f"<p>{html.escape(repr(self.bands))}</p><table>{rows}</table>"


def did_you_mean(wrong: Iterable[str], right: Iterable[str]) -> str:
    """The wrong names, quoted, each with the right one that is nearest to it."""
    known = list(right)
    near = ((name, difflib.get_close_matches(name, known, n=1)) for name in wrong)
    return ", ".join(f"{name!r} (did you mean {best[0]!r}?)" if best else repr(name) for name, best in near)


def _checked(name: str, value: SpectrumLike, bands: Bands, unphysical: bool) -> Spectrum:
    """A read-only array for one symbol, or the one-line reason why there is none."""
    # A name that a symbol can have.
    reflectance = Symbol.of(name).reflectance
    if name in RESERVED:
        raise ValueError(f"{name!r}: palette files have a key of this name; call the light otherwise")

    # Numbers, one a band.
    given = library_spectrum(value, bands, reflectance=reflectance) if isinstance(value, str) else value
    try:
        array = np.array(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name!r} = {shown(given)}: give numbers, one a band or one for all") from None
    if array.ndim == 0:
        array = np.full(len(bands), array)
    if array.shape != (len(bands),):
        colour = ", or a colour as text, '#c08a3e'" if array.shape == (3,) else ""
        raise ValueError(
            f"{name!r} has {array.size} values for {bands!r}: give one a band, or one number for all{colour}"
        )

    # Numbers that a spectrum can have.
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name!r} is {array[~np.isfinite(array)][0]} at {_where(~np.isfinite(array), bands)}")
    if np.any(array < 0):
        raise ValueError(f"{name!r} is {array.min():g} at {_where(array < 0, bands)}: no spectrum is negative")
    if reflectance and not unphysical and np.any(array > 1):
        at = _where(array > 1, bands)
        remedy = (
            "percent? divide by 100; if it is meant, unphysical=True"
            if array.max() > 2
            else "unphysical=True permits it"
        )
        raise ValueError(f"{name!r} is {array.max():g} (first above 1 at {at}): a reflectance lies in [0, 1]; {remedy}")
    array.flags.writeable = False
    return array


def _where(wrong: Bool[np.ndarray, " band"], bands: Bands) -> str:
    return bands.labels[int(np.flatnonzero(wrong)[0])]


def _curve(spectrum: Spectrum) -> str:
    """A spectrum as a small drawing; its full height is the larger of 1 and its maximum."""
    x = np.linspace(1, 119, spectrum.size)
    y = 29 - 28 * spectrum / max(1.0, float(spectrum.max()))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    line = f'<polyline points="{points}" fill="none" stroke="currentColor"/>'
    return f'<svg width="120" height="30" style="border-bottom:1px solid #8888">{line}</svg>'
