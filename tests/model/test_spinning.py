"""The modes of a speed that changes are the equations on fixed axes, which the reference states."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.model.contact import contact_potential
from rotor_ida.model.derivation import derive
from rotor_ida.model.spinning import RUN_UP
from rotor_ida.schema.flags import FLIES, ROLLS, SLIDES_BACKWARDS, SLIDES_FORWARDS
from rotor_ida.simulation.spin import SPEED, Driven, Ramp
from rotor_ida.simulation.witness.bodies import Disc
from rotor_ida.simulation.witness.mechanics import Machine
from tests.model.symbolic import value_of

MODES = {mode.name: mode for mode in RUN_UP.modes}
ROTOR = Rotor(
    omega=1.3, zeta=0.07, delta0=0.8, shaft_stiffness=0.4, contact_damping=0.3, load=0.6,
    friction=0.25, disc_radius=1.7,
)  # fmt: skip
LINEAR = replace(ROTOR, contact_exponent=1.0)
SPINS = {"ramp": Ramp(0.0, 0.0, 1.3, -0.2), "torque": Driven(2.0, 0.3, 4.0)}
WAYS = {
    "contact": SLIDES_FORWARDS, "rub": SLIDES_BACKWARDS, "rolling": ROLLS, "cartesian": FLIES,
}  # fmt: skip


def as_core(rotor, spin, mode):
    """Return a rotor with what the modes ask for."""
    driven = isinstance(spin, Driven)
    return SimpleNamespace(
        **{name: getattr(rotor, name) for name in
           ("zeta", "delta0", "shaft_stiffness", "contact_damping", "load", "friction",
            "disc_radius")},
        hertz=float(rotor.contact_exponent == 1.5), linear=float(rotor.contact_exponent == 1.0),
        felt=0.0, loose=0.0, sigma=-1.0 if mode == "rub" else 0.0,
        rate=0.0 if driven else spin.rate, torque=spin.torque if driven else 0.0,
        slope=spin.slope if driven else 0.0, inverse_inertia=1.0 / spin.inertia if driven else 0.0,
    )  # fmt: skip


def of_core(name, z, v, speed, rotor):
    """Return the state of a mode at an angle of 0, where the load points along -i."""
    if name == "cartesian":
        return [z.real, z.imag, v.real, v.imag, 0.0, -1.0, speed, 0.0]
    out, r = z / abs(z), abs(z)
    w, down = v / out, -1j / out
    third = r * w.imag + (rotor.disc_radius * speed * r if name != "contact" else 0.0)
    state = [np.sqrt(r - rotor.delta0), w.real, third, out.real, out.imag, down.real, down.imag,
             speed, 0.0, 0.0, 0.0, 0.0, 0.0]  # fmt: skip
    return state if name == "contact" else [*state, 0.0]


def moved(name, state, rates, rotor):
    """Return acceleration and theta'' on fixed axes from the rates of a mode, by its time."""
    named = dict(zip(MODES[name].state, state, strict=True))
    rate = dict(zip(MODES[name].state, rates, strict=True))
    if name == "cartesian":
        w, turned = complex(named["vx"], named["vy"]), complex(rate["vx"], rate["vy"])
        return turned + 1j * named["speed"] * w, rate["speed"]
    q, p = named["q"], named["p"]
    r, out = rotor.delta0 + q * q, complex(named["c"], named["s"])
    rim, quick = rotor.disc_radius * named["speed"], rate["speed"] / q
    if name == "contact":
        h, h_rate = named["h"], rate["h"] / q
    else:
        h = named["slip"] - rim * r
        h_rate = rate["slip"] / q - rim * p - rotor.disc_radius * quick * r
    inward = rate["p"] / q - h * h / r**3
    return complex(inward, h_rate / r) * out, quick


def drawn(name, seed):
    """Return displacement and velocity of a contact, or a flight, that moves as its mode says."""
    draw = np.random.default_rng(seed)
    radius = 0.5 if name == "cartesian" else 0.8 + draw.uniform(0.1, 0.9)
    z = radius * np.exp(2j * np.pi * draw.random())
    v = complex(*draw.normal(size=2))
    if name == "rolling":
        out = z / abs(z)
        v = complex((v / out).real, -ROTOR.disc_radius * ROTOR.omega) * out
    return z, v


@pytest.mark.parametrize("rotor", [ROTOR, LINEAR], ids=["hertz", "linear"])
@pytest.mark.parametrize("spin", SPINS)
@pytest.mark.parametrize("name", MODES)
def test_accelerations_are_those_on_fixed_axes(name, spin, rotor):
    rotor = replace(rotor, friction=0.0, disc_radius=None) if name == "contact" else rotor
    machine = Machine(Disc(rotor, SPINS[spin]), SPINS[spin], [WAYS[name]])
    given = replace(rotor, disc_radius=rotor.disc_radius or 0.0)
    for seed in range(20):
        z, v = drawn(name, seed)
        state, rate = np.zeros(11), np.empty(11)
        state[:4], state[SPEED] = (z.real, z.imag, v.real, v.imag), rotor.omega
        machine.rates(0.0, state, rate)
        core = as_core(given, SPINS[spin], name)
        own = of_core(name, z, v, rotor.omega, given)
        found, quick = moved(name, own, MODES[name].rates(own, core), given)
        assert found == pytest.approx(complex(*rate[2:4]), rel=1e-12, abs=1e-12)
        expected = rate[SPEED] if spin == "torque" else SPINS[spin].rate
        assert quick == pytest.approx(expected, rel=1e-12, abs=1e-13)


@pytest.mark.parametrize("spin", SPINS)
@pytest.mark.parametrize("name", ["contact", "rub", "rolling"])
def test_what_is_spent_balances_the_energy_on_the_axes_that_turn(name, spin):
    """|z'|**2/2 + kappa |z|**2/2 + V + gamma y - theta' h - theta'**2 x, by its own rate."""
    rotor = replace(ROTOR, friction=0.0, disc_radius=0.0) if name == "contact" else ROTOR

    def energy(state):
        named = dict(zip(MODES[name].state, state, strict=True))
        r, speed = rotor.delta0 + named["q"] ** 2, named["speed"]
        h = named["h"] if name == "contact" else named["slip"] - rotor.disc_radius * speed * r
        whole = 0.5 * (named["p"] ** 2 + (h / r) ** 2) + 0.5 * rotor.shaft_stiffness * r * r
        whole += contact_potential(r, rotor.delta0) - rotor.load * r * named["down_r"]
        return whole - speed * h - speed**2 * r * named["c"]

    for seed in range(20):
        z, v = drawn(name, seed)
        core = as_core(rotor, SPINS[spin], name)
        own = np.array(of_core(name, z, v, rotor.omega, rotor))
        rates = np.array(MODES[name].drawn_rates(own.tolist(), core))
        rate = dict(zip(MODES[name].state, rates, strict=True))
        changed = (energy(own + 1e-6 * rates) - energy(own - 1e-6 * rates)) / 2e-6
        n = (own[0] ** 3) * own[0]
        spring = n * own[1]  # of what the ring holds alone
        spent = rate["spent"] + rate["work"] - spring + rate.get("heat", 0.0)
        assert changed == pytest.approx(-spent, rel=1e-7, abs=1e-7)


