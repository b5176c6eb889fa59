"""Plots of exact whirls: jumps of the response curve, backbone and cusp, backward whirls."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    DARK_BROWN,
    DASHES,
    GREY,
    INK,
    RED,
    SHADE,
    circle,
    draw_marks,
    draw_ring,
    drawing,
    legend_below,
    look,
    own_legend,
    say_in_middle,
    style,
)
from rotor_ida.plot.datasets import check_dataset, clearance_of, hold_units, one_value
from rotor_ida.plot.labels import (
    LABELS,
    label_axis,
    label_parameter,
    number_text,
    parameter_text,
    title_of,
    unit_of,
)
from rotor_ida.plot.responses import CURVE, plot_amplitude, plot_phase
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import words_of

BACKWARD = (*PARAMETERS, "amplitude", "whirl_speed", "kind", "stability", "birth_omega")
# Backward whirls: colour, line, words, and an arrow on each circle, at a separate angle [rad].
LOOKS = {
    "slipping": (GREY, DASHES, "slipping whirl", 0.8),
    "rolling": (DARK_BROWN, "-", "dry whip", 0.5),
}
# Circles that are smaller than the figure by this factor are drawn once more, enlarged.
MAGNIFIED = 20.0


def plot_jumps(jumps: xr.Dataset, *, ax: Axes) -> Axes:
    """Draw an arrow from each fold to the whirl that the rotor jumps to.

    Parameters
    ----------
    jumps : Dataset
        Result of `rotor_ida.closed_forms.jumps`, for one ``zeta`` and one ``delta0``.
    ax : Axes
        Where the amplitude is drawn over the speed, in the same units.

    Returns
    -------
    Axes
        The same.

    Examples
    --------
    >>> from rotor_ida.closed_forms import jumps, response_curve
    >>> ax = plot_amplitude(response_curve(zeta=0.07, delta0=0.0, limits=(0.05, 3.0)))
    >>> plot_jumps(jumps(zeta=0.07, delta0=0.0), ax=ax) is ax
    True
    """
    names = ("fold_omega", "fold_amplitude", "landing_amplitude")
    jumps = check_dataset("jumps", jumps, names)
    hold_units(ax.yaxis, jumps["landing_amplitude"])
    columns = (jumps[name].values.ravel() for name in names)
    with style():
        for omega, begin, end in zip(*columns, strict=True):
            if np.isfinite(end):
                ax.annotate(
                    "", (omega, end), (omega, begin),
                    arrowprops={"arrowstyle": "-|>", "color": RED, "lw": 1.1, "shrinkA": 3.0,
                                "shrinkB": 0.0},
                )  # fmt: skip
        ax.plot([], [], color=RED, lw=1.1, marker=">", ms=4.0, markevery=[-1], label="jump")
        own_legend(ax)
    return ax


def plot_backbone(curve: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the backbone: the amplitude of a free whirl over its speed.

    Parameters
    ----------
    curve : Dataset
        Result of `rotor_ida.closed_forms.free_periods`, for one ``delta0``.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import free_periods
    >>> plot_backbone(free_periods(amplitude=[1.0, 2.0], delta0=0.5)).get_ylabel()
    'amplitude $A$'
    """
    curve = check_dataset("curve", curve, ("amplitude", "circular_period", "delta0"))
    one_value("curve", curve, "delta0")
    fresh = ax is None
    with drawing(ax) as ax:
        hold_units(ax.yaxis, curve["amplitude"])
        period = curve["circular_period"].squeeze().values / scale_of(curve, "time")
        omega = 2.0 * np.pi / period
        ax.plot(omega, curve["amplitude"].values, color="#6b7673", lw=0.9, ls=(0, (1, 2)),
                label="backbone", zorder=2.2)  # fmt: skip
        if fresh:
            label_parameter(ax.xaxis, "omega", curve)
            label_axis(ax.yaxis, "amplitude", curve["amplitude"])
        own_legend(ax)
    return ax


