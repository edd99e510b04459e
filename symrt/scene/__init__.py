"""The parts of a scene: shapes, materials, lights and a camera, from Python or from a file (before step 1)."""

from symrt.reading import shipped_scene
from symrt.scene.area_lights import DiskLight, RectangleLight, SphereLight
from symrt.scene.cameras import Camera, Window, camera_rays
from symrt.scene.files import load_scene
from symrt.scene.interreflection import Interreflection
from symrt.scene.lights import AmbientLight, DirectionalLight, Illumination, Light, PointLight
from symrt.scene.materials import Material
from symrt.scene.media import glasses, refractive_index
from symrt.scene.records import Scene
from symrt.scene.sky import Environment, SkyRegion
from symrt.scene.surface_lights import SurfaceLight

__all__ = [
    "AmbientLight",
    "Camera",
    "DirectionalLight",
    "DiskLight",
    "Environment",
    "Illumination",
    "Interreflection",
    "Light",
    "Material",
    "PointLight",
    "RectangleLight",
    "Scene",
    "SkyRegion",
    "SphereLight",
    "SurfaceLight",
    "Window",
    "camera_rays",
    "glasses",
    "load_scene",
    "refractive_index",
    "shipped_scene",
]
