"""The commands that compute: runs, sweeps, basins, and the paper's figures."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import rotor_ida
from rotor_ida.checks import AT_REST, check_one_varies
from rotor_ida.cli import options
from rotor_ida.cli.machines import Units
from rotor_ida.cli.output import Output, answer, answer_whole, summarised, working
from rotor_ida.cli.parsing import MOST_POINTS, check_points
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.systems import run_up_file, simulate_file, sweep_file
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor

# Number of random initial states of a bifurcation diagram.
STARTS = 8


def simulate(
    system: options.System = None,
    /,
    *,
    rotor: options.RotorOptions = options.RotorOptions(),
    duration: options.Duration,
    start: options.StartOrNone = None,
    samples: options.Samples = None,
    solver: options.AnySolverOptions = options.AnySolverOptions(),
    output: Output = Output(),
) -> Report:
    r"""Simulate a rotor at constant speed, with every contact entry and exit.

    From rest, saved to a file:

        rotor-ida simulate --omega 1.2 --zeta 0.07 --delta0 0.5 --duration 20 \
            --out run.nc

    From a given initial state, drawn to motion.png and motion.svg:

        rotor-ida simulate --omega 1.2 --zeta 0.07 --delta0 0.5 --duration 20 \
            --start 3 0 0 -1 --figure motion

    A rotor of any size with several contacts, from a system file:

        rotor-ida simulate rotor.toml --speed 4300rpm --duration 0.2s --out rub.nc
    """
    if system is not None:
        given = {"duration": duration, "samples": samples}
        return simulate_file(system, rotor, start, solver, output, given)
    chosen, units = rotor.rotor_and_units()
    output.check()
    run = rotor_ida.simulate(
        chosen,
        start=units.start(start or AT_REST),
        duration=units.time(duration),
        samples=samples,
        **options.of_disc(solver),
    )
    return answer(units.shown(run), output, most=FIRST_ROWS)


def run_up(
    system: options.System = None,
    /,
    *,
    rotor: options.RotorOptions = options.RotorOptions(),
    change: options.ChangeOptions = options.ChangeOptions(),
    start: options.StartOrNone = None,
    samples: options.Samples = None,
    solver: options.AnyRunUpSolverOptions = options.AnyRunUpSolverOptions(),
    output: Output = Output(),
) -> Report:
    r"""Simulate a rotor whose speed changes: a ramp, a speed profile, or a drive torque.

    A machine from standstill, as rotor-ida machine writes it:

        rotor-ida run-up --machine pump.toml --to 6000rpm --in 20s

    From --omega up through resonance; a speed profile; and a drive of limited power:

        rotor-ida run-up --omega 0.2 --zeta 0.07 --delta0 0.8 \
            --shaft-stiffness 1 --to 2 --rate 0.05 --out run_up.nc

        rotor-ida run-up --omega 0.5 --zeta 0.07 --delta0 1 \
            --speeds 0:0.5 20:1.5 40:1.5 60:0

        rotor-ida run-up --omega 0.5 --zeta 0.07 --delta0 1 \
            --torque 3 0.5 --inertia 10 --duration 60

    A machine in SI units, from 300 to 3000 rpm; values may have units:

        rotor-ida run-up --mass 4kg --contact-stiffness 3.2e7 --damping 89.1Ns/m \
            --eccentricity 10um --clearance 20um --speed 300rpm --to 3000rpm \
            --rate 9000rpm/s

    A rotor of any size, from a system file:

        rotor-ida run-up rotor.toml --from 600rpm --to 900rpm --in 0.5s
    """
    if system is not None:
        return run_up_file(system, rotor, change, start, solver, output, {"samples": samples})
    chosen = change.beginning(rotor)
    units = Units.of(chosen)
    output.check()
    with working("run-up [%]") as progress:
        run = rotor_ida.run_up(
            chosen if isinstance(chosen, Rotor) else chosen.rotor(),
            start=units.start(start or AT_REST),
            **change.of(chosen),
            samples=samples,
            **options.of_disc(solver),
            progress=progress,
        )
        shown = units.shown(run)
        found = rotor_ida.summary(shown)
    return summarised(found, answer(shown, output, most=FIRST_ROWS))


def sweep(
    system: options.System = None,
    /,
    *,
    rotors: options.RotorsOptions = options.RotorsOptions(),
    start: options.Starts = [AT_REST],  # noqa: B006 - never changed
    direction: options.Direction = None,
    jobs: options.JobOptions = options.JobOptions(),
    solver: options.AnySolverOptions = options.AnySolverOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Simulate the steady-state response over speeds, dampings and clearances.

    From two initial states, at three speeds and two clearances:

        rotor-ida sweep --omega 1.2:2:3 --zeta 0.5 --delta0 0 0.5 \
            --start 0 0 0 0 --start 10 0 0 0 --workers 1 --out sweep.nc

    Quasi-static sweep up and down in speed, with a shaft and under two loads:

        rotor-ida sweep --omega 0.5:3:6 --zeta 0.1 --delta0 1 --direction both \
            --shaft-stiffness 0.25 --load 0 0.3 --figure machine

    A rotor of any size with several contacts, from a system file:

        rotor-ida sweep rotor.toml --speed 1000rpm:5000rpm:9 --out map.nc
    """
    if system is not None:
        given = {"direction": direction, "study": study, **jobs.on_every_core()}
        return sweep_file(system, rotors, start, solver, output, given)
    check_points(*rotors.axes(), start, in_study=study is not None)
    output.check(panels=rotors.panels(over="omega"))
    given, units = rotors.given_and_units()
    units.keep(study)
    with working("sweep", study) as progress:
        dataset = rotor_ida.sweep(
            **given,
            starts=list(map(units.start, start)),
            direction=direction,
            **options.of_disc(solver),
            **jobs.on_every_core(),
            study=study,
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, study)


