"""Plots of Poincaré sections and Lyapunov exponents."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.arrays import ComplexValues
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.plot.appearance import (
    BLUE,
    GREY,
    INK,
    LEAST_SPAN,
    ORANGE,
    PURPLE,
    draw_ring,
    drawing,
    legend_below,
    say_in_middle,
    widen,
)
from rotor_ida.plot.datasets import (
    along_one,
    at_node,
    check_dataset,
    is_centred,
    rings_about,
)
from rotor_ida.plot.labels import (
    label_axis,
    label_of,
    label_parameter,
    title_of,
)
from rotor_ida.results.si_units import scale_of
from rotor_ida.units import with_error

STATES = ("rotating_x", "rotating_y", "rotating_vx", "rotating_vy")
OF_SYSTEM = ("node", "contact_node", "contact_stator", "clearance", "centre_x", "centre_y")
OF_EXPONENTS = ("lyapunov_exponent", "lyapunov_error")
# Styles of the points of a section.
FEW = 20
WORDS = {
    "revolution": "once a revolution",
    "entry": "at each entry",
    "exit": "at each exit",
    "peak": "at each largest radius",
    "roll": "where it begins to roll",
    "slip": "where it begins to slip",
    "reverse": "where its sliding reverses",
}
# Styles of the exponents.
LINES = ((BLUE, "-"), (ORANGE, "--"), (PURPLE, "-."), (INK, ":"))


def plot_section(section: xr.Dataset, *, node: str | None = None, ax: Axes | None = None) -> Axes:
    r"""Draw the points of a section.

    Parameters
    ----------
    section : Dataset
        Result of `rotor_ida.poincare_section`. Entries and exits all lie on the
        stator and are drawn as radial velocity over the angle from the unbalance. Other sections
        are drawn as displacements, with the stator.
    node : str, optional
        Name of a node of a rotor system; by default that of the contact whose events are shown, or
        of the first contact. Entries and exits of another node, or in a stator that is not centred
        and at rest, are drawn as displacements too.
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
    is_system = isinstance(section, xr.Dataset) and "node" in section.variables
    needed = OF_SYSTEM if is_system else PARAMETERS
    section = at_node(check_dataset("section", section, (*needed, *STATES, "crossing_time")), node)
    at = str(section.attrs.get("section", ""))
    z = section["rotating_x"].values + 1j * section["rotating_y"].values
    with drawing(ax, width=4.0, height=4.0) as ax:
        if at in ("entry", "exit") and _is_on_ring(section):
            w = section["rotating_vx"].values + 1j * section["rotating_vy"].values
            across, up = _together(np.angle(z)), (w * z.conj()).real / np.abs(z)
            scales = (1.0, _order(section, "velocity", w))
            ax.set_xlabel(label_of("angle", section["rotating_x"].drop_attrs()))
            label_axis(ax.yaxis, "radial_velocity", section["rotating_vx"])
        else:
            across, up, scales = z.real, z.imag, (_order(section, "length", z),) * 2
            label_axis(ax.xaxis, "rotating_x", section["rotating_x"])
            label_axis(ax.yaxis, "rotating_y", section["rotating_y"])
            for clearance in rings_about("section", section):
                draw_ring(ax, clearance)
            ax.set_aspect("equal", adjustable="datalim")
        ax.plot(across, up, ls="", marker="o", ms=_mark_size(z), mec="none", mfc=BLUE, zorder=3.0)
        limits = zip((ax.get_xlim(), ax.get_ylim()), scales, strict=True)
        widen(ax, *(LEAST_SPAN * max(order, *map(abs, ends)) for ends, order in limits))
        if not z.size:
            say_in_middle(ax, "no crossing")
        words = WORDS.get(at, "")
        if phase := float(section.attrs.get("phase", 0.0)):
            words = f"unbalance at {math.degrees(phase):.4g}°"
        ax.set_title(f"{title_of('section', section)}\n{words}{_counted(z)}".removesuffix("\n"))
    return ax


def _order(section: xr.Dataset, kind: str, values: ComplexValues) -> float:
    """Return what the points of a section are measured by: of a rotor system their own size."""
    if "node" in section.variables:
        return float(np.abs(values).max(initial=0.0))
    return scale_of(section, kind)


def _is_on_ring(section: xr.Dataset) -> bool:
    """Return whether the crossings of a section at entries lie on a ring about the axis."""
    if "node" not in section.variables:
        return True
    number = int(section.attrs.get("contact", 0))
    contact = section.isel(contact=number)
    is_own = str(contact["contact_node"].values) == str(section["node"].values)
    return is_own and bool(is_centred(section)[number])


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
        ax.set_ylim(low - 0.3 * room, high + 0.3 * room)
        legend_below(ax, columns=2)
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
        label_parameter(ax.xaxis, over, found)
        legend_below(ax, columns=4)
    return ax


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
