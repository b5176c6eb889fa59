"""The command sweep."""

from __future__ import annotations

from typing import Annotated, Literal

from cyclopts import Parameter

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer_whole, working
from rotor_ida.cli.parsing import check_points
from rotor_ida.cli.report import Report

Direction = Annotated[
    Literal["up", "down", "both"] | None,
    Parameter(help="Follow the response from speed to speed."),
]


def sweep(
    *,
    omega: options.Omegas,
    zeta: options.Zetas,
    delta0: options.Delta0s,
    start: options.Starts = [options.REST],  # noqa: B006 - never changed
    direction: Direction = None,
    jobs: options.JobOptions = options.JobOptions(),
    solver: options.SolverOptions = options.SolverOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Follow the rotor at every speed, damping and clearance until it has settled.

    From rest and from far out, at three speeds and two clearances:

        rotor-ida sweep --omega 1.2:2:3 --zeta 0.5 --delta0 0 0.5 \
            --start 0 0 0 0 --start 10 0 0 0 --workers 1 --out sweep.nc
    """
    check_points(omega, zeta, delta0, start, in_study=study is not None)
    output.check(panels=len(zeta) * len(delta0))
    from rotor_ida.parallel import count_workers  # noqa: PLC0415 - heavy, and not for --help

    # The program guards its main part: all cores, whatever the backend.
    every_core = jobs.workers is None and jobs.executor == "auto"
    with working("sweep", study) as progress:
        dataset = rotor_ida.sweep(
            omega=omega,
            zeta=zeta,
            delta0=delta0,
            starts=start,
            direction=direction,
            rtol=solver.rtol,
            atol=solver.atol,
            method=solver.method,
            flight=solver.flight,
            backend=solver.backend,
            workers=count_workers(None) if every_core else jobs.workers,
            executor=jobs.executor,
            study=study,
            progress=progress,
        )
        return answer_whole(dataset, output, study)
