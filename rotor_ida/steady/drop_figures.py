"""Results of a drop: forces, impulses, whirl, races and rest in each bearing."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.model.whirl import steps_of_turning
from rotor_ida.results.contact_facts import columns_of_contact, contact_facts
from rotor_ida.schema import OF_BEARING
from rotor_ida.simulation.dataset import AROUND

# Turns in one sense, without a return below half of the clearance, that make a whirl.
FEWEST_TURNS = 3.0
# Part of the end of a run for which a contact must last to be at rest in its bearing.
LASTING = 0.1
# What is delivered of each bearing, with the kind of number.
NUMBERS = {
    **{name: np.float64 for name in OF_BEARING if name != "excursion"},
    "contact_count": np.int64, "whirl_sense": np.int8,
}  # fmt: skip


def figures_of_drop(
    run: xr.Dataset, clearances: Mapping[str, float], capacities: Mapping[str, float]
) -> dict[str, Column]:
    """Return the results of a drop as variables of its dataset.

    Parameters
    ----------
    run : Dataset
        The run of a rotor system.
    clearances : mapping
        Other close clearances by node, where no contact is.
    capacities : mapping
        Load capacities of the bearings by node.
    """
    count = run.sizes["contact"]
    of_contacts = [_of_contact(run, number) for number in range(count)]
    columns: dict[str, Column] = {
        name: ("contact", np.array([each[name] for each in of_contacts], kind))
        for name, kind in NUMBERS.items()
    }
    radii = np.hypot(run["x"].values, run["y"].values).max(axis=0)
    columns["largest_radius"] = ("node", radii)
    if clearances:
        names = run["node"].values.tolist()
        gaps = np.array([clearances.get(name, math.nan) for name in names])
        columns["node_clearance"] = ("node", gaps)
        columns["node_excursion"] = ("node", radii / gaps)
    if capacities:
        nodes = run["contact_node"].values.tolist()
        limits = np.array([capacities.get(node, math.nan) for node in nodes])
        columns["load_capacity"] = ("contact", limits)
        columns["load_ratio"] = ("contact", columns["largest_force"][1] / limits)
    if "standstill_time" not in run:  # at a speed that is held
        columns |= {"standstill_time": ((), math.nan), "standstill_time_error": ((), math.nan)}
    return columns


def touched_clearances(drops: xr.Dataset) -> list[str]:
    """Return the nodes at which a drop, or any of many, touches other close clearances."""
    if "node_excursion" not in drops.variables:
        return []
    others = [dim for dim in drops["node_excursion"].dims if dim != "node"]
    touched = (drops["node_excursion"] >= 1.0).any(others)
    return [str(each) for each in drops["node"].values[touched.values]]


def _of_contact(run: xr.Dataset, number: int) -> dict[str, float]:
    """Return the figures of one contact."""
    own, end = columns_of_contact(run, number), float(run.attrs["duration"])
    facts = contact_facts(own, float(run["clearance"][number]), end)
    impulses, lasting = own["impulse"], facts["contact_time"]
    complete = impulses[~np.isnan(own["exit_time"])]
    begins = np.nan_to_num(own["entry_time"], nan=0.0)  # in contact from the start
    lengths = np.nan_to_num(own["exit_time"], nan=end) - begins
    race, race_time = _race(run, number)
    turns, rate = _whirl(run, number)
    sense = 0 if abs(turns) < FEWEST_TURNS else 1 if turns > 0.0 else -1
    return facts | {
        "largest_impulse": float(complete.max(initial=0.0)),
        "total_impulse": float(impulses.sum()),
        "total_contact_time": lasting,
        "longest_contact_time": float(lengths.max(initial=0.0)),
        "mean_contact_force": float(impulses.sum()) / lasting if lasting > 0.0 else math.nan,
        "largest_race_speed": race,
        "race_speed_time": race_time,
        "whirl_turns": turns,
        "whirl_speed": rate if sense else math.nan,
        "whirl_sense": sense,
        "rest_time": _rest(own, end),
    }


def _race(run: xr.Dataset, number: int) -> tuple[float, float]:
    """Return the largest speed of the race of a contact in size, and its time after the start."""
    if "race_speed_max" not in run:
        return math.nan, math.nan
    found = [(float(run[name][number]), float(run[f"{name}_time"][number]))
             for name in ("race_speed_max", "race_speed_min")]  # fmt: skip
    speed, time = max(found, key=lambda each: abs(each[0]))
    return speed, time if time > 0.0 else math.nan


def _whirl(run: xr.Dataset, number: int) -> tuple[float, float]:
    """Return the turns of the longest whirl around a bearing, and its mean speed.

    A whirl goes on while the rotor stays beyond half of the clearance. Both are negative where the
    whirl is backward: against the spin during it.
    """
    x, y = run["contact_x"].values[:, number], run["contact_y"].values[:, number]
    times, far = run["t"].values, np.hypot(x, y) > AROUND * float(run["clearance"][number])
    steps = steps_of_turning(x + 1j * y)
    going = far[1:] & far[:-1]
    edges = np.flatnonzero(np.diff(np.concatenate([[False], going, [False]]).astype(np.int8)))
    total = np.concatenate([[0.0], np.cumsum(np.where(going, steps, 0.0))])
    spin = run["angle"].values if "angle" in run else float(run.attrs["speed"]) * times
    best, rate = 0.0, math.nan
    for begin, end in edges.reshape(-1, 2):
        angles = total[begin : end + 1]
        first, last = sorted((int(angles.argmin()), int(angles.argmax())))
        turned = float(total[begin + last] - total[begin + first])
        turned *= math.copysign(1.0, spin[begin + last] - spin[begin + first])
        if abs(turned) > abs(best):
            best, rate = turned, turned / float(times[begin + last] - times[begin + first])
    return best / math.tau, rate


def _rest(own: Mapping[str, Values], end: float) -> float:
    """Return the time of the last entry, if the contact lasts from it to the end; else NaN."""
    lasts = np.isnan(own["exit_time"])
    last = float(np.fmax.reduce(own["entry_time"][lasts], initial=math.nan))
    return last if end - last >= LASTING * end else math.nan
