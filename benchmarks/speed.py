"""How fast this program is, beside others: ratios measured in turn, as a table in Markdown.

Two runs of 100 revolutions with 2,001 samples at rtol 1e-9 and atol 1e-11: full contact (omega
1.2, zeta 0.07, delta0 0.5, from rest) and bouncing (omega 2, zeta 0.07, delta0 2, from rest, 137
events). Beside them stand

- this program called from Python, ``backend="python"``, bare and as `simulate`;
- its Taylor series, bare and as `simulate`, at the loosest tolerance at which their worst state
  error is no larger than CVODE's (errors are taken against Taylor series at rtol 1e-15);
- the same algorithm written in C over the same SUNDIALS libraries (needs a C compiler);
- SciPy's DOP853 with an event function, at equal error likewise;
- heyoka at equal error (needs the extra ``bench``). Its Taylor series cannot cross the
  kink of the contact law, so the third run, in contact throughout, is the one to compare it on.

    pip install -e '.[bench]' && python benchmarks/speed.py

`--only machines` sets machines with shaft, contact damping, load and friction beside the paper's
rotor, all bouncing for 200 revolutions, by Taylor series: what it takes, for each event.
`--only run-ups` sets each of them at a speed that changes beside itself at constant speed.
"""

import argparse
import importlib.util
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from functools import partial

import c_program
import numpy as np
import ways
from measuring import ROUNDS, clocked, in_turn, machine, ratio
from ways import ATOL, Case, at_equal_error, errors

from rotor_ida import simulate
from rotor_ida.simulation.dataset import run_dataset
from rotor_ida.simulation.event_errors import estimate_event_errors
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from rotor_ida.simulation.spin import through

RTOL = 1e-9
TOLERANCES = [10.0 ** (-power / 4.0) for power in range(20, 53)]
BASE, WHOLE = "compiled, bare run", "compiled, `simulate`"
PYTHON, PYTHON_WHOLE = "python, bare run", "python, `simulate`"
TAYLOR, TAYLOR_WHOLE = "Taylor, bare run", "Taylor, `simulate`"
IN_C, DOP853 = "C, same libraries", "SciPy DOP853"
SHORT = Case("bouncing, shorter", 2.0, 0.07, 2.0, revolutions=32.0, samples=1001)
# Event times of the C program may differ by this, or by the error that they have anyway.
SAME_EVENT = 1e-9


def whole(case, backend="auto", method="adams", rtol=RTOL):
    """Return `simulate` as a function without arguments: two runs and the labels."""
    return partial(
        simulate,
        case.rotor,
        start=case.start,
        duration=case.duration,
        samples=case.samples,
        rtol=rtol,
        atol=ATOL * rtol,
        backend=backend,
        method=method,
    )


def others(case, wanted):
    """Return name, tolerance and way of each other program at equal error."""
    makes = {DOP853: ways.dop853, "scikit-sundae, plainly": ways.sundae}
    if importlib.util.find_spec("heyoka"):
        makes["heyoka"] = ways.heyoka
        makes["heyoka, with events"] = partial(ways.heyoka, events=True)
    for name, make in makes.items():
        rtol = at_equal_error(make, case, wanted, TOLERANCES)
        yield name, rtol, make(case, rtol)


def measure(case, program, rounds):
    """Print the table of one run."""
    way = ways.compiled(case, RTOL)
    wanted, of_time = errors(case, way())
    rows = {BASE: (RTOL, wanted, of_time), WHOLE: (RTOL, wanted, of_time)}
    clocks = {BASE: clocked(way), WHOLE: clocked(whole(case, "compiled"))}
    slow = ways.python(case, RTOL)
    rows[PYTHON] = rows[PYTHON_WHOLE] = (RTOL, *errors(case, slow()))
    clocks[PYTHON] = clocked(slow)
    clocks[PYTHON_WHOLE] = clocked(whole(case, "python"))
    rtol = at_equal_error(ways.taylor, case, wanted, TOLERANCES)
    series = ways.taylor(case, rtol)
    rows[TAYLOR] = rows[TAYLOR_WHOLE] = (rtol, *errors(case, series()))
    clocks[TAYLOR] = clocked(series)
    clocks[TAYLOR_WHOLE] = clocked(whole(case, method="taylor", rtol=rtol))
    if program:
        rows[IN_C] = (RTOL, math.nan, against_c(case, program))
        clocks[IN_C] = c_program.clock(program, case, RTOL)
    for name, rtol, other in others(case, wanted):
        rows[name] = (rtol, *errors(case, other()))
        clocks[name] = clocked(other)
    show(case, rows, in_turn(clocks, rounds))


