"""Contacts, unbalance, supports, gravity and static force belong to a rotor system."""

import pickle
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

import rotor_ida
from rotor_ida import (
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Support,
    Unbalance,
    simulate,
)

BARE = RotorSystem(
    mass=np.eye(4), stiffness=2.0 * np.eye(4), damping=0.2 * np.eye(4),
    nodes={"disc": (0, 1), "end": (2, 3)}, units="1",
)  # fmt: skip
TOUCH = Contact(node="disc", clearance=0.5, stiffness=4.0, exponent=1.0)
FIELDS = {"contacts": [TOUCH], "unbalance": [Unbalance(node="disc", moment=0.4)]}
HEAVY = {**FIELDS, "gravity": (0.0, -0.1), "static_force": [0.0, 0.0, 0.05, 0.0],
         "supports": [Support(node="end", stiffness=3.0, damping=0.1)]}  # fmt: skip
PUMP = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                        clearance=2e-6, speed=600.0, shaft_stiffness=4e5)  # fmt: skip
LEVITATED = HEAVY | {"unbalance": [Unbalance(node="disc", moment=0.1)]}
CYCLING = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
LIGHTER = {"unbalance": [Unbalance(node="disc", moment=0.99)]}
# What each function needs, and the fields that it takes in.
ASKED = {
    "simulate": ({"speed": 1.2, "duration": 9.0, "samples": 5}, HEAVY),
    "run_up": ({"speed": 0.5, "to": 1.2, "rate": 0.1, "samples": 5}, HEAVY),
    "sweep": ({"speed": 1.2, "workers": 1}, FIELDS),
    "lyapunov_exponent": (
        {"speed": 1.2, "transient": 5, "revolutions": 80, "batches": 4, "exponents": 1}, HEAVY,
    ),
    "synchronous_response": ({"speed": [0.9, 1.2]}, FIELDS),
    "campbell": ({"speed": [0.9, 1.2], "contact_stiffness": [0.0, 1.0]}, HEAVY),
    "special_speeds": ({"limits": (0.9, 1.9), "points": 8}, FIELDS),
    "clearance_report": (
        {"speed": (1.0, 1.1), "vibration_limit": 1.0, "points": 8, "multiple": 1.0}, FIELDS,
    ),
    "run_ups": ({"speed": 0.9, "to": 1.2, "rate": 0.1, "workers": 1}, FIELDS),
    "drop": ({"speed": 1.2, "duration": 5.0, "samples": 5}, LEVITATED),
    "limit_cycle": ({"speed": 2.0}, LIGHTER),
    "continue_cycle": ({"speed": 2.0, "limits": (1.9, 2.1), "points": 2}, LIGHTER),
    "drop_ensemble": ({"speed": 1.2, "duration": 2.0, "drops": 2, "workers": 1}, LEVITATED),
}  # fmt: skip


@pytest.mark.parametrize("verb", ASKED)
def test_keywords_stand_in_for_the_fields_of_the_system(verb):
    asked, fields = ASKED[verb]
    bare = CYCLING if "cycle" in verb else BARE
    one, other = (
        getattr(rotor_ida, verb)(replace(bare, **fields), **asked),
        getattr(rotor_ida, verb)(bare, **asked, **fields),
    )
    assert one.drop_vars("message", errors="ignore").equals(
        other.drop_vars("message", errors="ignore")
    )
    assert BARE.contacts == ()  # what is given stays as it is


@pytest.mark.parametrize("verb", ASKED)
def test_a_wrong_first_argument_and_a_misspelt_keyword_get_one_line(verb):
    function = getattr(rotor_ida, verb)
    asked, _ = ASKED[verb]
    words = rf"^{verb} takes a Rotor, DimensionalRotor or RotorSystem first, as in {verb}\(.*'pump"
    with pytest.raises(InputError, match=words) as caught:
        function("pump.toml", **asked)
    assert "\n" not in str(caught.value)
    words = rf"^{verb}\(\) got an unexpected keyword argument 'contcts'; did you mean 'contacts'\?$"
    with pytest.raises(TypeError, match=words):
        function(BARE, **asked, contcts=[TOUCH])


