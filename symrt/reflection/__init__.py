"""Models of reflection, each of them its formulas (step 1)."""

from symrt.reflection.metals import f82, schlick
from symrt.reflection.models import MODELS, Model, stack
from symrt.reflection.symbols import (
    diffuse,
    fluorescence,
    h_dot_v,
    l_dot_v,
    lobe,
    mirror,
    n_dot_h,
    n_dot_l,
    n_dot_v,
    parameter,
    r_dot_v,
    reflectance,
    specular,
)

__all__ = [
    "MODELS",
    "Model",
    "diffuse",
    "f82",
    "fluorescence",
    "h_dot_v",
    "l_dot_v",
    "lobe",
    "mirror",
    "n_dot_h",
    "n_dot_l",
    "n_dot_v",
    "parameter",
    "r_dot_v",
    "reflectance",
    "schlick",
    "specular",
    "stack",
]
