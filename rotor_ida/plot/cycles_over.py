"""Limit cycles at points of a parameter: their periods and radii over it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.plot.appearance import (
    INK,
    STABLE_CYCLE,
    UNSTABLE_CYCLE,
    draw_marks,
    look,
    new_figure,
    say_in_middle,
    shared_legend,
    style,
)
from rotor_ida.plot.datasets import along_one, check_dataset
from rotor_ida.plot.labels import label_axis, label_parameter
from rotor_ida.schema import words_of
from rotor_ida.texts import in_figure

Mask = npt.NDArray[np.bool_]
# Room beside the first and the last point, over the distance between them.
ROOM = 0.04
CYCLES = ("status", "period", "stability", "radius_min", "radius_max")


def cycles_figure(cycles: xr.Dataset) -> Figure:
    r"""Draw the period and the radii of limit cycles over the one parameter that varies.

    Radii lie between two lines, at each contact of a rotor system. A mark is filled where the cycle
    is stable. Where there is no cycle there is a gap.

    Parameters
    ----------
    cycles : Dataset
        Result of `rotor_ida.limit_cycle` in which one parameter varies.

    Raises
    ------
    InputError
        If the dataset is of another kind, or several parameters vary.

    Examples
    --------
    >>> from rotor_ida import Rotor, limit_cycle
    >>> cycles = limit_cycle(Rotor(omega=2.0, zeta=0.07, delta0=2.0), omega=[1.9, 2.0])
    >>> [ax.get_ylabel() for ax in cycles_figure(cycles).axes]
    ['period $T$', 'radius $|z|$']
    """
    cycles = check_dataset("cycles", cycles, CYCLES)
    part, over = along_one("cycles", cycles)
    part = part.sortby(over)
    is_stable = np.array(words_of(part["stability"])) == "stable"
    with style():
        figure = new_figure(5.0, 5.0)
        upper, lower = figure.subplots(2, 1, sharex=True)
        _draw(upper, part[over].values, part["period"].values, is_stable, INK)
        label_axis(upper.yaxis, "period", part["period"])
        is_system = "contact" in part["radius_max"].dims
        for number in range(part.sizes["contact"] if is_system else 1):
            own = part.isel(contact=number) if is_system else part
            colour, _ = look(number + 1)
            low, high = own["radius_min"].values, own["radius_max"].values
            lower.fill_between(part[over].values, low, high, color=colour, alpha=0.15, lw=0.0,
                               label=_words(own, number) if is_system else "_")  # fmt: skip
            for radii in (low, high):
                _draw(lower, part[over].values, radii, is_stable, colour)
        label_axis(lower.yaxis, "radius", part["radius_max"])
        label_parameter(lower.xaxis, over, cycles)
        first, last = part[over].values[[0, -1]].tolist()
        if first < last:  # points without a cycle too
            lower.set_xlim(first - ROOM * (last - first), last + ROOM * (last - first))
        if not np.isfinite(part["period"].values).any():
            say_in_middle(upper, "no limit cycle")
        else:
            shared_legend(figure, [upper, lower], outer=True)
    return figure


def _draw(ax: Axes, across: Values, up: Values, is_stable: Mask, colour: str) -> None:
    """Draw a number of the cycles, with marks that show their stability."""
    ax.plot(across, up, color=colour, lw=0.9)
    for here, face, label in ((is_stable, "", STABLE_CYCLE), (~is_stable, "white", UNSTABLE_CYCLE)):
        if np.isfinite(up[here]).any():
            draw_marks(ax, across[here], up[here], "o", colour, size=3.6, face=face, label=label)


def _words(own: xr.Dataset, number: int) -> str:
    """Return how a legend names a contact."""
    return f"contact {number} at {in_figure(str(own['contact_node'].values))}"
