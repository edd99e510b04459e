"""The loop that changes an image no more than its criteria ask: what it accepts is recomputed."""

import numpy as np
import pytest
from feedback.synthetic import BANDS, palette, system
from scipy import sparse
from scipy.interpolate import CubicSpline

from symrt.device import load_device
from symrt.device.colorimetry import tristimulus
from symrt.feedback import Scale, adapt, feasible
from symrt.feedback.parameters import Exposure, moved
from symrt.gamut import device_gamut, intersection
from symrt.interactions import Interaction
from symrt.spectra.bands import wavelengths
from symrt.spectra.library import colour_science, observer, spectrum
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.spectra.shading import shade
from symrt.system import LinearSystem

colour = colour_science()

DEVICE = load_device("dye3-endura-premier")
ENVELOPE = device_gamut(DEVICE, "envelope")
MIRRORED, COLOURS = system(height=12, width=16), palette()
FEW = [Scale("key"), Scale("fill"), Scale("brass"), Scale("ice")]
LIT = Reference("key", exposure=1.4)
OPTIONS = {"cap": False, "progress": False, "reference": LIT}


def reflected(values):
    return values.reshape(-1, 36)[MIRRORED.object_pixels] / LIT.white(MIRRORED, COLOURS) * LIT.exposure


def as_seen(reflectances):
    """L*a*b* under D50 by another library, of spectra interpolated to every nanometre."""
    nm, functions = observer()
    fine = wavelengths(380, 780, 1)
    weights = functions[(nm >= 380) & (nm <= 780)] * spectrum("illuminant/D50", fine, reflectance=False)[:, None]
    weights /= weights[:, 1].sum()
    spline = CubicSpline(BANDS.centres, reflectances.T, bc_type="natural")
    xyz = spline(np.clip(fine.centres, 380, 730)).T @ weights
    return colour.XYZ_to_Lab(xyz, colour.XYZ_to_xy(weights.sum(axis=0)))


def figures(image):
    """Share inside, mean difference, share of lightness."""
    given, now = (reflected(one.values) for one in (shade(MIRRORED, COLOURS), image))
    before, after = as_seen(given), as_seen(now)
    light = [np.minimum(one[:, 0], 100).mean() for one in (before, after)]
    # Pixels that were moved to the boundary are there to rounding.
    inside = (now <= ENVELOPE.upper + 1e-12).all(axis=1).mean()
    return inside, colour.delta_E(before, after, method="CIE 2000").mean(), light[1] / light[0]


ASKED = [
    ({}, "closest"),  # dimmed until every pixel is inside, less than half of the luminance would be left
    ({"least_luminance": 0.0}, "exposure"),
    ({"least_inside": 0.8}, "as given"),
    ({"least_lightness": 0.9}, "brightest"),
    ({"least_inside": 0.93, "most_difference": 2.0}, "exposure"),
    ({"least_inside": 0.95, "most_difference": 1.4}, "closest"),
    ({"most_difference": 4.0, "map_rest": True}, "as given, then pixel by pixel to the grey"),
]


@pytest.mark.parametrize(("asked", "means"), ASKED, ids=str)
def test_what_is_accepted_meets_the_criteria_as_another_library_sees_them(asked, means):
    found = adapt(
        MIRRORED,
        COLOURS,
        ENVELOPE,
        FEW[:2] if "most_difference" in asked and means == "closest" else FEW,
        **OPTIONS,
        **asked,
    )
    assert found.verdict == "reached"
    inside, difference, light = figures(found.image(MIRRORED))
    assert inside >= asked.get("least_inside", 1.0)
    assert difference <= asked.get("most_difference", np.inf) + 1e-6
    assert light >= asked.get("least_lightness", 0.0) - 1e-6
    step = found.accepted
    assert step is found.steps[-1]
    assert step.means == means
    assert (step.inside, step.difference, step.lightness) == pytest.approx((inside, difference, light), rel=1e-6)
    assert all(found.criteria.lacking(other) for other in found.steps[:-1])
    assert found.reachable == {}


