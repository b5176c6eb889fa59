"""The command simulate."""

from __future__ import annotations

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer
from rotor_ida.cli.report import Report

FIRST_ROWS = 10


def simulate(
    *,
    rotor: options.RotorOptions,
    duration: options.Duration,
    start: options.Start = options.REST,
    samples: options.Samples = 1001,
    solver: options.SolverOptions = options.SolverOptions(),
    output: Output = Output(),
) -> Report:
    r"""Simulate one rotor from one start, with every contact entry and exit.

    From rest, with the result kept in a file:

        rotor-ida simulate --omega 1.2 --zeta 0.07 --delta0 0.5 --duration 20 \
            --out run.nc

    From a start of its own, drawn into motion.png and motion.svg:

        rotor-ida simulate --omega 1.2 --zeta 0.07 --delta0 0.5 --duration 20 \
            --start 3 0 0 -1 --figure motion
    """
    output.check()
    run = rotor_ida.simulate(
        rotor.rotor(),
        start=start,
        duration=duration,
        samples=samples,
        rtol=solver.rtol,
        atol=solver.atol,
        method=solver.method,
        flight=solver.flight,
        backend=solver.backend,
    )
    return answer(run, output, most=FIRST_ROWS)
