"""Palettes: a spectrum for every light and reflectance symbol, the input of step 3 of the paper.

A symbol with a dot, ``sea.diffuse``, is a reflectance and lies in [0, 1]; one without, ``sun``, is a light and is not
negative.  ``sea>ice.diffuse`` is ice's reflectance at a point of sea, which a blend of the two materials gives weight.
``paint.fluorescence`` is a matrix, made of the spectra of its dyes.
"""

import difflib
import html
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool

from symrt.arrays import Spectrum
from symrt.errors import require, shown
from symrt.spectra.bands import Bands, resample
from symrt.spectra.fluorescence import WHOLE, Donaldson, FluorescenceLike, Matrix, SpectrumLike, sent_on
from symrt.spectra.library import spectrum as library_spectrum
from symrt.symbols import RESERVED, Symbol, fluoresces

Given = SpectrumLike | FluorescenceLike | Donaldson
"""What a palette takes for a symbol: a spectrum, or for a fluorescent one its dyes or its matrix."""
TOGETHER = frozenset({"diffuse", "specular", "mirror"})
"""Components of a material that share the light among them."""


@dataclass(frozen=True, eq=False)
class Palette:
    """Spectra by symbol name.

    Parameters
    ----------
    bands
        Wavelengths, or RGB.
    spectra
        For each symbol an array with one value a band, a number for all bands, or a name of the library; for a
        fluorescent one a `Fluorescence`, several, or a matrix from the bands that light arrives in to those it leaves
        in.  Afterwards every one of them is a read-only float64 array, and a fluorescent one a `Donaldson`, whose
        matrix ``palette[name]`` is.
    unphysical
        Permits reflectances above 1, and paints that give back more light than they get, or light of more energy; it is
        carried along by `replace`, `add` and `on`.
    white
        Radiance of the white that the spectra are meant to be seen against, as `Fit` found them: it stays when a light
        is replaced, so that a dimmer lamp makes a dimmer picture.  None: the key light's, whatever it is; with
        ``dataclasses.replace(palette, white=None)`` a palette lets go of its own.
    fluorescent
        Names of the symbols that are matrices.

    Examples
    --------
    >>> import symrt.spectra.bands as b
    >>> palette = Palette(b.RGB, {"sun": 1, "red.diffuse": [0.8, 0.1, 0.1]})
    >>> palette.replace(sun=[1, 0.9, 0.5])["sun"]
    array([1. , 0.9, 0.5])
    """

    bands: Bands
    spectra: Mapping[str, Given]
    unphysical: bool = False
    white: SpectrumLike | None = None
    fluorescent: tuple[str, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        # Arguments of the right kinds.
        require("bands", self.bands, Bands, "wavelengths(380, 730, 10) or RGB")
        require("spectra", self.spectra, Mapping, "a spectrum for each symbol, {'sun': 1, 'red.diffuse': 0.5}")
        if self.bands.kind == "coordinate":
            raise ValueError(
                "a palette in coordinates: their products are wrong; give spectra here, and the basis to shade"
            )

        # Every spectrum as an array, and every fault.
        arrays: dict[str, Spectrum | Donaldson] = {}
        faults = []
        for name, value in self.spectra.items():
            try:
                symbol = Symbol.of(name)
                check = _matrix if symbol.fluorescent else _checked
                arrays[name] = check(name, value, self.bands, self.unphysical)
            except ValueError as error:
                faults.append(str(error))
        matrices = {name: one for name, one in arrays.items() if isinstance(one, Donaldson)}
        object.__setattr__(self, "fluorescent", tuple(matrices))
        if matrices and not self.unphysical:
            faults += overdrawn({n: one.matrix if n in matrices else one for n, one in arrays.items()}, self.bands)  # type: ignore[union-attr,misc]  # as told apart above

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
        most = {name: sent_on(self[name], self.bands).max() for name in self.reflectances}
        return tuple(name for name, share in most.items() if share > (WHOLE if name in self.fluorescent else 1))

    def replace(self, spectra: Mapping[str, Given] | None = None, /, **lights: SpectrumLike) -> "Palette":
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

    def add(self, spectra: Mapping[str, Given] | None = None, /, **lights: SpectrumLike) -> "Palette":
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
        spectra = {
            n: one.on(bands, repr(n)) if isinstance(one, Donaldson) else resample(nm, self[n], bands, repr(n))
            for n, one in self.spectra.items()
        }
        white = None if self.white is None else resample(nm, np.asarray(self.white), bands, "the palette's white")
        return replace(self, bands=bands, spectra=spectra, white=white)

    def __getitem__(self, name: str) -> Spectrum | Matrix:
        if name not in self.spectra:
            raise KeyError(f"the palette has no {did_you_mean([name], self)}")
        held = self.held(name)
        return held.matrix if isinstance(held, Donaldson) else held

    def held(self, name: str) -> "Spectrum | Donaldson":
        """The spectrum of a symbol, or its fluorescence with its dyes."""
        return self.spectra[name]  # type: ignore[return-value]  # so since __post_init__

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
            f"<tr><td><code>{html.escape(name)}</code></td><td>{_drawn(held)}</td><td>{_said(held)}</td></tr>"
            for name, held in ((name, self.held(name)) for name in self)
        )
        return f"<p>{html.escape(repr(self.bands))}</p><table>{rows}</table>"


