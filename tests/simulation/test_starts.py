"""A result that ends in a state is a start wherever one is taken."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Race,
    Rotor,
    bifurcation_diagram,
    limit_cycle,
    lyapunov_exponent,
    poincare_section,
    resume,
    run_up,
    run_ups,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.starts import start_of, start_of_system
from rotor_ida.verification.verify import question_of

BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
OTHERS = {"zeta": 0.07, "delta0": 2.0}
PERIOD = 4.5639166754
FIRST, REST_OF = 17.3, 12.7
SYSTEM = BOUNCING.system()
AROUND = {"speed": 2.0}


@pytest.fixture(scope="module")
def cycle():
    return limit_cycle(BOUNCING)


@pytest.fixture(scope="module")
def point():
    return sweep(omega=[2.0, 2.2], **OTHERS)


def one_of(swept):
    return swept.isel(omega=0, zeta=0, delta0=0, start=0, direction=0)


def states_of(run):
    return np.array([run.x, run.y, run.vx, run.vy])


def test_two_parts_of_a_run_are_the_run():
    """The unbalance is along x at the start of the second part, which is turned by that angle."""
    whole = simulate(BOUNCING, duration=FIRST + REST_OF, samples=[FIRST, FIRST + REST_OF])
    first = simulate(BOUNCING, duration=FIRST)
    second = simulate(BOUNCING, start=first, duration=REST_OF, samples=[REST_OF])
    turn = np.exp(2.0j * FIRST)
    for x, y in (("x", "y"), ("vx", "vy")):
        there, here = (run[x].values[-1] + 1j * run[y].values[-1] for run in (whole, second))
        assert abs(here * turn - there) < 1e-8


def test_the_end_of_a_run_up_or_of_run_ups_begins_a_run_at_the_last_speed():
    fast = Rotor(omega=2.4, **OTHERS)
    up = run_up(BOUNCING, to=2.4, rate=0.1)
    many = run_ups(omega=2.0, to=2.4, rate=0.1, **OTHERS).squeeze()
    begun = [simulate(fast, start=each, duration=1.0).isel(t=0) for each in (up, many)]
    np.testing.assert_allclose(*map(states_of, begun), rtol=0.0, atol=1e-8)
    assert np.hypot(begun[0].x, begun[0].y) == pytest.approx(np.hypot(up.x[-1], up.y[-1]).item())
    again = simulate(SYSTEM, **AROUND, duration=1.0, start=run_up(SYSTEM, **AROUND, to=2.4, rate=1))
    assert np.isfinite(again.x).all()


def test_cycles_and_points_of_sweeps_begin_what_they_are(cycle, point):
    assert limit_cycle(BOUNCING, start=one_of(point)).period.item() == pytest.approx(PERIOD)
    assert limit_cycle(BOUNCING, start=simulate(BOUNCING, duration=30.0)).period.item() == (
        pytest.approx(PERIOD)
    )
    for start in (cycle, one_of(point)):
        run = simulate(BOUNCING, start=start, duration=1.0)
        assert cycle.radius_min - 1e-6 < np.hypot(run.x, run.y).min() < cycle.radius_max
        swept = sweep(omega=2.0, **OTHERS, starts=start)
        assert swept.period.item() == pytest.approx(PERIOD)
    both = sweep(omega=2.0, **OTHERS, starts=[(0, 0, 0, 0), cycle])
    assert both.sizes["start"] == 2
    assert both.start_x[1] == cycle.x[0]
    diagram = bifurcation_diagram(omega=2.0, **OTHERS, starts=cycle)
    assert diagram.extremum_radius.max() == pytest.approx(cycle.radius_max.item(), rel=1e-7)
    held = poincare_section(BOUNCING, start=cycle, revolutions=2)
    assert held.rotating_x[0].item() != 0.0
    exponents = lyapunov_exponent(BOUNCING, start=cycle, transient=1.0, duration=2000.0)
    assert abs(exponents.lyapunov_exponent.values[0]) < 1e-4


def test_cycles_and_points_of_sweeps_begin_motions_of_systems():
    run = simulate(SYSTEM, **AROUND, duration=FIRST)
    cycle = limit_cycle(SYSTEM, **AROUND, start=run)
    assert cycle.period.item() == pytest.approx(PERIOD)
    swept = sweep(SYSTEM, speed=[2.0], starts=[run, cycle])
    np.testing.assert_allclose(swept.period.values.ravel(), PERIOD)
    alone = swept.isel(speed=0, start=0, direction=0)
    again = simulate(SYSTEM, **AROUND, start=alone, duration=1.0)
    np.testing.assert_array_equal([again.x[0, 0], again.y[0, 0]], alone.final_state.values[:2])
    exponents = lyapunov_exponent(
        SYSTEM, **AROUND, start=cycle, transient=5, revolutions=80, batches=4
    )
    assert abs(exponents.lyapunov_exponent.values[0]) < 1e-3


def test_a_load_and_unequal_directions_need_whole_revolutions(point):
    loaded = Rotor(omega=2.0, load=0.3, **OTHERS)
    with pytest.raises(InputError, match="start must end after whole revolutions under a load"):
        simulate(loaded, start=simulate(loaded, duration=FIRST), duration=1.0)
    whole = simulate(loaded, duration=3.0 * np.pi)
    begun = simulate(loaded, start=whole, duration=1.0)
    np.testing.assert_array_equal(states_of(begun)[:, 0], states_of(whole)[:, -1])
    run = simulate(SYSTEM, **AROUND, gravity=(0.0, -0.3), duration=FIRST)
    with pytest.raises(InputError, match="start must end after whole revolutions, as the system"):
        simulate(SYSTEM, **AROUND, gravity=(0.0, -0.3), start=run, duration=1.0)
    with pytest.raises(InputError, match="start must be one point of a result, got all over omega"):
        simulate(BOUNCING, start=point, duration=1.0)


def test_a_result_of_another_kind_or_size_is_refused(cycle):
    exact = synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    run = simulate(SYSTEM, **AROUND, duration=1.0)
    none = limit_cycle(Rotor(omega=0.5, zeta=0.5, delta0=2.0))
    for start, kind in (
        (exact, "exact whirls"), (run, "run of a rotor system"), (none, "limit cycle")
    ):  # fmt: skip
        with pytest.raises(InputError, match=rf"point of a sweep of one disc does, got: {kind}$"):
            simulate(BOUNCING, start=start, duration=1.0)
    with pytest.raises(InputError, match=r"of a rotor system does, got: limit cycle$"):
        simulate(SYSTEM, **AROUND, start=cycle, duration=1.0)
    spun = [Contact(node="disc", clearance=1.0, stiffness=1.0, friction=0.1, radius=1.0,
                    race=Race(inertia=1.0, radius=1.0))]  # fmt: skip
    with pytest.raises(InputError, match=r"start must end in 5 finite numbers, as this system has"):
        simulate(SYSTEM, contacts=spun, speed=2.0, start=run, duration=1.0)


HELD = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.5, load=0.3)
RUBS = {"friction": 0.2, "disc_radius": 5.0}
OF_WORDS = [
    (Rotor(omega=2.0, zeta=0.07, delta0=2.0), "settled"),
    (Rotor(omega=1e-200, zeta=0.07, delta0=2.0), "settled"),
    (HELD, "settled"),
    (HELD, "rest"),
    (replace(HELD, shaft_stiffness=0.0, **RUBS), "rest"),  # climbs the stator
    (replace(HELD, shaft_stiffness=0.1, load=1.0, contact_exponent=1.0, **RUBS), "rest"),
]


@pytest.mark.parametrize(("rotor", "word"), OF_WORDS)
def test_words_are_the_starts_of_the_same_rotor_as_a_system(rotor, word):
    """Which solves linear equations, and finds rest as the minimum of a potential."""
    of_system = start_of_system(assemble(rotor.system()), word, rotor.omega).ravel()
    np.testing.assert_allclose(start_of(rotor, word), of_system, rtol=1e-9, atol=1e-12)


def test_settled_the_rotor_stays_on_its_whirl_in_si_too():
    """Until 20 revolutions later, at the amplitude of the closed form."""
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=1000.0,
    )  # fmt: skip
    run = simulate(machine, start="settled", duration=20.0 * math.tau / 1000.0)
    whirl = synchronous_response(machine).amplitude.isel(branch=0).item()
    np.testing.assert_allclose(np.hypot(run.x, run.y), whirl, rtol=1e-12)
    assert run.sizes["event"] == 0
    state = tuple(run[name].values[0] for name in ("x", "y", "vx", "vy"))
    assert run.attrs["start"] == pytest.approx(state, rel=1e-14)
    np.testing.assert_array_equal(run_up(machine, start="settled", to=1100.0, rate=1e4).x[0],
                                  run.x[0])  # fmt: skip


def test_every_verb_of_a_start_takes_the_words():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    state = start_of(rotor, "settled")
    asked = {
        poincare_section: {"revolutions": 3},
        lyapunov_exponent: {"transient": 10.0, "duration": 100.0, "batches": 4},
        limit_cycle: {},
    }
    for verb, given in asked.items():
        by_word, by_state = (verb(rotor, start=each, **given) for each in ("settled", state))
        assert by_word.drop_attrs(deep=False).equals(by_state.drop_attrs(deep=False)), verb
    machine = DimensionalRotor(
        mass=1.0, contact_stiffness=1.0, damping=0.14, eccentricity=1.0, clearance=2.0, speed=2.0
    )
    assert poincare_section(machine, start="settled", revolutions=3).sizes["crossing"] == 4


@pytest.mark.parametrize("verb", [sweep, bifurcation_diagram])
def test_over_the_speed_a_word_is_the_start_at_each(verb, tmp_path):
    """Each point is that from its own settled whirl; the study and the archive know the word."""
    given = {"zeta": 0.1, "delta0": 1.2}
    found = verb(omega=[0.8, 2.0], **given, starts=["settled", (3.0, 0.0, 0.0, 0.0)],
                 study=tmp_path / "study")  # fmt: skip
    assert np.isnan(found.start_x.values).tolist() == [True, False]
    for number, omega in enumerate((0.8, 2.0)):
        state = start_of(Rotor(omega=omega, **given), "settled")
        alone = verb(omega=omega, **given, starts=[state])
        assert alone.radius_max.item() == found.radius_max[number, 0, 0, 0]
    assert resume(tmp_path / "study").identical(found)
    again = question_of(found).ask()
    assert again.drop_attrs(deep=False).identical(found.drop_attrs(deep=False))


def test_run_ups_begin_on_the_whirl_at_their_phase():
    """So that the phase makes no difference without a load."""
    given = {"omega": 0.5, "to": 0.6, "rate": 0.01, "zeta": 0.1, "delta0": 2.0}
    found = run_ups(**given, phase=[0.0, 2.0], starts="settled")
    np.testing.assert_allclose(np.ptp(found.largest_radius.values), 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("rotor", "start", "message"),
    [
        (HELD, "setled", "start must be one of 'settled', 'rest', got 'setled'; did you mean"),
        (
            replace(HELD, shaft_stiffness=0.0), "settled",
            "start cannot be settled without shaft_stiffness",
        ),
        (
            Rotor(omega=1.0, zeta=0.0, delta0=2.0, shaft_stiffness=1.0), "settled",
            "start cannot be settled, as the stiffness is singular at this speed",
        ),
    ],
)  # fmt: skip
def test_words_that_are_no_start_are_refused(rotor, start, message):
    with pytest.raises(InputError, match=message):
        simulate(rotor, start=start, duration=1.0)
