"""The asking for light that goes from surface to surface (before step 1)."""

from dataclasses import dataclass

from symrt.errors import hinting, refuse
from symrt.scene.checks import check_whole

MOST_PATHS = 1 << 16
"""Largest number of paths."""
MOST_BOUNCES = 8
"""Largest number of bounces: for each there are four dimensions of the sequence that paths are drawn from."""


@hinting
@dataclass(frozen=True)
class Interreflection:
    """A scene's asking for diffuse interreflection: a scene without it is lit by its lights alone.

    Parameters
    ----------
    paths
        Number of paths that gather light at each hit that the camera sees, itself or in a mirror; 64 are a good
        picture, powers of 2 are spread most evenly.
    depth
        Number of times that light is reflected from surface to surface before the last one; what is beyond is bounded
        and estimated.

    Examples
    --------
    >>> Interreflection(paths=16)
    Interreflection(paths=16, depth=3)
    """

    paths: int = 64
    depth: int = 3

    def __post_init__(self) -> None:
        refuse(
            [*check_whole("paths", self.paths, MOST_PATHS), *check_whole("depth", self.depth, MOST_BOUNCES, least=0)]
        )