def show(case, rows, times):
    """Print the table of one run, and what it says, in one line."""
    events = ways.reference(case).event_times.size
    print(
        f"\n**{case.name}**: omega {case.omega:g}, zeta {case.zeta:g}, delta0 {case.delta0:g}, "
        f"{case.revolutions:g} revolutions, {case.samples:,} samples, events: {events}\n"
    )
    print("| way | rtol | state error | event time error | ms | times compiled | by the clock |")
    print("|---|---|---|---|---|---|---|")
    said = {}
    for name, (rtol, of_state, of_event) in rows.items():
        base = WHOLE if name == PYTHON_WHOLE else BASE
        cpu, wall = said[name] = ratio(times[name], times[base])
        print(
            f"| {name} | {rtol:.1e} | {number(of_state)} | {number(of_event)} "
            f"| {1e3 * times[name].median:.2f} | {cpu:.2f} | {wall:.2f} |"
        )
    in_c = f" and takes {1.0 / said[IN_C][0]:.2f} times what C takes" if IN_C in said else ""
    print(
        f"\nCompiled is {said[PYTHON][0]:.0f} times as fast as Python ({said[PYTHON_WHOLE][0]:.0f} "
        f"as `simulate`), {said[DOP853][0]:.0f} times as fast as DOP853 at equal error{in_c}.",
        flush=True,
    )


def number(error):
    """Return an error as text."""
    return "" if math.isnan(error) else f"{error:.0e}"


def against_c(case, program):
    """Return the error of the C program's event times; raise where it finds other events.

    Rounding alone makes an adaptive solver choose other steps: from there on the two differ by
    what the tolerance leaves open. At a tight tolerance they must come together.
    """
    for rtol in (RTOL, 1e-12):
        options = Options(rtol=rtol, atol=ATOL * rtol, backend="compiled")
        orbit = run(case.rotor, case.start, case.duration, case.times, options)
        apart = c_program.difference(program, case, rtol, orbit)
        _, own = errors(case, (orbit.states, orbit.event_times))
        print(f"\nC beside compiled, rtol {rtol:g}: event times apart by at most {apart:.1e}")
        if not apart <= max(SAME_EVENT, own):
            raise SystemExit(f"the C program finds other events in the run '{case.name}'")
    return c_program.difference(program, case, RTOL, ways.reference(case))


def labels(rounds):
    """Print what `simulate` takes beyond its bare run by Taylor series: errors and labels."""
    print(
        "\n| by Taylor series | samples | events | bare run, ms | `simulate`, ms | to label, ms "
        "| times bare |\n|---|---|---|---|---|---|---|"
    )
    for case in (ways.FULL_CONTACT, ways.BOUNCING, SHORT):
        options = Options(rtol=RTOL, atol=ATOL * RTOL, method="taylor")
        orbit = run(case.rotor, case.start, case.duration, case.times, options)
        known = estimate_event_errors(orbit, case.start)
        clocks = {
            "bare": clocked(ways.taylor(case, RTOL)),
            "whole": clocked(whole(case, method="taylor")),
            "labels": clocked(partial(run_dataset, orbit, case.start, known)),
        }
        clocks["whole"](1)  # the first call imports
        times = in_turn(clocks, rounds)
        bare, together, labelling = (f"{1e3 * times[name].median:.2f}" for name in clocks)
        print(
            f"| {case.name} | {case.samples:,} | {orbit.event_times.size} | {bare} | {together} "
            f"| {labelling} | {ratio(times['whole'], times['bare'])[1]:.2f} |",
            flush=True,
        )


OF_PAPER = "the paper's"
# What is added to the bouncing rotor: so little that it bounces as often.
MACHINES = {
    OF_PAPER: {},
    "shaft": {"shaft_stiffness": 0.02},
    "load": {"load": 0.02},
    "contact damping": {"contact_damping": 0.01},
    "all three": {"shaft_stiffness": 0.02, "load": 0.02, "contact_damping": 0.01},
    "friction": {"friction": 0.001, "disc_radius": 10.0},
}


def machines(rounds):
    """Print what a machine takes beside the paper's rotor, run by run and event by event."""
    print(
        "\n| machine, by Taylor series | samples | events | ms | ms, least | times the paper's, "
        "an event | least |\n|---|---|---|---|---|---|---|"
    )
    case = replace(ways.BOUNCING, revolutions=200.0)
    options = Options(rtol=RTOL, atol=ATOL * RTOL, method="taylor")
    for samples in (2, case.samples):
        asked = np.linspace(0.0, case.duration, samples)
        clocks, events = {}, {}
        for name, more in MACHINES.items():
            machine = replace(case.rotor, **more)
            way = partial(run, machine, case.start, case.duration, asked, options)
            events[name] = way().event_times.size
            clocks[name] = clocked(way)
        times = in_turn(clocks, rounds)
        for name, each in times.items():
            paper = times[OF_PAPER]
            share = events[OF_PAPER] / events[name]
            median = share * ratio(each, paper)[0]
            least = share * min(each.cpu) / min(paper.cpu)
            print(
                f"| {name} | {samples:,} | {events[name]} | {1e3 * each.median:.2f} "
                f"| {1e3 * min(each.cpu):.2f} | {median:.2f} | {least:.2f} |",
                flush=True,
            )


