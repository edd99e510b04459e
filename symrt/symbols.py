"""Symbols: the lights and reflectances that stay free until they are given spectra, and how they are written.

    symbol = light | surface "." component        surface = [place ">"] material

``sun`` is a light.  ``sea.diffuse`` is a reflectance: a component of a material.  ``sea>ice.diffuse`` is ice's where
the scene has sea, an *alternative* that counts only in a blend of the two.  ``poster.fluorescence`` is no spectrum but
a matrix, from the wavelengths that arrive to those that leave.  No other module takes such texts apart.
"""

import re
from dataclasses import dataclass
from functools import cached_property, lru_cache

from symrt.errors import shown

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,63}")
"""The names that lights, materials, components and textures may have."""
RESERVED = ("bands", "unphysical")
"""Keys of a palette's table in a file: no light can be called so."""
SURFACE = re.compile(rf"(?:({NAME.pattern})>)?({NAME.pattern})")
OF_MATERIAL = re.compile(rf"{SURFACE.pattern}\.({NAME.pattern})")
"""The names of reflectances and parameters: ``sea.diffuse``, ``sea>ice.diffuse``, ``brass.exponent``."""
REFLECTANCE = rf"{NAME.pattern}(?:>{NAME.pattern})?\.{NAME.pattern}"
"""A reflectance within a longer text."""
WRITTEN = rf"{NAME.pattern}(?:(?:>{NAME.pattern})?\.{NAME.pattern})?"
"""A symbol within a longer text."""
FLUORESCENCE = "fluorescence"
"""The component of a material that gives light back at other wavelengths."""
REMEMBERED = 1 << 14
"""Texts whose parts are remembered: the same few recur for every column of every system."""


@dataclass(frozen=True)
class Surface:
    """A material at its own points, ``sea``, or as an alternative at another's, ``sea>ice``.

    Parameters
    ----------
    material
        The material whose formulas, spectra and parameters it has.
    instead_of
        The material that it might take the place of; empty for one that the scene has.

    Examples
    --------
    >>> ice = Surface.of("sea>ice")
    >>> ice.material, ice.place, ice.alternative, str(ice)
    ('ice', 'sea', True, 'sea>ice')
    """

    material: str
    instead_of: str = ""

    @staticmethod
    @lru_cache(REMEMBERED)
    def of(text: str) -> "Surface":
        """The surface that a text names.

        Raises
        ------
        ValueError
            If it is not a material's name, or two of them.

        Examples
        --------
        >>> Surface.of("sea")
        Surface(material='sea', instead_of='')
        """
        if (found := SURFACE.fullmatch(text)) is None:
            raise ValueError(f"{shown(text)}: give a material's name, or place>material; letters, digits, '_'")
        place, material = found.groups()
        return Surface(material, place or "")

    @cached_property
    def place(self) -> str:
        """The material at whose points it is met."""
        return self.instead_of or self.material

    @cached_property
    def alternative(self) -> bool:
        """True if it might be there, and is not."""
        return bool(self.instead_of)

    def __str__(self) -> str:
        return f"{self.instead_of}>{self.material}" if self.instead_of else self.material


NONE = Surface("")
"""The surface of a light."""


@dataclass(frozen=True)
class Symbol:
    """A free spectrum, by its parts: a light, or a component of a surface's reflectance.

    Parameters
    ----------
    light
        The light's name; empty for a reflectance.
    surface
        The material that reflects, and the place where it does.
    component
        The one of the material's spectra, such as ``diffuse``; empty for a light.

    Examples
    --------
    >>> ice = Symbol.of("sea>ice.diffuse")
    >>> ice.material, ice.component, ice.place, ice.alternative, str(ice)
    ('ice', 'diffuse', 'sea', True, 'sea>ice.diffuse')
    """

    light: str = ""
    surface: Surface = NONE
    component: str = ""

    @staticmethod
    @lru_cache(REMEMBERED)
    def of(text: str) -> "Symbol":
        """The symbol that a text names.

        Raises
        ------
        ValueError
            If it is neither a light's name nor a reflectance's.

        Examples
        --------
        >>> Symbol.of("sun").light, Symbol.of("sun").reflectance, Symbol.of("sea.diffuse").reflectance
        ('sun', False, True)
        >>> Symbol.of("sea.diffuse.x")
        Traceback (most recent call last):
        ValueError: 'sea.diffuse.x': a symbol is a light's name, or material.component; letters, digits, '_'
        """
        if NAME.fullmatch(text):
            return Symbol(light=text)
        if (found := OF_MATERIAL.fullmatch(text)) is None:
            raise ValueError(f"{shown(text)}: a symbol is a light's name, or material.component; letters, digits, '_'")
        place, material, component = found.groups()
        return Symbol("", Surface(material, place or ""), component)

    @cached_property
    def reflectance(self) -> bool:
        """True if it is a reflectance, and no light."""
        return not self.light

    @cached_property
    def material(self) -> str:
        """The material whose spectrum it is, ``ice`` for ``sea>ice.diffuse``; empty for a light."""
        return self.surface.material

    @cached_property
    def place(self) -> str:
        """The material at whose points it is met, ``sea`` for ``sea>ice.diffuse``; empty for a light."""
        return self.surface.place

    @cached_property
    def alternative(self) -> bool:
        """True if it is of a material that might be at its place, and is not."""
        return self.surface.alternative

    @cached_property
    def fluorescent(self) -> bool:
        """True if it moves light from wavelength to wavelength: a matrix, which commutes with no other reflectance."""
        return fluoresces(self.component)

    def __str__(self) -> str:
        return self.light or named(str(self.surface), self.component)


def fluoresces(component: str) -> bool:
    """Whether a component is fluorescent, as its name tells: ``fluorescence``, or one that ends in ``_fluorescence``.

    Examples
    --------
    >>> fluoresces("fluorescence"), fluoresces("ink_fluorescence"), fluoresces("diffuse")
    (True, True, False)
    """
    return component == FLUORESCENCE or component.endswith(f"_{FLUORESCENCE}")


def named(surface: str, part: str) -> str:
    """The name of a component of a surface, or of a parameter of a material; its parts are not checked.

    Examples
    --------
    >>> named("sea", "diffuse"), named("sea>ice", "diffuse"), named("brass", "exponent")
    ('sea.diffuse', 'sea>ice.diffuse', 'brass.exponent')
    """
    return f"{surface}.{part}"


def halves(text: str) -> tuple[str, str]:
    """The parts of a name before and after its first dot, for printing: any name, whether or not it is a symbol's.

    Examples
    --------
    >>> halves("sea.diffuse"), halves("brass.exponent[0]"), halves("sun")
    (('sea', 'diffuse'), ('brass', 'exponent[0]'), ('sun', ''))
    """
    before, _, after = text.partition(".")
    return before, after
