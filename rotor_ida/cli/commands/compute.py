"""The commands that simulate: runs and run-ups, one or many, and the paper's figures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import AT_REST, MOST_NUMBERS, check_one_varies
from rotor_ida.cli import options, parsing
from rotor_ida.cli.machines import REST
from rotor_ida.cli.option_types import (
    IN_OUTPUT,
    IN_ROTOR,
    count_option,
    flag_option,
    number_option,
    numbers_option,
    path_option,
    quantity_option,
)
from rotor_ida.cli.output import Output, answer, answer_whole, summarised, working
from rotor_ida.cli.parsing import check_points
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.rotor_options import RotorOptions, RotorsOptions
from rotor_ida.cli.systems import (
    run_up_file,
    run_ups_file,
    section_file,
    simulate_file,
    sweep_file,
)
from rotor_ida.errors import InputError
from rotor_ida.model.scales import BECOMES

# Number of random initial states of a bifurcation diagram.
STARTS = 8
ExtremaTime = Annotated[
    float | None,
    quantity_option(
        "Time over which extrema are found (SI: s). Default: 100 / reference frequency.", "s"
    ),
]
Duration = Annotated[float, quantity_option("Time to simulate (SI: s).", "s")]
ToSpeed = Annotated[
    float, quantity_option("Final speed of the ramps (SI: rad/s, or as 3000rpm).", "rad s-1")
]
Rates = Annotated[
    list[float],
    numbers_option(
        "Rates of change of the speed (SI: rad/s2, or as 100rpm/s): numbers, or START:STOP:COUNT.",
        "rad s-2",
    ),
]
RateOrNone = Annotated[
    float | None,
    quantity_option(
        "Rate of change of the speed (SI: rad/s2, or as 100rpm/s), with --direction. Default: "
        "the rotor settles at each speed.",
        "rad s-2",
    ),
]
Phases = Annotated[
    list[float],
    Parameter(
        help="Angles of the unbalance at time 0, in radians: numbers, or START:STOP:COUNT. "
        "Default: 0.",
        converter=parsing.converter(parsing.numbers),
        consume_multiple=True,
        negative=(),
        show_default=False,
    ),
]
Samples = Annotated[
    int | None,
    count_option("Number of output times. Default: at least 32 per revolution.", 2, MOST_NUMBERS),
]
Results = Annotated[Path, path_option("Folder for archives and figures."), IN_OUTPUT]
Direction = Annotated[
    Literal["up", "down", "both"] | None,
    Parameter(help="Quasi-static sweep: start each speed where the one before ended."),
]
Events = Annotated[bool, flag_option("Keep the contact events of all runs, in one table.")]
_ALONG = Parameter(
    help="Parameter that rises or falls with --direction; for a machine speed, damping or "
    "clearance replace omega, zeta or delta0. Default: the speed, or else the only one with "
    "several values."
)
AlongEither = Annotated[options.OfRotor | None, _ALONG]
StiffnessFactors = Annotated[
    list[float] | None,
    numbers_option(
        "Factors of the stiffness of a rotor system with its supports, as --damping is of its "
        "damping: numbers, or START:STOP:COUNT."
    ),
    IN_ROTOR,
]
Unbalances = Annotated[
    list[float] | None,
    numbers_option(
        "Largest unbalance of a rotor system (SI: kg m), to which all others keep their ratios, as "
        "--clearance and --friction are of its contacts: numbers, or START:STOP:COUNT.",
        "kg m",
    ),
    IN_ROTOR,
]
InitialSpeeds = Annotated[
    list[float] | None,
    numbers_option(
        "Initial speeds (SI: rad/s, or as 300rpm), in place of --omega or --speed.",
        "rad s-1",
        name="--from",
    ),
]
Shown = Annotated[
    Literal["extrema", "revolution"],
    Parameter(help="What is shown of settled motions: extrema of the radius, or states once a "
              "revolution."),
]  # fmt: skip
Crossed = Annotated[
    Literal["revolution", "entry", "exit", "peak", "roll", "slip", "reverse"],
    Parameter(help="Where the section is: once a revolution, at contact events, or at peaks."),
]
ContactOfSection = Annotated[
    str | None,
    Parameter(
        help="Contact of a rotor system whose events or peaks are meant: number or node.",
        metavar="NUMBER|NODE",
    ),
]
Phase = Annotated[
    float, number_option("Angle of the unbalance from x in a section by revolutions, in radians.")
]
Revolutions = Annotated[
    int | None,
    count_option(
        "Number of revolutions of a section, or for extrema of a rotor system. Default: 64.",
        1, MOST_NUMBERS,
    ),
]  # fmt: skip
RevolutionsOfSection = Annotated[
    int, count_option("Number of revolutions of the section.", 1, MOST_NUMBERS)
]
Skip = Annotated[
    int, count_option("Number of earlier revolutions to skip as a transient.", 0, MOST_NUMBERS)
]
StartCount = Annotated[
    int | None,
    count_option(
        "Number of random initial states of one disc. Default: 8.", 1, parsing.MOST_POINTS_OF_STUDY
    ),
]
Quick = Annotated[bool, flag_option("Compute coarser results, faster.")]
Studies = Annotated[
    bool, flag_option("Compute the studies as well as the figures of the paper.", name="--all")
]
Names = Annotated[
    list[str] | None,
    Parameter(
        help="Scenarios to run: names, or beginnings of names.", consume_multiple=True, negative=()
    ),
]


def simulate(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    duration: Duration,
    start: options.StartOrNone = None,
    samples: Samples = None,
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
    chosen = rotor.chosen()
    output.check()
    with working("simulate [%]") as progress:
        run = rotor_ida.simulate(
            chosen,
            start=start or REST,
            duration=duration,
            samples=samples,
            **options.of_disc(solver),
            progress=progress,
        )
    return answer(run, output, most=FIRST_ROWS)


def run_up(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    change: options.ChangeOptions = options.ChangeOptions(),
    start: options.StartOrNone = None,
    samples: Samples = None,
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
    output.check()
    with working("run-up [%]") as progress:
        run = rotor_ida.run_up(
            chosen,
            start=start or REST,
            **change.given(),
            samples=samples,
            **options.of_disc(solver),
            progress=progress,
        )
        found = rotor_ida.summary(run)
    return summarised(found, answer(run, output, most=FIRST_ROWS))


def sweep(
    system: options.System = None,
    /,
    *,
    rotors: RotorsOptions = RotorsOptions(),
    start: options.Starts = [AT_REST],  # noqa: B006 - never changed
    direction: Direction = None,
    events: Events = False,
    along: AlongEither = None,
    stiffness: StiffnessFactors = None,
    unbalance: Unbalances = None,
    jobs: options.JobOptions = options.JobOptions(),
    solver: options.SweepSolverOptions = options.SweepSolverOptions(),
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

    Up and down in clearance, at one speed:

        rotor-ida sweep --omega 1.5 --zeta 0.07 --delta0 0:2:5 --direction both \
            --figure clearance

    A rotor of any size with several contacts, from a system file:

        rotor-ida sweep rotor.toml --speed 1000rpm:5000rpm:9 --out map.nc

    Up and down in the unbalance of that rotor, at two dampings, which are factors:

        rotor-ida sweep rotor.toml --speed 4000rpm --unbalance 1e-3:4e-3:4 \
            --damping 1 0.5 --direction both --along unbalance --figure unbalance
    """
    axes = {"stiffness": stiffness, "unbalance": unbalance}
    if system is not None:
        if events:
            raise InputError("events must be of one disc: sweeps of a rotor system keep none")
        given = {"direction": direction, "along": along, "study": study, **jobs.on_every_core()}
        starts = None if start == [AT_REST] else start
        return sweep_file(system, rotors, axes, starts, solver, output, given)
    _refuse_of_system(axes)
    check_points(*rotors.axes(), start, in_study=study is not None)
    several = [name for name, each in rotors.values.items() if len(each) > 1]
    over = along or (several[0] if direction and len(several) == 1 else "omega")
    output.check(panels=rotors.panels(over=BECOMES.get(over, over)))
    rotor, given = rotors.asked()
    with working("sweep", study) as progress:
        dataset = rotor_ida.sweep(
            rotor,
            **given,
            starts=start,
            direction=direction,
            events=events,
            along=along,
            **asdict(solver),
            **jobs.on_every_core(),
            study=study,
            progress=progress,
        )
        return answer_whole(dataset, output, study)


