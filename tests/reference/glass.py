"""Glass: the rays that a smooth surface between air and a medium sends on, by Snell's law and Fresnel's formulas."""

import json
import math
from pathlib import Path

from reference.records import Hit, Ray, Table
from reference.vectors import Vector, add, dot, mirrored, scale, unit

GLASSES = Path(__file__).parents[2] / "symrt" / "data" / "glasses.json"


def index_at(material: Table, nm: float | None) -> float:
    """The index of a material at a wavelength; None for media whose index is the same at all.

    Examples
    --------
    >>> index_at({"cauchy": [1.5, 0.004]}, 500.0)
    1.516
    """
    if "index" in material:
        return material["index"]
    micrometres = nm / 1000
    if "cauchy" in material:
        return sum(number / micrometres ** (2 * k) for k, number in enumerate(material["cauchy"]))
    pairs = material.get("sellmeier")
    if pairs is None:
        medium = json.loads(GLASSES.read_text(encoding="utf-8"))[material["glass"]]
        pairs = medium.get("B, C") or [(b, root * root) for b, root in medium["B, √C"]]
    square = micrometres * micrometres
    return math.sqrt(1 + sum(b * square / (square - c) for b, c in pairs))


def wavelengths_traced(file: Table) -> list[float]:
    """The wavelengths that are traced by themselves in a scene file: none where no index changes with them."""
    if all({"glass", "sellmeier", "cauchy"}.isdisjoint(table) for table in file["materials"].values()):
        return []
    windows = file.get("windows", 6)
    if isinstance(windows, list):
        return [float(nm) for nm in windows]
    return [float(round(380 + k * 350 / (windows - 1))) for k in range(windows)]


def glass_rays(hit: Hit, to_eye: Vector, index: float) -> list[Ray]:
    """The mirrored ray and the bent one, each with its share of unpolarised light."""
    here, beyond = (index, 1.0) if hit.from_inside else (1.0, index)
    cos_i = dot(hit.shading, to_eye)
    sin_t = here / beyond * math.sqrt(max(0.0, 1 - cos_i * cos_i))
    onward = mirrored(to_eye, hit.shading)
    if sin_t > 1:
        return [Ray("reflected", onward)]
    cos_t = math.sqrt(1 - sin_t * sin_t)
    across = (here * cos_i - beyond * cos_t) / (here * cos_i + beyond * cos_t)
    along = (beyond * cos_i - here * cos_t) / (beyond * cos_i + here * cos_t)
    share = (across**2 + along**2) / 2
    bent = add(scale(-here / beyond, to_eye), scale(here / beyond * cos_i - cos_t, hit.shading))
    return [Ray("reflected", onward, share), Ray("transmitted", unit(bent), 1 - share)]
