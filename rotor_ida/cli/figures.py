"""The figure that suits a dataset."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import rotor_ida
from rotor_ida import plot
from rotor_ida.cli.describe import kind_of
from rotor_ida.cli.output import check_panels
from rotor_ida.errors import InputError
from rotor_ida.paper.scenario import speeds_of_curves
from rotor_ida.plot.labels import LABELS

# Number of speeds of the exact curve where it has no tip.
CURVE_POINTS = 600
# Up to so many speeds of a table of whirls are marked.
FEW_SPEEDS = 30


def draw(dataset: xr.Dataset, stem: Path, *, overwrite: bool) -> list[Path]:
    """Draw a dataset into files whose names begin with `stem`."""
    return plot.save_figure(figure_of(dataset), stem, overwrite=overwrite)


def figure_of(dataset: xr.Dataset) -> Figure:
    """Return the figure of a run, a basin, whirls, or a sweep with the exact curve behind it."""
    kind = kind_of(dataset)
    if kind == "run":
        return plot.plot_run(dataset)
    if kind == "basin":
        figure, (ax,) = plot.panels(1, 1, width=4.6, height=5.0)
        plot.plot_basin(dataset, ax)
        return figure
    if kind not in {"whirls", "sweep"}:
        raise InputError(f"figure must be of a run, of whirls or of a sweep or basin, got {kind!r}")
    pairs = [
        (float(zeta), float(delta0))
        for zeta in dataset["zeta"].values
        for delta0 in dataset["delta0"].values
    ]
    columns = math.ceil(math.sqrt(check_panels(len(pairs))))
    rows = math.ceil(len(pairs) / columns)
    figure, axes = plot.panels(rows, columns, width=2.4 + 2.4 * columns, height=1.6 + 2.0 * rows)
    for ax, (zeta, delta0) in zip(axes, pairs, strict=False):
        part = dataset.sel(zeta=[zeta], delta0=[delta0])
        plot.plot_amplitude(
            _curve_behind(part, zeta, delta0),
            simulated=part if kind == "sweep" else None,
            fold_points=_folds(zeta, delta0),
            ax=ax,
        )
        if kind == "whirls" and part.sizes["omega"] <= FEW_SPEEDS:
            _mark_whirls(part, ax)
    shown = axes[: len(pairs)]
    for ax in axes[len(pairs) :]:
        ax.remove()
    plot.shared_legend(figure, shown)
    with plot.style():
        for ax in shown[max(0, len(pairs) - columns) :]:
            ax.tick_params(labelbottom=True)
            ax.set_xlabel(LABELS["omega"])
    return figure


def _mark_whirls(whirls: xr.Dataset, ax: Axes) -> None:
    """Mark the whirls at the speeds asked for, where they are few."""
    table = whirls["amplitude"].squeeze(["zeta", "delta0"])
    speeds = np.broadcast_to(table["omega"].values[:, None], table.shape)
    with plot.style():
        ax.plot(speeds.ravel(), table.values.ravel(), ls="", marker="o", ms=3.6, color="#3f90da",
                label="whirl at a given speed", zorder=3.1)  # fmt: skip


def _folds(zeta: float, delta0: float) -> xr.Dataset | None:
    """Return the folds, or nothing where the parameters are too extreme for them."""
    try:
        return rotor_ida.folds(zeta=zeta, delta0=delta0)
    except InputError:
        return None


def _curve_behind(sweep: xr.Dataset, zeta: float, delta0: float) -> xr.Dataset:
    speeds = sweep["omega"].values
    lowest, highest = float(speeds.min()), float(speeds.max())
    if speeds.size < 3:
        lowest, highest = 0.5 * lowest, 1.2 * highest
    if zeta > 0.0 and 0.0 < lowest < highest:
        dense = speeds_of_curves(zeta=zeta, delta0=delta0, lowest=lowest, highest=highest)
    else:
        dense = np.linspace(lowest, highest, CURVE_POINTS)
    omega = np.union1d(speeds, dense)
    return rotor_ida.synchronous_response(omega=omega, zeta=zeta, delta0=delta0)
