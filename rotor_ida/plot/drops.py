"""Plots of many drops: distributions, or ranges over a grid; and films of one."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rotor_ida.checks import check_count, check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import circle, new_figure, say_in_middle, style
from rotor_ida.plot.datasets import contact_text
from rotor_ida.plot.labels import label_axis, speeds_in, unit_of
from rotor_ida.plot.legends import shared_legend
from rotor_ida.results.checked_run import check_system_run
from rotor_ida.results.files import check_target, file_to_write
from rotor_ida.results.si_units import in_suitable_units
from rotor_ida.schema import OF_DROP
from rotor_ida.texts import in_figure

WIDTH, HEIGHT = 7.2, 5.0
# Figures of a bearing in many drops, those of which a grid shows ranges first.
RANGES = {
    "largest_force": "largest force", "excursion": "largest radius over clearance",
    "total_heat": "heat of friction",
}  # fmt: skip
WORDS = RANGES | {"largest_race_speed": "largest speed of the race"}
# Samples of an orbit behind the rotor in a film, and frames of one.
TRAIL, MOST_FRAMES = 60, 5000
ENDINGS = (".gif", ".mp4")


def plot_drops(drops: xr.Dataset) -> Figure:
    """Draw many drops: the fraction of them below a value, by bearing; or a grid of drops.

    Of a grid: ranges over the axis with most values besides the phase, with means (dots), and the
    fraction of drops that whirl backwards, over two axes if another varies.

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
    of_race = [name for name in drops.variables if str(name).startswith("largest_race_speed")]
    drops = in_suitable_units(drops).assign({name: speeds_in(drops[name]) for name in of_race})
    if "cell" in drops.sizes:
        return _plot_grid(drops)
    with style():
        figure = new_figure(WIDTH, HEIGHT)
        axes = figure.subplots(2, 2).ravel().tolist()
        for ax, name in zip(axes, WORDS, strict=True):
            for number in range(drops.sizes["contact"]):
                _draw_distribution(ax, drops, name, number)
            label_axis(ax.xaxis, name, drops[name], words=WORDS[name])
            ax.set_ylabel("fraction of drops")
            ax.set_ylim(0.0, 1.0)
            if not np.isfinite(drops[name].values).any():
                say_in_middle(ax, "no race")
                ax.set_xticks([])
        shared_legend(figure, axes, columns=5, outer=False)
    return figure


def _draw_distribution(ax: Axes, drops: xr.Dataset, name: str, number: int) -> None:
    """Draw the fraction of drops below a value, with dots at the quantiles."""
    values = drops[name].values[:, number].astype(float)
    values = np.sort(values[np.isfinite(values)])
    if not values.size:
        return
    colour, dashes = palette.look(1 + number)  # as in the figure of one drop
    node = in_figure(drops["contact_node"].values[number])
    ax.step(values, np.arange(1, values.size + 1) / values.size, where="post", color=colour,
            ls=dashes, lw=1.0, label=node)  # fmt: skip
    if f"{name}_quantile" not in drops.variables:
        return
    levels = drops["quantile"].values
    ends = [drops[f"{name}_quantile{end}"].values[:, number] for end in ("", "_low", "_high")]
    middle, low, high = (np.where(np.isfinite(each), each, ends[0]) for each in ends)
    ax.errorbar(middle, levels, xerr=[middle - low, high - middle], fmt="o", ms=3.0,
                color=colour, elinewidth=1.0, capsize=2.0)  # fmt: skip


def _plot_grid(drops: xr.Dataset) -> Figure:
    """Draw ranges and means over what varies most, and the share of drops that whirl backwards."""
    drops = drops.isel(drop=drops["status"].values == 0)
    # by number of values, the phase last unless it alone varies
    names = sorted(
        (name for name in OF_DROP if f"drop_{name}" in drops.variables),
        key=lambda name: (-_values(drops, name).size * (name != "phase"), name != "phase"),
    )
    name, other = names[0], names[1] if len(names) > 1 else "phase"
    with style():
        figure = new_figure(WIDTH, HEIGHT)
        axes = figure.subplots(2, 2).ravel().tolist()
        for ax, (figure_of, words) in zip(axes, RANGES.items(), strict=False):
            for number in range(drops.sizes["contact"]):
                _draw_range(ax, drops, name, figure_of, number)
            label_axis(ax.yaxis, figure_of, drops[figure_of], words=words)
            ax.set_xlabel(_label(drops, name))
        if other != "phase" and _values(drops, other).size > 1:
            _draw_map(figure, axes[3], drops, (name, other))
        else:
            _draw_shares(axes[3], drops, name)
        shared_legend(figure, axes, columns=5, outer=False)
    return figure


