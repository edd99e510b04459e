"""How other parameters move a limit, against asking again with a palette that was moved a little."""

import numpy as np
import pytest
from feedback.synthetic import BANDS, palette, system
from scipy import sparse

from symrt.device.inks import load_device
from symrt.feedback.parameters import Blend, Exposure, Scale
from symrt.feedback.ranges import feasible
from symrt.feedback.sensitivity import sensitivities
from symrt.feedback.weighing import pixels_of
from symrt.gamut.gamuts import device_gamut
from symrt.interactions import Interaction
from symrt.show.records import feasible_record
from symrt.spectra.palette import Palette
from symrt.spectra.reference import Reference
from symrt.symbols import Symbol
from symrt.system import LinearSystem

DEVICE = load_device("dye3-endura-premier")
IMAGE, COLOURS = system(12, 12), palette()
UNIT, ENVELOPE = device_gamut(DEVICE, "unit"), device_gamut(DEVICE, "envelope")
KEPT = device_gamut(DEVICE, "envelope", "luminance")
SCALES = [Scale("key"), Scale("fill"), Scale("deep"), Scale("brass"), Scale("brass.specular"), Exposure()]


def scaled(colours, name, factor):
    """The palette with a light, a material, or all lights scaled, and the exposure that keeps the white where it was.

    The white is the key light's: a brighter key against a white that is not brighter is what the exposure gives.
    """
    lights = {"exposure": ["key", "fill"]}.get(name, [name])
    symbols = [s for s in colours if s in lights or (Symbol.of(s).material == name and name not in ("key", "fill"))]
    moved = Palette(BANDS, {s: colours[s] * (factor if s in symbols else 1) for s in colours}, unphysical=True)
    return moved, Reference("key", exposure=factor if "key" in symbols else 1.0)


def ends(image, colours, gamut, parameter, name, factor, **options):
    moved, reference = scaled(colours, name, factor)
    found = feasible(image, moved, gamut, parameter, reference=reference, cap=False, **options)
    return np.array(found.intervals)


def differences(image, colours, gamut, parameter, name, **options):
    """Central differences of all ends by the logarithm of a scale."""
    # A blend's roots are enclosed to 2⁻³⁶, a scale's are found to rounding: the steps suit them.
    step = 1e-4 if isinstance(parameter, Blend) else 1e-5
    up, down = (ends(image, colours, gamut, parameter, name, np.exp(h), **options) for h in (step, -step))
    change = up - down if isinstance(parameter, Blend) else np.log(up / down)
    return change / (2 * step)


def held_against_differences(image, colours, gamut, parameter, **options):
    found = feasible(image, colours, gamut, parameter, reference=Reference("key"), cap=False, **options)
    names = {"key", "fill", "exposure", *(Symbol.of(s).material for s in colours if s not in ("key", "fill"))}
    compared = 0
    for name in sorted(names):
        expected = differences(image, colours, gamut, parameter, name, **options)
        for sides, row in zip(found.sensitivities, expected, strict=True):
            for side, value, why in zip(sides, row, found.reasons[0], strict=True):
                if why.side in ("range", "cap"):
                    assert side == ()
                    continue
                told = {one.name: one.change for one in side}
                own = parameter.name if isinstance(parameter, Scale) else str(parameter)
                if name == own:
                    continue
                assert told.get(name, 0.0) == pytest.approx(value, rel=2e-5, abs=2e-6)
                compared += 1
    return compared


@pytest.mark.parametrize("parameter", SCALES, ids=str)
@pytest.mark.parametrize("share", [0.0, 0.05])
def test_upper_limits_move_as_differences_say(parameter, share):
    options = {"within": (1e-3, 100.0), "allowed_out": share}
    assert held_against_differences(IMAGE, COLOURS, ENVELOPE, parameter, **options) > 5


@pytest.mark.parametrize("parameter", [Scale("key"), Exposure(), Scale("deep")], ids=str)
def test_lower_limits_move_as_differences_say(parameter):
    options = {"within": (1e-3, 100.0), "allowed_out": 0.9, "allowed_dark": 0.02}
    assert held_against_differences(IMAGE, COLOURS, KEPT, parameter, **options) > 5


