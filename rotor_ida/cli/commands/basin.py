"""The commands basin and fractions: where the starts of a plane, or random starts, end."""

from __future__ import annotations

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer_whole, working
from rotor_ida.cli.parsing import MOST_POINTS, check_points
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError


def basin(
    *,
    rotor: options.RotorOptions,
    x: options.Component,
    y: options.Component,
    vx: options.Component = 0.0,
    vy: options.Component = 0.0,
    rtol: options.Rtol = 1e-6,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Say for every start of a plane on which attractor the rotor ends.

    Two components of the start are ranges, two are numbers; here the velocities are 0:

        rotor-ida basin --omega 1.7 --zeta 0.07 --delta0 0 \
            --x=-15:15:64 --y=-15:15:64 --out basin.nc

    Interrupted, it writes what is done; with status 130 the rest is marked as not computed.
    """
    axes = [part for part in (x, y, vx, vy) if isinstance(part, list)]
    check_points(*axes, in_study=study is not None)
    output.check()
    with working("basin", study) as progress:
        dataset = rotor_ida.basin(
            rotor.rotor(),
            x=x,
            y=y,
            vx=vx,
            vy=vy,
            rtol=rtol,
            workers=jobs.workers,
            executor=jobs.executor,
            study=study,
            progress=progress,
        )
        return answer_whole(dataset, output, study)


def fractions(
    *,
    rotor: options.RotorOptions,
    x: options.Range,
    y: options.Range,
    vx: options.Range = 0.0,
    vy: options.Range = 0.0,
    starts: options.StartCount = 10_000,
    seed: options.Seed = 0,
    rtol: options.Rtol = 1e-6,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    out: options.Out = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Say which fraction of random starts ends on which attractor.

    Of starts drawn from a square, kept in a folder as they are done:

        rotor-ida fractions --omega 2 --zeta 0.07 --delta0 2 --x=-15:15 --y=-15:15 \
            --starts 2000 --study study
    """
    output = Output(out=out, as_json=as_json, force=force)
    output.check()
    if study is None and starts > MOST_POINTS:
        raise InputError(f"starts must be at most {MOST_POINTS} without --study, got {starts}")
    with working("fractions", study) as progress:
        dataset = rotor_ida.basin_fractions(
            rotor.rotor(),
            x=x,
            y=y,
            vx=vx,
            vy=vy,
            starts=starts,
            seed=seed,
            rtol=rtol,
            workers=jobs.workers,
            executor=jobs.executor,
            study=study,
            progress=progress,
        )
        return answer_whole(dataset, output, study)