def test_exposure_is_dimmed_no_further_than_the_image_needs():
    found = adapt(MIRRORED, COLOURS, ENVELOPE, FEW, **OPTIONS, least_luminance=0.0)
    assert [step.means for step in found.steps] == ["as given", "exposure"]
    assert found.exposure == feasible(MIRRORED, COLOURS, ENVELOPE, Exposure(), reference=LIT).high
    assert found.palette["fill"] == pytest.approx(found.exposure * COLOURS["fill"])


def test_an_image_that_meets_all_criteria_stays_as_it_is():
    dim = {**OPTIONS, "reference": Reference("key", exposure=0.2)}
    found = adapt(MIRRORED, COLOURS, ENVELOPE, FEW, **dim, most_difference=0.0, least_lightness=1.0)
    assert (found.accepted.means, found.exposure) == ("as given", 1.0)
    assert all(np.array_equal(found.palette[name], COLOURS[name]) for name in COLOURS)
    assert found.accepted.difference == 0


def test_what_cannot_be_reached_is_explained_and_what_can_be_is_named():
    options = {**OPTIONS, "least_luminance": 0.0}
    found = adapt(MIRRORED, COLOURS, ENVELOPE, FEW, **options, most_difference=0.5)
    assert (found.verdict, found.accepted) == ("not reached", None)
    assert {step.means for step in found.steps} == {"as given", "exposure", "closest", "lexicographic", "brightest"}
    assert found.criteria.lacking(found.steps[0]) == {"inside"}
    assert all(found.criteria.lacking(step) == {"difference"} for step in found.steps[1:])
    assert found.reachable["difference"] == min(step.difference for step in found.steps[1:])
    assert found.reachable["inside"] == found.steps[0].inside < 1
    assert all("meets the upper bound at" in step.binds for step in found.steps[1:])
    assert "No means tried reaches every pixel inside, a mean ΔE2000 of at most 0.5." in repr(found)
    assert f"With all other criteria met, difference: {found.reachable['difference']:.2f} at best." in repr(found)
    assert "<table>" in found._repr_html_()
    with pytest.raises(ValueError, match="ask for less"):
        _ = found.palette
    just = found.reachable["difference"]
    assert adapt(MIRRORED, COLOURS, ENVELOPE, FEW, **options, most_difference=just).verdict == "reached"


def test_near_black_is_not_accepted():
    # Twenty times too bright, dimming keeps every criterion that was asked for, and hardly a picture.
    bright = {**OPTIONS, "reference": Reference("key", exposure=20.0)}
    found = adapt(MIRRORED, COLOURS, ENVELOPE, [], **bright)
    assert found.verdict == "not reached"
    assert found.criteria.lacking(found.steps[1]) == {"luminance"}
    seen = [shade(MIRRORED, palette).values.reshape(-1, 36) / LIT.white(MIRRORED, COLOURS) * 20 for palette in
            (COLOURS, found.steps[1].palette)]  # fmt: skip
    lit = MIRRORED.object_pixels
    y = [np.minimum((one @ tristimulus(BANDS, "illuminant/D50")[:, 1])[lit], 1).mean() for one in seen]
    assert found.steps[1].luminance == pytest.approx(y[1] / y[0], rel=1e-9)
    assert "luminance" in repr(found)
    assert adapt(MIRRORED, COLOURS, ENVELOPE, [], **bright, least_luminance=0.0).verdict == "reached"


def test_asking_for_less_is_never_reached_later():
    """The loosest criterion first: the number of means that are tried does not fall as more is asked."""
    for name, values in (("most_difference", (30.0, 9.0, 7.0, 1.0)), ("least_lightness", (0.5, 0.75, 0.9, 1.0))):
        tried = [adapt(MIRRORED, COLOURS, ENVELOPE, FEW, **OPTIONS, **{name: value}) for value in values]
        assert [len(one.steps) for one in tried] == sorted(len(one.steps) for one in tried)
        assert len(tried[0].steps) < len(tried[-1].steps)


