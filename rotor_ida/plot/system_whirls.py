"""Plots of what a rotor system does at each speed: its synchronous whirls, and its eigenvalues."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count, check_panels, check_real
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    BLUE,
    FOLD,
    GRAZE,
    GREY,
    HOPF,
    INK,
    NEUTRAL,
    ORANGE,
    STABLE,
    UNSTABLE,
    draw_marks,
    drawing,
    legend_below,
    look,
    mixed_panels,
    shared_legend,
)
from rotor_ida.plot.datasets import check_dataset, units_in
from rotor_ida.plot.labels import label_axis
from rotor_ida.plot.systems import name_nodes
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.si_units import in_rpm
from rotor_ida.schema import SPECIAL, WHIRL_DIRECTION, flags_of
from rotor_ida.signals.nodes import Ring
from rotor_ida.texts import in_figure

WHIRLS = ("speed", "amplitude", "node_amplitude", "stability", "in_contact", "clearance")
# The whirls of a result of special speeds, by their names in one of whirls.
BRANCHES = {"branch_amplitude": "amplitude", "branch_stability": "stability"}
OF_CONTACTS = ("speed", "amplitude", "stability", "clearance", "contact_node")
MARKS = {
    "stable": (STABLE, BLUE, "o", 2.6, "full"),
    "unstable": (UNSTABLE, ORANGE, "x", 3.0, "full"),
    "neutral": (NEUTRAL, GREY, "o", 3.2, "none"),
}
SPECIALS = {"fold": (FOLD, "D", 4.0), "hopf": (HOPF, "o", 4.6), "graze": (GRAZE, "s", 4.0)}
SENSES = {"forward": (BLUE, "^"), "backward": (ORANGE, "v"), "none": (GREY, "o")}
MOST_NODES = 5
# Eigenvalues above this many times the largest speed are cut off.
HIGHEST = 3.0
# Upper end of the axis over the largest value that is drawn.
ABOVE = 1.08


def plot_system_whirls(
    whirls: xr.Dataset,
    *,
    contact: int = 0,
    special: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the amplitude of every synchronous whirl at a contact over the spin speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system with contacts.
    contact : int
        Number of the contact. Its clearance is a dashed line.
    special : Dataset, optional
        Result of `rotor_ida.special_speeds` for the same system: its folds, Hopf points and grazes
        are marked.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, speed=[0.5, 1.0, 1.5])
    >>> plot_system_whirls(whirls).get_title()
    'contact 0 at disc'
    """
    whirls = check_dataset("whirls", whirls, OF_CONTACTS)
    part = at_contact(whirls, contact)
    amplitude, stability = part["amplitude"].values, part["stability"].values
    flags = flags_of(whirls["stability"])
    with drawing(ax) as ax:
        speeds = label_speed(ax, whirls)
        label_axis(ax.yaxis, "amplitude", whirls["amplitude"])
        draw_clearance(ax, part)
        across = np.broadcast_to(speeds[:, np.newaxis], amplitude.shape)
        for word, (label, colour, mark, size, fill) in MARKS.items():
            chosen = stability == flags[word]
            if chosen.any():
                ax.plot(across[chosen], amplitude[chosen], ls="", marker=mark, ms=size,
                        color=colour, fillstyle=fill, label=label, zorder=3.0)  # fmt: skip
        if special is not None:
            _mark_special(ax, special, contact)
        ax.set_ylim(bottom=0.0)
        legend_below(ax, columns=4)
    return ax


def at_contact(dataset: xr.Dataset, contact: int) -> xr.Dataset:
    """Return the part of a dataset at a contact; refuse one that it has not."""
    count = dataset.sizes["contact"]
    if check_count("contact", contact, minimum=0) >= count:
        allowed = f"0 to {count - 1}" if count else "none: there is no contact"
        raise InputError(f"contact must be one of {allowed}, got {contact}")
    return dataset.isel(contact=contact).assign(contact=contact)


def draw_clearance(ax: Axes, part: xr.Dataset, *, over: str = "speed") -> None:
    """Draw the clearance of a contact over a parameter, and name the contact in the title."""
    look: dict[str, Any] = {
        "color": GREY,
        "lw": 0.9,
        "ls": "--",
        "zorder": 1.5,
        "label": "clearance",
    }
    if over == "clearance":
        ax.plot(part[over].values, clearance_of_contacts(part).values, **look)
    else:
        ax.axhline(clearance_of_contacts(part).item(), **look)
    number, node = part["contact"].item(), part["contact_node"].item()
    ax.set_title(f"contact {number} at {Ring(node, '', []).title}")


