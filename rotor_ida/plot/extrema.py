"""Bifurcation diagrams: the extrema of the radius over the speed, laid over the exact curve."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    ORANGE,
    PURPLE,
    axes_or_new,
    check_dataset,
    one_value,
    own_legend,
    style,
)
from rotor_ida.plot.labels import LABELS, check_same_units, label_axis, parameter_text
from rotor_ida.plot.responses import plot_amplitude
from rotor_ida.schema import flags_of

FREE = "extremum, contact-free or unresolved"
LOOKS = {
    "constant": ("constant radius", BLUE),
    "maximum": ("local maximum of $|z|$", ORANGE),
    "minimum": ("local minimum of $|z|$", PURPLE),
}
FEW = 3000
NEEDED = ("omega", "zeta", "delta0", "response", "extremum_count", "extremum_radius",
          "extremum_kind")  # fmt: skip


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
        What `rotor_ida.bifurcation_diagram` returned, for one ``zeta``.
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
    >>> from rotor_ida import bifurcation_diagram
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> plot_extrema(found).get_ylabel()
    'radius $|z|$'
    """
    found = check_dataset("found", found, NEEDED)
    zeta = one_value("found", found, "zeta")
    if exact is not None:
        exact = check_dataset("exact", exact, ("omega", "amplitude"))
        check_same_units("exact", exact, found)
    delta0 = (
        one_value("found", found, "delta0")
        if exact is None
        else one_value("exact", exact, "delta0")
    )
    if delta0 not in found["delta0"].values:
        raise InputError(f"found must hold the delta0 of exact, {delta0!r}, it does not")
    counts = found["extremum_count"]
    places = xr.broadcast(found["omega"], found["delta0"], found["response"], counts)
    omega, clearance, response = (
        np.repeat(place.transpose(*counts.dims).values.ravel(), counts.values.ravel())
        for place in places[:3]
    )
    here = clearance == delta0
    kinds_of_response = flags_of(found["response"])
    # of an unresolved motion it is not known whether the extrema remain
    free = np.isin(response, [kinds_of_response[kind] for kind in ("contact_free", "unresolved")])
    radius, kinds = found["extremum_radius"].values, found["extremum_kind"].values
    flags = flags_of(found["extremum_kind"])
    with style():
        if exact is None:
            ax = axes_or_new(ax)
            ax.set_title(parameter_text({"zeta": zeta, "delta0": delta0}))
        else:
            ax = plot_amplitude(exact, fold_points=fold_points, ax=ax)
        size = 2.6 if here.sum() < FEW else 1.2
        kind_of = {kind: here & (kinds == flags[kind]) for kind in LOOKS}
        swinging = free & ~kind_of["constant"]
        shown = {
            words: (colour, kind_of[kind] & ~swinging) for kind, (words, colour) in LOOKS.items()
        }
        shown[FREE] = (GREY, here & swinging)
        for words, (colour, chosen) in shown.items():
            if not chosen.any():
                continue
            steady = words == LOOKS["constant"][0]
            face = "none" if steady else colour
            ax.plot(
                omega[chosen], radius[chosen], ls="", marker="o", ms=3.4 if steady else size,
                mec=colour if steady else "none", mfc=face, mew=0.7, rasterized=True,
                zorder=2.4 if words == FREE else 3.0,
            )  # fmt: skip
            ax.plot([], [], ls="", marker="o", ms=3.4, mec=colour, mfc=face, mew=0.7, label=words)
        ax.set_xlabel(LABELS["omega"])
        label_axis(ax.yaxis, "radius", found["extremum_radius"])
        own_legend(ax)
    return ax
