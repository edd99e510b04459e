"""Saved systems that were tampered with are refused at loading, each in one line that names the file."""

import json

import numpy as np
import pytest
from scipy import sparse

from symrt.interactions import Interaction
from symrt.nodes import Nodes
from symrt.saving import load_system, save_system
from symrt.system import LinearSystem
from symrt.tails import Tail

HOSTILE = (
    *("", "1", "a b", "a-b", "é", "a" * 65, "__import__('os')", "<script>", r"\href{javascript:alert(1)}{x}", r"$\x$"),
    *("a\n", "a\x1b]0;owned\x07", "a\x9b2J", "a\u202eb", "a\x00", 1, None, ["a"], True),
)
ELSEWHERE = ("sea>ice.diffuse", "sun.x.y", "sea>ice>fog.diffuse", ".diffuse", "sea.", "sea>.diffuse", "sea")


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Arrays and header of one small system, without the digest, which would hide every other fault."""
    path = tmp_path_factory.mktemp("saved") / "whole.npz"
    columns = (
        Interaction("sky", ("sea>ice.diffuse",)),
        Interaction("sun", ("brass.mirror", "sea.diffuse")),
        Interaction("sun", ("brass.specular",), (("brass.exponent", 0),)),
    )
    system = LinearSystem(
        G=sparse.csr_array([[0.5, 0.0, 0.25], [0.0, 1.0, 0.0]]),
        interactions=columns,
        height=1,
        width=2,
        white={"sun": 0.3, "sky": 1.0},
        models={"brass": "direct = diffuse*n_dot_l/pi"},
        parameters={"brass.exponent": Nodes("brass.exponent", 5.0, 80.0, 3)},
        tail=Tail(
            sparse.csr_array([[0.1], [0.0]]),
            (Interaction("sun", ("brass.mirror",)),),
            (((("brass.mirror",), 0.1),),),
        ),
        seconds={"trace": 0.1},
    )
    save_system(path, system)
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    header = json.loads(arrays.pop("header").tobytes())
    del header["digest"]
    return arrays, header


def put(value, *keys):
    """Put a value into the header, at a key of a list of a table."""

    def damage(_, header):
        for key in keys[:-1]:
            header = header[key]
        header[keys[-1]] = value

    return damage


def array(name, values, dtype=None):
    """Put other numbers into an array."""

    def damage(arrays, _):
        arrays[name] = np.array(values, dtype or arrays[name].dtype)

    return damage


def named(place, names):
    """Damages that put each name into a place of the header, where `place` makes a damage of a name."""
    return [pytest.param(place(name), id=f"{number}-{name!r}"[:24]) for number, name in enumerate(names)]


def as_key(table, value):
    return lambda name: put({"sun": "0x1p0", "sky": "0x1p0", name: value}, table)


def texts(names):
    return [name for name in names if isinstance(name, str)]


PARAMETER = ["brass.exponent", "0x1p0", "0x1p1", 3, "log"]
SUN = ["sun", ["brass.mirror", "sea.diffuse"], []]
DAMAGE = [
    *named(lambda name: put(name, "interactions", 0, 0), (*HOSTILE, "moon", "bands")),
    *named(lambda name: put([name], "interactions", 0, 1), (*HOSTILE, *ELSEWHERE[1:])),
    *named(lambda name: put(name, "interactions", 2, 2, 0, 0), (*HOSTILE, "brass.index")),
    *named(lambda name: put(name, "tail", 0, 0), HOSTILE),
    *named(lambda name: put([name], "tail", 0, 1), HOSTILE),
    *named(lambda name: put([name], "reflected", 0, 0, 0), HOSTILE),
    *named(lambda name: put(name, "parameters", 0, 0), HOSTILE),
    *named(as_key("white", "0x1p0"), [*texts(HOSTILE), "bands", "brass", "ice"]),
    *named(lambda name: put({name: "direct = 0"}, "models"), [*texts(HOSTILE), "sun", "sea.diffuse"]),
    *named(lambda name: put({name: 0.1}, "seconds"), texts(HOSTILE)),
    *named(
        lambda text: put(text, "models", "brass"), [n for n in HOSTILE if not isinstance(n, str) or "a" < n < "b"][4:]
    ),
    # Parts that contradict each other, and numbers that are none.
    *named(lambda size: put(size, "height"), (0, 2, -1, 1.0, True, "1", None, 2**70)),
    *named(lambda number: put(number, "white", "sun"), ("nan", "inf", "-0x1p0", "x", 1.0, None)),
    *named(lambda number: put(number, "reflected", 0, 0, 1), ("nan", "-0x1p0", 1.0)),
    *named(lambda number: put(number, "seconds", "trace"), (-1.0, float("nan"), float("inf"), "1", None, True)),
    *named(lambda j: put(j, "interactions", 2, 2, 0, 1), (-1, 3, 0.0, "0", True, None)),
    *named(lambda count: put([*PARAMETER[:3], count, "log"], "parameters", 0), (0, 257, 3.0, "3", True)),
    *named(lambda rows: put(rows, "parameters"), ([], [PARAMETER, PARAMETER], [["brass.exponent"]], {}, None)),
    *named(lambda met: put(met, "interactions", 1, 1), (["sea.diffuse", 1], "sea.diffuse", None)),
    put(["sun", ["brass.specular"], [["brass.exponent", 0], ["brass.exponent", 1]]], "interactions", 2),
    put([SUN, SUN, SUN], "interactions"),
    put([SUN, SUN], "interactions"),
    put([["sun", ["brass.mirror"], [["brass.exponent", 0]]]], "tail"),
    put(None, "tail"),
    put(1, "extra"),
    array("extra", [1.0], float),
    # Places of coefficients.
    array("G_indptr", [0, 3, 2]),
    array("G_indptr", [1, 2, 3]),
    array("G_indptr", [0, 2, 2]),
    array("G_indptr", [0, 2, 4]),
    array("G_indptr", [0, 3]),
    array("G_indptr", [[0, 2, 3]]),
    array("G_indptr", [0, 2, 3], float),
    array("G_indices", [0, 2, 3]),
    array("G_indices", [0, -1, 1]),
    array("G_indices", [0, 2]),
    array("G_data", [0.5, np.nan, 1.0]),
    array("G_data", [0.5, 0.25, 1.0], np.float32),
    array("tail_data", [-0.1]),
    array("tail_data", [np.nan]),
]


def rewrite(path, arrays, header):
    np.savez(path, allow_pickle=False, header=np.frombuffer(json.dumps(header).encode(), dtype=np.uint8), **arrays)


def refused(path):
    with pytest.raises(ValueError, match="render the scene and save it again") as caught:
        load_system(path)
    said = str(caught.value)
    assert said.startswith(f"{path}: not a whole symrt system (")
    assert said.isprintable()


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_tampered_system_is_refused_at_loading(saved, tmp_path, damage):
    arrays, header = dict(saved[0]), json.loads(json.dumps(saved[1]))
    damage(arrays, header)
    rewrite(tmp_path / "b.npz", arrays, header)
    refused(tmp_path / "b.npz")


def test_rows_out_of_order_with_nothing_stored_do_not_end_the_interpreter(saved, tmp_path):
    arrays, header = dict(saved[0]), dict(saved[1])
    arrays |= {"G_data": np.zeros(0), "G_indices": np.zeros(0, np.int32), "G_indptr": np.array([0, 5, 0])}
    rewrite(tmp_path / "b.npz", arrays, header)
    refused(tmp_path / "b.npz")


def test_a_system_saved_before_there_were_digests_is_read(saved, tmp_path):
    rewrite(tmp_path / "b.npz", *saved)
    assert load_system(tmp_path / "b.npz").lights == ("sun", "sky")


def test_a_coefficient_that_might_have_been_is_noticed_by_the_digest(saved, tmp_path):
    rewrite(tmp_path / "b.npz", *saved)
    save_system(tmp_path / "a.npz", load_system(tmp_path / "b.npz"))
    with np.load(tmp_path / "a.npz") as file:
        arrays = {name: file[name] for name in file.files}
    np.savez(tmp_path / "c.npz", **(arrays | {"G_data": arrays["G_data"] * 0.5}))
    refused(tmp_path / "c.npz")


def test_what_would_be_refused_is_not_saved(saved, tmp_path):
    rewrite(tmp_path / "b.npz", *saved)
    system = load_system(tmp_path / "b.npz")
    object.__setattr__(system, "white", {"sun": 1.0, "sky": 1.0, "a\x1b": 1.0})
    with pytest.raises(ValueError, match=r"a\.npz: not saved: a light is called 'a\\x1b'"):
        save_system(tmp_path / "a.npz", system)
    assert not (tmp_path / "a.npz").exists()
