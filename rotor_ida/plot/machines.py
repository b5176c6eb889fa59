"""A run of a real machine, in its own units."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rotor_ida.contact import contact_force
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import BLUE, INK, RED, check_dataset, one_value, style
from rotor_ida.plot.paths import path_of
from rotor_ida.plot.runs import NEEDED


def plot_machine(run: xr.Dataset) -> Figure:
    """Draw a run in SI units: orbit, distance from the bearing axis, and contact force.

    Parameters
    ----------
    run : Dataset
        What `rotor_ida.dimensional` made of a run.

    Returns
    -------
    Figure
        The figure: the orbit in micrometres, the radius over milliseconds with the ring, and
        the contact force in newtons with the peak of each contact.

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
    'contact force [N]'
    """
    run = check_dataset("run", run, (*NEEDED, "peak_time", "peak_force"))
    if "length_scale" not in run.attrs:
        raise InputError("run must be in SI units: rotor_ida.dimensional makes it so")
    length = float(run.attrs["length_scale"])
    delta0 = one_value("run", run, "delta0")
    with style():
        figure = Figure(figsize=(7.2, 3.9), layout="constrained")
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.25))
        orbit, history = figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1])
        force = figure.add_subplot(grid[1, 1], sharex=history)
        path = path_of(run)
        for chosen, colour, label in ((~path.in_contact, BLUE, "flight"),
                                      (path.in_contact, RED, "contact")):  # fmt: skip
            if chosen.any():
                x, y = path.stretches(chosen)
                orbit.plot(1e6 * x, 1e6 * y, color=colour, lw=0.8, label=label)
        turn = np.linspace(0.0, 2.0 * np.pi, 361)
        ring = 1e6 * delta0 * length
        orbit.plot(ring * np.cos(turn), ring * np.sin(turn), color=INK, lw=0.9, ls=(0, (4, 2)),
                   label="clearance")  # fmt: skip
        orbit.set_aspect("equal", adjustable="datalim")
        orbit.set(xlabel="displacement $X$ [µm]", ylabel="displacement $Y$ [µm]")
        orbit.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=3, handlelength=1.6,
                     columnspacing=1.0)  # fmt: skip
        milliseconds = 1e3 * path.time
        history.plot(milliseconds, 1e6 * path.radius, color=INK, lw=0.8)
        history.axhline(ring, color=INK, lw=0.8, ls=(0, (4, 2)))
        history.tick_params(labelbottom=False)
        history.set(ylabel="radius $|Z|$ [µm]", ylim=(0.0, None))
        newtons = float(run.attrs["force_scale"]) * contact_force(path.radius / length, delta0)
        force.plot(milliseconds, newtons, color=RED, lw=0.8)
        force.plot(1e3 * run["peak_time"].values, run["peak_force"].values, ls="", marker="o",
                   ms=2.4, color=INK, label="peak of a contact")  # fmt: skip
        force.set(xlabel="time $T$ [ms]", ylabel="contact force [N]", ylim=(0.0, None))
        force.set_xlim(0.0, float(milliseconds[-1]))
        force.legend(loc="upper right")
    return figure
