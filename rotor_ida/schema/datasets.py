"""Labelled datasets: their variables have long names and units, from the one table."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from xarray.indexes import Index, PandasIndex

from rotor_ida.arrays import Column
from rotor_ida.errors import InputError
from rotor_ida.schema.quantities import QUANTITIES

CONVENTIONS = "CF-1.11"
# Attribute with the kind of result of a dataset, a row of `rotor_ida.results.kinds`.
RESULT_KIND = "result_kind"


def labelled(name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike) -> xr.Variable:
    """Return `values` as a variable with the long name and units of `name`.

    Examples
    --------
    >>> labelled("omega", "omega", [1.7]).attrs["units"]
    '1'
    """
    # fastpath: an array needs no further checks
    return xr.Variable(dims, np.asarray(values), QUANTITIES[name].attributes(), fastpath=True)


def labelled_dataset(
    title: str,
    variables: Mapping[str, Column | xr.Variable],
    coordinates: Mapping[str, Column | xr.Variable],
    attributes: Mapping[str, object] | None = None,
    *,
    kind: str = "",
) -> xr.Dataset:
    """Return a dataset whose variables have their long names and units.

    Variables are given by their names in `QUANTITIES`: as dimensions and values, or as labelled
    variables. Other attributes may describe, for example, the origin of the result. The kind is a
    row of `rotor_ida.results.kinds`; results of this package always have one.

    Examples
    --------
    >>> whirls = labelled_dataset(
    ...     "whirls", {"amplitude": ("omega", [2.0, 3.0])}, {"omega": ("omega", [1.7, 1.8])}
    ... )
    >>> whirls.attrs
    {'Conventions': 'CF-1.11', 'title': 'whirls'}
    >>> whirls.sel(omega=1.8).amplitude.item()
    3.0
    >>> whirls.identical(xr.Dataset(whirls.data_vars, whirls.coords, whirls.attrs))
    True
    """
    held: dict[Hashable, xr.Variable] = {
        name: column.to_base_variable()
        if isinstance(column, xr.Variable)
        else labelled(name, *column)
        for name, column in (*variables.items(), *coordinates.items())
    }
    indexes: dict[Hashable, Index] = {}
    for name, variable in tuple(held.items()):
        if variable.dims == (name,):
            indexes[name] = index = PandasIndex(variable.values, name, variable.dtype)
            held.update(index.create_variables({name: variable}))
    told = {"Conventions": CONVENTIONS, "title": title, **(attributes or {})}
    if kind:
        told[RESULT_KIND] = kind
    # The public constructor compares, aligns and copies variables that are known to match. That
    # takes 0.3 ms, as long as simulating a hundred contacts; xarray's internal one skips it.
    names = {*coordinates, *indexes}
    dims: dict[Hashable, int] = {}
    for name, variable in held.items():
        for dim, size in zip(variable.dims, variable.shape, strict=True):
            if dims.setdefault(dim, size) != size:
                raise ValueError(f"{name} must be of size {dims[dim]} along {dim}, got {size}")
    try:
        return xr.Dataset._construct_direct(held, names, dims, told, indexes)
    except (AttributeError, TypeError):  # another version of xarray
        plain = {name: variable for name, variable in held.items() if name not in names}
        return xr.Dataset(plain, {name: held[name] for name in names}, told)


def spread(
    dataset: xr.Dataset, names: Iterable[str], like: xr.DataArray
) -> dict[str, npt.NDArray[Any]]:
    """Return those of the named variables that there are, by name, on the dimensions of another."""
    return {
        name: dataset[name].broadcast_like(like).transpose(*like.dims).values
        for name in names
        if name in dataset.variables
    }


def origin_of(dataset: xr.Dataset) -> dict[str, object]:
    """Return the attributes that derived results inherit: all but title and kind."""
    own = {"title", RESULT_KIND}
    return {str(name): value for name, value in dataset.attrs.items() if name not in own}


def check_as_computed(name: str, dataset: xr.Dataset) -> None:
    """Raise `InputError` for a result in SI units, or with words in place of flags."""
    if "length_scale" in dataset.attrs:
        raise InputError(
            f"{name} must be dimensionless, got one in SI units: convert the result instead"
        )
    for flag, variable in dataset.variables.items():
        if variable.dtype.kind in "UO" and flag in QUANTITIES and QUANTITIES[str(flag)].flags:
            raise InputError(
                f"{name} must have its flags as numbers, got words in {flag}: give the result from "
                "before decode_flags"
            )
