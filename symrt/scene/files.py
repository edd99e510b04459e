"""Scene files: TOML in, a `Scene` out, or every fault at once with its file, key, rule and remedy (before step 1).

The tables are checked against the records that Python code uses, in JSON's strict sense: text is no number.  Names in
the file are only ever compared, never evaluated.  ``[palettes]`` is left to its own reader and ignored here.
"""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import ConfigDict, Field, PlainValidator, TypeAdapter, ValidationError

from symrt.errors import SceneError, shown, suggestion
from symrt.geometry import (
    BandedRelief,
    Box,
    Checker,
    Cylinder,
    Disk,
    LabelImage,
    Mesh,
    Plane,
    Rectangle,
    Sphere,
    WeightImage,
)
from symrt.reading import number_faults, read_toml, scene_path
from symrt.scene.area_lights import DiskLight, RectangleLight, SphereLight
from symrt.scene.cameras import Camera
from symrt.scene.consistency import file_faults, light_faults, name_faults, named_materials, reference_faults
from symrt.scene.interreflection import Interreflection
from symrt.scene.lights import AmbientLight, DirectionalLight, PointLight
from symrt.scene.materials import Material
from symrt.scene.media import WINDOWS
from symrt.scene.records import Scene
from symrt.scene.sky import Environment
from symrt.scene.surface_lights import SurfaceLight

KINDS: dict[str, dict[str, type]] = {
    "shapes": {kind.type: kind for kind in (Sphere, Plane, Disk, Rectangle, Cylinder, Box, Mesh)},
    "lights": {
        kind.type: kind
        for kind in (
            PointLight,
            DirectionalLight,
            AmbientLight,
            RectangleLight,
            DiskLight,
            SphereLight,
            SurfaceLight,
            Environment,
        )
    },
    "textures": {kind.type: kind for kind in (Checker, LabelImage, WeightImage, BandedRelief)},
}
"""The record of each `type` that a shape, a light and a texture may have."""

RECORDS: dict[str, type] = {"camera": Camera, "interreflection": Interreflection}
"""The record of each table that stands alone."""

UNION_PARTS = frozenset({"int", "float", "str", "dict[str,str]"})
"""Parts that pydantic adds to a key to say which member of a union it tried."""

_NUMBER = "it must be a number; write it without quotes, such as 1.5"
_WHOLE = "it must be a whole number; write it without quotes or decimals, such as 256"
_TABLE = "it must be a table; write its keys below a line such as [camera]"
_LIST = "it must be a list in brackets, such as [0, 1, 0]"
RULES = {
    "float_type": _NUMBER,
    "int_type": _WHOLE,
    "int_from_float": _WHOLE,
    "int_parsing_size": _WHOLE,
    "bool_type": "it must be true or false, without quotes",
    "string_type": "it must be text in quotes",
    "path_type": "it must be the name of a file, in quotes",
    "tuple_type": _LIST,
    "missing": "it is missing; a point or direction is three numbers, such as [0, 1, 0]",
    "too_long": "it has too many numbers; a point or direction is three, such as [0, 1, 0]",
    "dict_type": _TABLE,
    "dataclass_type": _TABLE,
    "model_attributes_type": _TABLE,
}
"""Rules in the words of the file, by pydantic's kind of error."""

NAMED = ("lights", "materials", "textures")
"""The tables whose keys are names."""


def load_scene(path: str | Path) -> Scene:
    """Read a scene file, or a scene that comes with symrt by its bare name.

    Raises
    ------
    SceneError
        If anything is wrong with the file, with one line for each fault.

    Examples
    --------
    >>> load_scene("first").symbols
    ('sun', 'red.diffuse', 'red.specular')
    """
    path = scene_path(path)
    tables = {key: value for key, value in read_toml(path).items() if key != "palettes"}

    # Numbers that no record could hold come first: tables nested too deeply are not read any further.
    bad_values = dict(number_faults(tables))
    faults = [f"{key} {fault}" if fault[0] == "=" else f"{key}{fault}" for key, fault in bad_values.items()]
    if not any("nested" in fault for fault in faults):
        scene, found = _scene(tables, path.parent)
        if scene is not None and not faults:
            return scene
        # A value that is reported already is not reported once more by the record that holds it.
        faults += [
            fault for fault in found if not any(f"{bad}[".startswith(f"{_key_of(fault)}[") for bad in bad_values)
        ]
    raise SceneError("\n".join(f"{path}: {fault}" for fault in dict.fromkeys(faults)))