def _refuse_of_system(given: Mapping[str, object]) -> None:
    """Refuse options of rotor systems with one disc."""
    for name, each in given.items():
        if each is not None:
            raise InputError(f"{name} must be of a rotor system, got no system file")


def bifurcation_diagram(
    system: options.System = None,
    /,
    *,
    rotors: RotorsOptions = RotorsOptions(),
    at: Shown = "extrema",
    revolutions: Revolutions = None,
    phase: Phase = 0.0,
    starts: StartCount = None,
    start: options.StartsOrNone = None,
    seed: options.Seed = 0,
    x: options.RangeOrNone = None,
    y: options.RangeOrNone = None,
    vx: options.RangeOrNone = None,
    vy: options.RangeOrNone = None,
    extrema_time: ExtremaTime = None,
    direction: Direction = None,
    along: AlongEither = None,
    stiffness: StiffnessFactors = None,
    unbalance: Unbalances = None,
    rate: RateOrNone = None,
    rtol: options.Rtol = 1e-10,
    atol: options.Atol = 1e-12,
    method: options.MethodOfStudy = None,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Compute a bifurcation diagram: settled motions by extrema or once a revolution.

    At each speed from four random initial states, drawn over the exact curve:

        rotor-ida bifurcation-diagram --omega 1.6:2:3 --zeta 0.07 --delta0 2 \
            --starts 4 --extrema-time 50 --workers 1 --figure diagram

    Up and down in speed, where each speed starts from the state of the one before:

        rotor-ida bifurcation-diagram --omega 1.2:1.7:3 --zeta 0.1 --delta0 0.5 \
            --start 0 0 0 0 --direction both --workers 1 --csv diagram.csv

    A rotor of any size with several contacts, once a revolution, from a system file:

        rotor-ida bifurcation-diagram rotor.toml --speed 1000rpm:5000rpm:3 \
            --at revolution --direction up --out strobes.nc
    """
    if start is not None and starts is not None:
        raise InputError(f"starts must be left out with --start, got {starts}")
    window = {"at": at, "revolutions": revolutions, "phase": phase}
    axes = {"stiffness": stiffness, "unbalance": unbalance}
    box = {"x": x, "y": y, "vx": vx, "vy": vy, "extrema_time": extrema_time, "rate": rate}
    given: dict[str, Any] = {name: each for name, each in box.items() if each is not None}
    more: dict[str, Any] = {
        **window, "seed": seed, "direction": direction, "along": along, "study": study,
        **jobs.on_every_core(),
    }  # fmt: skip
    if system is not None:
        if starts is not None:
            raise InputError(f"starts must be left out with a rotor system, got {starts}")
        solver = options.RunUpsSolverOptions(rtol=rtol, atol=atol, method=method)
        return sweep_file(
            system, rotors, axes, start, solver, output, {**given, **more}, is_diagram=True
        )
    _refuse_of_system(axes)
    count = STARTS if starts is None else starts
    check_points(*rotors.axes(), start or [AT_REST] * count, in_study=study is not None)
    output.check()
    if output.figure is not None:
        check_one_varies([name for name, each in rotors.values.items() if len(each) > 1])
    rotor, varied = rotors.asked()
    with working("diagram", study) as progress:
        dataset = rotor_ida.bifurcation_diagram(
            rotor,
            **varied,
            **given,
            **more,
            starts=count if start is None else start,
            rtol=rtol,
            atol=atol,
            method=method,
            progress=progress,
        )
        return answer_whole(dataset, output, study)


def poincare_section(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    revolutions: RevolutionsOfSection,
    skip: Skip = 0,
    at: Crossed = "revolution",
    contact: ContactOfSection = None,
    phase: Phase = 0.0,
    start: options.StartOrNone = None,
    rtol: options.Rtol = 1e-10,
    atol: options.Atol = 1e-12,
    method: options.MethodOfAny = None,
    output: Output = Output(),
) -> Report:
    r"""Compute a Poincaré section: the states of one motion once a revolution or at its events.

    Once a revolution, after 100 revolutions, drawn to section.png and section.svg:

        rotor-ida poincare-section --omega 2 --zeta 0.07 --delta0 2 \
            --revolutions 60 --skip 100 --figure section

    A rotor of any size with several contacts, at the entries of one, from a system file:

        rotor-ida poincare-section rotor.toml --speed 4300rpm --revolutions 40 \
            --at entry --contact seal --out entries.nc
    """
    given: dict[str, Any] = {
        "revolutions": revolutions, "skip": skip, "at": at, "phase": phase,
    }  # fmt: skip
    if system is not None:
        solver = options.AnyRunUpSolverOptions(rtol=rtol, atol=atol, method=method)
        number = int(contact) if contact is not None and contact.isdecimal() else contact
        return section_file(system, rotor, start, solver, output, {**given, "contact": number})
    _refuse_of_system({"contact": contact})
    chosen = rotor.chosen()
    output.check()
    with working("section [%]") as progress:
        section = rotor_ida.poincare_section(
            chosen, start=start or REST, **given, rtol=rtol, atol=atol, method=method,
            progress=progress,
        )  # fmt: skip
    return answer(section, output, most=FIRST_ROWS)


def run_ups(
    system: options.System = None,
    /,
    *,
    rotors: RotorsOptions = RotorsOptions(),
    to: ToSpeed,
    rate: Rates,
    begin: InitialSpeeds = None,
    phase: Phases = [0.0],  # noqa: B006 - never changed
    start: options.StartsOfRunUps = None,
    stiffness: StiffnessFactors = None,
    unbalance: Unbalances = None,
    jobs: options.JobOptions = options.JobOptions(),
    solver: options.RunUpsSolverOptions = options.RunUpsSolverOptions(),
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

    A rotor of any size with several contacts, from a system file:

        rotor-ida run-ups rotor.toml --from 600rpm --to 5000rpm --rate 5000rpm/s \
            --out many.nc

    That rotor with two frictions, and with its unbalance:

        rotor-ida run-ups rotor.toml --to 5000rpm --rate 5000rpm/s --friction 0 0.2 \
            --unbalance 1e-3 2e-3 --figure frictions
    """
    axes = {"stiffness": stiffness, "unbalance": unbalance}
    if begin is not None:
        of_speed = "speed" if system is not None or rotors.in_si else "omega"
        if of_speed in rotors.values:
            raise InputError(f"{of_speed} must be left out with --from, got both")
        initial: dict[str, Any] = {of_speed: begin}
        rotors = replace(rotors, **initial)
    if system is not None:
        given = {"to": to, "rate": rate, "phase": phase, "study": study, **jobs.on_every_core()}
        return run_ups_file(system, rotors, axes, start, solver, output, given)
    _refuse_of_system(axes)
    check_points(*rotors.axes(), rate, phase, start or [REST], in_study=study is not None)
    output.check(panels=rotors.panels())
    rotor, given = rotors.asked()
    with working("run-ups", study) as progress:
        dataset = rotor_ida.run_ups(
            rotor,
            **given,
            to=to,
            rate=rate,
            phase=phase,
            starts=[REST] if start is None else start,
            **asdict(solver),
            **jobs.on_every_core(),
            study=study,
            progress=progress,
        )
        return answer_whole(dataset, output, study)


def reproduce(
    *,
    out: Results = Path("results"),
    quick: Quick = False,
    studies: Studies = False,
    only: Names = None,
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
