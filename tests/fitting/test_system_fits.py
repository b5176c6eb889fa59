"""Fits of rotor systems: simulated measurements at several nodes, whose truth is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, chi2

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    fit,
    run_up,
    signals_of,
    simulate,
)
from tests.fitting.test_fit import noisy

NOISE = 2e-6


def machine(gap=1.2e-4, damping=120.0, moment=2e-4, friction=0.0, **more):
    """Return a disc that touches its stator, and an overhung end, on a shaft."""
    shaft = np.array([[9e5, -6e5], [-6e5, 8e5]])
    return RotorSystem(
        mass=np.diag([8.0, 8.0, 3.0, 3.0]), stiffness=np.kron(shaft, np.eye(2)),
        damping=np.diag([damping, damping, 0.5 * damping, 0.5 * damping]),
        nodes={"disc": (0, 1), "end": (2, 3)},
        contacts=[Contact(node="disc", clearance=gap, stiffness=5e6, exponent=1.0,
                          friction=friction, radius=0.05)],
        unbalance=[Unbalance(node="disc", moment=moment)], **more,
    )  # fmt: skip


GUESS = machine(gap=1.5e-4, damping=150.0, moment=2.4e-4)
TRUTH = {"clearance": 1.2e-4, "damping": 0.8, "stiffness": 1.0, "unbalance": 2e-4}


@pytest.fixture(scope="module")
def up():
    return run_up(machine(), speed=60.0, to=340.0, rate=180.0, start="settled", samples=3001)


def seen(run, seed, nodes=("disc", "end"), noise=NOISE):
    rng = np.random.default_rng(seed)
    return {node: noisy(signals_of(run, node=node), rng, noise) for node in nodes}


def off(found, truth):
    return (found.estimate.values - list(truth.values())) / found.standard_error.values


def test_a_machine_in_an_oil_film():
    """Its table is a part of the model; a factor of the damping is one of the film's too."""
    speeds = np.array([40.0, 150.0, 260.0, 360.0])
    part = (speeds / speeds[-1])[:, np.newaxis, np.newaxis]
    film = Bearing(
        node="end", speed=speeds, damping=(1000.0 - 600.0 * part) * np.eye(2),
        stiffness=(1.0 - 0.4 * part) * np.array([[3e5, 1e5], [-1e5, 4e5]]),
    )  # fmt: skip
    run = run_up(machine(bearings=[film]), speed=60.0, to=340.0, rate=180.0, start="settled",
                 samples=3001)  # fmt: skip
    assert run.event_time.size
    guess = machine(gap=1.5e-4, moment=2.4e-4, bearings=[film])
    found = fit(seen(run, 1), guess, ["clearance", "damping", "unbalance"], start="settled")
    truth = {"clearance": 1.2e-4, "damping": 1.0, "unbalance": 2e-4}
    assert (np.abs(off(found, truth)) < 3.0).all()
    assert abs(float(found.chi_square) / int(found.degrees_of_freedom) - 1.0) < 0.1


def test_errors_are_those_of_the_scatter(up):
    """Of fits by probes at two nodes: each mean square, and chi-square, follow their laws."""
    parts, squares, freedom, trials = [], 0.0, 0, 6
    for seed in range(trials):
        found = fit(seen(up, seed), GUESS, list(TRUTH), start="settled" if seed else None)
        assert found.attrs["search"] == "converged"
        parts.append(off(found, TRUTH))
        squares += float(found.chi_square)
        freedom += int(found.degrees_of_freedom)
        assert abs(float(found.noise) / NOISE - 1.0) < 0.1
    inside = (np.abs(parts) < 1.96).sum()
    assert inside >= binom.ppf(1e-5, len(TRUTH) * trials, 0.95)
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], trials)
    assert low < (np.array(parts) ** 2).sum(axis=0).min()
    assert (np.array(parts) ** 2).sum(axis=0).max() < high
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], freedom)
    assert low < squares < high


