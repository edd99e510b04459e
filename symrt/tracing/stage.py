"""A scene made ready for rays: files read, everything moved to the camera, models bound to materials (step 1)."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from symrt.geometry.mesh import Mesh, TriangleMesh, load_mesh
from symrt.geometry.pictures import load_texture
from symrt.geometry.rays import clearance, encloses, translate
from symrt.scene.cameras import Camera, moved_camera
from symrt.scene.lights import AmbientLight, DirectionalLight, Light, PointLight, moved, white
from symrt.scene.records import Scene
from symrt.tracing.plan import Alternatives, Plan, mirroring, plan
from symrt.tracing.raytree import MaterialRecord


@dataclass(frozen=True, eq=False)
class Stage:
    """What every tile of a trace shares.

    Parameters
    ----------
    slots
        What each surface is made of, a material or a texture; a shape owns one slot, a mesh one for each of its
        materials.
    first_slot
        For each shape, its first slot.
    alternatives
        For each material, others whose formulas are also evaluated at its points.
    irradiance
        For each light, an upper bound on the irradiance it gives any surface, per unit of its symbol.
    reflecting
        Materials of surfaces that mirror, by themselves or as an alternative.
    """

    camera: Camera
    shapes: tuple[object, ...]
    slots: tuple[str, ...]
    first_slot: np.ndarray
    textures: Mapping[str, object]
    materials: Mapping[str, MaterialRecord]
    alternatives: Alternatives
    lights: tuple[Light | AmbientLight, ...]
    white: Mapping[str, float]
    irradiance: Mapping[str, float]
    depth: int
    reflecting: tuple[str, ...]
    plan: Plan


def make_stage(scene: Scene, alternatives: Alternatives | None = None) -> Stage:
    """Read a scene's files and move everything so that the camera stands at the origin.

    Distances are then measured from where precision is needed, however far from the origin a scene was modelled.
    """
    alternatives = _checked(scene, alternatives or {})
    x, y, z = scene.camera.position
    by = (-x, -y, -z)
    shapes = tuple(translate(_load(shape, scene), np.array(by)) for shape in scene.shapes)
    lights = tuple(moved(light, by) for light in scene.lights)
    camera = moved_camera(scene.camera, by)
    slots, first = _slots(shapes)
    return Stage(
        camera=camera,
        shapes=shapes,
        slots=slots,
        first_slot=first,
        textures={texture.name: load_texture(texture, scene.folder) for texture in scene.textures},
        materials=_materials(scene, alternatives),
        alternatives=alternatives,
        lights=lights,
        white={light.name: white(light, camera.target) for light in lights},
        irradiance={light.name: _brightest(light, shapes) for light in lights},
        depth=scene.depth,
        reflecting=tuple(dict.fromkeys(name.partition(">")[0] for name in mirroring(scene, alternatives))),
        plan=plan(scene, alternatives),
    )


def _checked(scene: Scene, alternatives: Alternatives) -> Alternatives:
    """The alternatives, each one once; every name is a material's."""
    known = [m.name for m in scene.materials]
    for material, others in alternatives.items():
        if isinstance(others, str):
            raise ValueError(  # noqa: TRY004 -- a bad argument is a bad value
                f"alternatives: {others!r} stands for {material!r}: give a list of names, [{others!r}]"
            )
        for name in (material, *others):
            if name not in known:
                raise ValueError(f"alternatives: there is no material {name!r}; the scene has {', '.join(known)}")
    return {material: tuple(dict.fromkeys(others)) for material, others in alternatives.items()}


def _load(shape: object, scene: Scene) -> object:
    if not isinstance(shape, Mesh):
        return shape
    mesh = load_mesh(shape, scene.folder)
    # The scene asked this of its other shapes when it was made; a mesh had to be read first.
    if encloses(mesh, np.array(scene.camera.position)):
        raise ValueError(
            f"camera.position = {list(scene.camera.position)}: it is inside {shape.file}; move one of them"
        )
    return mesh


def _slots(shapes: tuple[object, ...]) -> tuple[tuple[str, ...], np.ndarray]:
    slots: list[str] = []
    first = []
    for shape in shapes:
        first.append(len(slots))
        slots += shape.materials if isinstance(shape, TriangleMesh) else [shape.material]  # type: ignore[attr-defined]
    return tuple(slots), np.array(first, dtype=np.int64)


def _materials(scene: Scene, alternatives: Alternatives) -> dict[str, MaterialRecord]:
    named = {m.name: MaterialRecord(m.reflection, dict(m.parameters)) for m in scene.materials}
    return named | {f"{m}>{other}": named[other] for m, others in alternatives.items() for other in others}


def _brightest(light: Light | AmbientLight, shapes: tuple[object, ...]) -> float:
    if isinstance(light, AmbientLight | DirectionalLight):
        return 1.0
    if not isinstance(light, PointLight):
        return float("inf")
    nearest = min((clearance(shape, np.array(light.position)) for shape in shapes), default=float("inf"))
    return 1 / nearest / nearest if nearest > 0 else float("inf")
