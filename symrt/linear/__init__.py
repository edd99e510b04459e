"""Step 2: collapse the tree of rays into a linear system."""

from symrt.linear.collapse import collapse
from symrt.linear.formulas import Expressions, Formula, expressions, formula
from symrt.linear.literal import coefficient_matrix, linear_form
from symrt.linear.render import render

__all__ = [
    "Expressions",
    "Formula",
    "coefficient_matrix",
    "collapse",
    "expressions",
    "formula",
    "linear_form",
    "render",
]