def plot_by_damping(exact: xr.Dataset, quantity: str, *, ax: Axes | None = None) -> Axes:
    r"""Draw amplitude or phase over the speed for several dampings, unstable whirls thin.

    Parameters
    ----------
    exact : Dataset
        Result of `rotor_ida.closed_forms.response_curve`, for one ``delta0``.
    quantity : {"amplitude", "phase_lag"}
        What to draw.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import response_curve
    >>> exact = response_curve(zeta=[1.0, 2.0], delta0=0.0, limits=(0.05, 3.0))
    >>> ax = plot_by_damping(exact, "amplitude")
    >>> [text.get_text() for text in ax.get_legend().get_texts()]
    ['$\\zeta = 1$', '$\\zeta = 2$']
    """
    exact = check_dataset("exact", exact, CURVE)
    draw = plot_amplitude if quantity == "amplitude" else plot_phase
    with drawing(ax) as ax:
        for number, zeta in enumerate(exact["zeta"].values):
            before = set(ax.lines)
            draw(exact.sel(zeta=zeta), ax=ax)
            colour, line = look(number)
            drawn = [each for each in ax.lines if each not in before]
            for each in drawn:
                unstable = each.get_label() == "unstable whirl"
                each.set(color=colour, linestyle=line, linewidth=0.6 if unstable else 1.3)
                each.set_label(parameter_text({"zeta": zeta}) if not unstable else "_unstable")
        ax.set_title(parameter_text({"delta0": one_value("exact", exact, "delta0")}))
        own_legend(ax)
    return ax


def plot_cusp(
    limit: xr.Dataset, *, highest: xr.Dataset | None = None, ax: Axes | None = None
) -> Axes:
    r"""Draw the cusp: damping above which the response curve has no fold, against clearance.

    Parameters
    ----------
    limit : Dataset
        Result of `rotor_ida.closed_forms.cusp` for many clearances.
    highest : Dataset, optional
        Its result without a clearance: the cusp of largest damping, which is marked.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import cusp
    >>> plot_cusp(cusp(delta0=[0.0, 1.0])).get_ylabel()
    'damping ratio $\\zeta$'
    """
    limit = check_dataset("limit", limit, ("delta0", "cusp_zeta"))
    with drawing(ax) as ax:
        delta0, zeta = limit["delta0"].values, limit["cusp_zeta"].values
        ax.fill_between(delta0, zeta, color=SHADE, lw=0.0)
        ax.plot(delta0, zeta, color=INK)
        if highest is not None:
            check_dataset("highest", highest, ("delta0", "cusp_zeta"))
            place = (highest["delta0"].item(), highest["cusp_zeta"].item())
            draw_marks(ax, *place, "D", INK, size=4.0, face="white")
            ax.annotate(f"$\\zeta = {place[1]:.6f}$ at $\\delta_0 = {place[0]:.4f}$", place,
                        xytext=(8, 3), textcoords="offset points")  # fmt: skip
        ax.text(0.3, 0.25, "jumps", transform=ax.transAxes, ha="center")
        ax.text(0.7, 0.75, "no jumps", transform=ax.transAxes, ha="center")
        ax.set_xlim(float(delta0.min()), float(delta0.max()))
        ax.set_ylim(0.0, 1.2 * float(zeta.max()))
        ax.set_xlabel(LABELS["delta0"])
        ax.set_ylabel(LABELS["zeta"])
    return ax


def plot_by_clearance(
    table: xr.Dataset, names: Mapping[str, str], *, label: str, ax: Axes | None = None
) -> Axes:
    """Draw some quantities over the clearance.

    Parameters
    ----------
    table : Dataset
        The quantities on ``delta0``. One with a further dimension, such as the speeds of
        the folds, is drawn as points, since not all exist at each clearance.
    names : mapping of str to str
        Label of each quantity in the legend.
    label : str
        Label of the vertical axis; the unit of the first quantity is added.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida.closed_forms import peaks
    >>> table = peaks(zeta=0.07, delta0=[0.0, 1.0])
    >>> plot_by_clearance(table, {"peak_amplitude": "peak"}, label="amplitude $A$").get_ylabel()
    'amplitude $A$'
    """
    table = check_dataset("table", table, ("delta0", *names))
    with drawing(ax) as ax:
        for number, (name, words) in enumerate(names.items()):
            colour, line = look(number)
            if "delta0" not in table[name].dims:
                raise InputError(f"table must contain {name} along delta0")
            delta0 = table["delta0"].values
            column = table[name].transpose("delta0", ...).values.reshape(delta0.size, -1)
            if column.shape[1] == 1:
                ax.plot(delta0, column, color=colour, ls=line, label=words, zorder=2.6)
                continue
            ax.plot(np.repeat(delta0, column.shape[1]), column.ravel(), ls="", marker=".",
                    ms=2.8, mew=0.0, color=colour, label=words)  # fmt: skip
        ax.set_xlabel(LABELS["delta0"])
        label_axis(ax.yaxis, "", table[next(iter(names))], words=label)
        if len(names) > 1:
            own_legend(ax)
    return ax


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
