"""Runs, responses and cycles at a held speed on bearings with tables: those of the plain system."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    basin_fractions,
    bifurcation_diagram,
    continue_cycle,
    drop,
    limit_cycle,
    lyapunov_exponent,
    poincare_section,
    simulate,
    special_speeds,
    sweep,
)
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from tests.films import on_films

SPEED = 1700.0


@pytest.fixture(scope="module", params=[0.0, 0.3], ids=["equal", "unequal"])
def system(request):
    return on_films(unequal=request.param)


@pytest.mark.parametrize("start", [None, "settled"])
@pytest.mark.parametrize("modes", [None, 4])
def test_a_run_at_a_speed_is_that_of_the_plain_system(system, start, modes):
    given = {"speed": SPEED, "start": start, "duration": 0.02, "samples": 5, "modes": modes}
    one, other = (simulate(each, **given) for each in (system, system.at(SPEED)))
    np.testing.assert_array_equal(one.event_time, other.event_time)
    np.testing.assert_array_equal(one.final_state, other.final_state)
    if start is None:
        assert one.sizes["event"] > 0


def test_few_modes_hold_films_as_all_do(system):
    """The basis keeps the bearings' nodes, so that any coefficient bends the rotor rightly."""
    whole, few = (
        sweep(system, speed=[400.0, 1000.0], contacts=[], modes=modes, starts=["settled"])
        for modes in (None, 6)
    )
    np.testing.assert_allclose(few.node_radius_max, whole.node_radius_max, rtol=2e-3)


@pytest.mark.parametrize(
    ("verb", "given", "names"),
    [
        (sweep, {}, ("radius_max", "node_radius_max")),
        (limit_cycle, {"start": "settled"}, ("radius_max", "multiplier_real")),
        (lyapunov_exponent, {"revolutions": 80, "batches": 4, "transient": 1, "exponents": 1},
         ("lyapunov_exponent",)),
        (poincare_section, {"revolutions": 5}, ("rotating_x", "rotating_y")),
        (bifurcation_diagram, {"revolutions": 5}, ("extremum_radius",)),
    ],
)  # fmt: skip
def test_an_answer_at_a_speed_is_that_of_the_plain_system(system, verb, given, names):
    one, other = (verb(each, speed=SPEED, **given) for each in (system, system.at(SPEED)))
    for name in names:
        np.testing.assert_allclose(one[name], other[name], rtol=1e-8, atol=1e-13)


def test_basins_at_a_speed_are_those_of_the_plain_system():
    one, other = (
        basin_fractions(each, speed=SPEED, node="1", x=(-2e-5, 2e-5), y=(-2e-5, 2e-5), starts=4,
                        seed=1)
        for each in (on_films(), on_films().at(SPEED))
    )  # fmt: skip
    np.testing.assert_array_equal(one.response_fraction, other.response_fraction)


def test_a_drop_at_a_held_speed_is_that_of_the_plain_system(system):
    given = {"speed": SPEED, "duration": 0.01, "samples": 3}
    wide = replace(system.contacts[0], clearance=1e-3)
    system = replace(system, translations=system.unit_translations(), contacts=[wide])
    one, other = (drop(each, **given) for each in (system, system.at(SPEED)))
    np.testing.assert_array_equal(one.final_state, other.final_state)


def test_a_state_changes_with_the_speed_by_the_slopes_of_the_tables(system):
    """Derivatives of the core against differences of flows at two speeds."""
    flow = SystemFlow.at(SettlingProblem.of(assemble(system), 1e-12), SPEED, NO_STOP)
    state = np.random.default_rng(3).normal(size=flow.scales.size) * 0.1
    until = 0.3 * flow.revolution
    (exact,) = flow.run(state, until, by=["speed"]).by
    step = 1e-4 * SPEED
    ahead, back = (flow.but(speed=SPEED + side * step).after(state, until) for side in (1, -1))
    np.testing.assert_allclose(exact, (ahead - back) / (2.0 * step), rtol=1e-5,
                               atol=1e-6 * np.abs(exact).max())  # fmt: skip


def test_cycles_are_followed_over_the_speed_with_the_coefficients_at_each():
    system = on_films(unequal=0.3)
    start = limit_cycle(system, start="settled", speed=SPEED)
    branch = continue_cycle(system, start=start, parameter="speed", limits=(SPEED, 1900.0),
                            points=6)  # fmt: skip
    last = branch.isel(point=-1)
    speed = float(last.speed)
    plain = limit_cycle(system.at(speed), start="settled", speed=speed)
    np.testing.assert_allclose(last.radius_max, plain.radius_max, rtol=1e-8)


def test_a_speed_outside_the_table_is_refused(system):
    for verb in (simulate, sweep):
        more = {"duration": 0.1} if verb is simulate else {}
        with pytest.raises(InputError, match="speed must lie within the table of the bearing"):
            verb(system, speed=3000.0, **more)


def test_a_growth_is_told_with_the_speed_at_which_it_begins():
    """The same threshold as that of `special_speeds`, by other eigenvalues."""
    system = on_films(unequal=0.3, cross=6000.0)
    with pytest.warns(UserWarning, match=r"unstable from [\d,]+ rpm on"):
        run = simulate(system, speed=2300.0, duration=1e-3, samples=3)
    found = special_speeds(system, limits=(160.0, 2390.0), points=20)
    threshold = found.special_speed.item()
    assert run.attrs["growth_begins_at"] == pytest.approx(threshold, rel=1e-4)
