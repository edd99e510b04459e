"""Parameters of models that stay free, or get values, from the words on a command line (step 2)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from symrt.errors import shown

if TYPE_CHECKING:
    from symrt.linear.freeing import Free


def free_of(words: Sequence[str]) -> "Free":
    """The parameters that stay free, from words such as ``brass.exponent=10,160``, or their names alone.

    Examples
    --------
    >>> free_of(["brass.exponent=10,160", "sea.gloss=first-order", "ice.gloss=first-order,1,2"])
    {'brass.exponent': (10.0, 160.0), 'sea.gloss': 'first order', 'ice.gloss': ('first order', 1.0, 2.0)}
    >>> free_of(["brass.exponent"])
    ['brass.exponent']
    """
    if not any("=" in word for word in words):
        return list(words)
    found: dict[str, Any] = {}
    for word in words:
        name, _, how = word.partition("=")
        first, *rest = how.split(",")
        ends = tuple(_figure("--free", word, part) for part in (rest if first == "first-order" else [first, *rest]))
        if not name or len(ends) not in ((0, 2) if first == "first-order" else (2,)):
            raise ValueError(
                f"--free {shown(word)}: write NAME=LOW,HIGH, NAME=first-order or NAME=first-order,LOW,HIGH"
            )
        found[name] = (("first order", *ends) if ends else "first order") if first == "first-order" else ends
    return found


def values_of(words: Sequence[str]) -> dict[str, float]:
    """Values of parameters, from words such as ``brass.exponent=40``.

    Examples
    --------
    >>> values_of(["brass.exponent=40"])
    {'brass.exponent': 40.0}
    """
    found = {}
    for word in words:
        name, sign, value = word.partition("=")
        if not (name and sign):
            raise ValueError(f"{shown(word)}: write NAME=VALUE, such as brass.exponent=40")
        found[name] = _figure("", word, value)
    return found


def _figure(option: str, word: str, number: str) -> float:
    try:
        return float(number)
    except ValueError:
        raise ValueError(f"{option} {shown(word)}: {shown(number)} is no number".strip()) from None
