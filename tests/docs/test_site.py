"""The sources of the site, as far as they can be checked without building it."""

import ast
import importlib.util
import re
import sys
import tomllib
from pathlib import Path

import pytest

from rotor_ida.core import library
from rotor_ida.errors import InstallationError

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def extension(name):
    spec = importlib.util.spec_from_file_location(name, DOCS / "_extensions" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_picture_of_the_layout_is_that_of_the_imports():
    layout = extension("layout")
    assert (DOCS / "layout.svg").read_text(encoding="utf-8") == layout.picture()


def test_arrows_lead_down_and_leave_out_what_others_imply():
    layout = extension("layout")
    rows = layout.layers()
    height = {part: number for number, row in enumerate(rows) for part in row}
    arrows = layout.arrows(rows)
    assert ("cycles", "steady") in arrows
    assert ("cli", "errors") not in arrows
    assert all(height[upper] < height[lower] for upper, lower in arrows)


def test_a_citation_names_the_version_that_is_released():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    cited = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), re.M)
    assert cited is not None
    assert cited[1] == project["version"]
    assert f"## {project['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_recipe_for_conda_has_the_version_and_the_bounds_of_the_project():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
    assert f'version: "{project["version"]}"' in recipe
    assert all(f"    - {name}\n" in recipe for name in project["license-files"])
    run = recipe.partition("  run:\n")[2].partition("\ntests:")[0]
    names = {"matplotlib": "matplotlib-base", "netCDF4": "netcdf4"}
    wanted = [f"python {project['requires-python']}", *(
        f"{names.get(name, name)} >={bound}"
        for name, bound in (
            each.partition(";")[0].split(">=") for each in project["dependencies"]
        )
    )]  # fmt: skip
    assert run.split("    - ")[1:] == [f"{each}\n" for each in wanted]


@pytest.mark.parametrize(
    "script", sorted((DOCS / "tutorial_scripts").glob("*.py")), ids=lambda path: path.stem
)
def test_prose_of_a_tutorial_states_no_measured_number(script):
    """Numbers stand in what is computed; prose has those of the machine that is described."""
    text = script.read_text(encoding="utf-8")
    prose = ast.get_docstring(ast.parse(text)) + "".join(re.findall(r"^#(.*)$", text, re.M))
    assert not re.search(r"\d\.\d{3,}", prose)


def test_without_a_core_the_build_ends_with_one_line(monkeypatch, capsys):
    def refuse():
        raise InstallationError("the compiled core is missing; run: pip install -e .")

    spec = importlib.util.spec_from_file_location("build", DOCS / "build.py")
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    monkeypatch.setattr(library, "build_info", refuse)
    monkeypatch.setattr(sys, "argv", ["build.py"])
    assert build.main() == 1
    said = capsys.readouterr()
    assert not said.out
    assert said.err == (
        "the site cannot be built: the compiled core is missing; run: pip install -e .\n"
    )
