"""The guide names every module that knows the forces on one disc by hand."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
# The rooms in which a disc moves; what is exact has its own row as a whole.
ROOMS = ("model", "core", "simulation", "steady", "cycles", "basins", "signals", "plot",
         "verification")  # fmt: skip
OF_A_FORCE = re.compile(
    r"\b(?:rotor|model|m)(?:\.|->)(?:shaft_stiffness|contact_damping|load|friction)\b"
    # or in a list
    r"|[{(]\"(?:contact_damping|load|friction)\", \"(?:contact_damping|load|friction)\""
)


def named_in_the_guide() -> set[str]:
    """Return the modules that the section on a new force names."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    section = text.partition("**A force.**")[2].partition("**A law of contact.**")[0]
    return set(re.findall(r"`((?:\w+/)+\w+\.(?:py|c|h))`", section))


def test_all_that_know_a_force_are_named():
    package = ROOT / "rotor_ida"
    knowing = {
        file.relative_to(package).as_posix()
        for room in ROOMS
        for file in (package / room).rglob("*.*")
        if file.suffix in {".py", ".c", ".h"}
        and not file.name.startswith("derived")
        and OF_A_FORCE.search(file.read_text(encoding="utf-8"))
    }
    assert len(knowing) > 40
    assert sorted(knowing - named_in_the_guide()) == []


def test_all_that_are_named_exist():
    missing = {each for each in named_in_the_guide() if not each.startswith(("tests", "benchmarks"))
               and not (ROOT / "rotor_ida" / each).exists()}  # fmt: skip
    assert missing == set()
