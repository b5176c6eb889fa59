"""Backward whirl by friction: the saddle and dry whip, held by integrating the stated motion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from rotor_ida import Rotor, backward_whirl, simulate
from rotor_ida.errors import InputError
from rotor_ida.schema import STABILITY, WHIRL_KIND
from tests.witness import FORWARDS, Disc

KNOWN = {"omega": 0.629579808, "zeta": 0.1, "delta0": 1.0, "friction": 0.2, "disc_radius": 10.0}
MACHINES = [
    KNOWN,
    {"omega": 1.0, "zeta": 0.05, "delta0": 0.7, "friction": 0.1, "disc_radius": 20.0,
     "shaft_stiffness": 0.3},
    {"omega": 1.0, "zeta": 0.03, "delta0": 2.0, "friction": 0.2, "disc_radius": 30.0,
     "shaft_stiffness": 0.2, "contact_exponent": 1.0},
    {"omega": 2.0, "zeta": 0.1, "delta0": 1.0, "friction": 0.3, "disc_radius": 15.0,
     "contact_damping": 0.8},
]  # fmt: skip


def row(found, kind):
    place = int(np.nonzero(found.kind.values == WHIRL_KIND[kind])[0][0])
    return {
        name: found[name].values[place].item() for name in found.data_vars if name != "birth_omega"
    }


def slipping(state, rotor):
    """The equation of motion on the fixed axes without unbalance, slipping forwards."""
    return Disc(rotor, unbalance=0.0).rates(np.array([*state, 0.0, rotor.omega]), FORWARDS)[:4]


def test_known_whirls():
    found = backward_whirl(Rotor(**KNOWN))
    saddle, whip = row(found, "slipping"), row(found, "rolling")
    assert saddle["whirl_speed"] == pytest.approx(-1.0, abs=1e-15)
    assert saddle["amplitude"] == pytest.approx(3.147899036, abs=1e-9)
    assert saddle["stability"] == STABILITY["unstable"]
    assert found.birth_omega.item() == pytest.approx(0.314789904, abs=1e-9)
    assert whip["amplitude"] == pytest.approx(4.984177749, abs=1e-8)
    assert whip["stability"] == STABILITY["stable"]


@pytest.mark.parametrize("machine", MACHINES)
def test_the_slipping_whirl_obeys_the_stated_motion(machine):
    """On a circle at its speed the acceleration is the centripetal one, and it slips forwards."""
    rotor = Rotor(**machine)
    saddle = row(backward_whirl(rotor), "slipping")
    r, speed = saddle["amplitude"], saddle["whirl_speed"]
    change = slipping([r, 0.0, 0.0, speed * r], rotor)
    np.testing.assert_allclose(change, [0.0, speed * r, -(speed**2) * r, 0.0], atol=1e-13 * r)
    assert speed * r + rotor.disc_radius * rotor.omega > 0.0
    assert saddle["tangential_force"] == rotor.friction * saddle["normal_force"]


@pytest.mark.parametrize("machine", MACHINES)
def test_the_slipping_whirl_is_a_saddle(machine):
    """On axes that turn with it the Jacobian, by complex steps, has one positive eigenvalue."""
    rotor = Rotor(**machine)
    saddle = row(backward_whirl(rotor), "slipping")
    r, speed = saddle["amplitude"], saddle["whirl_speed"]

    def turning(state):
        x, y, vx, vy = state
        _, _, ax, ay = slipping(state, rotor)
        return np.array([vx + speed * y, vy - speed * x, ax + speed * vy, ay - speed * vx])

    state = np.array([r, 0.0, 0.0, speed * r])
    steps = [turning(state + 1e-30j * unit).imag / 1e-30 for unit in np.eye(4)]
    found = np.linalg.eigvals(np.stack(steps, axis=1))
    assert np.abs(found).min() < 1e-12  # its phase
    leading = np.sort(found.real)[::-1]
    assert leading[0] == pytest.approx(saddle["growth_rate"], rel=1e-10)
    assert (found.real > 1e-10).sum() == 1


@pytest.mark.parametrize("machine", MACHINES)
def test_a_rolling_disc_settles_on_dry_whip(machine):
    """The radial equation of a disc that rolls, from 20 percent beside."""
    rotor = Rotor(**machine)
    whip = row(backward_whirl(rotor), "rolling")
    surface = rotor.disc_radius * rotor.omega

    def radial(_, state):
        r, rate = state
        force = max(r - rotor.delta0, 0.0) ** rotor.contact_exponent
        force = max(0.0, force * (1.0 + rotor.contact_damping * rate))
        return [rate, surface**2 / r - force - 2.0 * rotor.zeta * rate - rotor.shaft_stiffness * r]

    last = 30.0 / -whip["growth_rate"]
    start = [1.2 * whip["amplitude"], 0.0]
    found = solve_ivp(radial, (0.0, last), start, method="DOP853", rtol=1e-11, atol=1e-12)
    assert found.y[0, -1] == pytest.approx(whip["amplitude"], rel=1e-9)
    assert whip["whirl_speed"] == pytest.approx(-surface / whip["amplitude"], rel=1e-15)
    assert whip["tangential_force"] <= rotor.friction * whip["normal_force"]


@pytest.mark.parametrize("machine", MACHINES)
def test_both_are_born_as_one_where_friction_can_just_hold(machine):
    birth = backward_whirl(Rotor(**machine)).birth_omega.item()
    born = backward_whirl(Rotor(**(machine | {"omega": birth * (1.0 + 1e-12)})))
    saddle, whip = row(born, "slipping"), row(born, "rolling")
    for name in ("amplitude", "whirl_speed", "normal_force", "tangential_force"):
        assert saddle[name] == pytest.approx(whip[name], rel=1e-10)
    before = backward_whirl(Rotor(**(machine | {"omega": birth * (1.0 - 1e-12)})))
    assert np.isnan(before.amplitude).all()
    assert (before.stability == STABILITY["absent"]).all()
    assert before.birth_omega.item() == birth


def test_radii_over_many_orders_of_magnitude():
    """Against Brent's method on the stated equations."""
    draw = np.random.default_rng(4)
    for _ in range(200):
        zeta, mu, d = (10 ** draw.uniform(*ends) for ends in ((-4, 0), (-2, 0), (-2, 2)))
        kappa = float(draw.choice([0.0, 10 ** draw.uniform(-3, 1)]))
        n, rho = float(draw.choice([1.0, 1.5])), 10 ** draw.uniform(0, 3)
        whirl = (zeta + math.sqrt(zeta**2 + mu**2 * kappa)) / mu
        given = {"zeta": zeta, "delta0": d, "friction": mu, "disc_radius": rho,
                 "shaft_stiffness": kappa, "contact_exponent": n}  # fmt: skip
        if n == 1.0 and 2.0 * zeta * whirl / mu >= 1.0:
            none = backward_whirl(Rotor(omega=1e3, **given))
            assert np.isnan(none.birth_omega)
            assert np.isnan(none.amplitude).all()
            continue

        def slips(r, d=d, n=n, s=2.0 * zeta * whirl / mu):
            return (r - d) ** n / r - s

        radius = brentq(slips, d, 1e12, xtol=1e-300, rtol=1e-14, maxiter=1000)
        birth = backward_whirl(Rotor(omega=0.0, **given)).birth_omega.item()
        assert birth == pytest.approx(radius * whirl / rho, rel=1e-11)
        surface = 3.0 * birth * rho

        def rolls(r, d=d, n=n, kappa=kappa, surface=surface):
            return r * (r - d) ** n + kappa * r * r - surface**2

        found = backward_whirl(Rotor(omega=3.0 * birth, **given))
        settled = brentq(rolls, d, d + surface**2 + 1.0, xtol=1e-300, rtol=1e-14, maxiter=1000)
        assert row(found, "slipping")["amplitude"] == pytest.approx(radius, rel=1e-11)
        assert row(found, "rolling")["amplitude"] == pytest.approx(settled, rel=1e-11)


