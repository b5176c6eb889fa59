"""Which part of random starts reaches each kind of response, over the speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.plot.appearance import (
    KIND_SHADES,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.labels import KIND_WORDS, LABELS, parameter_text
from rotor_ida.schema import RESPONSE


def plot_basin_fractions(dataset: xr.Dataset, ax: Axes | None = None) -> Axes:
    """Draw the shares of starts by kind of response over the speed, one upon the other.

    Parameters
    ----------
    dataset : Dataset
        What `rotor_ida.basin_fractions` returned, joined along ``omega``, for one ``zeta`` and one
        ``delta0``.
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
    >>> found = xr.Dataset(
    ...     {"response_fraction": (("omega", "response"), [[1.0, 0.0], [0.25, 0.75]])},
    ...     {"omega": [1.0, 2.0], "response": [2, 3], "zeta": 0.07, "delta0": 0.5})
    >>> plot_basin_fractions(found).get_ylabel()
    'share of starts'
    """
    check_dataset("dataset", dataset, ("omega", "zeta", "delta0", "response", "response_fraction"))
    words = {number: kind for kind, number in RESPONSE.items()}
    table = dataset["response_fraction"].transpose("omega", "response")
    alone = ax is None
    with style():
        ax = axes_or_new(ax)
        base = np.zeros(table.sizes["omega"])
        for kind, (colour, *_) in KIND_SHADES.items():
            columns = [words[number] == kind for number in table["response"].values.tolist()]
            top = base + table.values[:, columns].sum(axis=1)
            if (top > base).any():
                ax.fill_between(
                    table["omega"].values, base, top, color=colour, lw=0.0,
                    label=KIND_WORDS[kind],
                )  # fmt: skip
            base = top
        ax.set_xlim(float(table["omega"].min()), float(table["omega"].max()))
        ax.set_ylim(0.0, 1.0)
        ax.set_xlabel(LABELS["omega"])
        ax.set_ylabel("share of starts")
        parameters = {name: one_value("dataset", dataset, name) for name in ("zeta", "delta0")}
        ax.set_title(parameter_text(**parameters))
        if alone:
            own_legend(ax)
    return ax
