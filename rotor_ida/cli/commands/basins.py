"""The commands for basins of attraction: of one rotor, over parameters, and as a report."""

from __future__ import annotations

from rotor_ida.cli.command import Case, command
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError


@command("one")
def basin(case: Case) -> Report:
    r"""Compute basins of attraction on a plane of initial states.

    Two components of the initial state are ranges; here the velocities are 0:

        rotor-ida basin --omega 1.7 --zeta 0.07 --delta0 0 \
            --x=-15:15:64 --y=-15:15:64 --out basin.nc

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida basin rotor.toml --speed 4300rpm --node disc \
            --x=-300um:300um:5 --y=-300um:300um:5 --figure basin

    After an interrupt (exit status 130) the rest of the result is marked as not computed.
    """
    return case.answer()


@command("one", label="fractions")
def basin_fractions(case: Case) -> Report:
    r"""Estimate basin fractions from random initial states.

    From a square of initial states, saved in a folder as they are computed:

        rotor-ida basin-fractions --omega 2 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --starts 2000 --study study

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida basin-fractions rotor.toml --speed 4300rpm --node disc \
            --x=-300um:300um --y=-300um:300um --starts 20
    """
    if case.output.figure is not None:
        raise InputError("figure must be left out: basin fractions have none")
    return case.answer()


@command("several", label="atlas")
def continue_attractors(case: Case) -> Report:
    r"""Continue all attractors over speed, damping or clearance, with their basin fractions.

    Over 15 speeds, drawn as basin fractions:

        rotor-ida continue-attractors --omega 0.2:3:8 --zeta 0.07 --delta0 2 \
            --x=-15:15 --y=-15:15 --starts 200 --out atlas.nc --figure atlas

    A rotor of any size with several contacts, from a system file, by the states of a node:

        rotor-ida continue-attractors rotor.toml --speed 3900rpm:4500rpm:3 \
            --node disc --x=-300um:300um --y=-300um:300um --starts 4
    """
    if case.output.figure is not None and case.rotors.panels() < 2:
        raise InputError("figure needs an atlas of several speeds, dampings or clearances, got one")
    return case.answer()


@command("one", label="touchdown", most=None)
def touchdown_report(case: Case) -> Report:
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
    if case.output.figure is not None:
        raise InputError("figure must be left out: a touchdown report has none")
    return case.answer()
