"""Questions about metals: columns that name no metal stay, F0 ends at 1, and what subtracts is named."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import camera, mirrors

import symrt as rt

GAMUT = rt.device_gamut(rt.load_device("dye3-endura-premier"), model="envelope")
DIM = rt.Reference(exposure=0.7)


def ball(model) -> rt.LinearSystem:
    """A ball of a metal on a floor, seen obliquely, so that much of it is met near its edge."""
    return rt.render(replace(mirrors(model=model), camera=camera(24, position=(0, 0.3, 4))), progress=False)


def coloured(system, bands=GAMUT.device.bands) -> rt.Palette:
    spectra = {"sun": "illuminant/D65", "sky": 0.2, "floor.diffuse": 0.6, "ball.f0": "metal/copper"}
    own = {"ball.f82": "metal/copper f82"} if "ball.f82" in system.reflectances else {}
    return rt.Palette(bands, spectra | own)


METAL, BENT = ball("metal"), ball("metal_f82")


def test_a_scaled_metal_keeps_its_white_edge():
    palette = coloured(METAL)
    dark = palette.replace({"ball.f0": 0.0})
    left = rt.shade(METAL, dark).values.reshape(-1, len(palette.bands))
    mask = METAL.pixels_of(np.array(["ball.f0" in i.met for i in METAL.interactions]))
    # Of a ball without F0 only the edge is left: (1 - n.v)^5 of the floor, bright in a few pixels.
    whole = rt.shade(METAL, palette).values.reshape(-1, len(palette.bands))
    assert (left[mask] > 0).all()
    share = left[mask, 15] / whole[mask, 15]
    assert share.min() < 0.01
    assert share.max() > 0.2


@pytest.mark.parametrize("system", [METAL, BENT], ids=["metal", "metal_f82"])
def test_a_range_of_a_metal_ends_where_the_picture_leaves_the_gamut(system):
    palette, scale = coloured(system), rt.Scale("ball")
    found = rt.feasible(system, palette, GAMUT, scale, within=(0.05, 3.0), reference=DIM, cap=False)
    white = DIM.white(system, palette)

    def inside(t: float) -> np.ndarray:
        scaled = {name: t * palette[name] for name in palette.reflectances if name.startswith("ball.")}
        moved = replace(palette, spectra={**palette.spectra, **scaled}, unphysical=True)
        seen = rt.shade(system, moved).values.reshape(-1, len(white)) * DIM.exposure / white
        return (seen <= GAMUT.upper).all(axis=1)[system.object_pixels]

    # What is darker than black counts as inside.
    assert found.verdict == "complete"
    assert 0.5 < found.high < 3
    for t in (found.low, 0.3, found.high):
        assert inside(t * (1 - 1e-9)).all()
    assert not inside(found.high * (1 + 1e-6)).all()


def test_a_metals_f0_ends_at_1():
    palette = coloured(METAL)
    found = rt.feasible(
        METAL, palette, GAMUT, rt.Scale("ball"), within=(0.05, 9.0), reference=rt.Reference(exposure=0.01)
    )
    assert found.high == pytest.approx(1 / palette["ball.f0"].max(), rel=1e-9)
    assert "ball.f0 would reflect more than" in str(found)


def test_what_subtracts_is_named_with_the_way_out(tmp_path):
    assert not METAL.signed
    assert METAL.subtracting == ()
    assert BENT.subtracting == ("ball",)
    reasons = set(BENT.signed.values())
    assert reasons == {"the model of ball subtracts"}
    # The column of the floor alone, seen in the ball, is one of them, although it names no ball.
    assert rt.Interaction("sky", ("floor.diffuse",)) in BENT.signed
    scales = [rt.Scale("ball"), rt.Scale("floor")]
    for ask in (rt.fit, rt.safe_box):
        with pytest.raises(
            ValueError, match=r"\(the model of ball subtracts\).* with feasible; .*'metal' for 'metal_f82'"
        ):
            ask(BENT, coloured(BENT), GAMUT, scales, reference=DIM)

    # It is kept in files and in regions.
    rt.save_system(tmp_path / "bent.npz", BENT)
    again = rt.load_system(tmp_path / "bent.npz")
    assert (again.subtracting, again.signed) == (BENT.subtracting, BENT.signed)
    parted = rt.split(BENT, "ball", np.tri(24, dtype=bool), "rim")
    assert parted.subtracting == ("ball", "rim")
    assert set(parted.signed.values()) <= {f"the model of {by} subtracts" for by in ("ball", "rim", "ball or rim")}


def test_a_formula_that_subtracts_nowhere_is_not_blamed():
    # What subtracts in one place only names the material whose terms do.
    system = rt.LinearSystem.of("0.5*sun*sea.diffuse - 0.1*sun*gold.f0*sea.diffuse")
    blamed = replace(system, subtracting=("chrome", "gold"))
    assert set(system.signed.values()) == {"a negative term"}
    assert set(blamed.signed.values()) == {"the model of gold subtracts"}
