"""Numbers on the last half of a run: of one disc, or of a contact of a rotor system."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.schema import EVENT_KIND, MODE

Values = dict[str, npt.NDArray[Any]]
# The end of a run is its last half.
LAST = 0.5
SAMPLES_PER_REVOLUTION = 48
# A longer run is drawn with fewer samples per revolution, but enough for the spectrum.
MOST_SAMPLES, FEWEST_PER_REVOLUTION = 16_384, 8


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
