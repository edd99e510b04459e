"""The scene that holds everything together (before step 1).

A record is checked when it is made, and reports all of its faults at once, one line each, with its key: so a scene that
exists can be traced.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from symrt.errors import hinting, refuse, shown
from symrt.scene.cameras import Camera
from symrt.scene.checks import check_whole, settle
from symrt.scene.consistency import file_faults, light_faults, name_faults, named_materials, reference_faults
from symrt.scene.interreflection import Interreflection
from symrt.scene.lights import Light
from symrt.scene.materials import Material, models_text
from symrt.scene.media import WINDOWS, window_faults, window_nodes
from symrt.scene.surface_lights import SurfaceLight
from symrt.table import html_table

OPEN = frozenset({"plane", "disk", "rectangle", "tube"})
"""Kinds of shapes that have no inside."""

DEEPEST = 1000
"""Largest number of mirror bounces that a scene may ask for."""


@hinting
@dataclass(frozen=True)
class Scene:
    """Shapes, their materials and textures, lights, and the camera that looks at them.

    Parameters
    ----------
    camera
        The viewpoint and the film.
    shapes
        The surfaces, each with the name of its material or texture.
    materials, lights, textures
        Records with unique names; an environment is taken apart into the lights of its regions.
    depth
        Number of mirror bounces followed; the light cut off after them is bounded and reported.
    interreflection
        The asking for light that diffusers send to each other; None for a scene lit by its lights alone.
    folder
        The folder that holds the files of meshes and textures.
    windows
        The parts of the spectrum that are followed apart behind glass whose index changes with the wavelength: so many,
        from 380 to 730 nm, or a list of their centres in nm.

    Raises
    ------
    ValueError
        If the parts do not fit each other, with one line for each fault.

    Examples
    --------
    >>> from symrt.geometry import Sphere
    >>> from symrt.scene.lights import DirectionalLight
    >>> Scene(
    ...     camera=Camera(position=(0, 3, 8), target=(0, 1, 0), width=320, height=240),
    ...     shapes=[Sphere(centre=(0, 1, 0), radius=1, material="red")],
    ...     materials=[Material("red", model="phong", exponent=40)],
    ...     lights=[DirectionalLight("sun", direction=(1, -1, 0))],
    ... ).symbols
    ('sun', 'red.diffuse', 'red.specular')
    """

    camera: Camera
    shapes: Sequence[Any]
    materials: Sequence[Material]
    lights: Sequence[Light]
    textures: Sequence[Any] = ()
    depth: int = 4
    folder: Path = Path()
    interreflection: Interreflection | None = None
    windows: int | Sequence[float | int] = WINDOWS

    def __post_init__(self) -> None:
        for key in ("shapes", "materials", "lights", "textures"):
            settle(self, **{key: tuple(getattr(self, key))})
        settle(self, windows=tuple(self.windows) if isinstance(self.windows, list) else self.windows)
        # An environment is the lights of its regions.
        settle(self, lights=tuple(part for light in self.lights for part in getattr(light, "lights", (light,))))
        refuse(_scene_faults(self))

    @property
    def symbols(self) -> tuple[str, ...]:
        """Names of the spectra that a palette of this scene gives: its lights, then its reflectances."""
        lights = (light.name for light in self.lights)
        return (*lights, *(symbol for material in self.materials for symbol in material.symbols))

    @property
    def nodes(self) -> tuple[float, ...]:
        """The wavelengths that are followed apart behind glass with a dispersion, in nm."""
        return window_nodes(self.windows)

    @cached_property
    def used_textures(self) -> frozenset[str]:
        """Names of the textures that some shape has."""
        return self._named_by_shapes & {texture.name for texture in self.textures}

    @cached_property
    def used_materials(self) -> frozenset[str]:
        """Names of the materials that some shape has, by itself or in a texture."""
        textured = (name for t in self.textures if t.name in self.used_textures for name in t.materials)
        return (self._named_by_shapes - self.used_textures) | frozenset(textured)

    @property
    def _named_by_shapes(self) -> frozenset[str]:
        return frozenset(name for shape in self.shapes for _, name in named_materials("", _materials_of(shape)))

    @cached_property
    def glass(self) -> frozenset[str]:
        """Names of the materials that light goes through, or that mirror as glass, and of textures that have them."""
        clear = frozenset(material.name for material in self.materials if material.reflection.refracts)
        return clear | {texture.name for texture in self.textures if not clear.isdisjoint(texture.materials)}

    def material(self, name: str) -> Material:
        """The material of a given name."""
        return next(material for material in self.materials if material.name == name)

    def _repr_html_(self) -> str:
        rows: list[tuple[str, str, str]] = [
            ("camera", self.camera.type, f"{self.camera.width} × {self.camera.height} pixels")
        ]
        rows += [(type(light).__name__, light.name, _details(light)) for light in self.lights]
        rows += [
            ("Material", m.name, f"{models_text(m)} {_details(m.parameters)}{m.dispersion or ''}")
            for m in self.materials
        ]
        rows += [(type(texture).__name__, texture.name, _details(texture)) for texture in self.textures]
        for shape in self.shapes:
            named = ", ".join(name for _, name in named_materials("", _materials_of(shape)))
            rows.append((type(shape).__name__, named, _details(shape)))
        return html_table(("what", "name or material", ""), rows)


def _scene_faults(scene: Scene) -> Iterator[str]:
    # Each part by itself.
    kinds = list(_kind_faults(scene))
    yield from kinds
    yield from light_faults(scene.lights)
    yield from check_whole("depth", scene.depth, DEEPEST, least=0)
    asked: object = scene.interreflection
    if not isinstance(asked, Interreflection | None):
        rule = "ask with a record, such as Interreflection(paths=64, depth=3)"
        yield f"interreflection = {shown(asked)}: {rule}"
    windows = list(window_faults(scene.windows))
    yield from windows

    # What refers to what, once all parts are what they should be.
    if not kinds:
        named = ("lights", "materials", "textures")
        yield from name_faults((key, record.name) for key in named for record in getattr(scene, key))
        faults = list(_reference_faults(scene))
        yield from faults or (*_open_glass_faults(scene), *_glow_faults(scene))
        yield from () if windows else _dispersion_faults(scene)
        yield from _order_faults(scene)
        yield from _place_faults(scene)


def _kind_faults(scene: Scene) -> Iterator[str]:
    demands: dict[str, Callable[[Any], bool]] = {
        "materials": lambda m: isinstance(m, Material),
        "lights": lambda light: isinstance(light, Light),
        "textures": lambda texture: hasattr(texture, "name") and hasattr(texture, "materials"),
        "shapes": lambda shape: hasattr(shape, "material") or hasattr(shape, "materials"),
    }
    for key, fits in demands.items():
        for i, record in enumerate(getattr(scene, key)):
            if not fits(record):
                yield f"{key}[{i}] = {shown(record)}: this is not one of the {key}; move it to where it belongs"


def _reference_faults(scene: Scene) -> Iterator[str]:
    shapes = [(f"shapes[{i}]", shape) for i, shape in enumerate(scene.shapes)]
    textures = [(f"textures.{texture.name}", texture) for texture in scene.textures]
    materials = [material.name for material in scene.materials]
    for key, texture in textures:
        yield from reference_faults(named_materials(f"{key}.materials", texture.materials), materials, "material")
    known = [*materials, *(texture.name for texture in scene.textures)]
    for key, shape in shapes:
        yield from reference_faults(
            named_materials(f"{key}.material", _materials_of(shape)), known, "material or texture"
        )
    glowing = ((f"lights.{light.name}.material", light.material) for light in scene.lights if _glows(light))
    yield from reference_faults(glowing, materials, "material")
    yield from file_faults(((f"{k}.file", r.file) for k, r in shapes + textures if hasattr(r, "file")), scene.folder)


def _open_glass_faults(scene: Scene) -> Iterator[str]:
    """Shapes of glass that enclose nothing; meshes that are still files are looked at when they are read."""
    for index, shape in enumerate(scene.shapes):
        kind = "tube" if getattr(shape, "capped", True) is False else getattr(shape, "type", "mesh")
        if kind in OPEN:
            names = [name for _, name in named_materials("", _materials_of(shape))]
            yield from (
                f"shapes[{index}].material = {name!r}: light goes through it, and a {kind} has no inside; use a "
                "sphere, a box, a capped cylinder or a closed mesh"
                for name in names
                if name in scene.glass
            )


def _glows(light: Any) -> TypeGuard[SurfaceLight]:
    return isinstance(light, SurfaceLight)


def _glow_faults(scene: Scene) -> Iterator[str]:
    """Surfaces that glow in no light's name, and lights of surfaces that do not glow."""
    named = {light.material for light in scene.lights if _glows(light)}
    for light in scene.lights:
        if _glows(light) and scene.material(light.material).reflection.emitted == 0:
            yield (
                f"lights.{light.name}.material = {light.material!r}: it does not glow, as its model has no formula "
                'emitted; stack one, model = ["lambert", "emitter"]'
            )
    for material in scene.materials:
        if material.reflection.emitted != 0 and material.name not in named:
            yield (
                f"materials.{material.name}: it glows, and no light says with what spectrum; add a light of "
                f'type = "surface" and material = "{material.name}"'
            )


