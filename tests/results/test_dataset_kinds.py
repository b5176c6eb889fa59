"""The registry of kinds of result: every dataset that is made has a row, and every row works."""

import ast
from pathlib import Path

import pytest
import xarray as xr

import rotor_ida
from rotor_ida.cycles.dataset import TITLES
from rotor_ida.results.dataset_kinds import KINDS, kind_of, loaded
from rotor_ida.schema import RESULT_KIND
from rotor_ida.verification.comparison_rules import VERIFIED

PACKAGE = Path(rotor_ida.__file__).parent
# They hand the kind on that they are given.
HANDED_ON = {
    "signals/record.py", "cycles/dataset.py", "cycles/continue_cycle.py", "steady/sweep.py",
    "basins/dataset.py", "basins/atlas/dataset.py",
}  # fmt: skip
# One function builds cycles, branches and curves, of one disc and of systems.
OF_CURVES = {
    f"{of}{kind}" for kind in ("cycle", *dict(TITLES.values()).values()) for of in ("", "system_")
}
# Another builds studies of both.
OF_STUDIES = {
    "sweep", "run_ups", "bifurcation_diagram", "stroboscopic_diagram",
    "system_sweep", "system_run_ups", "system_diagram", "system_stroboscopic_diagram",
}  # fmt: skip
# And two those of basins and atlases.
OF_BASINS = {
    "basin", "basin_fractions", "touchdown", "atlas", "system_touchdown", "system_atlas"
}  # fmt: skip
BUILDERS = {
    "labelled_dataset", "dataset", "branch_dataset", "labelled_cycles", "labelled_run_ups"
}  # fmt: skip


def stated_kinds():
    """Return the kind in each call that builds a dataset, by file and line."""
    found = {}
    for path in PACKAGE.rglob("*.py"):
        place = path.relative_to(PACKAGE).as_posix()
        for node in ast.walk(ast.parse(path.read_text())):
            given, name = {}, ""
            if isinstance(node, ast.Call):
                name = getattr(node.func, "id", getattr(node.func, "attr", ""))
                given = {each.arg: each.value for each in node.keywords}
            elif isinstance(node, ast.Dict):
                given = {getattr(key, "value", None): value for key, value in
                         zip(node.keys, node.values, strict=True)}  # fmt: skip
            if name in BUILDERS:
                found[place, node.lineno] = getattr(given.get("kind"), "value", None)
            elif RESULT_KIND in given:
                found[place, node.lineno] = given[RESULT_KIND].value
    return found


def test_each_dataset_that_the_package_builds_states_a_kind_of_the_registry():
    stated = stated_kinds()
    without = {place for place, kind in stated.items() if kind is None}
    assert {file for file, _ in without} <= HANDED_ON, without
    told = {kind for kind in stated.values() if kind is not None}
    assert told | OF_CURVES | OF_STUDIES | OF_BASINS == KINDS.keys() - {"other"}
    assert VERIFIED.keys() < KINDS.keys()


@pytest.mark.parametrize("kind", KINDS)
def test_what_a_row_names_exists(kind):
    row = KINDS[kind]
    for place in filter(None, (row.shown, row.drawn)):
        assert callable(loaded(place)), place


def test_the_page_on_datasets_has_each_kind():
    page = (PACKAGE.parent / "docs" / "datasets.md").read_text()
    first_columns = {line.split("|")[1].strip() for line in page.splitlines() if "|" in line}
    listed = {name for column in first_columns for name in column.split(", ")}
    assert {kind.meaning for kind in KINDS.values() if kind.name != "other"} <= listed


def test_a_result_made_from_another_states_its_own_kind():
    whirls = rotor_ida.synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    assert whirls.attrs[RESULT_KIND] == kind_of(whirls) == "whirls"
    compared = rotor_ida.compare(rotor_ida.sweep(omega=1.7, zeta=0.5, delta0=0.5))
    assert compared.attrs[RESULT_KIND] == kind_of(compared) == "comparison"
    assert kind_of(compared.drop_vars("matched_branch")) == "other"
    assert kind_of(whirls.assign_attrs({RESULT_KIND: "unheard_of"})) == "other"


def test_signals_made_by_hand_are_known_by_their_variables():
    made = xr.Dataset({"x": ("t", [0.0, 1.0]), "y": ("t", [1.0, 0.0])}, {"t": [0.0, 0.1]})
    assert (kind_of(made), kind_of(made.drop_vars("y"))) == ("signals", "other")
