"""Plots of grids of drops: ranges over what varies, and where the rotor whirls backwards."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.plot.appearance import look, new_figure, shared_legend, style
from rotor_ida.plot.labels import label_axis
from rotor_ida.schema import OF_DROP
from rotor_ida.texts import in_figure

WIDTH, HEIGHT = 7.2, 5.0
RANGES = {
    "largest_force": "largest force", "excursion": "largest radius over clearance",
    "total_heat": "heat of friction",
}  # fmt: skip


def plot_grid(drops: xr.Dataset) -> Figure:
    """Draw ranges and means over what varies most, and the share of drops that whirl backwards."""
    drops = drops.isel(drop=drops["status"].values == 0)
    # by number of values, the phase last unless it alone varies
    names = sorted(
        (name for name in OF_DROP if f"drop_{name}" in drops.variables),
        key=lambda name: (-_values(drops, name).size * (name != "phase"), name != "phase"),
    )
    name, other = names[0], names[1] if len(names) > 1 else "phase"
    with style():
        figure = new_figure(WIDTH, HEIGHT)
        axes = figure.subplots(2, 2).ravel().tolist()
        for ax, (figure_of, words) in zip(axes, RANGES.items(), strict=False):
            for number in range(drops.sizes["contact"]):
                _draw_range(ax, drops, name, figure_of, number)
            label_axis(ax.yaxis, figure_of, drops[figure_of], words=words)
            ax.set_xlabel(_label(drops, name))
        if other != "phase" and _values(drops, other).size > 1:
            _draw_map(figure, axes[3], drops, (name, other))
        else:
            _draw_shares(axes[3], drops, name)
        shared_legend(figure, axes, columns=5, outer=False)
    return figure


def _values(drops: xr.Dataset, name: str) -> np.ndarray:
    """Return the values on an axis of the grid, none if it does not vary."""
    found = np.unique(drops[f"drop_{name}"].values)
    return found if found.size > 1 else np.zeros(0)


def _label(drops: xr.Dataset, name: str) -> str:
    unit = str(drops[f"drop_{name}"].attrs.get("units"))
    return OF_DROP[name] + {"radian": " [rad]", "s m-1": " [s/m]"}.get(unit, "")


def _by_value(drops: xr.Dataset, name: str, values: np.ndarray) -> list[np.ndarray]:
    """Return the values of the drops at each value on an axis of the grid."""
    along = drops[f"drop_{name}"].values
    return [values[along == each] for each in np.unique(along)]


def _draw_range(ax: Axes, drops: xr.Dataset, name: str, figure_of: str, number: int) -> None:
    """Draw the range of a figure of a bearing, and its mean."""
    colour, dashes = look(1 + number)
    groups = _by_value(drops, name, drops[figure_of].values[:, number])
    known = [each[np.isfinite(each)] for each in groups]
    kept = [place for place, each in enumerate(known) if each.size]
    across = np.unique(drops[f"drop_{name}"].values)[kept]
    low, high, mean = (np.array([pick(known[place]) for place in kept])
                       for pick in (np.min, np.max, np.mean))  # fmt: skip
    node = in_figure(drops["contact_node"].values[number])
    ax.fill_between(across, low, high, color=colour, alpha=0.15, lw=0.0)
    ax.plot(across, mean, color=colour, ls=dashes, marker="o", ms=2.5, label=node)


def _draw_shares(ax: Axes, drops: xr.Dataset, name: str) -> None:
    """Draw the share of drops that whirl backwards in each bearing."""
    across = np.unique(drops[f"drop_{name}"].values)
    for number in range(drops.sizes["contact"]):
        colour, dashes = look(1 + number)
        groups = _by_value(drops, name, drops["whirl_sense"].values[:, number] < 0)
        ax.plot(across, [each.mean() for each in groups], color=colour, ls=dashes, marker="o",
                ms=2.5)  # fmt: skip
    ax.set(xlabel=_label(drops, name), ylabel="share that whirls backwards", ylim=(-0.02, 1.02))


def _draw_map(figure: Figure, ax: Axes, drops: xr.Dataset, names: tuple[str, str]) -> None:
    """Draw the share of drops that whirl backwards in any bearing, over two axes of the grid."""
    across, up = (np.unique(drops[f"drop_{name}"].values) for name in names)
    whirls = np.any(drops["whirl_sense"].values < 0, axis=1).astype(float)
    places = [drops[f"drop_{name}"].values for name in names]
    shares = [[whirls[(places[0] == x) & (places[1] == y)].mean() for x in across] for y in up]
    ax.grid(visible=False)
    drawn = ax.pcolormesh(np.arange(across.size), np.arange(up.size), shares, vmin=0.0, vmax=1.0,
                          cmap="Oranges")  # fmt: skip
    for axis, values in ((ax.xaxis, across), (ax.yaxis, up)):
        at = np.unique(np.linspace(0, values.size - 1, 6).astype(int))
        axis.set_ticks(at, [f"{values[each]:.3g}" for each in at])
    ax.set(xlabel=_label(drops, names[0]), ylabel=_label(drops, names[1]))
    figure.colorbar(drawn, ax=ax, label="share that whirls backwards")
