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

SLOW = {"glass", "lens", "many_lights", "prism", "cornell", "tinted", "sky"}
"""Scenes that cost many rays."""
DEAR_SCENES = {
    "test_the_array_path_is_the_literal_pipeline": SLOW,
    "test_printed_formula_evaluates_to_the_shaded_pixel": SLOW,
    "test_python_code_gives_every_lit_pixel": SLOW,
    "test_letters_and_linear_form_have_the_same_monomials": SLOW,
    "test_tiles_and_1_2_and_8_workers_give_the_same_bits": SLOW,
    "test_what_formulas_say_is_read_back_as_the_system": SLOW,
    "test_every_scene_looks_as_a_scalar_tracer_sees_it": SLOW,
    "test_at_any_depth_what_is_missing_is_bounded": SLOW,
    "test_columns_in_the_order_met_merge_into_the_sorted_system": SLOW,
}
"""By the test, scenes that it is asked about when time does not matter."""
DEAR = {
    "test_exactly_the_pixels_named_are_outside_and_it_is_never_worse_than_with_none": (
        "brightest-0.03",
        "contrast-0.03",
    ),
    "test_order_and_names_do_not_matter": ("contrast-0.08", "brightest-0.08", "closest-0.08"),
    "test_no_random_scales_inside_are_better": ("contrast-0.08", "brightest-0.08"),
    "test_the_range_is_that_of_the_pixels_that_some_value_brings_inside": (
        "inks-exposure",
        "inks-mirrors",
        "inks-blend",
    ),
    "test_feasible_takes_every_model": ("inks",),
    "test_what_is_accepted_meets_the_criteria_as_another_library_sees_them": (
        "{'least_inside': 0.95, 'most_difference': 1.4}-closest",
    ),
    "test_gamuts_of_any_model_are_asked_themselves": ("inks",),
    "test_pixels_above_black_stay_so": ("contrast",),
}
"""By the test, cases that take seconds of solvers each."""


def pytest_configure(config: pytest.Config) -> None:
    """Give each of several workers one processor: threads of linear algebra would only fight over them."""
    if config.getoption("numprocesses", None):
        os.environ["OPENBLAS_NUM_THREADS"] = "1"


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark cases that take seconds each as exhaustive: the cheap cases of the same tests are run at once."""
    for item in items:
        case = item.callspec.id if isinstance(item, pytest.Function) and hasattr(item, "callspec") else ""
        name = item.name.partition("[")[0]
        if (name in DEAR_SCENES and DEAR_SCENES[name].intersection(case.split("-"))) or case in DEAR.get(name, ()):
            item.add_marker(pytest.mark.exhaustive)


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
