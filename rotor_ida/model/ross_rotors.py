"""The matrices of a rotor of the package ROSS, of which nothing is imported."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import check_real, shown
from rotor_ida.errors import InputError, warn
from rotor_ida.units import quantity

# Coefficients that differ by less than this part of them are constant.
CONSTANT = 1e-6
MOST_NAMED = 4


def system_of_ross(rotor: Any, *, speed: float) -> dict[str, Any]:
    """Return the arguments of a `RotorSystem` from a rotor of ROSS; see `RotorSystem.from_ross`."""
    omega = check_real("speed", speed)
    if any(each.__name__ == "MultiRotor" for each in type(rotor).__mro__):
        raise InputError(
            "rotor must be one shaft line, got a MultiRotor: its shafts turn at different speeds"
        )
    try:
        mass = rotor.M(omega) if inspect.signature(rotor.M).parameters else rotor.M()
        found = {
            "mass": mass, "stiffness": rotor.K(omega), "damping": rotor.C(omega),
            "gyroscopic": rotor.G(),
        }  # fmt: skip
        nodes = _nodes(rotor, len(mass))
    except (AttributeError, TypeError) as error:
        raise InputError(
            f"rotor must be a rotor of ROSS, with M, K, C and G, got {shown(rotor)} ({error})"
        ) from error
    if hasattr(rotor, "Ksdt"):
        found["stiffness_rate"] = rotor.Ksdt()
    fluid = mass - getattr(rotor, "M0", mass)
    if fluid.any():
        found["added_mass"] = fluid
    along = list(getattr(rotor, "nodes_pos", []))
    # nodes of links have no position
    positions = dict(zip(nodes, along, strict=True)) if len(along) == len(nodes) else None
    note = _frozen(rotor, omega)
    if note:
        warn(note)
    return {**found, "nodes": nodes, "positions": positions, "note": note}


def _nodes(rotor: Any, size: int) -> dict[str, tuple[int, int]]:
    """Return the coordinates of all nodes along x and y.

    A node of the shaft has `number_dof` coordinates, one that a link adds has three: where they
    are is known to the elements alone.
    """
    if not hasattr(rotor, "elements"):
        step = int(rotor.number_dof)
        return {str(i): (step * i, step * i + 1) for i in range(size // step)}
    places: dict[str, int] = {}
    for element in rotor.elements:
        places |= element.dof_global_index
    numbers = sorted(int(name[2:]) for name in places if name.startswith("x_"))
    return {str(i): (places[f"x_{i}"], places[f"y_{i}"]) for i in numbers}


def _frozen(rotor: Any, omega: float) -> str:
    """Return a note on coefficients that depend on the speed, "" if there are none."""
    varying = [each for each in getattr(rotor, "bearing_elements", ()) if _varies(each)]
    if not varying:
        return ""
    note = (
        f"coefficients that depend on the speed are frozen at {omega:.6g} rad/s "
        f"({quantity(omega, 'rad/s')}): {_listed(varying)}"
    )
    outside = [each for each in varying
               if not min(each.frequency) <= omega <= max(each.frequency)]  # fmt: skip
    return f"{note}; the tables do not reach this speed: {_listed(outside)}" if outside else note


def _listed(elements: Sequence[Any]) -> str:
    """Return the tags of elements, or the number of many."""
    if len(elements) > MOST_NAMED:
        return f"{len(elements)} bearings and seals"
    return ", ".join(str(each.tag) for each in elements)


def _varies(element: Any) -> bool:
    """Return whether the coefficients of a bearing or seal depend on the speed."""
    if element.frequency is None:
        return False
    rows: list[Values] = [
        np.array([matrix(each) for each in element.frequency])
        for matrix in (element.K, element.C, element.M)
    ]
    return any(
        bool((np.abs(each - each[0]) > CONSTANT * np.abs(each).max()).any()) for each in rows
    )
