"""Sections through a motion, on axes that turn with the unbalance."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.parameters import PARAMETERS
from rotor_ida.plot.appearance import BLUE, INK, axes_or_new, check_dataset, one_value, style
from rotor_ida.plot.labels import LABELS, parameter_text
from rotor_ida.plot.units import label_of, scale_of, suited

NEEDED = (*PARAMETERS, "rotating_x", "rotating_y", "rotating_vx", "rotating_vy")
LEAST_SPAN = 0.2
FEW = 20
WORDS = {
    "revolution": "once a revolution",
    "entry": "at each entry",
    "exit": "at each exit",
    "peak": "at each largest radius",
}


def plot_section(
    section: xr.Dataset, *, units: Mapping[str, str] | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the points of a section.

    Parameters
    ----------
    section : Dataset
        What `rotor_ida.poincare_section` returned. Entries and exits, which all lie on the
        ring, are drawn as radial velocity over the angle from the unbalance, other sections as
        displacements, with the ring.
    units : mapping of str to str, optional
        Units for a dataset of `rotor_ida.dimensional`, such as ``{"length": "mm"}``; by default
        those with the SI prefix that suits.
    ax : Axes, optional
        Where to draw; by default on a new figure.

    Returns
    -------
    Axes
        Where it was drawn.

    Raises
    ------
    InputError
        If the dataset is no section.

    Examples
    --------
    >>> from rotor_ida import Rotor, poincare_section
    >>> rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    >>> ax = plot_section(poincare_section(rotor, start=(0, 0, 0, 0), revolutions=9))
    >>> ax.get_title()
    'once a revolution'
    """
    section = check_dataset("section", section, NEEDED)
    section = suited(section, NEEDED, units=units, ax=ax)
    at = str(section.attrs.get("section", ""))
    z = section["rotating_x"].values + 1j * section["rotating_y"].values
    w = section["rotating_vx"].values + 1j * section["rotating_vy"].values
    with style():
        ax = axes_or_new(ax, width=4.0, height=4.0)
        size = _mark_size(z)
        if at in ("entry", "exit"):
            across, up = _together(np.angle(z)), (w * z.conj()).real / np.abs(z)
            ax.set_xlabel(LABELS["angle"])
            ax.set_ylabel(label_of("radial_velocity", section["rotating_vx"]))
        else:
            ring = one_value("section", section, "delta0") * scale_of(section, "length")
            turn = np.linspace(0.0, 2.0 * math.pi, 361)
            if ring > 0.0:
                ax.plot(ring * np.cos(turn), ring * np.sin(turn), color=INK, lw=0.9,
                        ls=(0, (4, 2)), label="clearance", zorder=2.6)  # fmt: skip
            across, up = z.real, z.imag
            ax.set_xlabel(label_of("rotating_x", section["rotating_x"]))
            ax.set_ylabel(label_of("rotating_y", section["rotating_y"]))
            ax.set_aspect("equal", adjustable="datalim")
        ax.plot(across, up, ls="", marker="o", ms=size, mec="none", mfc=BLUE, zorder=3.0)
        _leave_room(ax)
        if not z.size:
            ax.text(0.5, 0.5, "no crossing", transform=ax.transAxes, ha="center", va="center")
        ax.set_title(WORDS.get(at, _title(section)) + _counted(z))
    return ax


def _together(angle: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return angles cut open at their widest gap, so that no cluster is torn apart at pi."""
    order = np.sort(angle)
    gaps = np.diff(order)
    if not gaps.size or gaps.max() <= 2.0 * math.pi + order[0] - order[-1]:
        return angle
    least = order[gaps.argmax() + 1]
    cut = least + np.mod(angle - least, 2.0 * math.pi)
    return np.asarray(cut - 2.0 * math.pi * np.round(cut.mean() / (2.0 * math.pi)))


def _distinct(z: npt.NDArray[np.complex128]) -> int:
    """Return the number of points that can be told apart."""
    return int(np.unique(np.round(z / (np.abs(z).max(initial=0.0) or 1.0), 3)).size)


def _counted(z: npt.NDArray[np.complex128]) -> str:
    """Return how many crossings fall on few points, where they do."""
    distinct = _distinct(z)
    if not 0 < distinct <= FEW or z.size <= 2 * distinct:
        return ""
    return f": {z.size} crossings, {distinct} point{'s' if distinct > 1 else ''}"


def _mark_size(z: npt.NDArray[np.complex128]) -> float:
    """Return a size of the marks by the number of points that can be told apart."""
    distinct = _distinct(z)
    return 4.5 if distinct <= FEW else 3.0 if distinct <= 200 else 1.6


def _leave_room(ax: Axes) -> None:
    """Widen limits that would blow rounding up to the size of the panel."""
    for low, high, widen in ((*ax.get_xlim(), ax.set_xlim), (*ax.get_ylim(), ax.set_ylim)):
        least = LEAST_SPAN * max(1.0, abs(low), abs(high))
        if high - low < least:
            middle = 0.5 * (low + high)
            widen(middle - 0.5 * least, middle + 0.5 * least)


def _title(section: xr.Dataset) -> str:
    return parameter_text(**{name: one_value("section", section, name) for name in PARAMETERS})
