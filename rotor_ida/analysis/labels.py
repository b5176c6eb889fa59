"""What the results of this package have in common: what they come from, and how they are made."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import numpy.typing as npt
import xarray as xr

from rotor_ida.errors import InputError
from rotor_ida.parameters import Rotor
from rotor_ida.schema import CONVENTIONS, labelled

PARAMETERS = ("omega", "zeta", "delta0")
Columns = Mapping[str, tuple[Hashable | Sequence[Hashable], npt.ArrayLike]]


def check_rotor(rotor: object) -> Rotor:
    """Return `rotor` if it is one."""
    if not isinstance(rotor, Rotor):
        raise InputError(f"rotor must be a Rotor, got {rotor!r}")
    return rotor


def check_run(run: object, needed: Sequence[str]) -> xr.Dataset:
    """Return `run` if it is a dimensionless run of one rotor with the variables needed."""
    if not isinstance(run, xr.Dataset):
        raise InputError(f"run must be a run of simulate, got {type(run).__name__}")
    missing = [name for name in (*PARAMETERS, *needed) if name not in run.variables]
    if missing:
        raise InputError(f"run must be a run of simulate; it lacks {', '.join(missing)}")
    if any(run[name].ndim for name in PARAMETERS):
        raise InputError("run must be one run; its omega, zeta and delta0 must be scalars")
    if "length_scale" in run.attrs:
        raise InputError("run must be dimensionless, got one in SI units: convert the result")
    return run


def rotor_of(run: xr.Dataset) -> Rotor:
    """Return the rotor of a run."""
    return Rotor(**{name: float(run[name]) for name in PARAMETERS})


def result(
    title: str,
    rotor: Rotor,
    columns: Columns,
    coordinates: Columns,
    attributes: Mapping[str, object],
) -> xr.Dataset:
    """Return columns as a dataset labelled by the rotor's parameters.

    Parameters
    ----------
    title : str
        What the dataset is.
    rotor : Rotor
        The rotor.
    columns, coordinates : mapping of str to tuple
        Dimensions and values by the names of `rotor_ida.schema`.
    attributes : mapping
        Where the result comes from.
    """
    parameters = {name: getattr(rotor, name) for name in PARAMETERS}
    coords = {name: labelled(name, (), value) for name, value in parameters.items()}
    coords |= {name: labelled(name, *column) for name, column in coordinates.items()}
    variables = {name: labelled(name, *column) for name, column in columns.items()}
    told = {**attributes, "Conventions": CONVENTIONS, "title": title}
    return xr.Dataset(variables, coords, told)
