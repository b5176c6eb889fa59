"""What mechanics says of every motion, tried on motions that Hypothesis chooses."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rotor_ida import Rotor, simulate
from rotor_ida.model.equations import energy
from rotor_ida.simulation import run as simulation_run

coordinates = st.floats(-2.0, 2.0)
starts = st.tuples(coordinates, coordinates, coordinates, coordinates)
rotors = st.builds(
    Rotor,
    omega=st.floats(0.1, 4.0),
    zeta=st.sampled_from([0.0, 1e-8, 0.07, 0.5]),
    delta0=st.sampled_from([0.0, 0.1, 0.5, 2.0]),
)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def states_of(run):
    return np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)


def power(times, states, rotor):
    """What the unbalance gives, less what damping takes."""
    _, _, vx, vy = states.T
    given = rotor.omega**2 * (np.cos(rotor.omega * times) * vx + np.sin(rotor.omega * times) * vy)
    return given - 2.0 * rotor.zeta * (vx**2 + vy**2)


@settings(max_examples=25, deadline=None)
@given(rotors, starts)
def test_energy_changes_by_the_work_done(rotor, start):
    """Gauss quadrature of the power between the events, so that it meets no kink."""
    duration = 12.0
    events = simulate(rotor, start=start, duration=duration, rtol=1e-12, atol=1e-14)
    edges = np.unique(np.concatenate([events.event_time.values, np.linspace(0, duration, 97)]))
    middle, half = (edges[1:] + edges[:-1]) / 2, np.diff(edges) / 2
    times = np.unique((middle[:, None] + half[:, None] * NODES).ravel())
    assume(times.size == middle.size * NODES.size)  # no event within rounding of another
    run = simulate(rotor, start=start, duration=duration, samples=times, rtol=1e-12, atol=1e-14)
    rate = power(times, states_of(run), rotor).reshape(middle.size, -1)
    work = float((rate @ WEIGHTS * half).sum())
    ends = simulate(rotor, start=start, duration=duration, samples=2, rtol=1e-12, atol=1e-14)
    first, last = energy(states_of(ends), rotor.delta0)
    assert last - first == pytest.approx(work, abs=1e-8 * max(1.0, first, abs(work)))


@settings(max_examples=20, deadline=None)
@given(rotors, starts)
def test_samples_and_events_keep_to_their_side_of_the_ring(rotor, start):
    """Without the checks that every run makes of itself, and more closely than they do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulation_run, "check_orbit", lambda orbit: None)
        run = simulate(rotor, start=start, duration=15.0)
    times, kinds = run.event_time.values, run.event_kind.values
    assert (np.diff(times) > 0.0).all()
    assert (kinds[1:] == -kinds[:-1]).all()
    if kinds.size:
        assert (kinds[0] == 1) == (run.starts_in_contact == 0)
    depth = np.hypot(run.x.values, run.y.values) - rotor.delta0
    passed = np.searchsorted(times, run.t.values, side="right")
    inside = (passed % 2 == 1) != bool(run.starts_in_contact)
    assert (np.where(inside, depth, -depth) > -1e-9).all()
    assert run.peak_indentation.values.size == math.ceil(
        (kinds.size + int(run.starts_in_contact)) / 2
    )
