"""The rotors of a study: the given values of each parameter as axes, checked once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import check_axis, is_scalar
from rotor_ida.model.parameters import (
    ALL_PARAMETERS,
    DEFAULTS,
    PARAMETERS,
    check_clearance_needed,
    check_exponent,
)
from rotor_ida.model.rotor import Rotor


@dataclass(frozen=True, slots=True)
class Rotors:
    """The rotors of a study, as a grid: all combinations of the parameters' values.

    Parameters
    ----------
    axes : mapping of str to ndarray, shape (n,)
        The values of each given parameter, in the order of `ALL_PARAMETERS` [1]. An optional
        parameter given as a scalar equal to its default is left out.
    numbers : frozenset of str
        Optional parameters given as one number: scalar coordinates of a result, not dimensions.
        ``omega``, ``zeta`` and ``delta0`` are always dimensions.
    """

    axes: Mapping[str, Values]
    numbers: frozenset[str] = frozenset()

    @property
    def dims(self) -> tuple[str, ...]:
        """Parameters that are dimensions of a result, in order."""
        return tuple(name for name in self.axes if name not in self.numbers)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Number of values along each dimension."""
        return tuple(self.axes[name].size for name in self.dims)

    @property
    def points(self) -> int:
        """Number of rotors."""
        return math.prod(self.sizes)

    @property
    def optional(self) -> tuple[str, ...]:
        """Optional parameters that are given and are not one default number."""
        return tuple(name for name in self.axes if name not in PARAMETERS)

    @property
    def coordinates(self) -> dict[str, Column]:
        """The coordinates of a result: an axis of each dimension, and the numbers."""
        return {
            name: ((), axis[0]) if name in self.numbers else (name, axis)
            for name, axis in self.axes.items()
        }

    @property
    def values(self) -> dict[str, float | list[float]]:
        """The values as plain numbers and lists, as a study stores them."""
        return {
            name: axis.item() if name in self.numbers else axis.tolist()
            for name, axis in self.axes.items()
        }

    def axis(self, name: str) -> Values:
        """Return the values of a parameter, or its default if not given."""
        default = DEFAULTS.get(name)
        return self.axes.get(name, np.array([math.nan if default is None else default]))

    def rotor(self, place: tuple[int, ...]) -> Rotor:
        """Return the rotor at a place of the grid, an index along each dimension."""
        at = dict(zip(self.dims, place, strict=True))
        return Rotor(**{name: float(axis[at.get(name, 0)]) for name, axis in self.axes.items()})

    def extremes(self) -> list[Rotor]:
        """Return rotors with each value of each parameter, and the largest of all others.

        For the damping ratio and the shaft stiffness the largest value is enough: if any rotor
        cannot be simulated, then this one cannot.
        """
        largest = {name: float(values.max()) for name, values in self.axes.items()}
        return [
            Rotor(**largest | {name: value})
            for name, values in self.axes.items()
            if name not in {"zeta", "shaft_stiffness"}
            for value in values.tolist()
        ]

    def __len__(self) -> int:
        return self.points


def rotors_of(given: Mapping[str, object], largest: float = math.inf) -> Rotors:
    """Return the rotors of a study, from the user's arguments by name.

    Parameters
    ----------
    given : mapping of str to array_like or None
        A number or a vector for each given parameter; `disc_radius` may be None.
    largest : float
        Largest allowed value of an optional parameter [1].

    Raises
    ------
    InputError
        If a value is not a finite number that is zero or positive, or if values exclude each other.

    Examples
    --------
    >>> rotors = rotors_of({"omega": [1.2, 1.7], "zeta": 0.07, "delta0": 0.5, "load": 0.1,
    ...                     "shaft_stiffness": [0.0, 0.25], "friction": 0.0})
    >>> rotors.dims, rotors.sizes, sorted(rotors.numbers)
    (('omega', 'zeta', 'delta0', 'shaft_stiffness'), (2, 1, 1, 2), ['load'])
    >>> rotors.rotor((1, 0, 0, 1))
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=0.25, load=0.1)
    """
    axes: dict[str, Values] = {}
    numbers = set()
    for name in ALL_PARAMETERS:
        value, optional = given.get(name), name in DEFAULTS
        if name not in given or (value is None and optional and DEFAULTS[name] is None):
            continue
        axis = check_axis(name, value, largest=largest if optional else math.inf)
        if optional and is_scalar(name, value):
            if axis.tolist() == [DEFAULTS[name]]:
                continue
            numbers.add(name)
        axes[name] = axis
    for exponent in np.unique(axes.get("contact_exponent", [])).tolist():
        check_exponent(exponent)
    if (axes.get("delta0", np.ones(1)) == 0.0).any():
        check_clearance_needed(
            {
                name: float(axes[name].max()) if name in axes else 0.0
                for name in ("friction", "contact_damping")
            }
        )
    return Rotors(axes, frozenset(numbers))
