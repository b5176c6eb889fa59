"""Starts of one disc under a load, side by side: the direction of the load, regions, and labels."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, basin
from rotor_ida.basins.attractors import kind_of
from rotor_ida.basins.cycle_sections import cycle_section
from rotor_ida.basins.fates import ALONE
from rotor_ida.basins.known import contact_free_whirls
from rotor_ida.basins.subjects import KnockedSystem, settled_row
from rotor_ida.core.runs import NO_STOP
from rotor_ida.cycles.shooting import close_orbit, once_round
from rotor_ida.model.assembly import assemble
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.system_flow import SettlingProblem
from rotor_ida.steady.follow import settle_disc
from tests.basins.lanes import GO_ON, followed

LOADED = {
    "no shaft": Rotor(omega=2.0, zeta=0.2, delta0=1.0, load=0.4),
    "two revolutions": Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3),
    "no clearance": Rotor(omega=1.4, zeta=0.1, delta0=0.0, load=0.2, contact_exponent=1.0),
    "contact damping and friction": Rotor(
        omega=0.8, zeta=0.15, delta0=0.5, load=0.5, contact_damping=0.2, friction=0.1,
        disc_radius=3.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("rotor", LOADED.values(), ids=LOADED)
def test_orbits_end_where_taylor_series_lead_them(rotor):
    """After times that are no whole revolutions as well: the load has then turned by a part."""
    states = np.random.default_rng(2).uniform(-3.0, 3.0, (4, 24))
    flow = DiscFlow(rotor, NO_STOP)
    for duration in (0.6, 3.0 * flow.revolution, 8.3):
        ends, labels, times = followed(rotor, states, duration, 1e-11)
        alike = labels == -1  # else the disc rolls, which no lane follows
        assert alike.sum() > 6
        assert (times[alike] == np.float32(duration)).all()
        for number in np.flatnonzero(alike).tolist():
            exact = flow.after(states[:, number], duration)
            np.testing.assert_allclose(ends[:, number], exact, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("name", ["no shaft", "two revolutions"])
def test_states_in_the_region_of_a_cycle_return_nearer(name):
    """Followed twice round by Taylor series, of which the search for the region knows nothing."""
    rotor = LOADED[name]
    flow = DiscFlow(rotor, NO_STOP)
    settled = settle_disc(rotor, (2.0, 0.0, 0.0, 0.0), ALONE)
    cycle = once_round(close_orbit(flow, np.array(settled.motion.state), settled.features.period))
    section = cycle_section(cycle, GO_ON)
    assert section.exists
    drawn = np.random.default_rng(5).normal(size=(4, 40))
    offsets = np.linalg.solve(section.form, drawn / np.linalg.norm(drawn, axis=0))
    assert np.linalg.norm(offsets, axis=0).max() > 1e-3
    for offset in offsets.T:
        reached = flow.after(section.centre + offset, 2.0 * cycle.duration) - section.centre
        assert np.linalg.norm(section.form @ reached) < 1.0


def test_a_whirl_about_its_sagging_position_is_never_left():
    """Taylor series from where lanes say so touch the ring no more."""
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=1.2, shaft_stiffness=4.0, load=0.6)
    states = np.random.default_rng(3).uniform(-2.0, 2.0, (4, 40))
    free, flow = contact_free_whirls(rotor, NO_STOP, fading=False), DiscFlow(rotor, NO_STOP)
    revolution = flow.revolution
    _, labels, times = followed(rotor, states, 40.0 * revolution, 1e-9, free.row)
    assert (labels == 0).all()
    assert times.max() > 10.0
    for start, time in zip(states.T, times.tolist(), strict=True):
        touches = flow.observed(start, np.linspace(0.0, time + 50.0, 400)).event_times
        assert (touches <= time + 1e-3).all()


RANDOM = np.random.default_rng(11)
DRAWN = [
    {
        "omega": RANDOM.uniform(0.8, 2.5),
        "zeta": RANDOM.uniform(0.08, 0.25),
        "delta0": RANDOM.uniform(0.3, 1.5),
        "load": RANDOM.uniform(0.1, 0.5),
        "shaft_stiffness": RANDOM.uniform(0.1, 1.0),
    }
    for _ in range(3)
]
# Three cycles, of one, two and three revolutions.
DRAWN.append({"omega": 1.327, "zeta": 0.098, "delta0": 0.786, "load": 0.234})


@pytest.mark.parametrize("given", DRAWN, ids=range(len(DRAWN)))
def test_every_cell_is_labelled_as_its_start_settles_as_a_system(given):
    """The kernel of rotor systems follows each start alone, and knows nothing of regions."""
    rotor, axis = Rotor(**given), np.linspace(-3.0, 3.0, 3)
    found = basin(rotor, x=axis, y=axis, vx=0.4, vy=-0.2)
    problem = SettlingProblem.of(assemble(rotor.system()), 1e-10)
    knocked = KnockedSystem.at(problem, rotor.omega, "disc", None)
    flow = knocked.flow(NO_STOP)
    for x in range(3):
        for y in range(3):
            start = np.array([[axis[x]], [axis[y]], [0.4], [-0.2]])
            row = settled_row(flow, knocked.states(flow, start)[0])
            here = found.isel(attractor=int(found.label.isel(x=x, y=y)))
            assert here.kind.item() == RESPONSE[kind_of(row)]
            for name in ("radius_min", "radius_max"):
                assert here[name].item() == pytest.approx(row[name].item(), abs=1e-6)
            np.testing.assert_allclose(here.period.item(), row["period"], rtol=1e-9)


def test_most_starts_are_held_by_the_region_of_the_cycle_and_not_followed_alone():
    axis = np.linspace(-3.0, 3.0, 24)
    rotor = LOADED["two revolutions"]
    found = basin(rotor, x=axis, y=axis)
    assert found.kind.values.tolist() == [RESPONSE["bouncing"]]
    assert found.trapping.values.tolist() == [TRAPPING["estimated"]]
    assert found.agreement == 1.0
    assert int(found.agreement_count) > 0
    revolutions = found.settling_time.values * rotor.omega / (2.0 * math.pi)
    np.testing.assert_allclose(revolutions, revolutions.round(), atol=1e-4)
