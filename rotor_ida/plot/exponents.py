"""Lyapunov exponents: how their means come to rest."""

from __future__ import annotations

from collections.abc import Mapping

import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    axes_or_new,
    check_dataset,
    style,
)
from rotor_ida.plot.labels import with_error
from rotor_ida.plot.units import label_of, suited

LINES = ((BLUE, "-"), (ORANGE, "--"), (PURPLE, "-."), (INK, ":"))
NEEDED = ("t", "running_exponent", "lyapunov_exponent", "lyapunov_error")


def plot_exponents(
    found: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the mean rates of stretching over the time of the mean, with the exponents.

    Parameters
    ----------
    found : Dataset
        What `rotor_ida.lyapunov_exponent` returned.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn. The legend has each exponent with the standard error of its last
        digits in brackets.

    Raises
    ------
    InputError
        If the dataset holds no exponents.

    Examples
    --------
    >>> from rotor_ida import Rotor, lyapunov_exponent
    >>> found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                           batches=4)
    >>> plot_exponents(found).get_legend_handles_labels()[1][0]
    '$\\lambda_1 = -0.07000$'
    """
    found = check_dataset("found", found, NEEDED)
    found = suited(found, ["t"], units=units, ax=ax)
    with style():
        ax = axes_or_new(ax)
        ax.axhline(0.0, color=GREY, lw=0.7, zorder=1.5)
        for number, (colour, dashes) in enumerate(LINES):
            part = found.isel(exponent=number)
            value, error = part["lyapunov_exponent"].item(), part["lyapunov_error"].item()
            words = f"$\\lambda_{number + 1} = {with_error(value, error)}$"
            ax.plot(part["t"], part["running_exponent"], color=colour, ls=dashes, lw=1.1,
                    label=words)  # fmt: skip
        ax.set_xlim(0.0, float(found["t"].values[-1]))
        ax.set_xlabel(label_of("t", found["t"]))
        ax.set_ylabel(label_of("running_exponent", found["running_exponent"]))
        low, high = float(found["lyapunov_exponent"].min()), float(found["lyapunov_exponent"].max())
        room = max(high - low, abs(high), abs(low)) or 1.0
        # the first, still unsettled means may lie outside
        ax.set_ylim(low - 0.3 * room, high + 0.9 * room)
        ax.legend(
            ncols=2, loc="upper center", fontsize=8.0, handlelength=2.0, columnspacing=1.0,
            borderaxespad=0.2,
        )  # fmt: skip
    return ax
