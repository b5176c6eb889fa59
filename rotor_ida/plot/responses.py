"""Response curves over the spin speed: the exact curve, and what simulations do beside it."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
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
from rotor_ida.plot.labels import check_same_units, label_axis, parameter_text, scale_of
from rotor_ida.plot.simulated import draw_simulated
from rotor_ida.schema import flags_of

Values = npt.NDArray[np.float64]

LINES = {
    "stable": (STABLE, "-", 1.3),
    "unstable": (UNSTABLE, (0, (4, 2)), 1.0),
    "neutral": (NEUTRAL, (0, (7, 1.6, 1.2, 1.6)), 1.0),
}
CURVE = ("omega", "zeta", "delta0", "amplitude", "phase_lag", "stability", "in_contact", "piece")


def plot_amplitude(
    exact: xr.Dataset,
    *,
    whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of every whirl over the spin speed.

    Parameters
    ----------
    exact : Dataset
        What `rotor_ida.closed_forms.response_curve` returned, for one ``zeta`` and one
        ``delta0``.
    whirls : Dataset, optional
        What `rotor_ida.synchronous_response` returned, for the same parameters: the whirls at
        its speeds are marked.
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
    >>> from rotor_ida import folds
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_amplitude(
    ...     response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0)),
    ...     fold_points=folds(zeta=0.07, delta0=0.5),
    ... )
    >>> ax.get_ylabel()
    'amplitude $A$'
    """
    return _plot("amplitude", exact, whirls, simulated, fold_points, ax)


def plot_phase(
    exact: xr.Dataset,
    *,
    whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    r"""Draw the phase by which every whirl lags the unbalance over the spin speed.

    Parameters
    ----------
    exact, whirls, simulated, fold_points, ax
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
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_phase(response_curve(zeta=0.5, delta0=0.0, limits=(0.5, 2.0)))
    >>> ax.get_ylabel()
    'phase lag $\\theta$'
    """
    return _plot("phase_lag", exact, whirls, simulated, fold_points, ax)


def _plot(
    quantity: str,
    exact: xr.Dataset,
    whirls: xr.Dataset | None,
    simulated: xr.Dataset | None,
    fold_points: xr.Dataset | None,
    ax: Axes | None,
) -> Axes:
    exact = check_dataset("exact", exact, CURVE)
    zeta, delta0 = (one_value("exact", exact, name) for name in ("zeta", "delta0"))
    fold_omega, fold_value = np.empty(0), np.empty(0)
    if fold_points is not None:
        check_dataset("fold_points", fold_points, ("zeta", "delta0", "fold_omega"))
        _check_same("fold_points", fold_points, exact)
        check_same_units("fold_points", fold_points, exact)
        fold_omega, fold_value = _folds(fold_points, quantity, zeta, exact)
    if whirls is not None:
        check_dataset("whirls", whirls, (*PARAMETERS, "amplitude", "phase_lag"))
        _check_same("whirls", whirls, exact)
        check_same_units("whirls", whirls, exact)
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
        draw_curve(ax, exact, over="omega", quantity=quantity)
        if whirls is not None:
            omega, height = xr.broadcast(whirls["omega"], whirls[quantity])
            ax.plot(omega.values.ravel(), height.values.ravel(), ls="", marker="o", ms=3.6,
                    color=BLUE, label="whirl at a given speed", zorder=3.1)  # fmt: skip
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


def draw_curve(ax: Axes, curve: xr.Dataset, *, over: str, quantity: str) -> None:
    """Draw the pieces of a response curve, a line for each stability."""
    x, y = curve[over].values.ravel(), curve[quantity].values.ravel()
    stability, piece = curve["stability"].values.ravel(), curve["piece"].values.ravel()
    flags = flags_of(curve["stability"])
    in_contact = curve["in_contact"].values.ravel() == 1
    turns = np.flatnonzero((np.diff(piece) != 0) | (np.diff(stability) != 0)) + 1
    lines: dict[int, list[Values]] = {}
    for points in np.split(np.arange(x.size), turns):
        first, last = int(points[0]), int(points[-1])
        if first > 0 and piece[first - 1] == piece[first]:
            first -= 1  # the fold, where the line before ends
        line = np.stack([x[first : last + 1], y[first : last + 1]])
        lines.setdefault(int(stability[last]), []).extend((line, np.full((2, 1), math.nan)))
    for word, (label, dashes, width) in LINES.items():
        flag = flags[word]
        if flag not in lines:
            continue
        # without damping contacting whirls are neutral too
        free = word == "neutral" and not in_contact[stability == flag].any()
        ax.plot(*np.concatenate(lines[flag], axis=1), ls=dashes, lw=width, color=INK,
                label=CONTACT_FREE if free else label, zorder=2.5)  # fmt: skip


def _finish(ax: Axes, quantity: str, exact: xr.Dataset, highest: float) -> None:
    label_axis(ax.xaxis, "omega", exact["omega"])
    label_axis(ax.yaxis, quantity, exact[quantity])
    ax.set_xlim(0.0, 1.02 * float(exact["omega"].max()))
    if quantity == "amplitude":
        # panels may share this axis with taller ones
        before = 0.0 if ax.get_autoscaley_on() else ax.get_ylim()[1]
        ax.set_ylim(0.0, max(before, 1.06 * highest))
    else:
        ax.set_ylim(0.0, 1.06 * math.pi)
        ax.set_yticks([0.0, 0.5 * math.pi, math.pi], ["0", r"$\pi/2$", r"$\pi$"])
