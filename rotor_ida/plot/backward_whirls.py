"""Backward whirls of one disc, in its clearance."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    DARK_BROWN,
    DASHES,
    GREY,
    INK,
    circle,
    draw_ring,
    drawing,
    legend_below,
    say_in_middle,
)
from rotor_ida.plot.datasets import check_dataset, clearance_of
from rotor_ida.plot.labels import label_axis, number_text, title_of, unit_of
from rotor_ida.schema import words_of

BACKWARD = (*PARAMETERS, "amplitude", "whirl_speed", "kind", "stability", "birth_omega")
# Backward whirls: colour, line, words, and an arrow on each circle, at a separate angle [rad].
LOOKS = {
    "slipping": (GREY, DASHES, "slipping whirl", 0.8),
    "rolling": (DARK_BROWN, "-", "dry whip", 0.5),
}
# Circles that are smaller than the figure by this factor are drawn once more, enlarged.
MAGNIFIED = 20.0


def plot_backward_whirl(whirls: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the backward whirls that friction drives without unbalance, with the stator.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.backward_whirl`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, backward_whirl
    >>> rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    >>> ax = plot_backward_whirl(backward_whirl(rotor))
    >>> [text.get_text().partition(":")[0] for text in ax.get_legend().get_texts()]
    ['dry whip', 'clearance', 'slipping whirl']
    """
    whirls = check_dataset("whirls", whirls, BACKWARD)
    radii, clearance = whirls["amplitude"].values, clearance_of(whirls, "whirls")
    with drawing(ax, width=4.2, height=5.4) as ax:
        label_axis(ax.xaxis, "x", whirls["amplitude"])
        label_axis(ax.yaxis, "y", whirls["amplitude"])
        _draw_circles(ax, whirls, clearance, max(clearance, float(np.nan_to_num(radii).max())))
        if not np.isfinite(radii).any():
            say_in_middle(ax, _why_there_is_none(whirls))
        inner = max(clearance, float(np.nan_to_num(radii, nan=math.inf).min()))
        if ax.get_xlim()[1] > MAGNIFIED * inner > 0.0:
            inset = ax.inset_axes((0.3, 0.3, 0.4, 0.4))
            _draw_circles(inset, whirls, clearance, inner)
            inset.tick_params(labelsize=7.0)
            inset.locator_params(nbins=3)
            ax.indicate_inset_zoom(inset, edgecolor=INK)
        legend_below(ax, columns=1)
        ax.set_title(title_of("whirls", whirls))
    return ax


def _draw_circles(ax: Axes, whirls: xr.Dataset, clearance: float, largest: float) -> None:
    """Draw the clearance and the circles of the whirls as far as the largest radius."""
    length = unit_of(whirls["amplitude"])
    rate = unit_of(whirls["whirl_speed"]).replace("1/s", "rad/s")
    draw_ring(ax, clearance)
    for radius, speed, kind, stability in zip(
        whirls["amplitude"].values.tolist(), whirls["whirl_speed"].values.tolist(),
        words_of(whirls["kind"]), words_of(whirls["stability"]), strict=True,
    ):  # fmt: skip
        if math.isfinite(radius):
            colour, dashes, words, angle = LOOKS[kind]
            size = f"{number_text(radius, '.4g')}$ {length}".rstrip()
            turns = f"{number_text(speed, '.4g')}$ {rate}".rstrip()
            ax.plot(*circle(radius), color=colour, ls=dashes, lw=1.4,
                    label=rf"{words}: {stability}, $|z| = {size}, $\Omega = {turns}")  # fmt: skip
            if largest / MAGNIFIED < radius <= largest:
                _draw_backward_arrow(ax, radius, angle, colour)
    ax.set_aspect("equal")
    ax.set(xlim=(-1.1 * largest, 1.1 * largest), ylim=(-1.1 * largest, 1.1 * largest))


def _draw_backward_arrow(ax: Axes, radius: float, angle: float, colour: str) -> None:
    """Draw an arrow that shows clockwise motion."""
    tip, tail = (
        (radius * math.cos(each), radius * math.sin(each)) for each in (angle, angle + 0.02)
    )
    arrow = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 13.0}
    ax.annotate("", tip, tail, arrowprops=arrow)


def _why_there_is_none(whirls: xr.Dataset) -> str:
    """Return the reason why no backward whirl exists."""
    birth = float(whirls["birth_omega"])
    if math.isnan(birth):
        return "no dry whip at any speed"
    return rf"no dry whip below $\omega = {number_text(birth, '.4g')}$"
