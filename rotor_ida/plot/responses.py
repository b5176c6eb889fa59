"""Response curves over the spin speed: the exact branches, and what simulations do beside them."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    CONTACT_FREE,
    FOLD,
    INK,
    NEUTRAL,
    STABLE,
    UNSTABLE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.branches import trace_branches
from rotor_ida.plot.labels import check_same_units, label_axis, parameter_text, scale_of
from rotor_ida.plot.simulated import draw_simulated
from rotor_ida.schema import flags_of

Values = npt.NDArray[np.float64]

LINES = {
    "stable": (STABLE, "-", 1.3),
    "unstable": (UNSTABLE, (0, (4, 2)), 1.0),
    "neutral": (NEUTRAL, (0, (7, 1.6, 1.2, 1.6)), 1.0),
}


def plot_amplitude(
    exact: xr.Dataset,
    *,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of every whirl over the spin speed.

    Parameters
    ----------
    exact : Dataset
        What `rotor_ida.synchronous_response` returned, for one ``zeta`` and one ``delta0`` and
        many speeds. Speeds from `rotor_ida.closed_forms.curve` among them make the tip smooth.
    simulated : Dataset, optional
        What `rotor_ida.sweep` returned, for the same parameters. Responses that are synchronous
        or contact-free are marks at their amplitude, by direction of the sweep; all others are
        bars over the range of the distance from the bearing axis.
    fold_points : Dataset, optional
        What `rotor_ida.folds` returned, for the same parameters: the folds are marked.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If a dataset is of another kind, holds several dampings or clearances, or other ones
        than `exact`.

    Examples
    --------
    >>> from rotor_ida import folds, synchronous_response
    >>> ax = plot_amplitude(
    ...     synchronous_response(omega=np.linspace(0.05, 3.0, 60), zeta=0.07, delta0=0.5),
    ...     fold_points=folds(zeta=0.07, delta0=0.5),
    ... )
    >>> ax.get_ylabel()
    'amplitude $A$'
    """
    return _plot("amplitude", exact, simulated, fold_points, ax)


