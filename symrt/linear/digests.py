"""Digests of records: two have the same only if they hold the same, bit for bit (steps 1 and 2)."""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import sympy


def digest_of(*things: object) -> str:
    """SHA-256 over everything that some records hold.

    Examples
    --------
    >>> digest_of("a scene") == digest_of("a scene"), digest_of(1.0) == digest_of(1.5)
    (True, False)
    """
    found = hashlib.sha256()
    for part in described(things):
        found.update(part)
    return found.hexdigest()


def described(thing: object) -> Iterator[bytes]:
    """Everything that a record holds, as bytes: two records give the same only if they are the same, bit for bit.

    Examples
    --------
    >>> list(described((1.5, "sun")))
    [b'tuple[', b'0x1.8000000000000p+0;', b"'sun';", b']']
    """
    # Leaves: formulas, arrays and numbers to the last bit; whatever else is a record of such.
    if isinstance(thing, sympy.Basic):
        yield f"{sympy.srepr(thing)};".encode()
    elif isinstance(thing, np.ndarray):
        yield f"{thing.dtype}{thing.shape};".encode() + np.ascontiguousarray(thing).tobytes()
    elif isinstance(thing, float | np.floating):
        yield f"{float(thing).hex()};".encode()
    elif isinstance(thing, np.integer):
        yield from described(int(thing))
    elif thing is None or isinstance(thing, str | bool | int | Path):
        yield f"{str(thing) if isinstance(thing, Path) else thing!r};".encode()
    else:
        yield f"{type(thing).__name__}[".encode()
        for part in _parts(thing):
            yield from described(part)
        yield b"]"


def _parts(thing: object) -> list[object]:
    if isinstance(thing, Mapping):
        return [part for key in sorted(thing) for part in (key, thing[key])]
    if isinstance(thing, tuple | list):
        return list(thing)
    if isinstance(thing, frozenset | set):
        return sorted(thing)
    if is_dataclass(thing):
        return [getattr(thing, field.name) for field in fields(thing)]
    raise ValueError(f"{thing!r} cannot be recognised when a render is resumed; make it a dataclass")
