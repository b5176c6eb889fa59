"""Several claimed solutions of one motion beside the simulated one, and how far they are off."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.plot.appearance import INK, axes_or_new, check_dataset, own_legend, style
from rotor_ida.plot.layout import LOOKS
from rotor_ida.plot.units import label_of, suited

NEEDED = ("t", "solution", "x", "y", "solution_x", "solution_y")


def plot_solutions(
    compared: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw x over time, simulated and as each solution has it.

    Parameters
    ----------
    compared : Dataset
        ``x`` and ``y`` on ``t``, and ``solution_x`` and ``solution_y`` on ``solution`` and
        ``time``; the coordinate ``solution`` names them.
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
        If the dataset is of another kind.

    Examples
    --------
    >>> line = ("t", [0.0, 1.0])
    >>> table = ("solution", "t"), [[0.0, 2.0]]
    >>> data = {"x": line, "y": line, "solution_x": table, "solution_y": table}
    >>> coordinates = {"t": [0.0, 1.0], "solution": ["as printed"]}
    >>> plot_solutions(xr.Dataset(data, coordinates)).get_xlabel()
    'time $t$'
    """
    compared = suited(check_dataset("compared", compared, NEEDED), NEEDED, units=units, ax=ax)
    with style():
        ax = axes_or_new(ax, width=7.0, height=2.6)
        ax.plot(compared["t"].values, compared["x"].values, color=INK, lw=1.4,
                label="simulated")  # fmt: skip
        for number, name in enumerate(compared["solution"].values.tolist(), start=1):
            colour, line = LOOKS[number]
            here = compared.sel(solution=name)
            ax.plot(here["t"].values, here["solution_x"].values, color=colour, ls=line,
                    lw=1.0, label=str(name))  # fmt: skip
        ax.set_xlim(float(compared["t"][0]), float(compared["t"][-1]))
        ax.set_xlabel(label_of("t", compared["t"]))
        ax.set_ylabel(label_of("x", compared["x"]))
        own_legend(ax)
    return ax


def plot_deviation(
    compared: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw how far each solution is from the simulated motion over time.

    Parameters
    ----------
    compared : Dataset
        As for `plot_solutions`.
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
        If the dataset is of another kind.

    Examples
    --------
    >>> line = ("t", [0.0, 1.0])
    >>> table = ("solution", "t"), [[0.0, 2.0]]
    >>> data = {"x": line, "y": line, "solution_x": table, "solution_y": table}
    >>> coordinates = {"t": [0.0, 1.0], "solution": ["as printed"]}
    >>> plot_deviation(xr.Dataset(data, coordinates)).get_xlabel()
    'time $t$'
    """
    compared = suited(check_dataset("compared", compared, NEEDED), NEEDED, units=units, ax=ax)
    across = compared["solution_x"] - compared["x"]
    up = compared["solution_y"] - compared["y"]
    error = (across**2 + up**2) ** 0.5
    with style():
        ax = axes_or_new(ax, width=7.0, height=2.6)
        for number, name in enumerate(compared["solution"].values.tolist(), start=1):
            colour, line = LOOKS[number]
            values = error.sel(solution=name).values
            shown = np.where(values > 0.0, values, np.nan)
            ax.semilogy(compared["t"].values, shown, color=colour, ls=line, lw=1.1,
                        label=str(name))  # fmt: skip
        ax.set_xlim(float(compared["t"][0]), float(compared["t"][-1]))
        ax.set_xlabel(label_of("t", compared["t"]))
        ax.set_ylabel(label_of("deviation", compared["x"]))
        own_legend(ax)
    return ax
