"""The figure that suits a dataset."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from rotor_ida import folds, plot
from rotor_ida.cli.describe import kind_of
from rotor_ida.cli.options import check_panels
from rotor_ida.closed_forms import response_curve
from rotor_ida.errors import InputError
from rotor_ida.parameters import ALL_PARAMETERS, DEFAULTS
from rotor_ida.plot.labels import LABELS

# Up to so many speeds of a table of whirls are marked.
FEW_SPEEDS = 30
# At so many clearances the folds of the whirl are shown beside those of cycles.
CLEARANCES = 41


def figure_of(dataset: xr.Dataset) -> Figure:
    """Return the figure of a dataset; of a sweep with the exact curve behind it."""
    kind = kind_of(dataset)
    if kind == "cycle":
        return plot.cycle_figure(dataset)
    if kind in {"branch", "curve"}:
        return _figure_of_cycles(kind, dataset)
    if kind == "run":
        return plot.plot_run(dataset)
    if kind == "basin":
        figure, (ax,) = plot.panels(1, 1, width=4.6, height=5.0)
        plot.plot_basin(dataset, ax)
        return figure
    if kind == "atlas":
        figure, (ax,) = plot.panels(1, 1, width=5.6, height=4.2)
        varying = [each for each in ALL_PARAMETERS if each in dataset.variables]
        line = sum(dataset[name].size > 1 for name in varying) == 1
        (plot.plot_attractors if line else plot.plot_attractor_map)(dataset, ax)
        plot.shared_legend(figure, [ax])
        return figure
    if kind not in {"whirls", "sweep"}:
        raise InputError(
            "figure must be of a run, of whirls, of a sweep, basin or atlas, or of limit cycles, "
            f"got {kind!r}"
        )
    parts = _parts(dataset)
    columns = math.ceil(math.sqrt(check_panels(len(parts))))
    rows = math.ceil(len(parts) / columns)
    figure, axes = plot.panels(rows, columns, width=2.4 + 2.4 * columns, height=1.6 + 2.0 * rows)
    for ax, part in zip(axes, parts, strict=False):
        few = kind == "whirls" and part.sizes["omega"] <= FEW_SPEEDS
        curve, fold_points = _exact_beside(part)
        plot.plot_amplitude(
            curve,
            whirls=part if few else None,
            simulated=part if kind == "sweep" else None,
            fold_points=fold_points,
            ax=ax,
        )
    shown = axes[: len(parts)]
    for ax in axes[len(parts) :]:
        ax.remove()
    plot.shared_legend(figure, shown)
    with plot.style():
        for ax in shown[max(0, len(parts) - columns) :]:
            ax.tick_params(labelbottom=True)
            ax.set_xlabel(LABELS["omega"])
    return figure


def _parts(dataset: xr.Dataset) -> list[xr.Dataset]:
    """Return the parts of a sweep or of whirls with one value of each parameter but the speed."""
    names = [name for name in ALL_PARAMETERS[1:] if name in dataset.dims]
    values = product(*(dataset[name].values.tolist() for name in names))
    return [
        dataset.sel({name: [value] for name, value in zip(names, each, strict=True)})
        for each in values
    ]


def _exact_beside(part: xr.Dataset) -> tuple[xr.Dataset | None, xr.Dataset | None]:
    """Return the exact curve for a part, and its folds; None under a load."""
    given = {name: part[name].item() for name in ALL_PARAMETERS[1:] if name in part.variables}
    if given.pop("load", 0.0) > 0.0:
        return None, None
    given.pop("disc_radius", None)  # of these whirls it moves none
    return response_curve(**given, limits=_limits_of(part)), folds(**given)


def _figure_of_cycles(kind: str, dataset: xr.Dataset) -> Figure:
    """Return the figure of a branch, or of a bifurcation curve beside the folds of the whirl."""
    figure, (ax,) = plot.panels(1, 1, width=5.6, height=4.2)
    if kind == "branch":
        plot.plot_branch(dataset, ax=ax)
        return figure
    plot.plot_curves(dataset, fold_points=_whirls_beside(dataset), ax=ax)
    return figure


def _whirls_beside(curve: xr.Dataset) -> xr.Dataset | None:
    """Return the folds of the whirl within the limits of a curve over speed and clearance."""
    limits = np.reshape(curve.attrs["limits"], (2, 2))
    of = dict(zip(str(curve.attrs["parameters"]).split(), limits.tolist(), strict=True))
    beyond = any(name in curve.variables for name in DEFAULTS)
    if beyond or set(of) != {"omega", "delta0"}:
        return None
    delta0, (low, high) = curve["delta0"].values, of["omega"]
    clearances = np.linspace(delta0.min(), delta0.max(), CLEARANCES)
    whirls = folds(zeta=curve["zeta"].item(), delta0=clearances)
    within = (whirls["fold_omega"] >= low) & (whirls["fold_omega"] <= high)
    return whirls.where(within) if within.any() else None


def _limits_of(part: xr.Dataset) -> tuple[float, float]:
    """Return the range of speeds to draw: a wider one round one or two."""
    lowest, highest = float(part["omega"].min()), float(part["omega"].max())
    if part.sizes["omega"] < 3:
        lowest, highest = 0.5 * lowest, 1.2 * highest
    return lowest, highest or 1.0
