"""The inputs of a result of a rotor system as variables of its dataset, and back.

The matrices are those that were integrated: of a reduced system, the reduced ones. Gravity is
within the constant force. So a result can be computed again, to the bit, from its dataset alone.
A sweep has its system in its question.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Race, Stator, Unbalance
from rotor_ida.results.question import MATRIX, STATE, Question
from rotor_ida.results.si_units import NOTE

MATRICES = ("mass", "damping", "gyroscopic", "stiffness", "stiffness_rate")
LAW = ("stiffness", "exponent", "damping", "friction", "radius")
OF_RACE = ("radius", "inertia", "drag", "speed")
OF_BEARING = ("speed", "stiffness", "damping")
OF_STATOR = {"mass": ("stator",), "stiffness": ("stator", "axis"), "damping": ("stator", "axis")}
NEEDED = (
    *("mass_matrix", "stiffness_matrix", "node_rows", "constant_force"),
    *("clearance", "stator_number", "centre_x", "centre_y", "stator_mass", "stator_stiffness"),
    *(f"law_{name}" for name in LAW),
    *(f"race_{name}" for name in OF_RACE),
    *("stator_damping", "unbalance_moment", "unbalance_phase"),
)

# The clearances of contacts where `clearance` is an axis.
OF_CONTACTS = "contact_clearance"
# Variables whose units say whether a system is in SI units.
SPEEDS = ("t", "speed", "special_speed")
NAMES = ("node", "contact_node", "contact_stator", "unbalance_node")


def problem_variables(assembly: Assembly, start: Values | None = None) -> dict[str, Column]:
    """Return what a result is computed from, but for its nodes and speed.

    Parameters
    ----------
    assembly : Assembly
        The system with its stators, contacts and forces.
    start : ndarray, shape (2, n), optional
        Displacement and velocity at time 0, of a run.
    """
    system, unbalance = assembly.system, assembly.system.unbalance
    square = ("freedom", "freedom_too")
    found: dict[str, Column] = {
        f"{name}_matrix": (square, matrix)
        for name in MATRICES
        if (matrix := getattr(system, name)) is not None
    }
    rows = np.array([system.rows(name) for name in system.nodes]).reshape(-1, 2, system.size)
    found["node_rows"] = (("node", "axis", "freedom"), rows)
    found["constant_force"] = ("assembled_freedom", assembly.force)
    if assembly.gravity.any():
        found["gravity"] = ("axis", assembly.gravity)
    if start is not None:
        found[STATE] = ("coordinate", start.ravel())
    found |= _bearings(system.bearings) | _contacts(assembly)
    for name, dims in OF_STATOR.items():
        values = np.array([getattr(each, name) for each in assembly.stators], float)
        found[f"stator_{name}"] = (dims, values.reshape(-1, *(2,) * (len(dims) - 1)))
    found["unbalance_node"] = ("unbalance", np.array([each.node for each in unbalance], str))
    for name in ("moment", "phase"):
        values = np.array([getattr(each, name) for each in unbalance], float)
        found[f"unbalance_{name}"] = ("unbalance", values)
    return found


def _bearings(bearings: Sequence[Bearing]) -> dict[str, Column]:
    """Return the tables of bearings over the speed, one below the other; nothing without any."""
    if not bearings:
        return {}
    numbers = np.repeat(np.arange(len(bearings)), [each.knots.size for each in bearings])
    joined = {name: np.concatenate([np.asarray(getattr(each, name)) for each in bearings])
              for name in OF_BEARING}  # fmt: skip
    return {
        "bearing_node": ("bearing", np.array([each.node for each in bearings], str)),
        **{f"bearing_{key}": ("bearing", np.array([getattr(each, key) or "" for each in bearings]))
           for key in ("stator", "name")},
        "table_bearing": ("bearing_row", numbers.astype(np.int16)),
        **{f"table_{name}": (("bearing_row", "axis", "axis_too")[: values.ndim], values)
           for name, values in joined.items()},
    }  # fmt: skip


def _bearings_of(run: xr.Dataset) -> list[Bearing]:
    """Return the bearings of a result whose coefficients depend on the speed."""
    if "bearing_node" not in run.variables:
        return []
    found = []
    names = ("node", "stator", "name")
    for number, words in enumerate(_rows(run, [f"bearing_{each}" for each in names])):
        rows = run.isel(bearing_row=run["table_bearing"].values == number)
        given: dict[str, Any] = {name: rows[f"table_{name}"].values for name in OF_BEARING}
        given |= {name: word or None for name, word in zip(names, words, strict=True)}
        found.append(Bearing(**given))
    return found


def _contacts(assembly: Assembly) -> dict[str, Column]:
    """Return the nodes, stators, laws and races of the contacts."""
    contacts = assembly.contacts
    stators = [
        each.stator if isinstance(each.stator, str)
        else "" if each.stator is None
        else f"stator {assembly.stators.index(each.stator)}"
        for each in contacts
    ]  # fmt: skip
    centres = np.array([each.centre for each in contacts]).reshape(-1, 2)

    def column(values: Sequence[Any]) -> Column:
        return "contact", np.array(values, float)

    numbers = [
        assembly.stators.index(each.stator) if isinstance(each.stator, Stator) else -1
        for each in contacts
    ]
    shared = [each.race is None and each.spinning_race is not None for each in contacts]
    nothing = dict.fromkeys(OF_RACE, np.nan)
    races = [
        nothing if race is None else {name: getattr(race, name) for name in OF_RACE}
        for race in assembly.races
    ]
    return {
        "contact_node": ("contact", np.array([each.node for each in contacts], str)),
        "clearance": column([each.clearance for each in contacts]),
        "contact_stator": ("contact", np.array(stators, str)),
        "centre_x": ("contact", centres[:, 0]),
        "centre_y": ("contact", centres[:, 1]),
        "stator_number": ("contact", np.array(numbers, np.int16)),
        **{f"law_{name}": column([getattr(each, name) for each in contacts]) for name in LAW},
        **{f"race_{name}": column([race[name] for race in races]) for name in OF_RACE},
        **({"race_is_of_stator": ("contact", np.array(shared, np.int8))} if any(shared) else {}),
    }


def system_of(run: xr.Dataset) -> RotorSystem:
    """Return the system of a result.

    Raises
    ------
    InputError
        If a part of it is missing.

    Examples
    --------
    >>> from rotor_ida import simulate
    >>> system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...                      unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> run = simulate(system, speed=0.9, duration=20.0, samples=3)
    >>> simulate(system_of(run), speed=0.9, duration=20.0, samples=3).equals(run)
    True
    """
    question = Question.of_result(run) if MATRIX not in run.variables else None
    if question and isinstance(question.arguments.get("rotor"), RotorSystem):  # of a sweep
        system: RotorSystem = question.arguments["rotor"]
        return system
    missing = [name for name in (*NEEDED, *NAMES) if name not in run.variables]
    missing += [dim for dim in ("contact", "node") if dim not in run.sizes]
    if missing:
        raise InputError(f"a result of a rotor system must have {', '.join(missing)}, got none")
    matrices: Any = {
        name: run[f"{name}_matrix"].values for name in MATRICES if f"{name}_matrix" in run
    }
    nodes = dict(zip(run["node"].values.tolist(), run["node_rows"].values, strict=True))
    si = any(run[name].attrs.get("units") in {"s", "s-1"} for name in SPEEDS if name in run)
    positions = None
    if "axial_position" in run.variables:
        positions = dict(zip(nodes, run["axial_position"].values.tolist(), strict=True))
    shared = _races_of_stators(run)
    stators = [
        Stator(mass=mass, stiffness=tuple(stiffness), damping=tuple(damping),
               race=shared.get(number))
        for number, (mass, stiffness, damping) in enumerate(
            _rows(run, [f"stator_{name}" for name in OF_STATOR]))
    ]  # fmt: skip
    return RotorSystem(
        **matrices, nodes=nodes, positions=positions, units="SI" if si else "1",
        contacts=[_contact(run.isel(contact=i), stators) for i in range(run.sizes["contact"])],
        unbalance=[
            Unbalance(node=node, moment=moment, phase=phase) for node, moment, phase in
            _rows(run, [f"unbalance_{name}" for name in ("node", "moment", "phase")])
        ],
        bearings=_bearings_of(run), static_force=run["constant_force"].values,
        gravity_in_static_force=tuple(run["gravity"].values) if "gravity" in run else None,
        note=run.attrs.get(NOTE, ""),
    )  # fmt: skip


def _race(row: xr.Dataset) -> Race | None:
    """Return the race of one contact of a run."""
    race = {name: float(row[f"race_{name}"]) for name in OF_RACE}
    return None if np.isnan(race["radius"]) else Race(**race)


def _races_of_stators(run: xr.Dataset) -> dict[int, Race | None]:
    """Return the races that belong to stators, by the numbers of these."""
    if "race_is_of_stator" not in run:
        return {}
    rows = run.isel(contact=run["race_is_of_stator"].values != 0)
    numbers = rows["stator_number"].values.tolist()
    return {number: _race(rows.isel(contact=i)) for i, number in enumerate(numbers)}


def _contact(row: xr.Dataset, stators: Sequence[Stator]) -> Contact:
    """Return one contact of a run."""
    numbers = {name: float(row[f"law_{name}"]) for name in LAW}
    radius = numbers.pop("radius")
    number, name = int(row["stator_number"]), str(row["contact_stator"].values)
    return Contact(
        node=str(row["contact_node"].values), clearance=float(row["clearance"]), **numbers,
        radius=None if np.isnan(radius) else radius,
        centre=(float(row["centre_x"]), float(row["centre_y"])),
        stator=stators[number] if number >= 0 else name or None,
        race=None if number >= 0 and stators[number].race is not None else _race(row),
    )  # fmt: skip


def _rows(run: xr.Dataset, names: Sequence[str]) -> list[tuple[Any, ...]]:
    """Return variables along one dimension row by row."""
    return list(zip(*(run[name].values.tolist() for name in names), strict=True))


def clearance_of_contacts(result: xr.Dataset) -> xr.DataArray:
    """Return the clearance of each contact, along `clearance` too where that is an axis."""
    return result[OF_CONTACTS if OF_CONTACTS in result.variables else "clearance"]


def described_problem(assembly: Assembly) -> dict[str, Column]:
    """Return what a result over the speed is computed from, and where its nodes are."""
    found = problem_variables(assembly)
    if (positions := assembly.system.positions) is not None:
        found["axial_position"] = ("node", np.array(list(positions.values())))
    return found
