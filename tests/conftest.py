"""What every test shares: laws are drawn the same way each time in CI, and nothing is left out there."""

import os
import re
from dataclasses import replace

import pytest
from hypothesis import settings

IN_CI = bool(os.environ.get("CI"))

settings.register_profile("ci", derandomize=True, deadline=None, database=None, print_blob=True)
settings.register_profile("here", deadline=None)
settings.load_profile("ci" if IN_CI else "here")

MISSING: list[str] = []


def pytest_configure(config: pytest.Config) -> None:
    """Give each of several workers one processor: threads of linear algebra would only fight over them."""
    if config.getoption("numprocesses", None):
        os.environ["OPENBLAS_NUM_THREADS"] = "1"


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Remember the tests that were skipped because something optional is not installed."""
    if report.skipped and "not installed" in str(report.longrepr):
        MISSING.append(report.nodeid)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """In CI everything optional is installed, so that a skip for want of it is a failure."""
    if IN_CI and MISSING and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
        session.config.get_terminal_writer().line(f"skipped in CI for want of a package: {', '.join(MISSING)}")


@pytest.fixture(scope="session", autouse=True)
def kernels():
    """Load the kernels first: no answer depends on it, but the time at which they are compiled is no test's own."""
    from symrt import fast  # noqa: PLC0415  # after the types are watched

    return fast.load()


@pytest.fixture
def run(capsys, monkeypatch, tmp_path):
    """The command line, in a folder of its own: exit code, standard output and standard error."""
    from symrt import cli  # noqa: PLC0415  # after the types are watched

    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> tuple[int, str, str]:
        code = cli.main([str(word) for word in words])
        said = capsys.readouterr()
        # What a slow machine shows of its progress is written over, as on a terminal.
        return code, said.out, re.sub(r"[^\n]*\r", "", said.err)

    return run


@pytest.fixture
def written():
    """Names of all that is in a folder."""
    return lambda folder: sorted(path.name for path in folder.rglob("*"))


@pytest.fixture
def system():
    """The smallest scene, rendered at 24 × 24."""
    import symrt as rt  # noqa: PLC0415  # as above

    scene = rt.load_scene("first")
    return rt.render(replace(scene, camera=replace(scene.camera, width=24, height=24)), progress=False)
