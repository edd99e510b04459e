"""The body of a gamut in three components, in which Figure 1 of the paper draws its segments (step 4)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from symrt.arrays import Spectrum
from symrt.gamut.colorimetric import ColorimetricGamut
from symrt.gamut.gamuts import AnyGamut, device_gamut
from symrt.gamut.hull import HullGamut
from symrt.gamut.interface import SlabGamut
from symrt.gamut.intersections import AnyIntersection, SlabIntersection
from symrt.gamut.recipes import InkGamut
from symrt.gamut.slabs import Gamut
from symrt.gamut.views import Polyhedron, Shadow, convex_solid

FLAT = 1e-9
"""Ratio of thickness to length below which a body is flat: prints differ there by less than they are known."""
MIXTURES = "shadow (projection) of all mixtures of its prints"

Components = tuple[int, int, int]


@dataclass(frozen=True, eq=False)
class Body:
    """A solid among spectra.

    Parameters
    ----------
    vectors
        The three components that it is seen in.
    solid
        Its shape in these components.
    what
        A description in words.
    """

    vectors: Float[np.ndarray, "3 band"]
    solid: Polyhedron
    what: str


def body_of(gamut: AnyGamut | AnyIntersection | SlabGamut, components: Components = (0, 1, 2)) -> Body:
    """The solid that a gamut is drawn as: its shadow, or that of the prints or bounds it consists of.

    Raises
    ------
    ValueError
        If the gamut bounds colours only, or mixes models, so that it has no such body; or if the components are not
        different ones of its device's.

    Examples
    --------
    >>> from symrt.device import load_device
    >>> from symrt.gamut.hull import hull_gamut
    >>> device = load_device("dye3-endura-premier")
    >>> envelope, mixtures = body_of(device_gamut(device, "envelope")), body_of(hull_gamut(device))
    >>> envelope.what, envelope.solid.volume > mixtures.solid.volume
    ('shadow (projection) of the gamut', True)
    """
    if isinstance(gamut, Gamut):
        shadow, what = gamut.shadow(components), "the gamut"
    elif isinstance(gamut, HullGamut | InkGamut):
        # The hull of points: these gamuts have no slabs whose shadow could be taken.
        vectors = device_gamut(gamut.device, "envelope").shadow(components).vectors
        solid = _mixtures(gamut, vectors, components)
        near = f"(being within {gamut.tolerance:g} RMS of one is being inside)"
        mixed = "(not all of them can be printed)"
        return Body(vectors, solid, f"{MIXTURES} {near if isinstance(gamut, HullGamut) else mixed}")
    elif isinstance(gamut, ColorimetricGamut):
        # Colours alone bound no spectra.
        shadow, what = device_gamut(gamut.device, "envelope").shadow(components), "its device's envelope"
    elif isinstance(gamut, SlabIntersection) and all(isinstance(part, Gamut) for part in gamut.parts):
        # Devices have bases of their own: the first one's serves for all.
        vectors = device_gamut(gamut.devices[0], "envelope").shadow(components).vectors
        shadow, what = Shadow(vectors, *shared_bounds(gamut)), "what the gamuts share"
    else:
        raise ValueError(
            f"{gamut.name}: it has no body among spectra to draw segments in; draw them in a printer's unit, envelope, "
            "hull, inks or colorimetric gamut"
        )

    return Body(shadow.vectors, shadow.polyhedron(), f"shadow (projection) of {what}")


def _mixtures(gamut: HullGamut | InkGamut, vectors: Float[np.ndarray, "3 band"], components: Components) -> Polyhedron:
    """The solid of all mixtures of prints; prints that lie in a plane there are refused."""
    places = gamut.device.samples @ vectors.T
    sizes = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    if len(sizes) < len(vectors) or sizes[-1] <= FLAT * sizes[0]:
        raise ValueError(
            f"{gamut.name}: in components {components} its prints lie in a plane, or as good as: choose earlier "
            "components, in which prints differ more"
        )
    return convex_solid(places)


def shared_bounds(gamut: SlabIntersection) -> tuple[Spectrum, Spectrum]:
    """The lower and the upper bound of each band in an intersection of gamuts that bound bands."""
    slabs = gamut.slabs
    single = slabs.bands >= 0
    lower, upper = np.empty(len(gamut.bands)), np.empty(len(gamut.bands))
    lower[slabs.bands[single]], upper[slabs.bands[single]] = slabs.lower[single], slabs.upper[single]
    return lower, upper