def test_no_more_pixels_are_left_out_than_the_criteria_need():
    """With exposure alone the least share is known: that at the least exposure which is light enough."""
    asked = {"least_inside": 0.9, "least_lightness": 0.9}
    found = adapt(MIRRORED, COLOURS, ENVELOPE, [], **OPTIONS, **asked)
    step = found.accepted
    assert step.means == "exposure"
    assert 0 < step.left_out < 0.1
    less = step.left_out - 0.1 / 32 - 1 / MIRRORED.object_pixels.sum()
    dimmer = feasible(MIRRORED, COLOURS, ENVELOPE, Exposure(), reference=LIT, allowed_out=less).high
    image = shade(MIRRORED, moved(MIRRORED, COLOURS, Exposure(), dimmer))
    assert figures(image)[2] < 0.9 <= step.lightness


@pytest.mark.parametrize("model", ["hull", "colorimetric", "inks"])
def test_gamuts_of_any_model_are_asked_themselves(model):
    gamut = device_gamut(DEVICE, model)
    grey = LinearSystem(sparse.csr_array([[1.0]]), (Interaction("key", ("wall.diffuse",)),), 1, 1, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "wall.diffuse": 0.95})
    found = adapt(grey, colours, gamut, [Scale("wall")], progress=False)
    assert found.verdict == "reached"
    seen = shade(grey, found.palette).values[0]
    assert gamut.contains(seen).all()
    assert not gamut.contains(np.full((1, 36), 0.95)).all()
    assert 0.9 < found.exposure < 1
    assert gamut.name in found.accepted.binds
    black = adapt(grey, colours, gamut, [Scale("wall")], within=(0.5, 1.0), most_difference=0.0, progress=False)
    assert black.verdict == "not reached"


def test_a_monitor_has_no_envelope_and_is_asked_itself():
    monitor = device_gamut(load_device("crt-brainard").on(BANDS), "monitor")
    found = adapt(MIRRORED, COLOURS, monitor, FEW, **OPTIONS, least_inside=0.2)
    assert {step.means for step in found.steps} <= {"as given", "exposure"}
    assert "closest" not in repr(found)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"least_inside": 2.0}, "least_inside"),
        ({"least_lightness": -1.0}, "least_lightness"),
        ({"most_difference": -1.0}, "most_difference"),
        ({"within": (3.0, 1.0)}, "within"),
        ({"scales": [Scale("bras")]}, "did you mean"),
        # Refused at once, and not only when scales are fitted: this image would be accepted as it is.
        ({"scales": [Scale("brass"), Scale("brass.mirror")], "least_inside": 0.0}, "give each spectrum one scale"),
    ],
)
def test_bad_questions_are_answered_in_one_line(change, message):
    question = {"system": MIRRORED, "palette": COLOURS, "gamut": ENVELOPE, "scales": FEW, **OPTIONS} | change
    with pytest.raises(ValueError, match=message) as error:
        adapt(**question)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("model", ["inks", "inks and envelope"])
def test_what_inks_cannot_reach_is_answered_and_not_refused(model):
    # Their gamut is not convex: pixels go to the nearest print, and there is no grey to go to.
    bands = wavelengths(400, 700, 50)
    device = load_device("dye3-endura-premier", bands)
    gamut = device_gamut(device, "inks")
    if model != "inks":
        gamut = intersection([gamut, device_gamut(device, "envelope")])
    column = Interaction("sun", ("sea.diffuse",))
    image = LinearSystem(sparse.csr_array([[0.25], [1.0]]), (column,), 1, 2, {"sun": 0.5})
    colours = Palette(bands, {"sun": 2, "sea.diffuse": [0.9, 0.1, 0.9, 0.1, 0.9, 0.1, 0.9]})
    found = adapt(image, colours, gamut, [], most_difference=0.0, map_rest=True, progress=False)
    assert found.verdict == "not reached"
    assert next(step.means for step in found.steps if step.mapped).endswith("to the nearest")


def test_a_black_picture_is_accepted_as_it_is():
    black = LinearSystem(sparse.csr_array(MIRRORED.G.shape), MIRRORED.interactions, 12, 16, MIRRORED.white)
    found = adapt(black, COLOURS, ENVELOPE, FEW, most_difference=0.0, progress=False)
    assert (found.accepted.means, found.asked) == ("as given", 0)
