"""Backward whirls that friction keeps up, as circles in the plane."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.model.table import PARAMETERS
from rotor_ida.plot.appearance import (
    DARK_BROWN,
    DASHES,
    GREY,
    axes_or_new,
    check_dataset,
    draw_ring,
    legend_below,
    lines_of,
    style,
)
from rotor_ida.plot.labels import label_axis, number_text
from rotor_ida.schema import flags_of

NEEDED = ("amplitude", "whirl_speed", "kind", "stability", "birth_omega")
LOOKS = {"slipping": (GREY, DASHES, "slipping whirl"), "rolling": (DARK_BROWN, "-", "dry whip")}
# An arrow on each circle, at an angle of its own [rad].
ARROWS = {"slipping": 0.8, "rolling": 0.5}


def plot_backward_whirl(whirls: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the backward whirls that friction keeps up without unbalance, with the ring.

    Parameters
    ----------
    whirls : Dataset
        What `rotor_ida.backward_whirl` returned.
    ax : Axes, optional
        Where to draw, and what is returned; by default the axes of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, backward_whirl
    >>> rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    >>> ax = plot_backward_whirl(backward_whirl(rotor))
    >>> [text.get_text().partition(":")[0] for text in ax.get_legend().get_texts()]
    ['dry whip', 'clearance', 'slipping whirl']
    """
    whirls = check_dataset("whirls", whirls, (*PARAMETERS, *NEEDED))
    kinds = {number: word for word, number in flags_of(whirls["kind"]).items()}
    stabilities = {number: word for word, number in flags_of(whirls["stability"]).items()}
    clearance = float(whirls["delta0"])
    largest = max(clearance, float(np.nan_to_num(whirls["amplitude"].values).max()))
    turn = np.linspace(0.0, 2.0 * math.pi, 361)
    with style():
        ax = axes_or_new(ax, width=4.2, height=5.0)
        label_axis(ax.xaxis, "x", whirls["amplitude"])
        label_axis(ax.yaxis, "y", whirls["amplitude"])
        draw_ring(ax, clearance)
        for number in range(whirls.sizes["whirl"]):
            whirl = whirls.isel(whirl=number)
            kind, radius = kinds[int(whirl["kind"])], float(whirl["amplitude"])
            if math.isnan(radius):
                continue
            colour, dashes, words = LOOKS[kind]
            stability = stabilities[int(whirl["stability"])]
            speed = number_text(float(whirl["whirl_speed"]), ".4g")
            size = number_text(radius, ".4g")
            ax.plot(radius * np.cos(turn), radius * np.sin(turn), color=colour, ls=dashes, lw=1.4,
                    label=rf"{words}: {stability}, $|z| = {size}$, $\Omega = {speed}$")  # fmt: skip
            tip, tail = ARROWS[kind], ARROWS[kind] + 0.02
            ax.annotate(
                "", (radius * math.cos(tip), radius * math.sin(tip)),
                (radius * math.cos(tail), radius * math.sin(tail)),
                arrowprops={"arrowstyle": "-|>", "color": colour, "mutation_scale": 13.0},
            )  # fmt: skip
        if not np.isfinite(whirls["amplitude"].values).any():
            ax.text(0.5, 0.5, _why(whirls), transform=ax.transAxes, ha="center", va="center")
        ax.set_aspect("equal")
        ax.set_xlim(-1.1 * largest, 1.1 * largest)
        ax.set_ylim(-1.1 * largest, 1.1 * largest)
        legend_below(ax, columns=1)
        ax.set_title(lines_of("whirls", whirls))
    return ax


def _why(whirls: xr.Dataset) -> str:
    """Return why there is no backward whirl."""
    birth = float(whirls["birth_omega"])
    if math.isnan(birth):
        return "no dry whip at any speed"
    return rf"no dry whip below $\omega = {number_text(birth, '.4g')}$"
