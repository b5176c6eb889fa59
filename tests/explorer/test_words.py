"""The sentences and sheets say what the numbers say."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from rotor_ida.explorer.words import (
    numbers_of_response,
    sheet_of,
    words_of_response,
    words_of_run,
    words_of_whip,
)
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from tests.explorer.asking import MACHINE, ROTOR

PLAIN, IN_SI = Rotor(**ROTOR), DimensionalRotor(**MACHINE)
SCALES = {"length": 1e-6, "time": 2e-3, "force": 1.0, "energy": 1e-6}
CYCLE = {
    "response": "bouncing", "lies_on": "cycle", "digits": 11.98, "radius_min": 1.5,
    "radius_max": 2.5, "period": 4.5, "contact_fraction": 0.25, "contacts_per_revolution": 0.4,
    "largest_force": 0.5, "message": "",
}  # fmt: skip
FREE = {
    "response": "contact_free", "lies_on": "whirl", "digits": 12.0, "radius_min": 0.227,
    "radius_max": 1.773, "contact_fraction": 0.0, "largest_force": 0.0,
    "contacts_per_revolution": 0.0,
}  # fmt: skip


def rows(told: Mapping[str, Any], scales: Mapping[str, float] | None = None) -> dict[str, str]:
    """Return the rows of a sheet, by quantity, each value with its unit."""
    (sheet,) = sheet_of("Motion", scales or {}, told)
    return {name: f"{value} {unit}".strip() for name, value, unit in sheet["rows"][1:]}


@pytest.mark.parametrize(
    ("all_", "fraction", "told"),
    [
        (0.0, 0.0, ["It never touches the stator."]),
        (12.0, 0.0, ["It has touched the stator, but no longer does."]),
        (12.0, 0.25, []),
    ],
)
def test_that_a_run_does_not_touch_is_said(all_: float, fraction: float, told: list[str]):
    assert words_of_run({"contacts_in_all": all_, "contact_fraction": fraction}) == told


def test_a_sheet_has_the_numbers_of_a_limit_cycle_in_the_units_of_the_rotor():
    told = numbers_of_response(PLAIN, CYCLE)
    assert rows(told) == {
        "smallest radius": "1.5", "largest radius": "2.5", "repeats after": "4.5",
        "contacts a revolution": "0.4", "time in contact": "25 %", "largest force": "0.5",
        "digits that agree with the exact one": "11",
    }  # fmt: skip
    assert list(rows(told, SCALES).values()) == [
        "1.5 µm", "2.5 µm", "9 ms", "0.4", "500 mN", "25 %", "11",
    ]  # fmt: skip


def test_what_is_not_known_or_does_not_occur_has_no_row():
    told = numbers_of_response(PLAIN, FREE)
    assert list(rows(told)) == ["smallest radius", "largest radius",
                                "digits that agree with the exact one"]  # fmt: skip
    lost = numbers_of_response(PLAIN, CYCLE | {"lies_on": "nothing", "period": math.nan})
    assert not {"repeats after", "digits that agree with the exact one"} & rows(lost).keys()


def test_loss_heat_and_ways_of_slipping_are_in_the_sheet():
    told = {"rolling_fraction": 0.6, "slipping_forward_fraction": 0.4,
            "slipping_backward_fraction": 0.0, "heat_per_revolution": 0.25,
            "loss_per_contact": 0.5, "releases": 3.0}  # fmt: skip
    assert rows(told, SCALES) == {
        "of it rolling": "60 %", "of it slipping forwards": "40 %", "heat a revolution": "250 nJ",
        "loss of a contact": "500 nJ", "releases before leaving the stator": "3",
    }  # fmt: skip


def test_chaos_has_the_time_in_which_neighbours_part_and_a_load_the_sag():
    told = CYCLE | {"response": "chaotic", "lies_on": "nothing", "lyapunov_exponent": 0.05}
    found = numbers_of_response(PLAIN, told)
    assert rows(found, SCALES)["neighbours part e-fold in"] == "40 ms"
    held = replace(PLAIN, load=0.125, shaft_stiffness=0.25)
    assert rows(numbers_of_response(held, FREE))["centre below the axis"] == "0.5"


def test_a_rotor_without_spin_comes_to_rest():
    still = replace(PLAIN, omega=0.0)
    assert words_of_response(still, FREE) == "It comes to rest inside the clearance."
    centred = words_of_response(still, FREE | {"radius_max": 1e-9})
    assert centred == "It comes to rest at the centre of the stator."
    lying = words_of_response(still, FREE | {"response": "synchronous"})
    assert lying == "It comes to rest on the stator."


def test_with_a_shaft_there_is_one_contact_free_whirl_unless_a_load_moves_it():
    shaft = replace(PLAIN, shaft_stiffness=0.25)
    told = words_of_response(shaft, FREE)
    assert told.startswith("It settles on the contact-free whirl, which is the only one")
    for other in (PLAIN, replace(shaft, load=0.5)):
        assert words_of_response(other, FREE).startswith("It settles on a contact-free whirl")


def test_dry_whip_is_told_in_the_units_of_the_machine():
    assert "dry whip would have a radius of 5 µm, and a backward whirl beyond 3.25 µm" in (
        words_of_whip(IN_SI, 3.25, 5.0, 0.25)
    )
    assert "any backward whirl on the stator would grow" in words_of_whip(PLAIN, math.nan, 5.0, 0.0)
    assert words_of_whip(IN_SI, math.nan, math.nan, 0.25) == (
        "Without unbalance dry whip begins at a speed of 1,194 rpm."
    )
    weak = words_of_whip(PLAIN, math.nan, math.nan, math.nan)
    assert weak == "Friction is too weak for dry whip at any speed."
