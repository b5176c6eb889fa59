"""Plots of contact forces: over time, and the distribution of their peaks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.plot.appearance import (
    BLUE,
    ORANGE,
    PALE_SHADE,
    RED,
    SHADE,
    draw_marks,
    drawing,
    legend_below,
    own_legend,
    say_in_middle,
    say_nothing,
)
from rotor_ida.plot.datasets import check_dataset, contact_in
from rotor_ida.plot.decimation import kept_in_columns
from rotor_ida.plot.labels import LABELS, label_axis
from rotor_ida.plot.motion import checked_run, in_contact, place_of_disc, title_of_contact
from rotor_ida.results.run import is_of_system
from rotor_ida.signals.path import Path, force_along

PEAK = "peak of a contact"
CUT = "contact cut off by the run: at least"
IN_AND_OUT = "in and out of contact"
# Contacts are drawn apart if the gap between them is at least the time shown over this number:
# half a point of a panel.
DRAWN_APART = 400


class Forces(NamedTuple):
    """The forces of a contact over time, and times and forces of its peaks."""

    time: Values
    normal: Values
    peaks: tuple[Values, Values]
    unit: xr.DataArray
    name: str = "contact_force"
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
            dataset, title = in_contact(run, number), title_of_contact(run, number)
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
    lowest = 0.0
    for words, values, colour in (
        ("normal force", (forces.time, forces.normal), BLUE),
        ("force along the stator", forces.tangential, ORANGE),
    ):
        if values is not None:
            kept = kept_in_columns(*values)
            lowest = min(lowest, 1.1 * float(values[1].min(initial=0.0)))
            ax.plot(*(each[kept] for each in values), color=colour, lw=0.9, label=words)
    if forces.peaks[0].size:
        draw_marks(ax, *forces.peaks, "o", RED, size=2.8, face="white", edge=0.8, label=PEAK)
    label_axis(ax.yaxis, forces.name, forces.unit)
    if not forces.normal.any():
        say_nothing(ax, "no contact")
        return
    ax.set_ylim(lowest, 1.12 * float(forces.normal.max()))


def forces_in(run: xr.Dataset, path: Path | None = None) -> Forces:
    """Return the forces in a run of one disc along its path, or at a contact of a system."""
    if path is not None and "zeta" in run.variables:
        peaks = _peaks_on_curve(run, path.time, force := force_along(run, path))
        name = "contact_force" if path.mode is None else "normal_force"
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


def plot_force_peaks(forces: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the cumulative distribution of peak contact forces.

    A contact in which the run begins or ends does not count: its peak may be larger than the
    largest force in the run, which is a mark on the curve.

    Parameters
    ----------
    forces : Dataset
        Result of `rotor_ida.contact_forces`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

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
    cut = peaks[~np.isfinite(share) & np.isfinite(peaks)]
    peaks, share = peaks[order], share[order]
    with drawing(ax) as ax:
        label_axis(ax.xaxis, "peak_force", forces["peak_force"])
        if peaks.size > 1:
            ax.step(np.append(peaks[0], peaks), np.append(0.0, share), where="post", color=RED)
            ax.set_xlim(0.0, 1.08 * max(float(peaks[-1]), *cut))
            if cut.size:
                heights = np.append(0.0, share)[np.searchsorted(peaks, cut, side="right")]
                draw_marks(ax, cut, heights, ">", RED, size=5.0, face="white", edge=0.9,
                           label=CUT, clip=False)  # fmt: skip
                own_legend(ax)
        else:
            say_in_middle(ax, "fewer than two whole contacts")
        ax.set_ylim(0.0, 1.02)
        ax.set_ylabel(LABELS["peak_fraction"])
    return ax


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
    _shade(ax, entries[begins[several]], exits[ends[several]], IN_AND_OUT, PALE_SHADE)
    _shade(ax, entries[alone], exits[alone], "in contact", SHADE)


def _shade(ax: Axes, begins: Values, ends: Values, words: str, colour: str) -> None:
    """Shade intervals of time, each at least as wide as a thin line."""
    if begins.size:
        bars = list(zip(begins, ends - begins, strict=True))
        ax.broken_barh(bars, (0.0, 1.0), label=words, transform=ax.get_xaxis_transform(),
                       facecolor=colour, edgecolor=colour, linewidth=0.5, zorder=0.5)  # fmt: skip
