"""What a file says to readers that know the CF conventions but not this package."""

from __future__ import annotations

import importlib
import importlib.metadata
from datetime import UTC, datetime

import numpy as np
import xarray as xr

HISTORY = "history"
CREATED = "date_created"
COMMAND = "command"

# A coordinate called time is for CF a date, which dimensionless time and time since a start are
# not. What is known along it is therefore named as coordinates of a motion, by a domain variable
# (CF-1.9, section 5.8): CF takes it for data on a calendar otherwise.
TIME = "time"
DOMAIN = "time_domain"

# The attribute of a label that names the coordinate that it is.
LABEL_OF = "label_of"


def time_domain(dataset: xr.Dataset) -> xr.Variable | None:
    """Return the domain variable of what is known along ``time``, None where there is none.

    Examples
    --------
    >>> run = xr.Dataset({"x": ("time", [0.0, 1.0])}, {"time": [0.0, 0.1]})
    >>> time_domain(run).attrs["coordinates"]
    'x'
    """
    if TIME in dataset.coords and "standard_name" in dataset[TIME].attrs:
        return None
    along = [
        str(name)
        for name, variable in dataset.data_vars.items()
        if TIME in variable.dims and variable.dtype.kind in "iuf"
    ]
    along = [name for name in along if "flag_meanings" not in dataset[name].attrs]
    if not along:
        return None
    dims = dict.fromkeys(str(dim) for name in along for dim in dataset[name].dims)
    attributes = {
        "long_name": "the motion, known along the dimension time",
        "dimensions": " ".join(dims),
        "coordinates": " ".join(along),
    }
    return xr.Variable((), np.int8(0), attributes)


def stored_names(dataset: xr.Dataset) -> dict[str, str]:
    """Return the name in the file of each variable.

    For CF the coordinate of a dimension is a number. Where it is a text it is stored under another
    name, as a label of the dimension.

    Examples
    --------
    >>> stored_names(xr.Dataset({"x": ("bearing", [0.0, 1.0])}, {"bearing": ["left", "right"]}))
    {'x': 'x', 'bearing': 'bearing_label'}
    """
    names = {str(name): str(name) for name in dataset.variables}
    for name in names:
        if name in dataset.dims and dataset[name].dtype.kind not in "iuf":
            label = f"{name}_label"
            while label in names or label in dataset.dims:
                label += "_"
            names[name] = label
    return names


def coordinates_of(dataset: xr.Dataset) -> tuple[dict[str, str], str]:
    """Return the attribute ``coordinates`` of each variable, and that of the file for the others.

    Examples
    --------
    >>> run = xr.Dataset({"x": ("time", [0.0])}, {"omega": 1.7, "far": ("start", ["a"])})
    >>> coordinates_of(run)
    ({'x': 'omega'}, 'far')
    """
    stored = stored_names(dataset)
    others = [str(name) for name in dataset.coords if stored[str(name)] not in dataset.dims]
    named: dict[str, str] = {}
    for name, variable in dataset.data_vars.items():
        its_own = [each for each in others if set(dataset[each].dims) <= set(variable.dims)]
        if its_own:
            named[str(name)] = " ".join(sorted(stored[each] for each in its_own))
    told = {name for names in named.values() for name in names.split()}
    return named, " ".join(sorted({stored[each] for each in others} - told))


def history_with(history: str, event: str, moment: str) -> str:
    """Return the CF attribute ``history`` with one line added for what happened at `moment`.

    Examples
    --------
    >>> print(history_with("2026-11-20T09:00:00Z cut", "saved", "2026-11-21T15:00:00Z"))
    2026-11-20T09:00:00Z cut
    2026-11-21T15:00:00Z rotor_ida ...: saved
    """
    line = f"{moment} rotor_ida {importlib.metadata.version('rotor-ida')}: {event}"
    return f"{history.rstrip()}\n{line}" if history.strip() else line


def now() -> str:
    """Return the time, in UTC, as ISO 8601."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def libraries() -> str:
    """Return the versions of the libraries that write the file."""
    netcdf = importlib.import_module("netCDF4")
    return (
        f"netCDF4 {netcdf.__version__}, netCDF-C {netcdf.__netcdf4libversion__}, "
        f"HDF5 {netcdf.__hdf5libversion__}"
    )
