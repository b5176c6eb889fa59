"""Small changes of a run of a system against runs from starts on both sides; exponents."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Race,
    Rotor,
    RotorSystem,
    Unbalance,
    lyapunov_exponent,
    simulate,
)
from rotor_ida.core.interface import DONE
from rotor_ida.core.systems import follow_system
from rotor_ida.model.assembly import assemble, canonical
from rotor_ida.schema import MODE
from rotor_ida.simulation.spin import steady
from rotor_ida.simulation.system_run import request_of

SPEED, DURATION = 1.1, 12.0


def end_of(request):
    """Return the state at the end of a run with its races, and the kinds of its events."""
    run = follow_system(request)
    assert run.status == DONE
    return np.concatenate([run.state.ravel(), run.touches["race"]]), run.event_kinds


def rolling_request():
    """Return a run that rolls in its race from start to end: a whirl at the spin speed."""
    system = RotorSystem(mass=20.0 * np.eye(2), stiffness=2e6 * np.eye(2),
                         damping=4e3 * np.eye(2), nodes={"disc": (0, 1)})  # fmt: skip
    race = Race(radius=0.03, inertia=2e-3, drag=1e-3, speed=250.0)
    touch = Contact(node="disc", clearance=3e-4, stiffness=5e7, exponent=1.0, friction=0.1,
                    radius=0.03, race=race)  # fmt: skip
    whole = assemble(
        replace(system, contacts=[touch], unbalance=[Unbalance(node="disc", moment=8e-3)])
    )
    request = request_of(
        whole, canonical(whole), steady(250.0, 2.0), np.zeros((2, 2)), np.array([2.0]), 2.0,
        rtol=1e-12, speed=250.0, fastest_speed=250.0, inertia=0.0,
    )  # fmt: skip
    settled = follow_system(request)
    turned = settled.turn[0]
    back = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
    span = 2.0 * np.pi / 250.0
    return replace(
        request, start=settled.state @ back.T, races=settled.touches["race"], duration=span,
        times=np.array([span]), pieces=steady(250.0, span).pieces(),
    )  # fmt: skip


def test_a_change_of_a_start_that_rolls_has_no_slip_left():
    """A neighbouring start slides for a moment; the witness is a difference of two runs."""
    request = rolling_request()
    run = follow_system(replace(request, columns=np.eye(5)))
    assert run.event_kinds.size == 0
    assert run.touches["mode"].tolist() == [MODE["rolling"]]
    scales = np.array([1e-3, 1e-3, 0.25, 0.25, 250.0])
    for change, moved in zip(np.diag(scales), run.columns, strict=True):
        ends = []
        for step in (1e-6, -1e-6):
            start = request.start + step * change[:4].reshape(2, 2)
            ends.append(end_of(replace(request, start=start,
                                       races=request.races + step * change[4:]))[0])  # fmt: skip
        apart = (ends[0] - ends[1]) / 2e-6 / scales
        np.testing.assert_allclose(
            moved * change.max() / scales, apart, rtol=0.0, atol=1e-3 * np.abs(apart).max()
        )
    factors = np.linalg.svd(run.columns / scales * scales[:, np.newaxis])[1]
    assert factors[-1] < 1e-9 * factors[0]


def test_dry_whip_that_rolls_all_along_has_no_exponent_of_slip():
    system = RotorSystem(mass=20.0 * np.eye(2), stiffness=2e6 * np.eye(2),
                         damping=800.0 * np.eye(2), nodes={"disc": (0, 1)})  # fmt: skip
    touch = Contact(node="disc", clearance=3e-4, stiffness=5e7, exponent=1.0, friction=0.3,
                    radius=0.006)  # fmt: skip
    found = lyapunov_exponent(
        system, contacts=[touch], speed=30.0, start=([3.2e-4, 0.0], [0.0, -0.15]),
        transient=20, revolutions=80, batches=4,
    )  # fmt: skip
    assert found.lyapunov_exponent[-1] == -np.inf
    np.testing.assert_allclose(found.lyapunov_exponent[0], 0.0, atol=1e-6)
    assert (found.lyapunov_exponent[1:3] < -10.0).all()


ROTOR = Rotor(omega=2.6, zeta=0.05, delta0=1.0, friction=0.2, disc_radius=1.0)


def test_exponents_of_one_disc_as_a_system():
    """Of a settled motion that bounces and slides: the same rates, to the error of the means."""
    start = (2.0, 0.0, 0.0, 1.0)
    run = simulate(ROTOR, start=start, duration=1000.0, samples=2)
    settled = [float(run[name][-1]) for name in ("x", "y", "vx", "vy")]
    one = lyapunov_exponent(ROTOR, start=settled, transient=200.0, duration=1500.0)
    system = ROTOR.system()
    angle = ROTOR.omega * 1000.0
    back = np.exp(-1j * angle) * np.array([complex(*settled[:2]), complex(*settled[2:])])
    found = lyapunov_exponent(
        system, speed=ROTOR.omega,
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
    system = ROTOR.system()
    given = {"speed": 1.0} | more
    with pytest.raises(InputError, match=message):
        lyapunov_exponent(system, **given)
