"""Scene files and palettes, read directly."""

import importlib
import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np

from reference.glass import glass_rays, index_at, wavelengths_traced
from reference.lamps import rectangle_lamp
from reference.lights import directional_light, point_light
from reference.meshes import mesh
from reference.records import Hit, Ray, Scene, Spectrum, Table
from reference.round_lamps import disk_lamp, sphere_lamp
from reference.shapes import box, cylinder, disk, plane, rectangle, sphere
from reference.sky import seen_sky, sky_lamps
from reference.textures import banded_relief, checker, label_image, weight_image
from reference.tracer import mirror_ray
from reference.vectors import Vector

METALS = Path(__file__).parents[2] / "symrt" / "data" / "metals.json"


def load(path: str | Path, nm: float | None = None) -> Scene:
    """Read a scene file, which is taken to be right: symrt is the one that checks.

    Glass has the index of one wavelength, in nm.
    """
    file, folder = tomllib.loads(Path(path).read_text()), Path(path).parent
    kinds = {"sphere": sphere, "plane": plane, "disk": disk, "rectangle": rectangle, "cylinder": cylinder, "box": box}
    lights = {"point": point_light, "directional": directional_light}
    lamps = {"rectangle": rectangle_lamp, "disk": disk_lamp, "sphere": sphere_lamp}
    from_file = {"label_image": label_image, "weight_image": weight_image}
    computed = {"checker": checker, "banded_relief": banded_relief}
    textures = {
        name: from_file[t["type"]](t, folder) if t["type"] in from_file else computed[t["type"]](t)
        for name, t in file.get("textures", {}).items()
    }

    skies = {name: t for name, t in file["lights"].items() if t["type"] == "environment"}
    of_skies = {light: lamp for name, t in skies.items() for light, lamp in sky_lamps(name, t).items()}

    def onwards(hit: Hit, to_eye: Vector) -> list[Ray]:
        # Each glass bends for itself; all that mirror at a point send the same ray.
        there = textures[hit.material](hit) if hit.material in textures else {hit.material: 1.0}
        tables = {name: file["materials"][name] for name, weight in there.items() if weight > 0}
        glass = {name: index_at(table, nm) for name, table in tables.items() if of_glass(table)}
        rays = [
            ray._replace(of=frozenset({name}))
            for name, index in glass.items()
            for ray in glass_rays(hit, to_eye, index)
        ]
        return rays + [ray._replace(of=frozenset(tables) - set(glass)) for ray in mirror_ray(hit, to_eye)]

    return Scene(
        camera=file["camera"],
        shapes=[mesh(t, folder) if t["type"] == "mesh" else kinds[t["type"]](t) for t in file["shapes"]],
        lights={name: lights[t["type"]](t) for name, t in file["lights"].items() if t["type"] in lights},
        ambient=[name for name, t in file["lights"].items() if t["type"] == "ambient"],
        unshadowed={
            light
            for name, t in file["lights"].items()
            if not t.get("shadows", True)
            for light in (name, *(sky_lamps(name, t) if name in skies else ()))
        },
        materials=file["materials"],
        textures=textures,
        depth=file.get("depth", 4),
        sending=(onwards,),
        glowing={name: t["material"] for name, t in file["lights"].items() if t["type"] == "surface"},
        lanterns=tuple(
            kinds[t["type"]]({**t, "material": name}) for name, t in file["lights"].items() if t.get("visible")
        ),
        lamps={name: lamps[t["type"]](t) for name, t in file["lights"].items() if t["type"] in lamps} | of_skies,
        skies=tuple(seen_sky(name, t) for name, t in skies.items()),
        least=1e-3,
    )


def of_glass(material: Table) -> bool:
    """True if one of the models of a material is glass."""
    model = material.get("model", "lambert")
    return "glass" in (model if isinstance(model, list) else [model])


def traced(path: str | Path) -> list[float]:
    """The wavelengths of a scene file that are traced by themselves, in nm; none where it need not be."""
    return wavelengths_traced(tomllib.loads(Path(path).read_text()))


def grid_of(path: str | Path, name: str) -> list[float] | None:
    """The wavelengths of a palette's bands, in nm; None for red, green and blue."""
    bands = tomllib.loads(Path(path).read_text())["palettes"][name]["bands"]
    if bands == "rgb":
        return None
    return [bands[0] + k * bands[2] for k in range(round((bands[1] - bands[0]) / bands[2]) + 1)]


