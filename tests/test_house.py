"""The laws of the house that no tool checks for us."""

import ast
import inspect
import json
import re
import subprocess
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import symrt

HOME = Path(__file__).parents[1]
MODULES = sorted((HOME / "symrt").rglob("*.py"))
TEXTS = [
    path
    for pattern in ("*.md", "*.toml", "*.txt", ".ci/run", "scenes/**/*", "symrt/**/*", "tests/**/*", "notebooks/**/*")
    for path in HOME.glob(pattern)
    if path.suffix in {".py", ".md", ".toml", ".txt", ".ipynb", ".js", ".json", ".obj", ".mtl", ".csv", ".html", ""}
    and path.is_file()
    and path != Path(__file__)
]


def test_every_public_function_shows_an_example():
    public = {name: inspect.unwrap(getattr(symrt, name)) for name in symrt.__all__ if name != "__version__"}
    functions = {name: value for name, value in public.items() if inspect.isfunction(value)}
    assert len(functions) > 10
    assert [name for name, function in functions.items() if ">>> " not in (inspect.getdoc(function) or "")] == []


def test_importing_symrt_and_its_command_line_pays_for_nothing_slow():
    heavy = ["numba", "sympy", "trimesh", "colour", "matplotlib", "scipy.optimize", "pydantic"]
    ask = f"import sys, symrt, symrt.cli; print(*(name for name in {heavy} if name in sys.modules))"
    answer = subprocess.run([sys.executable, "-c", ask], capture_output=True, text=True, check=True, cwd=HOME)
    assert answer.stdout.split() == []


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(HOME)))
def test_a_module_evaluates_no_text_and_hides_no_shapes(path):
    text = path.read_text()
    assert "from __future__ import annotations" not in text, "it hides the shapes from the checker"
    called = {
        node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", None)
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Call)
    }
    assert called.isdisjoint({"eval", "exec", "sympify", "parse_expr", "__import__"})


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(HOME)))
def test_a_module_can_be_read_in_one_sitting(path):
    assert path.read_text().count("\n") <= 350


def test_nothing_loads_a_pickle():
    for path in MODULES:
        assert not re.search(r"^\s*(import|from) (pickle|marshal|shelve|joblib|dill)\b", path.read_text(), re.MULTILINE)
        assert "allow_pickle=True" not in path.read_text()


def test_nothing_names_a_registry_or_one_machine_s_folders():
    private = re.compile(
        r"pypi\.org|pythonhosted|npmjs|deb\.debian|index-url|find-links|file:///|/(?:root|home|work|opt)/"
    )
    found = {str(path.relative_to(HOME)): private.findall(path.read_text()) for path in TEXTS}
    assert {name: words for name, words in found.items() if words} == {}


def test_constraints_are_versions_only():
    lines = [line for line in (HOME / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert len(lines) > 50
    assert [line for line in lines if not re.fullmatch(r"[A-Za-z0-9_.-]+==[0-9][A-Za-z0-9.]*", line)] == []


def test_constraints_pin_everything_that_is_asked_for():
    project = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *(line for extra in project["optional-dependencies"].values() for line in extra)]
    names = {re.match(r"[A-Za-z0-9._-]+", line)[0] for line in asked} - {"symrt"}
    pinned = {line.split("==")[0] for line in (HOME / "constraints.txt").read_text().splitlines()}
    assert {canonical(name) for name in names} <= {canonical(name) for name in pinned}


def canonical(name):
    return re.sub(r"[-_.]+", "-", name).lower()


def _required(extras: set[str]) -> set[str]:
    """Distributions that an installation with some extras asks for, its own extras followed."""
    project = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]
    lines = [*project["dependencies"], *(line for extra in extras for line in project["optional-dependencies"][extra])]
    inner = {extra for line in lines if line.startswith("symrt[") for extra in line[6:-1].split(",")} - extras
    return _required(extras | inner) if inner else {re.match(r"[\w.-]+", line)[0].lower() for line in lines}


