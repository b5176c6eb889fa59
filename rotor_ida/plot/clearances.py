"""What a clearance does: whirls at one speed over the clearance, and quantities of the design."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    INK,
    STABLE,
    UNSTABLE,
    axes_or_new,
    check_dataset,
    look,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.branches import trace_branches
from rotor_ida.plot.labels import (
    KIND_WORDS,
    LABELS,
    check_same_units,
    label_axis,
    parameter_text,
)
from rotor_ida.plot.simulated import KINDS
from rotor_ida.schema import flags_of

LINES = {
    "stable": (STABLE, "-", 1.3),
    "unstable": (UNSTABLE, (0, (4, 2)), 1.0),
    "neutral": ("contact-free whirl", (0, (7, 1.6, 1.2, 1.6)), 1.0),
}


def plot_over_clearance(
    exact: xr.Dataset,
    *,
    simulated: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw the whirls at one speed over the clearance, and what a simulated rotor does there.

    Parameters
    ----------
    exact : Dataset
        What `rotor_ida.synchronous_response` returned, for one ``omega`` and one ``zeta`` and
        many clearances.
    simulated : Dataset, optional
        What `rotor_ida.sweep` returned at the same speed and damping. Responses on a whirl are
        marks, all others bars over the range of the distance from the bearing axis.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If a dataset is of another kind or holds several speeds or dampings.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> exact = synchronous_response(omega=1.2, zeta=0.07, delta0=[0.0, 0.1, 0.2])
    >>> plot_over_clearance(exact).get_xlabel()
    'clearance $\\delta_0$'
    """
    exact = check_dataset("exact", exact, ("omega", "zeta", "delta0", "amplitude", "stability"))
    omega, zeta = (one_value("exact", exact, name) for name in ("omega", "zeta"))
    table = exact.squeeze([name for name in ("omega", "zeta") if name in exact.dims])
    if "delta0" not in table.dims:
        raise InputError("exact must hold several clearances, got one")
    table = table.transpose("delta0", "branch", ...)
    flags = flags_of(exact["stability"])
    words = {flag: word for word, flag in flags.items()}
    nothing = np.empty(0)
    branches = trace_branches(
        table["delta0"].values, table["amplitude"].values, table["amplitude"].values,
        table["stability"].values, unstable=flags["unstable"], fold_omega=nothing,
        fold_value=nothing,
    )  # fmt: skip
    with style():
        ax = axes_or_new(ax)
        for branch in branches:
            label, line, width = LINES[words[branch.stability]]
            ax.plot(branch.omega, branch.value, ls=line, lw=width, color=INK, label=label)
        if simulated is not None:
            check_same_units("simulated", simulated, exact)
            _draw_simulated(ax, simulated)
        ax.set_xlabel(LABELS["delta0"])
        label_axis(ax.yaxis, "amplitude", exact["amplitude"])
        ax.set_ylim(bottom=0.0)
        ax.set_title(parameter_text({"omega": omega, "zeta": zeta}))
        own_legend(ax)
    return ax


def _draw_simulated(ax: Axes, simulated: xr.Dataset) -> None:
    """Draw responses on a whirl as marks, the others as bars, by kind."""
    names = ("delta0", "response", "amplitude", "radius_min", "radius_max")
    check_dataset("simulated", simulated, names)
    flat = {
        name: values.values.ravel()
        for name, values in zip(names, xr.broadcast(*(simulated[each] for each in names)),
                                strict=True)
    }  # fmt: skip
    flags = flags_of(simulated["response"])
    for kind, looks in KINDS.items():
        of_kind = flat["response"] == flags[kind]
        if not of_kind.any():
            continue
        delta0 = flat["delta0"][of_kind]
        if looks.is_range:
            low, high = flat["radius_min"][of_kind], flat["radius_max"][of_kind]
            ax.vlines(delta0, low, high, color=looks.colour, lw=1.2 if looks.dotted else 2.0,
                      ls=(0, (1, 1.6)) if looks.dotted else "-", zorder=3.0,
                      label=f"{KIND_WORDS[kind]}: range of $|z|$")  # fmt: skip
            continue
        ax.plot(delta0, flat["amplitude"][of_kind], ls="", marker="o", ms=4.2, mec=looks.colour,
                mfc=looks.colour if looks.filled else "white", mew=0.9, label=KIND_WORDS[kind],
                zorder=3.1)  # fmt: skip


def plot_by_clearance(
    table: xr.Dataset,
    names: Mapping[str, str],
    *,
    label: str,
    ax: Axes | None = None,
) -> Axes:
    """Draw some quantities over the clearance.

    Parameters
    ----------
    table : Dataset
        The quantities on ``delta0``. One that has a further dimension, as the speeds of the
        folds have, is drawn in points, since its values come and go.
    names : mapping of str to str
        What each quantity is called in the legend.
    label : str
        What the vertical axis is called; the unit of the first quantity is added.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If a quantity is missing.

    Examples
    --------
    >>> from rotor_ida.closed_forms import peaks
    >>> table = peaks(zeta=0.07, delta0=[0.0, 1.0])
    >>> plot_by_clearance(table, {"peak_amplitude": "peak"}, label="amplitude $A$").get_ylabel()
    'amplitude $A$'
    """
    table = check_dataset("table", table, ("delta0", *names))
    with style():
        ax = axes_or_new(ax)
        for number, (name, words) in enumerate(names.items()):
            colour, line = look(number)
            column = table[name].squeeze().transpose("delta0", ...)
            if column.ndim == 1:
                ax.plot(table["delta0"].values, column.values, color=colour, ls=line, label=words,
                        zorder=2.6)  # fmt: skip
                continue
            delta0 = np.repeat(table["delta0"].values, column.shape[1])
            ax.plot(delta0, column.values.ravel(), ls="", marker=".", ms=2.8, mew=0.0,
                    color=colour, label=words)  # fmt: skip
        ax.set_xlabel(LABELS["delta0"])
        label_axis(ax.yaxis, "", table[next(iter(names))], words=label)
        if len(names) > 1:
            own_legend(ax)
    return ax
