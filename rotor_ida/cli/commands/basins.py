"""The commands for basins of attraction: of one rotor, over parameters, and as a report."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import MOST_SHOCKS, State, listed, shown
from rotor_ida.cli import options, parsing
from rotor_ida.cli.option_types import STUDY, count_option
from rotor_ida.cli.output import Output, answer, answer_whole, check_varies, working
from rotor_ida.cli.parsing import MOST_POINTS, check_points
from rotor_ida.cli.report import Report
from rotor_ida.cli.rotor_options import RotorOptions, RotorsOptions
from rotor_ida.cli.systems import basin_file, case_of
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED

Component = Annotated[
    float | list[float],
    Parameter(
        help="Component of the initial states: a number or a range.",
        metavar="FLOAT|START:STOP:COUNT",
        converter=parsing.converter(parsing.component_or_range),
        negative=(),
    ),
]
ShockCount = Annotated[
    int,
    count_option("Number of shocks of each kind to apply to each attractor.", 0, MOST_SHOCKS),
]
ShocksOrNone = Annotated[
    int | None,
    count_option(
        "Number of shocks of each kind to apply to each attractor. Default: 4096; under a load 0; "
        "of a rotor system 64.",
        0, MOST_SHOCKS,
    ),
]  # fmt: skip
NodeOrNone = Annotated[
    str | None,
    Parameter(help="Node of a rotor system whose initial states these are.", metavar="NAME"),
]
StartOfOthers = Annotated[
    State | str | None,
    options.START,
    Parameter(
        help="How the other nodes of a rotor system start: settled (steady whirl without contact) "
        "or rest (in equilibrium with the load). Default: what its file says.",
        metavar="settled|rest",
    ),
]


@Parameter(name="*", group=STUDY)
@dataclass(frozen=True, kw_only=True)
class DrawnOptions:
    """Options for random starts and their labels."""

    x: options.Range = 0.0
    y: options.Range = 0.0
    vx: options.Range = 0.0
    vy: options.Range = 0.0
    starts: options.StartCount = 1000
    seed: options.Seed = 0
    rtol: options.RtolOrNone = None


def basin(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    x: Component,
    y: Component,
    vx: Component = 0.0,
    vy: Component = 0.0,
    node: NodeOrNone = None,
    start: StartOfOthers = None,
    rtol: options.RtolOrNone = None,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Compute basins of attraction on a plane of initial states.

    Two components of the initial state are ranges; here the velocities are 0:

        rotor-ida basin --omega 1.7 --zeta 0.07 --delta0 0 \
            --x=-15:15:64 --y=-15:15:64 --out basin.nc

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida basin rotor.toml --speed 4300rpm --node disc \
            --x=-300um:300um:5 --y=-300um:300um:5 --figure basin

    After an interrupt (exit status 130) the rest of the result is marked as not computed.
    """
    axes = [part for part in (x, y, vx, vy) if isinstance(part, list)]
    check_points(*axes, in_study=study is not None)
    given: dict[str, Any] = {
        "x": x, "y": y, "vx": vx, "vy": vy, "rtol": rtol, **asdict(jobs), "study": study,
    }  # fmt: skip
    if system is not None:
        return basin_file(rotor_ida.basin, system, rotor, node, start, output, given)
    _refuse_parts_of_system(node, start)
    output.check()
    chosen = rotor.chosen()
    with working("basin", study) as progress:
        dataset = rotor_ida.basin(chosen, **given, progress=progress)
        return answer_whole(dataset, output, study)


