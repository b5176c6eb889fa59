"""The limit cycle that a start leads to, of rotors of each kind: against other integrators."""

import math

import numpy as np
import pytest

import rotor_ida
from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    SimulationError,
    backward_whirl,
    decode_flags,
    limit_cycle,
    poincare_section,
    simulate,
)
from rotor_ida.cycles import limit_cycle as search_module
from rotor_ida.schema import LINE_KIND, RESPONSE, STABILITY
from tests.cycles.known import (
    BOUNCING,
    CYCLES,
    FULL,
    HIGHEST,
    LOADED,
    LYING,
    PAIRS,
    PARTNERS,
    REST,
    SLIVER,
    SPECIAL_POINTS,
    multipliers,
    once_round,
    revolutions,
    signature,
    state_of,
)

# A third of the spin speed, without clearance and with little damping.
WITHOUT_CLEARANCE = Rotor(omega=3.473446685718647, zeta=0.04, delta0=0.0)
SOFT_RING = Rotor(
    omega=1.1, zeta=0.1, delta0=4.0, contact_exponent=1.0, contact_damping=0.1, load=0.04
)
TO_IT = (1.680227894690578, 1.7216694496323166, -1.3086145322038387, -1.7211419526289315)
ROTOR = BOUNCING.rotor
SYSTEM = ROTOR.system()
OMEGA = [1.9, 2.0, 2.5]
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=1000.0
)
FRICTIONAL = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
TO_WHIP = (6.928, 0.0, 0.0, -10.0)


def kind_of(cycle):
    return {flag: word for word, flag in RESPONSE.items()}[int(cycle["response"])]


def shifted(cycle, place):
    """A state on a cycle, as a start."""
    return tuple(float(cycle[name][place]) for name in ("x", "y", "vx", "vy"))


@pytest.mark.parametrize(("known", "kind", "contacts"), [(BOUNCING, "bouncing", 1),
                                                         (FULL, "full_contact", 0)])  # fmt: skip
def test_known_cycles_from_rest(known, kind, contacts):
    """DESIGN 9: periods to 1e-11, multipliers to 1e-8."""
    cycle = limit_cycle(known.rotor, start=REST if known is BOUNCING else (3.0, 1.0, 0.0, 0.0))
    assert cycle["period"].item() == pytest.approx(known.period, abs=1e-11)
    assert cycle["radius_max"].item() == pytest.approx(HIGHEST[known], abs=1e-9)
    pair = complex(cycle["multiplier_real"][1], abs(cycle["multiplier_imag"][1]))
    assert pair == pytest.approx(PAIRS[known], abs=1e-8)
    assert np.abs(multipliers(cycle) - PARTNERS[known]).min() < 1e-8
    assert (kind_of(cycle), cycle["contact_count"].item()) == (kind, contacts)
    assert cycle["stability"].item() == STABILITY["stable"]
    assert 0.0 < cycle["period_error"].item() < 1e-12
    assert (cycle["multiplier_error"] < 1e-11).all()


@pytest.mark.parametrize("name", CYCLES)
def test_another_integrator_comes_back_with_the_same_multipliers(name):
    """DOP853 on fixed axes, with events and the variational equation."""
    rotor, start = CYCLES[name]
    cycle = limit_cycle(rotor, start=start)
    state, found = state_of(cycle), multipliers(cycle)
    other = once_round(rotor, state, cycle.period.item())
    np.testing.assert_allclose(other.end, state, rtol=0.0, atol=1e-9)
    assert other.crossings.size == 2 * cycle.contact_count.item()
    # the smallest are the differences of much larger numbers
    expected = np.sort_complex(np.linalg.eigvals(other.monodromy))
    np.testing.assert_allclose(np.sort_complex(found), expected, rtol=0.0, atol=1e-7)
    assert cycle.stability.item() == STABILITY["stable"]
    assert cycle.residual.item() < 1e-13
    assert cycle.multiplier_error.values.max() < 1e-11
    if rotor.load:
        assert np.isnan(cycle.trivial_defect)
    else:  # where M is large rounding is too
        assert cycle.trivial_defect < (1e-10 if name == "sliver" else 1e-13)


