"""A rotor system in the coordinates of a few modes."""

from __future__ import annotations

from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import check_array, check_count
from rotor_ida.errors import InputError
from rotor_ida.model.reduction import in_basis, reduced_basis
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.supports import levitated_system


def check_modes(modes: int | None, more_modes: int | None) -> None:
    """Refuse a second number of modes that is no larger than the first."""
    if more_modes is None:
        return
    if modes is None:
        raise InputError("modes must be given with more_modes, got None")
    few, more = check_count("modes", modes, minimum=0), check_count("more_modes", more_modes)
    if more <= few:
        raise InputError(f"more_modes must be more than modes, {few}, got {more}")


def in_modes(system: RotorSystem, modes: int | None, start: Any) -> tuple[RotorSystem, Any]:
    """Return a system and its start, reduced with its supports if a number of modes is given.

    The static flexibility of the nodes of all contacts is kept.
    """
    if modes is None:
        return system, start
    system = levitated_system(system)
    basis = reduced_basis(system, modes=modes)
    if isinstance(start, tuple | list) and len(start) == 2:
        names = ("displacement", "velocity")
        start = tuple(
            _reduced(f"{name} of the start", each, basis, system.mass)
            for name, each in zip(names, start, strict=True)
        )
    return in_basis(system, basis), start


def _reduced(name: str, given: object, basis: Values, mass: Values) -> Values:
    """Return the nearest state, by the mass, in the coordinates of a basis; stators stay."""
    values, size = check_array(name, given), len(basis)
    if values.ndim != 1 or values.size < size:
        raise InputError(f"{name} must have the shape {(size,)}, got {values.shape}")
    return np.concatenate([basis.T @ (mass @ values[:size]), values[size:]])
