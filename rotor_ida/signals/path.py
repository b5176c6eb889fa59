"""The motion of a run between its outputs and events, its force, and rotating axes.

All values are in the units of the run, which may be those of `rotor_ida.dimensional`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.model.equations import rotated
from rotor_ida.results.checked_run import check_columns, check_run, rotor_of
from rotor_ida.results.in_si import keeps_si
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import MODE, flags_of, labelled, words_of
from rotor_ida.signals.forces import normal_force, radial_speed
from rotor_ida.signals.sampling import check_sampling, run_angles

# Between close outputs the motion is the cubic through their displacements and velocities.
POINTS_A_REVOLUTION = 90
# Mode after events that determine it; after the others the disc slips.
AFTER = {"exit": "flight", "roll": "rolling", "release": "loose"}
EVENT_NAMES = tuple(f"event_{name}" for name in COMPONENTS)


@dataclass(frozen=True, slots=True)
class Path:
    """The motion at times close enough for a smooth curve, in the run's units."""

    time: Values
    x: Values
    y: Values
    # whether the stretch that begins at each time is in contact
    in_contact: npt.NDArray[np.bool_]
    # how fast the distance from the bearing axis grows, where that is known
    radial_speed: Values | None = None
    # with friction, the mode of the stretch that begins at each time: a number of `MODE`
    mode: npt.NDArray[np.int8] | None = None

    @property
    def radius(self) -> Values:
        """Distance from the bearing axis."""
        return np.hypot(self.x, self.y)

    def stretches(self, chosen: npt.NDArray[np.bool_], *columns: Values) -> list[Values]:
        """Return columns of values along the chosen stretches of the path, separated by NaN."""
        begins = chosen[:-1]
        shown = np.zeros(chosen.shape, dtype=bool)
        shown[:-1] |= begins
        shown[1:] |= begins
        # a gap follows a point that ends one stretch without beginning the next
        last = np.nonzero(shown[:-1] & ~begins)[0] + 1
        return [np.insert(np.where(shown, column, np.nan), last, np.nan) for column in columns]


def path_of(run: xr.Dataset) -> Path:
    """Return outputs and events in one sequence, with points in between where they are close."""
    check_columns(run, ("t", *COMPONENTS, "event_time", *EVENT_NAMES, "event_kind"))
    times = np.concatenate([run["t"].values, run["event_time"].values])
    columns = [np.append(run[name].values, run[f"event_{name}"].values) for name in COMPONENTS]
    table = np.stack(columns, axis=1)
    # velocities in units of length over units of time, which may have prefixes of their own
    table[:, 2:] *= scale_of(run, "length") / (scale_of(run, "time") * scale_of(run, "velocity"))
    times, first = np.unique(times, return_index=True)
    states = table[first]
    z, velocities = states[:, 0] + 1j * states[:, 1], states[:, 2] + 1j * states[:, 3]
    check_sampling("run", times, z, velocities, _angles(run, times, first))
    steps = np.diff(times)
    revolutions = max(1.0, largest_speed(run)) / (2.0 * math.pi * scale_of(run, "time"))
    points = np.clip(np.ceil(steps * revolutions * POINTS_A_REVOLUTION), 1, None).astype(int)
    step = np.repeat(np.arange(steps.size), points)
    part = (np.arange(step.size) - np.repeat(np.cumsum(points) - points, points) + 1) / points[step]
    time = np.append(times[:1], times[step] + part * steps[step])
    places, speeds = _cubic(part[:, None], steps[step, None], states[step], states[step + 1])
    x, y = np.concatenate([states[:1, :2], places]).T
    vx, vy = np.concatenate([states[:1, 2:], speeds]).T
    outwards = radial_speed(x, y, vx, vy)
    return Path(time, x, y, _in_contact(run, time), outwards, _modes(run, time))


def _angles(run: xr.Dataset, times: Values, first: npt.NDArray[np.intp]) -> Values | None:
    """Return the angle of the rotor at samples and events, in the sequence of the path."""
    if "event_angle" in run.variables:
        check_columns(run, ("angle", "event_angle"))
        return np.append(run["angle"].values, run["event_angle"].values)[first]
    return run_angles(run, times)


def _cubic(part: Values, step: Values, before: Values, after: Values) -> tuple[Values, Values]:
    """Return positions and velocities on the cubic through two states, `part` of a step later."""
    rise = part * part * (3.0 - 2.0 * part)
    bend_a, bend_b = part * (1.0 - part) ** 2, part * part * (part - 1.0)
    ends = before[:, :2] * (1.0 - rise) + after[:, :2] * rise
    places = ends + step * (before[:, 2:] * bend_a + after[:, 2:] * bend_b)
    climb = 6.0 * part * (1.0 - part) * (after[:, :2] - before[:, :2]) / step
    turn_a, turn_b = (1.0 - part) * (1.0 - 3.0 * part), part * (3.0 * part - 2.0)
    return places, climb + before[:, 2:] * turn_a + after[:, 2:] * turn_b


