"""The demo writes the paper's figures, and they show what the paper says they show (issue 2; Figures 2 and 3)."""

import re

import imageio.v3 as imageio
import numpy as np
import pytest

import symrt as rt
from symrt.commands.arguments import scene_of
from symrt.show.demo import write_demo
from symrt.show.study import materials, telling_pixel

SIZE = 64
FILES = {
    "figure-1.png",
    "figure-2a.png",
    "figure-2b.png",
    "figure-3a.png",
    "figure-3a-black.png",
    "figure-3b.png",
    "ranges.png",
    "ranges.txt",
    "formula.txt",
    "times.txt",
    "index.html",
}


@pytest.fixture(scope="module")
def scene():
    return scene_of("globe", str(SIZE))


@pytest.fixture(scope="module")
def system(scene):
    return rt.render(scene, progress=False)


@pytest.fixture(scope="module")
def demo(scene, tmp_path_factory):
    out = tmp_path_factory.mktemp("demo") / "deep" / "out"
    return out, write_demo(out, scene, rt.load_palettes("globe"), progress=False)


def picture(demo, name):
    return imageio.imread(demo[0] / f"{name}.png")[..., :3].astype(float)


def shows(system, material):
    """Pixels in which nothing but one material is seen."""
    own = np.array([all(met.startswith(f"{material}.") for met in i.met) for i in system.interactions])
    sums = [np.asarray(abs(system.G) @ mask.astype(float)) for mask in (own, ~own)]
    return ((sums[0] > 0) & (sums[1] == 0)).reshape(SIZE, SIZE)


def test_every_file_is_written_whole_and_said(demo):
    out, products = demo
    assert {path.name for path in out.iterdir()} == FILES
    assert {product.path for product in products} == {out / name for name in FILES}
    assert all(product.path.stat().st_size > 0 and product.caption for product in products)


def test_the_pictures_are_not_blank_and_have_the_size_asked_for(demo):
    for name in ("2a", "2b", "3a", "3a-black", "3b"):
        seen = picture(demo, f"figure-{name}")
        assert seen.shape == (SIZE, SIZE, 3)
        assert len(np.unique(seen.reshape(-1, 3), axis=0)) > 50, name
    assert picture(demo, "figure-1").std() > 10


def test_figures_2a_and_2b_are_one_render_under_two_palettes(demo, system):
    # Paper §4: "rendered only once symbolically, then shaded" with RGB and with Macbeth spectra.
    for name, letter in (("rgb", "a"), ("macbeth", "b")):
        expected = rt.preview(system, rt.load_palettes("globe")[name])
        assert np.abs(picture(demo, f"figure-2{letter}") - expected).max() <= 1  # a value between two codes may round


def test_in_the_lightest_picture_africa_is_lighter_and_the_brass_is_darker(demo, system):
    # Paper, Figure 3: "while Africa is lighter, the brass arm has darkened from clipping".
    before, after = picture(demo, "figure-2b"), picture(demo, "figure-3b")
    upland, brass = shows(system, "upland"), shows(system, "brass")
    assert upland.sum() > 20
    assert brass.sum() > 20
    assert (after[upland].sum(axis=1) > before[upland].sum(axis=1)).all()
    assert (after[brass] <= before[brass]).all()
    assert after[brass].sum() < before[brass].sum()


def test_the_darkest_picture_is_no_lighter_anywhere_and_black_is_kept_where_it_is_asked_for(demo):
    darkest, kept, given = (picture(demo, name) for name in ("figure-3a", "figure-3a-black", "figure-2b"))
    assert (darkest <= given).all()
    assert (darkest <= kept).all()
    assert kept.sum() > darkest.sum()


def test_the_table_of_ranges_is_what_the_library_answers(demo, system):
    text = (demo[0] / "ranges.txt").read_text()
    gamut = rt.device_gamut(rt.load_device("dye3-endura-premier"), "envelope")
    palette = rt.load_palettes("globe")["macbeth"]
    for name in (*materials(system), "key", "fill"):
        found = rt.feasible(system, palette, gamut, rt.Scale(name), cap=False)
        # A row goes on in lines that begin with spaces.
        cells = re.search(rf"^scale of {name} .*\n(?: .*\n)*", text, re.MULTILINE)[0]
        row = " ".join(cells.split())
        assert f"{found.low:.4g}" in row.split()
        assert f"{found.high:.4g}" in row.split()
        assert found.verdict in row
        why = found.reasons[-1][1].short.split()
        assert all(word in row.split() for word in why)
        assert all(above in row for above in found.above_one)
    table = text.partition("parameter  ")[2].partition("\n\n")[0]
    assert max(map(len, table.splitlines())) <= 80
    for word in ("modelled", "exposure 1", "reference key", "no physical cap", "blend from"):
        assert word in text


def test_the_formula_before_and_after_the_collapse_is_the_shaded_pixel(demo, scene, system):
    text = (demo[0] / "formula.txt").read_text()
    x, y = telling_pixel(system)
    for formula in (rt.formula(scene, x=x, y=y), rt.formula(system, x=x, y=y)):
        assert all(form in text for form in (formula.text(), formula.latex(), formula.code()))
    assert float(re.search(r"within ([0-9.e-]+)\.$", text.strip())[1]) < 1e-14


def test_the_telling_pixel_shows_as_many_materials_as_any(system):
    x, y = telling_pixel(system)
    row = [system.interactions[k] for k in system.G[[y * SIZE + x]].indices]
    assert len({met.partition(".")[0] for i in row for met in i.met}) >= 2


def test_the_times_name_their_machine_and_every_step(demo):
    text = (demo[0] / "times.txt").read_text()
    assert all(
        word in text for word in ("processors", "trace", "collapse", "shade, 3 bands", "shade, 36 bands", "clip")
    )
    assert len(re.findall(r"\d+\.\d{4} s$", text, re.MULTILINE)) == 8


def test_the_page_shows_every_file_and_nothing_from_elsewhere(demo):
    text = (demo[0] / "index.html").read_text()
    assert set(re.findall(r'src="([^"]+)"', text)) == {name for name in FILES if name.endswith(".png")}
    assert all(name in text for name in FILES - {"index.html"})
    assert not re.search(r"https?:|<script|@import|url\(", text)


def test_a_scene_without_both_kinds_of_palette_is_refused(scene, tmp_path):
    palettes = rt.load_palettes("globe")
    with pytest.raises(ValueError, match="one in RGB and one in wavelengths"):
        write_demo(tmp_path, scene, {"macbeth": palettes["macbeth"]}, progress=False)
    assert not list(tmp_path.iterdir())
