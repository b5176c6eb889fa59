"""Settled responses of rotor systems: against exact whirls, and as labels of one disc; their time.

Random axisymmetric systems of 4 to 10 degrees of freedom, with two contacts, stators, friction and
contact damping: what settles on a synchronous or contact-free whirl is compared with all exact
ones. Random rotors of one disc are swept as such and as systems, and their labels compared. A
finite-element rotor with two clearances is swept up in 12 modes.

    python benchmarks/system_sweeps.py --systems 100 --discs 60
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

from rotor_ida import Rotor, Unbalance, decode_flags, sweep, synchronous_response
from rotor_ida.schema import STABILITY
from tests.axisymmetric_systems import random_axisymmetric

SPEEDS = [0.3, 0.6, 0.9, 1.3]
STEADY = ("contact_free", "synchronous")


def against_exact(seed):
    """Return the labels of a random system, and how far steady ones are from exact whirls."""
    system, contacts, unbalance = random_axisymmetric(seed)
    given = {"contacts": contacts, "unbalance": unbalance, "speed": SPEEDS}
    found = sweep(system, **given, workers=1).squeeze(["start", "direction"])
    exact = synchronous_response(system, **given)
    worst, unstable = 0.0, 0
    words = decode_flags(found.response).values.tolist()
    for row, word in enumerate(words):
        if word not in STEADY:
            continue
        point, branches = found.isel(speed=row), exact.isel(speed=row)
        whirl = (point.node_amplitude * np.exp(-1j * point.node_phase_lag)).values
        exactly = (branches.node_amplitude * np.exp(-1j * branches.node_phase_lag)).values
        apart = np.abs(exactly - whirl).max(axis=1) / np.abs(whirl).max()
        nearest = int(np.nanargmin(apart))
        worst = max(worst, float(apart[nearest]))
        unstable += int(branches.stability[nearest]) == STABILITY["unstable"]
    return words, worst, unstable


def random_disc(rng):
    """Return a random rotor of one disc on a shaft."""
    rubs = rng.random() < 0.5
    return {
        "omega": rng.uniform(0.3, 2.5), "zeta": rng.uniform(0.05, 0.3),
        "delta0": rng.uniform(0.3, 2.0), "shaft_stiffness": rng.uniform(0.05, 1.0),
        "contact_exponent": float(rng.choice([1.0, 1.5])),
        "contact_damping": float(rng.choice([0.0, 0.5])),
        "load": float(rng.choice([0.0, 0.3])),
        "friction": rng.uniform(0.02, 0.3) if rubs else 0.0,
        "disc_radius": rng.uniform(2.0, 15.0) if rubs else None,
    }  # fmt: skip


def labels_of_disc(given):
    """Return the labels of one disc as such and as a system."""
    one = sweep(**given, method="taylor", workers=1).squeeze()
    system = Rotor(**given).system()
    found = sweep(system, speed=given["omega"], workers=1).squeeze()
    return decode_flags(one.response).item(), decode_flags(found.response).item()


def timed_beam():
    """Return wall and processor time of 100 speeds of a finite-element rotor in 12 modes."""
    sys.path.insert(0, str(Path(__file__).parents[1] / "scenarios"))
    import finite_elements as beam  # noqa: PLC0415 - a script of another folder

    unbalance = [Unbalance(node=name, moment=beam.UNBALANCE) for name in beam.DISCS]
    began, spent = time.perf_counter(), time.process_time()
    found = sweep(
        beam.rotor(), contacts=beam.stops(), unbalance=unbalance, modes=12, workers=2,
        speed=np.linspace(beam.FIRST, beam.LAST, 100),
    )  # fmt: skip
    assert (found.status == 0).all()
    return time.perf_counter() - began, time.process_time() - spent


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--systems", type=int, default=20)
    parser.add_argument("--discs", type=int, default=20)
    asked = parser.parse_args()
    labels, worst, unstable, spent = Counter(), 0.0, 0, time.process_time()
    for seed in range(asked.systems):
        words, apart, wrong = against_exact(seed)
        labels.update(words)
        worst, unstable = max(worst, apart), unstable + wrong
    print(f"{asked.systems} systems, {sum(labels.values())} points: {dict(labels)}")
    print(f"  steady ones off the nearest exact whirl by at most {worst:.2g}; {unstable} unstable")
    print(f"  {time.process_time() - spent:.0f} s of processor time")
    rng = np.random.default_rng(0)
    pairs = Counter(labels_of_disc(random_disc(rng)) for _ in range(asked.discs))
    print(f"{asked.discs} rotors of one disc, with both labels:")
    for (one, system), count in sorted(pairs.items(), key=lambda each: -each[1]):
        print(f"  {count:4d} {one} {'' if one == system else f'but {system}'}")
    wall, processor = timed_beam()
    print(f"100 speeds in 12 modes: {wall:.1f} s, {processor:.1f} s of processor time")


if __name__ == "__main__":
    main()