@pytest.mark.parametrize("name", CYCLES)
def test_phase_space_shrinks_at_the_rate_of_damping(name):
    """det M = exp of the integral of the divergence: -4 zeta - c N/(1 + c d') while pressed.

    Without contact damping multipliers come in two pairs of product exp(-2 zeta T).
    """
    rotor, start = CYCLES[name]
    cycle = limit_cycle(rotor, start=start)
    found, period = multipliers(cycle), cycle.period.item()
    if rotor.contact_damping:
        x, y, vx, vy = (cycle[each].values for each in ("x", "y", "vx", "vy"))
        radius = np.hypot(x, y)
        pressed = 1.0 + rotor.contact_damping * (x * vx + y * vy) / radius > 0.0
        spring = np.maximum(radius - rotor.delta0, 0.0) ** rotor.contact_exponent * pressed
        rate = 4.0 * rotor.zeta + np.mean(rotor.contact_damping * spring[:-1])
        assert np.prod(found).real == pytest.approx(np.exp(-rate * period), rel=2e-3)
        assert np.isnan(cycle.symplectic_defect)
        return
    q = math.exp(-2.0 * rotor.zeta * period)
    assert np.prod(found).real == pytest.approx(q * q, rel=1e-11)
    for each in found:
        assert np.abs(found - q / each).min() < 1e-12
    assert cycle.symplectic_defect.item() < 1e-14


@pytest.mark.parametrize(
    ("rotor", "times", "kind"), [(LYING, 1, "full_contact"), (LOADED, 2, "bouncing")]
)
def test_under_a_load_a_period_is_of_whole_revolutions(rotor, times, kind):
    cycle = limit_cycle(rotor, start=REST)
    assert kind_of(cycle) == kind
    assert revolutions(rotor, cycle.period.item()) == pytest.approx(times, abs=1e-14)
    again = limit_cycle(rotor, start=state_of(cycle), period=2.0 * cycle.period.item())
    assert again.period.item() == pytest.approx(cycle.period.item(), rel=1e-14)
    # the static deflection is a line that does not move: the mean on fixed axes
    static = cycle.line_kind.values == LINE_KIND["static"]
    assert cycle.frequency.values[static].tolist() == [0.0]
    z = (cycle.x.values + 1j * cycle.y.values) * np.exp(1j * rotor.omega * cycle.t.values)
    assert cycle.whirl_amplitude.values[static][0] == pytest.approx(abs(z[:-1].mean()), rel=1e-12)
    with pytest.raises(InputError, match="period must be a whole number of revolutions"):
        limit_cycle(rotor, start=state_of(cycle), period=1.4 * 2.0 * math.pi / rotor.omega)


def test_a_motion_may_repeat_itself_after_forty_revolutions_only():
    """No window of a sweep shows so many; a section of its own says that it takes no fewer."""
    rotor = Rotor(
        omega=1.67, zeta=0.041, delta0=1.0, shaft_stiffness=1.0, contact_exponent=1.0,
        contact_damping=1.0, load=1.09,
    )  # fmt: skip
    cycle = limit_cycle(rotor, start=(0.0, -0.5, 0.0, 0.0))
    assert revolutions(rotor, cycle.period.item()) == pytest.approx(40.0, abs=1e-10)
    section = poincare_section(rotor, start=state_of(cycle), revolutions=40)
    states = np.stack([section[f"rotating_{name}"] for name in ("x", "y", "vx", "vy")], axis=1)
    misses = np.abs(states[1:] - states[0]).max(axis=1)
    assert misses[-1] < 1e-7
    assert misses[:-1].min() > 1e-3


WHIP = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)


