"""symrt: a symbolic spectral ray tracer.

A scene is rendered once, with every light and material left free as symbols, and then answers without rendering again.
The public names are grouped by the five steps of the method; each loads on first use, so that ``import symrt`` is
quick.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_NAMES = {
    # What is there
    "symrt.scene": [
        "Camera",
        "Material",
        "Scene",
        "glasses",
        "load_scene",
        "refractive_index",
        "shipped_scene",
        "AmbientLight",
        "DirectionalLight",
        "DiskLight",
        "Environment",
        "Illumination",
        "PointLight",
        "Interreflection",
        "RectangleLight",
        "SphereLight",
        "SurfaceLight",
    ],
    "symrt.geometry": [
        "Box",
        "Cylinder",
        "Disk",
        "Mesh",
        "Plane",
        "Rectangle",
        "Sphere",
        "TriangleMesh",
        "BandedRelief",
        "Checker",
        "LabelImage",
        "WeightImage",
    ],
    "symrt.reflection": ["MODELS", "Model", "lobe", "parameter", "reflectance", "schlick", "stack"],
    # 1 and 2: trace, collapse, print
    "symrt.tracing": ["RayTree", "probe", "trace"],
    "symrt.linear": [
        "Formula",
        "coefficient_matrix",
        "collapse",
        "estimate",
        "expressions",
        "formula",
        "linear_form",
        "merge_parts",
        "plan",
        "render",
        "render_part",
    ],
    "symrt.saving": ["load_system", "save_system"],
    "symrt.interactions": ["Interaction"],
    "symrt.system": ["LinearSystem"],
    "symrt.estimates": ["Estimate"],
    # 3: shade
    "symrt.spectra": [
        "RGB",
        "bell",
        "clipped",
        "Bands",
        "Fluorescence",
        "Palette",
        "Reference",
        "SpectralImage",
        "conductor_reflectance",
        "load_palettes",
        "metals",
        "optical_constants",
        "preview",
        "save_image",
        "save_palettes",
        "shade",
        "spectrum",
        "srgb",
        "to_rgb",
        "wavelengths",
    ],
    # 4: basis and gamut
    "symrt.device": ["Device", "devices", "fit_halftone", "load_device"],
    "symrt.gamut": ["Basis", "Gamut", "basis_report", "device_gamut", "intersection", "load_gamut", "save_gamut"],
    # 5: feedback
    "symrt.feedback": [
        "Blend",
        "Exposure",
        "Scale",
        "adapt",
        "clip",
        "feasible",
        "fit",
        "joint_region",
        "map_pixels",
        "pixels_of",
        "report",
        "safe_box",
        "split",
        "with_region",
    ],
    # Looking
    "symrt.show": ["plots"],
    "symrt.errors": ["SceneError"],
}
_ROOM = {name: room for room, names in _NAMES.items() for name in names}

__all__ = ["__version__", *sorted(_ROOM)]  # noqa: PLE0604 -- the names above are strings


def __getattr__(name: str) -> Any:
    if name not in _ROOM:
        raise AttributeError(f"symrt has no {name!r}; its public names are {', '.join(sorted(_ROOM))}")
    return getattr(import_module(_ROOM[name]), name)


def __dir__() -> list[str]:
    return __all__
