"""The command line says what the library says, and ends bad input in one line."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import typer

import symrt as rt
from symrt import cli

SMALL = ["--size", "24"]
HEAVY = {"colour", "imageio", "matplotlib", "numpy", "pydantic", "rich", "scipy", "sympy", "tqdm", "trimesh"}
COMMANDS = typer.main.get_command(cli.app).commands  # type: ignore[attr-defined]


def python(*words: str) -> "subprocess.CompletedProcess[str]":
    home = {**os.environ, "PYTHONPATH": str(Path(rt.__file__).parents[1])}
    return subprocess.run([sys.executable, *words], capture_output=True, text=True, check=False, env=home)


BAD_WORDS = [
    ["nope"],
    ["plan"],
    ["plan", "nosuch"],
    ["plan", "missing/scene.toml"],
    ["plan", "globe", "--nope"],
    ["plan", "x" * 5000],
    ["plan", "bad\0name"],
    ["probe", "first", "--rays", "0"],
    ["render", "first", "--size", "0"],
    ["render", "first", "--size", "-3"],
    ["render", "first", "--size", "9" * 40],
    ["render", "first", "--size", "24x"],
    ["render", "first", "--size", "99999"],
    ["render", "first", "--samples", "0"],
    ["render", "first", "--samples", "two"],
    ["render", "first", "--workers", "0"],
    ["render", "first", "--out", "missing/first.npz"],
    ["render", "first", "--out", "first.png"],
    ["render", "first", "--out", "."],
    ["render", "first.npz"],
    ["render", "globe", "--size", "8", "--alternative", "brass"],
    ["render", "globe", "--size", "8", "--alternative", "brass:nope"],
    ["formula", "first", "--x", "999", "--y", "0"],
    ["formula", "first", "--x", "-1", "--y", "0"],
    ["formula", "first", "--x", "1"],
    ["formula", "missing.npz", "--x", "1", "--y", "1"],
    ["shade", "first", *SMALL],
    ["shade", "first", *SMALL, "--palette", "plan"],
    ["shade", "first", *SMALL, "--palette", "plain", "--exposure", "0"],
    ["shade", "first", *SMALL, "--palette", "plain", "--exposure", "nan"],
    ["shade", "first", *SMALL, "--palette", "plain", "--reference", "moon"],
    ["shade", "first", *SMALL, "--palette", "plain", "--out", "first.gif"],
    ["shade", "missing.npz", "--palettes", "first", "--palette", "plain"],
    ["shade", "missing.npz"],
    ["gamut", "nope"],
    ["gamut", "missing.npz"],
    ["gamut", "--device", "missing.npz"],
    ["gamut", "dye3-endura-premier"],
    ["gamut", "chart.ti3", "--palettes", "first"],
    ["gamut", "--palette", "plain"],
    ["gamut", "--exposure", "2"],
    ["gamut", "--components", "0", "1", "3"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--components", "0", "0", "1"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--components", "0", "-1", "1"],
    ["gamut", "--tolerance", "0.1"],
    ["gamut", "--model", "hull", "--light", "illuminant/A"],
    ["gamut", "--model", "hull", "--tolerance", "-1"],
    ["gamut", "--model", "colorimetric", "--light", "D50"],
    ["gamut", "--device", "crt-brainard", "--resample"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--device", "srgb", "--resample"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:red"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--within", "3", "1"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--exposure", "0"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--reference", "moon"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--components", "0", "1", "36", "--plot", "a.png"],
    ["gamut", "first", *SMALL, "--palette", "plain", "--device", "crt-brainard", "--plot", "a.png"],
    ["gamut", "--model", "unitt"],
    ["gamut", "--black", "nope"],
    ["gamut", "--model", "nope"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "exposure"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:nothing"],
    ["gamut", "--model", "hull", "--black", "strict"],
    ["gamut", "--device", "crt-brainard", "--model", "hull"],
    ["gamut", "--device", "crt-brainard", "--black", "strict"],
    ["gamut", "--device", "dye3-endura-premier+nope"],
    ["gamut", "--device", "dye3-endura-premier+crt-brainard", "--plot", "a.png"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--model", "hull"],
    ["feasible", "first", *SMALL, "--palette", "rgb", "-p", "scale:red", "--device", "crt-brainard"],
    ["report", "first", *SMALL, "--palette", "plain", "--model", "nope"],
    ["report", "first", *SMALL, "--palette", "plain", "--plot", "a.gif"],
    ["gamut", "--plot", "gamut.gif"],
    ["shade", "first", *SMALL, "--palette", "plain", "--out", "first.npz", "--exposure", "2"],
    ["feasible", "first", "--palette", "plain"],
    ["feasible", "globe", *SMALL, "--palette", "macbeth", "-p", "blend:upland:ice", "--within", "0", "3"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:blue"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:__import__('os')"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "blend:red"],
    ["feasible", "globe", *SMALL, "--palette", "macbeth", "-p", "blend:upland:ice:oil"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "blend:red:blue"],
    ["feasible", "first", *SMALL, "--palette", "rgb", "-p", "scale:red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--within", "3", "1"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--allowed-out", "2"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--device", "nope"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "blend:red:red"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:red.diffuse"],
    ["fit", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--objective", "prettiest"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--together", "--allowed-out", "0.1"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--together", "--of", "red"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--of", "nothing"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "--region", "region.png"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:red", "--region", "a.png"],
    ["feasible", "first", *SMALL, "--palette", "plain", "-p", "scale:red", "-p", "scale:sun", "--region", "a.gif"],
    ["demo", "--scene", "nosuch"],
    ["demo", "--size", "0"],
]


@pytest.mark.parametrize("words", BAD_WORDS, ids=lambda words: " ".join(words)[:60].replace("\0", "0"))
def test_bad_input_ends_in_one_line_and_code_2_with_nothing_written(run, tmp_path, written, words):
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert err.startswith("symrt: ")
    assert err.count("\n") == 1
    assert len(err) < 700
    assert written(tmp_path) == []


def test_a_scene_with_several_faults_gives_a_line_for_each(run, tmp_path):
    scene = rt.shipped_scene("first").read_text()
    (tmp_path / "bad.toml").write_text(
        scene.replace("radius = 1", "radius = -1").replace("exponent = 40", "exponent = nan")
    )
    code, out, err = run("plan", "bad.toml")
    assert (code, out) == (2, "")
    lines = err.splitlines()
    assert len(lines) == 2
    assert all(line.startswith("symrt: bad.toml: ") for line in lines)


@pytest.mark.parametrize("content", [b"", b"not a zip", b"PK\x03\x04" + bytes(100)])
def test_damaged_systems_and_gamuts_end_in_one_line(run, tmp_path, content):
    (tmp_path / "bad.npz").write_bytes(content)
    for words in (["formula", "bad.npz", "--x", 0, "--y", 0], ["gamut", "--device", "bad.npz"]):
        code, out, err = run(*words)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "bad.npz" in err


def test_a_folder_that_cannot_be_made_ends_in_one_line(run, tmp_path, written):
    (tmp_path / "out").write_text("a file stands where the folder should")
    code, out, err = run("demo", "--scene", "globe", "--size", "8", "--out", "out")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "out" in err
    assert written(tmp_path) == ["out"]


def test_a_full_disk_leaves_no_half_written_file(run, tmp_path, written, monkeypatch):
    def full(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    code, out, err = run("render", "first", *SMALL)
    assert (code, out, err) == (2, "", "symrt: first.npz: No space left on device\n")
    assert written(tmp_path) == []


def test_an_interrupt_ends_with_code_130_and_no_traceback(run, monkeypatch):
    def interrupted(*_args, **_options):
        raise KeyboardInterrupt

    monkeypatch.setattr(rt, "load_scene", interrupted)
    assert run("render", "first") == (130, "", "")


def test_help_imports_nothing_slow():
    done = python(
        "-c", f"from symrt.cli import main; main(['--help']); import sys; print(sorted({HEAVY} & {{*sys.modules}}))"
    )
    assert "Usage: symrt" in done.stdout
    assert done.stdout.splitlines()[-1] == "[]"


def test_python_m_symrt_is_the_command_line():
    done = python("-m", "symrt", "--version")
    assert (done.returncode, done.stdout) == (0, f"symrt {rt.__version__}\n")
    bad = python("-m", "symrt", "plan", "nosuch")
    assert (bad.returncode, bad.stdout, bad.stderr.count("\n")) == (2, "", 1)


def test_no_words_show_the_help(run):
    code, out, err = run()
    assert (code, err) == (0, "")
    assert all(name in out for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_shows_an_example_that_it_understands(run, name):
    code, out, _ = run(name, "--help")
    assert code == 0
    example = " ".join(out.split("Example: ")[1].split("Options:")[0].split("Arguments:")[0].split())
    program, command, *words = example.split()
    assert (program, command) == ("symrt", name)
    COMMANDS[name].make_context(name, words)  # raises if it does not


def test_a_picture_too_large_for_the_machine_ends_in_one_line(run, monkeypatch):
    def too_large(*_arguments, **_options):
        raise MemoryError("Unable to allocate 36.0 GiB for an array with shape (134217728, 36)")

    monkeypatch.setattr(rt, "shade", too_large)
    code, _, error = run("shade", "first", "--palette", "plain", "--out", "a.png", "--size", "16")
    assert code == 2
    assert error.splitlines() == ["symrt: Unable to allocate 36.0 GiB for an array with shape (134217728, 36)"]
