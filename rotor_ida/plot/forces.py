"""Contact forces: along a run, and how their peaks are distributed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.plot.appearance import BLUE, RED, axes_or_new, check_dataset, style
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.units import label_of, suited


def plot_forces(
    forces: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the contact force over time, with the peak of each contact.

    Parameters
    ----------
    forces : Dataset
        What `rotor_ida.contact_forces` returned.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If the dataset holds no contact forces.

    Examples
    --------
    >>> from rotor_ida import Rotor, contact_forces, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> plot_forces(contact_forces(run)).get_ylabel()
    'contact force $f$'
    """
    forces = check_dataset("forces", forces, ("t", "force", "peak_time", "peak_force"))
    forces = suited(forces, ["t", "force", "peak_force"], units=units, ax=ax)
    time, peaks = forces["t"].values, forces["peak_time"].values
    # where the run begins or ends inside a contact, its largest force there is no peak
    shown = (peaks > time[0]) & (peaks < time[-1])
    with style():
        ax = axes_or_new(ax)
        ax.plot(time, forces["force"].values, color=BLUE, lw=0.9, label="force")
        ax.plot(
            peaks[shown], forces["peak_force"].values[shown], ls="", marker="o", ms=2.8,
            mec=RED, mfc="white", mew=0.8, label="peak of a contact",
        )  # fmt: skip
        ax.set_xlim(float(time[0]), float(time[-1]))
        ax.set_ylim(bottom=0.0)
        ax.set_xlabel(label_of("t", forces["t"]))
        ax.set_ylabel(label_of("force", forces["force"]))
    return ax


def plot_force_peaks(
    forces: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw which share of the contacts stays below each peak force.

    Parameters
    ----------
    forces : Dataset
        What `rotor_ida.contact_forces` returned.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If the dataset holds no contact forces.

    Examples
    --------
    >>> from rotor_ida import Rotor, contact_forces, simulate
    >>> run = simulate(Rotor(omega=1.7, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), duration=20)
    >>> plot_force_peaks(contact_forces(run)).get_xlabel()
    'peak force $f$'
    """
    forces = check_dataset("forces", forces, ("peak_force", "peak_fraction"))
    forces = suited(forces, ["peak_force"], units=units, ax=ax)
    peaks, share = forces["peak_force"].values, forces["peak_fraction"].values
    whole = np.flatnonzero(np.isfinite(share))
    order = whole[np.argsort(peaks[whole], kind="stable")]
    peaks, share = peaks[order], share[order]
    with style():
        ax = axes_or_new(ax)
        if peaks.size > 1:
            ax.step(np.append(peaks[0], peaks), np.append(0.0, share), where="post", color=RED)
            ax.set_xlim(0.0, 1.08 * float(peaks[-1]))
        else:
            words = "fewer than two whole contacts"
            ax.text(0.5, 0.5, words, transform=ax.transAxes, ha="center", va="center")
        ax.set_ylim(0.0, 1.02)
        ax.set_xlabel(label_of("peak_force", forces["peak_force"]))
        ax.set_ylabel(LABELS["peak_fraction"])
    return ax
