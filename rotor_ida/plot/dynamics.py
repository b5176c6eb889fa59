"""Plots of Poincaré sections, Lyapunov exponents and bifurcation diagrams."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    INK,
    ORANGE,
    PURPLE,
    draw_marks,
    draw_ring,
    drawing,
    legend_below,
    own_legend,
    say_in_middle,
)
from rotor_ida.plot.datasets import (
    along_one,
    check_dataset,
    check_same_parameters,
    check_same_units,
    clearance_of,
    fixed_parameters,
    one_value,
    parameters_in,
)
from rotor_ida.plot.labels import (
    LABELS,
    in_lines,
    label_axis,
    label_parameter,
    label_varied,
    parameter_text,
    title_of,
)
from rotor_ida.plot.responses import plot_amplitude
from rotor_ida.results.rows import own_rows
from rotor_ida.results.si_units import scale_of
from rotor_ida.schema import flags_of
from rotor_ida.units import with_error

OF_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")
# Styles of the points of a section.
LEAST_SPAN = 0.2
FEW = 20
WORDS = {
    "revolution": "once a revolution",
    "entry": "at each entry",
    "exit": "at each exit",
    "peak": "at each largest radius",
}
# Styles of the exponents.
LINES = ((BLUE, "-"), (ORANGE, "--"), (PURPLE, "-."), (INK, ":"))
# Parts of a bifurcation diagram.
FREE = "extremum, contact-free or unresolved"
FREE_KINDS = ("contact_free", "touching", "unresolved")
EXTREMA = {
    "constant": ("constant radius", BLUE),
    "maximum": ("local maximum of $|z|$", ORANGE),
    "minimum": ("local minimum of $|z|$", PURPLE),
}
FEW_EXTREMA = 3000
# Top of the axes over the largest extremum.
HEADROOM = 1.06
WITH_EXTREMA = (*PARAMETERS, "response", "extremum_count", "extremum_radius", "extremum_kind")


def plot_section(section: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the points of a section.

    Parameters
    ----------
    section : Dataset
        Result of `rotor_ida.poincare_section`. Entries and exits all lie on the
        stator and are drawn as radial velocity over the angle from the unbalance. Other sections
        are drawn as displacements, with the stator.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, poincare_section
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_section(poincare_section(rotor, start=(0, 0, 0, 0), revolutions=9))
    >>> ax.get_title()
    '$\\omega = 1.7$,  $\\zeta = 0.07$,  $\\delta_0 = 0.5$\nonce a revolution'
    """
    needed = (*PARAMETERS, "rotating_x", "rotating_y", "rotating_vx", "rotating_vy")
    section = check_dataset("section", section, needed)
    at = str(section.attrs.get("section", ""))
    z = section["rotating_x"].values + 1j * section["rotating_y"].values
    with drawing(ax, width=4.0, height=4.0) as ax:
        if at in ("entry", "exit"):
            w = section["rotating_vx"].values + 1j * section["rotating_vy"].values
            across, up = _together(np.angle(z)), (w * z.conj()).real / np.abs(z)
            scales = (1.0, scale_of(section, "velocity"))
            ax.set_xlabel(LABELS["angle"])
            label_axis(ax.yaxis, "radial_velocity", section["rotating_vx"])
        else:
            across, up, scales = z.real, z.imag, (scale_of(section, "length"),) * 2
            label_axis(ax.xaxis, "rotating_x", section["rotating_x"])
            label_axis(ax.yaxis, "rotating_y", section["rotating_y"])
            draw_ring(ax, clearance_of(section, "section"))
            ax.set_aspect("equal", adjustable="datalim")
        ax.plot(across, up, ls="", marker="o", ms=_mark_size(z), mec="none", mfc=BLUE, zorder=3.0)
        _leave_room(ax, *scales)
        if not z.size:
            say_in_middle(ax, "no crossing")
        words = WORDS.get(at, "")
        if phase := float(section.attrs.get("phase", 0.0)):
            words = f"unbalance at {math.degrees(phase):.4g}°"
        title = f"{title_of('section', section)}\n{words}{_counted(z)}"
        ax.set_title(title.removesuffix("\n"))
    return ax


