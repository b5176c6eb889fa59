"""Limit cycles of rotor systems and their branches as labelled datasets."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind
from rotor_ida.cycles.dataset import of_cycle
from rotor_ida.cycles.multipliers import is_stable, multipliers_of
from rotor_ida.cycles.system_guess import CLOSING_RTOL, CycleProblem
from rotor_ida.cycles.system_orbit import SystemOrbit
from rotor_ida.cycles.system_problem import SystemGuess
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import QUANTITIES, RESPONSE, SPECIAL, STABILITY, labelled_dataset
from rotor_ida.steady.system_motion import features_of
from rotor_ida.systems.units import with_system_units

OF_CONTACT = ("contact_count", "radius_min", "radius_max", "largest_force", "touched")
OF_NODE = ("node_radius_min", "node_radius_max")
AXES = {True: "turning", False: "fixed"}


def numbers_of(problem: CycleProblem, cycle: SystemOrbit) -> dict[str, Any]:
    """Return the numbers of a cycle: scalars, and arrays on multiplier, contact and node."""
    multipliers = multipliers_of(cycle)
    features = features_of(cycle.flow, cycle.start, cycle.sample_times, cycle.sampled)
    return {
        "period": cycle.duration,
        "response": np.int8(RESPONSE[cycle.response]),
        "stability": np.int8(STABILITY["stable" if is_stable(cycle) else "unstable"]),
        "residual": cycle.missed,
        "trivial_defect": _trivial_defect(cycle),
        "multiplier_real": multipliers.real,
        "multiplier_imag": multipliers.imag,
        "contact_count": np.array(cycle.contact_counts),
        "radius_min": features.contact_low,
        "radius_max": features.contact_high,
        "largest_force": features.largest_force,
        "touched": features.touches.astype(np.int8),
        "node_radius_min": features.node_low,
        "node_radius_max": features.node_high,
        "final_state": problem.state_in_q(cycle.flow, cycle.start),
    }


def _trivial_defect(cycle: SystemOrbit) -> float:
    """Return ``|M f - f|/|f|`` with the rate f at the start; NaN where no multiplier is 1."""
    if not cycle.is_autonomous:
        return math.nan
    rate = cycle.start_rate
    return float(np.linalg.norm(cycle.monodromy @ rate - rate) / np.linalg.norm(rate))


def _dims_of(name: str) -> tuple[str, ...]:
    """Return the dimensions of a number of a cycle."""
    if name.startswith("multiplier_"):
        return ("multiplier",)
    if name in OF_CONTACT:
        return ("contact",)
    if name in OF_NODE:
        return ("node",)
    return ("component",) if name.endswith("_state") else ()


def _labelled_as_cycle(dataset: xr.Dataset, problem: CycleProblem) -> xr.Dataset:
    """Return a dataset with the words and units of cycles of its system."""
    where = "distance of the contact from the centre of its stator"
    words = {
        "radius_min": f"smallest {where}", "radius_max": f"largest {where}",
        "special_radius_max": f"largest {where} at the special point",
        "node_radius_min": "smallest distance of the node from the axis",
        "node_radius_max": "largest distance of the node from the axis",
        "touched": "whether the contact is touched",
        "final_state": "displacement and velocity of all coordinates, and speeds of races, at the "
        "start of the period, with the unbalance at angle 0",
    }  # fmt: skip
    for name in words.keys() & dataset.variables.keys():
        dataset[name].attrs["long_name"] = words[name]
    return with_system_units(dataset, problem.assembly.system)


def system_cycle_dataset(
    problem: CycleProblem,
    guess: SystemGuess,
    cycle: SystemOrbit | None,
    response: str,
    errors: tuple[float, Values],
) -> xr.Dataset:
    """Return a limit cycle, or the response found instead, as a labelled dataset."""
    held = problem.described()
    count = guess.flow.scales.size
    if cycle is None:
        numbers = _none(problem, response, count)
    else:
        numbers = numbers_of(problem, cycle)
        numbers |= {"period_error": errors[0], "multiplier_error": errors[1]}
    variables: dict[str, Any] = {
        name: of_cycle(name, _dims_of(name), values) for name, values in numbers.items()
    }
    nodes = len(problem.assembly.system.nodes)
    times = np.zeros(0) if cycle is None else cycle.sample_times
    orbits = np.zeros((4, 0, nodes)) if cycle is None else _orbits(problem, cycle)
    turning = problem.settling.forward is not None
    for name, values in zip(COMPONENTS, orbits, strict=True):
        label = QUANTITIES[f"rotating_{name}" if turning else name]
        variables[name] = xr.Variable(("t", "node"), values, label.attributes())
    coordinates: dict[str, Any] = {
        "speed": ((), guess.flow.speed), "t": of_cycle("t", "t", times), "node": held.pop("node"),
        "multiplier": ("multiplier", np.arange(count)),
    }  # fmt: skip
    if "axial_position" in held:
        coordinates["axial_position"] = held.pop("axial_position")
    attributes = provenance({"method": "taylor", "rtol": CLOSING_RTOL}) | {"axes": AXES[turning]}
    dataset = labelled_dataset(
        "Limit cycle of a rotor system", {**variables, **held}, coordinates, attributes,
        kind="system_cycle",
    )  # fmt: skip
    return _labelled_as_cycle(dataset, problem)


def _orbits(problem: CycleProblem, cycle: SystemOrbit) -> Values:
    """Return ``x y vx vy`` of the nodes, shape (4, t, node), on the axes where it closes."""
    found = problem.settling.found
    rows = found.rows_in_y(problem.assembly.node_rows())
    moved = cycle.sampled.samples @ (rows[:, 0] + 1j * rows[:, 1]).T  # (t, 2, node)
    if cycle.is_autonomous:
        moved = moved * np.exp(-1j * cycle.flow.speed * cycle.sample_times)[:, None, None]
    place, velocity = moved[:, 0], moved[:, 1]
    return np.stack([place.real, place.imag, velocity.real, velocity.imag])


def _none(problem: CycleProblem, response: str, count: int) -> dict[str, Any]:
    """Return the numbers of a result without a limit cycle."""
    contacts, nodes = len(problem.assembly.contacts), len(problem.assembly.system.nodes)
    numbers: dict[str, Any] = dict.fromkeys(
        ("period", "period_error", "residual", "trivial_defect"), math.nan
    )
    numbers |= {
        "response": np.int8(RESPONSE[response]), "stability": np.int8(STABILITY["absent"])
    }  # fmt: skip
    sizes = {"multiplier": count, "contact": contacts, "node": nodes, "component": count}
    vectors = ("multiplier_real", "multiplier_imag", "multiplier_error", "radius_min",
               "radius_max", "largest_force", *OF_NODE, "final_state")  # fmt: skip
    numbers |= {name: np.full(sizes[_dims_of(name)[0]], math.nan) for name in vectors}
    return numbers | {
        "contact_count": np.zeros(contacts, np.int64), "touched": np.zeros(contacts, np.int8)
    }  # fmt: skip


# ---- Branches ----


def system_branch_dataset(
    problem: CycleProblem, sides: tuple[Side[SystemOrbit], Side[SystemOrbit]]
) -> xr.Dataset:
    """Return both sides, forward and backward, of a branch, from end to end."""
    forward, backward = sides
    before = len(backward.points) - 1
    points = [point.reversed() for point in backward.points[:0:-1]] + forward.points
    specials = [SpecialBehind(before - place - 1, each) for place, each in backward.specials[::-1]]
    specials += [SpecialBehind(before + place, each) for place, each in forward.specials]
    rows = [numbers_of(problem, point.stretch) for point in points]
    variables: dict[str, Any] = {
        name: of_cycle(name, ("point", *_dims_of(name)), np.array([row[name] for row in rows]))
        for name in rows[0]
    }
    variables["slope"] = of_cycle("slope", "point", [point.tangent[-1] for point in points])
    variables |= _special_columns(problem, specials)
    held = problem.described()
    coordinates: dict[str, Any] = {
        "speed": ("point", np.array([point.unknowns[-1] for point in points])),
        "node": held.pop("node"),
        "multiplier": ("multiplier", np.arange(len(points[0].stretch.start))),
    }
    if "axial_position" in held:
        coordinates["axial_position"] = held.pop("axial_position")
    closed = forward.end == CLOSED
    ends = {
        "closed": int(closed),
        "first_end": CLOSED if closed else backward.end or "start",
        "last_end": forward.end or "start",
        "first_reason": backward.reason,
        "last_reason": forward.reason,
        "axes": AXES[points[0].stretch.is_autonomous],
    }
    dataset = labelled_dataset(
        "Branch of limit cycles of a rotor system", {**variables, **held}, coordinates, ends,
        kind="system_branch",
    )  # fmt: skip
    return _labelled_as_cycle(dataset, problem)


def _special_columns(
    problem: CycleProblem, specials: Sequence[SpecialBehind[SystemOrbit]]
) -> dict[str, Column]:
    """Return the special points, in order along the branch."""
    orbits = [each.point.stretch for _, each in specials]
    contacts = len(problem.assembly.contacts)
    states = [problem.state_in_q(orbit.flow, orbit.start) for orbit in orbits]
    radii = np.array([orbit.sizes.reshape(2, -1)[1] for orbit in orbits])
    size = 2 * problem.assembly.size + int(problem.settling.with_race.sum())
    return {
        "special_kind": ("special", np.array([SPECIAL[e.name] for _, e in specials], np.int8)),
        "special_speed": ("special", np.array([orbit.flow.speed for orbit in orbits])),
        "special_period": ("special", np.array([orbit.duration for orbit in orbits])),
        "special_point": ("special", np.array([place for place, _ in specials], np.int64)),
        "special_radius_max": (("special", "contact"), radii.reshape(-1, contacts)),
        "special_state": (("special", "component"), np.array(states).reshape(-1, size)),
    }
