"""How often the stated errors of many drops hold, and the cost of drops.

Ensembles of a rigid rotor on two hard bearings are repeated with other seeds; all their drops
together stand for the truth. Printed are the fractions of intervals that hold the truth, over both
bearings: each should be 95 %. Before that, a finite-element rotor in 12 modes is dropped, and
bounces for a second.

    python benchmarks/drops.py --repetitions 50 --drops 40
"""

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from rotor_ida import Contact, Race, RotorSystem, Support, Unbalance, drop, drop_ensemble
from rotor_ida.schema import OF_BEARING

SHOWN = ("largest_force", "largest_impulse", "total_heat", "excursion", "contact_count")
FACTS = ("backward_whirl", "rest", "decided")
PLACES = {"a": -0.25, "b": 0.3, "disc": 0.05}


def rotor():
    """Return a rigid rotor of 20 kg, and what stands around it."""
    gyroscopic = np.zeros((4, 4))
    gyroscopic[2, 3], gyroscopic[3, 2] = 0.08, -0.08
    nodes = {name: np.array([[1.0, 0.0, z, 0.0], [0.0, 1.0, 0.0, z]]) for name, z in PLACES.items()}
    system = RotorSystem(mass=np.diag([20.0, 20.0, 0.6, 0.6]), stiffness=np.zeros((4, 4)),
                         gyroscopic=gyroscopic, nodes=nodes)  # fmt: skip
    race = Race(radius=0.03, inertia=2e-4, drag=1e-4)
    bearings = [Contact(node=node, clearance=2e-4, stiffness=2e9, damping=1.0, friction=0.1,
                        radius=0.03, race=race) for node in "ab"]  # fmt: skip
    supports = [Support(node=node, stiffness=2e6, damping=2e3) for node in "ab"]
    return system, {"contacts": bearings, "supports": supports, "inertia": 0.08, "speed": 600.0,
                    "unbalance": [Unbalance(node="disc", moment=8e-5)]}  # fmt: skip


def long_drop():
    """Return a drop of the rotor of the scenario `finite_elements`, and its processor time."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "scenarios"))
    import finite_elements as beam  # noqa: PLC0415 - a script of another folder

    system = beam.rotor()
    stiffness, damping = system.stiffness.copy(), system.damping.copy()
    ends = [name for name in system.nodes if name in {"0", str(beam.ELEMENTS)}]
    translations = np.zeros((system.size, 2))
    for name in system.nodes:
        for axis, row in enumerate(system.rows(name)):
            translations[:, axis] += row
            if name in ends:
                stiffness -= beam.BEARING[0] * np.outer(row, row)
                damping -= beam.BEARING[1] * np.outer(row, row)
    begun = time.process_time()
    run = drop(
        replace(system, stiffness=stiffness, damping=damping, translations=translations),
        contacts=[Contact(node=name, clearance=5e-5, stiffness=1e11, friction=0.02, radius=0.02)
                  for name in "19"],
        supports=[Support(node=name, stiffness=beam.BEARING[0], damping=beam.BEARING[1])
                  for name in "19"],
        unbalance=[Unbalance(node=name, moment=beam.UNBALANCE) for name in beam.DISCS],
        speed=12000.0 * math.pi / 30.0, inertia=0.05, duration=1.0, modes=12,
    )  # fmt: skip
    return run, time.process_time() - begun


def main():
    """Repeat ensembles, and print how often their errors hold."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int, default=50)
    parser.add_argument("--drops", type=int, default=40)
    parser.add_argument("--duration", type=float, default=0.03)
    given = parser.parse_args()
    run, cost = long_drop()
    contacts = int(run.contact_count.sum())
    print(f"{contacts} contacts in 1 s in 12 modes: {cost:.2f} s of processor time")
    system, around = rotor()
    begun = time.process_time()
    runs = [drop_ensemble(system, **around, duration=given.duration, friction=(0.05, 0.3),
                          drops=given.drops, seed=seed)
            for seed in range(given.repetitions)]  # fmt: skip
    cost = (time.process_time() - begun) / given.repetitions / given.drops
    print(f"{1e3 * cost:.0f} ms of processor time a drop of {given.duration:g} s")
    for name in filter(OF_BEARING.__contains__, SHOWN):
        values = np.concatenate([run[name].values for run in runs])
        within = holds(runs, f"{name}_mean", values.mean(axis=0))
        levels = runs[0]["quantile"].values
        truth = np.quantile(values, levels, axis=0)
        held = holds(runs, f"{name}_quantile", truth)
        print(f"{name}: means {within.mean():.2f}, quantiles {held.mean(axis=(0, 2)).round(2)}")
    for name in FACTS:
        truth = np.mean([run[f"{name}_fraction"].values for run in runs], axis=0)
        print(f"{name}: {truth.round(3)}, held {holds(runs, f'{name}_fraction', truth).mean():.2f}")


def holds(runs, name, truth):
    """Return whether the interval of a figure holds the truth in each run."""
    low, high = (np.array([run[f"{name}_{end}"].values for run in runs]) for end in ("low", "high"))
    return (low <= truth) & (truth <= high)


if __name__ == "__main__":
    main()
