"""Pixels as one writes them, ``0.25*sun*sea.diffuse + 0.1*sky*sea.diffuse``, read by hand: nothing is evaluated."""

import re

from symrt import windows
from symrt.errors import shown
from symrt.symbols import REFLECTANCE, WRITTEN

NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
LENGTH = r"(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d+)?"
FACTOR = re.compile(
    rf"(?P<number>{NUMBER})|(?P<window>{windows.WRITTEN})"
    rf"|(?P<through>{REFLECTANCE})\s*\*\*\s*(?P<length>{LENGTH})"
    rf"|(?P<name>{WRITTEN})(?:\s*\*\*\s*(?P<power>[1-9]\d{{0,2}})(?!\d))?"
)
ONE = re.sub(r"\?P<\w+>", "?:", FACTOR.pattern)
TERM = re.compile(rf"(?P<signs>[-+\s]*)(?P<term>(?:{ONE})(?:\s*\*\s*(?:{ONE}))*)\s*")
"""Signs, and factors joined by ``*``: numbers, windows of wavelengths, and names that may have a power below 1000.

A power with a decimal point, of a reflectance's name, is a length of glass.
"""
Factor = str | tuple[str, float]
"""A name or a window, or a transmittance with the length that it is raised to."""


def written_terms(text: str) -> list[tuple[float, tuple[Factor, ...]]]:
    """The terms of a sum: a number, and the names and windows that it multiplies, repeated as often as they occur.

    Raises
    ------
    ValueError
        If it is no sum of products of numbers, windows, names, names to whole powers, and transmittances to any.

    Examples
    --------
    >>> written_terms("0.25*sun*sea.diffuse - 2*sky*sea.mirror**2")
    [(0.25, ('sun', 'sea.diffuse')), (-2.0, ('sky', 'sea.mirror', 'sea.mirror'))]
    >>> written_terms("sun*wine.transmittance**1.5")
    [(1.0, ('sun', ('wine.transmittance', 1.5)))]
    """
    terms: list[tuple[float, tuple[Factor, ...]]] = []
    end = 0
    while end < len(text) or end == 0:
        # The next term, with a sign between two.
        found = TERM.match(text, end)
        if found is None or (end and not found["signs"].strip()):
            rest = text[end:].strip()
            where = f"at {shown(rest)}" if rest else "which is empty"
            raise ValueError(
                f"{shown(text)}, {where}: write a sum of terms such as 0.25*sun*sea.diffuse*chrome.mirror**2"
            )

        # Its number, and the names that it multiplies.
        coefficient = -1.0 if found["signs"].count("-") % 2 else 1.0
        names: list[Factor] = []
        for factor in FACTOR.finditer(found["term"]):
            if factor["number"]:
                coefficient *= float(factor["number"])
            elif factor["window"]:
                names.append(factor["window"])
            elif factor["length"]:
                names.append((factor["through"], _length(text, factor["length"])))
            else:
                names += [factor["name"]] * int(factor["power"] or 1)
        terms.append((coefficient, tuple(names)))
        end = found.end()
    return terms


def _length(text: str, written: str) -> float:
    length = float(written)
    if not 0 < length < float("inf"):
        raise ValueError(f"{shown(text)}: {written} is no length: write a number above 0 that a float can hold")
    return length
