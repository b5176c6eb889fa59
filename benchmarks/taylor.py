"""Taylor series beside CVODE: at equal error, against the arithmetic's limit, and with tangents.

Each table by its own name, or all of them:

    pip install -e '.[bench]' && python benchmarks/taylor.py
    python benchmarks/taylor.py witness runs

- witness: how far the reference of the other tables, Taylor series at rtol 1e-15, is from other
  programs at their tightest tolerances;
- runs: time at equal achieved error, of the runs of `speed.py`, with heyoka where no contact begins
  or ends (needs the extra ``bench``);
- arithmetic: the coefficients of one step, beside as many multiply-adds of a dot product
  (``c/series.c`` with the core's own source and flags; needs a C compiler);
- tangents: a motion with its four tangent vectors, by each method.
"""

import argparse
import importlib.util
import shlex
import subprocess
import tempfile
import time
from pathlib import Path

import c_program
import numpy as np
import ways
from measuring import ROUNDS, clocked, in_turn, machine, ratio

import rotor_ida
from rotor_ida import Rotor
from rotor_ida.core.library import build_info
from rotor_ida.core.runs import RunRequest, stretch
from rotor_ida.simulation.flow import ATOL
from rotor_ida.simulation.lyapunov import METHODS_OF_TANGENTS

WANTED = (1e-7, 1e-9, 1e-11)
TOLERANCES = [10.0 ** (-power / 4.0) for power in range(16, 61)]
ORDERS = (10, 15, 20)
REPEATS = 20_000
CORE = Path(rotor_ida.__file__).parent / "core"
SERIES = (str(Path(__file__).resolve().parent / "c" / "series.c"), str(CORE / "derived.c"))
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


def arithmetic(rounds):
    """Print the time of one step's coefficients, and of as many multiply-adds alone.

    Order n of each of the 12 products takes n + 1 of them. The median is over rounds in which the
    orders take turns.
    """
    found = {order: [] for order in ORDERS}
    with tempfile.TemporaryDirectory() as folder:
        try:
            program = c_program.compiled(
                [*shlex.split(build_info()["flags"]), f"-I{CORE}", *SERIES], Path(folder) / "series"
            )
        except c_program.NoProgramError as reason:
            print(f"\nNo table of the arithmetic: {reason}")
            return
        for _ in range(rounds):
            for order in ORDERS:
                command = [program, str(order), str(REPEATS)]
                ran = subprocess.run(command, capture_output=True, text=True, check=True)
                found[order].append([float(line.split()[1]) for line in ran.stdout.splitlines()])
    print(
        "\n| order | multiply-adds | ns | of as many in a dot product | ratio |"
        "\n|---|---|---|---|---|"
    )
    for order in ORDERS:
        count = 12 * order * (order + 1) // 2
        spent, each = np.median(found[order], axis=0)
        print(
            f"| {order} | {count:,} | {1e9 * spent:.0f} | {1e9 * count * each:.0f} "
            f"| {spent / (count * each):.1f} |"
        )


def tangents(_rounds):
    """Print what a motion with its tangent vectors takes, and how exact its exponents are."""
    print("\n| motion | method | rtol | worst error of a mean rate | s |\n|---|---|---|---|---|")
    stretched(Rotor(omega=1.2, zeta=0.07, delta0=0.5), (0.0, 0.0, 0.0, 0.0), 1e-8, "adams")
    for name, (omega, zeta, delta0, start) in MOTIONS.items():
        rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
        right, _ = stretched(rotor, start, 1e-14, "taylor")
        for method in METHODS_OF_TANGENTS:
            for rtol in (1e-8, 1e-10, 1e-12):
                means, spent = stretched(rotor, start, rtol, method)
                error = np.abs(means - right).max()
                print(f"| {name} | {method} | {rtol:g} | {error:.0e} | {spent:.3f} |", flush=True)


def stretched(rotor, start, rtol, method):
    """Return the mean rates of stretching of one motion, and the seconds that it took."""
    differences = np.ascontiguousarray(np.linalg.qr(np.vander([1.0, 0.7, -0.4, -0.9]))[0])
    asked = RunRequest(
        rotor=rotor, start=start, duration=SPAN, rtol=rtol, atol=ATOL * rtol, method=method,
        bundle=differences,
    )  # fmt: skip
    began = time.process_time()
    stretches, _ = stretch(asked, SPANS)
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