def bifurcation_diagram(
    *,
    rotors: options.RotorsOptions = options.RotorsOptions(),
    starts: options.StartCount = STARTS,
    start: options.StartsOrNone = None,
    seed: options.Seed = 0,
    reach: options.Reach = None,
    extrema_time: options.ExtremaTime = None,
    direction: options.Direction = None,
    rate: options.RateOrNone = None,
    rtol: options.Rtol = 1e-10,
    atol: options.Atol = 1e-12,
    method: options.ContactMethod = "adams",
    jobs: options.JobOptions = options.JobOptions(),
    output: Output = Output(),
) -> Report:
    r"""Compute a bifurcation diagram: extrema of the radius after the rotor has settled.

    At each speed from four random initial states, drawn over the exact curve:

        rotor-ida bifurcation-diagram --omega 1.6:2:3 --zeta 0.07 --delta0 2 \
            --starts 4 --extrema-time 50 --workers 1 --figure diagram

    Up and down in speed, where each speed starts from the state of the one before:

        rotor-ida bifurcation-diagram --omega 1.2:1.7:3 --zeta 0.1 --delta0 0.5 \
            --start 0 0 0 0 --direction both --workers 1 --csv diagram.csv
    """
    if start is not None and starts != STARTS:
        raise InputError(f"starts must be left out with --start, got {starts}")
    check_points(*rotors.axes(), start or [AT_REST] * starts)
    output.check()
    if output.figure is not None:
        check_one_varies([name for name, each in rotors.values.items() if len(each) > 1])
    given, units = rotors.given_and_units()
    if reach is not None:
        given["reach"] = units.component("x", reach)
    if extrema_time is not None:
        given["extrema_time"] = units.time(extrema_time)
    with working("diagram") as progress:
        dataset = rotor_ida.bifurcation_diagram(
            **given,
            starts=starts if start is None else list(map(units.start, start)),
            seed=seed,
            direction=direction,
            rate=None if rate is None else units.rate(rate),
            rtol=rtol,
            atol=atol,
            method=method,
            **jobs.on_every_core(),
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, None)