def test_limits_of_a_blend_move_as_differences_say():
    parameter = Blend("deep", "ice")
    assert held_against_differences(IMAGE, COLOURS, UNIT, parameter) == 0
    strong = COLOURS.replace({"deep.diffuse": 0.1, "ice.diffuse": 0.99})
    image = LinearSystem(IMAGE.G * 4, IMAGE.interactions, 12, 12, IMAGE.white)
    assert held_against_differences(image, strong, ENVELOPE, parameter, mask=pixels_of(IMAGE, "deep")) > 5


def alternatives():
    """Pixels that a's and b's own terms would make, the latter recorded as what might be there."""
    names = [
        ("key", ("a.diffuse",)),
        ("key", ("a.mirror", "c.diffuse")),
        ("key", ("a>b.diffuse",)),
        ("key", ("a>b.specular",)),
        ("fill", ("a.diffuse",)),
        ("fill", ("a>b.diffuse",)),
        ("key", ("c.diffuse",)),
    ]
    columns = tuple(sorted(Interaction(light, met) for light, met in names))
    random = np.random.default_rng(5)
    image = LinearSystem(
        sparse.csr_array(random.uniform(0.1, 0.5, (9, len(columns)))), columns, 3, 3, {"key": 0.3, "fill": 0.3}
    )
    symbols = {"a.diffuse": 0.2, "a.mirror": 0.1, "b.diffuse": 0.9, "b.specular": 0.8, "c.diffuse": 0.3}
    spectra = {name: value * random.uniform(0.9, 1, 36) for name, value in symbols.items()}
    return image, Palette(BANDS, {"key": 1.0 + 0.1 * random.uniform(size=36), "fill": 0.5, **spectra})


def test_limits_of_a_blend_with_columns_of_its_own_move_as_differences_say():
    image, colours = alternatives()
    assert held_against_differences(image, colours, ENVELOPE, Blend("a", "b")) >= 5


def test_both_sides_of_a_dip_move_as_differences_say():
    columns = (Interaction("key", ("a.diffuse", "a.mirror")), Interaction("fill", ("c.diffuse",)))
    order = sorted(range(2), key=lambda k: columns[k])
    image = LinearSystem(
        sparse.csr_array(np.array([[1.0, 0.05]])[:, order]),
        tuple(columns[k] for k in order),
        1,
        1,
        {"key": 1.0, "fill": 1.0},
    )
    spectra = {"a.diffuse": 1.0, "a.mirror": 0.1, "b.diffuse": 0.1, "b.mirror": 1.0, "c.diffuse": 0.2}
    colours = Palette(BANDS, {"key": np.linspace(1, 1.1, 36), "fill": 0.5, **spectra})
    gamut = type(UNIT)(**{**vars(UNIT), "upper": np.full(36, 0.2)})
    found = feasible(image, colours, gamut, Blend("a", "b"), reference=Reference("key"))
    assert len(found.intervals) == 2
    for name in ("key", "fill", "a", "b", "c"):
        expected = differences(image, colours, gamut, Blend("a", "b"), name)
        told = [
            {one.name: one.change for one in side} for side in (found.sensitivities[0][1], found.sensitivities[1][0])
        ]
        assert told[0].get(name, 0.0) == pytest.approx(expected[0, 1], rel=2e-5, abs=2e-6)
        assert told[1].get(name, 0.0) == pytest.approx(expected[1, 0], rel=2e-5, abs=2e-6)
    assert "moves the upper limit by" in repr(found)
    assert "moves the lower limit by" in repr(found)


def test_where_no_pixel_stops_a_range_nothing_moves_it():
    found = feasible(IMAGE, COLOURS, UNIT, Scale("upland"), within=(0.5, 0.6))
    assert found.sensitivities == (((), ()),)
    assert "1 % less" not in repr(found)
    capped = feasible(IMAGE, COLOURS, UNIT, Scale("upland"), within=(0.5, 100), allowed_out=1.0)
    assert capped.reasons[0][1].side == "cap"
    assert capped.sensitivities == (((), ()),)


def test_a_limit_at_nothing_has_no_share_to_move_by():
    pixel = int(np.flatnonzero(pixels_of(IMAGE, "deep"))[0])
    found = sensitivities(IMAGE, COLOURS, Scale("deep"), 0.0, pixel, np.ones(len(BANDS)))
    assert found == ()


