"""Looking and playing: plots, tables, the demo, the explorer, and the files they are written to."""

from importlib import import_module
from typing import Any

__all__ = ["plots"]


def __getattr__(name: str) -> Any:
    # Matplotlib is slow to import, and most of this room does without.
    if name == "plots":
        return import_module("symrt.show.plots")
    raise AttributeError(f"symrt.show has no {name!r}; it has {', '.join(__all__)}")
