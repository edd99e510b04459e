"""What every test shares: laws are drawn the same way each time in CI, and nothing is left out there."""

import os

import pytest
from hypothesis import settings

IN_CI = bool(os.environ.get("CI"))

settings.register_profile("ci", derandomize=True, deadline=None, database=None, print_blob=True)
settings.register_profile("here", deadline=None)
settings.load_profile("ci" if IN_CI else "here")

MISSING: list[str] = []


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Remember the tests that were skipped because something optional is not installed."""
    if report.skipped and "not installed" in str(report.longrepr):
        MISSING.append(report.nodeid)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """In CI everything optional is installed, so that a skip for want of it is a failure."""
    if IN_CI and MISSING and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
        session.config.get_terminal_writer().line(f"skipped in CI for want of a package: {', '.join(MISSING)}")
