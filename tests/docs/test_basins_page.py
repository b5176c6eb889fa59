"""The page on basins gives the numbers by which regions are found and labels are checked."""

from pathlib import Path

import pytest

from rotor_ida.basins import attractors, cycle_sections, fates, following, known
from rotor_ida.basins.atlas import shocks
from rotor_ida.steady import follow

PAGE = (Path(__file__).parents[2] / "docs" / "basins.md").read_text("utf-8")
WORDS = {2: "two", 3: "three", 5: "five", 8: "eighth", 12: "twelve", 20: "twenty"}


@pytest.mark.parametrize(
    "said",
    [
        f"{known.STATES} such states were followed",
        f"{cycle_sections.STATES} states on each of {WORDS[len(cycle_sections.SHELLS)]} shells",
        f"with an error of {cycle_sections.TOLERANCE:g} in a step",
        f"the set is {cycle_sections.CAUTION:g} as wide",
        f"{shocks.PHASES} phases, {shocks.DIRECTIONS} directions and {WORDS[len(shocks.SHELLS)]}",
        f"sizes returned to the set; {shocks.CAUTION:g} of that",
        f"{WORDS[int(fates.CLEAR_ERRORS)]} of its errors above zero",
        f"reset to it every {fates.SPAN:g} time units, at least {WORDS[fates.SPANS]} times",
        f"and at most {fates.MOST_SPANS} times",
        f"at an error of {fates.CLOSELY:g} in a step",
        f"until {follow.LONGEST_DECAY_TIMES:g}/ζ (at least {follow.LONGEST:,.0f}, at most "
        f"{follow.LONGEST_OF_ALL:,.0f})",
        f"at most {WORDS[attractors.WITNESSES]}, until one reaches the same attractor",
        f"one in {WORDS[following.ONE_START_OF]} of every {WORDS[following.ONE_BATCH_OF]} batch",
        f"one in {following.ONE_OF_ROTOR}, at most {following.MOST_OF_ROTOR}",
        f"(at least {following.TIGHTEST:g})",
    ],
)
def test_numbers_are_those_of_the_code(said):
    assert said in " ".join(PAGE.split())