def basin_fractions(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    x: options.Range,
    y: options.Range,
    vx: options.Range = 0.0,
    vy: options.Range = 0.0,
    node: NodeOrNone = None,
    start: StartOfOthers = None,
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

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida basin-fractions rotor.toml --speed 4300rpm --node disc \
            --x=-300um:300um --y=-300um:300um --starts 20
    """
    output = Output(out=out, csv=csv, as_json=as_json, force=force)
    output.check()
    if study is None and starts > MOST_POINTS:
        raise InputError(f"starts must be at most {MOST_POINTS} without --study, got {starts}")
    given: dict[str, Any] = {
        "x": x, "y": y, "vx": vx, "vy": vy, "starts": starts, "seed": seed, "rtol": rtol,
        **asdict(jobs), "study": study,
    }  # fmt: skip
    if system is not None:
        return basin_file(rotor_ida.basin_fractions, system, rotor, node, start, output, given)
    _refuse_parts_of_system(node, start)
    chosen = rotor.chosen()
    with working("fractions", study) as progress:
        dataset = rotor_ida.basin_fractions(chosen, **given, progress=progress)
        return answer_whole(dataset, output, study)


def _refuse_parts_of_system(node: str | None, start: State | str | None) -> None:
    """Refuse what is of a rotor system only."""
    for name, value in {"node": node, "start": start}.items():
        if value is not None:
            raise InputError(f"{name} must be of a rotor system, got no system file")


def continue_attractors(
    system: options.System = None,
    /,
    *,
    rotors: RotorsOptions = RotorsOptions(),
    node: NodeOrNone = None,
    start: StartOfOthers = None,
    drawn: DrawnOptions = DrawnOptions(),
    shocks: ShockCount = 0,
    jobs: options.JobOptions = options.JobOptions(),
    study: options.Study = None,
    output: Output = Output(),
) -> Report:
    r"""Continue all attractors over speed, damping or clearance, with their basin fractions.

    Over 15 speeds, drawn as basin fractions:

        rotor-ida continue-attractors --omega 0.2:3:8 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --starts 200 --out atlas.nc --figure atlas

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida continue-attractors rotor.toml --speed 3900rpm:4500rpm:3 \
            --node disc --x=-300um:300um --y=-300um:300um --starts 4
    """
    output.check()
    if output.figure is not None:
        check_varies(rotors.panels())
    asked = {**asdict(drawn), "shocks": shocks, **asdict(jobs), "study": study}
    if system is None:
        _refuse_parts_of_system(node, start)
        rotor, given = rotors.asked()
        verb = partial(rotor_ida.continue_attractors, rotor, **given)
    else:
        verb = partial(rotor_ida.continue_attractors, **_varied(system, rotors, node, start))
    with working("atlas", study) as progress:
        return answer_whole(verb(**_given(asked), progress=progress), output, study)


def _varied(
    file: Path, rotors: RotorsOptions, node: str | None, start: State | str | None
) -> dict[str, Any]:
    """Return the system of a file, its node, and what varies of it."""
    system, course = case_of(file, rotors.values)
    values: dict[str, Any] = {SPEED: course.speed, **rotors.values}
    for name, each in {**values, "machine": rotors.machine}.items():
        if name not in (SPEED, *PARAMETERS_OF_SYSTEM) and each is not None:
            raise InputError(f"{name} must be left out with a rotor system, got {shown(each)}")
    if values[SPEED] is None:
        raise InputError(f"speed must be given with --speed or in {file}")
    begun = {"start": course.start if start is None else start, "modes": course.modes}
    if node is None:
        nodes = listed([repr(each) for each in system.nodes], "or")
        raise InputError(f"node must be given with --node for a rotor system: {nodes}")
    return {"rotor": system, "node": node, **begun, **values}


def _given(options_: dict[str, Any]) -> dict[str, Any]:
    """Return options without a tolerance that is not given."""
    return {name: each for name, each in options_.items() if name != "rtol" or each is not None}


def touchdown_report(
    system: options.System = None,
    /,
    *,
    rotor: RotorOptions = RotorOptions(),
    node: NodeOrNone = None,
    start: StartOfOthers = None,
    drawn: DrawnOptions = DrawnOptions(),
    shocks: ShocksOrNone = None,
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

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida touchdown-report rotor.toml --speed 4300rpm --node disc \
            --x=-300um:300um --y=-300um:300um --starts 8 --shocks 0
    """
    if system is not None:
        given = {**asdict(drawn), "shocks": shocks}
        return basin_file(rotor_ida.touchdown_report, system, rotor, node, start, output, given)
    _refuse_parts_of_system(node, start)
    chosen = rotor.chosen()
    output.check()
    with working("touchdown") as progress:
        report = rotor_ida.touchdown_report(
            chosen, **asdict(drawn), shocks=shocks, progress=progress
        )
    return answer(report, output)
