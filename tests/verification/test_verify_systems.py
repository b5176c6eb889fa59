"""Results of rotor systems over the speed are made again from their archives."""

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    continue_cycle,
    limit_cycle,
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


LARGE = RotorSystem(
    mass=np.eye(8), damping=0.1 * np.eye(8), stiffness=np.diag(np.linspace(1.0, 40.0, 8)),
    nodes={"disc": (0, 1)}, unbalance=[Unbalance(node="disc", moment=1.0)],
    contacts=[Contact(node="disc", clearance=2.0, stiffness=4.0)],
)  # fmt: skip
MADE = {
    "whirls": lambda: synchronous_response(LARGE, speed=[1.2, 1.5]),
    "run": lambda: simulate(LARGE, speed=1.2, duration=5.0, modes=4, samples=3,
                            start=(0.1 * np.ones(8), np.zeros(8))),
    "loaded run": lambda: simulate(LARGE, speed=1.2, duration=5.0, modes=4, samples=3,
                                   static_force=0.01 * np.ones(8)),
}  # fmt: skip


@pytest.mark.parametrize("kind", MADE)
def test_a_large_system_is_taken_from_the_matrices_of_its_result(kind, monkeypatch):
    monkeypatch.setattr("rotor_ida.results.question.MOST_NUMBERS", 300)
    made = MADE[kind]()
    assert "RotorSystem" not in made.attrs["question"]
    assert differences(rerun(made), made)["agrees"] is True


@pytest.mark.parametrize("start", ["run", "cycle", "branch"])
def test_a_cycle_from_a_result_is_made_again_from_its_guess(start):
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    starts = {
        "run": lambda: simulate(system, speed=2.0, duration=20.0, samples=3),
        "cycle": lambda: limit_cycle(system, speed=1.99),
        "branch": lambda: continue_cycle(system, speed=1.99, limits=(1.98, 2.0)).isel(point=1),
    }
    given = {} if start == "branch" else {"speed": 2.0}
    cycle = limit_cycle(system, start=starts[start](), **given)
    assert len(cycle.attrs["question"]) < 2000
    assert differences(rerun(cycle), cycle)["agrees"] is True


def test_critical_speeds_are_not_compared_of_a_part():
    whirls = synchronous_response(
        SYSTEM, contacts=CONTACTS, unbalance=UNBALANCE, speed=np.linspace(300.0, 900.0, 25)
    )
    assert whirls.sizes["critical"] > 0
    part = whirls.isel(speed=[20, 3])
    found = differences(rerun(part), part)
    assert found["agrees"] is True, found["trouble"]
    assert "critical_speed" in found["not_compared"]
    assert "critical_speed" not in differences(rerun(whirls), whirls)["not_compared"]


def test_lost_branches_and_parts_are_named(tmp_path):
    made = special_speeds(
        SYSTEM, contacts=CONTACTS, unbalance=UNBALANCE, limits=(300.0, 900.0), points=20
    )
    again = rerun(load(save(made, tmp_path / "result.nc")))
    found = differences(again, made.isel(special=slice(1, None)))
    assert f"{{'special': {made.sizes['special']}}} computed again" in found["trouble"]
    with pytest.raises(InputError, match="cannot be verified: it lacks mass_matrix"):
        differences(again, made.drop_vars("mass_matrix"))


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
