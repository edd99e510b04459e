"""A report says what asking each gamut pixel by pixel says, and which pixel is farthest outside."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import palettes, small
from scipy import sparse

import symrt as rt
from symrt.device import load_device, load_monitor
from symrt.feedback import report
from symrt.gamut import device_gamut, monitor_gamut
from symrt.interactions import Interaction
from symrt.spectra.library import colour_science


@pytest.fixture(scope="module")
def asked():
    system, palette = rt.render(small("globe", 48), progress=False), palettes("globe")["macbeth"]
    device = load_device("dye3-endura-premier")
    gamuts = [device_gamut(device, model) for model in ("unit", "envelope", "hull", "colorimetric")]
    gamuts.append(monitor_gamut(load_monitor("crt-brainard").on(palette.bands)))
    white = rt.Reference().white(system, palette)
    seen = rt.shade(system, palette).values.reshape(-1, 36) / white
    return system, palette, gamuts, white, seen


def test_shares_and_worst_pixels_are_those_of_each_gamut(asked):
    system, palette, gamuts, white, seen = asked
    objects = np.flatnonzero(system.object_pixels)
    said = report(system, palette, gamuts)
    assert said.asked == said.objects == objects.size
    for gamut, verdict in zip(gamuts, said.verdicts, strict=True):
        under = gamut.under(white)
        inside = under.contains(seen[objects])
        assert verdict.inside == inside.mean()
        assert verdict.label == gamut.label
        if verdict.worst is not None:
            x, y = verdict.worst
            violation = under.violation(seen[objects])
            assert verdict.violation == pytest.approx(violation.max(), rel=1e-12)
            assert under.violation(seen[[y * 48 + x]])[0] == pytest.approx(violation.max(), rel=1e-12)


def test_shares_of_materials_count_the_pixels_that_they_light(asked):
    system, palette, gamuts, white, seen = asked
    verdict = report(system, palette, [gamuts[3]]).verdicts[0]
    inside = gamuts[3].under(white).contains(seen)
    brass = [j for j, i in enumerate(system.interactions) if any(s.startswith("brass.") for s in i.met)]
    own = np.diff(system.G[:, brass].indptr) > 0
    assert verdict.materials["brass"] == pytest.approx(inside[own].mean(), rel=1e-15)


def test_a_monitor_and_a_printer_disagree_as_counted(asked):
    # The paper, §2: "perfecting an image on a monitor may be counterproductive" for print.
    system, palette, gamuts, white, seen = asked
    objects = np.flatnonzero(system.object_pixels)
    shown = gamuts[-1].under(white).contains(seen[objects])
    printed = gamuts[2].under(white).contains(seen[objects])
    verdict = report(system, palette, gamuts).verdicts[2]
    assert verdict.contented[gamuts[-1].name] == ((shown & ~printed).mean(), (~shown & printed).mean())
    assert verdict.contented[gamuts[-1].name][0] > 0.5


def test_a_large_image_is_asked_evenly_and_says_so(asked):
    system, palette, gamuts, *_ = asked
    said = report(system, palette, gamuts[:2], most=100)
    assert said.asked == 100
    assert "100 of" in str(said)
    assert "drawn evenly" in said._repr_html_()


def test_one_pixel_outside_is_never_rounded_away(asked):
    system, palette, gamuts, *_ = asked
    said = report(system, palette.replace(key=0.999 * palette["key"]), gamuts[:2])
    for verdict, row in zip(said.verdicts, said.rows, strict=True):
        assert (row[1] == "100.0%") == (verdict.inside == 1)


def test_a_coefficient_of_zero_contributes_nothing(asked):
    """A stored one, as a file may hold."""
    columns = tuple(Interaction("key", (f"{name}.diffuse",)) for name in ("ice", "sea"))
    stored = sparse.csr_array(np.array([[0.5, 1.0], [1.0, 0.5]]))
    stored.data[[1, 2]] = 0.0
    system = rt.LinearSystem(stored, columns, 1, 2, white={"key": 1.0})
    palette = rt.Palette(asked[1].bands, {"key": 1.0, "ice.diffuse": 0.9, "sea.diffuse": 0.1})
    bright = replace(system, white={"key": 0.4})
    assert report(bright, palette, asked[2][:1]).verdicts[0].materials == {"ice": 0.0, "sea": 1.0}


def test_other_bands_are_refused(asked):
    system, palette, *_ = asked
    other = device_gamut(load_device("dye3-endura-premier", rt.wavelengths(400, 700, 20)), "unit")
    with pytest.raises(ValueError, match="same bands"):
        report(system, palette, [other])


def test_a_black_picture_is_inside_every_gamut(asked):
    system, palette, gamuts, *_ = asked
    said = report(replace(system, G=sparse.csr_array(system.G.shape)), palette, gamuts)
    assert (said.asked, said.objects) == (0, 0)
    assert all((verdict.inside, verdict.worst) == (1.0, None) for verdict in said.verdicts)


@pytest.mark.parametrize("most", [0, -5])
def test_asking_about_no_pixels_proves_nothing_and_is_refused(asked, most):
    system, palette, gamuts, *_ = asked
    with pytest.raises(ValueError, match=f"most = {most}: it is how many pixels are asked about, 1 or more"):
        report(system, palette, gamuts[:1], most=most)
    with pytest.raises(ValueError, match=f"most = {most}"):
        rt.feasible(system, palette, gamuts[2], rt.Exposure(), most=most)
    with pytest.raises(ValueError, match=f"most = {most}"):
        rt.adapt(system, palette, gamuts[2], [], most=most, progress=False)


def test_a_report_fits_a_terminal_and_says_each_long_name_once(asked):
    system, palette, gamuts, *_ = asked
    twice = [*gamuts, device_gamut(load_device("synthetic-cmyk"), "colorimetric")]
    said = report(system, palette, twice)
    assert [verdict.short for verdict in said.verdicts[3:]] == ["colorimetric 1", "monitor", "colorimetric 2"]
    lines = repr(said).splitlines()
    assert max(map(len, lines)) <= 80
    text = " ".join(repr(said).split())
    for verdict in said.verdicts:
        assert text.count(verdict.gamut) == said._repr_html_().replace("&#x27;", "'").count(verdict.gamut) == 1


def test_where_colours_are_asked_the_worst_pixel_is_told_in_ciede2000(asked):
    system, palette, gamuts, _, seen = asked
    colour = colour_science()
    verdicts = report(system, palette, gamuts).verdicts
    assert [verdict.delta_e is None for verdict in verdicts] == [True, True, True, False, False]
    x, y = verdicts[3].worst
    spectrum = seen[[y * 48 + x]]
    pair = np.vstack([spectrum, gamuts[3].nearest(spectrum)]) @ gamuts[3].observer
    d50 = gamuts[3].observer.sum(axis=0)
    lab = colour.XYZ_to_Lab(pair, colour.XYZ_to_xy(d50))
    # The white of our bands is theirs, the illuminant's xy, up to what the bands sample: some 1e-3.
    assert verdicts[3].delta_e == pytest.approx(float(colour.delta_E(lab[0], lab[1], method="CIE 2000")), rel=5e-3)
    assert f"{verdicts[3].delta_e:.3g} ΔE00" in repr(report(system, palette, gamuts))
