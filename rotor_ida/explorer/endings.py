"""Numbers on the last half of a run, of one disc or of a contact of a rotor system."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import DAMPED_EVENT_KIND, EVENT_KIND, MODE
from rotor_ida.signals.forces import power_in_contact

FloatArray = npt.NDArray[np.float64]
Values = dict[str, npt.NDArray[Any]]
# The end of a run is its last half.
LAST = 0.5
SAMPLES_PER_REVOLUTION = 48
# A longer run is drawn with fewer samples per revolution, but enough for the spectrum.
MOST_SAMPLES, FEWEST_PER_REVOLUTION = 16_384, 8
OF_ENDING = ("t", "x", "y", "vx", "vy", "mode", "slip_speed")


def ending_of(run: Values, omega: float) -> dict[str, float]:
    """Summarize the last half of a run: contacts, their peak force, extreme radii.

    With friction, add the fractions of contact time with slip and rolling.
    """
    end = float(run["t"][-1])
    begin = LAST * end
    late = run["t"] >= begin
    radius = np.hypot(run["x"], run["y"])[late]
    peaks = run["peak_force"][run["peak_time"] >= begin]
    revolutions = revolutions_in(run, omega)
    entry = np.maximum(np.nan_to_num(run["entry_time"], nan=0.0), begin)
    leaving = np.nan_to_num(run["exit_time"], nan=end)
    found = {
        "contacts_per_revolution": (
            events_in(run, EVENT_KIND["entry"]) / revolutions if revolutions else math.nan
        ),
        "contact_fraction": float(np.maximum(leaving - entry, 0.0).sum()) / (end - begin),
        "largest_force": max(float(run["force"][late].max()), float(peaks.max(initial=0.0))),
        "radius_min": float(radius.min()),
        "radius_max": float(radius.max()),
        "contacts_in_all": float(run["peak_time"].size),
    }
    if "mode" in run:
        mode = run["mode"][late]
        touching = max(int(np.count_nonzero(mode != MODE["flight"])), 1)
        for name in ("slipping_forward", "slipping_backward", "rolling"):
            found[f"{name}_fraction"] = int(np.count_nonzero(mode == MODE[name])) / touching
    return found


def revolutions_in(run: Values, omega: float) -> float:
    """Return the number of revolutions in the last half of a run."""
    return (1.0 - LAST) * float(run["t"][-1]) * omega / (2.0 * math.pi)


def events_in(run: Values, kind: int) -> float:
    """Return the number of events of a kind in the last half of a run."""
    late = run["event_time"] >= LAST * run["t"][-1]
    return float(((run["event_kind"] == kind) & late).sum())


def samples_per_revolution(revolutions: int) -> int:
    """Return the number of samples per revolution of a run of a number of revolutions."""
    return max(min(SAMPLES_PER_REVOLUTION, MOST_SAMPLES // revolutions), FEWEST_PER_REVOLUTION)


def whirls_per_revolution(run: Values, omega: float) -> float:
    """Return the largest number of backward whirls in a revolution.

    For a disc with friction only, which may roll; over the last half of the run.
    """
    late = run["t"] >= LAST * run["t"][-1]
    if "mode" not in run or omega == 0.0:
        return 0.0
    held = late & (run["mode"] != MODE["flight"])
    x, y, vx, vy = (run[name][held] for name in COMPONENTS)
    rate = np.abs(x * vy - y * vx) / (x**2 + y**2)
    return float(rate.max(initial=0.0)) / omega


def values_of(run: xr.Dataset) -> Values:
    """Return the values of a run by name, without labels: a slider needs a fast answer."""
    return {str(name): variable.values for name, variable in run.variables.items()}


def states_of(run: Values) -> FloatArray:
    """Return the states of a run."""
    return np.stack([run[name] for name in COMPONENTS], axis=-1)


def forced(run: xr.Dataset, rotor: Rotor) -> Values:
    """Return the values of a run of one disc, with the contact force."""
    values = values_of(run)
    return values | {"force": power_in_contact(values, rotor).normal_force}


def ending(run: Values, rotor: Rotor) -> dict[str, float]:
    """Summarize the last half of a run of one disc: see `ending_of`.

    With contact damping, add the mean energy loss of contacts that end there, the loss per
    revolution, and how often the force falls to zero before the rotor leaves the stator; with
    friction the heat.
    """
    found = ending_of(run, rotor.omega)
    begin = LAST * float(run["t"][-1])
    late = {name: run[name][run["t"] >= begin] for name in OF_ENDING if name in run}
    power = power_in_contact(late, rotor)
    revolutions = revolutions_in(run, rotor.omega)

    def per_revolution(rate: FloatArray) -> float:
        # over whole periods of a periodic motion it is as exact as the samples
        return float(np.trapezoid(rate, late["t"])) / revolutions if revolutions else math.nan

    if rotor.contact_damping > 0.0:
        losses = run["contact_loss"][run["exit_time"] >= begin]
        found["loss_per_contact"] = float(losses.mean()) if losses.size else math.nan
        found["releases"] = events_in(run, DAMPED_EVENT_KIND["release"])
        found["loss_per_revolution"] = per_revolution(power.damping)
    if rotor.friction > 0.0:
        found["heat_per_revolution"] = per_revolution(power.friction)
    return found
