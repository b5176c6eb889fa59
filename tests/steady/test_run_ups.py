"""Many run-ups: each is that of `run_up`, and ends on what its last speed has."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, SimulationError, run_up, run_ups, summary, sweep
from rotor_ida.closed_forms import peaks
from rotor_ida.paper.whip import is_whip
from rotor_ida.schema import ENDING, RESPONSE, flags_of, words_of
from rotor_ida.steady import run_up_outcome

REST = (0.0, 0.0, 0.0, 0.0)
START = (0.3, -0.1, 0.2, 0.1)
SHAFT = {"zeta": 0.1, "delta0": 2.0, "shaft_stiffness": 1.0}
ALL = {
    "zeta": 0.07, "delta0": 1.0, "shaft_stiffness": 0.3, "contact_exponent": 1.0,
    "contact_damping": 0.5, "load": 0.2, "friction": 0.3, "disc_radius": 0.6,
}  # fmt: skip
WHIP = {"zeta": 0.1, "delta0": 1.0, "friction": 0.2, "disc_radius": 10.0}
WHIPS = (5.0, 0.0, 0.0, -6.3)
ENDS = ("end_x", "end_y", "end_vx", "end_vy")


def ends_of(found):
    return np.array([found[name].values for name in ENDS])


@pytest.mark.parametrize(
    ("rotor", "omega", "to", "rate", "start"),
    [(SHAFT, 0.3, 1.6, 0.05, REST), (ALL, 2.0, 0.5, -0.1, START), (WHIP, 0.63, 1.0, 0.05, WHIPS)],
    ids=["up", "down, all of it", "whip"],
)
def test_each_is_the_run_of_run_up(rotor, omega, to, rate, start):
    found = run_ups(omega=omega, to=to, rate=rate, starts=[start], rtol=1e-9, **rotor).squeeze()
    alone = run_up(
        Rotor(omega=omega, **rotor), start=start, to=to, rate=rate, samples=4001, rtol=1e-9,
        method="taylor",
    )  # fmt: skip
    close = {"rel": 1e-9, "abs": 1e-11}
    entries = alone.event_speed.values[alone.event_kind.values == 1]
    exits = alone.event_speed.values[alone.event_kind.values == -1]
    first = omega if alone.starts_in_contact else entries[0]
    assert found.first_touch_speed.item() == pytest.approx(first, **close)
    last = exits[-1] if exits.size else math.nan
    assert found.last_exit_speed.item() == pytest.approx(last, nan_ok=True, **close)
    assert found.contact_count.item() == alone.sizes["contact"]
    assert found.largest_force.item() == pytest.approx(alone.peak_force.values.max(), **close)
    hardest = alone.isel(contact=int(alone.peak_force.values.argmax()))
    speed = omega + rate * hardest.peak_time.item()
    assert found.largest_force_speed.item() == pytest.approx(speed, abs=1e-6)
    inside = alone.exit_time.fillna(alone.attrs["duration"]) - alone.entry_time.fillna(0.0)
    assert found.contact_time.item() == pytest.approx(inside.sum().item(), **close)
    radius = np.hypot(alone.x, alone.y).max().item()
    assert radius <= found.largest_radius.item() * (1.0 + 1e-12)
    assert found.largest_radius.item() == pytest.approx(radius, rel=1e-4)
    if "heat" in alone:
        assert found.total_heat.item() == pytest.approx(alone.heat.sum().item(), **close)
        rolls = alone.event_speed.values[alone.event_kind.values == 2]
        assert found.first_roll_speed.item() == pytest.approx(
            rolls[0] if rolls.size else math.nan, nan_ok=True, **close
        )
    if "contact_loss" in alone:
        lost = alone.contact_loss.sum().item()
        assert found.total_contact_loss.item() == pytest.approx(lost, **close)
    assert found.end_angle.item() == pytest.approx(alone.angle.values[-1], **close)
    ends = [alone[name].values[-1] for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(ends_of(found), ends, rtol=1e-8, atol=1e-9)


def test_without_a_load_a_phase_is_the_start_turned_back():
    angle = 0.7
    turned = complex(*START[:2]) * np.exp(-1j * angle), complex(*START[2:]) * np.exp(-1j * angle)
    start = (turned[0].real, turned[0].imag, turned[1].real, turned[1].imag)
    given = {"omega": 0.3, "to": 1.6, "rate": 0.1, **SHAFT}
    found = run_ups(**given, phase=[0.0, angle], starts=[START, start]).squeeze()
    one, other = found.isel(phase=1, start=0), found.isel(phase=0, start=1)
    assert one.largest_force.item() == pytest.approx(other.largest_force.item(), rel=1e-8)
    place, turned_back = (each.end_x.item() + 1j * each.end_y.item() for each in (one, other))
    assert place == pytest.approx(turned_back * np.exp(1j * angle), abs=1e-7)
    assert abs(found.largest_force.isel(start=0).diff("phase").item()) > 1e-3


def test_under_a_load_a_phase_is_the_angle_that_the_unbalance_has_come_to():
    """The same as to hold the first speed until the unbalance points there."""
    omega, to, rate, angle = 2.0, 0.5, -0.1, 2.5
    held = angle / omega
    rotor = Rotor(omega=omega, **ALL)
    before = run_up(rotor, start=START, speeds=[(0.0, omega), (held, omega)], samples=2)
    start = tuple(before[name].values[-1] for name in ("x", "y", "vx", "vy"))
    found = run_ups(omega=omega, to=to, rate=rate, phase=angle, starts=[start], **ALL).squeeze()
    speeds = [(0.0, omega), (held, omega), (held + (to - omega) / rate, to)]
    whole = run_up(rotor, start=START, speeds=speeds, samples=2)
    ends = [whole[name].values[-1] for name in ("x", "y", "vx", "vy")]
    np.testing.assert_allclose(ends_of(found), ends, rtol=0, atol=1e-7)
    assert found.end_angle.item() == pytest.approx(whole.angle.values[-1], rel=1e-12)


@pytest.mark.parametrize("load", [0.0, 0.3])
def test_it_settles_on_the_whirl_that_the_last_speed_has(load):
    """Round the place where the shaft holds the load, which stands still while the axes turn."""
    to, zeta, kappa = 0.3, 0.1, 1.0
    found = run_ups(
        omega=1.7, to=to, rate=-0.3, zeta=zeta, delta0=2.0, shaft_stiffness=kappa, load=load,
        phase=[0.4, 5.0],
    )  # fmt: skip
    whirl = to**2 / complex(kappa - to**2, 2.0 * zeta * to)
    assert (found.ending == ENDING["contact_free"]).all()
    np.testing.assert_allclose(found.amplitude.values, abs(whirl), rtol=1e-7)
    np.testing.assert_allclose(found.phase_lag.values, -np.angle(whirl), rtol=1e-7)
    np.testing.assert_allclose(found.radius_max.values, abs(whirl) + load / kappa, rtol=1e-3)


def test_a_slow_one_meets_the_force_of_the_exact_response():
    """What is left falls in proportion to the rate, where the response has no fold."""
    machine = {"zeta": 0.3, "delta0": 0.5, "shaft_stiffness": 1.0}
    found = run_ups(omega=0.3, to=3.0, rate=[0.005, 0.00125], rtol=1e-8, **machine).squeeze()
    exact = peaks(**machine)
    force = exact.peak_contact_force.item()
    more = found.largest_force.values - force
    assert 3.0 < more[0] / more[1] < 4.2
    assert found.largest_force.values[1] - more[0] / 4.0 == pytest.approx(force, rel=2e-3)
    later = found.largest_force_speed.values - exact.peak_omega.item()
    assert (later > 0.0).all()
    assert later[1] < 0.5 * later[0]


def test_slow_and_fast_ones_end_where_the_motion_after_the_ramp_leads():
    """As a sweep settles from the same state."""
    found = run_ups(omega=0.3, to=1.6, rate=[0.005, 0.05], **SHAFT).squeeze()
    assert found.ending.values.tolist() == [ENDING["rub"], ENDING["contact_free"]]
    for number in range(2):
        one = found.isel(rate=number)
        turn = np.exp(-1j * one.end_angle.item())
        place, velocity = (
            complex(one[f"end_{first}"], one[f"end_{second}"]) * turn
            for first, second in (("x", "y"), ("vx", "vy"))
        )
        start = (place.real, place.imag, velocity.real, velocity.imag)
        settled = sweep(omega=1.6, **SHAFT, starts=[start]).squeeze()
        assert one.response.item() == settled.response.item()
        assert one.radius_min.item() == pytest.approx(settled.radius_min.item(), rel=1e-6)


def test_whip_is_told_as_a_run_that_goes_on_tells_it():
    given = {"to": 1.0, "rate": 0.05}
    starts = [WHIPS, (1.5, 0.0, 0.0, 0.0)]
    found = run_ups(omega=0.63, **given, starts=starts, rtol=1e-8, **WHIP).squeeze()
    assert found.ending.values[0] == ENDING["whip"]
    assert found.ending.values[1] != ENDING["whip"]
    for start, ending in zip(starts, found.ending.values, strict=True):
        rotor = Rotor(omega=0.63, **WHIP)
        on = run_up(rotor, start=start, **given, duration=150.0, samples=401, rtol=1e-8)
        assert is_whip(on) == (ending == ENDING["whip"])
    assert found.whip_fraction.item() == 0.5
    assert found.whip_fraction_error.item() == pytest.approx(math.sqrt(0.125))


def test_a_disc_that_slides_both_ways_by_turns_whips_too():
    """The unbalance is too strong for it to roll: a full contact backwards, and its own end."""
    rotor = {"zeta": 0.05, "delta0": 1.0, "friction": 0.1, "disc_radius": 10.0}
    start = (8.9, 0.0, 0.0, -15.0)
    given = {"to": 1.5, "rate": 0.1}
    found = run_ups(omega=1.45, **given, starts=[start], rtol=1e-8, **rotor).squeeze()
    assert found.response.item() == RESPONSE["full_contact"]
    assert found.ending.item() == ENDING["whip"]
    on = run_up(
        Rotor(omega=1.45, **rotor), start=start, **given, duration=90.0, samples=901, rtol=1e-8
    )
    late = on.isel(t=on.t.values > 60.0)
    kinds = set(late.event_kind.values[late.event_time.values > 60.0].tolist())
    assert kinds == {3}
    assert float((late.x * late.vy - late.y * late.vx).max()) < 0.0


def test_dimensions():
    found = run_ups(
        omega=0.3, to=1.6, rate=[0.1, 0.2], zeta=[0.1, 0.2], delta0=2.0, shaft_stiffness=1.0,
        phase=[0.0, 1.0, 2.0], starts=[REST, START], rtol=1e-8,
    )  # fmt: skip
    assert found.ending.dims == ("omega", "zeta", "delta0", "rate", "phase", "start")
    assert found.ending.shape == (1, 2, 1, 2, 3, 2)
    assert found.rub_fraction.dims == ("omega", "zeta", "delta0", "rate")
    assert (found.to.item(), found.shaft_stiffness.item()) == (1.6, 1.0)
    assert set(flags_of(found.ending)) == set(ENDING)
    assert "total_heat" not in found
    whole = sum(found[f"{word}_fraction"] for word in ("contact_free", "rub", "whip", "unresolved"))
    assert (whole == 1.0).all()
    one = run_ups(
        omega=0.3, to=1.6, rate=0.2, zeta=0.2, delta0=2.0, shaft_stiffness=1.0, phase=2.0,
        starts=[START], rtol=1e-8,
    )  # fmt: skip
    there = found.sel(rate=[0.2], zeta=[0.2], phase=[2.0]).isel(start=[1])
    np.testing.assert_array_equal(ends_of(one), ends_of(there))


def test_one_that_fails_is_labelled_and_stops_nothing(monkeypatch):
    """On its ramp, or once it is held; what it met on the ramp is kept."""
    true_run, true_follow = run_up_outcome.run, run_up_outcome.settle_disc

    def fails(rotor, *rest, **options):
        if rotor.zeta == 0.2:
            raise SimulationError("corrector failed", time=1.0, state=REST)
        return true_run(rotor, *rest, **options)

    def overflows(rotor, *rest, **options):
        if rotor.zeta == 0.3:
            raise OverflowError("too large")
        return true_follow(rotor, *rest, **options)

    monkeypatch.setattr(run_up_outcome, "run", fails)
    monkeypatch.setattr(run_up_outcome, "settle_disc", overflows)
    given = SHAFT | {"zeta": [0.1, 0.2, 0.3]}
    found = run_ups(omega=0.3, to=1.6, rate=0.3, **given, executor="serial").squeeze()
    assert found.status.values.tolist() == [0, 1, 1]
    assert found.ending.values.tolist() == [ENDING["contact_free"], -1, -1]
    assert found.response.values.tolist()[1:] == [RESPONSE["failed"]] * 2
    assert "corrector failed (at t = 1" in found.message.values[1]
    assert found.message.values[2] == "OverflowError: too large"
    assert np.isfinite(found.largest_radius.values).tolist() == [True, False, True]
    assert found.failed_count.values.tolist() == [0, 1, 1]
    assert np.isnan(found.contact_free_fraction.values).tolist() == [False, True, True]


def test_an_unresolved_ending_tells_what_was_tried():
    rotor = Rotor(omega=0.3, zeta=0.0, delta0=0.2, shaft_stiffness=1.0)
    told = "revolutions: without damping nothing settles"
    found = run_ups(**rotor.given, to=1.6, rate=0.3).squeeze()
    assert words_of(found.ending) == ["unresolved"]
    assert found.message.item().endswith(told)
    assert int(found.status) == 0
    sentence = summary(run_up(rotor, to=1.6, rate=0.3)).attrs["sentence"]
    assert f"it still rubs, and had not settled: {found.message.item()}." in sentence
