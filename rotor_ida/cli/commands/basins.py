"""The command basin."""

from __future__ import annotations

import rotor_ida
from rotor_ida.cli import options, parsing
from rotor_ida.cli.progress import progress
from rotor_ida.cli.report import Report
from rotor_ida.cli.studied import studied
from rotor_ida.cli.targets import check_targets


def basin(
    *,
    omega: options.Omega,
    zeta: options.Zeta,
    delta0: options.Delta0,
    x: options.Component,
    y: options.Component,
    vx: options.Component = "0",
    vy: options.Component = "0",
    rtol: options.Rtol = "1e-06",
    workers: options.Workers = None,
    executor: options.Executor = "auto",
    study: options.Study = None,
    out: options.Out = None,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Say for every start of a plane on which attractor the rotor ends.

    Two components of the start are ranges, two are numbers; here the velocities are 0:

        rotor-ida basin --omega 1.7 --zeta 0.07 --delta0 0 \
            --x=-15:15:64 --y=-15:15:64 --out basin.nc

    Interrupted, it writes what is done; with status 130 the rest is marked as not computed.
    """
    start = {
        name: parsing.number_or_range(name, word)
        for name, word in (("x", x), ("y", y), ("vx", vx), ("vy", vy))
    }
    axes = [part for part in start.values() if isinstance(part, list)]
    parsing.check_points(*axes, in_study=study is not None)
    targets = check_targets(out=out, study=study, figure=figure, force=force)
    from rotor_ida.cli.endings import answered  # noqa: PLC0415 - heavy, and not for --help

    rotor = rotor_ida.Rotor(
        omega=parsing.number("omega", omega),
        zeta=parsing.number("zeta", zeta),
        delta0=parsing.number("delta0", delta0),
    )
    with studied(study):
        with progress("basin") as told:
            dataset = rotor_ida.basin(
                rotor,
                x=start["x"],
                y=start["y"],
                vx=start["vx"],
                vy=start["vy"],
                rtol=parsing.number("rtol", rtol),
                workers=parsing.workers(workers),
                executor=executor,
                study=study,
                progress=told,
            )
        return answered(dataset, targets, as_json=as_json)
