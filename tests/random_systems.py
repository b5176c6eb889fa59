"""Random rotor systems: full matrices, several contacts, stators and races."""

import numpy as np

from rotor_ida import Contact, Race, RotorSystem, Stator, Unbalance, run_up, simulate


def random_system(seed):
    """Return a system, the keywords of its surroundings, and how it is simulated."""
    rng = np.random.default_rng(seed)
    size = 2 * int(rng.integers(2, 7))
    more, bent, turned = (rng.normal(size=(size, size)) for _ in range(3))
    stiffness = bent @ bent.T / size + 0.3 * np.eye(size)
    system = RotorSystem(
        mass=np.eye(size) + 0.1 * more @ more.T / size,
        stiffness=stiffness,
        damping=0.05 * np.eye(size) + 0.02 * stiffness,
        gyroscopic=0.2 * (turned - turned.T),
        stiffness_rate=0.02 * turned @ turned.T if seed % 3 == 0 else None,
        nodes={f"n{i}": (2 * i, 2 * i + 1) for i in range(size // 2)},
        units="1",
    )
    contacts = [random_contact(rng, i, size // 2) for i in range(int(rng.integers(1, 4)))]
    return system, {
        "contacts": contacts,
        "unbalance": [
            Unbalance(node="n0", moment=rng.uniform(0.2, 1)),
            Unbalance(node="n1", moment=rng.uniform(0.1, 0.5), phase=rng.uniform(0, 6)),
        ],
        "static_force": 0.2 * rng.normal(size=size),
        "start": (0.2 * rng.normal(size=size), 0.5 * rng.normal(size=size)),
    }


def random_contact(rng, number, nodes):
    """Return a contact, to the ground, to a stator of its own or to another node."""
    stator, kind = None, rng.random()
    if kind < 0.3:
        stator = Stator(
            mass=rng.uniform(0.3, 2), stiffness=rng.uniform(1, 10), damping=rng.uniform(0, 0.5)
        )
    elif kind < 0.5 and nodes > 3:
        stator = f"n{nodes - 1}"
    race = None
    if rng.random() < 0.3:
        race = Race(radius=rng.uniform(1, 3), inertia=rng.uniform(0.5, 3), drag=rng.uniform(0, 0.1))
    return Contact(
        node=f"n{number % nodes}",
        clearance=rng.uniform(0.3, 1.2),
        stiffness=rng.uniform(5, 50),
        exponent=float(rng.choice([1.0, 1.5])),
        damping=float(rng.choice([0.0, 0.3, 1.5])),
        friction=float(rng.choice([0.0, 0.1, 0.4])),
        radius=rng.uniform(1, 5),
        centre=tuple(0.1 * rng.normal(size=2)),
        stator=stator,
        race=race,
    )


def followed(seed, duration, **how):
    """Return a run of a random system: at a speed, along a ramp, or under a torque."""
    system, around = random_system(seed)
    common = around | {"duration": duration, "samples": 31} | how
    if seed % 4 < 2:
        return simulate(system, speed=1.1, **common)
    if seed % 4 == 2:
        return run_up(system, speed=0.5, rate=0.1, **common)
    return run_up(system, speed=1.0, torque=(1.5, 0.4), inertia=4.0, **common)


def stated_and_true(run, best):
    """Return stated and true errors of the sure events of a run, by one that is far more exact.

    What is not sure of the better run itself is taken off the true error. Other events are refused.
    """
    said, true = [], []
    for contact in range(run.sizes["contact"]):
        mine, theirs = (each.event_contact.values == contact for each in (run, best))
        stated = run.event_time_error.values[mine]
        sure = np.isfinite(stated)
        count = int(sure.sum())
        np.testing.assert_array_equal(
            run.event_kind.values[mine][:count], best.event_kind.values[theirs][:count]
        )
        apart = run.event_time.values[mine][:count] - best.event_time.values[theirs][:count]
        true.append(np.abs(apart) - best.event_time_error.values[theirs][:count])
        said.append(stated[:count])
    return np.concatenate(said), np.concatenate(true)
