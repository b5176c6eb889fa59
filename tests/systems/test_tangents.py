"""Small changes of a run of a system against runs from starts on both sides; exponents."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, RotorSystem, lyapunov_exponent, simulate
from rotor_ida.core.interface import DONE
from rotor_ida.core.systems import follow_system
from rotor_ida.simulation.spin import steady
from rotor_ida.systems.assembly import assemble, canonical
from rotor_ida.systems.following import request_of
from tests.systems.random_systems import random_system

SPEED, DURATION = 1.1, 12.0
# Between them, seeds whose contacts enter, leave, roll, slip and reverse, damped and undamped, with
# races and stators: the kinds of event are counted in the test.
SEEDS = (2, 5, 10, 17, 19)


def request_of_system(seed):
    """Return a run of a random system in the coordinates of the core."""
    system, around = random_system(seed)
    whole = assemble(system, around["contacts"], around["unbalance"], None, around["static_force"])
    found = canonical(whole)
    start = np.zeros((2, whole.size))
    start[:, : system.size] = around["start"]
    return request_of(
        whole, found, steady(SPEED, DURATION), start @ found.factor, np.array([DURATION]),
        DURATION, rtol=1e-12, speed=SPEED, fastest_speed=SPEED, inertia=0.0,
    )  # fmt: skip


def end_of(request):
    """Return the state at the end of a run with its races, and the kinds of its events."""
    run = follow_system(request)
    assert run.status == DONE
    return np.concatenate([run.state.ravel(), run.touches["race"]]), run.event_kinds


@pytest.mark.parametrize("seed", SEEDS)
def test_small_changes_are_differences_of_runs(seed):
    """Central differences, in five directions; at an entry the third derivative is infinite."""
    request = request_of_system(seed)
    size, rng = request.start.size, np.random.default_rng(0)
    changes = rng.normal(size=(5, size + len(request.laws)))
    changes[:, size:] *= request.laws["inverse_race_inertia"] > 0.0
    run = follow_system(replace(request, columns=changes))
    alone, kinds = end_of(request)
    end = np.concatenate([run.state.ravel(), run.touches["race"]])
    np.testing.assert_allclose(end, alone, rtol=0.0, atol=1e-9)
    for change, moved in zip(changes, run.columns, strict=True):
        ends = []
        for step in (1e-6, -1e-6):
            start = request.start + step * change[:size].reshape(2, -1)
            races = request.races + step * change[size:]
            end, same = end_of(replace(request, start=start, races=races))
            np.testing.assert_array_equal(same, kinds)
            ends.append(end)
        apart = (ends[0] - ends[1]) / 2e-6
        np.testing.assert_allclose(moved, apart, rtol=0.0, atol=2e-7 * np.abs(moved).max())


def test_the_seeds_have_all_kinds_of_events():
    kinds = np.concatenate([end_of(request_of_system(seed))[1] for seed in SEEDS])
    assert set(np.unique(kinds)) >= {1, -1, 2, -2, -4}


ROTOR = Rotor(omega=2.6, zeta=0.05, delta0=1.0, friction=0.2, disc_radius=1.0)


def test_exponents_of_one_disc_as_a_system():
    """Of a settled motion that bounces and slides: the same rates, to the error of the means."""
    start = (2.0, 0.0, 0.0, 1.0)
    run = simulate(ROTOR, start=start, duration=1000.0, samples=2)
    settled = [float(run[name][-1]) for name in ("x", "y", "vx", "vy")]
    one = lyapunov_exponent(ROTOR, start=settled, transient=200.0, duration=1500.0)
    system, contacts, unbalance = ROTOR.system()
    angle = ROTOR.omega * 1000.0
    back = np.exp(-1j * angle) * np.array([complex(*settled[:2]), complex(*settled[2:])])
    found = lyapunov_exponent(
        system, contacts=contacts, unbalance=unbalance, speed=ROTOR.omega,
        start=([back[0].real, back[0].imag], [back[1].real, back[1].imag]),
        transient=80, revolutions=620,
    )  # fmt: skip
    within = np.hypot(one.lyapunov_error, found.lyapunov_error) * 5.0 + 1e-6
    assert (np.abs(one.lyapunov_exponent - found.lyapunov_exponent) <= within).all()


def test_exponents_without_contact_are_the_decay_rates():
    rng = np.random.default_rng(1)
    bent, resisted, turned = (rng.normal(size=(4, 4)) for _ in range(3))
    system = RotorSystem(
        mass=np.eye(4), stiffness=bent @ bent.T + np.eye(4), damping=0.1 * resisted @ resisted.T,
        gyroscopic=turned - turned.T, nodes={"disc": (0, 1)}, units="1",
    )  # fmt: skip
    first_order = np.block(
        [[np.zeros((4, 4)), np.eye(4)],
         [-system.stiffness, -system.damping - 1.3 * system.gyroscopic]]
    )  # fmt: skip
    found = lyapunov_exponent(system, speed=1.3, transient=100, revolutions=400)
    rates = np.sort(np.linalg.eigvals(first_order).real)[::-1]
    np.testing.assert_allclose(found.lyapunov_exponent, rates, atol=1e-5)
    np.testing.assert_allclose(found.lyapunov_exponent.sum(), -np.trace(system.damping), rtol=1e-10)


@pytest.mark.parametrize(
    ("more", "message"),
    [({"exponents": 9}, "at most 4"), ({"revolutions": 50}, "at least 20"), ({"speed": 0.0}, "0")],
)
def test_bad_arguments_give_one_line(more, message):
    system, contacts, unbalance = ROTOR.system()
    given = {"contacts": contacts, "unbalance": unbalance, "speed": 1.0} | more
    with pytest.raises(InputError, match=message):
        lyapunov_exponent(system, **given)
