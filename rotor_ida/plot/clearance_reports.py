"""Plots of a report on close clearances: the scaled orbits over the speed, at each clearance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot.appearance import (
    DASHES,
    GREY,
    INK,
    SHADE,
    drawing,
    legend_below,
    look,
)
from rotor_ida.plot.datasets import at_contact, check_dataset
from rotor_ida.plot.labels import label_axis, label_parameter
from rotor_ida.schema import words_of
from rotor_ida.signals.nodes import Ring

NEEDED = (
    "speed", "major_axis", "scale_factor", "clearance", "contact_node", "clearance_verdict",
    "critical_speed",
)  # fmt: skip
ALLOWED, ORBIT = 0.75, "scaled orbit, peak to peak"
# Lowest and highest part of a diametral clearance that is shown, unless the orbits are larger.
LOWEST, HIGHEST, ROOM = 1e-3, 2.0, 1.5


def plot_clearance(report: xr.Dataset, *, contact: int | str = 0, ax: Axes | None = None) -> Axes:
    """Draw the scaled orbits at a close clearance over the spin speed, from peak to peak.

    Parameters
    ----------
    report : Dataset
        Result of `rotor_ida.clearance_report`.
    contact : int or str
        The contact, by its number or its node. Its diametral clearance is a line, and 75 per cent
        of it dashed; critical speeds are dotted, and the continuous speeds shaded.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Contact, Rotor, clearance_report
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=5.0).system()
    >>> report = clearance_report(system, speed=(2.0, 3.0),
    ...                           probes=["disc"], vibration_limit=1.0)
    >>> plot_clearance(report).get_title()
    'contact 0 at disc: passes'
    """
    report = check_dataset("report", report, NEEDED)
    own = at_contact(report, contact)
    diameter = 2.0 * own["clearance"].item()
    scaled = (own["major_axis"] * own["scale_factor"]).transpose("case", "speed").values
    with drawing(ax) as ax:
        speeds = label_parameter(ax.xaxis, SPEED, report)
        factor = float(speeds[-1] / report["speed"].values[-1])
        label_axis(ax.yaxis, "major_axis", report["major_axis"], words=ORBIT)
        running = factor * np.asarray(report.attrs["running_speeds"])
        ax.axvspan(running[0], running[1], color=SHADE, lw=0.0, zorder=0.5,
                   label="continuous speeds")  # fmt: skip
        ax.axhline(diameter, color=INK, lw=1.0, zorder=1.6, label="diametral clearance")
        ax.axhline(ALLOWED * diameter, color=INK, lw=0.9, ls=DASHES, zorder=1.6,
                   label="75 % of it")  # fmt: skip
        for number, each in enumerate(factor * report["critical_speed"].values):
            ax.axvline(each, color=GREY, lw=0.9, ls=":", zorder=1.4,
                       label="_" if number else "critical speed")  # fmt: skip
        for number, axes in enumerate(scaled):
            colour, dashes = look(number + 1)
            ax.plot(speeds, axes, color=colour, ls=dashes, label=f"case {number}", zorder=3.0)
        ax.set_yscale("log")
        ax.set_xlim(0.0, speeds[-1])
        top = max(HIGHEST * diameter, ROOM * float(scaled.max()))
        ax.set_ylim(max(LOWEST * diameter, 0.5 * float(scaled.min())), top)
        verdict = words_of(own["clearance_verdict"])[0]
        node = Ring(own["contact_node"].item(), "", []).title
        ax.set_title(f"contact {own['contact'].item()} at {node}: {verdict}")
        legend_below(ax, columns=3)
    return ax
