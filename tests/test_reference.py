"""The scalar tracer itself: what it says of scenes that can be worked out by hand."""

import ast
import math
from pathlib import Path

import pytest
import reference
import tomli_w

EYE = {"position": [0, 0, 5], "target": [0, 0, 0], "field_of_view": 30}
WALL = {"type": "plane", "point": [0, 0, 0], "normal": [0, 0, 1], "material": "wall"}
SUN = {"type": "directional", "direction": [0, 3, -4]}  # its cosine to the wall's normal is 4/5


def middle(tmp_path, palette, rules=None, **scene):
    """The middle pixel of a small scene, with rules that no file can say."""
    path = tmp_path / "scene.toml"
    whole = {"camera": EYE, "shapes": [WALL], "materials": {"wall": {}}, "lights": {"sun": SUN}} | scene
    path.write_text(tomli_w.dumps(whole | {"palettes": {"hand": {"bands": "rgb"} | palette}}))
    plain = reference.load(path)._replace(**(rules or {}))
    return reference.pixel(plain, reference.load_palette(path, "hand"), 1, 1, 3, 3)


def test_a_diffuse_wall_sends_back_its_share_of_the_cosine(tmp_path):
    seen = middle(tmp_path, {"wall.diffuse": [0.2, 0.5, 1.0], "sun": [10.0, 1.0, 2.0]})
    assert seen == pytest.approx([0.8 * x / math.pi for x in (2.0, 0.5, 2.0)], rel=1e-15)


def test_a_point_light_falls_off_with_the_square_of_the_distance(tmp_path):
    bulb = {"type": "point", "position": [0, 3, 4]}
    seen = middle(tmp_path, {"wall.diffuse": 0.5, "bulb": 7.0}, lights={"bulb": bulb})
    assert seen == pytest.approx([7 / 25 * 0.8 * 0.5 / math.pi] * 3, rel=1e-15)


@pytest.mark.parametrize(
    ("model", "lobe"),
    [  # the eye is on the normal, so r·v = n·l = 4/5, and n·h is the cosine of half that angle: √0.9
        ("phong", (20 + 2) / (2 * math.pi) * 0.8**20 * 0.8),
        ("phong_plain", 0.8**20 / math.pi),
        ("blinn_phong", (20 + 8) / (8 * math.pi) * 0.9**10 * 0.8),
    ],
)
def test_a_glossy_wall_adds_its_lobe(tmp_path, model, lobe):
    seen = middle(
        tmp_path,
        {"wall.diffuse": 0.5, "wall.specular": 0.25, "sun": 1.0},
        materials={"wall": {"model": model, "exponent": 20}},
    )
    assert seen == pytest.approx([0.5 * 0.8 / math.pi + 0.25 * lobe] * 3, rel=1e-14)


@pytest.mark.parametrize("depth", [0, 1, 2, 5])
def test_a_periscope_needs_a_depth_of_two_and_squares_its_mirror(tmp_path, depth):
    def mirror(centre, *edges):
        return {"type": "rectangle", "centre": centre, "edge_u": edges[0], "edge_v": edges[1], "material": "chrome"}

    shapes = [
        mirror([0, 0, 0], [1, 0, 0], [0, 1, 1]),  # what comes along -z goes down
        mirror([0, -4, 0], [1, 0, 0], [0, 1, 1]),  # and along -z again
        {"type": "plane", "point": [0, 0, -9], "normal": [0, 0, 1], "material": "wall"},
    ]
    seen = middle(
        tmp_path,
        {"wall.diffuse": 1.0, "chrome.mirror": 0.5, "sun": math.pi},
        shapes=shapes,
        materials={"wall": {}, "chrome": {"model": "mirror"}},
        lights={"sun": {"type": "directional", "direction": [0, 0, -1], "shadows": False}},
        depth=depth,
    )
    assert seen == pytest.approx([0.25 if depth >= 2 else 0.0] * 3, rel=1e-15)