def test_one_disc_as_a_system_has_the_same_estimates_and_errors():
    """The factors of a system times its first guesses are the parameters of the disc."""
    rotor = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
    guess = Rotor(omega=0.3, zeta=0.08, delta0=1.8, shaft_stiffness=0.9)
    run = run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2501)
    signals = noisy(signals_of(run), np.random.default_rng(1), 0.02)
    disc = fit(signals, guess, ["zeta", "delta0", "shaft_stiffness"])
    system = fit(signals, guess.system(), ["damping", "clearance", "stiffness"])
    factors = np.array([guess.zeta, 1.0, guess.shaft_stiffness])
    errors = disc.standard_error.values
    assert (np.abs(factors * system.estimate.values - disc.estimate.values) < 1e-3 * errors).all()
    np.testing.assert_allclose(factors * system.standard_error.values, errors, rtol=1e-4)
    assert float(system.chi_square) == pytest.approx(float(disc.chi_square), rel=1e-6)


def test_probes_at_a_second_node_and_contact_times_tell_more(up):
    entries = up.event_time.values[up.event_kind.values == 1]
    both = seen(up, 3)
    one = fit(both["disc"], GUESS, list(TRUTH), start="settled")
    two = fit(both, GUESS, list(TRUTH), start="settled")
    assert (two.standard_error < one.standard_error).all()
    assert set(one.node.values) == {"disc"}
    assert (
        two.node.values.tolist() == ["disc"] * one.sizes["window"] + ["end"] * one.sizes["window"]
    )
    timed = fit(both, GUESS, list(TRUTH), start="settled", entries=entries, time_error=1e-6)
    assert timed.compared.values.all()
    assert timed.standard_error[0] < two.standard_error[0]


def test_a_wrong_model_leaves_more_than_noise_where_it_is_wrong(up):
    """A seal at the overhung end that the model lacks moves that node most."""
    shaft = np.array([[9e5, -6e5], [-6e5, 8.4e5]])
    wrong = machine()
    true = RotorSystem(
        mass=wrong.mass, stiffness=np.kron(shaft, np.eye(2)), damping=wrong.damping,
        nodes=wrong.nodes, contacts=wrong.contacts, unbalance=wrong.unbalance,
    )  # fmt: skip
    run = run_up(true, speed=60.0, to=340.0, rate=180.0, start="settled", samples=3001)
    found = fit(seen(run, 1), wrong, ["clearance", "damping"], start="settled", noise=NOISE)
    assert found.attrs["remainder"].startswith("the residuals exceed the noise")
    assert "most at node '" in found.attrs["remainder"]


def test_an_angle_of_the_unbalance_and_a_stiffer_contact_are_found(up):
    """From guesses that are off, at probes that do not see the contact's node."""
    signals = seen(up, 2, ("end",))["end"]
    signals["angle"] = signals.angle - 0.7
    truth = {"clearance": 1.2e-4, "contact_stiffness": 5e6, "unbalance_angle": 0.7}
    found = fit(signals, machine(gap=1.4e-4), list(truth), start="settled")
    assert (np.abs(off(found, truth)) < 4.0).all()
    assert found.unit.values.tolist() == ["m", "N m-1", "radian"]


def test_signals_in_micrometres_and_a_system_that_hangs_under_gravity():
    """Where a machine stands still, its probes tell the place; so the mean counts too."""
    true = machine(gravity=(0.0, -2.0))
    run = run_up(true, speed=60.0, to=340.0, rate=180.0, start="settled", samples=3001)
    signals = {}
    for node, each in seen(run, 4, noise=0.0).items():
        scaled = each.assign({name: each[name] * 1e6 for name in "xy"})
        for name in "xy":
            scaled[name].attrs = {**each[name].attrs, "units": "um"}
        signals[node] = noisy(scaled, np.random.default_rng(len(node)), 2.0)
    truth = {"clearance": 1.2e-4, "unbalance": 2e-4}
    guess = machine(gap=1.3e-4, moment=2.2e-4, gravity=(0.0, -2.0))
    found = fit(signals, guess, list(truth), orders=(0, 1), start="settled")
    assert (np.abs(off(found, truth)) < 4.0).all()
    assert float(found.noise) == pytest.approx(2.0, rel=0.1)
    assert found.forward_whirl_amplitude.attrs["units"] == "um"


