"""The tiles that a picture is rendered in: their size depends on the scene alone (steps 1 and 2)."""

from symrt.errors import shown

Window = tuple[int, int, int, int]

SAMPLES = 65536
"""Film samples in a tile, at most: enough to amortise NumPy's calls, between each of which threads hand over Python's
lock, and few enough to stay in cache and be shared out."""
RAYS = 1 << 19
"""Rays in a tile, at most, as far as the plan expects them: a tree keeps some hundred bytes of each."""


def tiles(
    width: int, height: int, rays_a_pixel: int, rays_a_sample: int = 1, rows: tuple[int, int] | None = None
) -> list[Window]:
    """Windows that cover the film in the order of its pixels: bands of whole rows, or pieces of one that is too long.

    Parameters
    ----------
    rays_a_pixel
        Samples of the film in each pixel.
    rays_a_sample
        Rays that the plan expects for each of them.
    rows
        The first row and the one after the last, where only some are covered.

    Examples
    --------
    >>> tiles(512, 512, 1)[:2]
    [(0, 0, 512, 128), (0, 128, 512, 256)]
    >>> tiles(512, 512, 1, rays_a_sample=64)[0], tiles(512, 512, 1, rows=(500, 512))
    ((0, 0, 512, 16), [(0, 500, 512, 512)])
    """
    first, last = rows or (0, height)
    samples = min(SAMPLES, max(1, RAYS // rays_a_sample))
    across = max(1, min(width, samples // rays_a_pixel))
    down = max(1, samples // (across * rays_a_pixel)) if across == width else 1
    return [
        (x, y, min(x + across, width), min(y + down, last))
        for y in range(first, last, down)
        for x in range(0, width, across)
    ]


def rows_of(part: tuple[int, int], height: int) -> tuple[int, int]:
    """The first row of a part, and the one after its last.

    Examples
    --------
    >>> [rows_of((k, 3), 8) for k in (1, 2, 3)]
    [(0, 2), (2, 5), (5, 8)]
    """
    number, count = part
    if not 1 <= number <= count <= height:
        raise ValueError(
            f"part {shown(number)}/{shown(count)}: parts run from 1/n to n/n, and the picture's {height} rows make at "
            f"most {height}: give another"
        )
    return height * (number - 1) // count, height * number // count
