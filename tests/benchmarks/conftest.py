"""The globe at 512², rendered once for all benchmarks, and a table of what was measured, printed at the end."""

from pathlib import Path

import pytest
from benchmarks.pairs import machine

import symrt as rt

SCENE = Path(__file__).parents[2] / "scenes" / "globe.toml"
ROWS: list[str] = []


@pytest.fixture(scope="session")
def globe() -> rt.Scene:
    scene = rt.load_scene(SCENE)
    assert (scene.camera.width, scene.camera.height) == (512, 512)
    return scene


@pytest.fixture(scope="session")
def system(globe) -> rt.LinearSystem:
    return rt.render(globe, progress=False)


@pytest.fixture(scope="session")
def palette() -> rt.Palette:
    return rt.load_palettes(SCENE)["macbeth"]


@pytest.fixture
def report():
    """Keep one line of the table: what, how many times another thing, and seconds."""
    return ROWS.append


def pytest_terminal_summary(terminalreporter) -> None:
    if ROWS:
        terminalreporter.section(f"speed on {machine()}")
        for row in ROWS:
            terminalreporter.write_line(row)