def test_a_system_is_a_value():
    held = replace(BARE, **HEAVY)
    assert held.contacts == (TOUCH,)
    with pytest.raises(FrozenInstanceError):
        held.gravity = None
    with pytest.raises(ValueError, match="read-only"):
        held.static_force[0] = 1.0
    again = pickle.loads(pickle.dumps(held))
    asked = {"speed": 1.2, "duration": 5.0, "samples": 3}
    assert simulate(again, **asked).equals(simulate(held, **asked))


def test_a_static_force_may_act_on_stators_too():
    """A stator of stiffness 2 under a force of 0.5 sags by 0.25; the rotor is not touched."""
    free = Contact(node="disc", clearance=9.0, stiffness=4.0, stator=Stator(mass=1.0, stiffness=2))
    system = replace(BARE, contacts=[free], static_force=[0.0, 0.2, 0.0, 0.0, 0.0, 0.5])
    run = simulate(system, speed=1.0, start="rest", duration=1.0, samples=2)
    np.testing.assert_allclose(run.final_state[:6], [0.0, 0.1, 0.0, 0.0, 0.0, 0.25], atol=1e-12)
    small = system.reduced(modes=4)
    run = simulate(small, speed=1.0, start="rest", duration=1.0, samples=2)
    np.testing.assert_allclose(run.final_state[4:6], [0.0, 0.25], atol=1e-12)


def test_fewer_coordinates_keep_what_belongs_to_the_system():
    """All four modes are the system itself, in other coordinates."""
    held = replace(BARE, **HEAVY)
    small = held.reduced(modes=4)
    assert small.contacts == held.contacts
    assert (small.unbalance, small.supports) == (held.unbalance, held.supports)
    assert small.gravity == held.gravity
    asked = {"speed": 1.2, "duration": 9.0, "samples": 5, "start": None}
    one, other = simulate(held, **asked), simulate(small, **asked)
    np.testing.assert_allclose(one.event_time, other.event_time, rtol=1e-9)
    np.testing.assert_allclose(one.x, other.x, atol=1e-9)
    sizes = [held.reduced(modes=0, **keep).size for keep in ({}, {"keep": ["disc", "end"]})]
    assert sizes == [2, 4]  # by default the flexibility of the contact's node


def test_a_file_takes_them_along(tmp_path):
    np.savez(tmp_path / "rotor.npz", M=np.eye(2), K=np.eye(2), node_disc=[0, 1])
    system = RotorSystem.from_file(tmp_path / "rotor.npz", contacts=[TOUCH], gravity=(0.0, -1.0))
    assert (system.contacts, system.gravity) == ((TOUCH,), (0.0, -1.0))
    with pytest.raises(TypeError, match=r"from_file\(\) got an unexpected .* did you mean 'grav"):
        RotorSystem.from_file(tmp_path / "rotor.npz", gravty=(0.0, -1.0))


def test_one_disc_goes_where_systems_go():
    """In SI a machine: its critical speed is the root of shaft stiffness over mass."""
    found = rotor_ida.campbell(PUMP, speed=[100.0, 900.0])
    assert found.speed.attrs["units"] == "s-1"
    exact = np.sqrt(4e5 / 4.0 - 280.0**2 / 4.0 / 4.0**2)
    np.testing.assert_allclose(found.critical_speed.max(), exact, rtol=1e-9)
    rotor = Rotor(omega=1.0, zeta=0.07, delta0=0.5)
    special = rotor_ida.special_speeds(rotor, limits=(0.5, 2.5), points=40)
    folds = np.sort(rotor_ida.folds(zeta=0.07, delta0=0.5).fold_omega.values.ravel())
    np.testing.assert_allclose(special.special_speed, folds[folds > 0.5], rtol=1e-9)