def test_a_whip_that_rolls_and_slips_for_ever_is_a_cycle():
    """Once round it is where it was, by CVODE as well, and one of its multipliers is 0."""
    amplitude = float(backward_whirl(WHIP).amplitude[-1])
    cycle = limit_cycle(WHIP, start=(amplitude, 0.0, 0.0, -10.0))
    assert kind_of(cycle) == "rolling"
    assert cycle.stability == STABILITY["stable"]
    assert cycle.residual < 1e-13
    found = multipliers(cycle)
    assert found[0] == 1.0
    assert found[3] == 0.0
    assert 0.0 < abs(found[1]) < 1.0
    start, period = state_of(cycle), cycle.period.item()
    run = simulate(WHIP, start=start, duration=period, samples=2, method="adams", rtol=1e-12)
    turn = np.exp(-1j * WHIP.omega * period)
    back = np.array([run.x[-1] + 1j * run.y[-1], run.vx[-1] + 1j * run.vy[-1]]) * turn
    expected = [complex(*start[:2]), complex(*start[2:])]
    np.testing.assert_allclose(back, expected, rtol=0.0, atol=1e-8)


def test_peak_force_and_impulse_are_those_of_cvodes_contacts():
    cycle = limit_cycle(BOUNCING.rotor, start=REST)
    run = simulate(BOUNCING.rotor, start=REST, duration=400.0, rtol=1e-11, atol=1e-13)
    last = run.isel(contact=-2)
    assert last["peak_force"].item() == pytest.approx(cycle["largest_force"].item(), rel=1e-8)
    assert last["impulse"].item() == pytest.approx(cycle["impulse_per_period"].item(), rel=1e-8)
    period = float(run["entry_time"][-2] - run["entry_time"][-3])
    assert period == pytest.approx(cycle["period"].item(), rel=1e-8)


@pytest.mark.parametrize("known", [*SLIVER, SPECIAL_POINTS[4]])
def test_unstable_and_barely_stable_cycles_from_a_near_start_alone(known):
    """No period given: the start comes back to itself, so it is a guess of the cycle there."""
    state = np.array(known.state) * (1.0 + 1e-6)
    cycle = limit_cycle(known.rotor, start=state)
    assert cycle["period"].item() == pytest.approx(known.period, rel=1e-7)


@pytest.mark.parametrize("start", [
    (-2.484357, -3.265325, 1.329065, -1.001068), (-2.483789, -3.271007, 1.330143, -1.005810),
])  # fmt: skip
def test_a_start_that_returns_closely_after_two_or_three_periods_leads_to_one(start):
    """Differences turn as they decay: the orbit comes near enough only after several periods."""
    cycle = limit_cycle(BOUNCING.rotor, start=start)
    assert cycle["period"].item() == pytest.approx(BOUNCING.period, abs=1e-11)
    assert cycle["contact_count"].item() == 1


def test_an_unstable_cycle_is_not_left_for_an_attractor():
    """Between its two doublings the bouncing cycle at omega 1.7 is unstable."""
    point = SPECIAL_POINTS[4]
    rotor = Rotor(omega=1.79, zeta=0.07, delta0=2.0)
    unstable = limit_cycle(rotor, start=point.state, period=point.period)
    assert unstable["stability"].item() == STABILITY["unstable"]
    assert abs(complex(unstable["multiplier_real"][0], unstable["multiplier_imag"][0])) > 1.0
    again = limit_cycle(rotor, start=shifted(unstable, 300))
    np.testing.assert_allclose(signature(again), signature(unstable), rtol=1e-12)


@pytest.mark.parametrize(("rotor", "start", "kind"), [
    (Rotor(omega=1.7, zeta=0.07, delta0=0.0), REST, "synchronous"),
    (Rotor(omega=1.7, zeta=0.07, delta0=9.0), REST, "contact_free"),
    (Rotor(omega=1.23, zeta=0.07, delta0=2.0), (1.7, -1.5, 0.0, 0.0), "touching"),
    (Rotor(omega=1.38, zeta=0.07, delta0=1.0), (1.5, -0.25, 0.0, 0.0), "chaotic"),
    (Rotor(omega=0.5, zeta=0.1, delta0=5.0, load=0.3, shaft_stiffness=1.0), REST, "contact_free"),
    (SOFT_RING, (0.0, -0.5, 0.0, 0.0), "chaotic"),
])  # fmt: skip
def test_without_a_cycle_it_says_what_there_is_instead(rotor, start, kind):
    found = limit_cycle(rotor, start=start)
    assert kind_of(found) == kind
    assert np.isnan(found["period"])
    assert np.isnan(found["multiplier_real"]).all()
    assert found["stability"].item() == STABILITY["absent"]
    assert found.sizes["t"] == 0