def _dispersion_faults(scene: Scene) -> Iterator[str]:
    """Media without an index at some wavelength of the scene's windows."""
    for material in scene.materials:
        if material.dispersion is not None:
            faults = material.dispersion.faults(scene.nodes[0], scene.nodes[-1])
            yield from (f"materials.{material.name}: {material.dispersion}: {fault}" for fault in faults)


def _order_faults(scene: Scene) -> Iterator[str]:
    """Paint that would give back at other wavelengths what glass has told apart: a column has its window last."""
    if scene.interreflection is not None:
        paints = [material.name for material in scene.materials if material.reflection.fluorescent]
        glass = [material.name for material in scene.materials if material.dispersion is not None]
        if paints and glass:
            yield (
                f"interreflection: {paints[0]} fluoresces, and would gather light through {glass[0]}, whose index "
                f"changes with the wavelength; give {glass[0]} an index = 1.5, say, or leave out interreflection"
            )


def _place_faults(scene: Scene) -> Iterator[str]:
    for light in scene.lights:
        if getattr(light, "position", None) == scene.camera.target:
            yield (
                f"lights.{light.name}.position: it stands at the camera's target, where the white that reflectances "
                "are measured against is looked for; move the light or the target"
            )


def _materials_of(shape: Any) -> Any:
    """The name of a shape's material, or the several names of a mesh, loaded or not, and of a box."""
    return shape.material if hasattr(shape, "material") else shape.materials


def _details(record: Any) -> str:
    """The fields of a record as text, without values computed from them, such as a box's triangles."""
    told = dict(record) if isinstance(record, Mapping) else vars(record)
    own = {one.name for one in fields(record)} if is_dataclass(record) else set(told)
    skipped = {"name", "type", "material"}
    told = {key: value for key, value in told.items() if key in own and not isinstance(value, np.ndarray)}
    return ", ".join(f"{key} = {shown(value)}" for key, value in told.items() if key not in skipped)
