"""The command line destroys nothing that is there, waits for no pipe, and lets no control character through."""

import io
import os
import sys
from pathlib import Path

import pytest

import symrt as rt
from symrt.cli import main
from symrt.commands.saying import say
from symrt.show.writing import json_text


@pytest.fixture
def system(tmp_path, monkeypatch):
    """A folder with a rendered system, and its bytes."""
    monkeypatch.chdir(tmp_path)
    assert main(["render", "first", "--size", "8", "--out", "a.npz"]) == 0
    return Path("a.npz").read_bytes()


SHADE = ["shade", "a.npz", "--palettes", "first", "--palette", "plain"]


def test_a_picture_does_not_replace_the_system_it_is_made_of(system, capsys):
    Path("b.npz").hardlink_to("a.npz")
    for name in ("a.npz", "./a.npz", "b.npz"):
        assert main([*SHADE, "--out", name]) == 2
        assert "would be lost: give another name" in capsys.readouterr().err
    assert Path("a.npz").read_bytes() == system


def test_a_picture_or_a_gamut_does_not_replace_another_system(system, capsys):
    Path("b.npz").write_bytes(system)
    for words in ([*SHADE, "--out", "b.npz"], ["gamut", "--save", "b.npz"]):
        assert main(words) == 2
        assert "b.npz: a symrt-system is there, which would be lost" in capsys.readouterr().err
    assert Path("b.npz").read_bytes() == system


@pytest.mark.usefixtures("system")
def test_the_same_command_may_replace_what_it_wrote():
    for _ in range(2):
        assert main([*SHADE, "--out", "b.npz"]) == 0
        assert main([*SHADE, "--out", "b.png"]) == 0
        assert main(["render", "first", "--size", "8", "--out", "a.npz"]) == 0


@pytest.mark.usefixtures("system")
@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "a.png", "--plot", "./a.png"], "--out and --plot are both a.png"),
        (["--palette-out", "p.toml", "--palettes", "p.toml"], "--palette-out p.toml is a file that is read"),
        (["--palette-out", "q.toml"], "q.toml holds other palettes, which would be lost: ['cold', 'warm']"),
    ],
)
def test_outputs_of_one_name_and_palettes_that_would_be_lost_are_refused(capsys, words, said):
    plain = rt.load_palettes("first")["rgb"]
    rt.save_palettes("p.toml", {"rgb": plain})
    rt.save_palettes("q.toml", {"warm": plain, "cold": plain})
    before = Path("q.toml").read_bytes(), Path("p.toml").read_bytes()
    assert main(["fit", "first", "--size", "8", "-p", "scale:sun", *words]) == 2
    assert said in capsys.readouterr().err
    assert (Path("q.toml").read_bytes(), Path("p.toml").read_bytes()) == before


@pytest.mark.usefixtures("system")
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize(
    "words",
    [
        ["plan", "PIPE.toml"],
        ["formula", "PIPE.npz", "--x", "0", "--y", "0"],
        ["gamut", "--device", "PIPE.ti3"],
        ["gamut", "--device", "PIPE.npz"],
        ["shade", "a.npz", "--palettes", "PIPE.toml"],
    ],
)
def test_nobody_waits_for_a_pipe(capsys, words):
    for name in ("PIPE.toml", "PIPE.npz", "PIPE.ti3"):
        os.mkfifo(name)
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "PIPE" in said
    assert "a pipe or a device, not a file" in said


@pytest.mark.parametrize(
    "words", [["plan", "a\x1b]0;owned\x07.toml"], ["shade", "a\x9b2J.npz"], ["gamut", "--device", "\u202ea"]]
)
def test_what_was_typed_comes_back_without_what_a_terminal_obeys(capsys, words):
    assert main(words) == 2
    out, err = capsys.readouterr()
    assert all(line.isprintable() for line in (out + err).splitlines())


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "utf-8"])
def test_an_answer_is_written_in_any_encoding(monkeypatch, encoding):
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", stream)
    say("4 × 4 ≤ Σ é")
    stream.flush()
    assert stream.buffer.getvalue().decode(encoding).startswith("4 ")


def test_json_is_the_same_in_any_encoding():
    assert json_text({"a": "×\x1b\x7f\x9b\u202e"}).isascii()
    assert "\x7f" not in json_text({"a": "\x7f"})