def plot_exponents(found: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    r"""Draw the convergence of the Lyapunov exponents over the averaging time, or their course.

    Of one motion the legend shows each exponent with the standard error of its last digits in
    brackets. Of several the exponents are drawn over the one parameter that varies, with errors.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.lyapunov_exponent`.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, lyapunov_exponent
    >>> found = lyapunov_exponent(Rotor(omega=1.7, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                           batches=4)
    >>> plot_exponents(found).get_legend_handles_labels()[1][0]
    '$\\lambda_1 = -0.07000$'
    """
    if isinstance(found, xr.Dataset) and "status" in found and "running_exponent" not in found:
        return _plot_exponents_over(check_dataset("found", found, ("exponent", *OF_EXPONENTS)), ax)
    found = check_dataset("found", found, ("t", "running_exponent", *OF_EXPONENTS))
    with drawing(ax) as ax:
        label_axis(ax.xaxis, "t", found["t"])
        label_axis(ax.yaxis, "running_exponent", found["running_exponent"])
        ax.axhline(0.0, color=GREY, lw=0.7, zorder=1.5)
        for number, (colour, dashes) in enumerate(LINES[: found.sizes["exponent"]]):
            part = found.isel(exponent=number)
            value, error = part["lyapunov_exponent"].item(), part["lyapunov_error"].item()
            words = f"$\\lambda_{number + 1} = {with_error(value, error, most=5)}$"
            ax.plot(part["t"], part["running_exponent"], color=colour, ls=dashes, lw=1.1,
                    label=words)  # fmt: skip
        ax.set_xlim(0.0, float(found["t"].values[-1]))
        low, high = float(found["lyapunov_exponent"].min()), float(found["lyapunov_exponent"].max())
        room = max(high - low, abs(high), abs(low)) or 1.0
        # the first means have not converged and may lie outside
        ax.set_ylim(low - 0.3 * room, high + 0.9 * room)
        ax.legend(
            ncols=2, loc="upper center", fontsize=8.0, handlelength=2.0, columnspacing=1.0,
            borderaxespad=0.2,
        )  # fmt: skip
    return ax


def _plot_exponents_over(found: xr.Dataset, ax: Axes | None) -> Axes:
    """Draw exponents over the parameter that varies."""
    part, over = along_one("found", found)
    with drawing(ax) as ax:
        label_axis(ax.yaxis, "running_exponent", found["lyapunov_exponent"])
        ax.axhline(0.0, color=GREY, lw=0.7, zorder=1.5)
        for number, (colour, dashes) in enumerate(LINES[: found.sizes["exponent"]]):
            own = part.isel(exponent=number)
            ax.errorbar(own[over].values, own["lyapunov_exponent"], own["lyapunov_error"],
                        color=colour, ls=dashes, lw=1.1, marker="o", ms=2.5, capsize=2.0,
                        label=f"$\\lambda_{number + 1}$")  # fmt: skip
        label_varied(ax.xaxis, over, found)
        legend_below(ax, columns=4)
    return ax


def plot_extrema(
    found: xr.Dataset,
    *,
    exact: xr.Dataset | None = None,
    fold_points: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the extrema of the radius over the varying parameter.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.bifurcation_diagram`, in which one parameter varies. It may contain
        several ``delta0`` beside `exact`.
    exact : Dataset, optional
        Result of `rotor_ida.closed_forms.response_curve`, for the same parameters and one
        ``delta0``. It is drawn under the extrema over the speed, which are shown for this
        clearance only.
    fold_points : Dataset, optional
        Result of `rotor_ida.folds` for the same parameters.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import bifurcation_diagram
    >>> found = bifurcation_diagram(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, starts=[(0, 0, 0, 0)])
    >>> plot_extrema(found).get_ylabel()
    'radius $|z|$'
    """
    found = check_dataset("found", found, WITH_EXTREMA)
    over, held = _varied(found, exact)
    extrema = _extrema_of(found, over, None if over == "delta0" else held["delta0"])
    with drawing(ax) as ax:
        if exact is None:
            ax.set_title(in_lines(parameter_text(held)))
        else:
            plot_amplitude(exact, fold_points=fold_points, ax=ax)
        size = 2.6 if extrema.here.sum() < FEW_EXTREMA else 1.2
        for words, (colour, chosen) in extrema.groups.items():
            if not chosen.any():
                continue
            steady = words == EXTREMA["constant"][0]
            face = "none" if steady else colour
            ax.plot(
                extrema.across[chosen], extrema.radius[chosen], ls="", marker="o",
                ms=3.4 if steady else size, mec=colour if steady else "none", mfc=face, mew=0.7,
                rasterized=True, zorder=2.4 if words == FREE else 3.0,
            )  # fmt: skip
            draw_marks(ax, [], [], "o", colour, size=3.4, face=face, edge=0.7, label=words)
        if exact is not None:  # whose amplitudes may be the smaller
            highest = extrema.radius[extrema.here].max(initial=0.0)
            ax.set_ylim(top=max(ax.get_ylim()[1], HEADROOM * highest))
        label_parameter(ax.xaxis, over, found)
        label_axis(ax.yaxis, "radius", found["extremum_radius"])
        own_legend(ax)
    return ax


class _Extrema(NamedTuple):
    """The extrema of a diagram as flat arrays: which are shown, and each kind."""

    across: Values
    radius: Values
    here: npt.NDArray[np.bool_]
    groups: dict[str, tuple[str, npt.NDArray[np.bool_]]]


def _extrema_of(found: xr.Dataset, over: str, delta0: float | None) -> _Extrema:
    """Return the extrema over a parameter, for one clearance or all."""
    found = own_rows(found)
    counts = found["extremum_count"]
    places = xr.broadcast(found[over], found["delta0"], found["response"], counts)
    across, clearance, response = (
        np.repeat(place.transpose(*counts.dims).values.ravel(), counts.values.ravel())
        for place in places[:3]
    )
    if over == "omega" and "extremum_speed" in found.variables:
        across = found["extremum_speed"].values / scale_of(found, "speed")
    here = np.full(clearance.shape, True) if delta0 is None else clearance == delta0
    # the extrema of an unresolved motion may not last
    free = _is_of(response, found["response"], FREE_KINDS)
    of_kind = {
        kind: here & _is_of(found["extremum_kind"].values, found["extremum_kind"], (kind,))
        for kind in EXTREMA
    }
    swinging = free & ~of_kind["constant"]
    groups = {
        words: (colour, of_kind[kind] & ~swinging) for kind, (words, colour) in EXTREMA.items()
    }
    groups[FREE] = (GREY, here & swinging)
    return _Extrema(across, found["extremum_radius"].values, here, groups)


def _is_of(
    numbers: Values, variable: xr.DataArray, kinds: tuple[str, ...]
) -> npt.NDArray[np.bool_]:
    """Return a mask of the flags that are of some kinds."""
    flags = flags_of(variable)
    return np.isin(numbers, [flags[kind] for kind in kinds if kind in flags])


def _varied(found: xr.Dataset, exact: xr.Dataset | None) -> tuple[str, dict[str, float]]:
    """Return the varying parameter of a diagram, and the values of the others."""
    names = parameters_in(found)
    if exact is None:
        varied = [name for name in names if found[name].size > 1]
        over = varied[0] if len(varied) == 1 else "omega"
        others = {name: one_value("found", found, name) for name in names if name != over}
        return over, others
    exact = check_dataset("exact", exact, ("omega", "amplitude"))
    check_same_units("exact", exact, found)
    others = {name: one_value("found", found, name) for name in names[1:] if name != "delta0"}
    check_same_parameters("found", others, fixed_parameters("exact", exact, ("zeta",)))
    delta0 = one_value("exact", exact, "delta0")
    if delta0 not in found["delta0"].values:
        raise InputError(f"found must contain the delta0 of exact, {delta0!r}, it does not")
    return "omega", others | {"delta0": delta0}


def _together(angle: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return angles cut at their widest gap, so that no cluster is split at pi."""
    order = np.sort(angle)
    gaps = np.diff(order)
    if not gaps.size or gaps.max() <= 2.0 * math.pi + order[0] - order[-1]:
        return angle
    least = order[gaps.argmax() + 1]
    cut = least + np.mod(angle - least, 2.0 * math.pi)
    return np.asarray(cut - 2.0 * math.pi * np.round(cut.mean() / (2.0 * math.pi)))


def _distinct(z: npt.NDArray[np.complex128]) -> int:
    """Return the number of distinguishable points."""
    return int(np.unique(np.round(z / (np.abs(z).max(initial=0.0) or 1.0), 3)).size)


def _counted(z: npt.NDArray[np.complex128]) -> str:
    """Return the count of crossings and of distinct points, if these are few."""
    distinct = _distinct(z)
    if not 0 < distinct <= FEW or z.size <= 2 * distinct:
        return ""
    return f": {z.size} crossings, {distinct} point{'s' if distinct > 1 else ''}"


def _mark_size(z: npt.NDArray[np.complex128]) -> float:
    """Return the marker size for a number of distinguishable points."""
    distinct = _distinct(z)
    return 4.5 if distinct <= FEW else 3.0 if distinct <= 200 else 1.6


def _leave_room(ax: Axes, across: float, up: float) -> None:
    """Widen limits that would magnify rounding errors to the whole panel."""
    for low, high, widen, order in (
        (*ax.get_xlim(), ax.set_xlim, across),
        (*ax.get_ylim(), ax.set_ylim, up),
    ):
        least = LEAST_SPAN * max(order, abs(low), abs(high))
        if high - low < least:
            middle = 0.5 * (low + high)
            widen(middle - 0.5 * least, middle + 0.5 * least)
