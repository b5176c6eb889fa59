"""Bifurcation diagrams: the extrema of the radius over the speed, laid over the exact curve."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    LABELS,
    ORANGE,
    PURPLE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    parameter_text,
    style,
)
from rotor_ida.plot.responses import plot_amplitude
from rotor_ida.schema import flags_of

LOOKS = {
    "constant": ("constant radius", BLUE, "o", 3.4),
    "maximum": ("local maximum of $|z|$", ORANGE, ".", 1.6),
    "minimum": ("local minimum of $|z|$", PURPLE, ".", 1.6),
}
NEEDED = ("omega", "zeta", "delta0", "extremum_count", "extremum_radius", "extremum_kind")


def plot_extrema(
    found: xr.Dataset,
    *,
    exact: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the extrema of the radius over the speed.

    Parameters
    ----------
    found : Dataset
        What `rotor_ida.bifurcation` returned, for one ``zeta``.
    exact : Dataset, optional
        What `rotor_ida.synchronous_response` returned, for the same ``zeta`` and one
        ``delta0``: drawn under the extrema, and only those of this clearance are shown.
    fold_points : Dataset, optional
        What `rotor_ida.folds` returned for the same parameters.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If a dataset is of another kind or holds several dampings or clearances.

    Examples
    --------
    >>> from rotor_ida import bifurcation
    >>> found = bifurcation(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> plot_extrema(found).get_ylabel()
    'radius $|z|$'
    """
    found = check_dataset("found", found, NEEDED)
    one_value("found", found, "zeta")
    delta0 = (
        one_value("found", found, "delta0")
        if exact is None
        else one_value("exact", exact, "delta0")
    )
    if delta0 not in found["delta0"].values:
        raise InputError(f"found must hold the delta0 of exact, {delta0!r}, it does not")
    counts = found["extremum_count"]
    places = xr.broadcast(found["omega"], found["delta0"], counts)
    omega, clearance = (
        np.repeat(place.transpose(*counts.dims).values.ravel(), counts.values.ravel())
        for place in places[:2]
    )
    radius, kinds = found["extremum_radius"].values, found["extremum_kind"].values
    flags = flags_of(found["extremum_kind"])
    with style():
        if exact is None:
            ax = axes_or_new(ax)
            ax.set_title(parameter_text(zeta=one_value("found", found, "zeta"), delta0=delta0))
        else:
            ax = plot_amplitude(exact, fold_points=fold_points, ax=ax)
        for kind, (words, colour, marker, size) in LOOKS.items():
            chosen = (kinds == flags[kind]) & (clearance == delta0)
            if chosen.any():
                ax.plot(
                    omega[chosen], radius[chosen], ls="", marker=marker, ms=size,
                    mec=colour if kind == "constant" else "none",
                    mfc="none" if kind == "constant" else colour, mew=0.7, label=words,
                    rasterized=True, zorder=3.0,
                )  # fmt: skip
        ax.set_xlabel(LABELS["omega"])
        ax.set_ylabel(LABELS["radius"])
        own_legend(ax)
    return ax
