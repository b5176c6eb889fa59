"""One run: its motion between the outputs, its orbit, its contacts and their forces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patheffects import Stroke

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_choice
from rotor_ida.errors import InputError
from rotor_ida.model.contact import contact_force, damping_factor
from rotor_ida.model.table import FRICTIONLESS, PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    DARK_BROWN,
    DASHES,
    INK,
    ORANGE,
    PURPLE,
    RED,
    SHADE,
    axes_or_new,
    check_dataset,
    draw_ring,
    finish_solid,
    legend_below,
    lines_of,
    one_value,
    shared_legend,
    solid_axes,
    style,
)
from rotor_ida.plot.decimation import draw_path
from rotor_ida.plot.labels import LABELS, label_axis, label_of, scale_of, unit_of
from rotor_ida.schema import MODE, flags_of

NEEDED = (*PARAMETERS, "t", "x", "y", "vx", "vy", "starts_in_contact", "event_time",
          "event_kind", "event_x", "event_y", "event_vx", "event_vy", "entry_time",
          "exit_time")  # fmt: skip
# Above these numbers of events their marks get smaller, and then are left out: they would hide
# the motion, and the colours of contact and flight say the same.
FEW_EVENTS, MANY_EVENTS = 40, 120
# Between outputs the motion is drawn as the cubic that has its velocities too, but only where
# they lie closer than this part of a revolution; farther apart it would be an invention.
SMOOTH_BELOW = 0.2
POINTS_A_REVOLUTION = 90
# An orbit of more points is drawn without what cannot be seen.
DENSE = 200_000
# Events: the mark of each, its colour, and whether it is filled.
MARKS = {
    "entry": ("^", RED, True),
    "exit": ("v", RED, False),
    "roll": ("o", DARK_BROWN, True),
    "slip": ("o", DARK_BROWN, False),
    "reverse": ("x", PURPLE, True),
    "press": ("s", INK, True),
    "release": ("s", INK, False),
}
# With friction a motion has a colour, a line and a width for each way in which it goes on. What
# is loose in the ring slips too, though nothing presses it on.
WAYS: tuple[tuple[tuple[str, ...], str, str, object, float], ...] = (
    (("flight",), "flight", BLUE, "-", 1.0),
    (("slipping_forward", "loose"), "slips forwards", RED, "-", 1.2),
    (("slipping_backward",), "slips backwards", PURPLE, (0, (1.2, 0.7)), 1.7),
    (("rolling",), "rolls", DARK_BROWN, "-", 3.0),
)
# How a motion goes on after events that tell it; after the others it slips.
AFTER = {"exit": "flight", "roll": "rolling", "release": "loose"}
# Where it rolls the line has sleepers, so that it is told from the others without colour too.
SLEEPERS = {"dash_offset": 0.0, "dash_list": [2.0, 2.5]}


def plot_run(run: xr.Dataset) -> Figure:
    """Draw one run: displacements, radius, contact forces and orbit.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.

    Returns
    -------
    Figure
        The figure. Its axes are x, y, radius and peak force over time, and the orbit. Contact
        is shaded; events are marked while they are few enough to tell apart. With friction there
        is the slip speed too, the force is the normal one over time, and orbit and radius have
        the colours of slip, forwards and backwards, and of rolling.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> figure = plot_run(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> [ax.get_ylabel() for ax in figure.axes][:2]
    ['displacement $x$', 'displacement $y$']
    """
    run = check_dataset("run", run, (*NEEDED, "peak_time", "peak_force"))
    clearance = clearance_of(run)
    path = path_of(run)
    with style():
        layout = ConstrainedLayoutEngine(h_pad=0.03, hspace=0.0)
        rows = 4 if path.mode is None else 5
        figure = Figure(figsize=(7.2, 1.2 * rows), layout=layout)
        grid = figure.add_gridspec(rows, 2, width_ratios=(1.0, 1.0))
        first = figure.add_subplot(grid[0, 0])
        history = [first]
        history += [figure.add_subplot(grid[row, 0], sharex=first) for row in range(1, rows)]
        for ax, name, values in zip(
            history, ("x", "y", "radius"), (path.x, path.y, path.radius), strict=False
        ):
            _shade_contacts(ax, run)
            if name == "radius" and path.mode is not None:
                draw_motion(ax, path, path.time, values, width=_line_width(run))
            else:
                ax.plot(path.time, values, color=INK, lw=_line_width(run))
            ax.set_ylabel(_row_label(name, run["x"]))
        history[2].axhline(clearance, color=INK, lw=0.7, ls=DASHES, zorder=2.6)
        history[2].set_ylim(bottom=0.0)
        times = run["event_time"].values
        radius = np.hypot(run["event_x"].values, run["event_y"].values)
        on_ring = np.isin(run["event_kind"].values, (1, -1))
        _mark_events(history[2], run, times, np.where(on_ring, clearance, radius))
        _draw_forces(history[3], run)
        if path.mode is not None:
            _draw_slip(history[4], run)
        first.set_xlim(float(path.time[0]), float(path.time[-1]))
        for ax in history[:-1]:
            ax.tick_params(labelbottom=False)
        history[-1].set_xlabel(label_of("t", run["t"]))
        figure.align_ylabels(history)
        orbit = figure.add_subplot(grid[:, 1])
        orbit.set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        _draw_orbit(orbit, run, path)
        shared_legend(figure, [history[2], orbit], columns=7, outer=False)
        figure.suptitle(lines_of("run", run), fontsize=10.0)
    return figure


def plot_orbit(run: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the orbit in the plane, with the ring of the clearance.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_orbit(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> ax.get_xlabel()
    'displacement $x$'
    """
    run = check_dataset("run", run, NEEDED)
    return _plot_orbit(run, path_of(run), ("x", "y"), ax)


def plot_rotating_orbit(run: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the orbit as seen on axes that turn with the unbalance, with the ring.

    A synchronous whirl is a point there; what is left moving is what the response curve of one
    harmonic cannot show.

    Parameters
    ----------
    run, ax
        As for `plot_orbit`; what `rotor_ida.rotating` returned will do too.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_rotating_orbit(simulate(rotor, start=(0, 0, 0, 0), duration=20, samples=401))
    >>> ax.get_ylabel()
    'across it $\\operatorname{Im}\\,z\\,e^{-i\\omega t}$'
    """
    run = check_dataset("run", run, NEEDED)
    if "speed" in run.variables:
        raise InputError("run must be at one speed for axes that turn, got a run of run_up")
    omega = one_value("run", run, "omega") / scale_of(run, "time")
    path = path_of(run)
    x, y = _rotated_back(path.x, path.y, omega * path.time)
    angle = omega * run["event_time"].values
    event_x, event_y = _rotated_back(run["event_x"].values, run["event_y"].values, angle)
    seen = run.assign(event_x=("event", event_x), event_y=("event", event_y))
    return _plot_orbit(seen, replace(path, x=x, y=y), ("rotating_x", "rotating_y"), ax)


def plot_history(run: xr.Dataset, name: str, *, ax: Axes | None = None) -> Axes:
    """Draw a displacement or the radius over time, contact and flight in their colours.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    name : {"x", "y", "radius"}
        What to draw.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_history(simulate(rotor, start=(0, 0, 0, 0), duration=20), "x").get_ylabel()
    'displacement $x$'
    """
    run = check_dataset("run", run, NEEDED)
    check_choice("name", name, ("x", "y", "radius"))
    with style():
        ax = axes_or_new(ax, width=7.0, height=2.4)
        label_axis(ax.xaxis, "t", run["t"])
        label_axis(ax.yaxis, name, run["x"])
        path = path_of(run)
        draw_motion(ax, path, path.time, getattr(path, name), width=0.9)
        ax.set_xlim(float(path.time[0]), float(path.time[-1]))
    return ax


def plot_drawn_out(run: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the orbit over time in three dimensions, contact and flight in their colours.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.simulate` returned.
    ax : Axes, optional
        Three-dimensional axes to draw on and return; by default those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> plot_drawn_out(simulate(rotor, start=(0, 0, 0, 0), duration=20)).get_xlabel()
    'time $t$'
    """
    run = check_dataset("run", run, NEEDED)
    with style():
        solid = solid_axes(ax)
        path = path_of(run)
        draw_motion(solid, path, path.time, path.x, path.y, width=0.7)
        label_axis(solid.xaxis, "t", run["t"])
        label_axis(solid.yaxis, "x_alone", run["x"])
        label_axis(solid.zaxis, "y_alone", run["y"])
        solid.xaxis.labelpad, solid.yaxis.labelpad, solid.zaxis.labelpad = -4, -6, -6
        solid.view_init(elev=22, azim=-58)
        finish_solid(solid, zoom=1.12)
    return cast(Axes, solid)


def plot_machine(run: xr.Dataset) -> Figure:
    """Draw a run in SI units: orbit, distance from the bearing axis, and contact force.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.dimensional` made of a run.

    Returns
    -------
    Figure
        The figure: the orbit, the radius over time with the ring, and the contact force with
        the peak of each contact.

    Examples
    --------
    >>> from rotor_ida import DimensionalRotor, dimensional, simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = dimensional(simulate(machine.rotor(), start=(0, 0, 0, 0), duration=40.0), machine)
    >>> [ax.get_ylabel() for ax in plot_machine(run).axes][2]
    'contact force $F$ [N]'
    """
    run = check_dataset("run", run, (*NEEDED, "peak_time", "peak_force"))
    if "length_scale" not in run.attrs:
        raise InputError("run must be in SI units: rotor_ida.dimensional makes it so")
    ring, path = clearance_of(run), path_of(run)
    with style():
        figure = Figure(figsize=(7.2, 3.9), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        orbit, history = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
        force = figure.add_subplot(grid[1, 1], sharex=history)
        draw_motion(orbit, path, path.x, path.y, width=0.8)
        draw_ring(orbit, ring)
        orbit.set_aspect("equal", adjustable="datalim")
        orbit.set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        above = 1.12 if path.mode is None else 1.18
        orbit.legend(loc="upper center", bbox_to_anchor=(0.5, above), ncols=3, handlelength=1.6,
                     columnspacing=1.0)  # fmt: skip
        if path.mode is None:
            history.plot(path.time, path.radius, color=INK, lw=0.8)
        else:
            draw_motion(history, path, path.time, path.radius, width=0.8)
        history.axhline(ring, color=INK, lw=0.8, ls=DASHES)
        history.tick_params(labelbottom=False)
        history.set(ylabel=label_of("radius", run["x"]), ylim=(0.0, None))
        history.set_title(lines_of("run", run))
        forces = _force_along(run, path)
        words = "contact_force" if path.mode is None else "normal_force"
        force.plot(path.time, forces, color=RED, lw=0.8)
        force.plot(
            *_peaks_on(run, path.time, forces),
            ls="",
            marker="o",
            ms=2.4,
            color=INK,
            label="peak of a contact",
        )
        # room for the legend
        force.set(xlabel=label_of("t", run["t"]), ylim=(0.0, 1.25 * float(forces.max()) or 1.0),
                  ylabel=label_of(words, run["peak_force"]))  # fmt: skip
        force.set_xlim(float(path.time[0]), float(path.time[-1]))
        force.legend(loc="upper right")
    return figure


def plot_forces(forces: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the contact force over time, with the peak of each contact.

    With friction that is the normal force, and beside it the force along the ring.

    Parameters
    ----------
    forces : Dataset
        What `rotor_ida.contact_forces` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, contact_forces, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> plot_forces(contact_forces(run)).get_ylabel()
    'contact force $f$'
    """
    forces = check_dataset("forces", forces, ("t", "force", "peak_time", "peak_force"))
    time = forces["t"].values
    with style():
        ax = axes_or_new(ax)
        label_axis(ax.xaxis, "t", forces["t"])
        label_axis(ax.yaxis, "force", forces["force"])
        rubs, lowest = "tangential_force" in forces, 0.0
        normal = forces["normal_force" if rubs else "force"].values
        ax.plot(time, normal, color=BLUE, lw=0.9, label="normal force" if rubs else "force")
        if rubs:
            along = forces["tangential_force"].values
            ax.plot(time, along, color=ORANGE, lw=0.9, label="force along the ring")
            lowest = min(lowest, 1.1 * float(along.min(initial=0.0)))
        peaks = _peaks_on(forces, time, normal)
        ax.plot(*peaks, ls="", marker="o", ms=2.8, mec=RED, mfc="white", mew=0.8,
                label="peak of a contact")  # fmt: skip
        ax.set_xlim(float(time[0]), float(time[-1]))
        ax.set_ylim(bottom=lowest)
        if rubs:
            legend_below(ax, columns=3)
    return ax


def plot_force_peaks(forces: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw which share of the contacts stays below each peak force.

    Parameters
    ----------
    forces : Dataset
        What `rotor_ida.contact_forces` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, contact_forces, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> plot_force_peaks(contact_forces(run)).get_xlabel()
    'peak force $f$'
    """
    forces = check_dataset("forces", forces, ("peak_force", "peak_fraction"))
    peaks, share = forces["peak_force"].values, forces["peak_fraction"].values
    whole = np.flatnonzero(np.isfinite(share))
    order = whole[np.argsort(peaks[whole], kind="stable")]
    peaks, share = peaks[order], share[order]
    with style():
        ax = axes_or_new(ax)
        label_axis(ax.xaxis, "peak_force", forces["peak_force"])
        if peaks.size > 1:
            ax.step(np.append(peaks[0], peaks), np.append(0.0, share), where="post", color=RED)
            ax.set_xlim(0.0, 1.08 * float(peaks[-1]))
        else:
            words = "fewer than two whole contacts"
            ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center")
        ax.set_ylim(0.0, 1.02)
        ax.set_ylabel(LABELS["peak_fraction"])
    return ax


@dataclass(frozen=True, slots=True)
class Path:
    """The motion, at times close enough to be drawn as smooth as it is, in the run's units."""

    time: Values
    x: Values
    y: Values
    # whether the stretch that begins at each time is in contact
    in_contact: npt.NDArray[np.bool_]
    # how fast the distance from the bearing axis grows, where that is known
    radial_speed: Values | None = None
    # with friction, how the stretch that begins at each time goes on: a number of `MODE`
    mode: npt.NDArray[np.int8] | None = None

    @property
    def radius(self) -> Values:
        """Distance from the bearing axis."""
        return np.hypot(self.x, self.y)

    def stretches(self, chosen: npt.NDArray[np.bool_], *columns: Values) -> list[Values]:
        """Return columns of values along the chosen stretches of the path, parted by NaN."""
        begins = chosen[:-1]
        shown = np.zeros(chosen.shape, dtype=bool)
        shown[:-1] |= begins
        shown[1:] |= begins
        # a point that ends one stretch without beginning the next is followed by a gap
        last = np.nonzero(shown[:-1] & ~begins)[0] + 1
        return [np.insert(np.where(shown, column, np.nan), last, np.nan) for column in columns]


def path_of(run: xr.Dataset) -> Path:
    """Return outputs and events in one sequence, with points between where they lie close."""
    times = np.concatenate([run["t"].values, run["event_time"].values])
    columns = [np.append(run[name].values, run[f"event_{name}"].values) for name in COMPONENTS]
    table = np.stack(columns, axis=1)
    # velocities in units of length over units of time, which may have prefixes of their own
    table[:, 2:] *= scale_of(run, "length") / (scale_of(run, "time") * scale_of(run, "velocity"))
    times, first = np.unique(times, return_index=True)
    states = table[first]
    steps = np.diff(times)
    revolutions = max(1.0, _fastest(run)) / (2.0 * math.pi * scale_of(run, "time"))
    points = np.clip(np.ceil(steps * revolutions * POINTS_A_REVOLUTION), 1, None).astype(int)
    points[steps * revolutions > SMOOTH_BELOW] = 1
    step = np.repeat(np.arange(steps.size), points)
    part = (np.arange(step.size) - np.repeat(np.cumsum(points) - points, points) + 1) / points[step]
    time = np.append(times[:1], times[step] + part * steps[step])
    places, speeds = _cubic(part[:, None], steps[step, None], states[step], states[step + 1])
    x, y = np.concatenate([states[:1, :2], places]).T
    vx, vy = np.concatenate([states[:1, 2:], speeds]).T
    radius = np.hypot(x, y)
    outwards = np.divide(x * vx + y * vy, radius, out=np.zeros_like(radius), where=radius > 0.0)
    return Path(time, x, y, _in_contact(run, time), outwards, _modes(run, time))


def _cubic(part: Values, step: Values, before: Values, after: Values) -> tuple[Values, Values]:
    """Return places and speeds on the cubic through two states, part of a step after the first."""
    rise = part * part * (3.0 - 2.0 * part)
    bend_a, bend_b = part * (1.0 - part) ** 2, part * part * (part - 1.0)
    ends = before[:, :2] * (1.0 - rise) + after[:, :2] * rise
    places = ends + step * (before[:, 2:] * bend_a + after[:, 2:] * bend_b)
    climb = 6.0 * part * (1.0 - part) * (after[:, :2] - before[:, :2]) / step
    turn_a, turn_b = (1.0 - part) * (1.0 - 3.0 * part), part * (3.0 * part - 2.0)
    return places, climb + before[:, 2:] * turn_a + after[:, 2:] * turn_b


def _force_along(run: xr.Dataset, path: Path) -> Values:
    """Return the contact force along the path of a run in the units of the run."""
    given = {name: one_value("run", run, name) for name in FRICTIONLESS if name in run.variables}
    machine, length = FRICTIONLESS | given, scale_of(run, "length")
    delta0, damping = one_value("run", run, "delta0"), machine["contact_damping"]
    force = contact_force(path.radius / length, delta0, machine["contact_exponent"])
    if damping > 0.0 and path.radial_speed is not None:
        speed = path.radial_speed * scale_of(run, "time") / length
        force = force * damping_factor(speed, damping)
    return scale_of(run, "force") * force


def _in_contact(run: xr.Dataset, time: Values) -> npt.NDArray[np.bool_]:
    """Return whether the stretch that begins at each time is in contact."""
    passed = np.searchsorted(run["event_time"].values, time, side="right")
    leaving = flags_of(run["event_kind"])["exit"]
    after = np.append(bool(run["starts_in_contact"].values), run["event_kind"].values != leaving)
    return np.asarray(after[passed], dtype=bool)


def _modes(run: xr.Dataset, time: Values) -> npt.NDArray[np.int8] | None:
    """Return how the stretch that begins at each time goes on; None without friction."""
    if "mode" not in run.variables:
        return None
    met = run["event_time"].values
    between = _modes_without_samples(run)
    seen, first = np.unique(np.searchsorted(met, run["t"].values, side="right"), return_index=True)
    between[seen] = run["mode"].values[first]
    return between[np.searchsorted(met, time, side="right")]


def _modes_without_samples(run: xr.Dataset) -> npt.NDArray[np.int8]:
    """Return how the motion goes on from its start and from each event, as far as events tell."""
    x, y, vx, vy = (run[f"event_{name}"].values for name in COMPONENTS)
    speed = run["omega"].item()
    if "event_speed" in run.variables:
        speed = run["event_speed"].values / scale_of(run, "speed")
    rim = run["disc_radius"].item() * speed * scale_of(run, "velocity")
    slip = np.append((x * vy - y * vx) / np.hypot(x, y) + rim, 0.0)
    # it keeps its sense from one event to the next, at one of which it may be 0
    senses = np.where(slip[:-1] + slip[1:] < 0.0, -1, 1).tolist()
    words = {number: word for word, number in flags_of(run["event_kind"]).items()}
    modes = [int(run["mode"].values[0])]
    for kind, sense in zip(run["event_kind"].values.tolist(), senses, strict=True):
        word = words[kind]
        turned = -modes[-1] if word == "reverse" else sense
        modes.append(MODE[AFTER[word]] if word in AFTER else turned)
    return np.array(modes, dtype=np.int8)


def _rotated_back(x: Values, y: Values, angle: Values) -> tuple[Values, Values]:
    rotated = (x + 1j * y) * np.exp(-1j * angle)
    return rotated.real, rotated.imag


def clearance_of(run: xr.Dataset) -> float:
    """Return the clearance in the units of the lengths of a run."""
    return one_value("run", run, "delta0") * scale_of(run, "length")


def _shade_contacts(ax: Axes, run: xr.Dataset) -> None:
    """Shade each contact, as far as the run shows it."""
    ax.grid(visible=False, axis="x")
    first, last = run["t"].values[[0, -1]]
    entries = np.nan_to_num(run["entry_time"].values, nan=first)
    exits = np.nan_to_num(run["exit_time"].values, nan=last)
    if entries.size:
        ax.broken_barh(
            list(zip(entries, exits - entries, strict=True)), (0.0, 1.0), label="in contact",
            transform=ax.get_xaxis_transform(), facecolor=SHADE, linewidth=0.0, zorder=0.5,
        )  # fmt: skip


def _mark_events(ax: Axes, run: xr.Dataset, across: Values, up: Values) -> None:
    """Mark events at their places, while they are few enough to tell apart."""
    kinds, flags = run["event_kind"].values, flags_of(run["event_kind"])
    if kinds.size > MANY_EVENTS:
        return
    for name, (marker, colour, filled) in MARKS.items():
        of_kind = kinds == flags.get(name)
        if of_kind.any():
            ax.plot(
                across[of_kind], up[of_kind], ls="", marker=marker, ms=_mark_size(run), mec=colour,
                mfc=colour if filled else "white", mew=0.7, label=name, zorder=3.0,
            )  # fmt: skip


def _row_label(name: str, variable: xr.DataArray) -> str:
    """Return the label of a low panel: with a unit, name and symbol do not fit both."""
    label = label_of(name, variable)
    return label.partition(" ")[2] if unit_of(variable) else label


def _draw_forces(ax: Axes, run: xr.Dataset) -> None:
    """Draw the peaks of the contacts; with friction on the normal force over time."""
    _shade_contacts(ax, run)
    times, forces = _peaks(run)
    highest, name = float(forces.max(initial=0.0)), "peak_force"
    if "normal_force" in run.variables:
        normal, name = run["normal_force"].values, "normal_force"
        ax.plot(run["t"].values, normal, color=RED, lw=0.8)
        highest = max(highest, float(normal.max(initial=0.0)))
    else:
        ax.vlines(times, 0.0, forces, color=RED, lw=0.8)
    ax.plot(times, forces, ls="", marker="o", ms=max(2.0, 0.7 * _mark_size(run)), color=RED)
    ax.set_ylim(0.0, 1.12 * highest or 1.0)
    ax.set_ylabel(_row_label(name, run["peak_force"]))
    if not run.sizes["contact"]:
        ax.text(0.5, 0.5, "no contact", transform=ax.transAxes, ha="center", va="center")


def _draw_slip(ax: Axes, run: xr.Dataset) -> None:
    """Draw the slip speed over time, in contact."""
    _shade_contacts(ax, run)
    slip = np.where(run["mode"].values == MODE["flight"], np.nan, run["slip_speed"].values)
    ax.axhline(0.0, color=INK, lw=0.7, ls=DASHES)
    ax.plot(run["t"].values, slip, color=INK, lw=_line_width(run))
    ax.set_ylabel(_row_label("slip_speed", run["slip_speed"]))


def draw_motion(ax: Any, path: Path, *columns: Values, width: float, heavier: float = 1.0) -> None:
    """Draw flight and contact in their colours, contact this much heavier.

    With friction slip in either sense and rolling have looks of their own.
    """
    if path.mode is not None:
        _draw_ways(ax, path, path.mode, columns, width)
        return
    for chosen, colour, lw, label in (
        (~path.in_contact, BLUE, width, "flight"),
        (path.in_contact, RED, heavier * width, "contact"),
    ):
        if not chosen[:-1].any():
            continue
        if path.time.size > DENSE and len(columns) == 2 and columns[0] is path.x:
            draw_path(ax, *path.stretches(chosen, *columns), colour=colour, width=lw, words=label)
            continue
        ax.plot(*path.stretches(chosen, *columns), color=colour, lw=lw, label=label)


def _draw_ways(
    ax: Any, path: Path, ways: npt.NDArray[np.int8], columns: tuple[Values, ...], width: float
) -> None:
    """Draw flight, slip and rolling."""
    for modes, label, colour, dashes, heavier in WAYS:
        chosen = np.isin(ways, [MODE[mode] for mode in modes])
        if not chosen[:-1].any():
            continue
        line: Any = {"color": colour, "lw": heavier * width, "ls": dashes, "label": label}
        if label == "rolls":
            line["solid_capstyle"] = "butt"
            line["path_effects"] = [
                Stroke(), Stroke(linewidth=width, foreground="white", dashes=SLEEPERS)
            ]  # fmt: skip
        ax.plot(*path.stretches(chosen, *columns), **line)


def _peaks(dataset: xr.Dataset) -> tuple[Values, Values]:
    """Return times and forces of the peaks of contacts.

    Where a run begins or ends inside a contact, the largest force there is no peak.
    """
    times, first, last = dataset["peak_time"].values, *dataset["t"].values[[0, -1]]
    seen = (times > first) & (times < last)
    return times[seen], dataset["peak_force"].values[seen]


def _peaks_on(dataset: xr.Dataset, time: Values, force: Values) -> tuple[Values, Values]:
    """Return times and forces of the peaks of contacts, as they lie on the force over time.

    With contact damping the force is largest before the indentation, whose time is told.
    """
    times, peaks = _peaks(dataset)
    if "contact_damping" not in dataset.variables:
        return times, peaks
    free = np.flatnonzero(force == 0.0)
    first = np.append(-1, free)[np.searchsorted(time[free], times, side="right")] + 1
    last = np.append(free, time.size)[np.searchsorted(time[free], times, side="right")]
    places = [
        one + int(np.argmax(force[one:other])) if other > one else one
        for one, other in zip(first.tolist(), last.tolist(), strict=True)
    ]
    return time[np.minimum(places, time.size - 1).astype(int)], peaks


def _plot_orbit(run: xr.Dataset, path: Path, names: tuple[str, str], ax: Axes | None) -> Axes:
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.9)
        label_axis(ax.xaxis, names[0], run["x"])
        label_axis(ax.yaxis, names[1], run["y"])
        _draw_orbit(ax, run, path)
        legend_below(ax)
        ax.set_title(lines_of("run", run))
    return ax


def _draw_orbit(ax: Axes, run: xr.Dataset, path: Path) -> None:
    draw_ring(ax, clearance_of(run))
    draw_motion(ax, path, path.x, path.y, width=_line_width(run), heavier=1.2)
    _mark_events(ax, run, run["event_x"].values, run["event_y"].values)
    ax.plot(path.x[0], path.y[0], ls="", marker="s", ms=4.5, color=INK, label="start", zorder=3.1)
    ax.set_aspect("equal", adjustable="datalim")
    ax.autoscale_view()


def _fastest(run: xr.Dataset) -> float:
    """Return the largest speed of a run [1]."""
    omega = one_value("run", run, "omega")
    if "speed" in run.variables:
        omega = max(omega, float(run["speed"].max()) / scale_of(run, "speed"))
    return omega


def _line_width(run: xr.Dataset) -> float:
    duration = float(run["t"].values[-1] - run["t"].values[0]) / scale_of(run, "time")
    revolutions = duration * max(1.0, _fastest(run)) / (2.0 * math.pi)
    return 1.1 if revolutions < 15 else 0.7 if revolutions < 60 else 0.45


def _mark_size(run: xr.Dataset) -> float:
    return 4.0 if run.sizes["event"] <= FEW_EVENTS else 2.2
