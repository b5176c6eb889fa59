"""A run-up in pieces is the run-up of the library, and the folds on its way are the exact ones."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from rotor_ida import Rotor, folds, run_up, synchronous_response
from rotor_ida.explorer.passage import RTOL
from tests.explorer.asking import CHATTER, MACHINE, Message, answer_to, question

UP = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
BOUNCING, BOUNCED = {"omega": 2.4, "zeta": 0.07, "delta0": 2.0}, (2.6, 0.75, 0.66, -1.65)
SHAKEN = (0.3, 0.1, 0.2, 0.1)


def piece(rotor: dict[str, float], start: object, to: float, rate: float) -> Message:
    (answer,) = answer_to(question("run_up", machine=rotor, start=list(start), to=to, rate=rate))
    assert answer.part == "run_up", answer.facts
    return answer


@pytest.mark.parametrize(
    ("rotor", "start", "stops", "rate"),
    [(BOUNCING, BOUNCED, (2.4, 2.48, 2.61, 3.0), 0.02),
     (BOUNCING, BOUNCED, (2.4, 2.112, 1.9), -0.02),
     (CHATTER, SHAKEN, (1.2, 1.25, 1.4), 0.01)],
    ids=["up", "down, a stop in contact", "slipping and rolling"],
)  # fmt: skip
def test_pieces_make_one_run_up(
    rotor: dict[str, float],
    start: tuple[float, ...],
    stops: tuple[float, ...],
    rate: float,
) -> None:
    """Each begins where the last one ended, turned to where the unbalance is at its beginning."""
    begun, angle = start, 0.0
    speeds, radii, angles = [], [], []
    for here, to in pairwise(stops):
        answer = piece({**rotor, "omega": here}, start, to, rate)
        assert answer.facts["speed"] == answer.arrays["speed"][-1]
        speeds.append(answer.arrays["speed"][-1])
        radii.append(answer.arrays["radius"][-1])
        angle += answer.arrays["angle"][-1]
        angles.append(angle)
        start = answer.facts["end"]
    duration = (stops[-1] - stops[0]) / rate
    times = [0.0, *((stop - stops[0]) / rate for stop in stops[1:-1]), duration]
    whole = run_up(Rotor(**rotor), start=begun, to=stops[-1], rate=rate, samples=times, rtol=1e-10)
    assert whole.sizes["event"] >= 8
    assert speeds == pytest.approx(stops[1:], abs=1e-12)
    assert angles == pytest.approx(whole.angle.values[1:], abs=1e-9)
    assert radii == pytest.approx(np.hypot(whole.x, whole.y).values[1:], abs=1e3 * RTOL)
    z = complex(whole.x[-1], whole.y[-1]) * np.exp(-1j * float(whole.angle[-1]))
    v = complex(whole.vx[-1], whole.vy[-1]) * np.exp(-1j * float(whole.angle[-1]))
    assert start == pytest.approx([z.real, z.imag, v.real, v.imag], abs=1e3 * RTOL)


def test_the_largest_force_is_that_of_the_contacts_and_of_one_that_has_not_ended() -> None:
    answer = piece(UP, SHAKEN, 1.5, 0.02)
    whole = run_up(Rotor(**UP), start=SHAKEN, to=1.5, rate=0.02, rtol=1e-9)
    assert answer.facts["largest_force"] == pytest.approx(float(whole.peak_force.max()), rel=1e-6)
    held = piece({**UP, "delta0": 0.0}, (1.0, 0.0, 0.0, 1.2), 1.201, 0.02)
    radius = held.arrays["radius"].max()
    assert held.facts["largest_force"] >= radius**1.5 * (1.0 - 1e-12)


@pytest.mark.parametrize("delta0", [0.0, 0.5, 2.0])
def test_a_whirl_ends_at_its_fold_on_the_way_on_which_there_are_fewer_behind_it(
    delta0: float,
) -> None:
    """Speed and radius of each fold are exact; so is, near it, the whirl that is left."""
    found = piece({**UP, "delta0": delta0}, (0, 0, 0, 0), 1.201, 0.02).facts["folds"]
    exact = folds(zeta=0.07, delta0=delta0)
    pairs = {
        (float(omega), float(radius))
        for omega, radius in zip(
            exact.fold_omega.values.ravel(), exact.fold_amplitude.values.ravel(), strict=True
        )
    }
    assert [fold["way"] for fold in found] == [-1.0, 1.0]
    for fold in found:
        assert (fold["omega"], fold["radius"]) in pairs
        behind = fold["omega"] * (1.0 + 1e-6 * fold["way"])
        left = synchronous_response(omega=behind, zeta=0.07, delta0=delta0).amplitude.values
        left = left[np.isfinite(left)]
        assert left.size == 1
        assert left[0] == pytest.approx(fold["other"], rel=2e-3)


def test_without_an_exact_curve_there_are_no_folds() -> None:
    loaded = {**UP, "load": 0.3, "shaft_stiffness": 0.25}
    assert piece(loaded, (0, 0, 0, 0), 1.201, 0.02).facts["folds"] == []


def test_a_machine_in_si_units_runs_up_as_its_rotor_does() -> None:
    """The speed of the machine is in rad/s, the end and the rate have no dimension, as starts."""
    rotor = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
    ours = piece(MACHINE, SHAKEN, 2.05, 0.01)
    other = piece(rotor, SHAKEN, 2.05, 0.01)
    assert ours.arrays["radius"] == pytest.approx(other.arrays["radius"], abs=1e-6)
    assert ours.facts["scales"]["rate"] == pytest.approx(500.0)


def test_a_piece_is_sampled_often_enough_at_every_speed() -> None:
    for omega in (0.05, 1.0, 3.0):
        answer = piece({**UP, "omega": omega}, (0, 0, 0, 0), omega + 0.1, 0.01)
        turns = max(answer.arrays["angle"][-1], 10.0) / (2.0 * math.pi)
        assert answer.arrays["speed"].size >= 48 * turns