def test_shares_of_the_lights_add_up_to_the_exposure_and_are_sorted():
    found = feasible(IMAGE, COLOURS, ENVELOPE, Scale("brass"), within=(0.01, 100), cap=False)
    (_, above) = found.sensitivities[0]
    told = {one.name: one.change for one in above}
    assert told["exposure"] == pytest.approx(told["key"] + told.get("fill", 0.0), rel=1e-12)
    assert [abs(one.change) for one in above] == sorted((abs(one.change) for one in above), reverse=True)
    assert "brass" not in told
    moves = {one.parameter: one.change for one in found.moves[0][1]}
    record = feasible_record(found)["moved by 1 % less"][0]["above"]
    assert record == {str(parameter): change for parameter, change in moves.items()}
    assert f"1 % less exposure moves the upper limit by {100 * moves[Exposure()]:+.3g} %" in repr(found)
    assert "Against the same white, 1 % less exposure" in found._repr_html_()


@pytest.mark.parametrize("seed", range(12))
def test_what_is_said_of_1_percent_less_is_what_happens(seed):
    # Of one pixel's derivatives most were wrong where another pixel takes over: each sentence is asked for again.
    image, colours = system(8, 8, seed=seed), palette(seed)
    parameter = [Scale("brass"), Scale("key"), Scale("ice"), Exposure()][seed % 4]
    options = {"within": (1e-3, 100.0), "allowed_out": [0.0, 0.1][seed % 2]}
    found = feasible(image, colours, ENVELOPE, parameter, reference=Reference("key"), cap=False, **options)
    told = 0
    for k, sides in enumerate(found.moves):
        for side, moves in enumerate(sides):
            for move in moves:
                # Not by fixing the white: a key at 0.99 against its own white is seen as an exposure of 0.99.
                after = ends(image, colours, ENVELOPE, parameter, move.name, 0.99, **options)[k, side]
                assert move.change == pytest.approx(after / found.intervals[k][side] - 1, rel=1e-6, abs=1e-9)
                told += 1
    assert told


def test_a_derivative_that_another_pixel_belies_is_not_said():
    # The upper pixel stops a at 1 and sinks with b; but the lower one stops it at 1 + 1e-4, whatever b does.
    columns = (Interaction("key", ("a.diffuse",)), Interaction("key", ("b.diffuse",)))
    image = LinearSystem(sparse.csr_array([[0.1, 0.9], [1 / 1.0001, 0.0]]), columns, 1, 2, {"key": 1.0})
    colours = Palette(BANDS, {"key": 1.0, "a.diffuse": 1.0, "b.diffuse": 1.0})
    found = feasible(image, colours, UNIT, Scale("a"), cap=False)
    (_, above) = found.sensitivities[0]
    assert {one.name: one.change for one in above}["b"] == pytest.approx(-9.0, rel=1e-9)
    assert {one.name: one.change for one in found.moves[0][1]}["b"] == pytest.approx(1e-4, rel=1e-6)
    said = " ".join(repr(found).split())
    assert "1 % less b moves the upper limit by +0.01 %" in said or "1 % less b by +0.01 %" in said


def test_a_colorimetric_gamut_says_what_1_percent_less_does():
    image = LinearSystem.of(
        "0.25*key*a.diffuse + 0.1*fill*a.diffuse", "0.2*key*a.diffuse", white={"key": 0.5, "fill": 0.5}
    )
    colours = Palette(BANDS, {"key": 1.0, "fill": 0.5, "a.diffuse": DEVICE.white / 2})
    gamut = device_gamut(DEVICE, "colorimetric")
    wide = {"within": (0.01, 100.0)}
    found = feasible(image, colours, gamut, Scale("a"), reference=Reference("key"), cap=False, **wide)
    moves = {one.name: one.change for one in found.moves[-1][1]}
    assert set(moves) == {"key", "fill", "exposure"}
    for name, change in moves.items():
        after = ends(image, colours, gamut, Scale("a"), name, 0.99, **wide)[-1, 1]
        assert change == pytest.approx(after / found.high - 1, rel=1e-6, abs=1e-9)
    assert "1 % less" in repr(found)
    assert feasible(image, colours, device_gamut(DEVICE, "hull"), Scale("a")).again is None