def plot_phase(
    exact: xr.Dataset,
    *,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw the phase by which every whirl lags the unbalance over the spin speed.

    Parameters
    ----------
    exact, simulated, fold_points, ax
        As for `plot_amplitude`. Of a simulated response that is neither synchronous nor
        contact-free the phase of the part at the spin speed is marked.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        As for `plot_amplitude`.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> ax = plot_phase(synchronous_response(omega=[1.0, 1.1, 1.2], zeta=0.5, delta0=0.0))
    >>> ax.get_ylabel()
    'phase lag $\\theta$'
    """
    return _plot("phase_lag", exact, simulated, fold_points, ax)


def _plot(
    quantity: str,
    exact: xr.Dataset,
    simulated: xr.Dataset | None,
    fold_points: xr.Dataset | None,
    ax: Axes | None,
) -> Axes:
    exact = check_dataset(
        "exact", exact, (*PARAMETERS, "amplitude", "phase_lag", "stability", "in_contact")
    )
    zeta, delta0 = (one_value("exact", exact, name) for name in ("zeta", "delta0"))
    fold_omega, fold_value = np.empty(0), np.empty(0)
    if fold_points is not None:
        check_dataset("fold_points", fold_points, ("zeta", "delta0", "fold_omega"))
        _check_same("fold_points", fold_points, exact)
        check_same_units("fold_points", fold_points, exact)
        fold_omega, fold_value = _folds(fold_points, quantity, zeta, exact)
    if simulated is not None:
        needed = ("response", "amplitude", "phase_lag", "radius_min", "radius_max", "direction")
        check_dataset("simulated", simulated, (*PARAMETERS, *needed))
        _check_same("simulated", simulated, exact)
        check_same_units("simulated", simulated, exact)
    shown = (
        [exact["amplitude"]] if simulated is None else [exact["amplitude"], simulated["radius_max"]]
    )
    highest = max(float(values.max()) for values in shown)
    with style():
        ax = axes_or_new(ax)
        _draw_exact(ax, exact, quantity, fold_omega, fold_value)
        if fold_omega.size:
            ax.plot(
                fold_omega, fold_value, ls="", marker="D", ms=4.0, mfc="white", mec=INK, mew=1.0,
                label=FOLD, zorder=3.7,
            )  # fmt: skip
        if simulated is not None:
            draw_simulated(ax, simulated, quantity)
        _finish(ax, quantity, exact, highest)
        ax.set_title(parameter_text({"zeta": zeta, "delta0": delta0}))
        own_legend(ax)
    return ax


def _check_same(name: str, dataset: xr.Dataset, exact: xr.Dataset) -> None:
    for parameter in ("zeta", "delta0"):
        here, there = one_value(name, dataset, parameter), one_value("exact", exact, parameter)
        if here != there:
            raise InputError(f"{name} must have the {parameter} of exact, {there!r}, got {here!r}")


def _folds(
    fold_points: xr.Dataset, quantity: str, zeta: float, exact: xr.Dataset
) -> tuple[Values, Values]:
    """Return speed and height of the folds within the range of the curve."""
    lowest, highest = float(exact["omega"].min()), float(exact["omega"].max())
    omega = fold_points["fold_omega"].values.ravel()
    amplitude = fold_points["fold_amplitude"].values.ravel()
    present = (omega >= lowest) & (omega <= highest)
    omega, amplitude = omega[present], amplitude[present]
    if quantity == "amplitude":
        return omega, amplitude
    # A = omega sin(theta)/(2 zeta), and at every fold the lag is beyond a quarter turn
    whole = amplitude / scale_of(fold_points, "length")
    sine = np.minimum(2.0 * zeta * whole / omega, 1.0)
    return omega, math.pi - np.arcsin(sine)


def _draw_exact(
    ax: Axes, exact: xr.Dataset, quantity: str, fold_omega: Values, fold_value: Values
) -> None:
    table = exact.squeeze([name for name in ("zeta", "delta0") if name in exact.dims])
    if "omega" not in table.dims:
        table = table.expand_dims("omega")
    table = table.transpose("omega", "branch", ...).sortby("omega")
    flags = flags_of(exact["stability"])
    branches = trace_branches(
        table["omega"].values,
        table["amplitude"].values,
        table[quantity].values,
        table["stability"].values,
        unstable=flags["unstable"],
        fold_omega=fold_omega,
        fold_value=fold_value,
    )
    words = {flag: word for word, flag in flags.items()}
    neutral = exact["stability"] == flags["neutral"]
    for stability in sorted({branch.stability for branch in branches}):
        label, line, width = LINES[words[stability]]
        # without damping contacting whirls are neutral too
        if label == NEUTRAL and not (neutral & (exact["in_contact"] == 1)).any():
            label = CONTACT_FREE
        omega: list[float] = []
        value: list[float] = []
        for branch in branches:
            if branch.stability == stability:
                omega += [*branch.omega, math.nan]
                value += [*branch.value, math.nan]
        ax.plot(omega, value, ls=line, lw=width, color=INK, label=label, zorder=2.5)


def _finish(ax: Axes, quantity: str, exact: xr.Dataset, highest: float) -> None:
    omega = np.atleast_1d(exact["omega"].values)
    label_axis(ax.xaxis, "omega", exact["omega"])
    label_axis(ax.yaxis, quantity, exact[quantity])
    if omega.size > 1:
        ax.set_xlim(0.0, 1.02 * float(omega.max()))
    if quantity == "amplitude":
        # panels may share this axis with taller ones
        before = 0.0 if ax.get_autoscaley_on() else ax.get_ylim()[1]
        ax.set_ylim(0.0, max(before, 1.06 * highest))
    else:
        ax.set_ylim(0.0, 1.06 * math.pi)
        ax.set_yticks([0.0, 0.5 * math.pi, math.pi], ["0", r"$\pi/2$", r"$\pi$"])
