"""The parameters of many rotors in synchronous whirl, as columns with one entry per rotor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_points
from rotor_ida.closed_forms.contact_laws import Range, RestoringLaw
from rotor_ida.model.parameters import DEFAULTS
from rotor_ida.model.rotors import Rotors, rotors_of


@dataclass(frozen=True, slots=True)
class RotorColumns:
    """Parameters of the whirls of many rotors [1]; arrays of the same shape.

    A parameter that is not given has its default, or NaN if it is required.
    """

    omega: Values
    zeta: Values
    delta0: Values
    shaft_stiffness: Values
    contact_exponent: Values
    contact_damping: Values
    friction: Values

    @classmethod
    def of(cls, values: Mapping[str, npt.ArrayLike]) -> RotorColumns:
        """Return columns of numbers and arrays that broadcast.

        Examples
        --------
        >>> rotors = RotorColumns.of({"omega": [1.2, 1.7], "zeta": 0.07, "delta0": 0.5})
        >>> rotors.zeta, rotors.contact_exponent
        (array([0.07, 0.07]), array([1.5, 1.5]))
        """
        names = [field.name for field in fields(cls)]
        given = [
            np.asarray(values.get(name, DEFAULTS.get(name, math.nan)), dtype=np.float64)
            for name in names
        ]
        return cls(*np.broadcast_arrays(*given))

    @classmethod
    def grid(cls, rotors: Rotors) -> RotorColumns:
        """Return the columns of all rotors of a study, the last dimension varying fastest."""
        grid = np.meshgrid(*rotors.axes.values(), indexing="ij")
        return cls.of({name: part.ravel() for name, part in zip(rotors.axes, grid, strict=True)})

    @property
    def laws(self) -> list[RestoringLaw]:
        """Stiffness and friction of each rotor."""
        columns = self.delta0, self.shaft_stiffness, self.contact_exponent, self.friction
        return [RestoringLaw(*row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def __getitem__(self, rows: Any) -> RotorColumns:
        """Return some of the rotors, by any index of NumPy."""
        return RotorColumns(*(getattr(self, field.name)[rows] for field in fields(self)))


def checked_rotors(given: Mapping[str, object], ranges: Mapping[str, Range]) -> Rotors:
    """Return the rotors of a study whose axes have been checked.

    Parameters
    ----------
    given : mapping of str to array_like
        A number or a vector for each parameter.
    ranges : mapping of str to tuple of two floats
        Smallest and largest value of some; for the others zero and 1e15.

    Examples
    --------
    >>> checked_rotors({"zeta": [0.1, 0.2], "friction": 0.0}, {"zeta": (1e-20, 1e6)}).dims
    ('zeta',)
    """
    for name, values in given.items():
        smallest, largest = ranges.get(name, (0.0, LARGEST_NUMBER))
        check_axis(name, values, smallest=smallest, largest=largest)
    rotors = rotors_of(given)
    check_points(*rotors.axes.values())
    return rotors
