"""A rotor system and its surroundings in the coordinates of a few modes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import check_array, check_count
from rotor_ida.errors import InputError
from rotor_ida.model.reduction import in_basis, reduced_basis
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.systems.assembly import check_parts


def check_modes(modes: int | None, more_modes: int | None) -> None:
    """Refuse a second number of modes that is no larger than the first."""
    if more_modes is None:
        return
    if modes is None:
        raise InputError("modes must be given with more_modes, got None")
    few, more = check_count("modes", modes, minimum=0), check_count("more_modes", more_modes)
    if more <= few:
        raise InputError(f"more_modes must be more than modes, {few}, got {more}")


def in_modes(system: RotorSystem, modes: int | None, around: Mapping[str, Any]) -> dict[str, Any]:
    """Return the system and its surroundings as keywords, reduced if a number of modes is given.

    The static flexibility of the nodes of all contacts is kept.
    """
    if modes is None:
        return {"system": system, **around}
    check_parts(system, around["contacts"], around["unbalance"])
    held = [each.node for each in around["contacts"]]
    held += [each.stator for each in around["contacts"] if isinstance(each.stator, str)]
    basis = reduced_basis(system, modes=modes, keep=list(dict.fromkeys(held)))
    force, start = around["static_force"], around["start"]
    if force is not None:
        whole = check_array("static_force", force)
        own = np.zeros(system.size) if system.static_force is None else system.static_force
        if whole.shape != own.shape:
            raise InputError(f"static_force must have the shape {own.shape}, got {whole.shape}")
        system = replace(system, static_force=own + whole)
    if isinstance(start, tuple | list) and len(start) == 2:
        names = ("displacement", "velocity")
        start = tuple(
            _reduced(f"{name} of the start", each, basis, system.mass)
            for name, each in zip(names, start, strict=True)
        )
    return {**around, "system": in_basis(system, basis), "static_force": None, "start": start}


def _reduced(name: str, given: object, basis: Values, mass: Values) -> Values:
    """Return the nearest state, by the mass, in the coordinates of a basis; stators stay."""
    values, size = check_array(name, given), len(basis)
    if values.ndim != 1 or values.size < size:
        raise InputError(f"{name} must have the shape {(size,)}, got {values.shape}")
    return np.concatenate([basis.T @ (mass @ values[:size]), values[size:]])
