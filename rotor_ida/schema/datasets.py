"""Labelled datasets: their variables have long names and units, from the one table."""

from __future__ import annotations

import math
import re
from collections.abc import Hashable, Iterable, Mapping, Sequence
from functools import lru_cache
from numbers import Real
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr
from xarray.indexes import Index, PandasIndex

from rotor_ida.arrays import Column
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.schema.flags import check_flags
from rotor_ida.schema.quantities import OTHER_UNITS, QUANTITIES, UNITS
from rotor_ida.units import dimension_of

CONVENTIONS = "CF-1.11"
# Attribute with the kind of result of a dataset, a row of `rotor_ida.results.dataset_kinds`.
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
    row of `rotor_ida.results.dataset_kinds`; results of this package always have one.

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
        name: column if isinstance(column, xr.Variable) else labelled(name, *column)
        for name, column in {**variables, **coordinates}.items()
    }
    indexes: dict[Hashable, Index] = {
        name: PandasIndex(variable.values, name, variable.dtype)
        for name, variable in held.items()
        if variable.dims == (name,)
    }
    for index in indexes.values():
        held |= index.create_variables(held)
    # all as coordinates at first: the constructor of a dataset would align and compare variables
    dataset = (
        xr.Coordinates(held, indexes)
        .to_dataset()
        .reset_coords([name for name in variables if name not in indexes])
    )
    dataset.attrs = {"Conventions": CONVENTIONS, "title": title, **(attributes or {})}
    if kind:
        dataset.attrs[RESULT_KIND] = kind
    return dataset


def spread(
    dataset: xr.Dataset, names: Iterable[str], like: xr.DataArray
) -> dict[str, npt.NDArray[Any]]:
    """Return those of the named variables that there are, by name, on the dimensions of another."""
    return {
        name: along(dataset.variables[name], like.sizes).values
        for name in names
        if name in dataset.variables
    }


def along(variable: xr.Variable, sizes: Mapping[Hashable, int]) -> xr.Variable:
    """Return a variable broadcast to these dimensions; quicker than an array with coordinates."""
    found: xr.Variable = variable.set_dims(sizes)  # type: ignore[no-untyped-call]
    return found


def origin_of(dataset: xr.Dataset) -> dict[str, object]:
    """Return the attributes that derived results inherit: all but title and kind."""
    own = {"title", RESULT_KIND}
    return {str(name): value for name, value in dataset.attrs.items() if name not in own}


def check_variables(name: str, dataset: xr.Dataset) -> None:
    """Raise `InputError` for a variable of a result that is not what `QUANTITIES` says.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    >>> check_variables("whirls", whirls.assign(amplitude=whirls.amplitude.astype(str)))
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: amplitude of whirls must be real numbers, got <U32
    """
    for each, variable in dataset.variables.items():
        what, quantity = f"{each} of {name}", QUANTITIES.get(str(each))
        for told in ("units", "long_name"):
            if not isinstance(variable.attrs.get(told, ""), str):
                word = shown(variable.attrs[told])
                raise InputError(f"{told} of {what} must be text, got {word}")
        if quantity is None:
            continue
        _check_unit(str(each), name, str(variable.attrs.get("units", "1")))
        if quantity.is_text:
            if not _is_text(variable):
                raise InputError(f"{what} must be text, got {variable.dtype}")
        elif quantity.flags and variable.dtype.kind in "UO":
            raise InputError(
                f"{name} must have its flags as numbers, got words in {each}: give the result from "
                "before decode_flags"
            )
        elif variable.dtype.kind not in "iuf" and not _is_real(variable):
            raise InputError(f"{what} must be real numbers, got {variable.dtype}")
        elif "flag_meanings" in variable.attrs:
            check_flags(what, variable)


def _check_unit(variable: str, name: str, unit: str) -> None:
    """Refuse a unit of another kind, such as kg for a length."""
    quantity, given = QUANTITIES[variable], _dimension(unit)
    allowed = UNITS.get(quantity.scale, OTHER_UNITS.get(variable, quantity.units))
    if quantity.units and given is not None and given != _dimension(allowed):
        raise InputError(
            f"units of {variable} of {name} must be 1 or of the kind {allowed}, got {shown(unit)}"
        )


@lru_cache(maxsize=256)
def _dimension(unit: str) -> tuple[float, ...] | None:
    """Return exponents of kg, m and s, as a radian has none; None for text that is no unit."""
    found = dimension_of(re.sub(r"J\b", "N m", unit))
    return None if found is None or not any(found[:3]) else found[:3]


def _is_real(variable: xr.Variable) -> bool:
    """Return whether objects are real numbers, such as fractions."""
    return variable.dtype.kind == "O" and all(
        isinstance(value, Real) and not isinstance(value, bool)
        for value in variable.values.ravel().tolist()
    )


def _is_text(variable: xr.Variable) -> bool:
    """Return whether a variable is text, with NaN where one is missing."""
    if variable.dtype.kind != "O":
        return variable.dtype.kind in "UT"
    values = variable.values.ravel().tolist()
    return all(
        isinstance(value, str) or (isinstance(value, float) and math.isnan(value))
        for value in values
    )


def check_as_computed(name: str, dataset: xr.Dataset) -> None:
    """Raise `InputError` for a result in SI units, or with words in place of flags."""
    if "length_scale" in dataset.attrs:
        raise InputError(
            f"{name} must be dimensionless, got one in SI units: convert the result instead"
        )
    check_variables(name, dataset)
