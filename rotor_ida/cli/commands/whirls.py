"""The commands for exact whirls, and what is known of a rotor over its speed."""

from __future__ import annotations

from dataclasses import replace

import rotor_ida
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError

# More rows are for programs, with --json or --out.
MOST_ROWS = 1000


@command("several", most=MOST_ROWS)
def synchronous_response(
    case: Case, *, folds: bool = False, without_gravity: bool = False
) -> Report:
    r"""List all exact synchronous whirls, with their stability.

    At two speeds, with the folds; then over a range of speeds, saved and drawn:

        rotor-ida synchronous-response --omega 1.2 1.7 --zeta 0.07 --delta0 0.5 \
            --folds

        rotor-ida synchronous-response --omega 0.5:3:251 --zeta 0.07 \
            --delta0 0 2 --out whirls.nc --figure whirls.png

    A rotor of any size, from a system file:

        rotor-ida synchronous-response rotor.toml --speed 3000rpm:9000rpm:61 \
            --without-gravity --figure rubs
    """
    case.without_gravity = without_gravity
    if folds and case.is_system:
        raise InputError("folds must be left out with a rotor system: see special-speeds")
    if not case.is_system:
        case.panels = case.rotors.panels(over="omega")
    whirls = case.ask()
    if folds:
        machine, given = case.rotors.asked()
        of_folds = {name: each for name, each in given.items()
                    if name not in {"omega", "speed", "contact_damping"}}  # fmt: skip
        undamped = None if machine is None else replace(machine, contact_damping=0.0)
        found = rotor_ida.folds(undamped, **of_folds)
        whirls = whirls.assign({name: found[name] for name in ("fold_omega", "fold_amplitude")})
    return case.report(whirls)


@command("all speeds", most=MOST_ROWS)
def folds(case: Case) -> Report:
    r"""Compute all folds: speeds at which a synchronous whirl in contact vanishes.

    The rotor jumps there. At two clearances; then drawn on the response curve:

        rotor-ida folds --zeta 0.07 --delta0 0 0.5

        rotor-ida folds --zeta 0.07 --delta0 0.5 --out folds.nc --figure folds
    """
    case.panels = case.rotors.panels()
    return case.answer()


@command("all speeds", most=MOST_ROWS)
def hopf_points(case: Case) -> Report:
    r"""Compute all Hopf points: speeds at which a whirl in contact begins to oscillate.

    They occur only with friction or contact damping:

        rotor-ida hopf-points --zeta 0.07 --delta0 0.5 --friction 0 0.1 \
            --figure hopf_points
    """
    case.panels = case.rotors.panels()
    return case.answer()


@command("one", most=None)
def backward_whirl(case: Case) -> Report:
    r"""Compute the backward whirls that friction sustains: dry whirl and dry whip.

    Without unbalance; both exist above the speed `birth omega`:

        rotor-ida backward-whirl --omega 0.63 --zeta 0.1 --delta0 1 \
            --friction 0.2 --disc-radius 10
    """
    return case.answer()


@command("of a file")
def special_speeds(case: Case, *, without_gravity: bool = False) -> Report:
    r"""List the speeds at which a rotor system grows unstable, and its whirls fold or graze.

    Between two speeds, with the whirls drawn to special.png and special.svg:

        rotor-ida special-speeds rotor.toml --limits 3000rpm 9000rpm \
            --without-gravity --out special.nc --figure special
    """
    case.without_gravity = without_gravity
    return case.answer()


@command("of a file")
def campbell(case: Case) -> Report:
    r"""Compute whirl speeds and damping ratios over the speed: a Campbell diagram.

    With open contacts, and with springs at the contacts as in a rub:

        rotor-ida campbell rotor.toml --speed 0:9000rpm:46 --modes 6 \
            --contact-stiffness 0 1e7 --figure campbell
    """
    case.without_gravity = case.is_system  # eigenvalues have none
    return case.answer()


@command("of a file")
def clearance_report(
    case: Case, *, own_unbalance: bool = False, without_gravity: bool = False
) -> Report:
    r"""Check the unbalance response at close clearances in the manner of API 617.

    Each contact of the file is a clearance. What follows a touch is computed where rotor and
    stators are axisymmetric and carry no weight:

        rotor-ida clearance-report rotor.toml --speed 7000rpm 9000rpm 9500rpm \
            --probes disc --without-gravity --out report.nc --figure report
    """
    case.without_gravity = without_gravity
    if not own_unbalance:
        case.given["unbalance"] = ()
    return case.answer()
