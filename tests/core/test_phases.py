"""Phases of a run: where they begin and end, and where a load leads however long they last."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from rotor_ida import Rotor, simulate, sweep
from rotor_ida.core.interface import DONE
from rotor_ida.core.runs import RunRequest, follow_run

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
HOW = {"rtol": 1e-12, "atol": 1e-14}


def linear_state(rotor, start, time):
    """Where a linear contact without clearance leads, on the rotating axes: by an exponential.

    The state is ``(z, z', g, e)`` on axes that stand still, g the load's and e the unbalance's.
    """
    stiffness = rotor.shaft_stiffness + 1.0
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiffness, -2.0 * rotor.zeta, rotor.load, rotor.omega**2],
            [0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1j * rotor.omega],
        ]
    )
    x, y, vx, vy = start
    z, v, *_ = expm(matrix * time) @ [complex(x, y), complex(vx, vy), -1j, 1.0]
    z, v = np.array([z, v]) * np.exp(-1j * rotor.omega * time)
    return np.array([z.real, z.imag, v.real, v.imag])


@pytest.mark.parametrize("rtol", [1e-8, 1e-13])
@pytest.mark.parametrize(
    "start", [(1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.7, 1e-9, -0.4, 0)]
)
def test_a_linear_contact_without_clearance_is_felt_through_the_centre(start, rtol):
    """It is linear: what is left out near the axis, where a Hertz contact is not felt, shows."""
    for omega, kappa, load in ((0.0, 0.0, 0.0), (0.0, 0.8, 0.3), (1.7, 0.0, 0.5), (0.0, 0.0, 2.0)):
        rotor = Rotor(omega=omega, zeta=0.0, delta0=0.0, contact_exponent=1.0,
                      shaft_stiffness=kappa, load=load)  # fmt: skip
        seen = follow_run(
            RunRequest(rotor=rotor, start=start, duration=20.0, rtol=rtol, atol=1e-3 * rtol)
        )
        assert seen.status == DONE
        expected = linear_state(rotor, start, 20.0)
        np.testing.assert_allclose(seen.state, expected, rtol=0, atol=40.0 * rtol + 1e-13)


@pytest.mark.parametrize("delta0", [0.0, 1.0])
def test_the_load_points_down_however_long_a_phase_lasts(delta0):
    """Damped, errors of single steps are forgotten; a direction that went astray would not be.

    With clearance the load holds the rotor in contact; then a tighter tolerance is the witness.
    """
    rotor = Rotor(omega=2.0, zeta=0.1, delta0=delta0, contact_exponent=1.0, load=20.0)
    start, time, errors = (0.0, -20.0 - delta0, 0.0, 0.0), 1000.0, []
    for rtol in (1e-7, 1e-8, 1e-9):
        states = [
            follow_run(RunRequest(rotor=rotor, start=start, duration=time, rtol=each,
                                  atol=1e-2 * each, events=True))
            for each in (rtol, 1e-14)
        ]  # fmt: skip
        assert not states[0].event_times.size
        exact = states[1].state if delta0 else linear_state(rotor, start, time)
        errors.append(np.abs(np.subtract(states[0].state, exact)).max() / rtol)
    assert max(errors) < 5.0


@pytest.mark.parametrize("method", ["adams", "bdf"])
@pytest.mark.parametrize("delta0", [0.0, 1.0])
def test_by_cvode_too_the_load_points_down_however_long_a_phase_lasts(method, delta0):
    """Its direction comes from the time: what a step leaves open does not add up to a turn."""
    rotor = Rotor(omega=2.0, zeta=0.1, delta0=delta0, contact_exponent=1.0, load=20.0)
    errors = []
    for time in (250.0, 1000.0):
        asked = RunRequest(rotor=rotor, start=(0.0, -20.0 - delta0, 0.0, 0.0), duration=time,
                      rtol=1e-9, atol=1e-11, method=method)  # fmt: skip
        exact = follow_run(replace(asked, method="taylor", rtol=1e-13)).state
        errors.append(np.abs(np.subtract(follow_run(asked).state, exact)).max())
    assert max(errors) < 2e-6  # 9e-6 and 2e-5 where its rate alone turned it


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_a_load_alone_leads_from_rest_at_the_axis(exponent):
    """It swings between there and the depth h at which load times h is the energy of the contact:
    h**(n + 1)/(n + 1) = gamma h."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.0, load=0.6, contact_exponent=exponent)
    seen = follow_run(RunRequest(rotor=rotor, start=(0.0,) * 4, duration=30.0, extrema=True, **HOW))
    assert seen.status == DONE
    depth = (0.6 * (exponent + 1.0)) ** (1.0 / exponent)
    highest = seen.extrema["radius"][seen.extrema["kind"] > 0]
    assert highest.size > 2
    np.testing.assert_allclose(highest, depth, rtol=1e-10)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_a_start_on_the_border_of_loose_is_decided_by_what_follows(method):
    """1 + c d' and its rate of change vanish there, and then it grows: not loose, without an event.

    Of z = -1 with omega = 1, h = 1 and d' = -1, radial acceleration 0 and radial jerk 3.
    """
    rotor = Rotor(omega=1.0, zeta=0.0, delta0=0.75, contact_damping=1.0)
    start = np.array((-1.0, 0.0, 1.0, -1.0))
    beside = start - (0.0, 0.0, 1e-9, 0.0)
    seen, near = (
        follow_run(
            RunRequest(rotor=rotor, start=tuple(begun), duration=6.0, events=True, method=method,
                  rtol=1e-10, atol=1e-12)
        )
        for begun in (start, beside)
    )  # fmt: skip
    assert seen.event_kinds.tolist() == near.event_kinds.tolist()
    assert seen.event_times[0] > 1e-3
    np.testing.assert_allclose(seen.event_times, near.event_times, rtol=0, atol=1e-7)
    np.testing.assert_allclose(seen.state, near.state, rtol=0, atol=1e-7)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_a_run_that_ends_at_an_event_reports_its_end(method):
    """The time of a phase, added to that at which it began, may round to the end of the run."""
    rest = (0.0, 0.0, 0.0, 0.0)
    times = simulate(BOUNCING, start=rest, duration=60.0, method=method).event_time.values
    for time in np.concatenate([np.nextafter(times, 0.0), times, np.nextafter(times, 99.0)]):
        seen = follow_run(
            RunRequest(
                rotor=BOUNCING, start=rest, duration=float(time), method=method, events=True,
                sample_times=np.array([0.0, time]), **HOW,
            )
        )  # fmt: skip
        assert seen.samples.shape == (2, 4)
        np.testing.assert_allclose(seen.samples[1], seen.state, rtol=0.0, atol=1e-12)


def test_samples_are_as_many_as_the_run_came_to():
    stop = np.ones(1, np.uint8)
    times = np.linspace(0.0, 10.0, 11)
    asked = RunRequest(rotor=BOUNCING, start=(0, 0, 0, 0), duration=10.0, sample_times=times, **HOW)
    assert len(follow_run(asked).samples) == 11
    stopped = RunRequest(
        rotor=BOUNCING, start=(0, 0, 0, 0), duration=10.0, sample_times=times, stop=stop, **HOW
    )
    assert len(follow_run(stopped).samples) == 1


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_sweep_by_ida_finds_its_turning_points_itself(rtol):
    """The reference takes tolerances that Taylor series do not."""
    given = {"omega": 2.0, "zeta": 0.6, "delta0": 1.0, "starts": [(6, 0, 0, 3)]}
    swept, exact = sweep(**given, method="ida", rtol=rtol), sweep(**given, method="taylor")
    assert swept["status"].item() == 0
    assert swept.response.item() == exact.response.item()
    assert swept.radius_max.item() == pytest.approx(exact.radius_max.item(), rel=0.1 * rtol)
