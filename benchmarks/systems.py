"""Rotor systems: whether they are the rotors that they should be, and what they cost.

Random rotors of one disc as systems, against the core of one disc: each event. The time of both.
With ROSS (``pip install 'ross-rotordynamics>=2.3' 'plotly<7'``) a rotor of 66 degrees of freedom
with a contact, whole and with a few modes, against ROSS's own steps.

    python benchmarks/systems.py [--trials 2000] [--rounds 7]
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
import time
import warnings
from functools import partial
from itertools import product

import numpy as np
from measuring import ROUNDS, clocked, in_turn, machine

from rotor_ida import Contact, Rotor, RotorSystem, Unbalance, simulate

SPEED, MOMENT, CLEARANCE, STIFFNESS, DURATION = 426.33795, 2e-4, 1e-4, 5e6, 0.2
MODES, STEPS_OF_ROSS = (4, 12, 20), (1e-4, 1e-5)
SURE = 1e-9


def random_rotor(rng):
    """Return a random rotor of one disc, with anything that one may have."""
    rubs = rng.random() < 0.6
    return Rotor(
        omega=rng.uniform(0.2, 3.0), zeta=rng.uniform(0.01, 0.3), delta0=rng.uniform(0.3, 2.0),
        shaft_stiffness=float(rng.choice([0.0, rng.uniform(0.01, 1.0)])),
        contact_damping=float(rng.choice([0.0, rng.uniform(0.01, 2.0)])),
        load=float(rng.choice([0.0, rng.uniform(0.0, 0.5)])),
        friction=rng.uniform(0.02, 0.5) if rubs else 0.0,
        disc_radius=rng.uniform(1.0, 20.0) if rubs else None,
        contact_exponent=float(rng.choice([1.0, 1.5])),
    )  # fmt: skip


def as_system(rotor, start, **how):
    """Return a run of a rotor of one disc as a system."""
    return simulate(rotor.system(), speed=rotor.omega, start=(start[:2], start[2:]), **how)


def compare(trials):
    """Compare random rotors of one disc with the same as systems; return how many differ."""
    rng, events, others, worst = np.random.default_rng(11), 0, [], 0.0
    for trial in range(trials):
        rotor, start = random_rotor(rng), rng.normal(size=4)
        how = {"duration": 40.0, "samples": 2, "rtol": 1e-13}
        one = simulate(rotor, start=start, method="taylor", **how)
        many = as_system(rotor, start, **how)
        stated = one.event_time_error.values
        count = stated.size if (stated < SURE).all() else int(np.argmin(stated < SURE))
        same = np.array_equal(one.event_kind[:count], many.event_kind[:count])
        apart = np.abs(
            one.event_time.values[:count] - many.event_time.values[: stated.size][:count]
        )
        allowed = 20.0 * (stated[:count] + many.event_time_error.values[:count]) + 1e-12
        events += count
        if not same or (apart > allowed).any():
            others.append(trial)
        worst = max(worst, float(apart.max(initial=0.0)))
    print(f"{trials} rotors, {events} events known to {SURE:g}: {len(others)} rotors differ "
          f"{others[:9]}; events apart by at most {worst:.2g}")  # fmt: skip
    return len(others)


def one_disc(rounds):
    """Print the time of one disc as a system over that by the core of one disc."""
    rotors = {
        "bouncing": Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.1),
        "full contact": Rotor(omega=1.2, zeta=0.07, delta0=0.5),
        "rubbing": Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0),
    }
    start, how = np.array([3.0, 1.0, 0.0, 0.0]), {"duration": 400.0, "samples": 2}
    for (name, each), method in product(rotors.items(), ("taylor", "adams")):
        ways = {
            "one disc": partial(simulate, each, start=start, method=method, **how),
            "system": partial(as_system, each, start, method=method, **how),
        }
        times = in_turn({way: clocked(run) for way, run in ways.items()}, rounds)
        one, many = (times[way].median for way in ways)
        print(
            f"{name}, {method}: {1e3 * one:.2f} ms, as a system {1e3 * many:.2f} ms, "
            f"{many / one:.2f} times"
        )


def rotor_of_ross(ross):
    """Return the rotor of the comparison."""
    steel = ross.Material("steel", rho=7810.0, E=211e9, G_s=81.2e9)
    shaft = [ross.ShaftElement(0.05, 0.0, 0.02, material=steel, n=i, alpha=2.0) for i in range(10)]
    discs = [ross.DiskElement.from_geometry(n, steel, 0.02, 0.02, 0.12) for n in (3, 7)]
    bearings = [ross.BearingElement(n, kxx=5e6, cxx=200.0) for n in (0, 10)]
    return ross.Rotor(shaft, discs, bearings)


def against_ross(rounds):
    """Print time and error of a rotor of finite elements, by this package and by ROSS."""
    try:
        with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
            warnings.simplefilter("ignore")
            import ross  # noqa: PLC0415 - it takes seconds, and is not always there
    except ImportError:
        print("ROSS is missing: pip install 'ross-rotordynamics>=2.3' 'plotly<7'")
        return
    rotor = rotor_of_ross(ross)
    system = RotorSystem.from_ross(rotor, speed=SPEED)
    around = {
        "contacts": [Contact(node="3", clearance=CLEARANCE, stiffness=STIFFNESS, exponent=1.0)],
        "unbalance": [Unbalance(node=each, moment=MOMENT) for each in ("3", "7")],
        "speed": SPEED, "duration": DURATION, "samples": 2,
    }  # fmt: skip
    whole = simulate(system, **around)
    exact = np.array([whole[name].sel(node="3").values[-1] for name in "xy"])
    times = whole.event_time.values
    print(f"{system}: {times.size} events, the first at {times[0]:.9g} s, the last at "
          f"{times[-1]:.9g} s; node 3 ends at "
          f"({1e6 * exact[0]:.6f}, {1e6 * exact[1]:.6f}) um, largest r/clearance "
          f"{whole.excursion.item():.6f}")  # fmt: skip
    clocks = {"all modes": clocked(lambda: simulate(system, **around))}
    for count in MODES:
        run = simulate(system, **around, modes=count)
        off = np.hypot(
            *(run[n].sel(node="3").values[-1] - e for n, e in zip("xy", exact, strict=True))
        )
        name = f"{count} modes, {1e6 * off:.2g} um off"
        clocks[name] = clocked(lambda count=count: simulate(system, **around, modes=count))
    for name, spent in in_turn(clocks, rounds).items():
        print(f"{name}: {1e3 * spent.median:.1f} ms")
    for step in STEPS_OF_ROSS:
        begun = time.perf_counter()
        with contextlib.redirect_stdout(io.StringIO()):
            found = rotor.run_rubbing(
                n=3, distance=CLEARANCE, contact_stiffness=STIFFNESS, contact_damping=0.0,
                friction_coeff=0.0, node=[3, 7], unbalance_magnitude=[MOMENT, MOMENT],
                unbalance_phase=[0.0, 0.0], speed=SPEED,
                t=np.arange(0.0, DURATION + 0.5 * step, step),
            )  # fmt: skip
        took = time.perf_counter() - begun
        place = found.yout[-1, [3 * rotor.number_dof, 3 * rotor.number_dof + 1]]
        off = np.hypot(*(place - exact))
        print(f"ROSS, dt {step:g} s: {1e3 * took:.0f} ms, {1e6 * off:.3g} um off")


def main() -> int:
    """Compare and measure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=2000)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    asked = parser.parse_args()
    print(machine())
    others = compare(asked.trials)
    one_disc(asked.rounds)
    against_ross(asked.rounds)
    return 1 if others else 0


if __name__ == "__main__":
    sys.exit(main())