# So slow that it bounces as often as at constant speed.
SLOW_RATE = 1e-9


def run_ups(rounds):
    """Print what a run-up of a prescribed speed takes beside a run at constant speed."""
    print(
        "\n| run-up, by Taylor series | samples | events | of the other | ms | times a run at "
        "constant speed, an event | least |\n|---|---|---|---|---|---|---|"
    )
    case = replace(ways.BOUNCING, revolutions=200.0)
    options = Options(rtol=RTOL, atol=ATOL * RTOL, method="taylor")
    for samples in (2, case.samples):
        asked = np.linspace(0.0, case.duration, samples)
        for name, more in MACHINES.items():
            machine = replace(case.rotor, **more)
            way = partial(run, machine, case.start, case.duration, asked, options)
            course = through([(0.0, machine.omega), (case.duration, machine.omega
                              + SLOW_RATE * case.duration)], case.duration)  # fmt: skip
            found = {"steady": way, "changing": partial(way, profile=course)}
            events = {each: go().event_times.size for each, go in found.items()}
            times = in_turn({each: clocked(go) for each, go in found.items()}, rounds)
            share = events["steady"] / events["changing"]
            median = share * ratio(times["changing"], times["steady"])[0]
            least = share * min(times["changing"].cpu) / min(times["steady"].cpu)
            print(
                f"| {name} | {samples:,} | {events['changing']} | {events['steady']} "
                f"| {1e3 * times['changing'].median:.2f} | {median:.2f} | {least:.2f} |",
                flush=True,
            )


FIRST = (
    "from rotor_ida import Rotor, simulate; simulate(Rotor(omega=1.2, zeta=0.07, delta0=0.5), "
    "start=(0, 0, 0, 0), duration=100.0)"
)
PROGRAM = "import sys; from rotor_ida.cli import main"
ONE_RUN = ["--omega", "1.2", "--zeta", "0.07", "--delta0", "0.5", "--duration", "100"]
COMMANDS = (
    ["--help"],
    ["simulate", *ONE_RUN],
    ["simulate", *ONE_RUN, "--method", "taylor"],
)
PROCESSES = {
    "python -c pass": ["-c", "pass"],
    "import numpy, xarray": ["-c", "import numpy, xarray"],
    "import rotor_ida": ["-c", "import rotor_ida"],
    "import, and a first simulate": ["-c", FIRST],
    **{
        " ".join(["rotor-ida", *words]): ["-c", f"{PROGRAM}; sys.exit(main())", *words]
        for words in COMMANDS
    },
}


def processes(rounds):
    """Print what whole processes take, from their start to their end, in turn."""
    found = {name: ([], []) for name in PROCESSES}
    for turn in range(rounds + 1):
        for name, arguments in PROCESSES.items():
            wall, spent = time.perf_counter(), os.times()
            subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
            after = os.times()
            if turn:
                found[name][0].append(time.perf_counter() - wall)
                found[name][1].append(sum(after[2:4]) - sum(spent[2:4]))
    print("\n| whole process | s of processor | s by the clock |\n|---|---|---|")
    for name, (wall, cpu) in found.items():
        print(f"| `{name}` | {statistics.median(cpu):.2f} | {statistics.median(wall):.2f} |")


def main():
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--only", choices=("runs", "labels", "machines", "run-ups", "processes"))
    arguments = parser.parse_args()
    print(f"{machine()}\n\nMedians of {arguments.rounds} rounds, in turn.")
    if arguments.only in {None, "runs"}:
        with tempfile.TemporaryDirectory() as folder:
            program = None
            try:
                program = c_program.build(folder)
            except c_program.NoProgramError as reason:
                print(f"\nNo comparison with C: {reason}")
            cases: list[Case] = [ways.FULL_CONTACT, ways.BOUNCING, ways.in_contact_from_start()]
            for case in cases:
                measure(case, program, arguments.rounds)
    if arguments.only in {None, "labels"}:
        labels(arguments.rounds)
    if arguments.only in {None, "machines"}:
        machines(arguments.rounds)
    if arguments.only in {None, "run-ups"}:
        run_ups(arguments.rounds)
    if arguments.only in {None, "processes"}:
        processes(arguments.rounds)


if __name__ == "__main__":
    main()
