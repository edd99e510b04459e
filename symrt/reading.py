"""Reading what others wrote: TOML files, and the paths they name, trusted with nothing.

Two readers share a scene file, one on each side of the waist; both begin here.
"""

import math
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any

from symrt.disk import ordinary
from symrt.errors import SceneError, shown, suggestion
from symrt.symbols import NAME

LARGEST = 16 << 20
"""Bytes that a scene file may have; geometry and pictures have files of their own."""

DEEPEST = 8
"""Tables within tables that a scene file may have."""

PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_.-]){PART}(?:[ \t]*+\.[ \t]*+{PART}){{32}}")
"""A key such as a.b.c.… of dozens of parts: Python's TOML reader needs memory in the square of their number."""


def shipped_scenes() -> dict[str, Path]:
    """The files of the scenes that come with symrt, by name.

    Examples
    --------
    >>> "globe" in shipped_scenes()
    True
    """
    here = Path(__file__).resolve().parent
    # A wheel carries the scenes inside the package; a checkout has them beside it.
    folder = next((place for place in (here / "scenes", here.parent / "scenes") if place.is_dir()), here)
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def shipped_scene(name: str) -> Path:
    """The file of a scene that comes with symrt.

    Examples
    --------
    >>> shipped_scene("first").name
    'first.toml'
    """
    shipped = shipped_scenes()
    if name not in shipped:
        raise SceneError(f"{shown(name)}: no scene of this name comes with symrt; {suggestion(name, shipped)}")
    return shipped[name]


def scene_path(path: str | Path) -> Path:
    """The path itself, or the file of a shipped scene if it is a bare name such as ``globe`` and no such file exists.

    Examples
    --------
    >>> scene_path("first").name, scene_path("mine/first.toml").name
    ('first.toml', 'first.toml')
    """
    if isinstance(path, str) and NAME.fullmatch(path) and not Path(path).is_file():
        return shipped_scene(path)
    return Path(path)


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML file.

    Raises
    ------
    SceneError
        If there is no such file, it is too large, or it is not TOML; with the line, where there is one.
    """
    # Read the text, if it is of a size that a scene may have.
    try:
        size = ordinary(path).stat().st_size
        if path.is_file() and size > LARGEST:
            rule = f"a scene file has at most {LARGEST >> 20} MiB; put geometry and pictures in files of their own"
            raise SceneError(f"{path}: {size} bytes: {rule}")
        text = path.read_bytes().decode("utf-8")
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; give the path of a scene, such as scenes/first.toml") from None
    except UnicodeDecodeError as error:
        raise SceneError(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8 text") from None
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error.strerror}; give the path of a scene file") from None
    except ValueError as error:
        raise SceneError(f"{path}: {error}") from None

    # Parse it, unless the parser would need too much memory for it.
    if chain := LONG_KEY.search(text):
        line = text.count("\n", 0, chain.start()) + 1
        raise SceneError(f"{path}: line {line}: nested too deeply; a scene has at most {DEEPEST} levels")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError(f"{path}: not TOML: {str(error).splitlines()[0]}; correct that line") from None
    except RecursionError:
        raise SceneError(f"{path}: nested too deeply; a scene has at most {DEEPEST} levels") from None
    except ValueError:  # Python refuses to read integers of more than 4,300 digits
        line = _line_of_long_number(text)
        raise SceneError(f"{path}: line {line}: a number with thousands of digits; write it as 1.5e3") from None


def number_faults(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Key and fault of each value that no scene can use: not finite, too large, a date, nested too deeply.

    Examples
    --------
    >>> list(number_faults({"camera": {"width": float("inf")}}))
    [('camera.width', '= inf: numbers must be finite and within ±1.8e308; write an ordinary one, such as 1.5')]
    """
    waiting: list[tuple[str, Any, int]] = [("", data, 0)]
    while waiting:
        key, value, level = waiting.pop()

        # A table or a list is looked into, down to a depth.
        if isinstance(value, dict | list):
            if level > DEEPEST:
                yield key[:60], f": nested too deeply; a scene has at most {DEEPEST} levels"
                continue
            waiting.extend((_key(key, part), inner, level + 1) for part, inner in reversed(_items(value)))

        # A value must be a number that can be used, or text.
        elif isinstance(value, float) and not math.isfinite(value):
            yield key, f"= {value}: numbers must be finite and within ±1.8e308; write an ordinary one, such as 1.5"
        elif isinstance(value, int) and abs(value) >= 2**63:
            yield key, f"= {shown(value)}: whole numbers have at most 18 digits; write it as 1.5e20"
        elif not isinstance(value, str | int | float):
            yield key, f"= {value}: a scene has no dates or times; write a number, or text in quotes"


def inside(folder: Path, file: str | Path) -> Path:
    r"""The path of a file that a scene names, which must stay inside the scene's folder.

    Raises
    ------
    ValueError
        If the path is absolute, climbs with ``..``, leaves the folder by a symbolic link, or names no file.

    Examples
    --------
    >>> inside(Path("/scenes"), "../secret.obj")
    Traceback (most recent call last):
    ValueError: '../secret.obj' leaves the scene's folder: give a path inside it, without '..'
    """
    # The path as it is written, on any system.
    name = str(file)
    posix, windows = PurePosixPath(name), PureWindowsPath(name)
    if not name or "\0" in name:
        raise ValueError(f"{shown(name)} is not a file name: give a path inside the scene's folder")
    if posix.is_absolute() or windows.drive or windows.root:
        raise ValueError(f"{shown(name)} is an absolute path: give one relative to the scene's folder")
    if ".." in posix.parts or ".." in windows.parts:
        raise ValueError(f"{shown(name)} leaves the scene's folder: give a path inside it, without '..'")

    # The file that it leads to, links followed.
    try:
        path = (folder / name).resolve()
        here = path.is_file()
    except (OSError, RuntimeError) as error:  # RuntimeError: links that lead in a circle, before Python 3.13
        raise ValueError(f"{shown(name)} cannot be read ({error}): give a path inside the scene's folder") from None
    if not path.is_relative_to(folder.resolve()):
        raise ValueError(f"{shown(name)} is a link out of the scene's folder: copy the file into it")
    if not here:
        raise ValueError(f"{shown(name)} does not exist in the scene's folder: correct the name or add the file")
    return path


def _items(value: dict[str, Any] | list[Any]) -> list[tuple[str | int, Any]]:
    return list(value.items()) if isinstance(value, dict) else list(enumerate(value))


def _key(parent: str, part: str | int) -> str:
    if isinstance(part, int):
        return f"{parent}[{part}]"
    name = part if re.fullmatch(r"[\w.-]{1,64}", part) else shown(part)
    return f"{parent}.{name}" if parent else name


def _line_of_long_number(text: str) -> int:
    found = re.search(r"[0-9_]{4300,}", text)
    return text.count("\n", 0, found.start() if found else 0) + 1
