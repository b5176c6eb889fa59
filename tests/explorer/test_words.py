"""The sentences say what the numbers say."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from rotor_ida.explorer.words import (
    words_of_response,
    words_of_run,
    words_of_transient,
    words_of_whip,
)
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from tests.explorer.asking import MACHINE, ROTOR

PLAIN, IN_SI = Rotor(**ROTOR), DimensionalRotor(**MACHINE)
RUN = {
    "contacts_in_all": 12.0, "contact_fraction": 0.25, "contacts_per_revolution": 0.4,
    "largest_force": 0.5,
}  # fmt: skip


DAMPED = {"loss_per_contact": 0.25, "releases": 0.0}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"contacts_per_revolution": 1.0}, "half: 1 contact a revolution, in contact 25 %"),
        ({}, "0.4 contacts a revolution, in contact 25 % of the time, peak force 0.5."),
        ({"contacts_in_all": 0.0}, "It never touches the stator."),
        ({"contact_fraction": 0.0}, "It has touched the stator, but no longer does."),
        ({"contact_fraction": 1.0}, "always in contact, with a force of up to 0.5."),
        ({"contacts_per_revolution": float("nan")}, "half: in contact 25 % of the time"),
    ],
)
def test_words_of_a_run(changes: dict[str, float], told: str):
    (sentence,) = words_of_run(PLAIN, RUN | changes)
    assert told in sentence


def test_a_machine_is_told_of_in_si_units():
    (sentence,) = words_of_run(IN_SI, RUN)
    assert sentence.endswith("peak force 500 mN.")


CYCLE = RUN | {
    "response": "bouncing", "lies_on": "cycle", "digits": 11.98, "radius_min": 1.5,
    "radius_max": 2.5, "period": 4.5, "message": "", "rotor": ROTOR,
}  # fmt: skip


def test_words_of_a_limit_cycle_hold_its_numbers():
    text = " ".join(words_of_response(PLAIN, CYCLE))
    for each in ("bouncing", "1.5", "2.5", "4.5", "11 digits", "0.4 times", "25 %", "force of 0.5"):
        assert each in text
    in_si = " ".join(words_of_response(IN_SI, CYCLE))
    for each in ("1.5 µm", "2.5 µm", "9 ms", "500 mN"):
        assert each in in_si


FREE = {
    "response": "contact_free", "lies_on": "whirl", "digits": 12.0, "exact_amplitude": 1.0,
    "radius_min": 0.227, "radius_max": 1.773, "contact_fraction": 0.0, "rotor": ROTOR,
}  # fmt: skip


def test_a_whirl_off_the_axis_has_its_radii_and_the_gap_that_is_left():
    text = " ".join(words_of_response(PLAIN, FREE))
    assert "Its radius goes from 0.227 to 1.773, and leaves a gap of 0.227 to the stator." in text
    text = " ".join(words_of_response(IN_SI, FREE))
    assert "Its radius goes from 227 nm to 1.773 µm, and leaves a gap of 227 nm" in text


def test_a_whirl_on_the_axis_has_one_radius():
    told = FREE | {"radius_min": 1.0 - 1e-13, "radius_max": 1.0 + 1e-13}
    text = " ".join(words_of_response(PLAIN, told))
    assert "Its radius is 1, and leaves a gap of 1 to the stator." in text


def test_a_rotor_without_spin_comes_to_rest():
    told = FREE | {"rotor": ROTOR | {"omega": 0.0}, "radius_min": 1.5, "radius_max": 1.5}
    assert words_of_response(PLAIN, told) == [
        "It comes to rest inside the clearance.",
        "Its radius is 1.5, and leaves a gap of 0.5 to the stator.",
    ]
    (sentence,) = words_of_response(PLAIN, told | {"radius_max": 1e-9})
    assert sentence == "It comes to rest at the centre of the stator."


def test_words_of_a_run_that_ends_too_early_are_in_the_units_of_the_machine():
    assert "ends at t = 188.5 (60 revolutions)" in words_of_transient(PLAIN, 2.0, 188.5, 17_000.0)
    assert "settled at t = 34 s (5,411" in words_of_transient(IN_SI, 2.0, 188.5, 17_000.0)
    assert "revolutions" not in words_of_transient(PLAIN, 0.0, 377.0, 17_000.0)


def test_what_contact_damping_takes_is_told_in_units_of_energy():
    machine = replace(IN_SI, contact_damping=3.0)
    _, loss = words_of_run(PLAIN, RUN | DAMPED)
    assert loss == "A contact loses 0.25 in the mean."
    _, loss = words_of_run(machine, RUN | DAMPED | {"releases": 3.0})
    assert loss == (
        "A contact loses 250 nJ in the mean, and releases the rotor before it has left the stator."
    )
    touched = words_of_response(PLAIN, CYCLE | {"contacts_per_revolution": 1.0})[-1]
    assert touched.startswith("It touches the stator once a revolution")
    assert words_of_response(PLAIN, CYCLE | DAMPED)[-1] == "A contact loses 0.25 in the mean."
    (sentence,) = words_of_run(PLAIN, RUN | DAMPED | {"loss_per_contact": float("nan")})
    assert "half" in sentence  # no contact has ended


def test_what_a_contact_that_never_ends_takes_is_told_by_the_revolution():
    told = {"contact_fraction": 1.0, "loss_per_contact": math.nan, "loss_per_revolution": 0.25}
    cycle = RUN | told | {"radius_min": 2.25, "radius_max": 2.5}
    assert words_of_run(PLAIN, cycle)[-1] == "The contact loses 0.25 a revolution."
    assert words_of_run(IN_SI, cycle)[-1] == "The contact loses 250 nJ a revolution."
    (sentence,) = words_of_run(PLAIN, cycle | {"radius_min": 2.5})
    assert "always in contact" in sentence  # a whirl loses nothing there


def test_with_a_shaft_there_is_one_contact_free_whirl():
    told = words_of_response(replace(PLAIN, shaft_stiffness=0.25), FREE)
    assert told[0].startswith("It settles on the contact-free whirl, which is the only one")
    assert words_of_response(PLAIN, FREE)[0].startswith("It settles on a contact-free whirl")


def test_under_a_load_a_cycle_repeats_itself_after_revolutions():
    loaded = replace(PLAIN, load=0.5)
    revolution = 2.0 * math.pi / PLAIN.omega
    for count, said in ((1, "every revolution."), (3, "every 3 revolutions.")):
        told = words_of_response(loaded, CYCLE | {"period": count * revolution})
        assert told[1].endswith(said)


def test_under_a_load_a_rotor_comes_to_rest_on_the_ring_or_hangs_in_the_clearance():
    still = {"omega": 0.0, "zeta": 0.07, "delta0": 2.0, "load": 0.125}
    lying = {
        "response": "synchronous", "lies_on": "whirl", "digits": 12.0, "exact_amplitude": 2.25,
        "radius_min": 2.25, "radius_max": 2.25, "contact_fraction": 1.0, "largest_force": 0.125,
        "rotor": still,
    }  # fmt: skip
    assert words_of_response(Rotor(**still), lying) == [
        "It comes to rest on the stator.",
        "Its radius is 2.25.",
        "It presses on the stator with 0.125.",
    ]
    held = still | {"omega": 2.0, "shaft_stiffness": 0.25}
    told = words_of_response(Rotor(**held), FREE | {"rotor": held})
    assert told[0].startswith("It settles on a contact-free whirl")
    assert "Its centre hangs 0.5 below the axis of the bearing." in told


def test_words_of_chaos_tell_how_fast_neighbours_part():
    told = CYCLE | {
        "response": "chaotic", "lies_on": "nothing", "lyapunov_exponent": 0.05,
        "period": float("nan"),
    }  # fmt: skip
    assert any("e-fold every 20" in each for each in words_of_response(PLAIN, told))
    assert any("e-fold every 40 ms" in each for each in words_of_response(IN_SI, told))


def test_words_of_a_failure_are_its_reason():
    told = {"response": "failed", "message": "too much work"}
    (sentence,) = words_of_response(PLAIN, told)
    assert "too much work" in sentence


RUBBED = {
    "rolling_fraction": 0.6, "slipping_forward_fraction": 0.4, "slipping_backward_fraction": 0.0,
    "heat_per_revolution": 0.25,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({}, "Of the time in contact it rolls 60 % and slips forwards 40 %, with a heat of 0.25 "),
        (
            {"rolling_fraction": 0.5, "slipping_backward_fraction": 0.1},
            "rolls 50 %, slips forwards 40 % and slips backwards 10 %, with",
        ),
        (
            {"rolling_fraction": 0.0, "slipping_forward_fraction": 1.0},
            "In contact it slips forwards all the time, with a heat of 0.25 a revolution.",
        ),
        (
            {"rolling_fraction": 1.0, "slipping_forward_fraction": 0.0},
            "In contact it rolls all the time.",
        ),
        ({"heat_per_revolution": math.nan}, "rolls 60 % and slips forwards 40 %."),
    ],
)
def test_how_the_disc_slips_and_rolls_is_told(changes: dict[str, float], told: str):
    _, sentence = words_of_run(PLAIN, RUN | RUBBED | changes)
    assert told in sentence
    assert words_of_response(PLAIN, CYCLE | RUBBED | changes)[-1] == sentence


def test_heat_is_told_in_units_of_energy_and_a_disc_that_does_not_turn_does_not_roll():
    _, sentence = words_of_run(IN_SI, RUN | RUBBED)
    assert sentence.endswith("with a heat of 250 nJ a revolution.")
    still = RUBBED | {"rolling_fraction": 1.0, "slipping_forward_fraction": 0.0}
    _, sentence = words_of_run(replace(PLAIN, omega=0.0), RUN | still)
    assert sentence == "In contact it does not slide."


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
