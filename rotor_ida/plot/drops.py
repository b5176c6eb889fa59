"""Plots of drops: forces, radius, speeds and races over time; distributions of many drops."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rotor_ida.checks import check_count, check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    DASHES,
    GREY,
    INK,
    ORANGE,
    circle,
    look,
    new_figure,
    say_in_middle,
    shared_legend,
    style,
)
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.drop_grids import RANGES, plot_grid
from rotor_ida.plot.forces import forces_in
from rotor_ida.plot.labels import label_axis
from rotor_ida.plot.motion import in_contact
from rotor_ida.results.files import check_target, file_to_write
from rotor_ida.results.run import check_system_run
from rotor_ida.results.si_units import in_suitable_units
from rotor_ida.texts import in_figure

WIDTH, ROW = 7.2, 1.7
# Figures of a bearing in many drops, and samples of an orbit behind the rotor in a film.
WORDS = RANGES | {"largest_race_speed": "largest speed of the race"}
TRAIL, MOST_FRAMES = 60, 5000
EXTREMES = ("min", "max")
RPM = 60.0 / math.tau
ENDINGS = (".gif", ".mp4")


def plot_drop(run: xr.Dataset) -> Figure:
    """Draw a drop over time: radius and force in each bearing, and the speeds of rotor and races.

    Parameters
    ----------
    run : Dataset
        Result of `rotor_ida.drop`.

    Returns
    -------
    Figure
        The figure.

    Examples
    --------
    >>> from rotor_ida import Contact, RotorSystem, drop
    >>> bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0)
    >>> system = RotorSystem(mass=20.0 * np.eye(2), stiffness=np.zeros((2, 2)),
    ...                      nodes={"disc": (0, 1)}, contacts=[bearing])
    >>> run = drop(system, speed=500.0, duration=0.1)
    >>> [ax.get_ylabel() for ax in plot_drop(run).axes]
    ['radius over clearance', 'normal force $N$ [kN]']
    """
    run = in_suitable_units(check_system_run(run))
    has_speeds = "speed" in run.variables or "event_race_speed" in run.variables
    rows = 3 if has_speeds else 2
    with style():
        figure = new_figure(WIDTH, 0.9 + ROW * rows)
        axes = figure.subplots(rows, 1, sharex=True).tolist()
        time = run["t"].values
        for number in range(run.sizes["contact"]):
            _draw_bearing(axes[0], axes[1], run, number)
        axes[0].axhline(1.0, color=INK, lw=0.8, ls=DASHES, label="clearance")
        axes[0].set_ylabel("radius over clearance")
        axes[0].set_ylim(bottom=0.0)
        axes[1].set_ylim(bottom=0.0)
        label_axis(axes[1].yaxis, "normal_force", run["normal_force"])
        if has_speeds:
            _draw_speeds(axes[2], run)
        axes[0].set_xlim(*time[[0, -1]])
        label_axis(axes[-1].xaxis, "t", run["t"])
        figure.align_ylabels(axes)
        shared_legend(figure, axes, columns=5, outer=False)
    return figure


def _draw_bearing(above: Axes, below: Axes, run: xr.Dataset, number: int) -> None:
    """Draw radius and force of one bearing."""
    colour, dashes = look(1 + number)
    own = in_contact(run, number)
    node, forces = in_figure(own["contact_node"].item()), forces_in(own)
    radius = np.hypot(own["contact_x"].values, own["contact_y"].values) / float(own["clearance"])
    for ax, times, values in (
        (above, own["t"].values, radius), (below, forces.time, forces.normal),
    ):  # fmt: skip
        kept = kept_in_columns(times, values)
        ax.plot(times[kept], values[kept], color=colour, ls=dashes, lw=0.8, label=node)


def _draw_speeds(ax: Axes, run: xr.Dataset) -> None:
    """Draw the speeds of the rotor and of the races, these at events, extremes and the end."""
    unit = str(run["event_speed"].attrs.get("units", "1")) if "event_speed" in run else "1"
    parts = RPM if unit == "s-1" else 1.0
    if "speed" in run.variables:
        ax.plot(run["t"], parts * run["speed"].values, color=INK, lw=1.2, label="rotor")
    if "event_race_speed" in run.variables:
        races = np.flatnonzero(~np.isnan(run["race_radius"].values))
        last = run["final_state"].values[run.sizes["component"] - races.size :]
        for number, at_end in zip(races, last, strict=True):
            colour, dashes = look(1 + int(number))
            most = [run[f"race_speed_{name}"].values[number] for name in EXTREMES]
            at = [run[f"race_speed_{name}_time"].values[number] for name in EXTREMES]
            times = np.concatenate([run["event_time"].values, at, run["t"].values[-1:]])
            order = np.argsort(times, kind="stable")
            times = times[order]
            speeds = np.concatenate([run["event_race_speed"].values[:, number], most, [at_end]])
            speeds = speeds[order]
            kept = kept_in_columns(times, speeds)
            ax.plot(times[kept], parts * speeds[kept], color=colour, ls=dashes, lw=0.8)
    words = "speeds of rotor, races" if "event_race_speed" in run else "speed of rotor"
    ax.set_ylabel(f"{words} [rpm]" if unit == "s-1" else words, fontsize=9.0)
    ax.axhline(0.0, color=GREY, lw=0.6)


def plot_drops(drops: xr.Dataset) -> Figure:
    """Draw many drops: the fraction of them below a value, by bearing; or a grid of drops.

    Of a grid: ranges over the axis with most values besides the phase, with means (dots), and the
    share of drops that whirl backwards, over two axes if another varies.

    Parameters
    ----------
    drops : Dataset
        Result of `rotor_ida.drop_ensemble`.

    Returns
    -------
    Figure
        The figure: forces, excursions, heat, and speeds of races.

    Examples
    --------
    >>> from rotor_ida import Contact, RotorSystem, drop_ensemble
    >>> bearing = Contact(node="disc", clearance=2e-4, stiffness=2e9, damping=1.0)
    >>> system = RotorSystem(mass=20.0 * np.eye(2), stiffness=np.zeros((2, 2)),
    ...                      nodes={"disc": (0, 1)}, contacts=[bearing])
    >>> drops = drop_ensemble(system, speed=500.0, duration=0.05, drops=4,
    ...                       workers=1)
    >>> len(plot_drops(drops).axes)
    4
    """
    drops = check_instance("drops", drops, xr.Dataset)
    missing = [name for name in (*WORDS, "contact_node") if name not in drops.variables]
    missing += [] if "drop" in drops.dims else ["the dimension drop"]
    if missing:
        raise InputError(f"drops must be a result of drop_ensemble; it lacks {missing[0]}")
    drops = in_suitable_units(drops)
    if "cell" in drops.sizes:
        return plot_grid(drops)
    with style():
        figure = new_figure(WIDTH, 5.0)
        axes = figure.subplots(2, 2).ravel().tolist()
        for ax, name in zip(axes, WORDS, strict=True):
            for number in range(drops.sizes["contact"]):
                _draw_distribution(ax, drops, name, number)
            label_axis(ax.xaxis, name, drops[name], words=WORDS[name])
            if name == "largest_race_speed" and drops[name].attrs.get("units") == "s-1":
                ax.set_xlabel(f"{WORDS[name]} [rpm]")
            ax.set_ylabel("fraction of drops")
            ax.set_ylim(0.0, 1.0)
            if not np.isfinite(drops[name].values).any():
                say_in_middle(ax, "no race")
                ax.set_xticks([])
        shared_legend(figure, axes, columns=5, outer=False)
    return figure


def _draw_distribution(ax: Axes, drops: xr.Dataset, name: str, number: int) -> None:
    """Draw the fraction of drops below a value, with dots at the quantiles."""
    in_rpm = name == "largest_race_speed" and drops[name].attrs.get("units") == "s-1"
    parts = RPM if in_rpm else 1.0
    values = parts * drops[name].values[:, number].astype(float)
    values = np.sort(values[np.isfinite(values)])
    if not values.size:
        return
    colour, dashes = look(1 + number)  # as in the figure of one drop
    node = in_figure(drops["contact_node"].values[number])
    ax.step(values, np.arange(1, values.size + 1) / values.size, where="post", color=colour,
            ls=dashes, lw=1.0, label=node)  # fmt: skip
    if f"{name}_quantile" not in drops.variables:
        return
    levels = drops["quantile"].values
    ends = [parts * drops[f"{name}_quantile{end}"].values[:, number]
            for end in ("", "_low", "_high")]  # fmt: skip
    middle, low, high = (np.where(np.isfinite(each), each, ends[0]) for each in ends)
    ax.errorbar(middle, levels, xerr=[middle - low, high - middle], fmt="o", ms=3.0,
                color=colour, elinewidth=1.0, capsize=2.0)  # fmt: skip


def save_orbit_film(
    run: xr.Dataset,
    path: str | os.PathLike[str],
    *,
    frames: int = 100,
    rate: int = 20,
    overwrite: bool = False,
) -> Path:
    """Write a film of the orbits in all bearings, as GIF, or as MP4 where ffmpeg is installed.

    Parameters
    ----------
    run : Dataset
        A run of a rotor system.
    path : path-like
        The file, ending in ``.gif`` or ``.mp4``.
    frames : int
        Number of frames, spread evenly over the samples of the run.
    rate : int
        Frames per second.
    overwrite : bool
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file has another ending or exists, or ffmpeg is missing for MP4.
    ArchiveError
        If the file cannot be written.
    """
    from matplotlib.animation import (  # noqa: PLC0415 - takes a moment
        AbstractMovieWriter,
        FFMpegWriter,
        FuncAnimation,
        PillowWriter,
    )

    run = in_suitable_units(check_system_run(run))
    target = check_film(path, overwrite=overwrite)
    count = check_count("frames", frames, minimum=2, maximum=MOST_FRAMES)
    speed = check_count("rate", rate, minimum=1, maximum=100)
    contacts = run.sizes["contact"]
    if not contacts:
        raise InputError("run must have contacts, got none")
    places = np.unique(np.linspace(0, run.sizes["t"] - 1, count).astype(int))
    with style():
        figure = new_figure(min(3.2 * contacts, 9.6), 3.5)
        axes = figure.subplots(1, contacts, squeeze=False)[0].tolist()
        lines = [_film_panel(ax, run, number) for number, ax in enumerate(axes)]
        title = figure.suptitle(" ", fontsize=10.0)
        unit = str(run["t"].attrs.get("units", "")).removeprefix("1")

        figure.draw_without_rendering()
        figure.set_layout_engine("none")  # laid out once, not for every frame

        places_x, places_y = run["contact_x"].values, run["contact_y"].values
        times = run["t"].values

        def draw(place: int) -> None:
            first = max(0, place - TRAIL)
            for number, (trail, dot) in enumerate(lines):
                x, y = places_x[:, number], places_y[:, number]
                trail.set_data(x[first : place + 1], y[first : place + 1])
                dot.set_data(x[place : place + 1], y[place : place + 1])
            title.set_text(f"t = {times[place]:.4f} {unit}")

        film = FuncAnimation(figure, draw, frames=places.tolist())
        writer: AbstractMovieWriter = (
            PillowWriter(fps=speed) if target.suffix == ".gif" else FFMpegWriter(fps=speed)
        )
        with file_to_write("film", target, overwrite=overwrite) as part:
            film.save(part, writer=writer, dpi=120)
    return target


def check_film(
    path: str | os.PathLike[str], *, overwrite: bool, permission: str = "overwrite is true"
) -> Path:
    """Return the path of a film that can be written here."""
    from matplotlib.animation import FFMpegWriter  # noqa: PLC0415 - takes a moment

    target = check_target("film", path, overwrite=overwrite, permission=permission)
    if target.suffix not in ENDINGS:
        raise InputError(f"film must end in .gif or .mp4, got {shown(str(path))}")
    if target.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise InputError("film must end in .gif, as ffmpeg is not installed for .mp4")
    return target


def _film_panel(ax: Axes, run: xr.Dataset, number: int) -> tuple[Line2D, Line2D]:
    """Draw the clearance of a bearing; return the lines of orbit and rotor."""
    clearance = float(run["clearance"][number])
    ax.plot(*circle(clearance), color=INK, lw=0.9, ls=DASHES)
    x, y = (run[f"contact_{axis}"].values[:, number] for axis in "xy")
    reach = 1.1 * max(clearance, float(np.hypot(x, y).max()))
    (trail,) = ax.plot([], [], color=BLUE, lw=0.8)
    (dot,) = ax.plot([], [], "o", color=ORANGE, ms=5.0)
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach))
    ax.set_aspect("equal")
    ax.set_title(
        f"contact {number} at {in_figure(run['contact_node'].values[number])}", fontsize=9.5
    )
    label_axis(ax.xaxis, "x_alone", run["x"])
    label_axis(ax.yaxis, "y_alone", run["y"])
    return trail, dot
