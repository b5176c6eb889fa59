"""The matrices of a rotor of the package ROSS, of which nothing is imported."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import check_real, shown
from rotor_ida.errors import InputError, warn
from rotor_ida.model.bearing import Bearing
from rotor_ida.units import quantity

# Coefficients that differ by less than this part of them are constant.
CONSTANT = 1e-6
MOST_NAMED = 4


def system_of_ross(rotor: Any, *, speed: float | None) -> dict[str, Any]:
    """Return the arguments of a `RotorSystem` from a rotor of ROSS; see `RotorSystem.from_ross`."""
    omega = None if speed is None else check_real("speed", speed)
    if any(each.__name__ == "MultiRotor" for each in type(rotor).__mro__):
        raise InputError(
            "rotor must be one shaft line, got a MultiRotor: its shafts turn at different speeds"
        )
    try:
        found = _with_tables(rotor) if omega is None else _frozen(rotor, omega)
        nodes = _nodes(rotor, len(found["mass"]))
        found["gyroscopic"] = rotor.G()
    except (AttributeError, TypeError) as error:
        raise InputError(
            f"rotor must be a rotor of ROSS, with M, K, C and G, got {shown(rotor)} ({error})"
        ) from error
    if hasattr(rotor, "Ksdt"):
        found["stiffness_rate"] = rotor.Ksdt()
    fluid = found["mass"] - getattr(rotor, "M0", found["mass"])
    if fluid.any():
        found["added_mass"] = fluid
    along = list(getattr(rotor, "nodes_pos", []))
    # nodes of links have no position
    positions = dict(zip(nodes, along, strict=True)) if len(along) == len(nodes) else None
    return {**found, "nodes": nodes, "positions": positions}


def _with_tables(rotor: Any) -> dict[str, Any]:
    """Return the matrices without bearings and seals, and these with their own tables.

    What acts on them along the axis stays in the matrices, by the first row of a table.
    """
    matrices = {"stiffness": rotor.K0.copy(), "damping": rotor.C0.copy(), "mass": rotor.M0.copy()}
    bearings = []
    for each in rotor.bearing_elements:
        if _varies(each, "m"):
            raise InputError(
                f"speed must be given, as the added mass of {each.tag} depends on the speed"
            )
        first = 0.0 if each.frequency is None else float(np.ravel(each.frequency)[0])
        at = list(each.dof_global_index.values())
        matrices["mass"][np.ix_(at, at)] += each.M(first)
        across = [name[:2] in {"x_", "y_"} for name in each.dof_global_index]
        for name, whole in (("stiffness", each.K(first)), ("damping", each.C(first))):
            along = whole.copy()
            along[np.ix_(across, across)] = 0.0
            matrices[name][np.ix_(at, at)] += along
        bearings.append(_bearing(each, "k", "c"))
    return {**matrices, "bearings": bearings}


def _bearing(element: Any, stiffness: str, damping: str) -> Bearing:
    """Return a bearing whose coefficients are two of an element, by their letters."""
    node, *link = [name[2:] for name in element.dof_global_index if name.startswith("x_")]
    return Bearing(
        node=node, name=getattr(element, "tag", None) or None,
        stator=link[0] if link else None, speed=element.frequency,
        stiffness=_table(element, stiffness), damping=_table(element, damping),
    )  # fmt: skip


def _table(element: Any, letter: str) -> Values:
    """Return the table of a coefficient as it was given: ROSS itself smooths it."""
    rows = np.array([
        [np.ravel(getattr(element, f"{letter}{one}{other}")) for other in "xy"] for one in "xy"
    ], float)  # fmt: skip
    return np.moveaxis(rows, -1, 0)


def _frozen(rotor: Any, omega: float) -> dict[str, Any]:
    """Return the matrices with the coefficients at a speed, and a note on those that vary.

    Those across the axis are on the same cubics as those of a table that is kept.
    """
    of_speed = bool(inspect.signature(rotor.M).parameters)
    found = {"stiffness": rotor.K(omega), "damping": rotor.C(omega),
             "mass": rotor.M(omega) if of_speed else rotor.M()}  # fmt: skip
    varying = [each for each in getattr(rotor, "bearing_elements", ()) if _varies(each)]
    for each in varying:
        across = [name[:2] in {"x_", "y_"} for name in each.dof_global_index]
        at = np.array(list(each.dof_global_index.values()))[across]
        stiffness, damping = _bearing(each, "k", "c").at(omega)
        pairs = {"stiffness": (stiffness, each.K), "damping": (damping, each.C)}
        if of_speed:
            pairs["mass"] = (_bearing(each, "m", "m").at(omega)[0], each.M)
        for name, (own, smoothed) in pairs.items():
            whole = own if len(at) == 2 else np.kron([[1.0, -1.0], [-1.0, 1.0]], own)
            found[name][np.ix_(at, at)] += whole - smoothed(omega)[np.ix_(across, across)]
    note = _note(varying, omega) if varying else ""
    if note:
        warn(note)
    return found | {"note": note}


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


def _note(varying: Sequence[Any], omega: float) -> str:
    """Return a note on coefficients that depend on the speed."""
    return (
        f"coefficients that depend on the speed are frozen at {omega:.6g} rad/s "
        f"({quantity(omega, 'rad/s')}): {_listed(varying)}"
    )


def _listed(elements: Sequence[Any]) -> str:
    """Return the tags of elements, or the number of many."""
    if len(elements) > MOST_NAMED:
        return f"{len(elements)} bearings and seals"
    return ", ".join(str(each.tag) for each in elements)


def _varies(element: Any, letters: str = "kcm") -> bool:
    """Return whether coefficients of a bearing or seal depend on the speed."""
    if element.frequency is None:
        return False
    rows = [_table(element, letter) for letter in letters]
    return any(
        bool((np.abs(each - each[0]) > CONSTANT * np.abs(each).max()).any()) for each in rows
    )
