"""Results of rotor systems over the speed are made again from their archives."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    campbell,
    clearance_report,
    load,
    save,
    simulate,
    special_speeds,
    synchronous_response,
)
from rotor_ida.verification.verify import differences, rerun

CHAIN = np.array([[8e6, -4e6], [-4e6, 6e6]])
SYSTEM = RotorSystem(
    mass=np.diag([12.0, 12.0, 8.0, 8.0]), stiffness=np.kron(CHAIN, np.eye(2)),
    damping=np.kron(2e-4 * CHAIN, np.eye(2)), nodes={"disc": (0, 1), "seal": (2, 3)},
    positions={"disc": 0.3, "seal": 0.1},
)  # fmt: skip
CONTACTS = [
    Contact(node="seal", clearance=30e-6, stiffness=5e7, exponent=1.0, friction=0.1, radius=0.05,
            stator=Stator(mass=20.0, stiffness=1e7, damping=2000.0)),
    Contact(node="disc", clearance=50e-6, stiffness=4e9, damping=2.0),
]  # fmt: skip
UNBALANCE = [Unbalance(node="disc", moment=2e-4, phase=1.0)]
LOADED = RotorSystem(
    mass=SYSTEM.mass, stiffness=SYSTEM.stiffness, damping=SYSTEM.damping, nodes=SYSTEM.nodes,
    static_force=[0.0, -100.0, 0.0, 0.0],
)  # fmt: skip
AROUND = {"contacts": CONTACTS, "unbalance": UNBALANCE}
OF_REPORT = {"contacts": CONTACTS, "probes": ["disc"], "speed": (680.0, 840.0), "points": 40}
MADE = {
    "whirls": lambda: synchronous_response(SYSTEM, **AROUND, speed=[400.0, 600.0]),
    "unbalance response": lambda: synchronous_response(SYSTEM, unbalance=UNBALANCE, speed=500.0),
    "special speeds": lambda: special_speeds(SYSTEM, **AROUND, limits=(300.0, 900.0), points=20),
    "Campbell diagram": lambda: campbell(
        SYSTEM, contacts=CONTACTS, speed=[0.0, 500.0], contact_stiffness=[0.0, 1e7], modes=4
    ),
    "report": lambda: clearance_report(SYSTEM, **OF_REPORT),
    "report of an unbalance": lambda: clearance_report(
        SYSTEM, **OF_REPORT, unbalance=UNBALANCE, multiple=1.5, vibration_limit=3e-5
    ),
    "report of a loaded rotor": lambda: clearance_report(LOADED, **OF_REPORT, mass=18.0),
}


@cache
def made_of(name):
    return MADE[name]()


@cache
def made_again(name):
    """Return a result computed from the archive of another, and that as it was loaded."""
    with TemporaryDirectory() as folder:
        archived = load(save(made_of(name), Path(folder) / "result.nc"))
    return rerun(archived), archived


@pytest.mark.parametrize("name", MADE)
def test_a_result_is_made_again_to_the_bit(name):
    made, (again, archived) = made_of(name), made_again(name)
    assert again.drop_attrs().equals(made.drop_attrs())
    found = differences(again, archived)
    assert (found["agrees"], found["largest_difference"]) == (True, 0.0)
    assert found["compared"] >= 3
    with pytest.raises(InputError, match="method must be left out for the kind"):
        rerun(archived, method="taylor")


@pytest.mark.parametrize(
    ("name", "variable", "words"),
    [
        ("whirls", "growth_rate", "growth_rate differs in"),
        ("special speeds", "special_speed", "special_speed differs in"),
        ("Campbell diagram", "damping_ratio", "damping_ratio differs in"),
        ("report", "running_share", "running_share differs in"),
    ],
)
def test_a_forged_number_is_found(name, variable, words):
    forged = made_of(name).copy(deep=True)
    forged[variable].values.ravel()[0] *= 1.0 + 1e-6
    found = differences(made_again(name)[0], forged)
    assert found["agrees"] is False
    assert words in found["trouble"]
    assert found["differing"] >= 1


def test_lost_branches_and_parts_are_named():
    made = made_of("special speeds")
    found = differences(made_again("special speeds")[0], made.isel(special=slice(1, None)))
    assert f"{{'special': {made.sizes['special']}}} computed again" in found["trouble"]
    with pytest.raises(InputError, match="cannot be verified: it lacks unbalance_node"):
        rerun(
            made.drop_vars("unbalance_node")
            .drop_attrs(deep=False)
            .assign_attrs({name: each for name, each in made.attrs.items() if name != "question"})
        )
    with pytest.raises(InputError, match="cannot be verified: it lacks mass_matrix"):
        rerun(made.drop_vars("mass_matrix"))


def test_another_method_finds_the_same_excursion():
    """Though its samples miss the largest displacement: it is that of the motion between them."""
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    run = simulate(system, speed=2.0, duration=20.0, samples=201)
    again = rerun(run, method="adams")
    sampled = float(np.hypot(run.contact_x, run.contact_y).max()) / 2.0
    assert float(run.excursion.item()) > sampled + 1e-6
    np.testing.assert_allclose(again.excursion, run.excursion, rtol=1e-9)
    found = differences(again, run)
    assert found["agrees"] is True, found["trouble"]
    forged = run.assign(excursion=run.excursion * 1.002)
    assert "excursion differs" in differences(again, forged)["trouble"]
