"""Contact in a run: touches, the largest radius and force, losses, and their times.

The columns are those of a run of one disc, or of one contact of a rotor system.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.schema import MODE, OF_FRICTION_EVENT_KIND

# What has a time, or at a changing speed a speed; NaN if it does not occur.
OCCUR = ("first_touch", "last_exit", "largest_radius", "largest_force", "first_roll")
OF_EPISODES = (
    "entry_time", "exit_time", "peak_time", "peak_indentation", "peak_force", "peak_force_time",
    "impulse", "heat", "contact_loss",
)  # fmt: skip


def contact_facts(
    run: Mapping[Any, Any], clearance: float, until: float | None = None
) -> dict[str, float]:
    """Return touches, the largest radius and force, and losses, with the times of `OCCUR`.

    Parameters
    ----------
    run : mapping
        Columns by their names in a run of one disc, from its start on. ``mode``, ``normal_force``,
        ``heat`` and ``contact_loss`` may be missing; so may ``peak_force_time``, which is then that
        of the largest indentation. Extrema of the radius between samples are in ``extremum_time``
        and ``extremum_radius``.
    clearance : float
        The clearance.
    until : float, optional
        The end of the run; default: the last sample.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), duration=20.0)
    >>> facts = contact_facts(run, 2.0)
    >>> facts["contact_count"], round(facts["first_touch_time"], 6)
    (4, 1.098545)
    """
    times, entries, exits, peaks = (
        np.asarray(run[name], float) for name in ("t", "entry_time", "exit_time", "peak_time")
    )
    end = float(times[-1]) if until is None else until
    begins, ends = np.nan_to_num(entries, nan=0.0), np.nan_to_num(exits, nan=end)
    rolls = np.asarray(run["event_time"])[
        np.asarray(run["event_kind"]) == OF_FRICTION_EVENT_KIND["roll"]
    ]
    if "mode" in run and int(run["mode"][0]) == MODE["rolling"]:
        rolls = times
    radius, farthest = _largest(
        (peaks, clearance + np.asarray(run["peak_indentation"])),
        (times, np.hypot(run["x"], run["y"])),
        (run.get("extremum_time", ()), run.get("extremum_radius", ())),
    )
    force, hardest = _largest(
        (run.get("peak_force_time", peaks), run["peak_force"]),
        (times, run.get("normal_force", np.zeros(times.size))),
    )
    return {
        "first_touch_time": float(np.fmin.reduce(begins, initial=math.nan)),
        "last_exit_time": float(np.fmax.reduce(exits, initial=math.nan)),
        "largest_radius": radius,
        "largest_radius_time": farthest,
        "smallest_gap": clearance - radius,
        "largest_force": force,
        "largest_force_time": hardest if force > 0.0 else math.nan,
        "contact_count": entries.size,
        "contact_time": float((ends - begins).sum()),
        "first_roll_time": float(rolls[0]) if rolls.size else math.nan,
        **{f"total_{name}": float(np.nansum(run.get(name, 0.0)))
           for name in ("heat", "contact_loss")},
    }  # fmt: skip


def run_up_facts(run: Mapping[Any, Any], clearance: float) -> dict[str, float]:
    """Return the same of a run whose speed changes, with speeds in place of times.

    The time of the first touch is there too.
    """
    times = np.concatenate([run["t"], run["event_time"]])
    order = np.argsort(times, kind="stable")
    speeds = np.concatenate([run["speed"], run["event_speed"]])[order]
    facts = contact_facts(run, clearance)
    found = {"first_touch_time": facts["first_touch_time"]}
    for name, value in facts.items():
        if name.removesuffix("_time") in OCCUR and name not in OCCUR:
            speed = float(np.interp(value, times[order], speeds))
            found[name.replace("_time", "_speed")] = speed
        else:
            found[name] = value
    return found


def columns_of_contact(run: xr.Dataset, number: int) -> dict[str, Values]:
    """Return the columns of one contact of a rotor system, by their names of one disc."""
    own, mine = (run[name].values == number for name in ("episode_contact", "event_contact"))
    found: dict[str, Values] = {name: run[name].values[own] for name in OF_EPISODES if name in run}
    found |= {
        name: run[name].values[mine]
        for name in ("event_time", "event_kind", "event_speed") if name in run
    }  # fmt: skip
    found |= {name: run[name].values for name in ("t", "speed") if name in run}
    found |= {name: run[name].values[:, number] for name in ("mode", "normal_force")}
    found |= {name: run[f"contact_{name}"].values[:, number] for name in ("x", "y")}
    return found


def _largest(*columns: tuple[Any, Any]) -> tuple[float, float]:
    """Return the largest value in pairs of times and values, and its time; the first of equals."""
    times, values = (np.concatenate(each) for each in zip(*columns, strict=True))
    place = int(np.nanargmax(values))
    return float(values[place]), float(times[place])
