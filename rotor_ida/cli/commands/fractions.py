"""The command shares."""

from __future__ import annotations

import rotor_ida
from rotor_ida.checks import LARGEST_SEED
from rotor_ida.cli import options, parsing
from rotor_ida.cli.progress import progress
from rotor_ida.cli.report import Report
from rotor_ida.cli.studied import studied
from rotor_ida.cli.targets import check_targets


def fractions(
    *,
    omega: options.Omega,
    zeta: options.Zeta,
    delta0: options.Delta0,
    x: options.Range,
    y: options.Range,
    vx: options.Range = "0",
    vy: options.Range = "0",
    starts: options.StartCount = "10000",
    seed: options.Seed = "0",
    rtol: options.Rtol = "1e-06",
    workers: options.Workers = None,
    executor: options.Executor = "auto",
    study: options.Study = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Say which parts of random starts end on which attractor.

    Of starts drawn from a square, kept in a folder as they are done:

        rotor-ida fractions --omega 2 --zeta 0.07 --delta0 2 --x=-15:15 --y=-15:15 \
            --starts 2000 --study study
    """
    targets = check_targets(out=out, study=study, force=force)
    drawn = {
        name: parsing.number_or_ends(name, word)
        for name, word in (("x", x), ("y", y), ("vx", vx), ("vy", vy))
    }
    most = parsing.MOST_POINTS if study is None else parsing.MOST_POINTS_OF_STUDY
    count = parsing.whole_number("starts", starts, 1, most)
    from rotor_ida.cli.endings import answered  # noqa: PLC0415 - heavy, and not for --help

    rotor = rotor_ida.Rotor(
        omega=parsing.number("omega", omega),
        zeta=parsing.number("zeta", zeta),
        delta0=parsing.number("delta0", delta0),
    )
    with studied(study):
        with progress("fractions") as told:
            dataset = rotor_ida.basin_fractions(
                rotor,
                x=drawn["x"],
                y=drawn["y"],
                vx=drawn["vx"],
                vy=drawn["vy"],
                starts=count,
                seed=parsing.whole_number("seed", seed, 0, LARGEST_SEED),
                rtol=parsing.number("rtol", rtol),
                workers=parsing.workers(workers),
                executor=executor,
                study=study,
                progress=told,
            )
        return answered(dataset, targets, as_json=as_json)
