"""Speed maps of rotor systems: settled responses at each contact over the exact whirls."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError
from rotor_ida.plot.appearance import (
    drawing,
    legend_below,
    raise_limit,
)
from rotor_ida.plot.datasets import check_dataset
from rotor_ida.plot.labels import label_axis
from rotor_ida.plot.responses import draw_beneath, draw_simulated
from rotor_ida.plot.system_whirls import (
    WHIRLS,
    at_contact,
    draw_clearance,
    label_speed,
    panels_of_contacts,
    speeds_in,
)
from rotor_ida.systems.archived import problem_of
from rotor_ida.systems.whirls.synchronous import synchronous_response_system

SWEEP = (
    "speed", "response", "direction", "amplitude", "phase_lag", "radius_min", "radius_max",
    "touched", "clearance", "contact_node",
)  # fmt: skip
# Speeds at which they are computed, at least.
FEWEST_SPEEDS = 500


def plot_system_sweep(
    sweep: xr.Dataset,
    *,
    contact: int = 0,
    whirls: xr.Dataset | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Draw the settled responses of a rotor system at a contact over the spin speed.

    Parameters
    ----------
    sweep : Dataset
        Result of `rotor_ida.sweep` for a rotor system with contacts. Synchronous and contact-free
        responses are marks at their amplitude, by direction of the sweep. All others are bars over
        the range of the distance from the centre of the stator.
    contact : int
        Number of the contact. Its clearance is a dashed line.
    whirls : Dataset, optional
        Result of `rotor_ida.synchronous_response` for the same system: the exact whirls are drawn
        beneath.
    ax : Axes, optional
        Axes to draw on and return; default: those of a new figure.

    Raises
    ------
    InputError
        If a dataset is of another kind, or has no such contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, sweep
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> responses = sweep(system, speed=[0.5, 1.0, 1.5])
    >>> plot_system_sweep(responses).get_title()
    'contact 0 at disc'
    """
    sweep = check_dataset("sweep", sweep, SWEEP)
    part = at_contact(sweep, contact)
    with drawing(ax) as ax:
        speeds = label_speed(ax, sweep)
        label_axis(ax.yaxis, "amplitude", sweep["amplitude"])
        draw_clearance(ax, part)
        highest = float(np.nanmax(part["radius_max"].values, initial=part["clearance"].item()))
        if whirls is not None:
            exact = check_dataset("whirls", whirls, (*WHIRLS, "contact_node"))
            beneath = at_contact(exact, contact)
            draw_beneath(ax, beneath["speed"].copy(data=speeds_in(beneath["speed"])), beneath)
            highest = max(highest, float(np.nanmax(beneath["amplitude"], initial=0.0)))
        draw_simulated(
            ax, part.assign_coords(speed=("speed", speeds)), "amplitude", over="speed", reach="|u|"
        )
        raise_limit(ax, highest)
        legend_below(ax, columns=3)
    return ax


def system_sweep_figure(sweep: xr.Dataset) -> Figure:
    """Draw a speed map of a rotor system: a panel for each contact, with the exact whirls.

    Parameters
    ----------
    sweep : Dataset
        Result of `rotor_ida.sweep` for a rotor system with contacts. Where it is axisymmetric, the
        exact whirls are computed from the matrices in it.

    Raises
    ------
    InputError
        If the dataset is of another kind, or has no contact.

    Examples
    --------
    >>> from rotor_ida import Rotor, sweep
    >>> system = Rotor(omega=1.0, zeta=0.07, delta0=0.5).system()
    >>> responses = sweep(system, speed=[0.5, 1.0, 1.5])
    >>> len(system_sweep_figure(responses).axes)
    1
    """
    check_dataset("sweep", sweep, SWEEP)
    whirls = _exact_beneath(sweep)
    return panels_of_contacts(
        sweep.sizes["contact"],
        lambda number, ax: plot_system_sweep(sweep, contact=number, whirls=whirls, ax=ax),
    )


def _exact_beneath(sweep: xr.Dataset) -> xr.Dataset | None:
    """Return the exact whirls of the system of a sweep; None where there are none."""
    try:
        system, _ = problem_of(sweep)
        return synchronous_response_system(system, speed=_dense(sweep["speed"].values))
    except InputError:  # not axisymmetric, under a constant force, or a part of a sweep
        return None


def _dense(speeds: Values) -> Values:
    """Return speeds over the same range, close enough for dots to be read as lines."""
    if speeds.size < 2:
        return speeds
    return np.linspace(speeds.min(), speeds.max(), max(FEWEST_SPEEDS, speeds.size))
