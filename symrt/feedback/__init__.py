"""Step 5: what the gamut says about the parameters."""

from symrt.feedback.joint.adapted import Adapted, Criteria, Step
from symrt.feedback.joint.adapting import adapt
from symrt.feedback.joint.boxes import SafeBox
from symrt.feedback.joint.fits import fit
from symrt.feedback.joint.fitted import Fit
from symrt.feedback.joint.freedom import safe_box
from symrt.feedback.joint.joint_region import joint_region
from symrt.feedback.joint.pairs import JointRegion
from symrt.feedback.parameters import Blend, Exposure, Scale
from symrt.feedback.pixelwise import Mapped, map_pixels
from symrt.feedback.ranges import feasible
from symrt.feedback.reasons import Feasible, Reason
from symrt.feedback.regions import split, with_region
from symrt.feedback.report import Report, Verdict, report
from symrt.feedback.sensitivity import Move, Sensitivity
from symrt.feedback.weighing import pixels_of
from symrt.gamut.clipping import Interval
from symrt.gamut.interface import clip

__all__ = [
    "Adapted",
    "Blend",
    "Criteria",
    "Exposure",
    "Feasible",
    "Fit",
    "Interval",
    "JointRegion",
    "Mapped",
    "Move",
    "Reason",
    "Report",
    "SafeBox",
    "Scale",
    "Sensitivity",
    "Step",
    "Verdict",
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
]
