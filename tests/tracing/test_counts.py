"""After a render it is said what was counted: each effect's rays, the pixels that it touched, and its time."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import camera, mirrors, small

import symrt as rt
from symrt.counts import Count, Counts


def without_times(counts):
    return {name: (count.rays, count.pixels, dict(count.ways)) for name, count in counts.effects.items()}


def differing(scene, name):
    """Pixels whose light is another without an effect."""
    whole, without = (rt.collapse(rt.trace(scene, force=force)) for force in (None, {name: False}))
    palette = rt.Palette(rt.RGB, {symbol: 0.5 + 0.01 * k for k, symbol in enumerate(scene.symbols)})
    one, other = (rt.shade(system, palette).values.reshape(-1, 3) for system in (whole, without))
    return int(np.count_nonzero((one != other).any(axis=1)))


def test_the_pixels_that_an_effect_touches_are_those_that_are_others_without_it():
    scene = replace(mirrors(model=["lambert", "mirror"], depth=2), camera=camera(16))
    counts = rt.trace(scene).counts
    assert counts.pixels == 256
    assert counts.effects["ambient"].pixels == differing(scene, "ambient")
    # A mirrored ray may meet nothing, and a shadow stand where the sun sends nothing to the eye.
    assert counts.effects["mirrors"].pixels >= differing(scene, "mirrors") > 0
    assert counts.effects["shadows"].pixels >= differing(replace(scene, depth=0), "shadows") > 0


@pytest.mark.parametrize("name", ["glass", "soft_shadow"])
def test_counts_of_tiles_are_those_of_the_whole(name, monkeypatch, tmp_path):
    scene = small(name, 12)
    whole = rt.trace(scene)
    assert {name: count.rays for name, count in whole.counts.effects.items() if count.rays} == whole.rays
    assert list(whole.counts.effects) == ["camera", *(e.name for e in whole.plan.effects if e.simulated)]
    monkeypatch.setattr("symrt.linear.tiles.SAMPLES", 24)
    system = rt.render(scene, progress=False)
    assert without_times(system.counts) == without_times(whole.counts)
    assert system.counts.pixels == 144
    # They are saved with the system, and those of parts are put together.
    rt.save_system(tmp_path / "system.npz", system)
    assert rt.load_system(tmp_path / "system.npz").counts == system.counts
    for part in (1, 2, 3):
        rt.render_part(scene, (part, 3), tmp_path / "parts", progress=False)
    assert without_times(rt.merge_parts(tmp_path / "parts").counts) == without_times(whole.counts)


def test_glass_counts_what_it_mirrors_and_what_it_lets_through():
    tree = rt.trace(small("glass", 12))
    ways = tree.counts.effects["refraction"].ways
    followed = [branch for level in tree.levels[1:] for branch in level.branches]
    for via in ("reflected", "transmitted"):
        assert 0 < sum(branch.size for branch in followed if branch.via == via) <= ways[via]
    assert sum(ways.values()) == tree.rays["refraction"]


def test_times_add_up_to_that_of_the_trace():
    tree = rt.trace(small("spheres", 48))
    spent = {name: count.seconds for name, count in tree.counts.effects.items()}
    assert all(seconds >= 0 for seconds in spent.values())
    assert 0.5 * tree.seconds < sum(spent.values()) <= tree.seconds
    assert spent["mirrors"] > 0


def test_no_shadow_ray_starts_where_no_material_asks_for_light():
    # A mirror and nothing else: the sun is seen by no formula, and a ball of glass asks no more.
    scene = mirrors(model="mirror", depth=0)
    alone = replace(scene, shapes=scene.shapes[:1])
    assert rt.trace(alone).rays.get("shadows", 0) == 0
    both = rt.trace(scene)
    lit = sum(lit.point.size for p in both.levels[0].points for lit in p.lit if lit.light == "sun")
    assert both.rays["shadows"] == lit


def test_counts_show_themselves(run):
    counts = rt.render(small("glass", 8), progress=False).counts
    assert "reflected" in str(counts)
    assert "<td>refraction</td>" in counts._repr_html_()
    assert "<td>refraction</td>" in rt.render(small("glass", 8), progress=False)._repr_html_()
    code, out, err = run("render", "spheres", "--size", "16", "--out", "a.npz")
    assert (code, len(out.splitlines())) == (0, 1)
    assert "mirrors" in err
    code, out, err = run("render", "spheres", "--size", "16", "--out", "a.npz", "--json")
    record = json.loads(out)["counts"]
    assert (code, err, list(record)) == (0, "", ["camera", "shadows", "mirrors", "ambient", "textures"])
    assert record["mirrors"]["pixels"] > 0


def test_counts_of_which_one_is_unknown_join():
    one, other = Counts({"a": Count(1, 0.5, None, {"x": 1})}, 4), Counts({"a": Count(2, 0.5, 3, {"y": 2})}, 5)
    assert one.joined(other) == Counts({"a": Count(3, 1.0, 3, {"x": 1, "y": 2})}, 9)
    assert one.joined(Counts()) == one
