"""The words that all commands on a picture share, and those on a picture and a gamut, each listed once."""

import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, wraps
from typing import TYPE_CHECKING, Any, TypeVar

import symrt as rt
from symrt.commands import options as option
from symrt.commands.arguments import Kind, against, bands_of, gamut_of, palette_of, system_of
from symrt.commands.masks import parted

if TYPE_CHECKING:
    from symrt.feedback.parameters import Parameter
    from symrt.gamut.gamuts import AnyGamut
    from symrt.gamut.intersections import AnyIntersection
    from symrt.spectra.palette import Palette
    from symrt.spectra.reference import Reference
    from symrt.system import LinearSystem


@dataclass(frozen=True)
class Picture:
    """A scene or a system with its spectra, its reference white, and the device in question."""

    source: option.Source
    palette: option.PaletteName = None
    palettes: option.PaletteFile = None
    split: option.Split = None
    reference: option.Reference = None
    white_of: option.WhiteOf = None
    exposure: option.Exposure = 1.0
    size: option.Size = None
    device: option.DeviceName = option.DEVICE
    mode: option.Mode = None
    resample: option.Resample = False

    @cached_property
    def given(self) -> "Palette":
        """The palette, on the device's bands if asked for; it needs no rendering."""
        found = palette_of(self.source, self.palettes, self.palette)
        return found.on(bands_of(self.device, self.mode)) if self.resample else found

    @cached_property
    def seen(self) -> "Reference":
        """The reference white and the exposure."""
        if self.reference is not None and self.white_of is not None:
            raise ValueError("--reference and --white-of both choose the white: give one of them")
        return rt.Reference(self.reference, self.exposure)

    @property
    def read(self) -> list[str | None]:
        """Words that may name files that are read, which no output may replace."""
        return [self.source, self.palettes, self.device, *(self.split or ())]

    def rendered(self, asked: "Sequence[Parameter]" = ()) -> "tuple[LinearSystem, Palette]":
        """The system and the palette, with names for the regions that were split off."""
        given, _ = self.given, self.seen
        system = system_of(self.source, self.size, asked)
        if self.white_of is not None:
            given = against(system, given, self.source, self.palettes, self.white_of, self.resample)
        return parted(system, given, self.split)


@dataclass(frozen=True)
class Question(Picture):
    """A picture, and the gamut that it is asked about."""

    model: option.ModelName = None
    black: option.BlackName = None
    light: option.ViewingLight = None
    tolerance: option.Tolerance = None

    @cached_property
    def gamut(self) -> "AnyGamut | AnyIntersection":
        """The gamut, on the palette's bands."""
        kind = Kind(self.model, self.black, self.light, self.tolerance, self.mode)
        return gamut_of(self.device, kind, self.given.bands)


Asked = TypeVar("Asked", bound=Picture)


def asking(kind: type[Asked]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Turn a function of a picture or question, and of further words, into a command with all of their words.

    Examples
    --------
    >>> @asking(Picture)
    ... def look(picture: Picture, closely: bool = False) -> None:
    ...     print(picture.source, picture.exposure, closely)
    >>> look(source="globe", exposure=2.0, closely=True)
    globe 2.0 True
    >>> list(inspect.signature(look).parameters)[:3]
    ['source', 'closely', 'palette']
    """

    def made(function: Callable[..., None]) -> Callable[..., None]:
        # The command's words: the source, then the function's own, then those that all such commands share.
        _, *own = inspect.signature(function, eval_str=True).parameters.values()
        source, *common = inspect.signature(kind, eval_str=True).parameters.values()
        words = [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in (source, *own, *common)]

        @wraps(function)
        def command(**given: Any) -> None:
            function(kind(**{one.name: given.pop(one.name) for one in fields(kind) if one.name in given}), **given)

        command.__signature__ = inspect.Signature(words)  # type: ignore[attr-defined]
        command.__annotations__ = {one.name: one.annotation for one in words} | {"return": None}
        return command

    return made