def run_ups(
    *,
    rotors: options.RotorsOptions = options.RotorsOptions(),
    to: options.ToSpeed,
    rate: options.Rates,
    phase: options.Phases = [0.0],  # noqa: B006 - never changed
    start: options.Starts = [AT_REST],  # noqa: B006 - never changed
    jobs: options.JobOptions = options.JobOptions(),
    solver: options.RunUpSolverOptions = options.RunUpSolverOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Simulate run-ups or run-downs at many rates, and summarise each.

    Through the critical speed of a shaft, at three rates and two clearances:

        rotor-ida run-ups --omega 0.3 --to 1.6 --rate 0.005 0.05 0.5 --zeta 0.1 \
            --delta0 1 2 --shaft-stiffness 1 --workers 1 --out run_ups.nc

    Run-down under a load, for eight initial angles of the unbalance:

        rotor-ida run-ups --omega 2 --to 0.5 --rate -0.1 --zeta 0.1 --delta0 1 \
            --shaft-stiffness 1 --load 0.2 --start 0 -0.2 0 0 --phase 0:5.5:8 \
            --workers 1 --figure run_ups
    """
    check_points(*rotors.axes(), rate, phase, start, in_study=study is not None)
    output.check(panels=rotors.panels())
    given, units = rotors.given_and_units()
    units.keep(study)
    with working("run-ups", study) as progress:
        dataset = rotor_ida.run_ups(
            **given,
            to=units.speed(to),
            rate=list(map(units.rate, rate)),
            phase=phase,
            starts=list(map(units.start, start)),
            **asdict(solver),
            **jobs.on_every_core(),
            study=study,
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, study)


def basin(
    *,
    rotor: options.RotorOptions = options.RotorOptions(),
    x: options.Component,
    y: options.Component,
    vx: options.Component = 0.0,
    vy: options.Component = 0.0,
    rtol: options.RtolOrNone = None,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Compute basins of attraction on a plane of initial states.

    Two components of the initial state are ranges; here the velocities are 0:

        rotor-ida basin --omega 1.7 --zeta 0.07 --delta0 0 \
            --x=-15:15:64 --y=-15:15:64 --out basin.nc

    After an interrupt (exit status 130) the rest of the result is marked as not computed.
    """
    axes = [part for part in (x, y, vx, vy) if isinstance(part, list)]
    check_points(*axes, in_study=study is not None)
    output.check()
    chosen, units = rotor.rotor_and_units()
    units.keep(study)
    with working("basin", study) as progress:
        dataset = rotor_ida.basin(
            chosen,
            x=units.component("x", x),
            y=units.component("y", y),
            vx=units.component("vx", vx),
            vy=units.component("vy", vy),
            rtol=rtol,
            **asdict(jobs),
            study=study,
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, study)


def basin_fractions(
    *,
    rotor: options.RotorOptions = options.RotorOptions(),
    x: options.Range,
    y: options.Range,
    vx: options.Range = 0.0,
    vy: options.Range = 0.0,
    starts: options.StartCount = 10_000,
    seed: options.Seed = 0,
    rtol: options.RtolOrNone = None,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    out: options.Out = None,
    csv: options.Csv = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    r"""Estimate basin fractions from random initial states.

    From a square of initial states, saved in a folder as they are computed:

        rotor-ida basin-fractions --omega 2 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --starts 2000 --study study
    """
    output = Output(out=out, csv=csv, as_json=as_json, force=force)
    output.check()
    if study is None and starts > MOST_POINTS:
        raise InputError(f"starts must be at most {MOST_POINTS} without --study, got {starts}")
    chosen, units = rotor.rotor_and_units()
    units.keep(study)
    with working("fractions", study) as progress:
        dataset = rotor_ida.basin_fractions(
            chosen,
            x=units.component("x", x),
            y=units.component("y", y),
            vx=units.component("vx", vx),
            vy=units.component("vy", vy),
            starts=starts,
            seed=seed,
            rtol=rtol,
            **asdict(jobs),
            study=study,
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, study)


def continue_attractors(
    *,
    rotors: options.RotorsOptions = options.RotorsOptions(),
    drawn: options.DrawnOptions = options.DrawnOptions(),
    shocks: options.ShockCount = 0,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Continue all attractors over speed, damping or clearance, with their basin fractions.

    Over 15 speeds, drawn as basin fractions:

        rotor-ida continue-attractors --omega 0.2:3:8 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --starts 200 --out atlas.nc --figure atlas
    """
    output.check()
    if output.figure is not None:
        options.check_varies(rotors.panels())
    given, units = rotors.given_and_units()
    units.keep(study)
    with working("atlas", study) as progress:
        dataset = rotor_ida.continue_attractors(
            **given,
            **drawn.of(units),
            shocks=shocks,
            **asdict(jobs),
            study=study,
            progress=progress,
        )
        return answer_whole(units.shown(dataset), output, study)


def touchdown_report(
    *,
    rotor: options.RotorOptions = options.RotorOptions(),
    drawn: options.DrawnOptions = options.DrawnOptions(),
    shocks: options.ShocksOrNone = None,
    output: Output = Output(),
) -> Report:
    r"""Report the loads, basin fraction and shock resistance of each attractor.

    In SI units, from initial displacements within 15 um:

        rotor-ida touchdown-report --mass 4kg --contact-stiffness 1e9 \
            --damping 280 --eccentricity 1um --clearance 2um --speed 1000 \
            --x=-15um:15um --y=-15um:15um

    Dimensionless, without shocks:

        rotor-ida touchdown-report --omega 2 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --shocks 0 --json

    Drops of a horizontal rotor, whose starts are followed one by one:

        rotor-ida touchdown-report --omega 2 --zeta 0.05 --delta0 1 \
            --shaft-stiffness 0.25 --load 0.6 --x=-1:1 --y=-1:1 --starts 50
    """
    chosen = rotor.chosen()
    output.check()
    report = rotor_ida.touchdown_report(chosen, **asdict(drawn), shocks=shocks)
    return answer(report, output)


def reproduce(
    *,
    out: options.Results = Path("results"),
    quick: options.Quick = False,
    studies: options.Studies = False,
    only: options.Names = None,
    workers: options.Workers = None,
    force: options.Force = False,
) -> int:
    """Reproduce the figures of the paper and, on request, all studies, as a page index.html.

    Results that are up to date are kept. One scenario, coarse but quick:

        rotor-ida reproduce --only fig06_jumps --quick --out results
    """
    from rotor_ida.paper import reproduction  # noqa: PLC0415 - heavy, and not for --help

    return reproduction.reproduce(
        out, quick=quick, studies=studies, only=only, workers=workers, force=force
    )