def did_you_mean(wrong: Iterable[str], right: Iterable[str]) -> str:
    """The wrong names, quoted, each with the right one that is nearest to it."""
    known = list(right)
    near = ((name, difflib.get_close_matches(name, known, n=1)) for name in wrong)
    return ", ".join(f"{name!r} (did you mean {best[0]!r}?)" if best else repr(name) for name, best in near)


def together(symbol: Symbol) -> bool:
    """Whether a component shares the light of its surface with others: the usual ones do, and fluorescent ones.

    Examples
    --------
    >>> together(Symbol.of("paint.diffuse")), together(Symbol.of("paint.fluorescence")), together(Symbol.of("gold.f0"))
    (True, True, False)
    """
    return symbol.component in TOGETHER or symbol.fluorescent


def overdrawn(factors: Mapping[str, Spectrum | Matrix], bands: Bands) -> Iterator[str]:
    """Sentences about fluorescent materials whose components together send on more light than arrives."""
    parts = defaultdict(list)
    for name, factor in factors.items():
        symbol = Symbol.of(name)
        if together(symbol):
            parts[symbol.surface].append((symbol.component, sent_on(factor, bands)))
    for surface, shares in parts.items():
        total = np.sum([share for _, share in shares], axis=0)
        band = int(total.argmax())
        if len(shares) > 1 and total[band] > WHOLE and any(fluoresces(component) for component, _ in shares):
            added = " + ".join(f"{component} {share[band]:.4g}" for component, share in shares)
            yield (
                f"'{surface}': {added} send on {total[band]:.4g} of the light at {bands.labels[band]}, more than "
                "arrives: lower one of them; unphysical=True permits it"
            )


def _matrix(name: str, value: Given, bands: Bands, unphysical: bool) -> Donaldson:
    """A fluorescent reflectance for one symbol, or the one-line reason why there is none."""
    if isinstance(value, Donaldson) and value.bands == bands:
        found = value
    else:
        try:
            found = Donaldson.of(value, bands)  # type: ignore[arg-type]  # it refuses what it cannot take
        except ValueError as error:
            raise ValueError(f"{name!r}: {error}") from None
    if not unphysical and (fault := next(found.faults(), None)):
        raise ValueError(f"{name!r} {fault}")
    return found


def _checked(name: str, value: Given, bands: Bands, unphysical: bool) -> Spectrum:
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


def _drawn(held: Spectrum | Donaldson) -> str:
    """A spectrum as a curve, a matrix as a picture: upwards the band that light arrives in, to the right the other."""
    if not isinstance(held, Donaldson):
        return _curve(held)
    size, most = len(held.bands), float(held.matrix.max()) or 1.0
    cells = "".join(
        f'<rect x="{j}" y="{size - 1 - i}" width="1" height="1" fill-opacity="{held.matrix[i, j] / most:.2f}"/>'
        for i, j in np.argwhere(held.matrix > most / 200).tolist()
    )
    style = 'width="120" height="60" preserveAspectRatio="none" style="border:1px solid #8888"'
    return f'<svg viewBox="0 0 {size} {size}" {style} fill="currentColor">{cells}</svg>'


def _said(held: Spectrum | Donaldson) -> str:
    """The range of a spectrum, or the wavelengths between which light moves."""
    if not isinstance(held, Donaldson):
        return f"{held.min():.3g} … {held.max():.3g}"
    from_, to = (held.bands.labels[int(held.matrix.max(axis=k).argmax())] for k in (1, 0))
    return f"mostly from {from_} to {to}, up to {sent_on(held.matrix, held.bands).max():.3g} of the light"


def _curve(spectrum: Spectrum) -> str:
    """A spectrum as a small drawing; its full height is the larger of 1 and its maximum."""
    x = np.linspace(1, 119, spectrum.size)
    y = 29 - 28 * spectrum / max(1.0, float(spectrum.max()))
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    line = f'<polyline points="{points}" fill="none" stroke="currentColor"/>'
    return f'<svg width="120" height="30" style="border-bottom:1px solid #8888">{line}</svg>'
