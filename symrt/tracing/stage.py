"""A scene made ready for rays: files read, everything moved to the camera, models bound to materials (step 1)."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from symrt.geometry.box import Box
from symrt.geometry.culling import Shapes, gathered
from symrt.geometry.mesh import Mesh, load_mesh
from symrt.geometry.pictures import load_texture
from symrt.geometry.rays import clearance, translate
from symrt.geometry.triangle_mesh import TriangleMesh
from symrt.reflection.bounds import largest
from symrt.reflection.models import INDEX, LIT
from symrt.scene.cameras import Camera, moved_camera
from symrt.scene.interreflection import Interreflection
from symrt.scene.lights import Answering, answering
from symrt.scene.materials import Material
from symrt.scene.records import Scene
from symrt.scene.sky import Sky
from symrt.scene.wide_lights import AreaLight, WideLight
from symrt.symbols import Surface
from symrt.tracing.raytree import LightRecord, MaterialRecord
from symrt.windows import SpectralWindow, windows_of

Alternatives = Mapping[str, Sequence[str]]
"""For a material, others that may take its place."""


@dataclass(frozen=True, eq=False)
class Stage:
    """A scene made ready for rays, shared by all tiles of a trace.

    Parameters
    ----------
    seen
        The shapes, and after them the lamps that are seen; the same record where there is none.
    slots
        Names of the surfaces' materials and textures: a shape owns one slot, a mesh one for each of its materials, a
        box one for each face.  A lamp's slot has its own name.
    first_slot
        For each shape, the index of its first slot.
    alternatives
        For each material, others whose formulas are also evaluated at its points.
    lights
        Each light, seen from the camera: those with a direction first, by name.
    sky
        The regions of the sky.
    remembered
        The tree's record of each light, in the scene's order.
    sending
        For each material whose surfaces send rays on, by itself or as an alternative, the formulas that say so; those
        that lights meet come last, and count only where an effect sends rays by them, too.
    most
        For each material, upper bounds of the shares by which its formulas send on what further rays bring; 1 where
        more may be sent, or nothing is known.
    windows
        The windows of wavelengths that glass bends apart; none where no index changes with the wavelength.
    """

    camera: Camera
    shapes: Shapes
    seen: Shapes
    slots: tuple[str, ...]
    first_slot: np.ndarray
    textures: Mapping[str, object]
    materials: Mapping[str, MaterialRecord]
    alternatives: Alternatives
    lights: tuple[Answering, ...]
    sky: tuple[Sky, ...]
    remembered: Mapping[str, LightRecord]
    depth: int
    interreflection: Interreflection | None
    sending: Mapping[str, tuple[str, ...]]
    most: Mapping[str, Mapping[str, float]]
    windows: tuple[SpectralWindow, ...] = ()

    @property
    def textured(self) -> frozenset[int]:
        """The shapes whose surface coordinates a texture asks for."""
        slots = np.flatnonzero([name in self.textures for name in self.slots])
        return frozenset((np.searchsorted(self.first_slot, slots, side="right") - 1).tolist())


def make_stage(scene: Scene, alternatives: Alternatives | None = None) -> Stage:
    """Read a scene's files and move everything so that the camera stands at the origin.

    Distances are then measured from where precision is needed, however far from the origin a scene was modelled.
    """
    alternatives = checked_alternatives(scene, alternatives or {})

    # Read the files of shapes and textures.
    loaded = [load_mesh(shape, scene.folder) if isinstance(shape, Mesh) else shape for shape in scene.shapes]
    textures = {texture.name: load_texture(texture, scene.folder) for texture in scene.textures}

    # Bind each model to its material.
    _check_closed(scene, loaded)
    materials, sending = _materials(scene, alternatives), _sending(scene, alternatives)

    # Move everything to the camera.
    x, y, z = scene.camera.position
    by = (-x, -y, -z)
    camera = moved_camera(scene.camera, by)
    lights = tuple(answering(light).moved(by) for light in scene.lights)
    moved = [translate(shape, np.array(by)) for shape in loaded]

    # Number the materials of the shapes; lamps that are seen come after them, and cast no shadow.
    shapes = gathered(moved)
    lamps = [light.shape for light in lights if isinstance(light, AreaLight) and light.visible]
    seen = gathered([*shapes, *lamps]) if lamps else shapes
    slots, first = _numbered(seen)

    # The sky, where nothing is met: the last slot, which a hit of the shape −1 finds.
    sky = tuple(light for light in lights if isinstance(light, Sky))
    if sky:
        slots, first = (*slots, sky[0].name), np.append(first, len(slots))
    return Stage(
        camera=camera,
        shapes=shapes,
        seen=seen,
        slots=slots,
        first_slot=first,
        textures=textures,
        materials=materials,
        alternatives=alternatives,
        lights=tuple(sorted((light for light in lights if light.via == "direct"), key=lambda light: light.name))
        + tuple(light for light in lights if light.via != "direct"),
        sky=sky,
        remembered={light.name: _remembered(light, camera, shapes, scene) for light in lights},
        depth=scene.depth,
        interreflection=scene.interreflection,
        sending=sending,
        most={name: _most(record) for name, record in materials.items()},
        windows=windows_of(scene.nodes) if any(record.indices for record in materials.values()) else (),
    )


def _most(record: MaterialRecord) -> dict[str, float]:
    """Upper bounds of the formulas by which a material sends rays on, for its parameters as they are."""
    ranges = {key: (value, value) for key, value in record.parameters.items()}
    return {via: min(largest(record.model.formulas[via], ranges), 1.0) for via in sorted(record.model.sending)}


def _check_closed(scene: Scene, shapes: Sequence[object]) -> None:
    """Refuse meshes of glass with a hole: what is inside of them is not known.

    Raises
    ------
    ValueError
        That names the mesh, and the ends of its first open edge.
    """
    for index, shape in enumerate(shapes):
        if (
            isinstance(shape, TriangleMesh)
            and scene.glass.intersection(shape.materials)
            and shape.open_edge is not None
        ):
            first, last = (tuple(end) for end in shape.open_edge.tolist())
            raise ValueError(
                f"shapes[{index}]: a mesh of glass must be closed, and its edge from {first} to {last} belongs to one "
                "triangle only, or to two that are wound against each other; repair the mesh"
            )
        if isinstance(shape, TriangleMesh) and scene.glass.intersection(shape.materials) and shape.volume < 0:
            raise ValueError(f"shapes[{index}]: a mesh of glass is wound inside out; turn its faces round")


def senders(scene: Scene, alternatives: Alternatives, via: str) -> tuple[str, ...]:
    """Names of the materials of some shape whose formula `via` is not zero; ``sea>ice`` where only an alternative's is.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> senders(load_scene(shipped_scene("spheres")), {"red": ["chrome"]}, "reflected")
    ('chrome', 'light_tile', 'dark_tile', 'red>chrome')
    """
    sending = {
        m.name
        for m in scene.materials
        if via in m.reflection.sending or (via in LIT and m.reflection.formulas[via] != 0)
    }
    used = [m.name for m in scene.materials if m.name in scene.used_materials]
    others = (
        str(Surface(other, instead_of=name))
        for name in used
        for other in alternatives.get(name, ())
        if other in sending
    )
    return (*(name for name in used if name in sending), *others)


def refracting(scene: Scene, alternatives: Alternatives) -> tuple[str, ...]:
    """Names of the materials of some shape, or alternatives to them, that light goes through or that mirror as glass.

    Examples
    --------
    >>> from symrt.scene import load_scene, shipped_scene
    >>> refracting(load_scene(shipped_scene("glass")), {})
    ('glass', 'flint', 'water')
    """
    sending = (name for via in ("transmitted", "reflected") for name in senders(scene, alternatives, via))
    glass = (name for name in sending if scene.material(Surface.of(name).material).reflection.refracts)
    return tuple(dict.fromkeys(glass))


def _sending(scene: Scene, alternatives: Alternatives) -> dict[str, tuple[str, ...]]:
    """The formulas by which each material's surfaces may send rays on, those of its alternatives included."""
    formulas = (*sorted({via for material in scene.materials for via in material.reflection.sending}), *LIT)
    found: dict[str, tuple[str, ...]] = {}
    for via in formulas:
        for place in dict.fromkeys(Surface.of(name).place for name in senders(scene, alternatives, via)):
            found[place] = (*found.get(place, ()), via)
    return found


