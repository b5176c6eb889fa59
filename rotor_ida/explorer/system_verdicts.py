"""What the page of a rotor system says in words of a run or a drop."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from rotor_ida.explorer.system_touches import speed_in_words, titled
from rotor_ida.results.depths import beyond_model
from rotor_ida.results.kinds import kind_of
from rotor_ida.steady.drop_figures import touched_clearances
from rotor_ida.units import SPEED_UNITS, rpm

# Revolutions at the end of a run that the verdict is about.
LAST = 10


def verdict(run: xr.Dataset) -> str:
    """Return in a sentence which contacts touch at the end of a run, and how hard."""
    said = _verdict_of_drop(run) if kind_of(run) == "drop" else _verdict_of_run(run)
    return f"{said} {beyond_model(run)}".rstrip()


def _verdict_of_run(run: xr.Dataset) -> str:
    nodes, peaks = run["contact_node"].values.tolist(), run["peak_force"].values
    owners, unit = run["episode_contact"].values, _unit(run, "normal_force")
    speed = float(run["speed"].values[-1]) if "speed" in run else float(run.attrs["speed"])
    told = speed_in_words(speed, si=_is_si(run))
    last = float(run["t"].values[-1])
    begin = last - 2.0 * math.pi * LAST / speed if speed > 0.0 else 0.0
    ends = run["exit_time"].values
    late = np.isnan(ends) | (ends >= begin)
    parts, clear = [], []
    for i, node in enumerate(nodes):
        mine = late & (owners == i)
        if mine.any():
            sampled = run["normal_force"].values[run["t"].values >= begin, i]
            between = peaks[mine & (run["peak_time"].values >= begin)]
            force = np.concatenate([sampled, between]).max(initial=0.0)
            parts.append(f"rubs at {titled(i, node)} with up to {force:.4g} {unit}".strip())
        else:
            clear.append(titled(i, node))
    if not parts:
        return f"At {told} the rotor runs clear of all contacts in the last {LAST} revolutions."
    rest = f", and runs clear of {', '.join(clear)}" if clear else ""
    return f"In the last {LAST} revolutions, at {told}, the rotor {' and '.join(parts)}{rest}."


def touched_on_the_way(run: xr.Dataset) -> str:
    """Return in a sentence between which speeds a run-up touches each contact."""
    times, speeds, si = run["t"].values, run["speed"].values, _is_si(run)
    parts = []
    for number, node in enumerate(run["contact_node"].values.tolist()):
        mine = run["episode_contact"].values == number
        if not mine.any():
            continue
        begins = np.nan_to_num(run["entry_time"].values[mine], nan=times[0])
        ends = np.nan_to_num(run["exit_time"].values[mine], nan=times[-1])
        first, last = np.interp([begins.min(), ends.max()], times, speeds).tolist()
        between = f"{speed_in_words(first, si=si)} and {speed_in_words(last, si=si)}"
        parts.append(f"{titled(number, node)} between {between}")
    return f"The run-up touches {', '.join(parts) or 'no contact'}."


def _verdict_of_drop(run: xr.Dataset) -> str:
    """Return in a sentence per bearing what it takes, and how the rotor moves in it."""
    said = [
        f"{titled(number, node)} {', '.join(_of_bearing(run.isel(contact=number)))}"
        for number, node in enumerate(run["contact_node"].values.tolist())
    ]
    stands = float(run["standstill_time"])
    if math.isfinite(stands):
        time = f"{stands:.3g} {_unit(run, 't')}".strip()
        said.append(f"the speed stays below 1 % of that at the drop from {time} on")
    if touched := touched_clearances(run):
        said.append(f"other close clearances are touched at {', '.join(touched)}")
    return f"Drop: {'; '.join(said)}."


def _of_bearing(own: xr.Dataset) -> list[str]:
    """Return the figures of one bearing in words."""
    force = f"{float(own['largest_force']):.4g} {_unit(own, 'largest_force')}".strip()
    told = [
        f"takes up to {force} in {int(own['contact_count'])} contacts",
        f"excursion up to {float(own['excursion']):.3g} clearances",
    ]
    sense = int(own["whirl_sense"])
    if sense:
        turns, speed = abs(float(own["whirl_turns"])), abs(float(own["whirl_speed"]))
        rate = f" at {speed / SPEED_UNITS['Hz']:.3g} Hz" if _is_si(own) else f" at {speed:.3g}"
        told.append(f"whirls {'forward' if sense > 0 else 'backward'} for {turns:.3g} turns{rate}")
    else:
        told.append("no lasting whirl")
    race = float(own["largest_race_speed"])
    if math.isfinite(race):
        most = rpm(race) if _is_si(own) else f"{race:.4g}"
        told.append(f"race up to {most}")
    rest = float(own["rest_time"])
    resting = f"in contact to the end from {rest:.3g} {_unit(own, 't')}".strip()
    return [*told, resting if math.isfinite(rest) else "no lasting contact by the end"]


def _unit(run: xr.Dataset, name: str) -> str:
    """Return the unit of a variable; empty if it has none."""
    unit = str(run[name].attrs.get("units", ""))
    return "" if unit == "1" else unit


def _is_si(run: xr.Dataset) -> bool:
    return _unit(run, "t") == "s"
