"""A machine in SI units on the page: its data sheet, its run-up, its verdict and its whip."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import backward_whirl, machine_from_data_sheet, run_up, summary
from rotor_ida.explorer.cases import PER_WHIRL
from rotor_ida.explorer.endings import whirls_per_revolution
from rotor_ida.explorer.messages import largest_speed, read_question, speeds_shown
from rotor_ida.explorer.motion import show_lines
from rotor_ida.explorer.words import verdict_of, words_of_run_up
from rotor_ida.model.data_sheet import GRAVITY, KEYS
from rotor_ida.model.disc_starts import hanging
from rotor_ida.model.rotor import DimensionalRotor
from tests.explorer.asking import answer_to, question

RPM = math.pi / 30.0
SHEET = {
    "mass": "12 kg", "shaft_stiffness": "4 MN/m", "damping_ratio": "3 %", "clearance": "150 um",
    "balance_grade": "G6.3", "balance_speed": "3600 rpm", "speed": "3600 rpm", "friction": "0.12",
    "contact_stiffness": "1e8 N/m", "disc_radius": "60 mm", "load": "",
}  # fmt: skip
PUMP = machine_from_data_sheet(**{name: words for name, words in SHEET.items() if words})
UP_TO = 6000.0 * RPM / PUMP.reference_frequency


def answer_to_sheet(quantities: dict[str, str]):
    asked = {"about": "machine", "number": 3, "quantities": quantities}
    (message,) = answer_to(read_question(json.dumps(asked)))
    return message


def test_a_data_sheet_gives_the_machine_of_the_library():
    message = answer_to_sheet(SHEET)
    assert (message.part, message.header["number"]) == ("machine", 3)
    state = dict(message.facts["state"])
    assert state.pop("fastest") == pytest.approx(6000.0 * RPM)
    assert DimensionalRotor(**state) == PUMP
    assert message.facts["notes"] == []


def test_an_unlikely_machine_is_shown_with_a_note():
    (note,) = answer_to_sheet(SHEET | {"friction": "1.5"}).facts["notes"]
    assert note.startswith("friction is 1.5")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"mass": ""}, "mass"),
        ({"mass": "12 um"}, "mass"),
        ({"clearance": "many"}, "clearance"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_a_data_sheet_that_is_wrong_is_told_of_and_leaves_the_page_as_it_is(
    changes: dict[str, str], told: str
):
    message = answer_to_sheet(SHEET | changes)
    assert message.part == "trouble"
    assert message.header["about"] == "machine"
    assert told in message.facts["message"]


def test_the_form_has_every_quantity_of_a_data_sheet_but_the_contact_law_once():
    from rotor_ida.explorer.page import _ways

    names = [name for ways in _ways() for name in ways]
    assert sorted(names) == sorted(set(KEYS) - {"contact_exponent", "contact_damping"})


def test_the_speeds_that_are_shown_reach_past_the_critical_one():
    low, high = speeds_shown(PUMP)
    rate = PUMP.reference_frequency / RPM
    assert high * rate == pytest.approx(9000.0)
    assert 0.0 < low * rate < 10.0
    assert largest_speed(PUMP) > PUMP.critical_speed


def run_up_of(
    machine: DimensionalRotor, to: float, pieces: int, seconds: float
) -> dict[str, object]:
    """Return the facts of the last piece of a run-up from standstill [1, s]."""
    rate = to / seconds * machine.time_scale
    given, start, angle = machine.given, None, 0.0
    speeds = list(speeds_shown(machine))
    for piece in range(pieces):
        speed = to * piece / pieces * machine.reference_frequency
        (answer,) = answer_to(question(
            "run_up", machine=given | {"speed": speed}, start=start, speeds=speeds,
            to=to * (piece + 1) / pieces, rate=rate, angle=angle,
        ))  # fmt: skip
        assert answer.part == "run_up", answer.facts
        start, angle = answer.facts["end"], answer.facts["angle"]
    return answer.facts


def test_a_run_up_below_the_critical_speed_is_summed_up_without_contact():
    facts = run_up_of(PUMP, 0.5 * UP_TO, 8, 2.0)
    assert facts["now"] == "clear"
    assert facts["words"].startswith("From 0 rpm to 3,000 rpm. No rub: closest to the stator at 3,")
    assert facts["words"].endswith("of the clearance of 150 µm are left.")


def test_a_run_up_under_weight_is_that_of_the_library():
    """Sag 29 µm, in a clearance of 60 µm: it first touches where the library says, and rubs on."""
    heavy = replace(PUMP, load=12.0 * GRAVITY, clearance=6e-5)
    facts = run_up_of(heavy, UP_TO, 16, 2.0)
    rotor = replace(heavy, speed=0.0).rotor()
    told = summary(run_up(rotor, start=hanging(rotor), to=UP_TO, ramp_time=2.0 / heavy.time_scale))
    assert facts["now"] == "rub"
    assert facts["words"].startswith(
        f"From 0 rpm to 6,000 rpm. Rub: it first touches the stator at "
        f"{told.first_touch_speed.item() * heavy.reference_frequency / RPM:,.0f} rpm"
    )
    assert facts["largest_force"] == pytest.approx(told.largest_force.item(), rel=1e-5)


def test_a_rotor_in_dry_whip_is_drawn_with_a_curve_of_samples_a_whirl():
    rotor = PUMP.rotor()
    radius = float(backward_whirl(rotor)["amplitude"][1])
    start = [radius, 0.0, 0.0, -rotor.disc_radius * rotor.omega]
    asked = question("motion", machine=PUMP.given, start=start, revolutions=20)
    (answer,) = answer_to(asked)
    x, y = answer.arrays["x"], answer.arrays["y"]
    turns = np.unwrap(np.angle(x + 1j * y))
    assert turns[-1] < -7.0 * 20 * math.tau  # backward, rolling: rho/radius times the spin
    assert np.abs(np.diff(turns)).max() < 1.1 * math.tau / PER_WHIRL
    (lines,) = show_lines(asked)
    assert lines.facts["orders"] > rotor.disc_radius / radius  # its line is in the spectrum
    heights = lines.arrays["line_amplitude"]
    line = lines.arrays["line_over_omega"][heights.argmax()]
    assert line == pytest.approx(-rotor.disc_radius / radius, abs=0.1)


def test_a_run_that_does_not_turn_has_no_whirls_a_revolution():
    zeros = np.zeros(2)
    run = {"t": np.arange(2.0), "mode": zeros, **dict.fromkeys(("x", "y", "vx", "vy"), zeros)}
    assert whirls_per_revolution(run, 0.0) == 0.0


SETTLED = {"contact_fraction": 0.0, "radius_max": 1.0, "largest_force": 2.0}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"response": "contact_free"}, "No contact: radius 16.71 µm, gap 133.3 µm left of the"),
        ({"response": "bouncing", "contact_fraction": 0.25}, "Rub: in contact 25 % of the time"),
        ({"response": "synchronous", "contact_fraction": 1.0}, "Rub: contact without a break, "),
        ({"response": "rolling", "contact_fraction": 1.0}, "Dry whip: the disc rolls backwards"),
        ({"response": "failed", "message": "too long"}, "Not known: too long."),
    ],
)
def test_the_verdict_says_whether_it_rubs(changes: dict[str, object], told: str):
    assert verdict_of(PUMP, SETTLED | changes).startswith(told)


def test_an_indentation_beyond_the_model_is_said_to_be():
    deep = SETTLED | {"response": "rolling", "contact_fraction": 1.0}
    for indentation, is_too_deep in ((0.9, False), (1.1, True)):
        radius = (1.0 + indentation) * PUMP.rotor().delta0
        verdict = verdict_of(PUMP, deep | {"radius_max": radius})
        assert ("more than the clearance;" in verdict) == is_too_deep


def test_a_run_up_into_whip_is_summed_up_as_such():
    told = words_of_run_up(PUMP, {
        "begin": 0.0, "end": 0.2, "first_touch_speed": 0.18, "smallest_gap": -1.0,
        "largest_force": 3.0, "largest_force_speed": 0.2, "now": "whip",
    })  # fmt: skip
    assert "Dry whip: it first touches the stator at 4,962 rpm, and presses up to " in told
