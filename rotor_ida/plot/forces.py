"""The contacts of a run and their forces."""

from __future__ import annotations

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
)
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.labels import LABELS, label_axis

PEAK = "peak of a contact"
CUT = "contact cut off by the run: at least"
IN_AND_OUT = "in and out of contact"
# Contacts are drawn apart if the gap between them is at least the time shown over this number:
# half a point of a panel.
DRAWN_APART = 400
# A peak of the force is on the curve of its samples from this part of it on.
ON_CURVE = 0.98


def plot_forces(forces: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the contact force over time, with the peak of each contact.

    With friction, draw the normal force and the force along the stator.

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
    >>> plot_forces(contact_forces(run)).get_ylabel()
    'contact force $f$'
    """
    forces = check_dataset("forces", forces, ("t", "force", "peak_time", "peak_force"))
    time, lowest = forces["t"].values, 0.0
    rubs = "tangential_force" in forces
    normal = forces["normal_force" if rubs else "force"].values
    with drawing(ax) as ax:
        label_axis(ax.xaxis, "t", forces["t"])
        label_axis(ax.yaxis, "force", forces["force"])
        ax.plot(time, normal, color=BLUE, lw=0.9, label="normal force" if rubs else "force")
        if rubs:
            along = forces["tangential_force"].values
            ax.plot(time, along, color=ORANGE, lw=0.9, label="force along the stator")
            lowest = min(lowest, 1.1 * float(along.min(initial=0.0)))
        peaks = peaks_on(forces, time, normal)
        draw_marks(ax, *peaks, "o", RED, size=2.8, face="white", edge=0.8, label=PEAK)
        ax.set_xlim(float(time[0]), float(time[-1]))
        ax.set_ylim(bottom=lowest)
        if rubs:
            legend_below(ax, columns=3)
    return ax


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


def peaks_of(dataset: xr.Dataset) -> tuple[Values, Values]:
    """Return times and forces of the peaks of contacts.

    The largest force is not a peak if a run begins or ends inside that contact.
    """
    times, first, last = dataset["peak_time"].values, *dataset["t"].values[[0, -1]]
    inside = (times > first) & (times < last)
    return times[inside], dataset["peak_force"].values[inside]


def peaks_on(dataset: xr.Dataset, time: Values, force: Values) -> tuple[Values, Values]:
    """Return times and forces of contact peaks, on the curve of the force over time.

    With contact damping the force peaks before the indentation, whose time is stored.
    """
    times, peaks = peaks_of(dataset)
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


def peaks_on_curve(part: xr.Dataset, time: Values, normal: Values) -> tuple[Values, Values]:
    """Return times and forces of the peaks of one contact of a rotor system, on its curve.

    With contact damping the force peaks before the indentation, whose time is stored.
    """
    times, peaks = peaks_of(part)
    for place in np.flatnonzero(np.interp(times, time, normal) < ON_CURVE * peaks):
        of_episode = int(np.flatnonzero(part["peak_time"].values == times[place])[0])
        begin, end = (part[f"{edge}_time"].values[of_episode] for edge in ("entry", "exit"))
        # a comparison with NaN is false: a contact at the begin or the end of the run has no edge
        inside = np.flatnonzero(~((time < begin) | (time > end)))
        if inside.size:
            times[place] = time[inside[np.argmax(normal[inside])]]
    return times, peaks
