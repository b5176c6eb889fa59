"""A run of a real machine, in its own units."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rotor_ida.equations.contact import contact_force
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import BLUE, INK, RED, check_dataset, one_value, style
from rotor_ida.plot.labels import parameter_text
from rotor_ida.plot.paths import path_of
from rotor_ida.plot.runs import NEEDED, SIZED_BY, clearance_of
from rotor_ida.plot.units import label_of, scale_of, suited


def plot_machine(run: xr.Dataset, *, units: Mapping[str, str] | None = None) -> Figure:
    """Draw a run in SI units: orbit, distance from the bearing axis, and contact force.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.dimensional` made of a run.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.

    Returns
    -------
    Figure
        The figure: the orbit, the radius over time with the ring, and the contact force with
        the peak of each contact.

    Raises
    ------
    InputError
        If the dataset is no run in SI units.

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
    run = suited(run, SIZED_BY, units=units)
    delta0, ring, path = one_value("run", run, "delta0"), clearance_of(run), path_of(run)
    with style():
        figure = Figure(figsize=(7.2, 3.9), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        orbit, history = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
        force = figure.add_subplot(grid[1, 1], sharex=history)
        for chosen, colour, label in ((~path.in_contact, BLUE, "flight"),
                                      (path.in_contact, RED, "contact")):  # fmt: skip
            if chosen.any():
                orbit.plot(*path.stretches(chosen), color=colour, lw=0.8, label=label)
        turn = np.linspace(0.0, 2.0 * np.pi, 361)
        orbit.plot(ring * np.cos(turn), ring * np.sin(turn), color=INK, lw=0.9, ls=(0, (4, 2)),
                   label="clearance")  # fmt: skip
        orbit.set_aspect("equal", adjustable="datalim")
        orbit.set(xlabel=label_of("x", run["x"]), ylabel=label_of("y", run["y"]))
        orbit.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=3, handlelength=1.6,
                     columnspacing=1.0)  # fmt: skip
        history.plot(path.time, path.radius, color=INK, lw=0.8)
        history.axhline(ring, color=INK, lw=0.8, ls=(0, (4, 2)))
        history.tick_params(labelbottom=False)
        history.set(ylabel=label_of("radius", run["x"]), ylim=(0.0, None))
        history.set_title(
            parameter_text(
                omega=one_value("run", run, "omega"),
                zeta=one_value("run", run, "zeta"),
                delta0=delta0,
            )
        )
        indentation = path.radius / scale_of(run, "length")
        force.plot(path.time, scale_of(run, "force") * contact_force(indentation, delta0),
                   color=RED, lw=0.8)  # fmt: skip
        peaks = run["peak_time"].values
        shown = (peaks > path.time[0]) & (peaks < path.time[-1])
        force.plot(peaks[shown], run["peak_force"].values[shown], ls="", marker="o", ms=2.4,
                   color=INK, label="peak of a contact")  # fmt: skip
        force.set(xlabel=label_of("t", run["t"]), ylim=(0.0, None),
                  ylabel=label_of("contact_force", run["peak_force"]))  # fmt: skip
        force.set_xlim(float(path.time[0]), float(path.time[-1]))
        force.legend(loc="upper right")
    return figure
