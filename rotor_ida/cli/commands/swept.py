"""The command sweep."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import rotor_ida
from rotor_ida.cli import options, parsing
from rotor_ida.cli.progress import progress
from rotor_ida.cli.report import Report
from rotor_ida.cli.studied import studied
from rotor_ida.cli.targets import check_targets

if TYPE_CHECKING:
    from rotor_ida.simulation.options import Backend, Flight, Method
    from rotor_ida.sweeps.sweep import Direction


def sweep(
    *,
    omega: options.Omegas,
    zeta: options.Zetas,
    delta0: options.Delta0s,
    start: options.Starts = ["0 0 0 0"],  # noqa: B006 - never changed
    direction: options.Direction = None,
    workers: options.Workers = None,
    executor: options.Executor = "auto",
    rtol: options.Rtol = "1e-10",
    atol: options.Atol = "1e-12",
    method: options.Method = "adams",
    flight: options.Flight = "exact",
    backend: options.Backend = "auto",
    study: options.Study = None,
    out: options.Out = None,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Follow the rotor at every speed, damping and clearance until it has settled.

    From rest and from far out, at three speeds and two clearances:

        rotor-ida sweep --omega 1.2:2:3 --zeta 0.5 --delta0 0 0.5 \
            --start 0 0 0 0 --start 10 0 0 0 --workers 1 --out sweep.nc
    """
    axes = [
        parsing.numbers(name, words)
        for name, words in (("omega", omega), ("zeta", zeta), ("delta0", delta0))
    ]
    starts = [parsing.state("start", words.split()) for words in start]
    parsing.check_points(*axes, starts, in_study=study is not None)
    count = parsing.workers(workers)
    panels = len(axes[1]) * len(axes[2])
    targets = check_targets(out=out, study=study, figure=figure, panels=panels, force=force)
    from rotor_ida.cli.endings import answered  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.parallel import count_workers  # noqa: PLC0415

    with studied(study):
        with progress("sweep") as told:
            dataset = rotor_ida.sweep(
                omega=axes[0],
                zeta=axes[1],
                delta0=axes[2],
                starts=starts,
                direction=cast("Direction | None", direction),
                rtol=parsing.number("rtol", rtol),
                atol=parsing.number("atol", atol),
                method=cast("Method", method),
                flight=cast("Flight", flight),
                backend=cast("Backend", backend),
                # The program guards its main part: all cores, whatever the backend.
                workers=count_workers(None) if count is None and executor == "auto" else count,
                executor=executor,
                study=study,
                progress=told,
            )
        return answered(dataset, targets, as_json=as_json)
