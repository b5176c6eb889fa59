"""What drops are computed from, as a design that studies and archives keep in JSON, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Race, Stator, Support, Unbalance

ARRAYS = ("mass", "stiffness", "damping", "gyroscopic", "stiffness_rate", "translations",
          "static_force", "added_mass")  # fmt: skip
# What a design holds of a drop.
OF_CASE = (
    "system", "stators", "bearings", "supports", "unbalance", "speed", "duration", "failing",
    "gravity", "static_force", "inertia", "drag", "clearances",
    "capacities", "modes", "rtol", "phase", "start", "more_modes", "method",
)  # fmt: skip
# The variable of a dataset that has its design.
DESIGN = "design"


def plain_case(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `drop` as plain lists, numbers and text.

    Examples
    --------
    >>> system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)})
    >>> shared = Stator(mass=1.0, stiffness=2.0)
    >>> bearing = Contact(node="disc", clearance=0.5, stiffness=4.0, stator=shared)
    >>> given = {"system": system, "bearings": [bearing], "supports": [], "unbalance": [],
    ...          "speed": 2.0, "gravity": (0.0, -1.0), "failing": None}
    >>> again = case_from(plain_case(given))
    >>> again["bearings"][0].stator.stiffness, again["speed"]
    ((2.0, 2.0), 2.0)
    >>> plain_case(again) == plain_case(given)
    True
    """
    bearings: Sequence[Contact] = case["bearings"]
    stators = list({id(each.stator): each.stator for each in bearings
                    if isinstance(each.stator, Stator)}.values())  # fmt: skip
    rows = [
        asdict(replace(each, stator=None))
        | {"stator": stators.index(each.stator) if isinstance(each.stator, Stator) else each.stator}
        for each in bearings
    ]
    parts = ("system", "bearings", "supports", "unbalance")
    found = {name: _plain(value) for name, value in case.items() if name not in parts}
    return found | {
        "system": _plain_system(case["system"]),
        "stators": [asdict(each) for each in stators], "bearings": rows,
        "supports": [asdict(each) for each in case["supports"]],
        "unbalance": [asdict(each) for each in case["unbalance"]],
    }  # fmt: skip


def as_text(design: Mapping[str, Any]) -> str:
    """Return a design as the text that a dataset keeps."""
    return json.dumps(design, separators=(",", ":"))


def design_in(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the design in a dataset."""
    if DESIGN not in dataset:
        kind = dataset.attrs.get("result_kind")
        raise InputError(f"this {kind} cannot be verified: it lacks {DESIGN}")
    try:
        found = json.loads(str(dataset[DESIGN].values))
    except (ValueError, RecursionError) as error:
        raise InputError(
            f"{DESIGN} must be JSON, got {shown(str(dataset[DESIGN].values))}"
        ) from error
    if not isinstance(found, dict):
        raise InputError(f"{DESIGN} must be that of drops, got {shown(found)}")
    return found


def case_from(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `drop` from the plain ones, among others in a design."""
    found = {name: plain[name] for name in OF_CASE if name in plain and name != "stators"}
    stators = [Stator(**{**each, "race": _race(each["race"])}) for each in plain["stators"]]
    bearings = []
    for each in plain["bearings"]:
        stator = stators[each["stator"]] if isinstance(each["stator"], int) else each["stator"]
        bearings.append(Contact(**{**each, "race": _race(each["race"]), "stator": stator}))
    given = dict(plain["system"])
    nodes = {
        name: (int(place[0]), int(place[1])) if np.ndim(place) == 1 else np.array(place)
        for name, place in given.pop("nodes").items()
    }
    arrays: dict[str, Any] = {
        name: np.array(given[name]) for name in ARRAYS if given[name] is not None
    }
    rest = {name: each for name, each in given.items() if name not in ARRAYS}
    return found | {
        "system": RotorSystem(**arrays, nodes=nodes, **rest), "bearings": bearings,
        "supports": [Support(**each) for each in plain["supports"]],
        "unbalance": [Unbalance(**each) for each in plain["unbalance"]],
    }  # fmt: skip


def _plain_system(system: RotorSystem) -> dict[str, Any]:
    """Return a system as lists."""
    found = {name: _plain(getattr(system, name)) for name in ARRAYS}
    return found | {
        "nodes": {name: _plain(place) for name, place in system.nodes.items()},
        "gravity_in_static_force": _plain(system.gravity_in_static_force),
        "positions": None if system.positions is None else dict(system.positions),
        "units": system.units,
        "note": system.note,
    }


def _plain(value: Any) -> Any:
    """Return an array or sequence of numbers as a list, and a number as it is."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, Mapping):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, list | tuple) and all(isinstance(each, str) for each in value):
        return list(value)
    numbers = np.asarray(value)
    return (numbers.astype(float) if numbers.dtype == object else numbers).tolist()


def _race(given: Mapping[str, Any] | None) -> Race | None:
    return None if given is None else Race(**given)
