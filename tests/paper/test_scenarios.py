"""The scenarios run, write what they say, and say something of every figure."""

import re
from functools import partial
from pathlib import Path

import pytest

from rotor_ida import load
from rotor_ida.paper import freshness
from rotor_ida.paper import scenario as paper_scenario
from rotor_ida.paper.gallery import read_entries
from rotor_ida.paper.reproduction import scenario_scripts
from rotor_ida.paper.scenario import Settings
from rotor_ida.plot import save_figure, saving
from rotor_ida.plot.appearance import SettledLayout
from tests.scenarios import scenario

# The others take longer: the site with coarse figures and `rotor-ida reproduce` run them, and of
# most the functions are tested beside this.
QUICK = ["dimensional_example", "drop", "event_time_convergence", "fig02_03_force_potential",
         "fig04_05_free_vibration", "fig08_09_whirls", "fitted_machine", "general_solution",
         "how_slow", "internal_resonance", "plots", "random_starts", "run_up", "way_to_whip",
         "whip_map"]  # fmt: skip

# What the site with coarse figures has computed, if it has been built.
OF_SITE = Path(__file__).parents[2] / "docs" / "results"
SPELLED_OUT = re.compile(r"\b(omega|zeta|delta0|sqrt)\b|\^|\de[-+]\d|\b[xyz]0?'")


def run_quickly(name, folder):
    module = scenario(name)
    folder.mkdir()
    module.main(Settings(folder, True, 1, False))
    return module


@pytest.mark.parametrize("name", QUICK)
def test_scenario_writes_archives_and_figures_with_words(name, tmp_path, monkeypatch):
    origin = freshness.origin_of(scenario_scripts()[name], ["--quick"])
    if freshness.is_fresh(OF_SITE / name, origin):
        check_words(scenario(name), OF_SITE / name)
        return
    # both formats are written below, in full, and laid out
    monkeypatch.setattr(paper_scenario, "save_figure", partial(save_figure, formats="png"))
    monkeypatch.setattr(saving, "_DOTS_PER_INCH", 50)
    monkeypatch.setattr(SettledLayout, "execute", lambda *_: None)
    module = run_quickly(name, tmp_path / name)
    check_words(module, tmp_path / name)


def check_words(module, folder):
    """Check the archives, and the words of each figure, that a scenario has written."""
    assert len(module.__doc__.splitlines()) > 2
    entries = read_entries(folder)
    drawn = {path.stem for path in folder.glob("*.png")}
    assert drawn == {entry.figure for entry in entries}
    for entry in entries:
        words = " ".join([entry.shows, entry.paper, entry.found, entry.verdict])
        assert not SPELLED_OUT.search(words)
        assert entry.shows.endswith(".")
        assert entry.found.endswith(".")
        for archive in entry.archives:
            dataset = load(folder / archive)
            for variable in dataset.data_vars.values():
                assert variable.attrs["long_name"]


def test_scenario_run_twice_gives_the_same_bytes(tmp_path):
    for turn in ("one", "two"):
        module = run_quickly("fig06_jumps", tmp_path / turn)
    check_words(module, tmp_path / "two")
    drawn = sorted((tmp_path / "one").glob("*.[ps][nv]g"))
    figures = {entry.figure for entry in read_entries(tmp_path / "one")}
    assert {path.name for path in drawn} == {f"{figure}.{ending}" for figure in figures
                                             for ending in ("png", "svg")}  # fmt: skip
    for path in drawn:
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
    first, second = (read_entries(tmp_path / turn) for turn in ("one", "two"))
    assert first == second
