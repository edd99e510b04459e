"""Rays that carry too little are not followed, by one rule for all senders; what they would bring is bounded."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from PIL import Image
from scenes_for_tests import camera, mirrors, small

import symrt as rt
from symrt.reflection import diffuse, mirror, n_dot_l, n_dot_v, reflectance, schlick

VARNISH = rt.Model(direct=diffuse * n_dot_l / np.pi, reflected=0.3 * schlick(reflectance("f0"), n_dot_v))


def checked_mirror():
    """A floor that is a weak mirror in some squares and paint in the others, below a ball of the user's own varnish."""
    scene = mirrors(model=VARNISH)
    floor = rt.Checker("tiles", materials=("floor", "weak"), size=0.5)
    weak = rt.Material("weak", model=rt.Model(direct=diffuse * n_dot_l / np.pi, reflected=0.05 * mirror))
    shapes = [scene.shapes[0], replace(scene.shapes[1], material="tiles")]
    return replace(scene, shapes=shapes, textures=[floor], materials=[*scene.materials, weak], camera=camera(16))


SCENES = {
    "glass": lambda: small("glass", 12),
    "checked mirror": checked_mirror,
}


@cache
def shaded(name, tolerance):
    scene = SCENES[name]()
    palette = rt.Palette(rt.RGB, {symbol: 0.4 + 0.02 * k for k, symbol in enumerate(scene.symbols)})
    tree = rt.trace(scene, tolerance=tolerance)
    return rt.shade(rt.collapse(tree), palette), sum(tree.rays.values())


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("tolerance", [1e-3, 0.02, 0.2])
def test_what_is_missing_is_never_more_than_the_certificate(name, tolerance, record_property):
    (whole, all_rays), (cut, rays) = shaded(name, 0), shaded(name, tolerance)
    missing = (whole.values - cut.values).max(axis=(0, 1))
    bound = np.broadcast_to(cut.cut_off, missing.shape)
    share = float((bound / np.where(missing > 0, missing, np.inf)).max())
    record_property("the bound over what is missing", share)
    print(f"{name}, {tolerance:g}: {rays} of {all_rays} rays, bound / missing {share:.3g}")  # noqa: T201  # for pytest -s
    assert np.all(missing <= bound)
    assert rays <= all_rays
    # Nothing is pruned for nothing: where rays were saved the certificate says more than that of the whole.
    assert rays == all_rays or np.all(cut.cut_off > 0)


def test_mirrors_are_pruned_by_what_their_formulas_send_on_at_most():
    # The varnish sends on at most 0.3, the weak mirror 0.05: a path through both carries at most 0.015.
    scene, casts = checked_mirror(), {}
    for tolerance in (0, 0.01, 0.02, 0.06, 0.31):
        tree = rt.trace(scene, tolerance=tolerance)
        casts[tolerance] = tree.rays.get("mirrors", 0)
        followed = [branch for level in tree.levels[1:] for branch in level.branches]
        assert sum(branch.size for branch in followed) <= casts[tolerance]
    assert casts[0] >= casts[0.01] > casts[0.02] > casts[0.06] > casts[0.31] == 0


def test_mirrors_that_may_send_on_everything_are_followed_to_the_depth():
    for scene in (small("spheres", 8), small("metals", 8)):
        few, every = (rt.trace(scene, tolerance=tolerance) for tolerance in (0.5, 0))
        assert few.rays == every.rays


def test_a_textures_weight_is_a_share_of_what_is_carried(tmp_path):
    # A floor that is a mirror by about half a thousandth of its weight casts no mirrored ray unless all are asked for.
    Image.fromarray(np.full((2, 2), 30, dtype=np.uint16)).save(tmp_path / "film.png")  # 30 / 65535
    film = rt.WeightImage("film", "film.png", materials=("floor", "ball"))
    scene = mirrors(model="mirror", depth=1)
    floor = replace(scene.shapes[1], material="film")
    thin = replace(scene, shapes=[floor], textures=[film], folder=tmp_path)
    assert "mirrors" in rt.plan(thin)
    assert rt.trace(thin).rays.get("mirrors", 0) == 0
    assert rt.trace(thin, tolerance=0).rays["mirrors"] > 0


@pytest.mark.parametrize("tolerance", [-0.1, 1, 1.5, float("nan"), True])
def test_a_tolerance_is_a_share(tolerance):
    with pytest.raises(ValueError, match=r"give a share of the light from 0 to below 1, such as 0\.001"):
        rt.plan(small("first", 8), tolerance=tolerance)


def test_the_tolerance_belongs_to_a_render(run, tmp_path):
    scene = small("glass", 12)
    system = rt.render(scene, tolerance=0.1, progress=False)
    once = rt.collapse(rt.trace(scene, tolerance=0.1))
    assert np.array_equal(system.G.toarray(), once.G.toarray())
    assert "down to 10% of a sample" in " ".join(str(rt.plan(scene, tolerance=0.1)).split())
    assert "down to" not in str(rt.plan(scene, tolerance=0))
    # Tiles and parts of another tolerance are of another render.
    rt.render(scene, tolerance=0.1, save=tmp_path / "tiles", progress=False)
    with pytest.raises(ValueError, match="tiles of another scene or of other parameters"):
        rt.render(scene, save=tmp_path / "tiles", progress=False)
    # The command line has the same.
    assert run("render", "glass", "--size", "12x12", "--tolerance", 0.1, "--out", "glass.npz")[0] == 0
    assert np.array_equal(rt.load_system("glass.npz").G.toarray(), system.G.toarray())
    code, _, said = run("plan", "glass", "--tolerance", 2)
    assert (code, said) == (2, "symrt: tolerance = 2.0: give a share of the light from 0 to below 1, such as 0.001\n")
