"""The parameters of many rotors in synchronous whirl, as columns with one entry per rotor."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, shown
from rotor_ida.closed_forms.restoring_law import RestoringLaw
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import DEFAULTS, Parameters
from rotor_ida.model.rotor import DimensionalRotor, Rotor, check_no_load
from rotor_ida.model.varied import Range, Varied, varied_of


@dataclass(frozen=True, slots=True)
class RotorColumns:
    """Parameters of the whirls of many rotors [dimensionless]; arrays of the same shape.

    A parameter that is not given has its default, or NaN if it is required.
    """

    omega: Values
    zeta: Values
    delta0: Values
    shaft_stiffness: Values
    contact_exponent: Values
    contact_damping: Values
    friction: Values
    load: Values

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

    @property
    def laws(self) -> list[RestoringLaw]:
        """Stiffness and friction of each rotor."""
        columns = self.delta0, self.shaft_stiffness, self.contact_exponent, self.friction
        return [RestoringLaw(*row) for row in zip(*(c.tolist() for c in columns), strict=True)]

    def __getitem__(self, rows: Any) -> RotorColumns:
        """Return some of the rotors, by any index of NumPy."""
        return RotorColumns(*(getattr(self, field.name)[rows] for field in fields(self)))


def whirls_asked(
    verb: Callable[..., object],
    rotor: Rotor | DimensionalRotor | None,
    given: Parameters,
    ranges: Mapping[str, Range],
    left_out: Mapping[str, str] = {},
    *,
    under_load: bool = False,
) -> Varied:
    """Return what a function of synchronous whirls is asked to vary: see `varied_of`.

    The radius of the disc moves no whirl and is left out; a load must be 0, unless the function
    takes one. The largest value is 1e15 where `ranges` name no other.
    """
    asked = varied_of(
        verb, rotor, given, left_out=left_out, ranges=ranges, others=(0.0, LARGEST_NUMBER)
    )
    if not under_load:
        check_no_load(float(np.max(asked.values("load"), initial=0.0)), verb.__name__)
    if (radii := asked.values("disc_radius")).size > 1:
        raise InputError(f"disc_radius must be one number: it moves no whirl, got {shown(radii)}")
    loaded = asked.values("load").any()
    return asked.without(*([] if loaded else ["load"]), "disc_radius").check_size()