def checked_alternatives(scene: Scene, alternatives: Alternatives) -> Alternatives:
    """The alternatives, each one once, if every name is a material's."""
    known = [m.name for m in scene.materials]
    for material, others in alternatives.items():
        if isinstance(others, str):
            raise ValueError(  # noqa: TRY004 -- a bad argument is a bad value
                f"alternatives: {others!r} stands for {material!r}: give a list of names, [{others!r}]"
            )
        for name in (material, *others):
            if name not in known:
                raise ValueError(f"alternatives: there is no material {name!r}; the scene has {', '.join(known)}")
        # An alternative weighs nothing until a blend gives its reflectances weight.
        for name in (material, *others) if others else ():
            if scene.material(name).reflection.always_there:
                raise ValueError(
                    f"alternatives: {name!r} has a term that names no reflectance, as a metal's edge, which no blend "
                    "can weigh: metals of one model blend without alternatives; or give it another model, as 'mirror'"
                )
    return {material: tuple(dict.fromkeys(others)) for material, others in alternatives.items()}


def _numbered(shapes: Sequence[Any]) -> tuple[tuple[str, ...], np.ndarray]:
    """The slots of all shapes, one shape after the other, and the first slot of each."""
    slots: list[str] = []
    first = []
    for shape in shapes:
        first.append(len(slots))
        slots += shape.materials if isinstance(shape, TriangleMesh | Box) else [shape.material]
    return tuple(slots), np.array(first, dtype=np.int64)


