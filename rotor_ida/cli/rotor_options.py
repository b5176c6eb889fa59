"""Options for a rotor or for several: dimensionless, in SI units, or of a file."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from cyclopts import Parameter

from rotor_ida.cli import machines
from rotor_ida.cli.option_types import (
    IN_ROTOR,
    ROTOR,
    number_option,
    numbers_option,
    path_option,
    quantity_option,
)
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import units_of
from rotor_ida.model.parameters import MACHINE_PARAMETERS, OPTIONAL, TABLE
from rotor_ida.model.parameters import Parameter as Quantity
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.scales import BECOMES

# Placeholder where a speed is required but not used.
ANY_SPEED = 1.0
# The speed of a rotor, without dimensions and in SI units.
SPEEDS = ("omega", "speed")
MachineFile = Annotated[
    Path | None,
    path_option("Machine in SI units, as written by rotor-ida machine; other options override it."),
    IN_ROTOR,
]


def _units_of(parameter: Quantity) -> tuple[str, ...]:
    """Return the allowed units of an option for a parameter of a machine."""
    if parameter.unit == "1":
        return ()
    return units_of(parameter.name)


# For one rotor or several, dimensionless or in SI units, or in an archive.
ONE = {
    each.name: Annotated[
        float | None,
        quantity_option(each.either_help, *_units_of(each))
        if _units_of(each)
        else number_option(each.either_help),
    ]
    for each in TABLE
}
SEVERAL = {
    each.name: Annotated[
        list[float] | None, numbers_option(each.either_axis_help, *_units_of(each))
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

    if TYPE_CHECKING:
        machine: Path | None = None

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
@with_parameters({**ONE, "machine": MachineFile})
class RotorOptions(Given):
    """One rotor, without dimensions or in SI units."""

    def chosen(self, known: Mapping[str, float] = {}) -> Rotor | DimensionalRotor:
        """Return the rotor, dimensionless or in SI units, from the given and `known` quantities."""
        return machines.chosen({**self.given, **known}, self.machine, OPTIONAL)


@Parameter(name="*", group=ROTOR)
@dataclass(frozen=True, kw_only=True)
@with_parameters({**SEVERAL, "machine": MachineFile})
class RotorsOptions(Given):
    """The rotors of a study; without an optional parameter, all have its default."""

    def asked(
        self, known: Mapping[str, list[float]] = {}
    ) -> tuple[DimensionalRotor | None, dict[str, Any]]:
        """Return the machine, if it is one, and the quantities that are given or vary.

        One value of an optional parameter does not make an axis.
        """
        values = {**self.given, **known}
        if self.machine is None:
            machines.check_complete(values, OPTIONAL)
        if self.in_si:
            return machines.varied(values, self.machine)
        return None, {
            name: each[0] if name in OPTIONAL and len(each) == 1 else each
            for name, each in values.items()
        }

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
            machines.check_complete(self.given, OPTIONAL, known=(speed,))
        at_any = {speed: [ANY_SPEED]} if self.machine is None else {}
        machine, given = super().asked({**known, **at_any})
        given.pop("omega", None)
        return machine, given