def _material(table: Any) -> Material:
    if not isinstance(table, Mapping):
        raise ValueError("it must be a table; write [materials.red] and its keys below it")  # noqa: TRY004 -- pydantic asks for it
    return Material(**table)


@dataclass(frozen=True)
class Document:
    """The tables of a scene file, as the records they become."""

    __pydantic_config__: ClassVar = ConfigDict(extra="forbid", strict=True)
    camera: Camera
    shapes: tuple[
        Annotated[Sphere | Plane | Disk | Rectangle | Cylinder | Box | Mesh, Field(discriminator="type")], ...
    ]
    materials: dict[str, Annotated[Any, PlainValidator(_material)]]
    lights: dict[
        str,
        Annotated[
            PointLight
            | DirectionalLight
            | AmbientLight
            | RectangleLight
            | DiskLight
            | SphereLight
            | SurfaceLight
            | Environment,
            Field(discriminator="type"),
        ],
    ] = field(default_factory=dict)
    textures: dict[str, Annotated[Checker | LabelImage | WeightImage | BandedRelief, Field(discriminator="type")]] = (
        field(default_factory=dict)
    )
    depth: int = 4
    interreflection: Interreflection | None = None
    windows: Any = WINDOWS


@cache
def _reader() -> Any:
    return TypeAdapter(Document)


def _scene(tables: Mapping[str, Any], folder: Path) -> tuple[Scene | None, list[str]]:
    """Make the scene of a file's tables, and list its faults; there is no scene if there are any."""
    # A table's key becomes the name of its record.
    faults = list(_own_name_faults(tables))
    named = {kind: _with_names(tables[kind]) for kind in NAMED if kind in tables}

    # Check each table against its record.
    try:
        document = _reader().validate_json(_json({**tables, **named}))
    except ValidationError as error:
        errors = error.errors(include_url=False, include_input=True)
        # Of a union that nothing fits only one member is reported: a number, or one name for a mesh.
        told = [one for one in errors if one["loc"][-1] not in ("int", "dict[str,str]")]
        meant = {place for one in told if (place := _meant(tuple(one["loc"]), dict(one))) is not None}
        told = [one for one in told if one["type"] != "missing" or tuple(one["loc"]) not in meant]
        faults += [line for one in told for line in _lines(tuple(one["loc"]), dict(one))]
        return None, [*faults, *_consistency_faults(tables, folder)]

    # Check that the records fit each other.
    try:
        scene = Scene(
            camera=document.camera,
            shapes=document.shapes,
            materials=tuple(document.materials.values()),
            lights=tuple(document.lights.values()),
            textures=tuple(document.textures.values()),
            depth=document.depth,
            interreflection=document.interreflection,
            folder=folder,
            windows=document.windows,
        )
    except ValueError as error:
        return None, [*faults, *str(error).splitlines()]
    return (None if faults else scene), faults


def _json(tables: Mapping[str, Any]) -> str:
    """The tables as JSON; dates and whole numbers beyond 64 bits, reported already, become text and floats."""
    text = json.dumps(tables, default=str)
    return json.dumps(json.loads(text, parse_int=lambda digits: int(digits) if len(digits) < 20 else float(digits)))


def _with_names(kind: Any) -> Any:
    if not isinstance(kind, dict):
        return kind
    return {name: {**table, "name": name} if isinstance(table, dict) else table for name, table in kind.items()}


def _own_name_faults(tables: Mapping[str, Any]) -> Iterator[str]:
    for kind in NAMED:
        for key, table in _subtables(tables, kind):
            if "name" in table:
                yield f"{key}.name = {shown(table['name'])}: its table has the name already; delete this line"


def _consistency_faults(tables: Mapping[str, Any], folder: Path) -> Iterator[str]:
    """Faults of names, references and files in tables that have other faults too."""
    names = {kind: list(tables[kind]) if isinstance(tables.get(kind), dict) else [] for kind in NAMED}
    yield from light_faults(names["lights"])
    yield from name_faults((kind, name) for kind in NAMED for name in names[kind])

    # References and files that are no text are reported with their tables.
    shapes, textures = list(_subtables(tables, "shapes")), list(_subtables(tables, "textures"))
    glowing = ((f"{key}.material", table.get("material")) for key, table in _subtables(tables, "lights"))
    yield from reference_faults(_texts(glowing), names["materials"], "material")
    for key, table in textures:
        uses = named_materials(f"{key}.materials", table.get("materials", []))
        yield from reference_faults(_texts(uses), names["materials"], "material")
    for key, table in shapes:
        uses = named_materials(f"{key}.material", table.get("material", []))
        yield from reference_faults(_texts(uses), names["materials"] + names["textures"], "material or texture")
    yield from file_faults(_texts((f"{key}.file", table.get("file")) for key, table in shapes + textures), folder)