def test_a_disc_that_rolls_on_its_stator_is_fitted():
    """A dry whip that rolls and slips by turns: of 6 fits each mean square follows its law."""
    truth, rng, parts = {"zeta": 0.1, "delta0": 1.0, "friction": 0.2}, np.random.default_rng(3), []
    rotor = Rotor(omega=0.6295, disc_radius=10.0, **truth)
    run = simulate(rotor, start=(4.98, 0, 0, -6.2), duration=100.0, samples=3001)
    assert (run.event_kind.values == 2).sum() > 20
    for _ in range(6):
        found = fit(noisy(signals_of(run), rng, 0.05), rotor, list(truth))
        parts.append(off(found, truth))
    low, high = chi2.ppf([1e-5, 1.0 - 1e-5], len(parts))
    squares = (np.array(parts) ** 2).sum(axis=0)
    assert low < squares.min()
    assert squares.max() < high


def without(signals, name):
    return signals.drop_vars(name)


REFUSED = {
    "unknown node": (lambda s: {"signals": {"dsc": s}}, r"node must be one of .* mean 'disc'"),
    "no node": (lambda s: {"signals": without(s, "node")},
                r"signals must be given by the node at which probes look, .* of 'disc', 'end'"),
    "no nodes": (lambda s: {"signals": {}}, r"signals must be given by the node"),
    "other times": (lambda s: {"signals": {"disc": s, "end": s.isel(t=slice(0, 2000))}},
                    r"the same times, angles and units, got others at 'end'"),
    "of one disc": (lambda _: {"unknown": ["zeta"]}, r"must be of 'damping', .* got 'zeta'"),
    "no contacts": (lambda _: {"machine": RotorSystem(mass=np.eye(2), stiffness=np.eye(2),
                                                      nodes={"disc": (0, 1)})},
                    r"clearance must be left out, as the system has no contacts"),
    "no radius": (lambda _: {"unknown": ["friction"], "machine": RotorSystem(
                     mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
                     contacts=[Contact(node="disc", clearance=1e-4, stiffness=1e6)])},
                  r"radius of the contact at 'disc' must be given with friction"),
    "short": (lambda s: {"signals": s.isel(t=slice(0, 60))}, r"at least 1 whole revolutions"),
    "few": (lambda s: {"signals": s.isel(t=slice(0, 200)), "unknown": list(TRUTH)},
            r"at least as many numbers to compare as unknowns"),
    "start": (lambda _: {"start": (np.zeros(3), np.zeros(3))}, r"must have the shape \(4,\)"),
    "word": (lambda _: {"start": "still"}, r"start must be one of 'settled', 'rest'"),
    "disc": (lambda s: {"signals": {"disc": s}, "unknown": ["zeta"],
                        "machine": Rotor(omega=1, zeta=0.1, delta0=0.5)},
             r"signals must be a dataset, or a list of them, with one disc"),
    "unit": (lambda _: {"machine": Rotor(omega=1, zeta=0.1, delta0=0.5).system()},
             r"machine must be a DimensionalRotor, or .* for signals"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_fitted_is_told_in_one_line(name, up):
    given, said = REFUSED[name]
    signals = signals_of(up, node="disc")
    with pytest.raises(InputError, match=said) as caught:
        fit(**{"signals": signals, "machine": machine(), "unknown": ["clearance"],
               **given(signals)})  # fmt: skip
    assert "\n" not in str(caught.value)
