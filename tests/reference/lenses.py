"""Places on a lens: points that fill a square evenly, brought to the unit disk."""

import math

from reference.records import Sample


def through_a_lens(samples: list[Sample], places: int, pixel: int) -> list[Sample]:
    """Each sample of a pixel as so many, each through a place on the lens; `pixel` is its number in the picture."""
    flips = hashed(pixel)
    found = []
    for k in range(len(samples) * places):
        u = (radical_inverse(k) ^ flips >> 32) + 0.5
        v = (sobol(k) ^ flips & 0xFFFFFFFF) + 0.5
        sample = samples[k // places]
        found.append(sample._replace(weight=sample.weight / places, lens=in_disk(u / 2**32, v / 2**32)))
    return found


def radical_inverse(k: int) -> int:
    """The 32 binary digits of a number, the last one first."""
    return int(f"{k:032b}"[::-1], 2)


def sobol(k: int) -> int:
    """The second coordinate: digit i of the number brings row i of Pascal's triangle modulo 2, from the left."""
    found = 0
    for i in range(k.bit_length()):
        if k >> i & 1:
            found ^= sum((math.comb(i, j) % 2) << (31 - j) for j in range(i + 1))
    return found


def hashed(n: int) -> int:
    """SplitMix64."""
    z = (n + 1) * 0x9E3779B97F4A7C15 % 2**64
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 % 2**64
    z = (z ^ z >> 27) * 0x94D049BB133111EB % 2**64
    return z ^ z >> 31


def in_disk(u: float, v: float) -> tuple[float, float]:
    """Shirley and Chiu's map, by polar coordinates in each of four triangles."""
    a, b = 2 * u - 1, 2 * v - 1
    if abs(a) > abs(b):
        radius, angle = a, math.pi / 4 * b / a
    else:
        radius, angle = b, math.pi / 2 - math.pi / 4 * a / b
    return radius * math.cos(angle), radius * math.sin(angle)