def _materials(scene: Scene, alternatives: Alternatives) -> dict[str, MaterialRecord]:
    """The tree's record of each material, and of each alternative under its own name."""
    named = {material.name: _record(material, scene) for material in scene.materials}
    pairs = [(name, other) for name, others in alternatives.items() for other in others]
    return named | {str(Surface(other, instead_of=name)): named[other] for name, other in pairs}


def _remembered(light: Answering, camera: Camera, shapes: Shapes, scene: Scene) -> LightRecord:
    """The tree's record of a light; a lamp that is seen has the radiance 1."""
    shown = 1.0 if isinstance(light, AreaLight) and light.visible else 0.0
    shown = light.brightest if isinstance(light, Sky) else shown
    return LightRecord(light.via, light.white(camera.target), _bound(light, shapes, scene), shown)


def _record(material: Material, scene: Scene) -> MaterialRecord:
    if material.dispersion is None:
        return MaterialRecord(material.reflection, dict(material.parameters))
    # The index at each window's centre, and one in the middle that stands for all where they are not told apart.
    nodes = np.array([*scene.nodes, (scene.nodes[0] + scene.nodes[-1]) / 2])
    *indices, middle = material.dispersion.index(nodes).tolist()
    return MaterialRecord(material.reflection, {**material.parameters, INDEX: middle}, tuple(indices))


def _bound(light: Answering, shapes: Shapes, scene: Scene) -> float:
    """The light's own bound; diffusers get no more from what has the radiance 1 than from the whole sky, π."""
    bound = light.bound(partial(_nearest, shapes))
    if isinstance(light, WideLight) and all(material.reflection.diffusing for material in scene.materials):
        return min(bound, np.pi * (light.brightest if isinstance(light, Sky) else 1.0))
    return bound


def _nearest(shapes: Shapes, place: np.ndarray) -> float:
    """The distance from a place to the nearest surface; infinite where there is none."""
    return min((clearance(shape, place) for shape in shapes), default=float("inf"))
