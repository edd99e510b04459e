"""Figures: the gamut with its segments (Figure 1 of the paper), feasible ranges with their reasons, and more.

Every function returns a matplotlib ``Figure`` and touches none of matplotlib's global state: save it, or let a notebook
show it.  Matplotlib is imported nowhere else.
"""

from symrt.show.plots.adapting import adapted_figure, mapped_figure
from symrt.show.plots.basis import basis_figure
from symrt.show.plots.bodies import body_figure, colours_figure, prints_figure
from symrt.show.plots.feedback import curve_figure, out_of_gamut_map, ranges_figure
from symrt.show.plots.fits import fit_figure
from symrt.show.plots.gallery import gallery_figure
from symrt.show.plots.gamut import gamut_figure, segments_figure, solids_figure
from symrt.show.plots.region import joint_region_figure
from symrt.show.plots.style import png

__all__ = [
    "adapted_figure",
    "basis_figure",
    "body_figure",
    "colours_figure",
    "curve_figure",
    "fit_figure",
    "gallery_figure",
    "gamut_figure",
    "joint_region_figure",
    "mapped_figure",
    "out_of_gamut_map",
    "png",
    "prints_figure",
    "ranges_figure",
    "segments_figure",
    "solids_figure",
]
