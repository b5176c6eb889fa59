"""Machines on the command line: their files and units."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from rotor_ida.checks import State, listed
from rotor_ida.cli.parsing import Quantity
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import check_keys, machine_from_data_sheet, overridden
from rotor_ida.model.parameters import MACHINE_PARAMETERS, OF_MACHINE, PARAMETERS
from rotor_ida.model.rotor import DimensionalRotor, Rotor

if TYPE_CHECKING:
    pass

# Required parameters of a rotor, dimensionless or in SI units.
KINDS = (PARAMETERS, MACHINE_PARAMETERS)
# A number, the numbers of an axis, or the two ends of a range.
Component = TypeVar("Component", float, list[float] | float, tuple[float, float] | float)

# The start of one disc where none is given: in equilibrium with its load.
REST = "rest"


def begun(start: State | str | None, rotor: Rotor | DimensionalRotor) -> State:
    """Return a start as a state; without one it is where the load holds the rotor."""
    if start is not None and not isinstance(start, str):
        return start
    from rotor_ida.simulation.starts import start_of  # noqa: PLC0415 - not for --help

    word = start or REST
    if isinstance(rotor, Rotor):
        return start_of(rotor, word)
    x, y, vx, vy = start_of(rotor.rotor(), word)
    length, velocity = rotor.length_scale, rotor.velocity_scale
    return x * length, y * length, vx * velocity, vy * velocity


def sheet_of(given: Mapping[str, object], file: Path | None) -> dict[str, object]:
    """Return the data sheet from options, which override those of a file."""
    given = {name: float(each) if isinstance(each, float) else each
             for name, each in given.items()} | _with_its_unit(given)  # fmt: skip
    if file is None:
        return given
    from rotor_ida.results.machine_file import read_data_sheet  # noqa: PLC0415 - not for --help

    dimensionless = [name for name in PARAMETERS if name in given]
    if dimensionless:
        raise InputError(f"{dimensionless[0]} must be left out with a machine: it has no dimension")
    sheet = overridden(read_data_sheet(file), given)
    check_keys(sheet, str(file))
    return sheet


def _with_its_unit(given: Mapping[str, object]) -> dict[str, object]:
    """Return the contact stiffness as given: its unit decides the contact law."""
    stiffness = given.get("contact_stiffness")
    if isinstance(stiffness, Quantity) and stiffness.word:
        return {"contact_stiffness": stiffness.word}
    return {}


def chosen(
    given: Mapping[str, object], file: Path | None, optional: Sequence[str]
) -> Rotor | DimensionalRotor:
    """Return the given rotor, dimensionless or as a machine."""
    if file is None:
        check_complete(given, optional)
        if "omega" in given:
            return Rotor(**given)  # type: ignore[arg-type]
    return of_sheet(sheet_of(given, file), file)


def check_complete(
    given: Collection[str], optional: Sequence[str], *, known: Sequence[str] = ()
) -> None:
    """Refuse a rotor that is incomplete but for `known` parameters, or given in both ways."""
    needed = [name for name in given if name not in optional]
    both = [next((name for name in needed if name in kind), "") for kind in KINDS]
    if all(both):
        raise InputError(
            f"a rotor must be given without dimensions or in SI units, got {listed(both)}"
        )
    lacking = missing([*needed, *known])
    if lacking:
        beside = f" with {listed(needed)}" if needed else ", or a machine in SI units"
        raise InputError(f"{listed(lacking)} must be given{beside}")


def missing(given: Collection[str]) -> list[str]:
    """Return the missing parameters of a rotor, for the kind of those given.

    Examples
    --------
    >>> missing(["zeta"]), missing([]), missing(["mass", "damping", "eccentricity", "clearance"])
    (['omega', 'delta0'], ['omega', 'zeta', 'delta0'], ['contact_stiffness', 'speed'])
    """
    kind = MACHINE_PARAMETERS if set(MACHINE_PARAMETERS).intersection(given) else PARAMETERS
    return [name for name in kind if name not in given]


def of_sheet(sheet: Mapping[str, object], file: Path | None) -> DimensionalRotor:
    """Return the machine of a data sheet; a mistake in a file names the file."""
    try:
        return machine_from_data_sheet(**sheet)  # type: ignore[arg-type]
    except InputError as error:
        raise error if file is None else error.within(f"{file}: ") from error


def varied(
    given: Mapping[str, Sequence[float]], file: Path | None
) -> tuple[DimensionalRotor, dict[str, Sequence[float]]]:
    """Return the first of several machines, and the quantities that vary."""
    several = {name: each for name, each in given.items() if len(each) > 1}
    for name, values in several.items():
        if OF_MACHINE[name].sets_scales:
            raise InputError(
                f"{name} must be one number, as it sets the scales of all machines, got "
                f"{len(values)}"
            )
    return of_sheet(sheet_of({name: each[0] for name, each in given.items()}, file), file), several
