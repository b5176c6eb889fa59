"""What takes a `Rotor` uses each of its parameters, or refuses it; none is left out in silence."""

from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import DimensionalRotor, InputError, Rotor
from rotor_ida.model.parameters import DEFAULTS

START = (2.6, 0.75, 0.66, -1.65)
# The value of each optional parameter, and what it needs besides.
VALUES = {
    "shaft_stiffness": 0.2, "contact_exponent": 1.0, "contact_damping": 0.3, "load": 0.1,
    "friction": 0.1, "disc_radius": 2.0,
}  # fmt: skip
NEEDED = {"friction": {"disc_radius": 3.0}, "disc_radius": {"friction": 0.1, "disc_radius": 3.0}}
# At rest nothing moves.
NOT_AT_REST = {"contact_damping", "friction", "disc_radius"}


def of(dataset: xr.Dataset, *names: str) -> np.ndarray:
    return np.concatenate([np.asarray(dataset[name], dtype=float).ravel() for name in names])


def simulated(method: str, backend: str = "auto") -> Callable[[Rotor], np.ndarray]:
    return lambda rotor: of(
        rotor_ida.simulate(rotor, start=START, duration=12.0, method=method, backend=backend),
        "event_time", "x", "y",
    )  # fmt: skip


def run_up(rotor: Rotor) -> np.ndarray:
    found = rotor_ida.run_up(rotor, to=2.2, ramp_time=12.0, start=START)
    return of(found, "event_time", "x", "y")


def system(rotor: Rotor | DimensionalRotor) -> np.ndarray:
    found = rotor.system()
    (contact,), (unbalance,) = found.contacts, found.unbalance
    law = (contact.clearance, contact.stiffness, contact.exponent, contact.damping,
           contact.friction, contact.radius or 0.0, unbalance.moment)  # fmt: skip
    matrices = (found.mass, found.stiffness, found.damping, found.gravity or (0.0, 0.0))
    return np.concatenate([*map(np.ravel, matrices), law])


def machine(rotor: Rotor) -> np.ndarray:
    si = DimensionalRotor(
        mass=1.0, contact_stiffness=1.0, damping=2.0 * rotor.zeta, eccentricity=1.0,
        clearance=rotor.delta0, speed=rotor.omega,
        **{name: getattr(rotor, name) for name in DEFAULTS},
    )  # fmt: skip
    assert si.rotor() == rotor
    return system(si)


def limit_cycle(rotor: Rotor) -> np.ndarray:
    cycle = rotor_ida.limit_cycle(rotor, start=START)
    return of(cycle, "period", "multiplier_real", "multiplier_imag")


def lyapunov(rotor: Rotor) -> np.ndarray:
    found = rotor_ida.lyapunov_exponent(
        rotor, start=START, transient=20.0, duration=400.0, batches=4
    )
    return of(found, "lyapunov_exponent")


def basin(rotor: Rotor) -> np.ndarray:
    return of(rotor_ida.basin(rotor, x=1.0, y=(2.0, 4.0), workers=1), "settling_time")


def backward_whirl(rotor: Rotor) -> np.ndarray:
    rotor = Rotor(**{"friction": 0.4, "disc_radius": 3.0, "shaft_stiffness": 0.1} | rotor.given)
    return of(rotor_ida.backward_whirl(rotor), "amplitude", "growth_rate")


def rest(rotor: Rotor) -> np.ndarray:
    pressed = Rotor(**{"load": 3.0} | rotor.given)
    return of(rotor_ida.rest(pressed), "y", "indentation", "radial_frequency")


ASKED: dict[str, Callable[[Rotor], np.ndarray]] = {
    "simulate by Taylor series": simulated("taylor"),
    "simulate by CVODE": simulated("adams"),
    "simulate by the reference": simulated("bdf", "python"),
    "run_up": run_up,
    "system": system,
    "system of a machine": machine,
    "limit_cycle": limit_cycle,
    "lyapunov_exponent": lyapunov,
    "basin": basin,
    "backward_whirl": backward_whirl,
    "rest": rest,
}


def answer(what: str, **changes: float) -> np.ndarray | None:
    try:
        return ASKED[what](Rotor(omega=2.0, zeta=0.07, delta0=2.0, **changes))
    except InputError:
        return None


@pytest.mark.parametrize("name", DEFAULTS)
@pytest.mark.parametrize("what", ASKED)
def test_each_is_used_or_refused(what, name):
    needed = NEEDED.get(name, {})
    without = {key: value for key, value in needed.items() if name == "disc_radius"}
    before, after = answer(what, **without), answer(what, **needed | {name: VALUES[name]})
    if after is None:
        return
    is_same = before is not None and np.array_equal(before, after)
    assert is_same == (what == "rest" and name in NOT_AT_REST)