def _subtables(tables: Mapping[str, Any], kind: str) -> Iterator[tuple[str, dict[str, Any]]]:
    value = tables.get(kind)
    if isinstance(value, dict):
        yield from ((f"{kind}.{_shown_key(name)}", table) for name, table in value.items() if isinstance(table, dict))
    elif isinstance(value, list):
        yield from ((f"{kind}[{i}]", table) for i, table in enumerate(value) if isinstance(table, dict))


def _texts(pairs: Iterable[tuple[str, Any]]) -> list[tuple[str, str]]:
    return [(key, value) for key, value in pairs if isinstance(value, str)]


def _meant(where: tuple[str | int, ...], error: dict[str, Any]) -> tuple[str | int, ...] | None:
    """The key that an unknown one seems to stand for, so that it is not reported as missing too."""
    if error["type"] not in ("unexpected_keyword_argument", "extra_forbidden"):
        return None
    near = re.fullmatch(r"did you mean '(.*)'\?", suggestion(str(where[-1]), _keys(where)))
    return (*where[:-1], near[1]) if near else None


def _keys(where: tuple[str | int, ...]) -> list[str]:
    """The keys that the table of a key may have."""
    tag = where[2] if len(where) > 2 and where[0] in KINDS else None
    record = KINDS[str(where[0])].get(str(tag)) if tag else RECORDS.get(str(where[0]))
    return [f.name for f in fields(record or Document) if f.name != "name"]


def _lines(where: tuple[str | int, ...], error: dict[str, Any]) -> Iterator[str]:
    """Put one of pydantic's errors into the words of the file."""
    # The record that was tried, and the key as the file has it.
    tag = where[2] if len(where) > 2 and where[0] in KINDS else None
    known = KINDS.get(str(where[0]), {})
    record = known.get(str(tag)) if tag else RECORDS.get(str(where[0]))
    keys = _keys(where)
    where = tuple(part for i, part in enumerate(where) if not (i == 2 and tag) and part not in UNION_PARTS)
    key, last = _dotted(where), where[-1]

    # A line for each kind of error, from the record's own to the general ones.
    if error["type"] == "value_error":
        lines = str(error["ctx"]["error"]).splitlines()
        # Names are reported with their tables, by `name_faults`.
        yield from (_placed(key, line, record) for line in lines if not line.startswith("name = "))
    elif error["type"] in ("unexpected_keyword_argument", "extra_forbidden"):
        yield f"{key}: there is no such key; {suggestion(str(last), keys)}"
    elif error["type"].startswith("union_tag"):
        value = f" = {shown(error['ctx']['tag'])}: there is no such type" if "tag" in error["ctx"] else ": missing"
        yield f"{key}.type{value}; {suggestion(str(error['ctx'].get('tag', '')), known)}"
    elif error["type"] == "literal_error":
        yield f"{key} = {shown(error['input'])}: it must be {error['ctx']['expected']}"
    elif error["type"] == "missing" and not isinstance(last, int):
        yield f"{key}: missing; add it"
    else:
        rule = RULES.get(error["type"], error["msg"])
        value = "" if error["type"] == "missing" else f" = {shown(error['input'])}"
        yield f"{key}{value}: {rule}"


def _placed(key: str, line: str, record: type | None) -> str:
    """Put the record's key before a record's fault, in place of the kind or name that the fault opens with."""
    own = {f.name for f in fields(record)} if record else set()
    line = re.sub(rf"^({getattr(record, 'type', '')}|texture \w+): ", "", line)
    first = re.match(r"(\w+)(\[\d+\])*( = |: )", line)
    if first and (record is None or first[1] in own):
        return f"{key}.{line}"
    return f"{key}: {line}"


def _key_of(fault: str) -> str:
    return re.split(r" = |: ", fault, maxsplit=1)[0]


def _dotted(where: Iterable[str | int]) -> str:
    return "".join(f"[{part}]" if isinstance(part, int) else f".{_shown_key(part)}" for part in where).lstrip(".")


def _shown_key(part: str) -> str:
    return part if re.fullmatch(r"[A-Za-z0-9_-]{1,64}", part) else shown(part)
