"""The page of errata says what its numbers say, and the numbers are those of the physics."""

from pathlib import Path

import pytest

from rotor_ida.paper.errata import errata_page, numbers, page

PAGE = Path(__file__).parents[3] / "docs" / "errata.md"
# Computed twice before this program was written; to the digits given.
KNOWN = {
    "force": {"below": 0.3536, "above": 1.0230},
    "periods": {"small": 5.28351, "large": 3.73600},
    "portraits": {"longer": 4.746},
    "single_response": {"printed": 2.52403, "small": 1.87963, "middle": 6.19321, "large": 9.48721},
    "phases": {"argument": -2.98617},
    "with_clearance": {"amplitude": 4.31900, "printed_amplitude": 2.13615, "lag": 0.52809,
                       "printed_lag": 2.98142},
    "unstable": {"amplitude": 6.19321, "growth": 0.09830},
    "captions": {"rest": 1.87963, "ten": 9.48721},
    "cusps": {"without": 0.15604517},
    "clearance": {"a": 3.363, "b": 4.319, "c": 5.214, "d": 6.873},
}  # fmt: skip


@pytest.fixture(scope="module")
def made():
    return errata_page()


def test_page_is_what_its_numbers_say(made):
    assert made == PAGE.read_text(encoding="utf-8"), (
        "make it: python -m rotor_ida.paper.errata FILE"
    )


def test_every_row_of_the_table_is_whole(made):
    rows = [line for line in made.splitlines() if line.startswith("| ")]
    assert len(rows) == len(page.ROWS) + 1
    assert all(row.replace("\\|", "").count("|") == 5 for row in rows)
    assert "{" not in made


@pytest.mark.parametrize("name", KNOWN)
def test_numbers_that_were_known_before(name):
    found = getattr(numbers, name)()
    for key, value in KNOWN[name].items():
        digits = len(str(value).partition(".")[2])
        # trailing zeros are not seen in the literal
        assert found[key] == pytest.approx(value, abs=0.6 * 10.0 ** -min(digits, 5)), key


def test_cuts_through_the_basin_are_one_stretch_each():
    assert numbers.basin_cuts()["changes"] == 4


def test_rotor_with_wide_clearance_bounces_and_never_reaches_the_branch():
    found = numbers.agreement()
    assert found["bounces"] == 1.0
    assert found["reached"] == 0
    assert found["with_branch"] == 4


def test_scaling_holds_to_the_digits_that_the_integrations_have():
    found = numbers.scaling()
    assert found["right"] < 5e-12
    assert found["printed"] > 1.0


def test_error_of_the_general_solution():
    assert numbers.transient()["printed"] == pytest.approx(18.0, abs=0.01)


def test_a_number_beyond_its_bound_is_not_printed():
    row = page.Row("(9)", "", "", "{right_bound:.0e}", lambda: {"right": 1e-3})
    with pytest.raises(ValueError, match=r"\(9\): right must be below 5e-12, got 0\.001"):
        page._line(row)
