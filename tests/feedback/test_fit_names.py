"""Fits do not depend on names or order: of scales, materials, interactions and pixels."""

from dataclasses import replace

import numpy as np
import pytest
from feedback.synthetic import MATTE, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback import Scale, fit
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference

IMAGE, COLOURS = system(height=5, width=10), palette()
MATERIALS, FEW = ("brass", *MATTE), ("key", "brass", "ice")
LIGHTEST, DARKEST = (device_gamut(load_device("dye3-endura-premier"), "envelope", b) for b in ("clip", "luminance"))


def called(numbers):
    """The same picture with materials of other names, its interactions where these come in order."""
    new = {material: f"m{k}" for material, k in zip(MATERIALS, numbers, strict=True)}

    def renamed(symbol):
        material, dot, component = symbol.partition(".")
        return new.get(material, material) + dot + component

    columns = [Interaction(i.light, tuple(sorted(map(renamed, i.met)))) for i in IMAGE.interactions]
    order = sorted(range(len(columns)), key=lambda k: columns[k])
    image = replace(IMAGE, G=IMAGE.G[:, order], interactions=tuple(columns[k] for k in order))
    return image, Palette(COLOURS.bands, {renamed(n): COLOURS[n] for n in sorted(COLOURS, key=renamed)}), renamed


def asked(goal, share, image, colours, scales):
    options = {"allowed_out": share, "allowed_dark": share, "cap": False, "least_luminance": 0}
    gamut = DARKEST if goal == "darkest" else LIGHTEST
    options["reference"] = Reference("key", exposure=4.0)
    return fit(image, colours, gamut, [Scale(s) for s in scales], objective=goal, **options)


@pytest.mark.parametrize("share", [0.0, 0.08])
@pytest.mark.parametrize("goal", ["lightest", "darkest", "closest", "lexicographic", "brightest", "contrast"])
def test_order_and_names_do_not_matter(goal, share):
    random = np.random.default_rng(1)
    first = asked(goal, share, IMAGE, COLOURS, FEW)
    assert len(set(first.values.values())) > 1
    image, colours, renamed = called(random.permutation(len(MATERIALS)))
    order = random.permutation(IMAGE.width * IMAGE.height)
    image = replace(image, G=sparse.csr_array(image.G[order]))
    assert [n.met for n in image.interactions] != [n.met for n in IMAGE.interactions]
    other = asked(goal, share, image, colours, [renamed(name) for name in random.permutation(FEW)])
    # Programmes in another order round otherwise, and a search for the best nearby ends where a step brings 1e-7.
    rounding = 1e-9 if first.optimum == "global" else 1e-5
    assert [other.values[renamed(n)] for n in FEW] == pytest.approx([first.values[n] for n in FEW], rel=rounding)
    assert [other.reasons[renamed(n)].side for n in FEW] == [first.reasons[n].side for n in FEW]
    assert np.array_equal(np.sort(order[other.left_out]), np.sort(first.left_out))
    assert len(first.left_out) or not share or goal == "darkest"
