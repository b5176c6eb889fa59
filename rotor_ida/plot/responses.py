"""Response curves over spin speed or clearance, and what simulated rotors do beside them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.errors import InputError
from rotor_ida.model.table import FRICTIONLESS, OPTIONAL, PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    CONTACT_FREE,
    DARK_BROWN,
    FOLD,
    FROM_REST,
    FROM_START,
    GOING_DOWN,
    GOING_UP,
    GREEN,
    GREY,
    HOPF,
    INK,
    NEUTRAL,
    ORANGE,
    PURPLE,
    RED,
    STABLE,
    UNSTABLE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.labels import (
    KIND_WORDS,
    LABELS,
    check_same_units,
    label_axis,
    parameter_text,
    scale_of,
)
from rotor_ida.schema import flags_of

LINES = {
    "stable": (STABLE, "-", 1.3),
    "unstable": (UNSTABLE, (0, (4, 2)), 1.0),
    "neutral": (NEUTRAL, (0, (7, 1.6, 1.2, 1.6)), 1.0),
}
CURVE = ("omega", "zeta", "delta0", "amplitude", "phase_lag", "stability", "in_contact", "piece")
NO_CURVE = "no exact curve"
WHIRLS = (*PARAMETERS, "amplitude", "phase_lag")
SIMULATED = ("response", "amplitude", "phase_lag", "radius_min", "radius_max", "direction")


@dataclass(frozen=True, slots=True)
class _Look:
    """How one kind of response is drawn."""

    colour: str
    filled: bool
    is_range: bool
    dashes: object = "-"


DOTS, LONG = (0, (1, 1.6)), (0, (4, 1.4))
KINDS = {
    "synchronous": _Look(BLUE, True, False),
    "contact_free": _Look(BLUE, False, False),
    "bouncing": _Look(ORANGE, False, True),
    "full_contact": _Look(PURPLE, True, True),
    "rolling": _Look(DARK_BROWN, True, True, LONG),
    "touching": _Look(INK, False, False),
    "quasi_periodic": _Look(GREEN, False, True),
    "chaotic": _Look(RED, True, True, DOTS),
    "unresolved": _Look(GREY, False, True, DOTS),
}
DIRECTIONS = {0: ("o", 4.2), 1: ("^", 3.4), -1: ("v", 3.4)}


def plot_amplitude(
    exact: xr.Dataset | None,
    *,
    whirls: xr.Dataset | None = None,
    simulated: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    hopf_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of every whirl over the spin speed.

    Parameters
    ----------
    exact : Dataset or None
        What `rotor_ida.closed_forms.response_curve` returned, for one ``zeta``, one ``delta0``
        and one of each other parameter. None, for `simulated` alone, where no curve is known:
        under a load.
    whirls : Dataset, optional
        What `rotor_ida.synchronous_response` returned, for the same parameters: the whirls at
        its speeds are marked.
    simulated : Dataset, optional
        What `rotor_ida.sweep` returned, for the same parameters. Responses that are synchronous,
        contact-free or touching are marks at their amplitude, by direction of the sweep; all
        others are bars over the range of the distance from the bearing axis.
    fold_points : Dataset, optional
        What `rotor_ida.folds` returned, for the same parameters: the folds are marked.
    hopf_points : Dataset, optional
        What `rotor_ida.hopf_points` returned, for the same parameters: they are marked.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Raises
    ------
    InputError
        If a dataset is of another kind, holds several dampings, clearances or other parameters,
        or other ones than `exact`; if there is nothing to draw.

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
    return _plot("amplitude", exact, whirls, simulated, fold_points, ax, hopf_points)


def plot_phase(
    exact: xr.Dataset | None,
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

    Examples
    --------
    >>> from rotor_ida.closed_forms import response_curve
    >>> ax = plot_phase(response_curve(zeta=0.5, delta0=0.0, limits=(0.5, 2.0)))
    >>> ax.get_ylabel()
    'phase lag $\\theta$'
    """
    return _plot("phase_lag", exact, whirls, simulated, fold_points, ax)


