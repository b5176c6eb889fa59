"""The commands that simulate: runs and run-ups, one or many, and the paper's figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import rotor_ida
from rotor_ida.checks import check_one_varies, shown
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.given import given_in_words
from rotor_ida.cli.report import Report
from rotor_ida.cli.verb_options import OF_CHANGE
from rotor_ida.errors import InputError
from rotor_ida.model.scales import BECOMES
from rotor_ida.model.system_parameters import SPEED

if TYPE_CHECKING:
    from rotor_ida.cli.variables import Description


@command("one", label="simulate [%]", quiet=True)
def simulate(case: Case) -> Report:
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
    return case.answer()


@command("one", label="run-up [%]", quiet=True)
def run_up(case: Case, *, begin: float | None = None) -> Report:
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
    if case.is_system:
        _change_of_file(case, begin)
    else:
        _begun(case, begin)
    run, speed = case.ask(), case.running_speed
    summary = rotor_ida.summary(run, running_speed=speed)

    def told(most: int | None) -> Description:
        """Return the answer, which begins with the summary and the words on what was given."""
        from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help

        (first, before), (record, parts) = describe(summary), describe(run, most=most)
        sentence, given = str(summary.attrs["sentence"]), given_in_words(case.rotor, speed)
        others = [each for each in parts if not (isinstance(each, str) and each in sentence)]
        parts = [*before[:1], *filter(None, [given]), *before[1:], *others]
        return {"summary": first | {"sentence": sentence}} | record, parts

    return case.report(run, told=told)


@command("several")
def sweep(case: Case) -> Report:
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
    if not case.is_system:
        several = case.varied()
        over = case.given.get("along") or "omega"
        if case.given.get("direction") and "along" not in case.given and len(several) == 1:
            over = several[0]
        case.panels = case.rotors.panels(over=BECOMES.get(over, over))
    return case.answer()


@command("several", label="diagram")
def bifurcation_diagram(case: Case, *, node: str | None = None) -> Report:
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
    starts = case.given.get("starts")
    if "start" in case.given and starts is not None:
        raise InputError(f"starts must be left out with --start, got {starts}")
    case.draw_at(node)
    if case.is_system:
        case.refuse_with("a rotor system", {"starts": starts})
    if case.output.figure is not None:
        check_one_varies(case.varied())
    return case.answer()


@command("one", label="section [%]")
def poincare_section(case: Case, *, node: str | None = None) -> Report:
    r"""Compute a Poincaré section: the states of one motion once a revolution or at its events.

    Once a revolution, after 100 revolutions, drawn to section.png and section.svg:

        rotor-ida poincare-section --omega 2 --zeta 0.07 --delta0 2 \
            --revolutions 60 --skip 100 --figure section

    A rotor of any size with several contacts, at the entries of one, from a system file:

        rotor-ida poincare-section rotor.toml --speed 4300rpm --revolutions 40 \
            --at entry --contact seal --out entries.nc
    """
    case.draw_at(node)
    return case.answer()


@command("several", label="run-ups")
def run_ups(case: Case, *, begin: float | None = None) -> Report:
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
    if case.is_system:
        first = case.rotor_values.get(SPEED, case.from_file[1].run_up.get(SPEED, 0.0))
        case.known[SPEED] = first
    else:
        case.panels = case.rotors.panels()
    _begun(case, begin)
    return case.answer()


def _begun(case: Case, begin: float | None) -> None:
    """Let a rotor begin at a speed, if it is given, and the machine of a file at standstill."""
    speed = SPEED if case.is_system or case.rotors.in_si else "omega"
    is_set = "speeds" in case.given or speed in case.rotor_values
    if begin is None and case.rotors.machine is not None and not is_set:
        begin = 0.0  # the file contains the running speed
    if begin is not None:
        if speed in case.rotor_values:
            raise InputError(f"{speed} must be left out with --from, got both")
        case.known[speed] = [begin] if case.of.rotors == "several" else begin


def _change_of_file(case: Case, begin: float | None) -> None:
    """Let a system run up as its file says, unless options give another change of speed."""
    own = case.from_file[1].run_up
    replaces = bool(OF_CHANGE.intersection(case.given) - {"duration"})
    case.given = {**({} if replaces else own), **case.given}
    case.given.pop(SPEED, None)
    _begun(case, begin)
    first = case.known.get(SPEED, case.rotor_values.get(SPEED))
    if "speeds" not in case.given:
        case.known[SPEED] = own.get(SPEED, 0.0) if first is None else first
    elif first is not None:
        raise InputError(f"from must be left out with speeds, got {shown(first)}")


@command("none", asks=(), writes=False)
def reproduce(
    _case: Case, *, out: Path = Path("results"), quick: bool = False, studies: bool = False,
    only: list[str] | None = None, workers: int | None = None, force: bool = False,
) -> int:  # fmt: skip
    """Reproduce the figures of the paper and, on request, all studies, as a page index.html.

    Results that are up to date are kept. One scenario, coarse but quick:

        rotor-ida reproduce --only fig06_jumps --quick --out results
    """
    from rotor_ida.paper import reproduction  # noqa: PLC0415 - heavy, and not for --help

    return reproduction.reproduce(
        out, quick=quick, studies=studies, only=only, workers=workers, force=force
    )
