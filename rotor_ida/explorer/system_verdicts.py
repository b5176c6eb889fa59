"""What the page of a rotor system says in words of a run or a drop."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.depths import beyond_model
from rotor_ida.steady.drop_words import sentence_of
from rotor_ida.units import quantity

# Revolutions at the end of a run that the verdict is about.
LAST = 10


def verdict(run: xr.Dataset) -> str:
    """Return in a sentence which contacts touch at the end of a run, and how hard."""
    if kind_of(run) == "drop":
        return sentence_of(run, None)
    return f"{_verdict_of_run(run)} {beyond_model(run)}".rstrip()


def level_of(run: xr.Dataset) -> str:
    """Return the severity of a run: "rub" where it touches at its end, or drops, else "clear"."""
    return "rub" if kind_of(run) == "drop" or _late_contacts(run).any() else "clear"


def _late_contacts(run: xr.Dataset) -> npt.NDArray[np.bool_]:
    """Return which episodes of contact last into the last revolutions."""
    ends = run["exit_time"].values
    return np.asarray(np.isnan(ends) | (ends >= _begin(run)))


def _begin(run: xr.Dataset) -> float:
    """Return the time at which the last revolutions begin."""
    speed, last = _last_speed(run), float(run["t"].values[-1])
    return last - 2.0 * math.pi * LAST / speed if speed > 0.0 else 0.0


def _last_speed(run: xr.Dataset) -> float:
    return float(run["speed"].values[-1]) if "speed" in run else float(run.attrs["speed"])


def _verdict_of_run(run: xr.Dataset) -> str:
    nodes, peaks = run["contact_node"].values.tolist(), run["peak_force"].values
    owners, unit = run["episode_contact"].values, str(run["normal_force"].attrs.get("units", ""))
    told, begin, late = _speed(run, _last_speed(run)), _begin(run), _late_contacts(run)
    parts, clear = [], []
    for i, node in enumerate(nodes):
        mine = late & (owners == i)
        if mine.any():
            sampled = run["normal_force"].values[run["t"].values >= begin, i]
            between = peaks[mine & (run["peak_time"].values >= begin)]
            force = np.concatenate([sampled, between]).max(initial=0.0)
            parts.append(f"rubs at {titled(i, node)} with up to {quantity(float(force), unit)}")
        else:
            clear.append(titled(i, node))
    if not parts:
        return f"At {told} the rotor runs clear of all contacts in the last {LAST} revolutions."
    rest = f", and runs clear of {', '.join(clear)}" if clear else ""
    return f"In the last {LAST} revolutions, at {told}, the rotor {' and '.join(parts)}{rest}."


def touched_on_the_way(run: xr.Dataset) -> str:
    """Return in a sentence between which speeds a run-up touches each contact."""
    times, speeds = run["t"].values, run["speed"].values
    parts = []
    for number, node in enumerate(run["contact_node"].values.tolist()):
        mine = run["episode_contact"].values == number
        if not mine.any():
            continue
        begins = np.nan_to_num(run["entry_time"].values[mine], nan=times[0])
        ends = np.nan_to_num(run["exit_time"].values[mine], nan=times[-1])
        first, last = np.interp([begins.min(), ends.max()], times, speeds).tolist()
        between = f"{_speed(run, first)} and {_speed(run, last)}"
        parts.append(f"{titled(number, node)} between {between}")
    return f"The run-up touches {', '.join(parts) or 'no contact'}."


def _speed(run: xr.Dataset, speed: float) -> str:
    return quantity(speed, "rad/s" if run["t"].attrs.get("units") == "s" else "1")


def titled(number: int, node: str) -> str:
    """Return the name of a contact."""
    return f"contact {number} ({'node ' * node.isdecimal()}{node})"