def force_along(run: xr.Dataset, path: Path) -> Values:
    """Return the contact force along the path of a run in the units of the run."""
    rotor, length = rotor_of(run), scale_of(run, "length")
    outwards = 0.0 if path.radial_speed is None else path.radial_speed * scale_of(run, "time")
    return scale_of(run, "force") * normal_force(rotor, path.radius / length, outwards / length)


def largest_speed(run: xr.Dataset) -> float:
    """Return the largest speed of a run [dimensionless]."""
    omega = float(run["omega"])
    if "speed" in run.variables:
        omega = max(omega, float(run["speed"].max()) / scale_of(run, "speed"))
    return omega


def _in_contact(run: xr.Dataset, time: Values) -> npt.NDArray[np.bool_]:
    """Return whether the stretch that begins at each time is in contact."""
    passed = np.searchsorted(run["event_time"].values, time, side="right")
    leaving = flags_of(run["event_kind"])["exit"]
    after = np.append(bool(run["starts_in_contact"].values), run["event_kind"].values != leaving)
    return np.asarray(after[passed], dtype=bool)


def _modes(run: xr.Dataset, time: Values) -> npt.NDArray[np.int8] | None:
    """Return the mode of the stretch that begins at each time; None without friction."""
    if "mode" not in run.variables:
        return None
    return modes_at(time, run, _modes_after_events(run), run["mode"].values)


def modes_at(
    time: Values, run: xr.Dataset, after: npt.NDArray[np.int8], sampled: npt.NDArray[np.int8]
) -> npt.NDArray[np.int8]:
    """Return the mode from each time on: that of the first sample after an event, if there is one.

    `after` has the modes after the start and after each event, as far as events determine them,
    and `sampled` those at the samples.
    """
    events, modes = run["event_time"].values, after.copy()
    passed, first = np.unique(
        np.searchsorted(events, run["t"].values, side="right"), return_index=True
    )
    modes[passed] = sampled[first]
    return modes[np.searchsorted(events, time, side="right")]


def _modes_after_events(run: xr.Dataset) -> npt.NDArray[np.int8]:
    """Return the mode after the start and after each event, as far as events determine it."""
    x, y, vx, vy = (run[f"event_{name}"].values for name in COMPONENTS)
    speed = run["omega"].item()
    if "event_speed" in run.variables:
        speed = run["event_speed"].values / scale_of(run, "speed")
    rim = run["disc_radius"].item() * speed * scale_of(run, "velocity")
    slip = np.append((x * vy - y * vx) / np.hypot(x, y) + rim, 0.0)
    # it keeps its direction from one event to the next; at one of them it may be 0
    senses = np.where(slip[:-1] + slip[1:] < 0.0, -1, 1).tolist()
    modes = [int(run["mode"].values[0])]
    for word, sense in zip(words_of(run["event_kind"]), senses, strict=True):
        turned = -modes[-1] if word == "reverse" else sense
        modes.append(MODE[AFTER[word]] if word in AFTER else turned)
    return np.array(modes, dtype=np.int8)


@keeps_si
def rotating(run: xr.Dataset) -> xr.Dataset:
    """Transform the motion of a run to axes that rotate with the unbalance.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.simulate` or `rotor_ida.run_up`, or part of one.

    Returns
    -------
    Dataset
        The run, with ``rotating_x rotating_y rotating_vx rotating_vy`` on ``t`` and
        ``event_rotating_x event_rotating_y event_rotating_vx event_rotating_vy`` on ``event``
        added [dimensionless].

    Raises
    ------
    InputError
        If the dataset is not a run.

    Notes
    -----
    ``Z = z exp(-i omega t)`` and ``W = z' exp(-i omega t)`` are the same two vectors on axes of
    which the first points along the unbalance. W is the velocity in the fixed frame, not the rate
    of change of Z, which is ``W - i omega Z``. A synchronous whirl of amplitude A and phase lag
    theta is the point ``Z = A exp(-i theta)``. If the speed changes, the axes rotate with the
    ``angle`` of the run.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019, multiplied by ``exp(-i omega t)``.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=1.2, zeta=0.5, delta0=0.5), start=(0, 0, 0, 0), duration=60.0)
    >>> seen = rotating(run)
    >>> seen.rotating_x[-1].item(), seen.rotating_y[-1].item()
    (-0.59999..., -0.60170...)
    """
    run = check_run(run, ("t", "event_time", *COMPONENTS, *EVENT_NAMES))
    return run.assign(
        {
            **_on_rotating_axes("t", "rotating", run, COMPONENTS),
            **_on_rotating_axes("event", "event_rotating", run, EVENT_NAMES),
        }
    )


def _on_rotating_axes(
    dim: str, prefix: str, run: xr.Dataset, names: tuple[str, ...]
) -> dict[str, xr.Variable]:
    times = run["t" if dim == "t" else "event_time"].values
    angles = float(run["omega"]) * times
    if "event_angle" in run:  # the speed changed
        angles = run["angle" if dim == "t" else "event_angle"].values
    states = np.stack([run[name].values for name in names], axis=-1)
    table = rotated(states, -angles)
    return {
        f"{prefix}_{name}": labelled(f"{prefix}_{name}", dim, np.ascontiguousarray(column))
        for name, column in zip(COMPONENTS, table.T, strict=True)
    }
