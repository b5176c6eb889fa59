"""How a motion is drawn: where it is seen, modes in colour, events, orbit, contact forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import Stroke
from matplotlib.ticker import MaxNLocator

from rotor_ida.arrays import Flags, Values
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot import palette
from rotor_ida.plot.appearance import draw_marks, draw_ring, drawing, say_in_middle
from rotor_ida.plot.datasets import check_dataset, clearance_of, contact_in, contact_text
from rotor_ida.plot.decimation import draw_over_time, draw_path
from rotor_ida.plot.labels import label_axis
from rotor_ida.plot.legends import legend_below
from rotor_ida.results.checked_run import check_columns, check_system_run, is_of_system
from rotor_ida.results.si_units import in_suitable_units, scale_of
from rotor_ida.schema import MODE, flags_of
from rotor_ida.signals.nodes import Ring, path_in, rings_of
from rotor_ida.signals.path import Path, force_along, largest_speed, path_of

NEEDED = (*PARAMETERS, "t", "x", "y", "vx", "vy", "starts_in_contact", "event_time",
          "event_kind", "event_x", "event_y", "event_vx", "event_vy", "entry_time",
          "exit_time")  # fmt: skip
WITH_PEAKS = (*NEEDED, "peak_time", "peak_force")
# Above these numbers of events their marks get smaller, and then are left out: they would hide
# the motion, and the colours of contact and flight show the same.
FEW_EVENTS, MANY_EVENTS = 40, 120

# Events: the mark of each, its colour, and whether it is filled.
MARKS = {
    "entry": ("^", palette.RED, True),
    "exit": ("v", palette.RED, False),
    "roll": ("o", palette.DARK_BROWN, True),
    "slip": ("o", palette.DARK_BROWN, False),
    "reverse": ("x", palette.PURPLE, True),
    "press": ("s", palette.INK, True),
    "release": ("s", palette.INK, False),
}
# With friction each kind of motion has a colour, a line and a width. Flight counts as slip, at no
# normal force.
WAYS: tuple[tuple[tuple[str, ...], str, str, object, float], ...] = (
    (("flight",), "flight", palette.BLUE, "-", 1.0),
    (("slipping_forward", "loose"), "slips forwards", palette.RED, "-", 1.2),
    (("slipping_backward",), "slips backwards", palette.PURPLE, (0, (1.2, 0.7)), 1.7),
    (("rolling",), "rolls", palette.DARK_BROWN, "-", 3.0),
)
# Rolling is a double line, so that it differs from the others without colour too.
CORE = "#f3e9e4"
PEAK = "peak of a contact"
IN_AND_OUT = "in and out of contact"
# Contacts are drawn apart if the gap between them is at least the time shown over this number:
# half a point of a panel.
DRAWN_APART = 400


class Place(NamedTuple):
    """Where a rotor is seen: the disc, or a node of a system, in one contact.

    `run` has the events and episodes of that contact alone, whose number among all contacts gives
    it its colour. Without a stator the clearance is 0.
    """

    title: str
    run: xr.Dataset
    path: Path
    clearance: float
    centre: complex = 0j
    number: int = 0

    @property
    def radius(self) -> Values:
        """Distance from the centre of the stator."""
        return np.abs(self.path.x + 1j * self.path.y - self.centre)

    @property
    def rubs(self) -> bool:
        """Whether friction acts."""
        force = self.run.get("tangential_force")
        return self.path.mode is not None and (force is None or bool(force.values.any()))

    @property
    def has_stator(self) -> bool:
        """Whether there is a contact."""
        return "entry_time" in self.run.variables

    @property
    def entries(self) -> Values:
        """Times at which contacts begin; NaN where one lasts from the start of the run."""
        return np.asarray(self.run["entry_time"].values) if self.has_stator else np.empty(0)

    @property
    def event_radius(self) -> Values:
        """Distance from the centre of the stator at the events; on it at entries and exits."""
        z = self.run["event_x"].values + 1j * self.run["event_y"].values
        on_ring = np.isin(self.run["event_kind"].values, (1, -1))
        return np.where(on_ring, self.clearance, np.abs(z - self.centre))


def checked_run(run: object, needed: Sequence[str] = WITH_PEAKS) -> xr.Dataset:
    """Return a run of any rotor, or a part of one, in suitable units and with its events only."""
    if isinstance(run, xr.Dataset) and is_of_system(run):
        return _with_own_events(in_suitable_units(check_system_run(run)))
    found = check_dataset("run", run, needed)
    check_columns(found, ("t", "event_time"))
    return _with_own_events(found)


def _with_own_events(run: xr.Dataset) -> xr.Dataset:
    """Return a part of a run with the events in its time; refuse one without samples."""
    if not run.sizes["t"]:
        raise InputError("run must contain samples, got none")
    events, (first, last) = run["event_time"].values, run["t"].values[[0, -1]]
    before = run["event_kind"].values[events < first]
    part = run.isel(event=(events >= first) & (events <= last))
    if not before.size or "starts_in_contact" not in run.variables:
        return part
    touches = before[-1] != flags_of(run["event_kind"])["exit"]
    return part.assign(starts_in_contact=run["starts_in_contact"].copy(data=np.int8(touches)))


def place_of_disc(run: xr.Dataset) -> Place:
    """Return the disc in its stator."""
    return Place("", run, path_of(run), clearance_of(run))


def places_in(run: xr.Dataset, nodes: Sequence[str]) -> list[Place]:
    """Return the contacts at some nodes of a run of a system; nodes without any in space."""
    return [
        place_at(run, ring._replace(contacts=contacts))
        for ring in rings_of(run, nodes)
        for contacts in [[number] for number in ring.contacts] or [[]]
    ]


def place_at(run: xr.Dataset, ring: Ring) -> Place:
    """Return a node of a system in one contact, or in none."""
    path = path_in(run, ring)
    if not ring.contacts:
        own = run.isel(event=slice(0, 0), episode=slice(0, 0))
        return Place(ring.title, own.drop_vars(("entry_time", "exit_time")), path, 0.0)
    own = in_contact(run, ring.contacts[0])
    centre = complex(own["centre_x"], own["centre_y"])
    title = contact_text(run, ring.contacts[0])
    return Place(title, own, path, float(own["clearance"]), centre, ring.contacts[0])


def in_contact(run: xr.Dataset, number: int) -> xr.Dataset:
    """Return one contact in a run of a system, with its events as in a run of one disc."""
    own = run.isel(
        contact=number, event=run["event_contact"].values == number,
        episode=run["episode_contact"].values == number,
    )  # fmt: skip
    aside = {f"event_{axis}": own[f"event_contact_{axis}"] + own[f"centre_{axis}"] for axis in "xy"}
    return own.assign(aside)


def draw_orbit(ax: Axes, place: Place) -> None:
    """Draw the orbit of a rotor, with the stator, the events and the start."""
    path = place.path
    draw_ring(ax, place.clearance, place.centre)
    draw_motion(ax, path, path.x, path.y, width=line_width(place.run), heavier=1.2)
    if "event_x" in place.run.variables:
        mark_events(ax, place.run, place.run["event_x"].values, place.run["event_y"].values)
    draw_marks(ax, path.x[0], path.y[0], "s", palette.INK, size=4.5, label="start", level=3.1)
    ax.set_aspect("equal", adjustable="datalim")
    ax.autoscale_view()


def square(ax: Axes) -> None:
    """Make a small panel of an orbit square, with few ticks."""
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_box_aspect(1.0)
    ax.tick_params(labelsize=8.0)
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=4, steps=[1, 2, 5, 10]))


def draw_motion(ax: Any, path: Path, *columns: Values, width: float, heavier: float = 1.0) -> None:
    """Draw flight and contact in colour, contact wider by a factor.

    With friction, forward slip, backward slip and rolling have separate styles.
    """
    ways: list[tuple[Flags, str, str, object, float]] = [
        (~path.in_contact, "flight", palette.BLUE, "-", 1.0),
        (path.in_contact, "contact", palette.RED, "-", heavier),
    ]
    if path.mode is not None:
        ways = [
            (np.isin(path.mode, [MODE[mode] for mode in modes]), label, colour, dashes, wider)
            for modes, label, colour, dashes, wider in WAYS
        ]
    for chosen, label, colour, dashes, wider in ways:
        if not chosen[:-1].any():
            continue
        line: Any = {"color": colour, "lw": wider * width, "ls": dashes, "label": label}
        if label == "rolls":
            line["solid_capstyle"] = "butt"
            line["path_effects"] = [Stroke(), Stroke(linewidth=width, foreground=CORE)]
        parts = path.stretches(chosen, *columns)
        if len(columns) == 2 and columns[0] is path.x:
            draw_path(ax, *parts, **line)
        else:
            ax.plot(*parts, **line)


def mark_events(ax: Axes, run: xr.Dataset, across: Values, up: Values) -> None:
    """Mark events, unless they are too many."""
    kinds, flags = run["event_kind"].values, flags_of(run["event_kind"])
    if kinds.size > MANY_EVENTS:
        return
    size = 4.0 if kinds.size <= FEW_EVENTS else 2.2
    for name, (marker, colour, filled) in MARKS.items():
        of_kind = kinds == flags.get(name)
        if of_kind.any():
            draw_marks(ax, across[of_kind], up[of_kind], marker, colour, size=size,
                       face="" if filled else "white", edge=0.7, label=name,
                       level=3.0)  # fmt: skip


def line_width(run: xr.Dataset) -> float:
    """Return the width of an orbit: thin if it has many turns."""
    turns = float(run["t"].values[-1] - run["t"].values[0]) / (2.0 * math.pi)
    if "zeta" in run.variables:
        turns *= max(1.0, largest_speed(run)) / scale_of(run, "time")
    else:
        turns *= np.abs(run["speed"] if "speed" in run.variables else run.attrs["speed"]).max()
    return 1.1 if turns < 15 else 0.7 if turns < 60 else 0.45


class Forces(NamedTuple):
    """The forces of a contact over time, and times and forces of its peaks."""

    time: Values
    normal: Values
    peaks: tuple[Values, Values]
    unit: xr.DataArray
    name: str = "force"
    # on the times of samples; without friction there is none
    tangential: tuple[Values, Values] | None = None


def plot_forces(forces: xr.Dataset, *, contact: int | str = 0, ax: Axes | None = None) -> Axes:
    """Draw the contact force over time, with the peak of each contact.

    With friction, draw the normal force and the force along the stator.

    Parameters
    ----------
    forces : Dataset
        Result of `rotor_ida.contact_forces`, or a run of any rotor.
    contact : int or str
        Contact of a rotor system, by its number or its node.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, contact_forces, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> plot_forces(contact_forces(run)).get_ylabel()
    'contact force $f$'
    """
    title, dataset = "", forces
    if isinstance(forces, xr.Dataset) and "force" in forces.variables:
        dataset = check_dataset("forces", forces, ("t", "force", "peak_time", "peak_force"))
        found = _of_table(dataset)
    else:
        run = checked_run(forces)
        if is_of_system(run):
            number = contact_in(run, contact)
            dataset, title = in_contact(run, number), contact_text(run, number)
            found = forces_in(dataset)
        else:
            place = place_of_disc(run)
            dataset, found = run, forces_in(run, place.path)
    with drawing(ax, width=7.0, height=2.6) as ax:
        label_axis(ax.xaxis, "t", dataset["t"])
        draw_forces(ax, found)
        shade_contacts(ax, dataset)
        ax.set_xlim(*dataset["t"].values[[0, -1]])
        ax.set_title(title)
        legend_below(ax, columns=5)
    return ax


def draw_forces(ax: Axes, forces: Forces) -> None:
    """Draw the forces of a contact over time, through their peaks."""
    label_axis(ax.yaxis, forces.name, forces.unit)
    if not forces.normal.any():
        say_in_middle(ax, "no contact")
        return
    lowest = 0.0
    for words, values, colour in (
        ("normal force", (forces.time, forces.normal), palette.BLUE),
        ("force along the stator", forces.tangential, palette.ORANGE),
    ):
        if values is not None:
            draw_over_time(ax, *values, color=colour, lw=0.9, label=words)
            lowest = min(lowest, 1.1 * float(values[1].min(initial=0.0)))
    if forces.peaks[0].size:
        draw_marks(ax, *forces.peaks, "o", palette.RED, size=2.8, face="white", edge=0.8,
                   label=PEAK)  # fmt: skip
    ax.set_ylim(lowest, 1.12 * float(forces.normal.max()))


def forces_in(run: xr.Dataset, path: Path | None = None) -> Forces:
    """Return the forces in a run of one disc along its path, or at a contact of a system."""
    if path is not None and "zeta" in run.variables:
        peaks = _peaks_on_curve(run, path.time, force := force_along(run, path))
        name = "force" if path.mode is None else "normal_force"
        return Forces(*_with_peaks(path.time, force, peaks), peaks, run["peak_force"], name)
    times = run["t"].values
    peaks = _within(times, run["peak_force_time"].values, run["peak_force"].values)
    curve = _with_peaks(times, run["normal_force"].values, peaks)
    along = run["tangential_force"].values
    return Forces(*curve, peaks, run["normal_force"], "normal_force",
                  (times, along) if along.any() else None)  # fmt: skip


def _of_table(forces: xr.Dataset) -> Forces:
    """Return the forces in a result of `contact_forces`."""
    times, rubs = forces["t"].values, "tangential_force" in forces
    normal = forces["normal_force" if rubs else "force"].values
    peaks = _peaks_on_curve(forces, times, normal)
    along = (times, forces["tangential_force"].values) if rubs else None
    return Forces(*_with_peaks(times, normal, peaks), peaks, forces["force"], tangential=along)


def _with_peaks(
    times: Values, force: Values, peaks: tuple[Values, Values]
) -> tuple[Values, Values]:
    """Return a force over time with its peaks among the samples."""
    times, force = np.append(times, peaks[0]), np.append(force, peaks[1])
    order = np.argsort(times, kind="stable")
    return times[order], force[order]


def _within(samples: Values, times: Values, forces: Values) -> tuple[Values, Values]:
    """Return the peaks within a run: one at its begin or end may be part of a larger contact."""
    inside = (times > samples[0]) & (times < samples[-1])
    return times[inside], forces[inside]


def _peaks_on_curve(run: xr.Dataset, time: Values, force: Values) -> tuple[Values, Values]:
    """Return times and forces of contact peaks, on the curve of the force over time.

    With contact damping the force peaks before the indentation, whose time is stored.
    """
    times, peaks = _within(run["t"].values, run["peak_time"].values, run["peak_force"].values)
    if "contact_damping" not in run.variables:
        return times, peaks
    free = np.flatnonzero(force == 0.0)
    first = np.append(-1, free)[np.searchsorted(time[free], times, side="right")] + 1
    last = np.append(free, time.size)[np.searchsorted(time[free], times, side="right")]
    places = [
        one + int(np.argmax(force[one:other])) if other > one else one
        for one, other in zip(first.tolist(), last.tolist(), strict=True)
    ]
    return time[np.minimum(places, time.size - 1).astype(int)], peaks


def shade_contacts(ax: Axes, run: xr.Dataset) -> None:
    """Shade the contacts of a run; where they are too close to tell apart, all in a paler shade."""
    if not {"entry_time", "exit_time"} <= set(run.variables):
        return
    first, last = (float(each) for each in run["t"].values[[0, -1]])
    entries = np.nan_to_num(run["entry_time"].values, nan=first)
    exits = np.nan_to_num(run["exit_time"].values, nan=last)
    shown = (exits >= first) & (entries <= last)
    entries, exits = np.clip(entries[shown], first, last), np.clip(exits[shown], first, last)
    if not entries.size:
        return
    order = np.argsort(entries)
    entries, exits = entries[order], np.maximum.accumulate(exits[order])
    narrow = (last - first) / DRAWN_APART
    apart = np.flatnonzero(entries[1:] - exits[:-1] > narrow)
    begins, ends = np.append(0, apart + 1), np.append(apart, entries.size - 1)
    several = ends > begins
    alone = exits - entries > narrow
    alone[begins[~several]] = True
    _shade(ax, entries[begins[several]], exits[ends[several]], IN_AND_OUT, palette.PALE_SHADE)
    _shade(ax, entries[alone], exits[alone], "in contact", palette.SHADE)


def _shade(ax: Axes, begins: Values, ends: Values, words: str, colour: str) -> None:
    """Shade intervals of time, each at least as wide as a thin line."""
    if begins.size:
        bars = list(zip(begins, ends - begins, strict=True))
        ax.broken_barh(bars, (0.0, 1.0), label=words, transform=ax.get_xaxis_transform(),
                       facecolor=colour, edgecolor=colour, linewidth=0.5, zorder=0.5)  # fmt: skip