def load_palette(path: str | Path, name: str) -> dict[str, Spectrum]:
    """The spectra of a palette by symbol: numbers, lists, or names of tables in colour-science."""
    table, grid = tomllib.loads(Path(path).read_text())["palettes"][name], grid_of(path, name)
    return {
        symbol: matrix(value, grid) if symbol.endswith("fluorescence") else spectrum(value, grid)
        for symbol, value in table.items()
        if symbol not in ("bands", "reference-white")
    }


def matrix(value: Any, grid: list[float] | None) -> list[Spectrum]:
    """The matrix of some dyes, for evenly spaced wavelengths: what is taken in of each band, times what is given back.

    The energy taken in over a band's width is spread over all bands, in the proportions of the emission.
    """
    dyes = value if isinstance(value, list) else [value]
    total = [[0.0] * (3 if grid is None else len(grid)) for _ in (grid or "rgb")]
    for dye in dyes:
        taken, given = spectrum(dye["excitation"], grid), spectrum(dye["emission"], grid)
        for i, row in enumerate(total):
            for j in range(len(row)):
                row[j] += dye.get("efficiency", 1) * taken[i] * given[j] / math.fsum(given)
    return total


def spectrum(value: Any, grid: list[float] | None) -> Spectrum:
    """Values on a grid of wavelengths in nm; None stands for red, green and blue.

    A table is read at its own wavelengths only: what would have to be interpolated is a `KeyError`.

    Examples
    --------
    >>> spectrum(0.5, [400, 500])
    [0.5, 0.5]
    """
    if isinstance(value, int | float):
        return [float(value)] * (3 if grid is None else len(grid))
    if isinstance(value, list):
        return [float(x) for x in value]
    if isinstance(value, dict):
        part = bell(value, grid or []) if "peak" in value else spectrum(value["spectrum"], grid)
        return [value.get("scale", 1) * x for x in part]
    family, name = value.split("/")
    if family == "illuminant":
        light = colour_science().SDS_ILLUMINANTS[name]
        return [x / luminance(light) for x in on_grid(light, grid)]
    if family == "metal":
        return metal(name, grid)
    chart = colour_science().SDS_COLOURCHECKERS["BabelColor Average"]
    # A grey's notation and density may be left out: white is "white 9.5 (.05 D)".
    (patch,) = (
        sd
        for title, sd in chart.items()
        if name in (title, re.sub(r"( [\d.]+)? \(.*", "", title), title.split(" (")[0])
    )
    return on_grid(patch, grid)


def bell(value: Table, grid: list[float]) -> Spectrum:
    """A bell that is 1 at its peak, and 1/2 half its width beside it."""
    return [0.5 ** (((nm - value["peak"]) / (value["width"] / 2)) ** 2) for nm in grid]


def metal(name: str, grid: list[float] | None) -> Spectrum:
    """Reflectance along the normal, from n and k between the lines of the table."""
    nm, n, k = np.array(json.loads(METALS.read_text())[name]["nm, n, k"]).T
    assert grid is not None, "a table of wavelengths has no red, green and blue here"
    index = [complex(a, b) for a, b in zip(np.interp(grid, nm, n), np.interp(grid, nm, k), strict=True)]
    return [abs((1 - m) / (1 + m)) ** 2 for m in index]


def colour_science() -> Any:
    """The library, imported late: it takes a second, and would change how NumPy prints."""
    with np.printoptions():
        return importlib.import_module("colour")


def on_grid(table: Any, grid: list[float] | None) -> Spectrum:
    assert grid is not None, "a table of wavelengths has no red, green and blue here"
    measured = dict(zip(table.wavelengths.tolist(), table.values.tolist(), strict=True))
    return [measured[nm] for nm in grid]


def luminance(light: Any) -> float:
    """Of an illuminant, against an equal-energy light of constant 1: CIE 1931 2° observer, nm by nm."""
    observer = colour_science().MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    nm, y = observer.wavelengths, observer.values[:, 1]
    values = np.interp(nm, light.wavelengths, light.values, left=0, right=0)
    return math.fsum((values * y).tolist()) / math.fsum(y.tolist())
