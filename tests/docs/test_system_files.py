"""The page on system files: its example is that of the code, runs, and all entries are there."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from rotor_ida import Contact, Race, Stator, Support, Unbalance
from rotor_ida.cli import main
from rotor_ida.results import system_file

PAGE = (Path(__file__).parents[2] / "docs" / "system_files.md").read_text(encoding="utf-8")


def blocks(kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def test_the_example_runs_as_the_page_shows(tmp_path, monkeypatch, capfd):
    (text,) = blocks("toml")
    documented = [line[4:] for line in system_file.__doc__.splitlines() if line.startswith("    ")]
    # without blank lines, whose number a docstring does not keep
    assert [line for line in text.splitlines() if line] == [each for each in documented if each]
    monkeypatch.delenv("COLUMNS", raising=False)
    monkeypatch.chdir(tmp_path)
    Path("rotor.toml").write_text(text)
    for block in blocks("console"):
        line, _, expected = block.partition("\n")
        assert main(line.split()[2:]) == 0
        assert capfd.readouterr().out.startswith(expected)
    (code,) = blocks("python")
    names = {}
    exec(code, names)
    assert names["run"].sizes["event"] > 0
    assert names["passage"].sizes["event"] > 0


def fields_of(kind):
    return tuple(each.name for each in fields(kind))


@pytest.mark.parametrize(
    ("table", "known"),
    [
        ("", system_file.TOP),
        ("system.", ("file", *system_file.OF_SYSTEM)),
        ("contacts.", fields_of(Contact)),
        ("stators.", fields_of(Stator)),
        ("stators.race.", fields_of(Race)),
        ("unbalance.", fields_of(Unbalance)),
        ("supports.", fields_of(Support)),
        ("bearings.", ("node", "stator", "table", "speed", *system_file.COEFFICIENTS)),
        ("drop.", (*system_file.OF_DROP, "failing", "clearances", "capacities", "vary", "grid")),
        ("run_up.", (*system_file.OF_RUN_UP, "speeds", "torque")),
    ],
)
def test_the_page_lists_the_entries_that_the_code_knows(table, known):
    entries = re.findall(r"^\| (`.*?`) \|", PAGE, re.MULTILINE)
    listed = {name for entry in entries for name in re.findall("`(.*?)`", entry)}
    here = {name.removeprefix(table) for name in listed if name.startswith(table)}
    assert {name for name in here if "." not in name} == set(known)