def test_linear_ring_has_whip_where_friction_drives_its_backward_mode():
    """Far out a linear ring is a spring: an eigenvalue says when friction drives the whirl.

    z'' + 2 zeta z' + (kappa + 1 + i mu) z = 0 grows for mu > 2 zeta sqrt(kappa + 1), backwards
    with the natural frequency of shaft and ring together.
    """
    rng = np.random.default_rng(5)
    for _ in range(50):
        zeta, kappa = 10.0 ** rng.uniform(-2.5, 0.0), 10.0 ** rng.uniform(-3.0, 1.0)
        delta0, rho = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(-1.0, 2.0)
        bound = 2.0 * zeta * math.sqrt(kappa + 1.0)
        for factor, born in ((1.0 - 1e-9, False), (1.0 + 1e-9, True)):
            mu = factor * bound
            given = {"zeta": zeta, "delta0": delta0, "shaft_stiffness": kappa, "friction": mu,
                     "contact_exponent": 1.0, "disc_radius": rho}  # fmt: skip
            eigenvalues = np.roots([1.0, 2.0 * zeta, kappa + 1.0 + 1j * mu])
            fastest = eigenvalues[eigenvalues.real.argmax()]
            assert (fastest.real > 0.0) == born
            assert fastest.imag == pytest.approx(-math.sqrt(kappa + 1.0), rel=1e-8)
            assert np.isfinite(backward_whirl(Rotor(omega=1.0, **given)).birth_omega) == born


