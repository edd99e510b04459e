"""Fluorescent paints: matrices of dyes, in palettes and their files, and Γ in the order in which light meets them."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

import symrt as rt
from symrt.errors import SceneError
from symrt.spectra import products
from symrt.spectra.fluorescence import Donaldson, gathered, sent_on
from symrt.spectra.products import gamma

NM = rt.wavelengths(380, 730, 10)
UNEVEN = rt.Bands((400.0, 420.0, 470.0, 480.0, 600.0))
TWO = rt.Bands((450.0, 600.0))
DYE = rt.Fluorescence(excitation=[0.5, 0], emission=[0, 1])


def random_dye(random, bands, scale=1.0):
    """A dye that takes in below the middle of the bands and gives back above it."""
    middle = len(bands) // 2
    taken, given = random.uniform(0, scale, len(bands)), random.uniform(0, 5, len(bands))
    taken[middle:], given[:middle] = 0, 0
    return rt.Fluorescence(taken, given, random.uniform(0.5, 1))


def test_two_bands_by_hand():
    # Half of the energy at 450 nm leaves at 600 nm; both bands are 150 nm wide.
    assert Donaldson.of(DYE, TWO).matrix.tolist() == [[0.0, 0.5], [0.0, 0.0]]
    palette = rt.Palette(TWO, {"sun": [8, 1], "red.diffuse": [0.25, 0.5], "red.fluorescence": DYE})
    system = rt.LinearSystem.of("sun*red.diffuse + sun*red.fluorescence")
    assert rt.shade(system, palette).values.tolist() == [[[8 / 4, 1 / 2 + 8 / 2]]]


def test_red_paint_behind_a_green_mirror_is_not_a_green_mirror_behind_red_paint():
    # The mirror lets a quarter of the blue pass, and half of the red.
    palette = rt.Palette(TWO, {"sun": [8, 1], "green.mirror": [0.25, 0.5], "red.fluorescence": DYE})
    first = rt.LinearSystem.of("sun*green.mirror*red.fluorescence")
    last = rt.LinearSystem.of("sun*red.fluorescence*green.mirror")
    assert rt.shade(first, palette).values.tolist() == [[[0.0, float(Fraction(8) / 4 / 2)]]]
    assert rt.shade(last, palette).values.tolist() == [[[0.0, float(Fraction(8) / 2 / 2)]]]
    assert first.interactions != last.interactions


def test_equal_products_share_a_column_and_others_do_not():
    def columns(*texts):
        return [str(i) for i in rt.LinearSystem.of(*texts).interactions]

    same = ["sun*b.mirror*a.diffuse*p.fluorescence*b.mirror", "sun*a.diffuse*b.mirror*p.fluorescence*b.mirror"]
    assert columns(*same) == [same[1]]
    other = ["sun*p.fluorescence*q.fluorescence", "sun*q.fluorescence*p.fluorescence"]
    assert columns(*other) == other
    assert columns("sun*p.fluorescence*p.fluorescence") == ["sun*p.fluorescence**2"]


@pytest.mark.parametrize("bands", [NM, UNEVEN, rt.RGB], ids=["even", "uneven", "rgb"])
def test_energy_is_what_was_taken_in_times_the_efficiency(bands):
    random = np.random.default_rng(3)
    dyes = [random_dye(random, bands, 0.5) for _ in range(3)]
    found = Donaldson.of(dyes, bands)
    light = random.uniform(0, 2, len(bands))
    given_back = (light @ found.matrix) @ bands.widths
    taken_in = sum(float(d.efficiency) * (light * d.excitation) @ bands.widths for d in dyes)
    assert given_back == pytest.approx(taken_in, rel=1e-12)
    np.testing.assert_allclose(
        sent_on(found.matrix, bands), sum(d.efficiency * np.array(d.excitation) for d in dyes), rtol=1e-12
    )


def test_gamma_multiplies_in_the_order_in_which_light_meets_its_factors():
    random = np.random.default_rng(5)
    spectra = {n: random.uniform(0, 1, 36) for n in ("sun", "sky", "a.diffuse", "b.mirror")}
    spectra |= {n: random_dye(random, NM) for n in ("p.fluorescence", "q.ink_fluorescence")}
    palette = rt.Palette(NM, spectra, unphysical=True)
    names = list(spectra)[2:]
    columns = [
        rt.Interaction(str(random.choice(["sun", "sky"])), tuple(map(str, random.choice(names, random.integers(6)))))
        for _ in range(40)
    ]
    found = gamma(columns, palette)
    for interaction, row in zip(columns, found, strict=True):
        expected = palette[interaction.light]
        for name in interaction.met:
            expected = expected @ (palette[name] if palette[name].ndim == 2 else np.diag(palette[name]))
        np.testing.assert_allclose(row, expected, rtol=1e-12)
    # The same bits whatever stands beside a column, and those of plain columns as without any matrix.
    for k, interaction in enumerate(columns):
        assert gamma([interaction], palette)[0].tobytes() == found[k].tobytes()
    plain = rt.Palette(NM, {n: s for n, s in spectra.items() if "fluorescence" not in n})
    for k, interaction in enumerate(columns):
        if all(name in plain for name in interaction.met):
            assert gamma([interaction], plain)[0].tobytes() == found[k].tobytes()


def test_no_matrix_is_asked_for_where_nothing_fluoresces(monkeypatch):
    def never(*_):
        raise AssertionError("nothing here fluoresces")

    monkeypatch.setattr(products, "passed", never)
    palette = rt.Palette(rt.RGB, {"sun": 2, "red.mirror": 0.5})
    assert gamma([rt.Interaction("sun", ("red.mirror",) * 2)], palette).tolist() == [[0.5] * 3]


# --- Other bands ----------------------------------------------------------------------------------------------------


def test_other_bands_keep_a_dye_and_make_no_energy():
    dye = rt.Fluorescence(rt.bell(480, 50, NM), rt.bell(560, 50, NM), 0.9)
    palette = rt.Palette(NM, {"sun": 1, "red.fluorescence": dye})
    fine = palette.on(rt.wavelengths(380, 730, 2))
    # A straight line between bands has the sum of the bands, but for half of the first and of the last one.
    np.testing.assert_allclose(
        (fine["sun"] @ fine["red.fluorescence"])[::5], palette["sun"] @ palette["red.fluorescence"], rtol=1e-5
    )
    assert (sent_on(fine["red.fluorescence"], fine.bands) <= 0.9 + 1e-12).all()
    # Where only its blue side is left, what leaves beyond is not squeezed in.
    blue = palette.on(rt.wavelengths(400, 520, 10))
    np.testing.assert_allclose(blue["red.fluorescence"], palette["red.fluorescence"][2:15, 2:15], rtol=1e-12)


def test_a_matrix_and_its_dyes_go_to_other_bands_alike():
    dye = rt.Fluorescence(rt.bell(460, 60, NM), rt.bell(560, 50, NM), 0.9)
    bands = rt.wavelengths(400, 700, 15)
    one = Donaldson.of(dye, NM)
    np.testing.assert_allclose(
        Donaldson.of(np.array(one.matrix), NM).on(bands, "").matrix, one.on(bands, "").matrix, rtol=1e-9, atol=1e-15
    )


# --- Files ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("bands", [NM, UNEVEN, rt.RGB], ids=["even", "uneven", "rgb"])
def test_saved_palettes_come_back_bit_for_bit(tmp_path, bands):
    random = np.random.default_rng(11)
    spectra = {
        "sun": random.uniform(0, 2, len(bands)),
        "one.fluorescence": random_dye(random, bands),
        "two.fluorescence": [random_dye(random, bands, 0.5) for _ in range(2)],
        "three.fluorescence": np.triu(random.uniform(0, 1 / len(bands), (len(bands),) * 2), 1),
    }
    palette = rt.Palette(bands, spectra)
    rt.save_palettes(tmp_path / "own.toml", {"own": palette})
    back = rt.load_palettes(tmp_path / "own.toml")["own"]
    assert all(back[name].tobytes() == palette[name].tobytes() for name in spectra)
    assert back.fluorescent == palette.fluorescent == tuple(spectra)[1:]


def written(tmp_path, text, bands="[400, 600, 100]"):
    path = tmp_path / "a.toml"
    path.write_text(f"[palettes.p]\nbands = {bands}\nsun = 1.0\n{text}")
    return rt.load_palettes(path)["p"]


def test_files_give_dyes_by_their_spectra(tmp_path):
    text = '"a.fluorescence" = { excitation = [0.5, 0, 0], emission = { peak = 600, width = 100 }, efficiency = 0.5 }'
    bell = np.array([1 / 65536, 1 / 16, 1.0])
    expected = np.outer([0.25, 0, 0], bell / bell.sum())
    np.testing.assert_allclose(written(tmp_path, text)["a.fluorescence"], expected, rtol=1e-14)
    unquoted = '[[palettes.p.a.fluorescence]]\nexcitation = 0.1\nemission = "illuminant/E"\n' * 2
    np.testing.assert_allclose(written(tmp_path, unquoted)["a.fluorescence"], np.full((3, 3), 0.2 / 3), rtol=1e-14)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('"a.fluorescence" = 0.5', "a fluorescence is { excitation"),
        ('"a.fluorescence" = { excitation = 0.5 }', "a fluorescence is { excitation"),
        ('"a.fluorescence" = { excitation = 0.5, emission = 1, yield = 1 }', "no key 'yield'"),
        ('"a.fluorescence" = { excitation = 0.5, emission = 1, efficiency = 2 }', "efficiency = 2"),
        ('"a.fluorescence" = { excitation = 0.5, emission = 1, per_nm = 1 }', "write true or false"),
        ('"a.fluorescence" = { excitation = 0.5, emission = 0 }', "emission is 0 at all bands"),
        ('"a.fluorescence" = { excitation = [1.5, 0, 0], emission = 1 }', "a share of what arrives, from 0 to 1"),
        ('"a.fluorescence" = { excitation = [-1, 0, 0], emission = 1 }', "no light is negative"),
        ('"a.fluorescence" = { excitation = 0.5, emission = [0, 0, 1], per_nm = true }', "in 1/nm it is 1 at most"),
        ('"a.fluorescence" = { excitation = [0, 0, 1], emission = [1, 0, 0] }', "(Stokes); swap the two"),
        ('"a.fluorescence" = { matrix = [[0, 1], [0, 0]] }', "2 values where 3 belong"),
        ('"a.fluorescence" = { matrix = [[0, 0, 2], [0, 0, 0], [0, 0, 0]] }', "gives back 2 of the energy"),
        ('"a.fluorescence" = { excitation = 1, emission = [0, 0, 1] }\n"a.diffuse" = 0.1', "diffuse 0.1 send on 1.1"),
        ("lamp = { peak = 500 }", "width = None"),
        ("lamp = { peak = 500, width = 0 }", "is above 0"),
        ("lamp = { peak = 0.5, width = 10 }", "micrometres"),
    ],
)
def test_what_no_paint_does_is_one_line_with_the_remedy(tmp_path, text, says):
    with pytest.raises(SceneError) as refused:
        written(tmp_path, text)
    assert says in str(refused.value)
    assert len(str(refused.value).splitlines()) == 1


def test_a_bell_has_no_colour_in_rgb(tmp_path):
    with pytest.raises(SceneError, match="no red, green and blue"):
        written(tmp_path, "lamp = { peak = 500, width = 10 }", bands='"rgb"')


def test_unphysical_palettes_hold_paints_that_give_back_more():
    more = {"a.fluorescence": rt.Fluorescence([0, 1.0], [1, 0]), "a.diffuse": 0.5, "sun": 1}
    with pytest.raises(ValueError, match="Stokes"):
        rt.Palette(TWO, more)
    with pytest.raises(ValueError, match=r"'a': fluorescence 1 \+ diffuse 0.5 send on 1.5 of the light at 450 nm"):
        rt.Palette(TWO, more | {"a.fluorescence": rt.Fluorescence([1.0, 0], [0, 1])})
    palette = rt.Palette(TWO, more, unphysical=True)
    assert palette.replace(sun=2)["a.fluorescence"].tolist() == [[0, 0], [1, 0]]
    assert rt.Palette(TWO, {"a.fluorescence": np.array([[0, 1.5], [0, 0]])}, unphysical=True).above_one


def test_palettes_show_their_matrices():
    palette = rt.Palette(TWO, {"sun": 1, "a.fluorescence": DYE})
    assert "mostly from 450 nm to 600 nm, up to 0.5 of the light" in palette._repr_html_()
    assert repr(palette) == "Palette(Bands(2 wavelengths, 450 … 600 nm), sun, a.fluorescence)"


# --- The certificate ------------------------------------------------------------------------------------------------


def test_the_sum_of_all_bounces_is_the_series():
    random = np.random.default_rng(2)
    again = np.triu(random.uniform(0, 0.9, (6, 6)))
    start, total = random.uniform(0, 1, (2, 6)), np.zeros((2, 6))
    part = start
    for _ in range(600):
        total, part = total + part, part @ again
    np.testing.assert_allclose(gathered(start, again), total, rtol=1e-9)
    assert np.isinf(gathered(start, again + np.diag([0, 0, 0.2 + again[2, 2], 0, 0, 1.0]))).all()


def hall(model, depth):
    """Two walls that face each other, between a lamp."""
    return rt.Scene(
        camera=rt.Camera(position=(0.3, 0.2, 0), target=(0, 0, -1), width=8, height=8, field_of_view=50),
        shapes=[
            rt.Rectangle(centre=(0, 0, -2), edge_u=(9, 0, 0.2), edge_v=(0, 9, 0), material="front"),
            rt.Rectangle(centre=(0, 0, 2), edge_u=(-9, 0, 0), edge_v=(0, 9, 0.1), material="back"),
        ],
        materials=[rt.Material("front", model=model), rt.Material("back", model=["lambert", "mirror"])],
        lights=[rt.PointLight("lamp", position=(0, 1, 0.5)), rt.AmbientLight("sky")],
        depth=depth,
    )


GLOWING_MIRROR = rt.Model(reflected=rt.reflectance("mirror") + rt.reflectance("coat_fluorescence"))


@pytest.mark.parametrize(
    ("model", "near"),
    [
        (["lambert", "mirror", "fluorescent"], 12),
        (["lambert", "fluorescent", GLOWING_MIRROR], 12),
        # Its bound counts the coat as one that lamps shine on, too.
        ([GLOWING_MIRROR], 25),
    ],
    ids=["paint beside a mirror", "a mirror that glows, too", "nothing but a mirror that glows"],
)
def test_what_is_missing_is_bounded_where_light_moves_between_bands(model, near):
    random = np.random.default_rng(17)
    few, many = (rt.collapse(rt.trace(hall(model, depth), tolerance=0)) for depth in (1, 6))
    shown = {name for system in (few, many) for name in (*system.symbols, *system.tail.fluorescent)}
    ratios = []
    for _ in range(10):
        spectra = {n: random.uniform(0, 1, 5) if "." not in n else random.uniform(0, 0.3, 5) for n in shown}
        spectra |= {n: random_dye(random, UNEVEN, random.choice([0.1, 0.5])) for n in shown if "fluorescence" in n}
        palette = rt.Palette(UNEVEN, spectra, unphysical=True)
        seen, more = rt.shade(few, palette), rt.shade(many, palette)
        assert np.isfinite(seen.cut_off).all()
        missing = (more.values - seen.values).max(axis=(0, 1))
        assert (missing <= seen.cut_off).all()
        ratios.append(seen.cut_off / missing)
    assert np.min(ratios) < near, "a bound that is never near proves little"


def test_bounds_are_lost_only_where_light_does_not_fade():
    system = rt.collapse(rt.trace(hall(["lambert", "mirror", "fluorescent"], 1)))
    shown = {*system.symbols, *(name for i in system.tail.interactions for name in i.met)}
    spectra = {n: 0.3 if "." in n else 1.0 for n in shown} | {"front.fluorescence": DYE}
    palette = rt.Palette(TWO, spectra, unphysical=True)
    assert np.isfinite(rt.shade(system, palette).cut_off).all()
    # A mirror of all light at 450 nm, from which both bands are fed; one of all light at 600 nm feeds only that one,
    # but the sum has no end, and no band of it is told apart.
    for mirror in ([1.0, 0.3], [0.3, 1.0]):
        assert np.isinf(rt.shade(system, palette.replace({"back.mirror": mirror})).cut_off).any()
    dark = palette.replace({"front.mirror": 0.0, "back.mirror": 0.0})
    assert not rt.shade(system, dark).cut_off.any()
    # Of paint that the palette does not name, seen by no pixel, anything may come.
    unseen = replace(system, tail=replace(system.tail, fluorescent=("front.fluorescence", "hidden.fluorescence")))
    assert (rt.shade(unseen, palette).cut_off > rt.shade(system, palette).cut_off).all()


@pytest.mark.parametrize("depth", [0, 1, 3])
def test_a_furnace_of_fluorescent_paint_is_the_series_of_its_matrix(depth):
    # The lamp gives every place of the ball the same, and each bounce sends on R + F of it: Σ (R + F)^k.
    scene = rt.Scene(
        camera=rt.Camera(position=(0.25, 0.125, 0), target=(0, 0, 0.5), width=2, height=2, field_of_view=60),
        shapes=[rt.Sphere(centre=(0, 0, 0), radius=2, material="wall")],
        materials=[rt.Material("wall", model=["lambert", "fluorescent"])],
        lights=[rt.PointLight("lamp", position=(0, 0, 0))],
        interreflection=rt.Interreflection(3, depth),
    )
    random = np.random.default_rng(depth)
    wall = {"wall.diffuse": random.uniform(0.1, 0.5, 5), "wall.fluorescence": random_dye(random, UNEVEN, 0.4)}
    palette = rt.Palette(UNEVEN, {"lamp": random.uniform(1, 9, 5)} | wall)
    again = np.diag(palette["wall.diffuse"]) + palette["wall.fluorescence"]
    powers = [np.linalg.matrix_power(again, k) for k in range(1, depth + 2)]
    image = rt.shade(rt.render(scene, progress=False), palette)
    seen = np.broadcast_to(palette["lamp"] @ sum(powers) / (4 * np.pi), (2, 2, 5))
    np.testing.assert_allclose(image.values, seen, rtol=1e-12)

    # All bounces beyond the depth are within the bound.
    whole = palette["lamp"] @ again @ np.linalg.inv(np.eye(5) - again) / (4 * np.pi)
    assert (whole - seen <= image.cut_off).all()