def _values(drops: xr.Dataset, name: str) -> np.ndarray:
    """Return the values on an axis of the grid, none if it does not vary."""
    found = np.unique(drops[f"drop_{name}"].values)
    return found if found.size > 1 else np.zeros(0)


def _label(drops: xr.Dataset, name: str) -> str:
    unit = "rad" if name == "phase" else unit_of(drops[f"drop_{name}"])
    return f"{OF_DROP[name]} [{unit}]" if unit else OF_DROP[name]


def _by_value(drops: xr.Dataset, name: str, values: np.ndarray) -> list[np.ndarray]:
    """Return the values of the drops at each value on an axis of the grid."""
    along = drops[f"drop_{name}"].values
    return [values[along == each] for each in np.unique(along)]


def _draw_range(ax: Axes, drops: xr.Dataset, name: str, figure_of: str, number: int) -> None:
    """Draw the range of a figure of a bearing, and its mean."""
    colour, dashes = palette.look(1 + number)
    groups = _by_value(drops, name, drops[figure_of].values[:, number])
    known = [each[np.isfinite(each)] for each in groups]
    kept = [place for place, each in enumerate(known) if each.size]
    across = np.unique(drops[f"drop_{name}"].values)[kept]
    low, high, mean = (np.array([pick(known[place]) for place in kept])
                       for pick in (np.min, np.max, np.mean))  # fmt: skip
    node = in_figure(drops["contact_node"].values[number])
    ax.fill_between(across, low, high, color=colour, alpha=0.15, lw=0.0)
    ax.plot(across, mean, color=colour, ls=dashes, marker="o", ms=2.5, label=node)


def _draw_shares(ax: Axes, drops: xr.Dataset, name: str) -> None:
    """Draw the share of drops that whirl backwards in each bearing."""
    across = np.unique(drops[f"drop_{name}"].values)
    for number in range(drops.sizes["contact"]):
        colour, dashes = palette.look(1 + number)
        groups = _by_value(drops, name, drops["whirl_sense"].values[:, number] < 0)
        ax.plot(across, [each.mean() for each in groups], color=colour, ls=dashes, marker="o",
                ms=2.5)  # fmt: skip
    ax.set(xlabel=_label(drops, name), ylabel="share that whirls backwards", ylim=(-0.02, 1.02))


def _draw_map(figure: Figure, ax: Axes, drops: xr.Dataset, names: tuple[str, str]) -> None:
    """Draw the share of drops that whirl backwards in any bearing, over two axes of the grid."""
    across, up = (np.unique(drops[f"drop_{name}"].values) for name in names)
    whirls = np.any(drops["whirl_sense"].values < 0, axis=1).astype(float)
    places = [drops[f"drop_{name}"].values for name in names]
    shares = [[whirls[(places[0] == x) & (places[1] == y)].mean() for x in across] for y in up]
    ax.grid(visible=False)
    drawn = ax.pcolormesh(np.arange(across.size), np.arange(up.size), shares, vmin=0.0, vmax=1.0,
                          cmap="Oranges")  # fmt: skip
    for axis, values in ((ax.xaxis, across), (ax.yaxis, up)):
        at = np.unique(np.linspace(0, values.size - 1, 6).astype(int))
        axis.set_ticks(at, [f"{values[each]:.3g}" for each in at])
    ax.set(xlabel=_label(drops, names[0]), ylabel=_label(drops, names[1]))
    figure.colorbar(drawn, ax=ax, label="share that whirls backwards")


def save_orbit_film(
    run: xr.Dataset, path: str | os.PathLike[str], *, frames: int = 100, rate: int = 20,
    overwrite: bool = False,
) -> Path:  # fmt: skip
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
        with file_to_write(target, overwrite=overwrite) as part:
            film.save(part, writer=writer, dpi=120)
    return target


def check_film(
    path: str | os.PathLike[str], *, overwrite: bool, permission: str = "overwrite=True"
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
    ax.plot(*circle(clearance), color=palette.INK, lw=0.9, ls=palette.DASHES)
    x, y = (run[f"contact_{axis}"].values[:, number] for axis in "xy")
    reach = 1.1 * max(clearance, float(np.hypot(x, y).max()))
    (trail,) = ax.plot([], [], color=palette.BLUE, lw=0.8)
    (dot,) = ax.plot([], [], "o", color=palette.ORANGE, ms=5.0)
    ax.set(xlim=(-reach, reach), ylim=(-reach, reach))
    ax.set_aspect("equal")
    ax.set_title(contact_text(run, number), fontsize=9.5)
    label_axis(ax.xaxis, "x_alone", run["x"])
    label_axis(ax.yaxis, "y_alone", run["y"])
    return trail, dot
