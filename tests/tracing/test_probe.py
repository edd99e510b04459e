"""A probe's shares are those of the whole picture, as far as its rays can tell (paper §6)."""

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


def test_no_rays_no_probe():
    with pytest.raises(ValueError, match="at least one ray"):
        rt.probe(small("first", 8), rays=0)
