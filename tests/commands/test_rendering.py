"""Commands that render: parts are put together to the system of one render, and what is missing is named."""

import json

import numpy as np
import pytest
from scenes_for_tests import small

import symrt as rt

SMALL = ["--size", "24"]


def test_parts_are_rendered_and_merged_to_the_same_system(run, system):
    for number in (1, 3):
        code, out, _ = run("render", "first", *SMALL, "--part", f"{number}/3", "--out", "parts")
        assert (code, out) == (0, f"parts/part-{number}-of-3.npz: part {number} of 3\n")
    code, out, said = run("merge", "parts", "--out", "first.npz")
    assert (code, out, said) == (2, "", "symrt: parts: 1 of 3 parts are to be rendered: --array=2\n")
    record = json.loads(run("render", "first", *SMALL, "--part", "2/3", "--out", "parts", "--json")[1])
    assert record == {"part": "parts/part-2-of-3.npz"}
    assert json.loads(run("merge", "parts", "-o", "first.npz", "--json")[1])["coefficients"] == system.G.nnz
    merged = rt.load_system("first.npz")
    assert merged.interactions == system.interactions
    for part in ("data", "indices", "indptr"):
        assert np.array_equal(getattr(merged.G, part), getattr(system.G, part))


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--part", "3"], "--part '3': write K/N, such as 3/64"),
        (["--part", "1/3"], "--part 1/3: name the folder that the parts go to, such as --out parts"),
        (["--part", "4/3", "--out", "parts"], "part 4/3: parts run from 1/n to n/n"),
        (["--workers", "0"], "--workers '0': at least one thread works: give a number from 1, or processes"),
        (["--workers", "threads"], "--workers 'threads': at least one thread works"),
    ],
)
def test_words_that_name_no_part_and_no_workers_are_refused(run, written, tmp_path, words, says):
    code, out, said = run("render", "first", *SMALL, *words)
    assert (code, out) == (2, "")
    assert says in said
    assert written(tmp_path) == []


def test_a_dry_run_says_memory_and_time_and_writes_nothing(run, written, tmp_path):
    code, out, _ = run("render", "first", "--size", "512", "--dry-run")
    assert code == 0
    assert out.startswith("about 262 thousand pixels, ")
    assert "GiB of memory, " in out
    record = json.loads(run("render", "first", "--size", "512", "--part", "2/4", "--dry-run", "--json")[1])
    assert record["pixels"] == 512 * 128
    assert set(record) == {"pixels", "rays", "coefficients", "memory", "seconds"}
    assert written(tmp_path) == []


def test_a_render_larger_than_memory_is_refused_with_its_estimate_and_the_way_around(run, written, tmp_path):
    code, _, said = run("render", "first", "--size", "4096", "--memory", "0.01")
    assert code == 2
    assert said.startswith("symrt: about 17 million pixels, ")
    assert "0.01 GiB are there: render it smaller, or in parts on larger machines, or say how much there is" in said
    assert written(tmp_path) == []


def test_a_parameter_stays_free_and_is_settled_without_a_render(run):
    code, out, _ = run(
        "render", "first", *SMALL, "--free", "red.exponent=10,160", "--error", "1e-3", "--out", "free.npz"
    )
    assert code == 0
    assert "red.exponent errs by at most" in out
    nodes = rt.load_system("free.npz").parameters["red.exponent"]
    assert (nodes.low, nodes.high) == (10.0, 160.0)
    assert nodes.error <= 1e-3
    assert run("settle", "free.npz", "red.exponent=40", "--out", "settled.npz")[0] == 0
    settled, given = rt.load_system("settled.npz"), rt.collapse(rt.trace(small("first", 24)))
    assert settled.interactions == given.interactions
    np.testing.assert_allclose(settled.G.toarray(), given.G.toarray(), atol=nodes.error)
    for words, says in (
        (["settle", "free.npz", "red.exponent=400", "--out", "x.npz"], "the system was collapsed for [10.0, 160.0]"),
        (["settle", "free.npz", "red.exponent", "--out", "x.npz"], "write NAME=VALUE, such as brass.exponent=40"),
        (["render", "first", "--free", "red.exponent=wide"], "--free 'red.exponent=wide': 'wide' is no number"),
        (["render", "first", "--free", "red.exponent=10"], "write NAME=LOW,HIGH, NAME=first-order or"),
    ):
        code, _, said = run(*words)
        assert code == 2
        assert says in said
        assert said.count("\n") == 1