@pytest.mark.parametrize("name", MODES)
def test_the_jacobian_is_that_of_the_rates(name):
    derived, mode = derive(MODES[name], RUN_UP), MODES[name]
    z, v = drawn(name, 3)
    core = as_core(ROTOR, SPINS["torque"], name)
    state = np.array(of_core(name, z, v, ROTOR.omega, ROTOR))
    named = dict(zip(mode.state, state, strict=True))
    found = np.array([[value_of(e, core, named) for e in row] for row in derived.jacobian])
    for place in range(state.size):
        aside = 1e-6 * np.eye(state.size)[place]
        high, low = (
            np.array(mode.drawn_rates((state + sign * aside).tolist(), core)) for sign in (1, -1)
        )
        np.testing.assert_allclose(found[:, place], (high - low) / 2e-6, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("way", RUN_UP.lighter)
@pytest.mark.parametrize("name", MODES)
def test_lighter_series_are_of_the_same_rates(name, way):
    """Where what they leave out is 0; the work on the ring is known without them."""
    fixed = RUN_UP.lighter[way]
    rotor = ROTOR
    if way == "plain":
        rotor = replace(rotor, shaft_stiffness=0.0, contact_damping=0.0, load=0.0)
    core = as_core(rotor, SPINS["ramp"], name)
    z, v = drawn(name, 5)
    named = dict(zip(MODES[name].state, of_core(name, z, v, 1.3, rotor), strict=True))
    rates = MODES[name].rates([named[each] for each in MODES[name].state], core)
    derived = derive(MODES[name], RUN_UP, fixed)
    for each, light, rate in zip(MODES[name].state, derived.rates, rates, strict=True):
        if each not in fixed:
            assert value_of(light, core, named) == pytest.approx(rate, rel=1e-13, abs=1e-15)