def test_ambient_light_reaches_what_stands_in_shadow(tmp_path):
    roof = {"type": "disk", "centre": [0, -3, 4], "normal": [0, 0, 1], "radius": 1, "material": "wall"}
    lights = {"sun": SUN, "sky": {"type": "ambient"}}
    seen = middle(tmp_path, {"wall.diffuse": 0.5, "sun": 1.0, "sky": 0.25}, shapes=[WALL, roof], lights=lights)
    assert seen == [0.125] * 3


def test_a_relief_shows_sea_and_land_where_they_are():
    weigh = reference.banded_relief({"levels": [0], "materials": ["sea", "land"], "blend": 1})

    def at(north, east):
        hit = reference.Hit(1.0, (0, 0, 0), (0, 0, 1), (0, 0, 1), (east / 360 + 0.5, 0.5 - north / 180), (1, 1), "")
        return weigh(hit)

    assert at(north=15, east=20) == {"land": 1.0}  # Chad
    assert at(north=-25, east=135) == {"land": 1.0}  # Australia
    assert at(north=0, east=-140) == {"sea": 1.0}  # the Pacific
    assert at(north=0, east=80) == {"sea": 1.0}  # the Indian Ocean


@pytest.mark.parametrize("depth", [0, 1, 5])
def test_rays_that_a_hit_sends_on_make_a_furnace_a_geometric_series(tmp_path, depth):
    # The wall of a ball around eye and lamp gives ρ/(π R²) at every hit; two rays of shares 0.2 and 0.7 bring 0.9 of
    # it again, and a third of no share nothing: Σ K^k of it, and K^(depth + 1) of what lies beyond.
    def three(_, to_eye):
        return [reference.Ray("reflected", to_eye, share) for share in (0.2, 0.7, 0.0)]

    seen = middle(
        tmp_path,
        {"wall.diffuse": 1.0, "wall.mirror": [0.5, 1.0, 0.0], "lamp": 4 * math.pi, "beyond": [0.0, 0.0, 7.0]},
        rules={"sending": (three,), "beyond": "beyond", "least": 0.0},
        camera=EYE | {"position": [0, 0, 0], "target": [0, 0, -1]},
        shapes=[{"type": "sphere", "centre": [0, 0, 0], "radius": 2, "material": "wall"}],
        materials={"wall": {"model": ["lambert", "mirror"]}},
        lights={"lamp": {"type": "point", "position": [0, 0, 0]}},
        depth=depth,
    )
    assert seen == pytest.approx([sum((0.9 * m) ** k for k in range(depth + 1)) for m in (0.5, 1.0, 0.0)], rel=1e-14)


def test_a_ray_is_multiplied_by_the_formula_it_names(tmp_path):
    # Straight back from a wall that glows, through a diffuser's formula: 1/π of its share, and one bounce deep only.
    def back(_, to_eye):
        return [reference.Ray("direct", to_eye, 0.25), reference.Ray("reflected", to_eye, 1.0)]

    seen = middle(
        tmp_path,
        {"wall.diffuse": [0.2, 0.5, 1.0], "ember": 3.0, "cut": 10.0},
        rules={"sending": (back,), "emitting": (lambda *_: {"ember": 2.0},), "beyond": "cut"},
        lights={},
        depth=0,
    )
    assert seen == pytest.approx([6 + 10 * 0.25 * x / math.pi for x in (0.2, 0.5, 1.0)], rel=1e-14)


def test_samples_of_a_film_count_by_their_weights(tmp_path):
    # One sample on the wall, and one beside it, where there is nothing.
    tile = {"type": "rectangle", "centre": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 1, 0], "material": "wall"}
    film = [reference.Sample(1.5, 1.5, 0.375), reference.Sample(0.1, 1.5, 0.625)]
    seen = middle(
        tmp_path,
        {"wall.diffuse": 0.5, "sky": 8.0},
        rules={"film": lambda *_: film},
        shapes=[tile],
        lights={"sky": {"type": "ambient"}},
    )
    assert seen == [1.5] * 3


def test_nothing_of_symrt_is_in_it():
    for path in Path(reference.__file__).parent.glob("*.py"):
        imports = [
            node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Import | ast.ImportFrom)
        ]
        names = [getattr(node, "module", None) or node.names[0].name for node in imports]
        assert not [name for name in names if name.startswith("symrt")]
