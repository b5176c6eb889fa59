"""Plots of a run-up, run-down, drop or long run: radius and force over the speed, and orbits.

The orbit of many revolutions is a solid disc. Over the speed, or over time where the speed rests or
reverses, the radius is drawn as the band between its extremes in each revolution, beside orbits of
a few turns.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rotor_ida.arrays import Values
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import draw_level, draw_ring, new_figure, say_in_middle, style
from rotor_ida.plot.datasets import contact_text
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.labels import (
    label_axis,
    label_of,
    span_text,
    speed_text,
    speeds_in,
    title_of,
    unit_of,
)
from rotor_ida.plot.legends import shared_legend
from rotor_ida.plot.motion import (
    Place,
    checked_run,
    draw_motion,
    forces_in,
    place_of_disc,
    places_in,
    shade_contacts,
    square,
)
from rotor_ida.plot.runs import TALL, WIDTH
from rotor_ida.results.checked_run import is_of_system, nodes_in
from rotor_ida.results.si_units import scale_of

# Height of the orbits [inch].
ORBIT = 2.7
# Revolutions of an orbit, and of a run from which on it is drawn as bands.
FEW_TURNS, MANY_TURNS = 3.0, 60.0
# Columns of a band. A band of fewer revolutions than this is a line.
BINS, LINE = 700, 25
# A part of a revolution by which a column may be narrower than a dot, and one that is rounding.
NEARLY, ROUNDING = 0.1, 1e-6
# Of a system at most this many contacts are drawn, those of the largest forces.
MOST_CONTACTS = 5
# The speed is the axis if it only rises or only falls: in each of PARTS equal parts of the time by
# at least this fraction of a uniform change.
PARTS, LEAST_CHANGE = 20, 0.05
# A radius of more clearances than this is drawn on a logarithmic scale.
FAR = 20.0


class Course(NamedTuple):
    """The speed of a run and its revolutions over time, and what is drawn across."""

    time: Values
    speed: xr.DataArray
    turns: Values
    over_speed: bool

    def across(self, times: Values) -> Values:
        """Return the horizontal position at times."""
        return np.interp(times, self.time, self.speed) if self.over_speed else times

    def turns_at(self, times: Values) -> Values:
        """Return the revolutions since the beginning."""
        return np.interp(times, self.time, self.turns)


def plot_run_up(run: xr.Dataset) -> Figure:
    """Draw a run-up, run-down or drop: radius and force over speed or time, and three orbits.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.run_up`, of one disc or of a `rotor_ida.RotorSystem`, or of
        `rotor_ida.drop`, or a long run of `rotor_ida.simulate`.

    Returns
    -------
    Figure
        The figure. Radius and force are bands between their extremes in each revolution, and lines
        in runs of fewer than 25 revolutions. Above is the time; where the speed rests or reverses,
        and for a drop, the panels are over time, below one of the speed, with those of races. The
        orbits are those of three revolutions
        at the first touch, at the largest force, or the largest radius if nothing is touched, and
        at the end. Of a system the contacts that are touched are drawn, at most five, with the
        orbits in the one concerned.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> up = run_up(Rotor(omega=0.3, zeta=0.1, delta0=1.5), start=(0, 0, 0, 0), to=2.0, rate=0.01)
    >>> [ax.get_ylabel() for ax in plot_run_up(up).axes[:2]]
    ['radius $|z|$', 'contact force $f$']
    """
    run = checked_run(run)
    course = _course_of(run)
    places = _places_in_system(run) if is_of_system(run) else [place_of_disc(run)]
    orbits = list(_orbits_of(places, course))
    races = np.flatnonzero(np.isfinite(run.get("race_radius", []))).tolist()
    has_speed = "speed" in run.variables or races
    rows = 3 if has_speed and not course.over_speed else 2
    with style():
        figure = new_figure(WIDTH, 0.9 + TALL * rows + ORBIT)
        above, below = figure.subfigures(
            2, 1, squeeze=False, height_ratios=(0.5 + TALL * rows, ORBIT + 0.4)
        )[:, 0]
        panels = above.subplots(rows, 1, sharex=True).tolist()
        if rows > 2:
            _draw_speeds(panels[0], run, course, races)
        _draw_radii(panels[-2], run, places, course)
        _draw_normal_forces(panels[-1], places, course)
        _finish_panels(panels, run, places, course)
        for ax, orbit in zip(below.subplots(1, len(orbits), squeeze=False)[0], orbits, strict=True):
            _draw_orbit(ax, run, course, *orbit, orbit[1].title if len(places) > 1 else "")
        below.axes[0].set_ylabel(label_of("y", run["y"]))
        above.align_ylabels(panels)
        shared_legend(below, [*panels, *below.axes], columns=7, outer=False)
        above.suptitle(title_of("run", run), fontsize=10.0)
    return figure


def has_many_turns(run: xr.Dataset) -> bool:
    """Return whether the speed of a run changes, or its orbit has too many turns for a picture."""
    return "speed" in run.variables or _course_of(run).turns[-1] > MANY_TURNS


def _course_of(run: xr.Dataset) -> Course:
    """Return speed and revolutions over time, and whether the speed serves as an axis."""
    time = run["t"].values
    if "speed" not in run.variables:
        speed = run.attrs["speed"] if is_of_system(run) else float(run["omega"])
        turns = abs(speed) / scale_of(run, "time") * (time - time[0]) / (2.0 * math.pi)
        return Course(time, run["t"], turns, over_speed=False)
    turned = np.abs(np.diff(run["angle"].values, prepend=run["angle"].values[0]))
    speed = speeds_in(run["speed"])
    parts = np.diff(np.interp(np.linspace(time[0], time[-1], PARTS + 1), time, speed))
    changes = parts / (parts.sum() or math.inf)
    is_drop = "standstill_time" in run.variables
    over_speed = not is_drop and bool((changes >= LEAST_CHANGE / PARTS).all())
    return Course(time, speed, np.cumsum(turned) / (2.0 * math.pi), over_speed)


def _places_in_system(run: xr.Dataset) -> list[Place]:
    """Return the contacts that are touched, by largest force; the nearest if none is.

    Of a system without contacts it is the node that moves farthest.
    """
    names = nodes_in(run)
    places = [place for place in places_in(run, names) if place.has_stator]
    touched = sorted(
        (each for each in places if each.entries.size),
        key=lambda each: -forces_in(each.run).normal.max(),
    )
    if touched:
        return touched[:MOST_CONTACTS]
    if places:
        return [max(places, key=lambda each: each.radius.max() / each.clearance)]
    farthest = np.hypot(run["x"].values, run["y"].values).max(axis=0).argmax()
    return places_in(run, [names[int(farthest)]])


def _orbits_of(places: Sequence[Place], course: Course) -> Iterator[tuple[str, Place, list[float]]]:
    """Yield words, place and times of each orbit; those of nearly one time and place are one."""
    hardest, end = places[0], float(course.time[-1])
    touched = [each for each in places if each.entries.size]
    if touched:
        begins = [float(np.nan_to_num(each.entries, nan=course.time[0]).min()) for each in touched]
        first = int(np.argmin(begins))
        forces = forces_in(hardest.run, hardest.path)
        wanted = [
            ("first touch", touched[first], [begins[first]]),
            ("largest force", hardest, [float(forces.time[forces.normal.argmax()])]),
        ]
    else:
        farthest = float(hardest.path.time[hardest.radius.argmax()])
        wanted = [("largest radius", hardest, [farthest])]
    wanted.append(("end", hardest, [end]))
    while wanted:
        words, place, times = wanted.pop(0)
        if wanted and wanted[0][1] is place:
            after, _, later = wanted[0]
            apart = np.ptp(course.turns_at(np.array([*times, *later])))
            if apart < 0.5 * FEW_TURNS:
                wanted[0] = (f"{words}, {after}", place, [*times, *later])
                continue
        yield words, place, times


def _bins(across: Values, turns: Values) -> npt.NDArray[np.intp]:
    """Return the first sample of each column: the fewest whole revolutions at least a dot wide.

    The extremes of parts of revolutions would beat with the motion.
    """
    column = np.abs(across - across[0]) / (abs(across[-1] - across[0]) or 1.0) * BINS
    starts, place = [], 0
    while place < across.size:
        starts.append(place)
        beyond = min(int(np.searchsorted(column, column[place] + 1.0)), across.size - 1)
        whole = max(math.ceil(turns[beyond] - turns[place] - NEARLY), 1)
        first = math.floor(turns[place] + ROUNDING)
        place = max(int(np.searchsorted(turns, first + whole - ROUNDING)), place + 1)
    # the last one may be a part of a revolution
    return np.array(starts[: max(len(starts) - 1, 1)], dtype=np.intp)


def _draw_band(
    ax: Axes, course: Course, times: Values, values: Values, colour: str, label: str
) -> None:
    """Draw the band between the extremes in each revolution; a line if these are few."""
    across, turns = course.across(times), course.turns_at(times)
    if turns[-1] - turns[0] < LINE:
        ax.plot(across, values, color=colour, lw=0.9, label=label)
        return
    starts = _bins(across, turns)
    low, high = (each.reduceat(values, starts) for each in (np.minimum, np.maximum))
    middle = 0.5 * (across[starts] + across[np.append(starts[1:], across.size) - 1])
    middle[[0, -1]] = across[[0, -1]]
    ax.fill_between(middle, low, high, facecolor=colour, edgecolor=colour, lw=0.7, alpha=0.75,
                    label=label)  # fmt: skip


def _draw_speeds(ax: Axes, run: xr.Dataset, course: Course, races: Sequence[int]) -> None:
    """Draw the speeds of the rotor and of races: those at events, extremes and the end."""
    if "speed" in run.variables:
        label_axis(ax.yaxis, "speed", course.speed)
        ax.plot(
            course.time, course.speed, color=palette.INK, lw=1.0, label="rotor" if races else "_"
        )
    at_end = run["final_state"].values[-len(races) :].tolist() if races else []
    ends = ("race_speed_min", "race_speed_max")
    for number, last in zip(races, at_end, strict=True):
        own = run.isel(contact=number)
        speeds = [*own["event_race_speed"].values, *(own[end].item() for end in ends), last]
        times = [*own["event_time"].values, *(own[f"{end}_time"].item() for end in ends),
                 course.time[-1]]  # fmt: skip
        order = np.argsort(times, kind="stable")
        colour, dashes = palette.look(1 + number)
        kept = order[kept_in_columns(np.array(times)[order], np.array(speeds)[order])]
        shown = speeds_in(xr.DataArray(np.array(speeds)[kept], attrs=own["event_race_speed"].attrs))
        label_axis(ax.yaxis, "speed", shown, words="speeds")
        ax.plot(np.array(times)[kept], shown, color=colour, ls=dashes, lw=0.9,
                label=f"race of {contact_text(run, number)}")  # fmt: skip
    ax.axhline(0.0, color=palette.GREY, lw=0.6)


def _draw_radii(ax: Axes, run: xr.Dataset, places: Sequence[Place], course: Course) -> None:
    """Draw the radius in each place; over its clearance if there are several."""
    for number, place in enumerate(places):
        part = (place.clearance or 1.0) if len(places) > 1 else 1.0
        values = place.radius / part
        _draw_band(
            ax, course, place.path.time, values, _colour(places, number, palette.BLUE),
            _name(places, number),
        )  # fmt: skip
        draw_level(ax, place.clearance / part)
    clearance = 1.0 if len(places) > 1 else places[0].clearance
    if 0.0 < FAR * clearance < ax.dataLim.y1:  # as in dry whip, beside which nothing else is seen
        ax.set_yscale("log")
        ax.set_ylim(bottom=clearance / FAR)
    else:
        ax.set_ylim(bottom=0.0)
    if len(places) > 1:
        ax.set_ylabel("radius over clearance")
        return
    label_axis(ax.yaxis, "radius", run["x"])
    ax.set_title(places[0].title)


def _draw_normal_forces(ax: Axes, places: Sequence[Place], course: Course) -> None:
    """Draw the contact force in each place."""
    forces = [forces_in(each.run, each.path) for each in places if each.has_stator]
    for number, each in enumerate(forces):
        label_axis(ax.yaxis, each.name, each.unit)
        if each.normal.any():
            colour = _colour(places, number, palette.RED)
            _draw_band(ax, course, each.time, each.normal, colour, _name(places, number))
    peaks = np.concatenate([each.normal[each.normal > 0.0] for each in forces] or [np.empty(0)])
    if peaks.size and peaks.max() > FAR**2 * np.median(peaks):  # as in dry whip, after a rub
        ax.set_yscale("log")
        ax.set_ylim(bottom=np.median(peaks) / FAR)
    else:
        ax.set_ylim(bottom=0.0)
    if not any(each.normal.any() for each in forces):
        say_in_middle(ax, "no contact")


def _colour(places: Sequence[Place], number: int, alone: str) -> str:
    """Return the colour of a place: that of its race too, in all panels, if there are several."""
    return palette.look(places[number].number + 1)[0] if len(places) > 1 else alone


def _name(places: Sequence[Place], number: int) -> str:
    """Return the entry of a place in the legend."""
    return places[number].title if len(places) > 1 else "_"


def _finish_panels(
    panels: Sequence[Axes], run: xr.Dataset, places: Sequence[Place], course: Course
) -> None:
    """Label the shared axis, shade the contacts, and put the time above."""
    ends = np.sort(course.across(course.time[[0, -1]]))
    for ax in panels:
        ax.grid(visible=False, axis="x")
        if any(place.has_stator for place in places):
            shade_contacts(ax, _contacts_across(places, course))
    panels[0].set_xlim(*ends)
    if not course.over_speed:
        label_axis(panels[-1].xaxis, "t", run["t"])
        return
    label_axis(panels[-1].xaxis, "speed", course.speed)
    speed, time = course.speed.values, course.time
    rising = slice(None, None, 1 if speed[-1] > speed[0] else -1)
    above = panels[0].secondary_xaxis("top", functions=(
        lambda at: np.interp(np.asarray(at), speed[rising], time[rising]),
        lambda at: np.interp(np.asarray(at), time, speed),
    ))  # fmt: skip
    ticks = MaxNLocator(8).tick_values(time[0], time[-1])
    above.set_ticks([tick for tick in ticks if time[0] <= tick <= time[-1]])
    above.set_xlabel(label_of("t", run["t"]))


def _contacts_across(places: Sequence[Place], course: Course) -> xr.Dataset:
    """Return the intervals of contact along the horizontal axis."""
    runs = [place.run for place in places if place.has_stator]
    spans = [
        np.concatenate([np.nan_to_num(run[name].values, nan=course.time[end]) for run in runs])
        for name, end in (("entry_time", 0), ("exit_time", -1))
    ]
    ends = np.sort(course.across(np.stack(spans)), axis=0)
    columns = {"entry_time": ("contact", ends[0]), "exit_time": ("contact", ends[1])}
    return xr.Dataset(columns, {"t": np.sort(course.across(course.time[[0, -1]]))})


def _draw_orbit(
    ax: Axes, run: xr.Dataset, course: Course, words: str, place: Place, times: list[float],
    title: str,
) -> None:  # fmt: skip
    """Draw the orbit of a few revolutions about some times, in the clearance."""
    middle = float(course.turns_at(np.array(times)).mean())
    begin = max(0.0, min(middle - 0.5 * FEW_TURNS, course.turns[-1] - FEW_TURNS))
    path = place.path
    turns = course.turns_at(path.time)
    shown = (turns >= begin) & (turns <= begin + FEW_TURNS)
    names = ("time", "x", "y", "in_contact", "mode")
    columns = {
        name: getattr(path, name)[shown] for name in names if getattr(path, name) is not None
    }
    few = replace(path, radial_speed=None, **columns)
    draw_ring(ax, place.clearance, place.centre)
    draw_motion(ax, few, few.x, few.y, width=0.9, heavier=1.2)
    square(ax)
    ax.set_xlabel(label_of("x", run["x"]))
    ends = [times[0], times[-1]]
    spans = [f"{label_of('t', run['t']).split()[1]} {span_text(ends)} {unit_of(run['t'])}".rstrip()]
    if "speed" in run.variables:
        speeds = np.interp(ends, course.time, course.speed)
        spans.insert(0, speed_text(xr.DataArray(speeds, attrs=course.speed.attrs)))
    ax.set_title("\n".join(filter(None, [words, title, ",  ".join(spans)])), fontsize=9.0)
