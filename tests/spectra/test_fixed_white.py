"""A white that stays: fits read back, lamps that dim, and the same picture in every verb that looks at one."""

from dataclasses import replace

import numpy as np
import pytest
from feedback.synthetic import palette, system

import symrt as rt
from symrt.spectra.display import checked_white

IMAGE, COLOURS = system(height=8, width=8, seed=3), palette(seed=3)
GAMUT = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
KEY = rt.Scale("key")
BRIGHT = COLOURS.replace(key=6 * COLOURS["key"])


@pytest.fixture(scope="module")
def found():
    seen = rt.Reference(exposure=3.0)
    return rt.fit(IMAGE, COLOURS, GAMUT, [KEY, rt.Scale("brass")], objective="closest", cap=False, reference=seen)


def test_a_fit_keeps_the_white_it_was_found_against(found):
    assert found.values["key"] < 0.99
    np.testing.assert_array_equal(found.reference.radiance, rt.Reference().white(IMAGE, COLOURS))
    assert found.reference.exposure == 3.0
    # Its palette's own key light would give another white, and another answer: that is what used to be asked.
    lost = replace(found.palette, white=None)
    assert not np.allclose(rt.Reference().white(IMAGE, lost), found.reference.radiance)


def test_a_fit_read_back_is_inside_and_the_same_picture(found, tmp_path):
    rt.save_palettes(tmp_path / "fit.toml", {"closest": found.palette})
    back = rt.load_palettes(tmp_path / "fit.toml")["closest"]
    np.testing.assert_array_equal(back.white, found.palette.white)
    seen = rt.Reference(exposure=3.0)
    limit = rt.feasible(IMAGE, back, GAMUT, rt.Exposure(), cap=False, reference=seen)
    assert limit.verdict == "complete"
    assert limit.high >= 1.0
    assert "reference the palette's white" in limit.note
    assert rt.report(IMAGE, back, [GAMUT], reference=seen).verdicts[0].inside == 1.0
    pictures = [
        rt.preview(IMAGE, back, exposure=3.0),
        rt.preview(IMAGE, found.palette, exposure=3.0, white=np.array(found.reference.radiance)),
        np.rint(255 * rt.to_rgb(rt.shade(IMAGE, back), exposure=3.0)).astype(np.uint8),
    ]
    for picture in pictures[1:]:
        assert np.abs(picture.astype(int) - pictures[0].astype(int)).max() <= 1


def test_a_dimmed_lamp_dims_the_picture_against_a_fixed_white():
    dim = COLOURS.replace({name: 0.1 * COLOURS[name] for name in ("key", "fill")})
    white = rt.Reference().white(IMAGE, COLOURS)
    given, alone = rt.preview(IMAGE, COLOURS), rt.preview(IMAGE, dim)
    np.testing.assert_array_equal(alone, given)
    dimmed = rt.preview(IMAGE, dim, white=white)
    assert dimmed.mean() < 0.5 * given.mean()
    for other in (rt.to_rgb(rt.shade(IMAGE, dim), white=white), rt.to_rgb(rt.shade(IMAGE, replace(dim, white=white)))):
        assert np.abs(255 * other - dimmed).max() <= 0.51


def test_a_palettes_white_stays_through_every_copy():
    fixed = replace(COLOURS, white=rt.Reference().white(IMAGE, COLOURS))
    for copy in (fixed.replace(key=1.0), fixed.add({"new.diffuse": 0.5}), fixed.on(fixed.bands)):
        np.testing.assert_array_equal(copy.white, fixed.white)
    coarse = fixed.on(rt.wavelengths(400, 700, 20))
    np.testing.assert_allclose(coarse.white, fixed.white[2:33:2], rtol=1e-15)


