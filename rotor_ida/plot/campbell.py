"""Campbell diagrams: whirl speeds over the spin speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from rotor_ida.arrays import Values
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.plot.appearance import BLUE, GREY, INK, ORANGE, draw_marks, drawing, legend_below
from rotor_ida.plot.datasets import check_dataset, units_in
from rotor_ida.plot.labels import label_axis, label_parameter, speeds_in
from rotor_ida.schema import WHIRL_DIRECTION

SENSES = {"forward": (BLUE, "^"), "backward": (ORANGE, "v"), "none": (GREY, "o")}
# Eigenvalues above this many times the largest speed are cut off.
HIGHEST = 3.0
# Upper end of the axis over the largest value that is drawn.
ABOVE = 1.08
# More entries of a legend than this do not fit in lines of four.
MOST = 5


def plot_campbell(found: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw whirl speeds over the spin speed: forward, backward and neither.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.campbell`. Stiffer contacts are drawn fainter, critical speeds as
        rings.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, campbell
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5, shaft_stiffness=0.25).system()
    >>> plot_campbell(campbell(system, speed=[0.0, 0.5, 1.0])).get_ylabel()
    'size of the whirl speed'
    """
    needed = ("speed", "contact_stiffness", "whirl_speed", "whirl_sense")
    found = check_dataset("found", found, needed)
    springs = found["contact_stiffness"].values
    with drawing(ax) as ax:
        speeds = label_parameter(ax.xaxis, SPEED, found)
        shown = speeds_in(found["whirl_speed"])
        whirl = np.abs(shown.values)
        label_axis(ax.yaxis, "whirl_speed", shown, words="size of the whirl speed")
        highest = HIGHEST * float(np.abs(speeds).max(initial=0.0)) or np.inf
        drawn = whirl[whirl <= highest]
        senses = found["whirl_sense"].values
        for word, (colour, mark) in SENSES.items():
            for number, faint in enumerate(np.linspace(1.0, 0.35, springs.size)):
                chosen = (senses[number] == WHIRL_DIRECTION[word]) & np.isfinite(whirl[number])
                across = np.broadcast_to(speeds[:, np.newaxis], chosen.shape)
                ax.plot(across[chosen], whirl[number][chosen], ls="", marker=mark, ms=2.8,
                        color=colour, alpha=float(faint), mec="none")  # fmt: skip
        ax.plot(speeds, np.abs(speeds), color=INK, lw=0.9, ls="--", label="spin speed")
        handles = [ax.lines[-1], *_handles(senses, springs, units_in(found["contact_stiffness"]))]
        # archives had none at first
        critical = np.empty(0)
        if "critical_speed" in found:
            critical = speeds_in(found["critical_speed"]).values
        if critical.size:
            draw_marks(ax, critical, np.abs(critical), "o", INK, size=5.0, face="none",
                       label="critical speed", level=3.7)  # fmt: skip
            handles.append(ax.lines[-1])
        top = float(np.append(drawn, np.abs(critical)).max(initial=0.0))
        ax.set_ylim(0.0, ABOVE * top or 1.0)
        legend_below(ax, columns=4 if len(handles) < MOST else 3, handles=handles)
    return ax


def _handles(senses: Values, springs: Values, unit: str) -> list[Line2D]:
    """Return the entries of a legend: the senses of whirl, and the stiffnesses of contacts."""
    handles = [
        Line2D([], [], ls="", marker=mark, color=colour,
               label="along a line" if word == "none" else word)
        for word, (colour, mark) in SENSES.items() if (senses == WHIRL_DIRECTION[word]).any()
    ]  # fmt: skip
    if springs.size > 1:
        written = " N/m" if unit == "N m-1" else ""
        handles += [
            Line2D([], [], ls="", marker="s", color=INK, alpha=float(faint),
                   label=f"contacts {spring:.3g}{written}")
            for spring, faint in zip(springs, np.linspace(1.0, 0.35, springs.size), strict=True)
        ]  # fmt: skip
    return handles