def test_one_period_comes_back_and_is_cvodes_motion():
    """Samples on the rotating axes, against a run that begins at the cycle."""
    cycle = limit_cycle(BOUNCING.rotor, start=REST)
    for name in ("x", "y", "vx", "vy"):
        assert cycle[name][-1].item() == pytest.approx(cycle[name][0].item(), abs=1e-12)
    times = cycle["t"].values
    assert times[-1] == cycle["period"].item()
    run = simulate(BOUNCING.rotor, start=shifted(cycle, 0), duration=times[-1], samples=times.size)
    turn = np.exp(-1j * BOUNCING.rotor.omega * times)
    there = (run["x"].values + 1j * run["y"].values) * turn
    np.testing.assert_allclose(there, cycle["x"] + 1j * cycle["y"], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("known", [BOUNCING, FULL])
def test_lines_of_the_spectrum_make_the_motion_again(known):
    """On fixed axes lines at omega + k 2 pi/T; their powers add up to the mean square radius."""
    cycle = limit_cycle(known.rotor, start=known.state)
    radius = np.hypot(cycle["x"].values[:-1], cycle["y"].values[:-1])
    power = float((cycle["whirl_amplitude"] ** 2).sum())
    assert power == pytest.approx(float((radius**2).mean()), rel=1e-9)
    spin = cycle["whirl_amplitude"].values[cycle["line_kind"].values == LINE_KIND["spin"]]
    assert spin.item() == pytest.approx(abs(np.mean(cycle["x"][:-1] + 1j * cycle["y"][:-1])))
    orders = (cycle["frequency"].values - known.rotor.omega) * known.period / (2.0 * np.pi)
    np.testing.assert_allclose(orders, np.round(orders), rtol=0.0, atol=1e-9)
    strongest = np.argmax(np.where(cycle["line_kind"] == LINE_KIND["spin"], 0.0,
                                   cycle["whirl_amplitude"]))  # fmt: skip
    ratio = float(cycle["frequency"][strongest]) / known.rotor.omega
    assert cycle["side_line_over_spin"].item() == pytest.approx(ratio, rel=1e-12)


def test_without_clearance_a_third_of_the_spin_speed_rules():
    """Always in contact: no contact begins, and the impulse is the integral of the force."""
    cycle = limit_cycle(WITHOUT_CLEARANCE, start=TO_IT)
    assert kind_of(cycle) == "full_contact"
    assert cycle["contact_count"].item() == 0
    run = simulate(WITHOUT_CLEARANCE, start=shifted(cycle, 0), samples=20_001,
                   duration=cycle["period"].item())  # fmt: skip
    radius = np.hypot(run["x"].values, run["y"].values)
    # trapezoids of a smooth periodic function: the ends are one sample
    impulse = float((radius[:-1] ** 1.5).mean() * cycle["period"])
    assert cycle["impulse_per_period"].item() == pytest.approx(impulse, rel=1e-8)
    assert cycle["largest_force"].item() == pytest.approx(float(radius.max() ** 1.5), rel=1e-6)
    assert cycle["radius_min"].item() == pytest.approx(float(radius.min()), abs=1e-6)
    assert abs(cycle["side_line_over_spin"].item()) == pytest.approx(1.0 / 3.0, abs=0.01)


@pytest.mark.parametrize("times", [2, 3, 10])
def test_a_multiple_of_the_period_leads_to_the_period(times):
    cycle = limit_cycle(BOUNCING.rotor, start=BOUNCING.state, period=times * BOUNCING.period)
    assert cycle["period"].item() == pytest.approx(BOUNCING.period, abs=1e-11)
    assert cycle["contact_count"].item() == 1
    assert cycle.attrs["start_period"] == times * BOUNCING.period


@pytest.mark.parametrize("part", [0.001, 0.5, 1.5])
def test_a_wild_period_raises_with_the_place(part):
    with pytest.raises(SimulationError, match="found no limit cycle in 25 steps: period") as wild:
        limit_cycle(BOUNCING.rotor, start=BOUNCING.state, period=part * BOUNCING.period)
    assert wild.value.state is not None


@pytest.mark.parametrize(("change", "says"), [
    ({"zeta": 0.0}, "zeta must be above 0 for a limit cycle, got 0.0: nothing settles"),
    ({"omega": 0.0}, "omega must be above 0 for a limit cycle, got 0.0: nothing settles"),
    ({"omega": 1e-6}, "omega must be 0 or from 0.001 to 1000 to settle, got 1e-06"),
    ({"omega": 1e5}, "omega must be 0 or from 0.001 to 1000 to settle, got 100000.0"),
    ({"delta0": 1e7}, "delta0 must be at most 1e.06 to be simulated, got 10000000.0"),
])  # fmt: skip
def test_rotors_without_an_answer_are_refused_at_once(change, says):
    rotor = Rotor(**({"omega": 2.0, "zeta": 0.07, "delta0": 2.0} | change))
    for period in (None, 3.0):
        with pytest.raises(InputError, match=says):
            limit_cycle(rotor, start=REST, period=period)


def test_little_damping_large_clearance():
    """Period and extremes by CVODE's own motion, at zeta 0.01."""
    rotor = Rotor(omega=2.0, zeta=0.01, delta0=5.0)
    start = (7.0, 1.0, 0.0, 3.0)
    row = rotor_ida.sweep(omega=2.0, zeta=0.01, delta0=5.0, starts=[start]).squeeze()
    cycle = limit_cycle(rotor, start=start)
    assert kind_of(cycle) == "bouncing"
    np.testing.assert_allclose(signature(row), signature(cycle), rtol=1e-8)
    assert cycle["trivial_defect"].item() < 1e-10
    assert cycle["symplectic_defect"].item() < 1e-13


def check_points(found, alone_at, dim):
    """Check that each point of a result along a dimension is that of a call of its own."""
    numbers = [name for name in found.data_vars if name not in {"status", "message"}]
    for at in found[dim].values.tolist():
        point, alone = found.sel({dim: at}), alone_at(at)
        for name in numbers:
            if "t" in alone[name].dims:  # the state at its start
                expected = alone[name].values[0] if alone.sizes["t"] else np.nan
            else:
                expected = alone[name].values
            np.testing.assert_allclose(point[name], expected, rtol=1e-10, atol=1e-12, err_msg=name)
            assert point[name].dtype == alone[name].dtype
            np.testing.assert_equal(found[name].attrs, alone[name].attrs)


def test_each_point_is_that_of_one_call():
    found = limit_cycle(ROTOR, omega=OMEGA)
    assert found.period.dims == ("omega",)
    assert found.multiplier_error.dims == ("omega", "multiplier")
    assert decode_flags(found.response).values.tolist() == ["bouncing", "bouncing", "contact_free"]
    assert decode_flags(found.status).values.tolist() == ["done"] * 3
    check_points(found, lambda omega: limit_cycle(ROTOR, omega=omega), "omega")
    alone = limit_cycle(ROTOR, omega=2.0)
    assert {*alone.data_vars} - {*found.data_vars} == {"frequency", "whirl_amplitude", "line_kind"}


def test_parameters_of_a_rotor_system_vary_beside_its_speed():
    system = FRICTIONAL.system()
    start = [np.array(TO_WHIP[:2]), np.array(TO_WHIP[2:])]
    found = limit_cycle(system, speed=[1.0], friction=[0.1, 0.2], start=start)
    assert found.radius_max.dims == ("speed", "friction", "contact")
    disc = limit_cycle(FRICTIONAL, friction=[0.1, 0.2], start=TO_WHIP)
    assert decode_flags(disc.response).values.tolist() == ["synchronous", "rolling"]
    np.testing.assert_array_equal(found.response.isel(speed=0), disc.response)
    np.testing.assert_allclose(found.period.isel(speed=0), disc.period, rtol=1e-8)
    assert found.friction.attrs["long_name"] != disc.friction.attrs["long_name"]


def test_a_cycle_is_a_guess_at_each_point_and_each_point_is_one():
    one = limit_cycle(ROTOR)
    found = limit_cycle(ROTOR, omega=OMEGA[:2], start=one)
    np.testing.assert_allclose(found.period, limit_cycle(ROTOR, omega=OMEGA[:2]).period, rtol=1e-9)
    again = limit_cycle(ROTOR, start=found.sel(omega=2.0))
    np.testing.assert_allclose(again.period, one.period, rtol=1e-12)
    np.testing.assert_allclose(state_of(again), state_of(one), atol=1e-9)
    of_system = limit_cycle(SYSTEM, speed=2.0)
    others = limit_cycle(SYSTEM, clearance=[1.95, 2.0], start=of_system)
    np.testing.assert_allclose(others.period[1], one.period, rtol=1e-8)
    back = limit_cycle(SYSTEM, start=others.isel(clearance=1))
    np.testing.assert_allclose(back.period, one.period, rtol=1e-8)


def test_a_point_that_fails_says_why(monkeypatch):
    def found_cycle(guess, stop):
        if guess.rotor.omega == 1.9:
            raise SimulationError("it was told to")
        return search(guess, stop)

    search = search_module.found_cycle
    monkeypatch.setattr(search_module, "found_cycle", found_cycle)
    found = limit_cycle(ROTOR, omega=OMEGA[:2], executor="serial")
    assert decode_flags(found.status).values.tolist() == ["failed", "done"]
    assert found.message.values.tolist() == ["it was told to", ""]
    assert decode_flags(found.response).values.tolist() == ["failed", "bouncing"]
    assert decode_flags(found.stability).values.tolist() == ["absent", "stable"]
    assert np.isnan(found.period[0])
    assert found.contact_count.values.tolist() == [0, 1]


@pytest.mark.parametrize(("rotor", "given", "words"), [
    (ROTOR, {"omega": [2.0, 2.0]}, "omega must have each value once"),
    (ROTOR, {"omega": [0.0, 1.0]}, "omega must be above 0 for a limit cycle, got 0.0"),
    (ROTOR, {"speed": [1.0, 2.0]}, "speed must be left out with one disc"),
    (ROTOR, {"frictoin": [0.1]}, "limit_cycle has no argument 'frictoin'; did you mean 'friction'"),
    (ROTOR, {"omega": OMEGA, "period": 1e9}, "period must lie from 1e-06 to 10000.0, got"),
    (ROTOR, {"study": "s"}, "study must be left out of one cycle, got 's'"),
    (MACHINE, {"omega": [1.0, 2.0]}, "omega must be left out with a machine: give its speed"),
    (SYSTEM, {"speed": [0.0, 1.0]}, "speed must not be 0 for a limit cycle"),
    (SYSTEM, {"friction": [0.0, 0.1], "speed": 2.0}, "radius of the contact at 'disc' must be"),
    (SYSTEM, {"clearance": [1.0, 2.0]}, "speed must be given for a limit cycle of a system"),
    (SYSTEM, {"damping": [0.0, 1.0], "speed": 2.0}, "damping must be above 0 for a limit cycle"),
    (SYSTEM, {"study": "s", "speed": 2.0}, "study must be left out of one cycle"),
])  # fmt: skip
def test_what_cannot_be_asked_is_refused(rotor, given, words):
    with pytest.raises(InputError, match=words):
        limit_cycle(rotor, **given)