def test_a_white_that_is_none_is_refused():
    with pytest.raises(ValueError, match="the palette's white: 'white' has 2 values"):
        replace(COLOURS, white=[1.0, 2.0])
    with pytest.raises(ValueError, match="the palette's white is black"):
        replace(COLOURS, white=0.0)
    with pytest.raises(ValueError, match="a white is finite, not negative, and not black"):
        rt.Reference(radiance=[0.0, 0.0])
    with pytest.raises(ValueError, match="has 2 bands and the palette"):
        rt.Reference(radiance=[1.0, 2.0]).white(IMAGE, COLOURS)


def test_references_with_a_white_can_be_compared_and_kept():
    one, other = (rt.Reference("key", radiance=np.array([1.0, blue])) for blue in (0.5, 0.6))
    assert one == rt.Reference("key", radiance=(1.0, 0.5)) != other
    assert hash(one) != hash(other)
    kept = rt.Reference(exposure=2.0).kept(IMAGE, COLOURS)
    assert kept.kept(IMAGE, BRIGHT) == kept
    assert kept.called(IMAGE, BRIGHT) == "key as it was"


def test_what_was_adapted_keeps_its_white_through_a_file(tmp_path):
    seen = rt.Reference("key", exposure=3.0)
    found = rt.adapt(IMAGE, COLOURS, GAMUT, [KEY], cap=False, reference=seen, progress=False)
    assert found.exposure < 0.9  # it dims all lights: against their own white nothing would have changed
    rt.save_palettes(tmp_path / "adapted.toml", {"adapted": found.palette})
    back = rt.load_palettes(tmp_path / "adapted.toml")["adapted"]
    np.testing.assert_array_equal(back.white, seen.white(IMAGE, COLOURS))
    alone = rt.feasible(IMAGE, back, GAMUT, rt.Exposure(), cap=False, reference=rt.Reference(exposure=3.0))
    assert (alone.verdict, alone.high >= 1 - 1e-9) == ("complete", True)
    white = seen.white(IMAGE, COLOURS)
    np.testing.assert_allclose(
        rt.to_rgb(found.image(IMAGE)), rt.to_rgb(rt.shade(IMAGE, found.palette), white=white), rtol=1e-12
    )


def test_a_scaled_light_is_dimmed_no_further_than_the_white_given_asks_for():
    devices = map(rt.load_device, ("dye3-endura-premier", "synthetic-cmyk"))
    printed = rt.intersection([rt.device_gamut(device, "colorimetric") for device in devices])
    seen = rt.Reference("key", exposure=3.0)
    found = rt.adapt(IMAGE, COLOURS, printed, [KEY], cap=False, reference=seen, most_difference=0.0, progress=False)
    white = seen.white(IMAGE, COLOURS) / 3.0
    dimmed = [step for step in found.steps if step.means != "as given" and step.exposure < 1]
    for step in dimmed:
        values = rt.shade(IMAGE, step.palette).values.reshape(-1, 36)[IMAGE.object_pixels] / white
        assert step.inside == pytest.approx(np.mean(printed.contains(values)), abs=0.02)
        assert np.mean(printed.contains(1.02 * values)) < step.inside
    assert dimmed


def test_a_white_of_another_kind_is_named_with_what_makes_one():
    for white, said in ((rt.Reference(), "white is a Reference"), (KEY, "white is a Scale"), (COLOURS, "white is a")):
        with pytest.raises(TypeError, match=said):
            checked_white(white, COLOURS.bands)
    for white in (1.0, [1.0, 2.0], np.full(36, -1.0), np.full(36, np.nan)):
        with pytest.raises(ValueError, match=r"white = .*: a white "):
            checked_white(white, COLOURS.bands)


def test_a_preview_can_be_seen_against_a_light_by_name():
    named = rt.preview(IMAGE, COLOURS, white="fill")
    np.testing.assert_array_equal(named, rt.preview(IMAGE, COLOURS, white=rt.Reference("fill").white(IMAGE, COLOURS)))
    assert (named != rt.preview(IMAGE, COLOURS)).any()