def _mark_special(ax: Axes, special: xr.Dataset, contact: int) -> None:
    """Mark folds, Hopf points, and the grazes of a contact."""
    needed = ("special_speed", "special_kind", "amplitude")
    special = check_dataset("special", special, needed)
    speeds, kinds = speeds_in(special["special_speed"]), special["special_kind"].values
    amplitude = special["amplitude"].isel(contact=contact).values
    for word, (label, mark, size) in SPECIALS.items():
        chosen = kinds == SPECIAL[word]
        if word == "graze" and "grazed_contact" in special:  # archives had none at first
            chosen &= special["grazed_contact"].values == contact
        if chosen.any():
            draw_marks(ax, speeds[chosen], amplitude[chosen], mark, INK, size=size, face="white",
                       label=label, level=3.7)  # fmt: skip


def plot_unbalance_response(whirls: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw the amplitude of the contact-free whirl at each node over the spin speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system. Of more than five nodes,
        those with the largest amplitudes are drawn.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, contacts=[], speed=[0.5, 1.0, 1.5])
    >>> plot_unbalance_response(whirls).lines[0].get_label()
    'disc'
    """
    whirls = check_dataset("whirls", whirls, (*WHIRLS, "node"))
    free = ~(whirls["in_contact"].values == 1).any(axis=2)
    amplitude = np.where(free[:, :, np.newaxis], whirls["node_amplitude"].values, np.nan)[:, 0]
    names = whirls["node"].values
    largest = np.nanmax(np.where(np.isnan(amplitude), -1.0, amplitude), axis=0, initial=-1.0)
    chosen = np.sort(np.argsort(-largest, kind="stable")[:MOST_NODES])
    with drawing(ax) as ax:
        speeds = label_speed(ax, whirls)
        label_axis(ax.yaxis, "amplitude", whirls["node_amplitude"])
        for number, node in enumerate(chosen):
            colour, dashes = look(number)
            ax.plot(
                speeds, amplitude[:, node], color=colour, ls=dashes, label=in_figure(names[node])
            )
        ax.set_yscale("log")
        ax.set_title("contact-free whirl by node")
        legend_below(ax, columns=4)
    return ax


def plot_whirl_shapes(
    whirls: xr.Dataset, *, speed: float | None = None, ax: Axes | None = None
) -> Axes:
    """Draw the deflected shape of every synchronous whirl at a speed.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system.
    speed : float, optional
        The speed, in the unit of the dataset; the nearest one is drawn. Default: where a node is
        farthest from its place of rest.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or the speed is outside its speeds.

    Notes
    -----
    The displacement of each node is that along the direction of the node that moves most. Bars are
    the clearances of stators that stand still.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, speed=[0.5, 1.0, 1.5])
    >>> plot_whirl_shapes(whirls, speed=1.5).get_title()
    'spin speed 1.5'
    """
    whirls = check_dataset("whirls", whirls, (*WHIRLS, "node", "node_phase_lag", "contact_stator"))
    row = _row_at(whirls, speed)
    here = whirls.isel(speed=row)
    places = np.arange(float(here.sizes["node"]))
    if "axial_position" in here.variables:
        places = here["axial_position"].values
    order, flags = np.argsort(places, kind="stable"), flags_of(whirls["stability"])
    with drawing(ax) as ax:
        if "axial_position" in here.variables:
            label_axis(ax.xaxis, "axial_position", here["axial_position"])
        else:
            name_nodes(ax, list(map(str, here["node"].values)))
        label_axis(ax.yaxis, "displacement", here["node_amplitude"])
        ax.axhline(0.0, color=GREY, lw=0.7)
        _draw_rooms(ax, here, places)
        for word, (label, colour, mark, size, fill) in MARKS.items():
            for branch in np.flatnonzero(here["stability"].values == flags[word]):
                own = here.isel(branch=branch)
                moved = own["node_amplitude"].values * np.exp(-1j * own["node_phase_lag"].values)
                turn = moved[np.argmax(np.abs(moved))]
                up = (moved * turn.conjugate()).real / max(abs(turn), 1e-300)
                ax.plot(places[order], up[order], color=colour, marker=mark, ms=size,
                        fillstyle=fill, label=label, zorder=3.0)  # fmt: skip
        turns = in_rpm(whirls["speed"])
        value = f"{here['speed'].item():.6g}" if turns is None else f"{turns[row]:.6g} rpm"
        ax.set_title(f"spin speed {value}")
        legend_below(ax, columns=4)
    return ax


def _row_at(whirls: xr.Dataset, speed: object) -> int:
    """Return the number of the speed nearest to one; default: of the largest amplitude."""
    speeds = whirls["speed"].values
    if speed is None:
        sizes = np.nan_to_num(whirls["node_amplitude"].values, nan=-1.0)
        return int(np.argmax(sizes.max(axis=(1, 2), initial=-1.0)))
    wanted = check_real("speed", speed)
    if not speeds.min() <= wanted <= speeds.max():
        ends = f"{speeds.min():g} to {speeds.max():g}"
        raise InputError(f"speed must lie from {ends}, got {wanted!r}")
    return int(np.argmin(np.abs(speeds - wanted)))


def _draw_rooms(ax: Axes, here: xr.Dataset, places: Values) -> None:
    """Draw the clearances of stators that stand still."""
    fixed = here["contact_stator"].values == ""
    nodes = list(map(str, here["node"].values))
    at = [nodes.index(str(node)) for node in here["contact_node"].values[fixed]]
    if at:
        ax.errorbar(places[at], np.zeros(len(at)), here["clearance"].values[fixed], fmt="none",
                    ecolor=INK, elinewidth=0.8, capsize=3.5, label="clearance")  # fmt: skip


def system_whirls_figure(whirls: xr.Dataset) -> Figure:
    """Draw the synchronous whirls of a rotor system: a panel for each contact.

    Parameters
    ----------
    whirls : Dataset
        Result of `rotor_ida.synchronous_response` for a rotor system; without contacts the
        unbalance response is drawn.

    Examples
    --------
    >>> from rotor_ida import Rotor, synchronous_response
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> whirls = synchronous_response(system, speed=[0.5, 1.0, 1.5])
    >>> len(system_whirls_figure(whirls).axes)
    1
    """
    whirls = check_dataset("whirls", whirls, WHIRLS)
    if not whirls.sizes["contact"]:
        return cast(Figure, plot_unbalance_response(whirls).figure)
    return panels_of_contacts(
        whirls.sizes["contact"],
        lambda number, ax: plot_system_whirls(whirls, contact=number, ax=ax),
    )


def panels_of_contacts(count: int, draw: Callable[[int, Axes | None], Axes]) -> Figure:
    """Draw a panel for each contact, with one legend; one alone has a figure of its own."""
    if check_panels(count) < 2:
        return cast(Figure, draw(0, None).figure)
    columns = math.ceil(math.sqrt(count))
    rows = math.ceil(count / columns)
    figure, axes = mixed_panels(rows, columns, width=2.0 + 2.8 * columns, height=1.6 + 2.2 * rows)
    for number, ax in enumerate(axes[:count]):
        draw(number, ax)
    for ax in axes[count:]:
        ax.remove()
    shared_legend(figure, axes[:count], outer=False)
    return figure


def plot_special_speeds(special: xr.Dataset, *, contact: int = 0, ax: Axes | None = None) -> Axes:
    """Draw the whirls at a contact over the spin speed, with the speeds at which they change.

    Parameters
    ----------
    special : Dataset
        Result of `rotor_ida.special_speeds`.
    contact : int
        Number of the contact.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, special_speeds
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> special = special_speeds(system, limits=(0.5, 2.5), points=50)
    >>> ax = plot_special_speeds(special)
    >>> [line.get_label() for line in ax.lines]
    ['clearance', 'stable whirl', 'unstable whirl', 'fold']
    """
    check_dataset("special", special, (*BRANCHES, "special_speed", "special_kind", "amplitude"))
    whirls = special.drop_vars(["amplitude", "stability"], errors="ignore").rename(BRANCHES)
    return plot_system_whirls(whirls, contact=contact, special=special, ax=ax)


def special_speeds_figure(special: xr.Dataset) -> Figure:
    """Draw the speeds at which the whirls of a rotor system change: a panel for each contact.

    Parameters
    ----------
    special : Dataset
        Result of `rotor_ida.special_speeds`.

    Examples
    --------
    >>> from rotor_ida import Rotor, special_speeds
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> special = special_speeds(system, limits=(0.5, 2.5), points=50)
    >>> len(special_speeds_figure(special).axes)
    1
    """
    check_dataset("special", special, tuple(BRANCHES))
    if not special.sizes["contact"]:
        raise InputError("special must be of a system with contacts, got one without")
    return panels_of_contacts(
        special.sizes["contact"],
        lambda number, ax: plot_special_speeds(special, contact=number, ax=ax),
    )


def plot_campbell(found: xr.Dataset, *, ax: Axes | None = None) -> Axes:
    """Draw whirl speeds over the spin speed: forward, backward and neither.

    Parameters
    ----------
    found : Dataset
        Result of `rotor_ida.campbell`. Stiffer contacts are drawn fainter, critical speeds as
        rings.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Examples
    --------
    >>> from rotor_ida import Rotor, campbell
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5, shaft_stiffness=0.25).system()
    >>> plot_campbell(campbell(system, speed=[0.0, 0.5, 1.0])).get_ylabel()
    'size of the whirl speed'
    """
    needed = ("speed", "contact_stiffness", "whirl_speed", "whirl_sense")
    found = check_dataset("found", found, needed)
    springs = found["contact_stiffness"].values
    with drawing(ax) as ax:
        speeds = label_speed(ax, found)
        whirl, unit = np.abs(found["whirl_speed"].values), units_in(found["whirl_speed"])
        if (turns := in_rpm(found["whirl_speed"])) is not None:
            whirl, unit = np.abs(turns), "rpm"
        ax.set_ylabel("size of the whirl speed" + ("" if unit in ("", "1") else f" [{unit}]"))
        highest = HIGHEST * float(np.abs(speeds).max(initial=0.0)) or np.inf
        drawn = whirl[whirl <= highest]
        senses = found["whirl_sense"].values
        for word, (colour, mark) in SENSES.items():
            for number, faint in enumerate(np.linspace(1.0, 0.35, springs.size)):
                chosen = (senses[number] == WHIRL_DIRECTION[word]) & np.isfinite(whirl[number])
                across = np.broadcast_to(speeds[:, np.newaxis], chosen.shape)
                ax.plot(across[chosen], whirl[number][chosen], ls="", marker=mark, ms=2.8,
                        color=colour, alpha=float(faint), mec="none")  # fmt: skip
        ax.plot(speeds, np.abs(speeds), color=INK, lw=0.9, ls="--", label="spin speed")
        handles = [ax.lines[-1], *_handles(senses, springs, units_in(found["contact_stiffness"]))]
        # archives had none at first
        critical = speeds_in(found["critical_speed"]) if "critical_speed" in found else np.empty(0)
        if critical.size:
            draw_marks(ax, critical, np.abs(critical), "o", INK, size=5.0, face="none",
                       label="critical speed", level=3.7)  # fmt: skip
            handles.append(ax.lines[-1])
        top = float(np.append(drawn, np.abs(critical)).max(initial=0.0))
        ax.set_ylim(0.0, ABOVE * top or 1.0)
        legend_below(ax, handles=handles)
    return ax


def _handles(senses: Values, springs: Values, unit: str) -> list[Line2D]:
    """Return the entries of a legend: the senses of whirl, and the stiffnesses of contacts."""
    handles = [
        Line2D([], [], ls="", marker=mark, color=colour,
               label="along a line" if word == "none" else word)
        for word, (colour, mark) in SENSES.items() if (senses == WHIRL_DIRECTION[word]).any()
    ]  # fmt: skip
    if springs.size > 1:
        written = " N/m" if unit == "N m-1" else ""
        handles += [
            Line2D([], [], ls="", marker="s", color=INK, alpha=float(faint),
                   label=f"contacts {spring:.3g}{written}")
            for spring, faint in zip(springs, np.linspace(1.0, 0.35, springs.size), strict=True)
        ]  # fmt: skip
    return handles


def label_speed(ax: Axes, dataset: xr.Dataset) -> Values:
    """Label the axis of the speed, in rpm for SI units, and return the speeds in that unit."""
    ax.set_xlabel(speed_label(dataset))
    return speeds_in(dataset["speed"])


def speed_label(dataset: xr.Dataset) -> str:
    """Return the label of an axis of the speed, in rpm for SI units."""
    return r"spin speed $\Omega$" if in_rpm(dataset["speed"]) is None else "spin speed [rpm]"


def speeds_in(speeds: xr.DataArray) -> Values:
    """Return speeds in rpm, or as they are where they have no unit."""
    turns = in_rpm(speeds)
    return np.asarray(speeds.values) if turns is None else turns
