"""The commands for a rotor system over its speed: special speeds, eigenvalues, clearances."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import MOST_NUMBERS
from rotor_ida.cli import options
from rotor_ida.cli.option_types import (
    IN_ROTOR,
    count_option,
    flag_option,
    number_option,
    numbers_option,
    quantity_option,
    several_numbers_option,
)
from rotor_ida.cli.output import Output, answer, working
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.systems import linear_case

SpeedsOfSystem = Annotated[
    list[float],
    numbers_option("Spin speeds, or START:STOP:COUNT (SI: rad/s, or as 3000rpm).", "rad s-1"),
    IN_ROTOR,
]
LimitsOfSpeed = Annotated[
    tuple[float, float],
    several_numbers_option(
        "Lowest and highest speed (SI: rad/s, or as 3000rpm).", "LOW HIGH", "rad s-1", "rad s-1"
    ),
]
PointsBetween = Annotated[
    int, count_option("Number of speeds at which changes are noticed.", 2, MOST_NUMBERS)
]
ClosedStiffnesses = Annotated[
    list[float],
    numbers_option(
        "Stiffnesses of springs at the contacts, from open to closed (SI: N/m).", "N m-1"
    ),
]
ModesShown = Annotated[
    int | None, count_option("Number of eigenvalues, the slowest first.", 1, MOST_NUMBERS)
]
RunningSpeeds = Annotated[
    list[float],
    numbers_option(
        "Minimum and maximum continuous speed, and the trip speed (SI: rad/s, or as 3000rpm).",
        "rad s-1",
    ),
    IN_ROTOR,
]
Probes = Annotated[
    list[str] | None,
    Parameter(
        help="Nodes at which vibration is measured. Default: those of the contacts.",
        metavar="NAME",
        consume_multiple=True,
        negative=(),
    ),
]
OwnUnbalance = Annotated[
    bool, flag_option("Take the unbalance of the file as residual, instead of that of the formula.")
]
Multiple = Annotated[float, number_option("How many times the residual unbalance is applied.")]
VibrationLimit = Annotated[
    float | None,
    quantity_option("Vibration limit, from peak to peak (SI: m). Default: by the speed.", "m"),
]
RotorMass = Annotated[
    float | None,
    quantity_option(
        "Mass of the rotor, for its residual unbalance. Default: by the matrices.", "kg"
    ),
]
PointsOfResponse = Annotated[int, count_option("Number of speeds.", 2, MOST_NUMBERS)]


def special_speeds(
    system: options.SystemFile,
    /,
    *,
    limits: LimitsOfSpeed,
    points: PointsBetween = 200,
    without_gravity: options.WithoutGravity = False,
    output: Output = Output(),
) -> Report:
    r"""List the speeds at which the whirls of a rotor system fold, oscillate or graze.

    Between two speeds, with the whirls drawn to special.png and special.svg:

        rotor-ida special-speeds rotor.toml --limits 3000rpm 9000rpm \
            --without-gravity --out special.nc --figure special
    """
    output.check()
    rotor, _ = linear_case(system, {"limits": limits}, without_gravity=without_gravity)
    with working("special speeds") as progress:
        found = rotor_ida.special_speeds(rotor, limits=limits, points=points, progress=progress)
    return answer(found, output, most=FIRST_ROWS)


def campbell(
    system: options.SystemFile,
    /,
    *,
    speed: SpeedsOfSystem,
    contact_stiffness: ClosedStiffnesses = [0.0],  # noqa: B006 - never changed
    modes: ModesShown = None,
    output: Output = Output(),
) -> Report:
    r"""Compute whirl speeds and damping ratios over the speed: a Campbell diagram.

    With open contacts, and with springs at the contacts as in a rub:

        rotor-ida campbell rotor.toml --speed 0:9000rpm:46 --modes 6 \
            --contact-stiffness 0 1e7 --figure campbell
    """
    output.check()
    given = {"speed": speed, "contact_stiffness": contact_stiffness}
    rotor, _ = linear_case(system, given, without_gravity=True)
    found = rotor_ida.campbell(rotor, modes=modes, speed=speed, contact_stiffness=contact_stiffness)
    return answer(found, output, most=FIRST_ROWS)


def clearance_report(
    system: options.SystemFile,
    /,
    *,
    speed: RunningSpeeds,
    probes: Probes = None,
    own_unbalance: OwnUnbalance = False,
    multiple: Multiple = 2.0,
    vibration_limit: VibrationLimit = None,
    mass: RotorMass = None,
    points: PointsOfResponse = 300,
    without_gravity: options.WithoutGravity = False,
    output: Output = Output(),
) -> Report:
    r"""Check the unbalance response at close clearances in the manner of API 617.

    Each contact of the file is a clearance. What follows a touch is computed where rotor and
    stators are axisymmetric and carry no weight:

        rotor-ida clearance-report rotor.toml --speed 7000rpm 9000rpm 9500rpm \
            --probes disc --without-gravity --out report.nc --figure report
    """
    output.check()
    given: dict[str, Any] = {"speed": speed, "vibration_limit": vibration_limit, "mass": mass}
    rotor, _ = linear_case(system, given, without_gravity=without_gravity)
    if not own_unbalance:
        rotor = replace(rotor, unbalance=())
    found = rotor_ida.clearance_report(
        rotor, **given, probes=probes, multiple=multiple, points=points
    )
    return answer(found, output, most=FIRST_ROWS)
