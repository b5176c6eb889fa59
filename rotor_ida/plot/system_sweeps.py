"""Speed maps of rotor systems: settled responses at each contact over the exact whirls."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rotor_ida.arrays import Values
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED, with_parameters
from rotor_ida.plot.appearance import (
    drawing,
    legend_below,
    raise_limit,
)
from rotor_ida.plot.datasets import check_dataset, one_value
from rotor_ida.plot.labels import SEPARATOR, label_axis, label_varied, unit_of
from rotor_ida.plot.responses import draw_beneath, draw_simulated
from rotor_ida.plot.system_whirls import (
    WHIRLS,
    at_contact,
    draw_clearance,
    label_speed,
    panels_of_contacts,
    speeds_in,
)
from rotor_ida.results.archived_system import clearance_of_contacts, problem_of
from rotor_ida.results.concat import concat

SWEEP = (
    "speed", "response", "direction", "amplitude", "phase_lag", "radius_min", "radius_max",
    "touched", "clearance", "contact_node",
)  # fmt: skip
# What is drawn of exact whirls over another parameter than the speed.
WHIRLS_ALONG = ("amplitude", "stability")
# Speeds at which they are computed, at least; values of another parameter.
FEWEST_SPEEDS, VALUES = 500, 80


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
        the range of the distance from the centre of the stator. The parameter on the axis is the
        one along which the sweep leads, or the speed, or where that has one value the only one
        that varies; the sweep has one value of each other.
    contact : int
        Number of the contact. Its clearance is a dashed line.
    whirls : Dataset, optional
        Result of `rotor_ida.synchronous_response` for the same system: the exact whirls are drawn
        beneath. Over another parameter than the speed, several such results joined along it.
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
    (over, held), part = held_in(sweep, "sweep"), at_contact(sweep, contact)
    widest = float(clearance_of_contacts(part).max())
    with drawing(ax) as ax:
        places = label_over(ax, sweep, over)
        label_axis(ax.yaxis, "amplitude", sweep["amplitude"])
        draw_clearance(ax, part, over=over)
        if held:
            ax.set_title(f"{ax.get_title()}\n{text_of_system(sweep, held)}")
        highest = float(np.nanmax(part["radius_max"].values, initial=widest))
        if whirls is not None:
            needed = WHIRLS if over == SPEED else (over, *WHIRLS_ALONG)
            exact = check_dataset("whirls", whirls, needed)
            beneath = at_contact(exact, contact)
            across = beneath[over]
            values = speeds_in(across) if over == SPEED else across.values
            draw_beneath(ax, across.copy(data=values), beneath)
            highest = max(highest, float(np.nanmax(beneath["amplitude"], initial=0.0)))
        at_places = part.assign_coords({over: (over, places)})
        draw_simulated(ax, at_places, "amplitude", over=over, reach="|u|")
        raise_limit(ax, highest)
        legend_below(ax, columns=3)
    return ax


def held_in(dataset: xr.Dataset, name: str = "found") -> tuple[str, dict[str, float]]:
    """Return the parameter over which a result is drawn, and the one value of each other."""
    over = axis_of(dataset)
    others = [each for each in _parameters_in(dataset) if each != over]
    return over, {each: one_value(name, dataset, each) for each in others}


def label_over(ax: Axes, dataset: xr.Dataset, over: str) -> Values:
    """Label the axis of a parameter, and return its values; speeds of a system in rpm."""
    if over == SPEED:
        return label_speed(ax, dataset)
    label_varied(ax.xaxis, over, dataset)
    if over in PARAMETERS_OF_SYSTEM:  # an unbalance has many digits
        ax.ticklabel_format(axis="x", scilimits=(-2, 4), useMathText=True)
    return np.asarray(dataset[over].values)


def axis_of(sweep: xr.Dataset) -> str:
    """Return the parameter over which a sweep is drawn."""
    names = [name for name in _parameters_in(sweep) if sweep[name].size > 1]
    first = SPEED if SPEED in names or not names else names[0]
    return str(sweep.attrs.get("along", first))


def _parameters_in(sweep: xr.Dataset) -> list[str]:
    """Return the speed and the parameters that are axes or numbers of a sweep."""
    return [name for name in (SPEED, *PARAMETERS_OF_SYSTEM)
            if name in sweep.variables and sweep[name].dims in {(), (name,)}]  # fmt: skip


def text_of_system(sweep: xr.Dataset, values: Mapping[str, float]) -> str:
    """Return values of parameters as a title."""
    told = []
    for name, value in values.items():
        words = PARAMETERS_OF_SYSTEM[name].label if name in PARAMETERS_OF_SYSTEM else name
        shown, unit = value, unit_of(sweep[name])
        if name == SPEED and unit:
            shown, unit = speeds_in(sweep[name]).item(), "rpm"
        told.append(f"{words} {shown:.4g} {unit}".rstrip())
    return SEPARATOR.join(told)


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
    over = axis_of(sweep)
    parts = list(_parts(sweep, over))
    beneath = [_exact_beneath(part, over) for part in parts]
    contacts = sweep.sizes["contact"]

    def draw(number: int, ax: Axes | None) -> Axes:
        place, contact = divmod(number, contacts)
        return plot_system_sweep(parts[place], contact=contact, whirls=beneath[place], ax=ax)

    return panels_of_contacts(contacts * len(parts), draw)


def _parts(sweep: xr.Dataset, over: str) -> Iterator[xr.Dataset]:
    """Yield the parts of a sweep with one value of each parameter but one."""
    names = [name for name in _parameters_in(sweep) if name != over and sweep[name].ndim]
    for places in product(*(range(sweep.sizes[name]) for name in names)):
        yield sweep.isel({name: [at] for name, at in zip(names, places, strict=True)})


def _exact_beneath(part: xr.Dataset, over: str) -> xr.Dataset | None:
    """Return the exact whirls of the system of a sweep; None where there are none."""
    names = [name for name in _parameters_in(part) if name not in {SPEED, over}]
    try:
        system, _ = problem_of(part)
        system = with_parameters(system, {name: part[name].item() for name in names})
        if over == SPEED:
            return whirls_of_system(system, _dense(part[SPEED].values))
        found, values = [], part[over].values
        for value in np.linspace(values.min(), values.max(), VALUES).tolist():
            own = with_parameters(system, {over: value})
            whirls = whirls_of_system(own, part[SPEED].item())
            found.append(whirls[[*WHIRLS_ALONG]].isel(speed=0, drop=True).reset_coords(drop=True))
            found[-1] = found[-1].assign_coords({over: ((), value, part[over].attrs)})
        return concat(found, over)
    except InputError:  # not axisymmetric, under a constant force, or a part of a sweep
        return None


def _dense(speeds: Values) -> Values:
    """Return speeds over the same range, close enough for dots to be read as lines."""
    if speeds.size < 2:
        return speeds
    return np.linspace(speeds.min(), speeds.max(), max(FEWEST_SPEEDS, speeds.size))
