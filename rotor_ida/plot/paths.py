"""The motion of a run between its outputs, as far as they tell it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.plot.units import scale_of
from rotor_ida.schema import flags_of

Values = npt.NDArray[np.float64]

# Between outputs the motion is drawn as the cubic that has its velocities too, but only where
# they lie closer than this part of a revolution; farther apart it would be an invention.
SMOOTH_BELOW = 0.2
POINTS_A_REVOLUTION = 90


@dataclass(frozen=True, slots=True)
class Path:
    """The motion, at times close enough to be drawn as smooth as it is.

    Parameters
    ----------
    time, x, y : ndarray, shape (n,)
        Times and places, in the units of the run.
    in_contact : ndarray of bool, shape (n,)
        Whether the stretch that begins there is in contact.
    """

    time: Values
    x: Values
    y: Values
    in_contact: npt.NDArray[np.bool_]

    @property
    def radius(self) -> Values:
        """Distance from the bearing axis."""
        return np.hypot(self.x, self.y)

    def stretches(self, chosen: npt.NDArray[np.bool_]) -> tuple[Values, Values]:
        """Return the chosen stretches of the path, parted by NaN."""
        begins = chosen[:-1]
        points = np.stack([self.x, self.y], axis=1)
        shown = np.zeros(len(points), dtype=bool)
        shown[:-1] |= begins
        shown[1:] |= begins
        # a point that ends one stretch without beginning the next is followed by a gap
        last = np.nonzero(shown[:-1] & ~begins)[0] + 1
        gapped = np.insert(np.where(shown[:, None], points, np.nan), last, np.nan, axis=0)
        return gapped[:, 0], gapped[:, 1]


def path_of(run: xr.Dataset) -> Path:
    """Return outputs and events in one sequence, with points between where they lie close."""
    times = np.concatenate([run["t"].values, run["event_time"].values])
    table = np.concatenate(
        [
            np.stack([run[name].values for name in COMPONENTS], axis=1),
            np.stack([run[f"event_{name}"].values for name in COMPONENTS], axis=1),
        ]
    )
    times, first = np.unique(times, return_index=True)
    states = table[first]
    steps = np.diff(times)
    revolutions = max(1.0, run["omega"].item()) / (2.0 * math.pi * scale_of(run, "time"))
    points = np.clip(np.ceil(steps * revolutions * POINTS_A_REVOLUTION), 1, None).astype(int)
    points[steps * revolutions > SMOOTH_BELOW] = 1
    fine, x, y = [times[:1]], [states[:1, 0]], [states[:1, 1]]
    for number in np.unique(points):
        rows = np.nonzero(points == number)[0]
        part = np.arange(1, number + 1) / number
        fine.append((times[rows, None] + part * steps[rows, None]).ravel())
        for out, place, speed in ((x, 0, 2), (y, 1, 3)):
            out.append(
                _cubic(
                    part, steps[rows, None], states[rows, place], states[rows + 1, place],
                    states[rows, speed], states[rows + 1, speed],
                ).ravel()
            )  # fmt: skip
    time = np.concatenate(fine)
    order = np.argsort(time, kind="stable")
    time = time[order]
    return Path(time, np.concatenate(x)[order], np.concatenate(y)[order], _in_contact(run, time))


def _cubic(part: Values, step: Values, a: Values, b: Values, va: Values, vb: Values) -> Values:
    """Return the Hermite cubic between places `a` and `b` with velocities `va` and `vb`."""
    rise = part * part * (3.0 - 2.0 * part)
    bend_a, bend_b = part * (1.0 - part) ** 2, part * part * (part - 1.0)
    ends = a[:, None] * (1.0 - rise) + b[:, None] * rise
    return np.asarray(ends + step * (va[:, None] * bend_a + vb[:, None] * bend_b))


def _in_contact(run: xr.Dataset, time: Values) -> npt.NDArray[np.bool_]:
    """Return whether the stretch that begins at each time is in contact."""
    passed = np.searchsorted(run["event_time"].values, time, side="right")
    entry = flags_of(run["event_kind"])["entry"]
    after = np.concatenate(
        [[bool(run["starts_in_contact"].values)], run["event_kind"].values == entry]
    )
    return np.asarray(after[passed], dtype=bool)
