"""What a page draws of a run is the run that the library simulates."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida.explorer.cases import Node
from rotor_ida.explorer.messages import Question
from rotor_ida.schema import DAMPED_EVENT_KIND, EVENT_KIND
from tests.explorer.asking import (
    BEYOND,
    BEYOND_IN_SI,
    CHATTER,
    MACHINE,
    ROTOR,
    RUB,
    RUB_IN_SI,
    WHIP,
    WHIPPED,
    Message,
    answer_to,
    question,
)

QUESTIONS = {
    "bouncing": question(start=[2.6, 0.75, 0.66, -1.65]),
    "full contact": question(machine={"omega": 1.7, "zeta": 0.07, "delta0": 0.5}),
    "no clearance": question(
        machine={"omega": 1.2, "zeta": 0.07, "delta0": 0.0}, start=[1, 2, 3, 4]
    ),
    "contact-free": question(machine={"omega": 0.3, "zeta": 0.07, "delta0": 3.0}),
    "free vibration": question(machine={"omega": 0, "zeta": 0.01, "delta0": 1}, start=[3, 0, 0, 1]),
    "no damping": question(machine={"omega": 1.3, "zeta": 0, "delta0": 1}, revolutions=20),
    "long": question(revolutions=2000, machine={"omega": 1.38, "zeta": 0.07, "delta0": 1.0}),
    "a machine": question(machine=ROTOR | BEYOND),
    "in SI units": question(machine=MACHINE | BEYOND_IN_SI | RUB_IN_SI),
    "dry whip": question(machine=WHIP, start=WHIPPED),
    "slip in both senses": question(machine=CHATTER, start=[0.3, 0.1, 0.2, 0.1]),
    "a machine that rubs": question(machine=ROTOR | BEYOND | RUB, start=[2.6, 0.75, 0.66, -1.65]),
}  # fmt: skip


def simulated(asking: Question) -> xr.Dataset:
    omega = asking.rotor.omega or 1.0
    return rotor_ida.simulate(
        asking.rotor,
        start=asking.start,
        duration=asking.revolutions * 2.0 * math.pi / omega,
        samples=Node(asking).run().sizes["t"],
        method="taylor",
    )


def motion(asking: Question) -> Message:
    (message,) = answer_to(asking)
    assert message.part == "motion"
    return message


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_motion_is_that_of_the_library_bit_for_bit(name: str):
    """The run with its events, rotating axes, forces, slip, and a section once a revolution."""
    message, run = motion(QUESTIONS[name]), simulated(QUESTIONS[name])
    of_run = ("t", "x", "y", "event_time", "event_x", "event_y", "event_time_error", "event_kind",
              "entry_time", "exit_time", "peak_time", "peak_force")  # fmt: skip
    of_slip = ("mode", "slip_speed") if QUESTIONS[name].rotor.friction else ()
    turning, forces = rotor_ida.rotating(run), rotor_ida.contact_forces(run)
    of_turning = ("rotating_x", "rotating_y", "event_rotating_x", "event_rotating_y")
    for each in (*of_run, *of_slip, *of_turning):
        values = (turning if each in of_turning else run)[each].values
        np.testing.assert_array_equal(message.arrays[each], values, err_msg=each)
    normal = "normal_force" if "normal_force" in forces else "force"
    np.testing.assert_array_equal(message.arrays["force"], forces[normal].values)
    np.testing.assert_array_equal(message.arrays["radius"], np.hypot(run["x"], run["y"]).values)
    assert message.facts["horizon"] == float(run["horizon"])
    step = message.facts["samples_per_revolution"]
    for axis in ("x", "y"):
        section = message.arrays[f"section_{axis}"]
        assert section.size == QUESTIONS[name].revolutions + 1
        np.testing.assert_array_equal(section, message.arrays[f"rotating_{axis}"][::step])


def test_the_run_goes_on_from_the_end_as_if_it_had_not_stopped():
    first = motion(question(revolutions=20))
    second = motion(question(revolutions=20, start=first.facts["end"]))
    whole = rotor_ida.rotating(simulated(question(revolutions=60)))["rotating_x"].values
    each = first.facts["samples_per_revolution"]
    # the phase of the end is that of a whole revolution up to the rounding of its time
    np.testing.assert_allclose(
        second.arrays["rotating_x"], whole[20 * each : 40 * each + 1], atol=1e-8
    )


def test_what_is_told_of_the_end_is_counted_again():
    asking = QUESTIONS["bouncing"]
    message, run = motion(asking), simulated(asking)
    told, half = message.facts["ending"], float(run.attrs["duration"]) / 2.0
    entries = run["event_time"].values[run["event_kind"].values == EVENT_KIND["entry"]]
    late = run["t"].values >= half
    assert told["contacts_per_revolution"] == pytest.approx((entries >= half).sum() / 30.0)
    assert told["contacts_in_all"] == rotor_ida.contact_summary(run)["contact_count"]
    peaks = run["peak_force"].values[run["peak_time"].values >= half]
    assert told["largest_force"] == max(peaks.max(), message.arrays["force"][late].max())
    assert told["radius_max"] == message.arrays["radius"][late].max()
    inside = np.minimum(run["exit_time"].fillna(2 * half), 2 * half) - np.maximum(
        run["entry_time"].fillna(0.0), half
    )
    assert told["contact_fraction"] == pytest.approx(float(inside.clip(min=0.0).sum()) / half)


def test_the_loss_per_contact_is_the_mean_of_those_that_end_in_the_last_half():
    message, run = motion(QUESTIONS["a machine"]), simulated(QUESTIONS["a machine"])
    told, half = message.facts["ending"], float(run.attrs["duration"]) / 2.0
    ended = run["exit_time"].values >= half
    assert told["loss_per_contact"] == run["contact_loss"].values[ended].mean() > 0.0
    releases = run["event_time"].values[run["event_kind"].values == DAMPED_EVENT_KIND["release"]]
    assert told["releases"] == (releases >= half).sum() > 0
    kinds = run["event_kind"].values.tolist()
    _, events = message.facts["sheets"]
    found = {name: int(value) for name, value, unit in events["rows"][1:] if value.isdigit()}
    for name, kind in DAMPED_EVENT_KIND.items():
        assert found.get(name, 0) == kinds.count(kind)


@pytest.mark.parametrize("name", ["dry whip", "slip in both senses"])
def test_heat_and_shares_are_those_between_the_events(name: str):
    """The heat from the contacts of a run as long as the last half, the shares from its events."""
    message, rotor = motion(QUESTIONS[name]), QUESTIONS[name].rotor
    told, run = message.facts["ending"], simulated(QUESTIONS[name])
    half = run.sizes["t"] // 2
    x, y, vx, vy = (run[each].values[half] for each in ("x", "y", "vx", "vy"))
    late = rotor_ida.simulate(
        rotor, start=(x, y, vx, vy), duration=30.0 * 2.0 * math.pi / rotor.omega, method="taylor"
    )
    summary = rotor_ida.contact_summary(late)
    # by samples and by trapezia against integrals between events
    assert told["heat_per_revolution"] == pytest.approx(
        float(summary.heat_per_revolution), rel=0.02
    )
    assert told["rolling_fraction"] == pytest.approx(float(summary.rolling_fraction), abs=0.02)
    ways = ("slipping_forward_fraction", "slipping_backward_fraction", "rolling_fraction")
    assert sum(told[each] for each in ways) == pytest.approx(1.0)
    assert (told["slipping_backward_fraction"] > 0.1) == (name == "slip in both senses")


def test_a_machine_has_the_answer_of_its_rotor_and_its_scales():
    in_si, plain = motion(question(machine=MACHINE)), motion(question())
    machine = rotor_ida.DimensionalRotor(**MACHINE)
    assert in_si.facts["rotor"] == plain.facts["rotor"] == ROTOR
    for name, values in plain.arrays.items():
        np.testing.assert_array_equal(in_si.arrays[name], values, err_msg=name)
    assert plain.facts["scales"] == {}
    for kind in ("length", "time", "velocity", "force"):
        assert in_si.facts["scales"][kind] == getattr(machine, f"{kind}_scale")
    assert in_si.facts["scales"]["rate"] == machine.reference_frequency
    run = rotor_ida.dimensional(simulated(question()), machine)
    scales = in_si.facts["scales"]
    np.testing.assert_array_equal(in_si.arrays["x"] * scales["length"], run["x"].values)
    np.testing.assert_array_equal(in_si.arrays["t"] * scales["time"], run["t"].values)
    units = {unit for sheet in in_si.facts["sheets"] for _, _, unit in sheet["rows"][1:]}
    assert {"µm", "N"} <= units


EDGES = [
    *({name: 0.0} for name in ROTOR),
    {"omega": 1e-6},
    dict.fromkeys(ROTOR, 0.0),
    dict.fromkeys(ROTOR, 1e6),
    {"omega": 0.0, **RUB},
    {"load": 1.0, **RUB},
    {**RUB, "disc_radius": 1e6},
]


@pytest.mark.parametrize("changes", EDGES, ids=str)
def test_every_edge_gets_an_answer_or_one_reason(changes: dict[str, float]):
    (message,) = answer_to(question(machine=ROTOR | changes, revolutions=1))
    if message.part == "trouble":
        (line,) = message.facts["message"].splitlines()
        assert line
    else:
        assert message.part == "motion"
        assert [name for name, *_ in message.facts["sheets"][0]["rows"][1:3]] == [
            "smallest radius",
            "largest radius",
        ]
