"""Step 2: collapse the tree of rays into a linear system."""

from symrt.linear.collapse import collapse
from symrt.linear.estimate import Estimate, estimate
from symrt.linear.formulas import Expressions, Formula, expressions, formula
from symrt.linear.literal import coefficient_matrix, linear_form
from symrt.linear.parts import merge_parts, render_part
from symrt.linear.planning import plan
from symrt.linear.render import render

__all__ = [
    "Estimate",
    "Expressions",
    "Formula",
    "coefficient_matrix",
    "collapse",
    "estimate",
    "expressions",
    "formula",
    "linear_form",
    "merge_parts",
    "plan",
    "render",
    "render_part",
]
