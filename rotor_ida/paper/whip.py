"""Classify the end of a simulated rub, in dry whip or not, for the scenarios."""

from __future__ import annotations

import numpy as np
import xarray as xr

from rotor_ida.schema import MODE, OF_FRICTION_EVENT_KIND

# States at the end of a run. The last three are whip: pure rolling, rolling and slip by turns
# because of the unbalance, or slip that reverses because the unbalance is too strong to roll.
ENDS = {"no_whip": 0, "slipping": 1, "reversing": 2, "rolling_by_turns": 3, "rolling": 4}
FIRST_OF_WHIP = ENDS["reversing"]


def end_of(run: xr.Dataset, late: float = 2.0 / 3.0) -> int:
    """Return the end of a run with friction, a number of `ENDS`, from its part after `late`.

    In whip the rotor whirls backwards in lasting contact, and the disc stops sliding on the stator.
    A backward whirl that still slides forwards at the end is ``slipping``.
    """
    begin = late * float(run.t.values[-1])
    shown = run.isel(t=run.t.values >= begin)
    entries, exits = run.entry_time.values[-1:], run.exit_time.values[-1:]
    stays = entries.size and np.isnan(exits[0]) and not entries[0] > begin
    if not stays or (shown.x * shown.vy - shown.y * shown.vx).max() >= 0.0:
        return ENDS["no_whip"]
    if (shown["mode"] == MODE["rolling"]).all():
        return ENDS["rolling"]
    kinds = run.event_kind.values[run.event_time.values >= begin]
    if (kinds == OF_FRICTION_EVENT_KIND["roll"]).any():
        return ENDS["rolling_by_turns"]
    reverses = (kinds == OF_FRICTION_EVENT_KIND["reverse"]).any()
    return ENDS["reversing" if reverses else "slipping"]


def is_whip(run: xr.Dataset) -> bool:
    """Return whether a run ends in dry whip."""
    return end_of(run) >= FIRST_OF_WHIP
