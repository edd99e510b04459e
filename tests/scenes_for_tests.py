"""Small scenes that several rooms' tests share."""

import math
from dataclasses import replace
from pathlib import Path

import symrt as rt

SCENES = Path(__file__).parent.parent / "scenes"
FEW = 4
"""Most lights that a small scene keeps: every pixel's formula has a term for each."""


def every_scene() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in SCENES.glob("*.toml"))


def small(name: str, size: int, samples: int = 1) -> rt.Scene:
    """A shipped scene with a film of size × size pixels, few places on a lens, and few of many lights."""
    scene = rt.load_scene(SCENES / f"{name}.toml")
    lights = scene.lights if len(scene.lights) <= FEW else scene.lights[: FEW - 1] + scene.lights[-1:]
    eye = replace(scene.camera, width=size, height=size, samples=samples)
    if eye.aperture or eye.f_number:
        eye = replace(eye, lens_samples=2)
    few = None if scene.interreflection is None else rt.Interreflection(2, scene.interreflection.depth)
    return replace(scene, camera=eye, lights=lights, interreflection=few)


def palettes(name: str) -> dict[str, rt.Palette]:
    """The palettes of a shipped scene."""
    return rt.load_palettes(SCENES / f"{name}.toml")


def camera(size: int = 24, **changes) -> rt.Camera:
    """A camera in front of the unit sphere at the origin."""
    return rt.Camera(**({"position": (0, 1, 6), "target": (0, 0, 0), "width": size, "height": size} | changes))


def two_materials(exponent: float, swap: bool = False) -> rt.Scene:
    """A shiny ball beside a dull one under one light without shadows."""
    names = ("dull", "shiny") if swap else ("shiny", "dull")
    return rt.Scene(
        camera=camera(),
        shapes=[
            rt.Sphere(centre=(-0.9, 0, 0), radius=0.8, material=names[0]),
            rt.Sphere(centre=(0.9, 0, 0), radius=0.8, material=names[1]),
        ],
        materials=[rt.Material("shiny", model="phong", exponent=exponent), rt.Material("dull", model="lambert")],
        lights=[rt.DirectionalLight("sun", direction=(-1, -1, -2), shadows=False)],
    )


def mirrors(model="mirror", depth: int = 4, **parameters) -> rt.Scene:
    """A ball of a given model above a floor, under a sun and a sky."""
    return rt.Scene(
        camera=camera(),
        shapes=[
            rt.Sphere(centre=(0, 0, 0), radius=1, material="ball"),
            rt.Rectangle(centre=(0, -1.2, 0), edge_u=(8, 0, 0), edge_v=(0, 0, -8), material="floor"),
        ],
        materials=[rt.Material("ball", model=model, **parameters), rt.Material("floor", model="lambert")],
        lights=[rt.DirectionalLight("sun", direction=(-1, -2, -1)), rt.AmbientLight("sky")],
        depth=depth,
    )


def hall_of_mirrors(depth: int, tilt: float = 0.1) -> rt.Scene:
    """Two mirrors that face each other, slightly tilted, each with a little paint."""
    return rt.Scene(
        camera=rt.Camera(position=(0.3, 0.2, 0), target=(0, 0, -1), width=16, height=16, field_of_view=50),
        shapes=[
            rt.Rectangle(centre=(0, 0, -2), edge_u=(9, 0, 2 * tilt), edge_v=(0, 9, 0), material="front"),
            rt.Rectangle(centre=(0, 0, 2), edge_u=(-9, 0, 0), edge_v=(0, 9, tilt), material="back"),
        ],
        materials=[
            rt.Material("front", model=["lambert", "mirror"]),
            rt.Material("back", model=["lambert", "mirror"]),
        ],
        lights=[rt.PointLight("lamp", position=(0, 1, 0.5)), rt.AmbientLight("sky")],
        depth=depth,
    )


def lamps(count: int, size: int = 24) -> rt.Scene:
    """A ball above a floor, under a number of lamps that cast shadows."""
    ring = 2 * math.pi / count
    places = [(2 * math.cos(k * ring), 3 + k / count, 2 * math.sin(k * ring)) for k in range(count)]
    return rt.Scene(
        camera=camera(size),
        shapes=[
            rt.Sphere(centre=(0, 0, 0), radius=1, material="ball"),
            rt.Rectangle(centre=(0, -1.2, 0), edge_u=(8, 0, 0), edge_v=(0, 0, -8), material="floor"),
        ],
        materials=[rt.Material("ball", model="phong", exponent=20), rt.Material("floor", model="lambert")],
        lights=[rt.PointLight(f"lamp{k}", position=place) for k, place in enumerate(places)],
    )
