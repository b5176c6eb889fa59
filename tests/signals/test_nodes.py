"""Signals at a node of a rotor system are those of the same rotor as one disc."""

import re

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    concat,
    contact_forces,
    full_spectrum,
    orders,
    run_up,
    signals_of,
    simulate,
)

ROTOR = Rotor(omega=1.2, zeta=0.3, delta0=1.1, shaft_stiffness=0.2)
REST = (0.0, 0.0, 0.0, 0.0)
CHAIN = np.array([[8e6, -4e6], [-4e6, 6e6]])
# two discs on a shaft, in SI units
SYSTEM = RotorSystem(
    mass=np.diag([12.0, 12.0, 8.0, 8.0]), stiffness=np.kron(CHAIN, np.eye(2)),
    damping=np.kron(2e-3 * CHAIN, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
)  # fmt: skip
FAR = Contact(node="seal", clearance=1e-3, stiffness=5e7)
TURNS = {
    "unbalance": [Unbalance(node="disc", moment=1e-3)], "contacts": [FAR], "speed": 450.0,
    "duration": 0.5,
}  # fmt: skip


@pytest.fixture(scope="module")
def clear():
    """Return a run that settles on a whirl without contact."""
    return simulate(SYSTEM, **TURNS)


@pytest.mark.parametrize("ramp", [{}, {"to": 1.6, "rate": 0.01}])
def test_one_disc_gives_the_same_signals_as_its_system(ramp):
    system = ROTOR.system()
    samples = np.linspace(0.0, 40.0, 2001)
    parts = {"speed": ROTOR.omega}
    if ramp:
        disc = run_up(ROTOR, start=REST, samples=samples, **ramp)
        run = run_up(system, samples=samples, **parts, **ramp)
    else:
        disc = simulate(ROTOR, start=REST, duration=40.0, samples=samples)
        run = simulate(system, duration=40.0, samples=samples, **parts)
    one, other = signals_of(disc), signals_of(run, node="disc")
    for name in ("t", "x", "y", "angle"):
        np.testing.assert_allclose(other[name], one[name], rtol=0, atol=1e-8)
        assert other[name].attrs == one[name].attrs
    assert float(other.clearance) == ROTOR.delta0
    assert str(other.node.values) == "disc"
    for analyse in (full_spectrum, lambda each: orders(each, revolutions=2)):
        here, there = analyse(other), analyse(one)
        assert here.sizes == there.sizes
        assert set(there.data_vars) == set(here.data_vars)
        assert str(here.node.values) == "disc"


def test_units_and_angle_of_a_system_in_si_units(clear):
    signals = signals_of(clear, node="seal")
    assert (signals.x.attrs["units"], signals.t.attrs["units"]) == ("m", "s")
    np.testing.assert_array_equal(signals.x, clear.x.sel(node="seal"))
    np.testing.assert_allclose(signals.angle, 450.0 * clear.t)
    assert signals.attrs["result_kind"] == "signals"


def test_the_spectrum_of_a_node_peaks_at_the_speed_with_the_exact_amplitude(clear):
    late = signals_of(clear.sel(t=slice(0.3, None)), node="seal")
    found = full_spectrum(late)
    peak = found.isel(frequency=int(np.argmax(found.whirl_amplitude.values)))
    assert float(peak.frequency_over_omega) == pytest.approx(1.0, abs=0.05)
    # z = u Omega^2 (K - Omega^2 M + i Omega C)^-1 e_disc in complex coordinates
    dynamic = CHAIN * (1.0 + 2e-3j * 450.0) - 450.0**2 * np.diag([12.0, 8.0])
    whirl = np.linalg.solve(dynamic, [1e-3 * 450.0**2, 0.0])[1]
    tracked = orders(late, orders=[1.0], revolutions=4).isel(window=-1, order=0)
    assert float(tracked.forward_whirl_amplitude) == pytest.approx(abs(whirl), rel=1e-6)
    lag = np.angle(np.exp(1j * float(tracked.forward_phase_lag)) * whirl)
    assert lag == pytest.approx(0.0, abs=1e-5)


def test_the_clearance_is_that_of_one_central_circle_on_the_ground():
    usual = {"node": "seal", "clearance": 1e-2, "stiffness": 1e6}
    housing = Stator(mass=5.0, stiffness=1e7)
    for contacts, known in (
        ([Contact(**usual)], True),
        ([Contact(**usual), Contact(**usual | {"clearance": 2e-2})], False),
        ([Contact(**usual, centre=(1e-3, 0.0))], False),
        ([Contact(**usual, stator=housing)], False),
    ):
        run = simulate(SYSTEM, contacts=contacts, speed=450.0, duration=0.1)
        assert np.isfinite(signals_of(run, node="seal").clearance) == known
        assert np.isnan(signals_of(run, node="disc").clearance)


def test_signals_of_nodes_are_joined(clear):
    names = ["seal", "disc"]
    both = concat([signals_of(clear, node=name) for name in names], "node")
    np.testing.assert_array_equal(both.x.sel(node="disc"), clear.x.sel(node="disc"))
    assert both.clearance.dims == ("node",)
    np.testing.assert_array_equal(both.clearance, [1e-3, np.nan])


def test_displacements_at_a_contact_are_those_from_the_centre_of_its_stator():
    housing = Stator(mass=5.0, stiffness=4e6, damping=200.0)
    contacts = [
        Contact(node="seal", clearance=3e-5, stiffness=5e7, stator=housing),
        Contact(node="seal", clearance=5e-5, stiffness=5e7, centre=(2e-5, -1e-5)),
        Contact(node="disc", clearance=3e-5, stiffness=5e7, stator="seal"),
    ]
    run = simulate(SYSTEM, **TURNS | {"contacts": contacts, "speed": 520.0})
    assert run.contact_stator.values.tolist() == ["stator 0", "", "seal"]
    seal, disc = (run.x.sel(node=name) for name in ("seal", "disc"))
    np.testing.assert_allclose(run.contact_x.isel(contact=1), seal - 2e-5, rtol=0, atol=1e-18)
    np.testing.assert_allclose(run.contact_x.isel(contact=2), disc - seal, rtol=0, atol=1e-18)
    # the law of the force, by the indentation inside a stator that moves
    radius = np.hypot(run.contact_x, run.contact_y)
    force = 5e7 * np.maximum(radius - run.clearance, 0.0) ** 1.5
    assert float(force.isel(contact=0).max()) > 0.5
    np.testing.assert_allclose(run.normal_force, force, rtol=1e-6, atol=1e-6)
    edges = np.abs(run.event_kind.values) == 1
    assert edges.any()
    place = np.hypot(run.event_contact_x, run.event_contact_y).values[edges]
    expected = run.clearance.values[run.event_contact.values[edges]]
    np.testing.assert_allclose(place, expected, rtol=1e-9)


def test_a_part_with_one_node_needs_no_name(clear):
    part = clear.sel(node="disc", t=slice(0.1, 0.3))
    assert signals_of(part).identical(signals_of(clear.sel(t=slice(0.1, 0.3)), node="disc"))


OF_ONE_DISC = "must be of one disc, got a run of a rotor system: signals_of(run, node=...) gives "
REFUSED = [
    (signals_of, "node must be 'disc' or 'seal', got None"),
    (lambda run: signals_of(run, node="sael"), "or 'seal', got 'sael'; did you mean 'seal'?"),
    (lambda run: signals_of(run, node=1), "node must be 'disc' or 'seal', got 1"),
    (lambda run: signals_of(run.sel(node="disc"), node="seal"), "node must be 'disc', got 'seal'"),
    (lambda _: signals_of(simulate(ROTOR, start=REST, duration=10.0), node="a"),
     "node must be left out but for a run of a rotor system"),
    # an angle that falls has no revolutions
    (lambda run: signals_of(run.assign_attrs(speed=-450.0), node="seal"),
     "speed of the run must be zero or positive, got -450.0"),
    (lambda run: signals_of(run.isel(t=slice(None, None, 50)), node="seal"),
     "run must have more than 4 samples in each revolution"),
    *((function, f"{OF_ONE_DISC}signals of 'disc' or 'seal'")
      for function in (full_spectrum, orders, contact_forces)),
]  # fmt: skip


@pytest.mark.parametrize(("ask", "words"), REFUSED)
def test_what_gives_no_signals_is_refused(clear, ask, words):
    with pytest.raises(InputError, match=re.escape(words)):
        ask(clear)
