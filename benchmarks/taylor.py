"""Taylor series beside CVODE: at equal error, against the arithmetic's limit, and with tangents.

Each table by its own name, or all of them:

    pip install -e '.[bench]' && python benchmarks/taylor.py
    python benchmarks/taylor.py witness runs

- witness: how far the reference of the other tables, Taylor series at rtol 1e-15, is from other
  programs at their tightest tolerances;
- runs: time at equal achieved error, of the runs of `speed.py`, with heyoka where no contact begins
  or ends (needs the extra ``bench``);
- arithmetic: the coefficients of one step, beside as many multiply-adds of a dot product;
- tangents: a motion with its four tangent vectors, by each method.
"""

import argparse
import importlib.util
import time

import numpy as np
import ways
from measuring import ROUNDS, clocked, in_turn, machine, ratio

from rotor_ida.equations.compiling import compiled
from rotor_ida.simulation.start import starts_in_contact
from rotor_ida.simulation.taylor.contact_series import expand_contact
from rotor_ida.simulation.taylor.motion import open_taylor
from rotor_ida.stability.lyapunov import METHODS_OF_TANGENTS, follow_stretches

WANTED = (1e-7, 1e-9, 1e-11)
TOLERANCES = [10.0 ** (-power / 4.0) for power in range(16, 61)]
ORDERS = (10, 15, 20)
REPEATS = 20_000
# Numbers in each vector of the dot product: both lie in the nearest cache.
VECTOR = 1024
MOTIONS = {
    "whirl": (1.2, 0.07, 0.5, (0.0, 0.0, 0.0, 0.0)),
    "bouncing": (2.0, 0.07, 2.0, (0.0, 0.0, 0.0, 0.0)),
    "fast, bouncing": (3.0, 0.07, 1.0, (0.0, 0.0, 0.0, 0.0)),
}
SPAN, SPANS = 0.5, 4000


def cases():
    """Return the three runs."""
    return [ways.FULL_CONTACT, ways.BOUNCING, ways.in_contact_from_start()]


def witness(_rounds):
    """Print the difference of states and events from those of other programs."""
    print("\n| run | way | rtol | state | event time |\n|---|---|---|---|---|")
    for case in cases():
        others = {"CVODE": (ways.compiled, 1e-13), "SciPy DOP853": (ways.dop853, 1e-13)}
        if importlib.util.find_spec("heyoka") and "throughout" in case.name:
            others["heyoka"] = (ways.heyoka, 1e-16)
        for name, (make, rtol) in others.items():
            state, event = ways.errors(case, make(case, rtol)())
            print(f"| {case.name} | {name} | {rtol:g} | {state:.0e} | {event:.0e} |", flush=True)


def runs(rounds):
    """Print times at equal error, and how many times as fast as CVODE."""
    print("\n| run | state error at most | way | rtol | state error | ms | times as fast |")
    print("|---|---|---|---|---|---|---|")
    for case in cases():
        makes = {"CVODE": ways.compiled, "Taylor": ways.taylor}
        if importlib.util.find_spec("heyoka") and "throughout" in case.name:
            makes["heyoka"] = ways.heyoka
        for wanted in WANTED:
            found = {}
            for name, make in makes.items():
                rtol = ways.at_equal_error(make, case, wanted, TOLERANCES)
                found[name] = (rtol, make(case, rtol))
            times = in_turn({name: clocked(way) for name, (_, way) in found.items()}, rounds)
            for name, (rtol, way) in found.items():
                error, _ = ways.errors(case, way())
                gain, _ = ratio(times["CVODE"], times[name])
                print(
                    f"| {case.name} | {wanted:.0e} | {name} | {rtol:.1e} | {error:.0e} "
                    f"| {1e3 * times[name].median:.2f} | {gain:.2f} |",
                    flush=True,
                )


@compiled
def expand(rtol, order, repeats):
    """Write the coefficients of a contact up to an order, over and over."""
    motion = open_taylor(1.2, 0.07, 0.5, True, rtol, False)
    motion.series.terms[0, :5] = np.array([0.8, 0.1, 1.5, 0.6, 0.8])
    for _ in range(repeats):
        expand_contact(motion.series, motion.factors, order, 1.2, 0.07, 0.5)
    return motion.series.terms[order, 0]


@compiled
def dot(left, right, repeats):
    """Take a dot product over and over."""
    total = 0.0
    for _ in range(repeats):
        total += np.dot(left, right)
    return total


def arithmetic(rounds):
    """Print the time of one step's coefficients, and of as many multiply-adds alone.

    Order n of each of the 13 products takes n + 1 of them.
    """
    left = right = np.ones(VECTOR)
    clocks = {0: clocked(lambda: dot(left, right, REPEATS))}
    for order in ORDERS:
        rtol = np.exp(2.0 - 2.0 * (order - 1))
        clocks[order] = clocked(lambda rtol=rtol, order=order: expand(rtol, order, REPEATS))
    times = in_turn(clocks, rounds)
    each = times[0].median / REPEATS / VECTOR
    print(
        "\n| order | multiply-adds | ns | of as many in a dot product | ratio |"
        "\n|---|---|---|---|---|"
    )
    for order in ORDERS:
        count = 13 * order * (order + 1) // 2
        spent = times[order].median / REPEATS
        print(
            f"| {order} | {count:,} | {1e9 * spent:.0f} | {1e9 * count * each:.0f} "
            f"| {spent / (count * each):.1f} |"
        )


def tangents(_rounds):
    """Print what a motion with its tangent vectors takes, and how exact its exponents are."""
    print("\n| motion | method | rtol | worst error of a mean rate | s |\n|---|---|---|---|---|")
    for name, (*rotor, start) in MOTIONS.items():
        right, _ = stretched(rotor, start, 1e-14, "taylor")
        for method in METHODS_OF_TANGENTS:
            for rtol in (1e-8, 1e-10, 1e-12):
                means, spent = stretched(rotor, start, rtol, method)
                error = np.abs(means - right).max()
                print(f"| {name} | {method} | {rtol:g} | {error:.0e} | {spent:.3f} |", flush=True)


def stretched(rotor, start, rtol, method):
    """Return the mean rates of stretching of one motion, and the seconds that it took."""
    bundle = np.vstack([start, np.linalg.qr(np.vander([1.0, 0.7, -0.4, -0.9]))[0]])
    inside = starts_in_contact(complex(*start[:2]), complex(*start[2:]), *rotor)
    stretches, stop = np.empty((SPANS, 4)), np.zeros(1, np.uint8)
    how = (tuple(rotor), rtol, stop, method)
    follow_stretches(bundle.copy(), inside, SPAN, stretches[:1], *how)
    began = time.process_time()
    follow_stretches(bundle, inside, SPAN, stretches, *how)
    spent = time.process_time() - began
    return stretches.mean(axis=0) / SPAN, spent


TABLES = {way.__name__: way for way in (witness, runs, arithmetic, tangents)}


def main():
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(TABLES))
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    arguments = parser.parse_args()
    unknown = set(arguments.tables) - set(TABLES)
    if unknown:
        parser.error(f"no table {', '.join(sorted(unknown))}: choose from {', '.join(TABLES)}")
    print(f"{machine()}\n\nMedians of {arguments.rounds} rounds, in turn.")
    for name in arguments.tables or TABLES:
        TABLES[name](arguments.rounds)


if __name__ == "__main__":
    main()
