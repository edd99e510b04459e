"""A probe's shares are those of the whole picture, as far as its rays can tell (paper §6)."""

from dataclasses import replace

import numpy as np
import pytest
from scenes_for_tests import hall_of_mirrors, mirrors, small

import symrt as rt


@pytest.mark.parametrize("scene", [small("first", 96), mirrors(model=["lambert", "mirror"]), hall_of_mirrors(2)])
def test_shares_agree_with_the_whole_picture(scene):
    met, tree = rt.probe(scene, rays=2500), rt.trace(scene)
    for meeting in met.meetings:
        level = tree.levels[meeting.bounces]
        points = next(p for p in level.points if p.material == meeting.material)
        lit = next((lit for lit in points.lit if lit.light == meeting.light), None)
        seen = points.weight[lit.point].sum() if lit else points.weight.sum()
        whole = seen / tree.rays["camera"]
        assert abs(meeting.share - whole) <= 5 * np.sqrt(
            max(whole * (1 - whole), 1e-3) / min(met.rays, tree.rays["camera"])
        )


def test_a_probe_says_what_leaving_an_effect_out_would_change():
    met = rt.probe(mirrors(model=["lambert", "mirror"]), rays=1024)
    assert met.mirrored > 0
    assert met.hidden > 0
    assert "without shadows" in str(met)
    assert met.meetings[0].material in met._repr_html_()


@pytest.mark.parametrize("scene", [hall_of_mirrors(2), small("glass", 24)])
def test_all_kinds_of_branches_are_counted(scene):
    found, tree = rt.probe(scene, rays=900), rt.trace(scene)
    for branching in found.branches:
        level = tree.levels[branching.bounces]
        below = tree.levels[branching.bounces + 1].branches if branching.bounces + 1 < len(tree.levels) else ()
        points = next(p for p in level.points if p.material == branching.material)
        sent = {
            kind: sum(
                points.weight[np.searchsorted(points.hit, parent)].sum()
                for branch in branches
                if branch.via == branching.via and branch.sent_by(points)
                for parent in [branch.parent[np.isin(branch.parent, points.hit)]]
            )
            / tree.rays["camera"]
            for kind, branches in (("share", below), ("cut", level.cut))
        }
        for kind, whole in sent.items():
            spread = 5 * np.sqrt(max(whole, 3e-3) / min(found.rays, tree.rays["camera"]))
            assert abs(getattr(branching, kind) - whole) <= spread
    assert {b.via for b in found.branches} <= {"reflected", "transmitted"}
    assert "not followed" in str(found)
    assert found.branches[0].material in found._repr_html_().partition("not followed")[2]


def test_beyond_the_depth_branches_are_cut_and_gathered_ones_have_their_own_word():
    found = rt.probe(hall_of_mirrors(2), rays=64)
    assert {(b.bounces, b.share > 0, b.cut > 0) for b in found.branches} == {
        (0, True, False),
        (1, True, False),
        (2, False, True),
    }
    room = rt.Scene(
        camera=rt.Camera(position=(0, 0, 2), target=(0, 0, -1), width=4, height=4),
        shapes=[rt.Box(centre=(0, 0, 0), size=(4, 4, 8), material="wall")],
        materials=[rt.Material("wall")],
        lights=[rt.PointLight("lamp", position=(0, 1, 0))],
        interreflection=rt.Interreflection(paths=8, depth=1),
    )
    gathered = rt.probe(room, rays=16).branches
    assert [(b.via, b.bounces, b.share, b.cut) for b in gathered] == [
        ("gathered", 0, 8.0, 0.0),
        ("gathered", 1, 0.0, 8.0),
    ]


def test_a_light_of_several_samples_is_one_meeting():
    met = rt.probe(small("lens", 8), rays=16)
    assert len({(m.light, m.material, m.bounces) for m in met.meetings}) == len(met.meetings)
    lamp = rt.RectangleLight("lamp", centre=(0, 4, 0), edge_u=(1, 0, 0), edge_v=(0, 0, 1))
    glossy = rt.probe(replace(mirrors(model="phong", exponent=9), lights=[lamp]), rays=64)
    assert len({(m.light, m.material, m.bounces) for m in glossy.meetings}) == len(glossy.meetings) > 0
    assert all(m.share <= 1 for m in glossy.meetings)


def test_no_rays_no_probe():
    with pytest.raises(ValueError, match="at least one ray"):
        rt.probe(small("first", 8), rays=0)