@pytest.mark.parametrize("friction", [0.09, 0.12])
def test_wide_backward_whirl_grows_at_the_rate_of_the_linear_ring(friction):
    """Just below and just above the bound; the clearance matters less and less far out."""
    zeta, kappa, span = 0.05, 0.05, 20.0
    eigenvalues = np.roots([1.0, 2.0 * zeta, kappa + 1.0 + 1j * friction])
    backwards = eigenvalues[eigenvalues.imag.argmin()]
    rotor = Rotor(
        omega=0.5, zeta=zeta, delta0=1.0, shaft_stiffness=kappa, contact_exponent=1.0,
        friction=friction, disc_radius=1e6,
    )  # fmt: skip
    off = []
    for radius in (1e3, 1e4):
        velocity = backwards * radius
        start = (radius, 0.0, velocity.real, velocity.imag)
        run = simulate(rotor, start=start, duration=span, samples=2, method="taylor")
        grown = np.hypot(run.x.values[-1], run.y.values[-1]) / radius
        off.append(abs(math.log(grown) / span - backwards.real))
    assert off[0] < 2e-5
    assert 0.09 < off[1] / off[0] < 0.11


def test_without_damping_any_touch_is_driven():
    found = backward_whirl(Rotor(**(KNOWN | {"zeta": 0.0})))
    assert found.birth_omega.item() == 0.0
    assert np.isnan(row(found, "slipping")["amplitude"])
    assert row(found, "rolling")["stability"] == STABILITY["neutral"]
    held = backward_whirl(Rotor(**(KNOWN | {"zeta": 0.0, "shaft_stiffness": 4.0})))
    assert held.birth_omega.item() == pytest.approx(2.0 / 10.0)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"friction": 0.0}, "friction must be above 0 for a backward whirl, got 0.0"),
        ({"load": 1.0}, "load must be 0 for a backward whirl"),
        ({"friction": 1e-30}, "friction must be at least 1e-20 for a backward whirl, got 1e-30"),
        ({"omega": 1e18}, "omega must be"),
    ],
)
def test_odd_rotors_are_refused(given, says):
    with pytest.raises(InputError, match=says):
        backward_whirl(Rotor(**(KNOWN | given)))


def test_only_a_rotor_has_whirls():
    with pytest.raises(InputError, match="backward_whirl takes a Rotor or DimensionalRotor first"):
        backward_whirl(1.0)
