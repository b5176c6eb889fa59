"""Options for a rotor or for several: dimensionless, in SI units, or of a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

from cyclopts import Parameter

from rotor_ida.checks import listed
from rotor_ida.cli.option_types import (
    IN_ROTOR,
    ROTOR,
    number_option,
    numbers_option,
    path_option,
    quantity_option,
)
from rotor_ida.cli.parsing import Quantity
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import (
    GRAVITY,
    WEIGHT,
    check_keys,
    machine_from_data_sheet,
    overridden,
    units_of,
)
from rotor_ida.model.parameters import MACHINE_PARAMETERS, OF_MACHINE, OPTIONAL, PARAMETERS, TABLE
from rotor_ida.model.parameters import Parameter as Row
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.scales import BECOMES

# Placeholder where a speed is required but not used.
ANY_SPEED = 1.0
# Required parameters of a rotor, dimensionless or in SI units.
KINDS = (PARAMETERS, MACHINE_PARAMETERS)
# The speed of a rotor, without dimensions and in SI units.
SPEEDS = ("omega", "speed")
MachineFile = Annotated[
    Path | None,
    path_option("Machine in SI units, as written by rotor-ida machine; other options override it."),
    IN_ROTOR,
]


def _units_of(parameter: Row) -> tuple[str, ...]:
    """Return the allowed units of an option for a parameter of a machine."""
    if parameter.unit == "1":
        return ()
    return units_of(parameter.name)


def _help(name: str, text: str) -> str:
    """Return the help of an option for a parameter."""
    return f"{text[:-1]}; or the word weight." if name == "load" else text


# For one rotor or several, dimensionless or in SI units, or in an archive.
ONE = {
    each.name: Annotated[
        float | None,
        quantity_option(_help(each.name, each.either_help), *_units_of(each))
        if _units_of(each)
        else number_option(each.either_help),
    ]
    for each in TABLE
}
SEVERAL = {
    each.name: Annotated[
        list[float] | None,
        numbers_option(_help(each.name, each.either_axis_help), *_units_of(each)),
    ]
    for each in TABLE
}
Fields = TypeVar("Fields", bound=type)


def with_parameters(options: Mapping[str, Any]) -> Callable[[Fields], Fields]:
    """Return a decorator that puts options, none of which is needed, before those of a group."""

    def add(group: Fields) -> Fields:
        group.__annotations__ = {**options, **group.__annotations__}
        for name in options:
            setattr(group, name, None)
        return group

    return add


class Given:
    """What is given of rotors, without dimensions, in SI units or by a file."""

    machine: Path | None

    @property
    def in_si(self) -> bool:
        """Whether it is in SI units."""
        return self.machine is not None or bool(self.given.keys() & set(MACHINE_PARAMETERS))

    @property
    def given(self) -> dict[str, Any]:
        """The given quantities, each a number or several."""
        return {name: getattr(self, name) for name in ONE if getattr(self, name) is not None}


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters(ONE)
class RotorOptions(Given):
    """One rotor, without dimensions or in SI units."""

    machine: MachineFile = None

    def chosen(self, known: Mapping[str, float] = {}) -> Rotor | DimensionalRotor:
        """Return the rotor, dimensionless or in SI units, from the given and `known` quantities."""
        given = {**self.given, **known}
        if self.machine is None:
            check_complete(given, OPTIONAL)
            if "omega" in given:
                return Rotor(**given)
        return of_sheet(sheet_of(given, self.machine), self.machine)


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters(SEVERAL)
class RotorsOptions(Given):
    """The rotors of a study; without an optional parameter, all have its default."""

    machine: MachineFile = None

    def asked(
        self, known: Mapping[str, list[float]] = {}
    ) -> tuple[DimensionalRotor | None, dict[str, Any]]:
        """Return the machine, if it is one, and the quantities that are given or vary.

        One value of an optional parameter does not make an axis.
        """
        values = {**self.given, **known}
        if self.machine is None:
            check_complete(values, OPTIONAL)
        if not self.in_si:
            return None, {
                name: each[0] if name in OPTIONAL and len(each) == 1 else each
                for name, each in values.items()
            }
        several = {name: each for name, each in values.items() if len(each) > 1}
        for name, each in several.items():
            if OF_MACHINE[name].sets_scales:
                raise InputError(
                    f"{name} must be one number, as it sets the scales of all machines, got "
                    f"{len(each)}"
                )
        first = {name: each[0] for name, each in values.items()}
        machine = of_sheet(sheet_of(first, self.machine), self.machine)
        if "load" in several:
            weight = machine.mass * GRAVITY
            several["load"] = [weight if is_weight(each) else each for each in several["load"]]
        return machine, several

    def panels(self, over: str = "") -> int:
        """Return the number of panels of a figure over one of the parameters."""
        return math.prod(
            len(each) for name, each in self.given.items() if BECOMES.get(name, name) != over
        )


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters({name: Annotated[SEVERAL[name], Parameter(show=False)] for name in SPEEDS})
class AllSpeedsOptions(RotorsOptions):
    """Rotors for lists of folds or Hopf points, which are found at all speeds."""

    def asked(
        self, known: Mapping[str, list[float]] = {}
    ) -> tuple[DimensionalRotor | None, dict[str, Any]]:
        """Return the machine, if it is one, and the given parameters that affect these points."""
        for name in SPEEDS:
            if name in self.given:
                raise InputError(f"{name} must be left out: all speeds are searched")
        speed = "speed" if self.in_si else "omega"
        if self.machine is None:
            check_complete(self.given, OPTIONAL, known=(speed,))
        at_any = {speed: [ANY_SPEED]} if self.machine is None else {}
        machine, given = super().asked({**known, **at_any})
        given.pop("omega", None)
        return machine, given


def sheet_of(given: Mapping[str, object], file: Path | None) -> dict[str, object]:
    """Return the data sheet from options, which override those of a file."""
    given = {name: float(each) if isinstance(each, float) else each
             for name, each in given.items()} | _as_given(given)  # fmt: skip
    if file is None:
        return given
    from rotor_ida.results.machine_file import read_data_sheet  # noqa: PLC0415 - not for --help

    dimensionless = [name for name in PARAMETERS if name in given]
    if dimensionless:
        raise InputError(f"{dimensionless[0]} must be left out with a machine: it has no dimension")
    sheet = overridden(read_data_sheet(file), given)
    check_keys(sheet, str(file))
    return sheet


def _as_given(given: Mapping[str, object]) -> dict[str, object]:
    """Return a contact stiffness, whose unit decides its law, and a load that is the weight."""
    stiffness, load = given.get("contact_stiffness"), given.get("load")
    found: dict[str, object] = {}
    if isinstance(stiffness, Quantity) and stiffness.word:
        found["contact_stiffness"] = stiffness.word
    return found | ({"load": WEIGHT} if is_weight(load) else {})


def is_weight(load: object) -> bool:
    """Return whether a load is the word for the weight of the rotor."""
    return isinstance(load, Quantity) and load.word == WEIGHT


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
