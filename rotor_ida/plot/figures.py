"""Choose the figure for each kind of dataset; sweeps and whirls include the exact curve."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida import plot
from rotor_ida.checks import check_one_varies, check_panels
from rotor_ida.closed_forms import folds, hopf_points, response_curve, synchronous_response
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS
from rotor_ida.plot.datasets import parameters_in, rotors_in
from rotor_ida.plot.labels import label_parameter
from rotor_ida.plot.run_up import has_many_turns
from rotor_ida.results.kinds import KINDS, kind_of, loaded, why_not
from rotor_ida.results.run import is_of_system
from rotor_ida.results.si_units import dimensionless, in_units_of
from rotor_ida.signals.record import Record, record_of

# Largest number of speeds of a table of whirls that are marked.
FEW_SPEEDS = 30
# Number of clearances at which folds of the whirl are shown beside those of cycles.
CLEARANCES = 41
# Number of values of a parameter other than the speed at which whirls are shown.
ALONG = 401
# Folds and Hopf points are shown over these speeds, or to a margin past the last of them.
MARKED, USUAL, MARGIN = ("fold_omega", "hopf_omega"), (0.05, 3.0), 1.2
# Fewest revolutions of a Bode plot, samples between which speeds are compared, and the part by
# which the speed of a machine may change that does not run up.
FEW_TURNS, SPEEDS, WANDERS = 16, 17, 0.1
# Functions that draw a result of a rotor system at one of its nodes.
AT_NODE = {
    "system_section": "rotor_ida.plot:plot_section",
    "system_diagram": "rotor_ida.plot:plot_extrema",
    "system_stroboscopic_diagram": "rotor_ida.plot:plot_strobes",
}
# Margin beside the speeds of a bifurcation diagram, by their range.
BESIDE = 0.03
# Width and height of a single panel [inch].
ALONE = (5.6, 4.2)


def figure_of(dataset: xr.Dataset, node: str | None = None) -> Figure:
    """Return the figure of a dataset, at a node if one is given; a sweep with the exact curve."""
    kind = kind_of(dataset)
    drawn = KINDS[kind].drawn
    if not drawn:
        able = ", ".join(name for name, each in KINDS.items() if each.drawn)
        got = f"{kind!r}{why_not(dataset)}"
        raise InputError(f"figure must be of one of the kinds {able}, got {got}")
    made: Axes | Figure = (
        loaded(drawn)(dataset) if node is None else loaded(AT_NODE[kind])(dataset, node=node)
    )
    return made if isinstance(made, Figure) else cast(Figure, made.figure)


def figure_of_run(run: xr.Dataset) -> Figure:
    """Return the figure of a run: over the speed if that changes, in bands if it is long."""
    if has_many_turns(run):
        return plot.plot_run_up(run)
    return plot.system_figure(run) if is_of_system(run) else plot.plot_run(run)


def figure_of_whirls(dataset: xr.Dataset) -> Figure:
    """Return the figure of exact curves with the points of a dataset; a panel for each.

    A sweep along another parameter than the speed is drawn over that.
    """
    over = str(dataset.attrs.get("along", "omega"))
    parts = [part for _, part in rotors_in(dataset, but=(over,))]
    columns = math.ceil(math.sqrt(check_panels(len(parts))))
    rows = math.ceil(len(parts) / columns)
    figure, axes = plot.panels(rows, columns, width=2.4 + 2.4 * columns, height=1.6 + 2.0 * rows)
    for ax, part in zip(axes, parts, strict=False):
        if over != "omega":
            plot.plot_along(part, whirls=_whirls_along(part, over), ax=ax)
            continue
        few = "branch" in part.dims and part.sizes["omega"] <= FEW_SPEEDS
        curve, fold_points, hopf = _exact_beside(part)
        plot.plot_amplitude(
            curve,
            whirls=part if few else None,
            simulated=part if "response" in part else None,
            fold_points=fold_points,
            hopf_points=hopf,
            ax=ax,
        )
    shown = axes[: len(parts)]
    for ax in axes[len(parts) :]:
        ax.remove()
    plot.shared_legend(figure, shown)
    with plot.style():
        for ax in shown[max(0, len(parts) - columns) :]:
            ax.tick_params(labelbottom=True)
            label_parameter(ax.xaxis, over, dataset)
    return figure


def _whirls_along(part: xr.Dataset, over: str) -> xr.Dataset | None:
    """Return the exact whirls over a parameter; None where none lie beneath the responses."""
    given = {name: part[name].item() for name in parameters_in(part) if name != over}
    if over in {"load", "contact_exponent", "disc_radius"} or given.get("load", 0.0) > 0.0:
        return None
    ends = float(part[over].min()), float(part[over].max())
    asked: dict[str, Any] = {**given, over: np.linspace(*ends, ALONG)}
    return in_units_of(synchronous_response(**asked), part)


def _exact_beside(part: xr.Dataset) -> tuple[xr.Dataset | None, ...]:
    """Return the exact curve for a part, its folds and Hopf points; None under a load."""
    given = {name: part[name].item() for name in ALL_PARAMETERS[1:] if name in part.variables}
    if given.pop("load", 0.0) > 0.0:
        return None, None, None
    curve = response_curve(**given, limits=_limits_of(part))
    has_hopf_points = given.get("friction") or given.get("contact_damping")
    exact = [curve, folds(**given), hopf_points(**given) if has_hopf_points else None]
    return tuple(each if each is None else in_units_of(each, part) for each in exact)


def figure_of_diagram(dataset: xr.Dataset) -> Figure:
    """Return the figure of a bifurcation diagram over one parameter; over speeds on the curve."""
    varied = [name for name in parameters_in(dataset) if dataset[name].size > 1]
    check_one_varies(varied)
    exact, fold_points = None, None
    if varied in ([], ["omega"]):
        exact, fold_points, _ = _exact_beside(dataset)
    figure, (ax,) = plot.panels(1, 1, width=ALONE[0], height=ALONE[1])
    plot.plot_extrema(dataset, exact=exact, fold_points=fold_points, ax=ax)
    if varied == ["omega"]:
        lowest, highest = float(dataset["omega"].min()), float(dataset["omega"].max())
        ax.set_xlim(lowest - BESIDE * (highest - lowest), highest + BESIDE * (highest - lowest))
    plot.shared_legend(figure, [ax])
    return figure


def figure_of_strobes(dataset: xr.Dataset) -> Figure:
    """Return the figure of a stroboscopic diagram of one disc over one parameter."""
    check_one_varies([name for name in parameters_in(dataset) if dataset[name].size > 1])
    figure, (ax,) = plot.panels(1, 1, width=ALONE[0], height=ALONE[1])
    plot.plot_strobes(dataset, ax=ax)
    return figure


def figure_of_signals(dataset: xr.Dataset) -> Figure:
    """Return the figure of signals: a Bode plot while the speed changes, else the orbit."""
    of_run_up = plot_of_signals(dataset) == "bode"
    if of_run_up:
        return plot.plot_bode(dataset)
    return cast(Figure, plot.plot_orbit(dataset).figure)


def plot_of_signals(dataset: xr.Dataset) -> str:
    """Return which plot suits signals: ``bode`` while the speed changes, else ``orbit``."""
    return "bode" if _is_run_up(record_of(dataset)) else "orbit"


def _is_run_up(record: Record) -> bool:
    """Return whether the speed of signals changes over revolutions enough for a curve."""
    angles = record.angles
    if angles is None or angles[-1] - angles[0] < FEW_TURNS * 2.0 * math.pi:
        return False
    parts = np.linspace(0, angles.size - 1, min(SPEEDS, angles.size)).astype(int)
    speeds = np.diff(angles[parts]) / np.diff(record.times[parts])
    return bool(np.ptp(speeds) > WANDERS * speeds.max())


def figure_of_atlas(dataset: xr.Dataset) -> Figure:
    """Return the figure of an atlas: fractions over one parameter, or a map over two."""
    line = sum(dataset[name].size > 1 for name in parameters_in(dataset)) == 1
    return _with_legend(plot.plot_attractors if line else plot.plot_attractor_map, dataset)


def figure_of_fractions(dataset: xr.Dataset) -> Figure:
    """Return the figure of basin fractions: by attractor, or over the speed by kind."""
    if "omega" in dataset.variables and dataset["omega"].size > 1:
        return _with_legend(plot.plot_basin_fractions, dataset)
    return cast(Figure, plot.plot_attractor_fractions(dataset).figure)


def _with_legend(draw: Callable[..., Axes], dataset: xr.Dataset) -> Figure:
    """Return a figure with its legend under it."""
    figure, (ax,) = plot.panels(1, 1, width=ALONE[0], height=ALONE[1])
    draw(dataset, ax=ax)
    plot.shared_legend(figure, [ax])
    return figure


def figure_of_branch(dataset: xr.Dataset) -> Figure:
    """Return the figure of a branch of limit cycles."""
    figure, (ax,) = plot.panels(1, 1, width=ALONE[0], height=ALONE[1])
    plot.plot_branch(dataset, ax=ax)
    return figure


def figure_of_curve(dataset: xr.Dataset) -> Figure:
    """Return the figure of a bifurcation curve, beside the folds of the whirl."""
    figure, (ax,) = plot.panels(1, 1, width=ALONE[0], height=ALONE[1])
    plot.plot_curves(dataset, fold_points=_whirls_beside(dataset), ax=ax)
    return figure


def _whirls_beside(curve: xr.Dataset) -> xr.Dataset | None:
    """Return the folds of the whirl within the limits of a curve over speed and clearance."""
    limits = np.reshape(dimensionless(curve).attrs["limits"], (2, 2))
    of = dict(zip(str(curve.attrs["parameters"]).split(), limits.tolist(), strict=True))
    beyond = any(name in curve.variables for name in FRICTIONLESS)
    if beyond or set(of) != {"omega", "delta0"}:
        return None
    delta0, (low, high) = curve["delta0"].values, of["omega"]
    clearances = np.unique(np.linspace(delta0.min(), delta0.max(), CLEARANCES))
    whirls = folds(zeta=curve["zeta"].item(), delta0=clearances)
    within = (whirls["fold_omega"] >= low) & (whirls["fold_omega"] <= high)
    return whirls.where(within) if within.any() else None


def _limits_of(part: xr.Dataset) -> tuple[float, float]:
    """Return the range of speeds to draw, widened round one or two speeds or marked points."""
    if "omega" not in part.variables:
        marks = np.concatenate([part[name].values.ravel() for name in MARKED if name in part])
        return USUAL[0], max(USUAL[1], MARGIN * float(np.nan_to_num(marks).max(initial=0.0)))
    lowest, highest = float(part["omega"].min()), float(part["omega"].max())
    if part.sizes["omega"] < 3:
        lowest, highest = 0.5 * lowest, 1.2 * highest
    return lowest, highest or 1.0
