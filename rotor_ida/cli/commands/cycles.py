"""The commands for limit cycles: one cycle, its branch, its bifurcations over two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli import options, parsing
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.option_types import ROTOR
from rotor_ida.cli.output import read
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError, RotorError, SimulationError
from rotor_ida.model.data_sheet import in_si
from rotor_ida.model.parameters import OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.scales import IS_OF_MACHINE
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM

if TYPE_CHECKING:
    import xarray as xr

# Kinds of archive for `--from`, of one disc and of a rotor system.
SOURCES = ("cycle", "branch", "curve")
OF_SYSTEM = (*(f"system_{kind}" for kind in SOURCES), "system_special_points")


@Parameter(name="*", group=ROTOR)
@options.optioned
@dataclass(frozen=True, kw_only=True)
class Origin:
    """Where a branch or a curve begins: near a cycle, or at one in an archive."""

    period: float | None = None
    from_: Path | None = None
    point: int | None = None
    special: int | None = None

    @property
    def units_unknown(self) -> bool:
        """Whether the units come from an archive."""
        return self.from_ is not None

    @property
    def given(self) -> set[str]:
        """The names of what is given besides a file."""
        return {name for name, each in vars(self).items() if name != "from_" and each is not None}


@command("one", label="cycle", without=("workers", "executor", "study"))
def limit_cycle(case: Case, *, without_gravity: bool = False) -> Report:
    r"""Compute the limit cycle reached from an initial state, with multipliers and spectrum.

    From rest, saved to a file:

        rotor-ida limit-cycle --omega 2 --zeta 0.07 --delta0 2 --out cycle.nc

    A cycle, stable or not, near a state on the rotating axes and of about a given period:

        rotor-ida limit-cycle --omega 2 --zeta 0.07 --delta0 2 \
            --start 2.6 0.75 0.66 -1.65 --period 4.5

    The cycle to which a rotor of any size leads, from a system file:

        rotor-ida limit-cycle rotor.toml --speed 8000rpm --without-gravity \
            --out bounce.nc
    """
    case.without_gravity = without_gravity
    try:
        found = case.ask()
    except RotorError as error:
        is_guess = "period" in case.given and not case.is_system
        if is_guess and isinstance(error.__cause__, SimulationError):
            raise InputError(f"start and period must be near a limit cycle: {error}") from error
        raise
    if found["period"].notnull() or case.output.figure is None:
        return case.report(found)
    case.output = replace(case.output, figure=None)
    report = case.report(found)
    return replace(report, parts=[*report.parts, "drew no figure: there is no limit cycle"])


@command("one", label="points")
def continue_cycle(
    case: Case, *, origin: Origin = Origin(), without_gravity: bool = False
) -> Report:
    r"""Continue a limit cycle over speed, damping or clearance, with its bifurcations.

    From the cycle of the example of limit-cycle; then along the period-doubled branch:

        rotor-ida continue-cycle --from cycle.nc --limits 1.5 2.5 --out branch.nc

        rotor-ida continue-cycle --from branch.nc --special 1 --limits 1.7 2

    That of a rotor of any size over the speed, and over the clearance, from a system file:

        rotor-ida continue-cycle rotor.toml --from bounce.nc --without-gravity \
            --limits 7950rpm 8050rpm

        rotor-ida continue-cycle rotor.toml --from bounce.nc --without-gravity \
            --parameter clearance --limits 145um 155um
    """
    case.without_gravity = without_gravity
    parameter = case.given.setdefault("parameter", "speed" if case.is_system else "omega")
    return _followed(case, [parameter], origin)


@command("one", label="points")
def bifurcation_curve(
    case: Case, *, origin: Origin = Origin(), without_gravity: bool = False
) -> Report:
    r"""Continue a fold, period doubling or torus bifurcation of cycles over two parameters.

    From the branch of the example of continue-cycle:

        rotor-ida bifurcation-curve --from branch.nc --special 1 \
            --kind period_doubling --limits 1.7 1.9 1.9 2.1 --out curve.nc

    For a rotor of any size give its system file first, and an archive of its cycle or branch.
    """
    case.without_gravity = without_gravity
    names = ("speed", "clearance") if case.is_system else ("omega", "delta0")
    return _followed(case, case.given.setdefault("parameters", names), origin)


def _followed(case: Case, names: Sequence[str], origin: Origin) -> Report:
    """Follow a branch or a curve of any rotor, from a start or from a cycle in an archive."""
    given = [*case.rotor_values, *("start" for _ in case.given.keys() & {"start"})]
    given += ["machine"] * (case.rotors.machine is not None) + [*origin.given & {"period"}]
    if case.is_system and origin.period is not None:
        raise InputError(
            "period must be left out with a rotor system: compute its cycle first, with limit-cycle"
        )
    of_file = sorted(origin.given - {"period"})
    if origin.from_ is not None:
        wrong = [name for name in given if not (case.is_system and name == "speed")]
        if wrong:
            raise InputError(f"{wrong[0]} must be left out with --from")
        if len(of_file) > 1:
            raise InputError("special must be left out with --point")
        _begin_in(case, origin.from_, origin)
    elif of_file:
        raise InputError(f"{of_file[0]} must be left out without --from")
    elif not (given or case.is_system):
        raise InputError("a rotor must be given, or a file with --from")

    def adapted(rotor: Any, asked: dict[str, Any]) -> dict[str, Any]:
        limits = asked["limits"]
        _check_units(rotor, names, limits)
        if origin.period is not None:
            asked["start"] = _closed(rotor, asked.get("start"), origin.period)
        return asked | {"limits": limits if len(names) == 1 else (limits[:2], limits[2:])}

    case.adapted = adapted
    return case.answer()


def _begin_in(case: Case, file: Path, origin: Origin) -> None:
    """Let a case begin with a cycle in an archive, of one disc with its rotor."""
    archived = read(file)
    if case.is_system:
        case.given["start"] = _in_archive(archived, file, origin, OF_SYSTEM)
        return
    from rotor_ida.cycles.guess import guess_in  # noqa: PLC0415 - heavy, not for --help
    from rotor_ida.results.si_units import dimensionless, machine_of  # noqa: PLC0415

    found = _in_archive(dimensionless(archived), file, origin, SOURCES)
    case.rotor = machine_of(archived) or guess_in(found).rotor
    case.given["start"] = found


def _check_units(
    rotor: Rotor | DimensionalRotor | RotorSystem, names: Sequence[str], limits: Sequence[float]
) -> None:
    """Raise `InputError` unless the units of limits, two a parameter, are those of parameters."""
    if isinstance(rotor, Rotor) or (isinstance(rotor, RotorSystem) and rotor.units != "SI"):
        parsing.refuse_units({"limits": tuple(limits)})
    own = PARAMETERS_OF_SYSTEM if isinstance(rotor, RotorSystem) else OF_MACHINE
    for place, each in enumerate(limits):
        name, word = names[place // 2], getattr(each, "word", "")
        name = IS_OF_MACHINE.get(name, name)
        if word and (known := own.get(name, OF_MACHINE.get(name))):
            in_si(name, word, known.unit)


def _closed(rotor: Rotor | DimensionalRotor, start: Any, period: float) -> xr.Dataset:
    """Return the cycle near a guess; if there is none, the guess is an input error."""
    try:
        return rotor_ida.limit_cycle(rotor, start=start, period=period)
    except SimulationError as error:
        raise InputError(f"start and period must be near a limit cycle: {error}") from error


def _in_archive(
    dataset: xr.Dataset, file: Path, origin: Origin, sources: Sequence[str]
) -> xr.Dataset:
    """Return the cycle in an archive, or that at one point of a branch, a curve and so on."""
    from rotor_ida.results.dataset_kinds import kind_of  # noqa: PLC0415 - heavy, and not for --help

    kind = kind_of(dataset)
    if kind not in sources:
        also = ", or special speeds" if sources is OF_SYSTEM else ""
        of = " of a rotor system" if sources is OF_SYSTEM else ""
        raise InputError(
            f"from must be a cycle, a branch or a curve{also}{of}, got {shown(file)}, of the kind "
            f"{kind}"
        )
    if not kind.endswith("cycle"):
        return _at(dataset, kind, origin.point, origin.special)
    if (origin.point, origin.special) != (None, None):
        raise InputError(f"point and special must be left out with a cycle, got {shown(file)}")
    if dataset["period"].isnull():
        raise InputError(f"from must contain a limit cycle, got {shown(file)} without one")
    return dataset


def _at(dataset: xr.Dataset, kind: str, point: int | None, special: int | None) -> xr.Dataset:
    """Return one point, or one special point, of a branch, a curve or special speeds."""
    kind = kind.removeprefix("system_").replace("_", " ")
    if point is None and special is None:
        raise InputError(f"point or special must be given with a {kind}")
    dim, number = ("point", point) if special is None else ("special", special)
    size = dataset.sizes.get(dim, 0)
    if number is None or number >= size:
        have = f"from 0 to {size - 1}" if size else "left out: there is none"
        raise InputError(f"{dim} must be {have}, got {number}")
    return dataset.isel({dim: number})
