"""The dataset of one run: check it, and return its rotor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_increasing, check_instance, check_samples, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import (
    DAMPED_EVENT_KIND,
    EVENT_KIND,
    OF_FRICTION_EVENT_KIND,
    RESULT_KIND,
    Column,
    Quantity,
    check_as_computed,
    labelled,
)

# A run that begins or ends in a contact does not have all of these.
PARTLY_KNOWN = ("entry_time", "exit_time", "peak_time", "peak_force")

# Kinds of result that hold one.
SYSTEM_RUN, DROP = "system_run", "drop"
# The variables of a run of a rotor system: along which dimensions, and kinds of their numbers.
_TEXT, _WHOLE, _REAL = "UO", "iu", "iuf"
OF_SYSTEM: dict[str, tuple[tuple[str, ...], str]] = {
    "node": (("node",), _TEXT),
    **dict.fromkeys(("contact_node", "contact_stator"), (("contact",), _TEXT)),
    **dict.fromkeys(("clearance", "centre_x", "centre_y"), (("contact",), _REAL)),
    **dict.fromkeys(("x", "y"), (("t", "node"), _REAL)),
    **dict.fromkeys(
        ("contact_x", "contact_y", "normal_force", "tangential_force"), (("t", "contact"), _REAL)
    ),
    "mode": (("t", "contact"), _WHOLE),
    **dict.fromkeys(("event_time", "event_contact_x", "event_contact_y"), (("event",), _REAL)),
    **dict.fromkeys(("event_kind", "event_contact"), (("event",), _WHOLE)),
    "episode_contact": (("episode",), _WHOLE),
    **dict.fromkeys(("entry_time", "exit_time", "peak_time", "peak_force"), (("episode",), _REAL)),
}
_WORDS = {_TEXT: "text", _WHOLE: "whole numbers", _REAL: "real numbers"}


def samples_in(
    name: str, dataset: xr.Dataset, variable: str, dims: tuple[str, ...] = ("t",)
) -> Values:
    """Return a variable of a dataset, which must be finite numbers along one of `dims` alone."""
    found = dataset[variable]
    if found.dims not in [(dim,) for dim in dims]:
        raise InputError(
            f"{variable} of {name} must be on {listed(dims, 'or')} alone, got it on "
            f"{listed(list(map(str, found.dims))) if found.dims else 'no dimension'}"
        )
    return check_samples(f"{variable} of {name}", found.values)


def is_of_system(dataset: xr.Dataset) -> bool:
    """Return whether a dataset is a run of a rotor system, such as a drop."""
    kind = dataset.attrs.get(RESULT_KIND)
    return kind in {SYSTEM_RUN, DROP} and "contact_node" in dataset.variables


def nodes_in(run: xr.Dataset) -> list[str]:
    """Return the names of the nodes in a run of a rotor system, or in a part of one."""
    return [str(node) for node in np.atleast_1d(run["node"].values)] if "node" in run.coords else []


def refuse_system(name: str, dataset: xr.Dataset) -> None:
    """Raise `InputError` for a run of a rotor system."""
    if is_of_system(dataset):
        nodes = listed([repr(node) for node in nodes_in(dataset)] or ["no node"], "or")
        raise InputError(
            f"{name} must be of one disc, got a run of a rotor system: "
            f"signals_of(run, node=...) gives signals of {nodes}"
        )


def check_run(run: object, needed: Sequence[str]) -> xr.Dataset:
    """Return `run` if it is a dimensionless run of one rotor with the required variables."""
    run = check_instance("run", run, xr.Dataset)
    refuse_system("run", run)
    missing = [name for name in (*PARAMETERS, *needed) if name not in run.variables]
    if missing:
        raise InputError(f"run must be a run of simulate; it lacks {', '.join(missing)}")
    several = [name for name in ALL_PARAMETERS if name in run.variables and run[name].ndim]
    if several:
        raise InputError(f"run must be one run; its {several[0]} must be a scalar")
    check_as_computed("run", run)
    check_columns(run, needed)
    return run


def check_system_run(run: object, needed: Sequence[str] = tuple(OF_SYSTEM)) -> xr.Dataset:
    """Return `run` if it is a run of a rotor system with the required variables, time first."""
    run = check_instance("run", run, xr.Dataset)
    if not is_of_system(run):
        title = run.attrs.get("title", "another dataset")
        raise InputError(f"run must be of a rotor system, got {shown(title)}")
    missing = [name for name in ("t", *needed) if name not in run.variables]
    if missing:
        raise InputError(f"run must be a run of simulate; it lacks {', '.join(missing)}")
    check_increasing("t", samples_in("run", run, "t"))
    run = run.transpose("t", "node", ..., missing_dims="ignore")
    for name in needed:
        _check_column(run[name], *OF_SYSTEM[name])
        if name.endswith("_contact"):
            contacts, numbers = run.sizes["contact"], run[name].values
            wrong = numbers[(numbers < 0) | (numbers >= contacts)]
            if wrong.size:
                raise InputError(
                    f"{name} of run must be below its number of contacts, {contacts}, got "
                    f"{wrong[0]}"
                )
    return run


def _check_column(column: xr.DataArray, dims: tuple[str, ...], kinds: str) -> None:
    """Refuse a variable of a run along other dimensions, of another kind, or not finite."""
    if column.dims != dims:
        along = listed([str(dim) for dim in column.dims]) if column.dims else "no dimension"
        raise InputError(f"{column.name} of run must be along {listed(dims)}, got it on {along}")
    if column.dtype.kind not in kinds:
        raise InputError(f"{column.name} of run must be {_WORDS[kinds]}, got {column.dtype}")
    if "t" in dims:
        check_samples(f"{column.name} of run", column.values)


def check_columns(run: xr.Dataset, names: Sequence[str]) -> None:
    """Raise `InputError` unless variables of a run are numbers over time, events or contacts."""
    for name in names:
        if name not in PARTLY_KNOWN:
            samples_in("run", run, name, ("event" if name.startswith("event_") else "t",))


def check_one_speed(run: xr.Dataset, what: str) -> None:
    """Raise `InputError` for a run whose speed changes."""
    if "event_speed" in run.variables:
        raise InputError(f"run must be at one speed for {what}, got a run of run_up")


def rotor_of(run: xr.Dataset) -> Rotor:
    """Return the rotor of a run; missing parameters have their defaults."""
    return Rotor(**{name: run[name].item() for name in ALL_PARAMETERS if name in run.variables})


def parameter_coordinates(rotor: Rotor) -> dict[str, Column]:
    """Return the parameters of a rotor as scalar coordinates, without optional ones at defaults."""
    return {name: ((), value) for name, value in rotor.given.items()}


def kinds_of_events(*rotors: Rotor) -> dict[str, int]:
    """Return the kinds of events of some discs; contact damping and friction add kinds.

    Examples
    --------
    >>> rubbing = Rotor(omega=1.0, zeta=0.1, delta0=0.5, friction=0.1, disc_radius=1.0)
    >>> list(kinds_of_events(rubbing))
    ['exit', 'entry', 'roll', 'slip', 'reverse']
    """
    flags = EVENT_KIND
    if any(rotor.friction > 0.0 for rotor in rotors):
        flags = flags | OF_FRICTION_EVENT_KIND
    if any(rotor.contact_damping > 0.0 for rotor in rotors):
        flags = flags | {name: DAMPED_EVENT_KIND[name] for name in ("press", "release")}
    return flags


def event_columns(
    times: npt.ArrayLike, kinds: npt.ArrayLike, flags: Mapping[str, int]
) -> dict[str, xr.Variable]:
    """Return times and kinds of events, of which some are possible."""
    columns = {
        "event_time": labelled("event_time", "event", times),
        "event_kind": labelled("event_kind", "event", kinds),
    }
    if flags != EVENT_KIND:
        columns["event_time"].attrs["long_name"] = "time of the contact event"
        kind = Quantity(columns["event_kind"].attrs["long_name"], flags=flags)
        columns["event_kind"].attrs = kind.attributes()
    return columns


def course_of(speeds: Values) -> Values:
    """Return the first and the last speed, and those between at which it is largest or smallest.

    Examples
    --------
    >>> course_of(np.array([0.0, 900.0, 1800.0, 600.0, 0.0])).tolist()
    [0.0, 1800.0, 0.0]
    >>> course_of(np.array([300.0, 900.0, 1800.0])).tolist()
    [300.0, 1800.0]
    """
    low, high = np.sort(speeds[[0, -1]])
    extremes = sorted({int(speeds.argmin()), int(speeds.argmax())})
    slack = 1e-9 * float(np.abs(speeds).max())  # of rounding
    turns = [at for at in extremes if not low - slack <= speeds[at] <= high + slack]
    return np.asarray(speeds[[0, *turns, -1]])