def test_the_notebook_extra_brings_all_that_notebooks_use():
    # colour-cxf was missing, so that one of them stopped in the middle.
    used = set()
    for path in sorted((HOME / "notebooks").glob("*.ipynb")):
        cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
        for node in (node for cell in cells for node in ast.walk(ast.parse("".join(cell["source"])))):
            if isinstance(node, ast.Import):
                used |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                used.add(node.module.partition(".")[0])
            elif isinstance(node, ast.Call) and getattr(node.func, "id", "") == "find_spec":
                used.add(node.args[0].value)
    assert "colour_cxf" in used
    brought = _required({"notebook"})
    installed = packages_distributions()
    for name in used - sys.stdlib_module_names - {"symrt"}:
        assert brought & {distribution.lower() for distribution in installed[name]}, name
    assert {"jupyterlab", "ipykernel"} <= brought


def test_every_extra_is_named_where_it_is_needed():
    text = "\n".join(path.read_text() for path in [*MODULES, *(HOME / "tests").rglob("*.py"), HOME / "README.md"])
    extras = tomllib.loads((HOME / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    assert [name for name in extras if f"[{name}]" not in text and f"symrt[{name}" not in str(extras)] == []


APART = {
    *("partition", "rpartition", "split", "rsplit", "replace", "find", "rfind", "index", "count"),
    *("startswith", "endswith", "removeprefix", "removesuffix"),
}
"""Methods that take a text apart, or look at its ends."""
OTHER = {
    **dict.fromkeys(["reading.py", "scene/files.py", "scene/consistency.py"], "keys of a TOML file, camera.width"),
    **dict.fromkeys(["show/plots/region.py", "spectra/files.py"], "decimal points"),
    "device/cxf.py": "paths in XML",
}
"""Texts with dots that are no symbols."""


def marks(node) -> set[str]:
    """The marks of a symbol's syntax that a text, or an f-string, begins or ends with."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    texts = [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]
    return {text[end] for text in texts for end in (0, -1) if text} & {".", ">"}


def takes_a_symbol_apart(node) -> bool:
    """Whether a piece of code splits a text at a mark, asks if it has one, or puts one between two values."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in APART:
        given = [leaf for argument in node.args for leaf in getattr(argument, "elts", [argument])]
        return any(marks(leaf) for leaf in given)
    if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.In | ast.NotIn):
        return isinstance(node.left, ast.Constant) and node.left.value in (".", ">")
    if isinstance(node, ast.JoinedStr):
        inner = zip(node.values, node.values[1:], node.values[2:], strict=False)
        return any(
            isinstance(mark, ast.Constant)
            and mark.value in (".", ">")
            and isinstance(before, ast.FormattedValue)
            and isinstance(after, ast.FormattedValue)
            for before, mark, after in inner
        )
    return isinstance(node, ast.Attribute) and node.attr == "pattern" and getattr(node.value, "id", "") == "NAME"


def test_one_module_knows_how_a_symbol_is_written():
    found = {
        f"{path.relative_to(HOME / 'symrt')}:{node.lineno}"
        for path in MODULES
        if str(path.relative_to(HOME / "symrt")) not in {"symbols.py", *OTHER}
        for node in ast.walk(ast.parse(path.read_text()))
        if takes_a_symbol_apart(node)
    }
    assert found == set()


REACHED = {
    "archives": {"saving.py", "faults.py"},
    "another matrix is made of it": {"linear/stacking.py", "feedback/regions.py", "feedback/along.py"},
    "rows of coefficients are compared, summed or parted by their signs": {
        *("feedback/joint/outermost.py", "feedback/joint/objectives.py", "feedback/joint/posynomials.py"),
        "feedback/paints.py",
    },
    "rows in a cache, and the largest number": {"spectra/shading.py"},
    "its size is told": {"show/demo.py", "commands/rendering.py", "linear/estimate.py"},
}
"""Modules that reach into a system's matrix, by the reason why."""


def test_a_system_is_asked_and_its_matrix_left_alone():
    reached = {
        str(path.relative_to(HOME / "symrt"))
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute) and node.attr == "G"
    }
    assert reached - {"system.py"} == set().union(*REACHED.values())
