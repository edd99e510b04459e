"""Checks that the parts of a scene fit each other: names, references, files (before step 1).

Each check takes pairs of a key and its value, so that it serves a finished `Scene` and the raw tables of a file that
has other faults too; it yields one line for each fault.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from symrt.errors import shown, suggestion
from symrt.reading import inside
from symrt.scene.checks import check_name
from symrt.symbols import RESERVED

Keyed = Iterable[tuple[str, Any]]


def name_faults(names: Keyed) -> Iterator[str]:
    """Report names that formulas cannot use, and names that are used twice; each comes with the key of its table.

    Examples
    --------
    >>> list(name_faults([("lights", "sun"), ("materials", "sun")]))
    ["materials: the name 'sun' is already used in lights; lights, materials and textures share names, so rename one"]
    """
    owner: dict[str, str] = {}
    for key, name in names:
        bad = list(check_name("name", name))
        yield from (f"{key}: {fault}" for fault in bad)
        if name in RESERVED:
            yield f"{key}: the name {name!r} is a key of palettes in files, where it would be lost; choose another"
        if not bad and name in owner:
            rule = "lights, materials and textures share names, so rename one"
            yield f"{key}: the name {name!r} is already used in {owner[name]}; {rule}"
        if not bad:
            owner.setdefault(name, key)


def reference_faults(references: Keyed, known: Collection[str], kind: str) -> Iterator[str]:
    """Report references to names that do not exist.

    Examples
    --------
    >>> list(reference_faults([("shapes[0].material", "rad")], ["red"], "material"))
    ["shapes[0].material = 'rad': no material has this name; did you mean 'red'?"]
    """
    for key, name in references:
        if not isinstance(name, str) or name not in known:
            yield f"{key} = {shown(name)}: no {kind} has this name; {suggestion(str(name), known)}"


def named_materials(key: str, material: Any) -> list[tuple[str, Any]]:
    """The names that a shape's or a texture's `material` mentions, each with its key.

    Examples
    --------
    >>> named_materials("shapes[0].material", {"Brass": "brass"})
    [('shapes[0].material.Brass', 'brass')]
    """
    if isinstance(material, Mapping):
        return [(f"{key}.{part}", name) for part, name in material.items()]
    if isinstance(material, list | tuple):
        return [(f"{key}[{i}]", name) for i, name in enumerate(material)]
    return [(key, material)]


def file_faults(files: Keyed, folder: Path) -> Iterator[str]:
    """Report files that are missing, or that lie outside of the scene's folder.

    Examples
    --------
    >>> list(file_faults([("shapes[0].file", "/etc/passwd")], Path()))
    ["shapes[0].file: '/etc/passwd' is an absolute path: give one relative to the scene's folder"]
    """
    for key, file in files:
        try:
            inside(folder, file)
        except ValueError as error:
            yield f"{key}: {error}"


def light_faults(lights: Collection[Any]) -> Iterator[str]:
    """Report a scene without lights.

    Examples
    --------
    >>> list(light_faults(["sun"]))
    []
    """
    if not lights:
        yield "lights: there is none, so the picture would be black; add one, such as [lights.sun]"
