"""SymPy all the way: trees of pixels, expanded to linear forms, lambdified into a coefficient matrix (step 2).

This is the paper's §4 taken at its word, one pixel at a time: the teaching version, and the proof that the array path
in `collapse` does the same.  It is hundreds of times slower.
"""

from collections.abc import Iterable, Mapping

import sympy
from scipy import sparse

from symrt.interactions import Interaction, normal_order
from symrt.linear.formulas import Formula
from symrt.linear.functions import function_of
from symrt.reflection.symbols import Factor, Hat, Light, Ordered, Reflectance, lobe_value
from symrt.symbols import Symbol
from symrt.system import LinearSystem
from symrt.windows import EVERYWHERE, SpectralWindow


def linear_form(expression: sympy.Expr) -> dict[Interaction, sympy.Expr]:
    """The coefficient of each product of one light, some reflectances, and perhaps a window of wavelengths.

    Raises
    ------
    ValueError
        If a term has no light, several lights or windows, or is not a product of powers of its symbols.

    Examples
    --------
    >>> from symrt.reflection.symbols import n_dot_l
    >>> lit = Light("sun") * (Reflectance("sea.diffuse") + Reflectance("sea.specular")) * n_dot_l
    >>> {str(interaction): coefficient for interaction, coefficient in linear_form(lit).items()}
    {'sun*sea.diffuse': n_dot_l, 'sun*sea.specular': n_dot_l}

    A power that is no whole number is the length of a way through glass:

    >>> [str(interaction) for interaction in linear_form(Light("sun") * Reflectance("wine.transmittance") ** 1.5)]
    ['sun*wine.transmittance**1.5']
    """
    form: dict[Interaction, list[sympy.Expr]] = {}
    dynamic = expression.atoms(Light, Reflectance, Hat)
    for term in sympy.Add.make_args(sympy.expand(expression, deep=True, power_base=False, power_exp=False)):
        if term == 0:
            continue
        coefficient, product = term.as_independent(*dynamic, as_Add=False)
        form.setdefault(_interaction(product), []).append(coefficient)
    return {interaction: sympy.Add(*form[interaction]) for interaction in sorted(form)}


def coefficient_matrix(
    formulas: Iterable[Formula], width: int, height: int, white: Mapping[str, float]
) -> LinearSystem:
    """Collapse pixels' formulas, row by row from the top, into a linear system.

    The formulas come from `expressions`, or are a user's own.

    Examples
    --------
    >>> grey = Formula(Light("sun") * Reflectance("sea.diffuse") / 4)
    >>> coefficient_matrix([grey], 1, 1, {"sun": 1.0}).G.toarray()
    array([[0.25]])
    """
    rows = [_coefficients(pixel) for pixel in formulas]
    interactions = sorted({interaction for row in rows for interaction in row})
    column = {interaction: j for j, interaction in enumerate(interactions)}
    matrix = sparse.lil_array((len(rows), len(interactions)))
    for n, row in enumerate(rows):
        for interaction, g in row.items():
            matrix[n, column[interaction]] = g
    return LinearSystem(matrix.tocsr(), tuple(interactions), height, width, dict(white))


def _coefficients(pixel: Formula) -> dict[Interaction, float]:
    # Lengths of ways through glass are letters: with their values each is a column of its own.
    lengths = {
        letter
        for power in pixel.expression.atoms(sympy.Pow)
        if isinstance(power.base, Reflectance)
        for letter in power.exp.atoms(Factor)
    }
    settled = {letter: sympy.Float(pixel.values[letter.name]) for letter in lengths}
    form = linear_form(pixel.expression.xreplace(settled) if settled else pixel.expression)
    function = function_of([Factor(name) for name in pixel.values], list(form.values()), lobe_value)
    values = function(*pixel.values.values())
    return {interaction: float(g) for interaction, g in zip(form, values, strict=True) if g != 0}


def _interaction(product: sympy.Expr) -> Interaction:
    # The factors by their kind.
    lights: list[str] = []
    met: list[str] = []
    windows: list[str] = []
    powers: list[tuple[str, float]] = []
    for factor in sympy.Mul.make_args(product):
        base, power = factor.as_base_exp()
        if isinstance(base, Reflectance) and power.is_Float and power > 0:
            powers.append((base.name, float(power)))
            continue
        if powers and isinstance(base, Ordered) and Symbol.of(base.name).fluorescent:
            raise ValueError(f"{product}: columns keep powers of glass next to the eye, and {base} is nearer")
        if not isinstance(base, Light | Reflectance | Hat) or not (power.is_Integer and power > 0):
            raise ValueError(f"{product} is not a product of powers of lights and reflectances; expand it first")
        (lights if isinstance(base, Light) else windows if isinstance(base, Hat) else met).extend(
            [base.name] * int(power)
        )

    # One light, at most one window, and reflectances in their order.
    if len(lights) != 1:
        raise ValueError(f"{product} has {len(lights)} lights: every path of light starts at exactly one")
    if len(windows) > 1:
        raise ValueError(f"{product} has {len(windows)} windows of wavelengths: light is in one, or in none")
    window = SpectralWindow.of(windows[0]) if windows else EVERYWHERE
    return Interaction(lights[0], normal_order(met), window=window, powers=tuple(sorted(powers)))