def plot_over_clearance(
    exact: xr.Dataset, *, simulated: xr.Dataset | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the whirls at one speed over the clearance, and what a simulated rotor does there.

    Parameters
    ----------
    exact : Dataset
        What `rotor_ida.closed_forms.clearance_curve` returned, for one ``omega`` and one
        ``zeta``.
    simulated : Dataset, optional
        What `rotor_ida.sweep` returned at the same speed and damping. Responses on a whirl are
        marks, all others bars over the range of the distance from the bearing axis.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import clearance_curve
    >>> exact = clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 3.0))
    >>> plot_over_clearance(exact).get_xlabel()
    'clearance $\\delta_0$'
    """
    exact = check_dataset("exact", exact, CURVE)
    held = _held("exact", exact, ("omega", "zeta"))
    if simulated is not None:
        beyond = {name: value for name, value in held.items() if name in OPTIONAL}
        _check_same("simulated", _held("simulated", simulated, ()), beyond)
    with style():
        ax = axes_or_new(ax)
        draw_curve(ax, exact, over="delta0", quantity="amplitude")
        if simulated is not None:
            check_same_units("simulated", simulated, exact)
            _draw_over_clearance(ax, simulated)
        ax.set_xlabel(LABELS["delta0"])
        label_axis(ax.yaxis, "amplitude", exact["amplitude"])
        ax.set_ylim(bottom=0.0)
        ax.set_title(parameter_text(held))
        own_legend(ax)
    return ax


def _plot(
    quantity: str,
    exact: xr.Dataset | None,
    whirls: xr.Dataset | None,
    simulated: xr.Dataset | None,
    fold_points: xr.Dataset | None,
    ax: Axes | None,
    hopf_points: xr.Dataset | None = None,
) -> Axes:
    if exact is not None:
        shown = check_dataset("exact", exact, CURVE)
    elif simulated is not None:
        shown = check_dataset("simulated", simulated, (*PARAMETERS, *SIMULATED))
    else:
        raise InputError("exact must be a Dataset, or None beside simulated, got neither")
    held = _held("simulated" if exact is None else "exact", shown)
    beside = {"whirls": (whirls, WHIRLS), "simulated": (simulated, (*PARAMETERS, *SIMULATED)),
              "fold_points": (fold_points, ("zeta", "delta0", "fold_omega")),
              "hopf_points": (hopf_points, ("zeta", "delta0", "hopf_omega"))}  # fmt: skip
    for name, (dataset, needed) in beside.items():
        if dataset is not None:
            _check_beside(name, dataset, needed, shown, held)
    with style():
        ax = axes_or_new(ax)
        if exact is not None:
            draw_curve(ax, exact, over="omega", quantity=quantity)
        if whirls is not None:
            omega, height = xr.broadcast(whirls["omega"], whirls[quantity])
            ax.plot(omega.values.ravel(), height.values.ravel(), ls="", marker="o", ms=3.6,
                    color=BLUE, label="whirl at a given speed", zorder=3.1)  # fmt: skip
        if fold_points is not None:
            _draw_folds(ax, *_folds(fold_points, quantity, held["zeta"], shown))
        if hopf_points is not None:
            _draw_hopf_points(ax, hopf_points, shown)
        if simulated is not None:
            _draw_simulated(ax, simulated, quantity)
        heights = [shown["amplitude"], *([] if simulated is None else [simulated["radius_max"]])]
        _finish(ax, quantity, shown, max(float(each.max()) for each in heights))
        ax.set_title(parameter_text(held) if exact is not None else _without_curve(held))
        own_legend(ax)
    return ax


def _without_curve(held: Mapping[str, float]) -> str:
    """Return the title of a panel that says why it shows no curve."""
    last = {name: value for name, value in held.items() if name == "load"}
    before = {name: value for name, value in held.items() if name != "load"}
    reason = f"{parameter_text(last)}: {NO_CURVE} under a load" if last else NO_CURVE
    return f"{parameter_text(before)}\n{reason}"


def _held(
    name: str, dataset: xr.Dataset, of_all: Sequence[str] = ("zeta", "delta0")
) -> dict[str, float]:
    """Return the parameters but the one on the axis, of which there is one value each."""
    names = (*of_all, *(each for each in OPTIONAL if each in dataset.variables))
    return {each: one_value(name, dataset, each) for each in names}


def _check_same(name: str, here: Mapping[str, float], there: Mapping[str, float]) -> None:
    """Refuse other parameters than those of the exact curve."""
    papers = {**FRICTIONLESS, "friction": 0.0}
    of_this, of_exact = {**papers, **here}, {**papers, **there}
    for parameter, value in of_exact.items():
        # contact damping moves no fold
        skipped = (name, parameter) == ("fold_points", "contact_damping")
        if of_this[parameter] != value and not skipped:
            raise InputError(
                f"{name} must have the {parameter} of exact, {value!r}, got {of_this[parameter]!r}"
            )


def _check_beside(
    name: str, dataset: xr.Dataset, needed: Sequence[str], shown: xr.Dataset,
    held: Mapping[str, float],
) -> None:  # fmt: skip
    """Refuse what lacks variables or has other parameters or units than the exact curve."""
    check_dataset(name, dataset, needed)
    _check_same(name, _held(name, dataset), held)
    check_same_units(name, dataset, shown)


def _draw_folds(ax: Axes, omega: Values, height: Values) -> None:
    """Mark folds, where there are any."""
    if omega.size:
        ax.plot(
            omega, height, ls="", marker="D", ms=4.0, mfc="white", mec=INK, mew=1.0, label=FOLD,
            zorder=3.7,
        )  # fmt: skip


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


def _draw_hopf_points(ax: Axes, hopf_points: xr.Dataset, exact: xr.Dataset) -> None:
    """Mark the Hopf points within the range of the curve."""
    lowest, highest = float(exact["omega"].min()), float(exact["omega"].max())
    omega = hopf_points["hopf_omega"].values.ravel()
    here = (omega >= lowest) & (omega <= highest)
    if here.any():
        ax.plot(omega[here], hopf_points["hopf_amplitude"].values.ravel()[here], ls="",
                marker="o", ms=4.6, mfc="white", mec=INK, mew=1.0, label=HOPF,
                zorder=3.7)  # fmt: skip


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


def _draw_simulated(ax: Axes, simulated: xr.Dataset, quantity: str) -> None:
    """Draw the responses of a sweep: marks where a curve can show them, bars where it cannot."""
    flat = _columns(simulated, ("omega", *SIMULATED))
    flags = flags_of(simulated["response"])
    for kind, look in KINDS.items():
        of_kind = flat["response"] == flags.get(kind)
        if not of_kind.any():
            continue
        points = {name: values[of_kind] for name, values in flat.items()}
        if look.is_range and quantity == "amplitude":
            _draw_ranges(ax, look, points, f"{KIND_WORDS[kind]}: range of $|z|$")
            continue
        _draw_marks(ax, look, points, points[quantity], 1.0)
        ax.plot([], [], ls="", marker="s", ms=4.5, mec=look.colour, mew=0.9,
                mfc=_face(look), label=KIND_WORDS[kind])  # fmt: skip
    words = {0: _start_words(simulated), 1: GOING_UP, -1: GOING_DOWN}
    for direction in np.unique(flat["direction"]):
        marker, size = DIRECTIONS[int(direction)]
        ax.plot([], [], ls="", marker=marker, ms=size, mec=INK, mfc="none", mew=0.8,
                label=words[int(direction)])  # fmt: skip


def _columns(dataset: xr.Dataset, names: Sequence[str]) -> dict[str, Values]:
    """Return variables one value for each response, whatever dimensions each has."""
    same = xr.broadcast(*(dataset[name] for name in names))
    return {name: values.values.ravel() for name, values in zip(names, same, strict=True)}


def _draw_ranges(ax: Axes, look: _Look, points: dict[str, Values], words: str) -> None:
    ax.vlines(
        points["omega"], points["radius_min"], points["radius_max"], color=look.colour,
        lw=1.8 if look.filled else 0.9,
        ls=look.dashes, zorder=3.0, label=words,
    )  # fmt: skip
    for end in ("radius_min", "radius_max"):
        _draw_marks(ax, look, points, points[end], 0.75)


def _draw_marks(
    ax: Axes, look: _Look, points: dict[str, Values], heights: Values, scale: float
) -> None:
    """Mark points by the direction of their sweep, triangles over the larger circles."""
    for direction, (marker, size) in DIRECTIONS.items():
        here = points["direction"] == direction
        ax.plot(
            points["omega"][here], heights[here], ls="", marker=marker, ms=scale * size,
            mec=look.colour, mfc=_face(look), mew=0.7, zorder=3.2 if direction else 3.1,
        )  # fmt: skip


def _face(look: _Look) -> str:
    return look.colour if look.filled else "white"


def _start_words(simulated: xr.Dataset) -> str:
    starts = [f"start_{name}" for name in COMPONENTS]
    at_rest = all(name in simulated and not simulated[name].values.any() for name in starts)
    return FROM_REST if at_rest else FROM_START


def _draw_over_clearance(ax: Axes, simulated: xr.Dataset) -> None:
    """Draw responses on a whirl as marks, the others as bars, by kind."""
    names = ("delta0", "response", "amplitude", "radius_min", "radius_max")
    check_dataset("simulated", simulated, names)
    flat = _columns(simulated, names)
    flags = flags_of(simulated["response"])
    for kind, looks in KINDS.items():
        of_kind = flat["response"] == flags.get(kind)
        if not of_kind.any():
            continue
        delta0 = flat["delta0"][of_kind]
        if looks.is_range:
            low, high = flat["radius_min"][of_kind], flat["radius_max"][of_kind]
            width = 1.2 if looks.dashes == DOTS else 2.0
            ax.vlines(delta0, low, high, color=looks.colour, lw=width, ls=looks.dashes, zorder=3.0,
                      label=f"{KIND_WORDS[kind]}: range of $|z|$")  # fmt: skip
            continue
        ax.plot(delta0, flat["amplitude"][of_kind], ls="", marker="o", ms=4.2, mec=looks.colour,
                mfc=_face(looks), mew=0.9, label=KIND_WORDS[kind], zorder=3.1)  # fmt: skip


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
