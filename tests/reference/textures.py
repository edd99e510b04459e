"""Textures: each is a closure that gives the weights of materials at a hit."""

import math
from pathlib import Path

import imageio.v3 as imageio
import numpy as np

from reference.records import Hit, Table, Texture

RELIEF = Path(__file__).parents[2] / "symrt" / "data" / "relief_30min.npz"


def checker(table: Table) -> Texture:
    def weights(hit: Hit) -> dict[str, float]:
        steps = sum(math.floor(x * length / table["size"]) for x, length in zip(hit.uv, hit.extent, strict=True))
        return {table["materials"][steps % 2]: 1.0}

    return weights


def banded_relief(table: Table) -> Texture:
    with np.load(RELIEF) as file:
        rows: list[list[int]] = file["e"].tolist()
    levels, materials, blend = table["levels"], table["materials"], table["blend"]

    def height(u: float, v: float) -> float:
        """Metres, bilinear between the centres of cells; row 0 is the southernmost, column 0 begins at 180° W."""
        x, y = u * len(rows[0]) - 0.5, (1 - v) * len(rows) - 0.5
        y = min(max(y, 0.0), len(rows) - 1.0)
        column, row = math.floor(x), min(math.floor(y), len(rows) - 2)
        right, up = x - column, y - row
        west, east = column % len(rows[0]), (column + 1) % len(rows[0])
        south = rows[row][west] * (1 - right) + rows[row][east] * right
        north = rows[row + 1][west] * (1 - right) + rows[row + 1][east] * right
        return south * (1 - up) + north * up

    def weights(hit: Hit) -> dict[str, float]:
        e = height(*hit.uv)
        above = [1.0, *(min(max((e - level + blend) / (2 * blend), 0.0), 1.0) for level in levels), 0.0]
        return {name: above[k] - above[k + 1] for k, name in enumerate(materials) if above[k] > above[k + 1]}

    return weights


def label_image(table: Table, folder: Path) -> Texture:
    """The element that the point falls in, u to the right and v down from the top, holds the number of its material."""
    pixels = imageio.imread(folder / table["file"]).tolist()

    def weights(hit: Hit) -> dict[str, float]:
        row = pixels[math.floor(hit.uv[1] * len(pixels)) % len(pixels)]
        return {table["materials"][row[math.floor(hit.uv[0] * len(row)) % len(row)]]: 1.0}

    return weights


def weight_image(table: Table, folder: Path) -> Texture:
    """Each element's channels, divided by their sum, are weights; between the elements' centres they are blended.

    One channel serves two materials: black is the first, white the second.
    """
    pixels = imageio.imread(folder / table["file"])
    most = np.iinfo(pixels.dtype).max
    rows = [[[most - p, p] if isinstance(p, int) else p for p in row] for row in pixels.tolist()]

    def weights(hit: Hit) -> dict[str, float]:
        x, y = hit.uv[0] * len(rows[0]) - 0.5, hit.uv[1] * len(rows) - 0.5
        right, down = x - math.floor(x), y - math.floor(y)
        shares = dict.fromkeys(table["materials"], 0.0)
        for i, share_of_column in ((0, 1 - right), (1, right)):
            for j, share_of_row in ((0, 1 - down), (1, down)):
                channels = rows[(math.floor(y) + j) % len(rows)][(math.floor(x) + i) % len(rows[0])]
                for name, part in zip(table["materials"], channels, strict=True):
                    shares[name] += share_of_column * share_of_row * part / sum(channels)
        return shares

    return weights
