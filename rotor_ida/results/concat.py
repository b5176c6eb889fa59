"""Join results along a parameter, with their tables of events."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import check_instance, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import SPEED
from rotor_ida.results.question import QUESTION, Question
from rotor_ida.results.rows import counted, counts_in, own_rows
from rotor_ida.results.si_units import dimensionless
from rotor_ida.schema import flags_of


def concat(datasets: Sequence[xr.Dataset], dim: str) -> xr.Dataset:
    """Join results along a dimension, tables of events included.

    Parameters
    ----------
    datasets : sequence of Dataset
        Results of one kind: sweeps over different speeds, whirls, runs, and so on.
    dim : str
        A dimension of all datasets, such as the ``omega`` of sweeps, or a scalar coordinate that
        differs, such as the ``omega`` of runs, which becomes a dimension.

    Returns
    -------
    Dataset
        As from `xarray.concat` with ``join="outer"``: missing values, such as the third whirl
        where there is only one, are NaN or ``absent``. Two sweeps become one sweep over both.
        Events of runs, which are not in one table, are padded with NaN, flags too. Attributes that
        differ are dropped.

    Raises
    ------
    InputError
        If there is nothing to join, `dim` is not in all datasets, or results with tables of events
        differ in their other dimensions.

    Notes
    -----
    `xarray.concat` joins results without tables of events, such as sweeps without ``events=True``.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> first, second = (
    ...     sweep(omega=omega, zeta=0.07, delta0=2.0, events=True) for omega in ([1.0, 1.5], [2.0])
    ... )
    >>> both = concat([first, second], "omega")
    >>> both.response.sizes["omega"], int(both.event_count.sum()) == both.sizes["event"]
    (3, True)
    """
    if not isinstance(datasets, list | tuple):
        raise InputError(f"datasets must be a list of datasets, got {shown(datasets)}")
    given = [check_instance("datasets", each, xr.Dataset) for each in datasets]
    if not given:
        raise InputError("datasets must contain at least one, got none")
    check_instance("dim", dim, str)
    for each in given:
        if dim not in each.variables:
            raise InputError(f"dim must be in all datasets, got {shown(dim)}, which one lacks")
        if dim not in each.dims and each[dim].ndim:
            on = listed([str(other) for other in each[dim].dims])
            raise InputError(
                f"dim must be a dimension or a scalar, got {shown(dim)}, which is on {on}"
            )
    given = [own_rows(each) for each in given]
    tables = counts_in(given[0])
    if any(counts_in(each) != tables for each in given):
        raise InputError("datasets must be of one kind, got some with a table of events and others")
    for counts in tables:
        _check_one_grid([each[counts] for each in given], dim)
    result = _joined([each.drop_dims(list(tables.values())) for each in given], dim)
    for counts, table in tables.items():
        rows = _rows([each[counts] for each in given], dim)
        for name, variable in given[0].data_vars.items():
            if table in variable.dims:
                values = np.concatenate([each[name].values for each in given])
                result[name] = xr.Variable(variable.dims, values[rows], variable.attrs)
        result = result.assign(counted(counts, result[counts].variable, table))
    return result.assign_attrs(_question(given, result, dim))


def _question(given: Sequence[xr.Dataset], joined: xr.Dataset, dim: str) -> dict[str, str]:
    """Return the question of all results at once; none if theirs differ in more than this axis.

    There is none of a sweep up or down along the axis, where each point begins where another ended,
    nor where something of a whole result, such as a table of attractors, is now along the axis.
    """
    if any((dim in each.dims) != (dim in joined[name].dims) for name, each in given[0].items()):
        return {}
    asked = [Question.of_result(each) for each in given]
    if None in asked:
        return {}
    without_units = {
        own: plain
        for each in given
        for own, plain in zip(np.ravel(each[dim]), np.ravel(dimensionless(each)[dim]), strict=True)
    }
    axis = np.array([without_units[own] for own in joined[dim].values])
    whole = {
        Question(each.verb, {**each.arguments, dim: axis}).text()
        for each in asked
        if each and dim in each.arguments
        and not (each.arguments.get("direction") and each.arguments.get("along", SPEED) == dim)
    }  # fmt: skip
    return {QUESTION: whole.pop()} if len(whole) == 1 else {}


def _check_one_grid(counts: Sequence[xr.DataArray], dim: str) -> None:
    """Refuse results with tables whose other dimensions differ: rows would match no run."""
    try:
        xr.align(*counts, join="exact", exclude=[dim])
    except ValueError as error:
        raise InputError(
            f"datasets with {counts[0].name} must have the same coordinates besides {dim}: {error}"
        ) from None


def _joined(datasets: Sequence[xr.Dataset], dim: str) -> xr.Dataset:
    """Join datasets without tables that several runs share."""
    sizes = [dict(each.sizes) for each in datasets]
    # a dimension without coordinates and of differing size is padded by position
    uneven = {
        str(name)
        for name in datasets[0].dims
        if name not in datasets[0].coords and len({each.get(name) for each in sizes}) > 1
    }
    numbered = [
        each.assign_coords({name: np.arange(each.sizes[name]) for name in uneven})
        for each in datasets
    ]
    fills = {name: _missing(variable) for name, variable in datasets[0].data_vars.items()}
    # a scalar in which the results differ as well, such as the clearance at each node
    differing = [
        str(name)
        for name, first in datasets[0].coords.items()
        if not first.ndim and name != dim
        and all(name in each.coords for each in datasets)
        and not all(first.variable.equals(each[name].variable) for each in datasets)
    ]  # fmt: skip
    return xr.concat(
        numbered, dim, join="outer", coords=differing, compat="override", data_vars="all",
        combine_attrs="drop_conflicts", fill_value=fills,
    ).drop_vars(uneven)  # fmt: skip


def _missing(variable: xr.DataArray) -> float:
    """Return the fill value: that of the flag absent or no, if there is one, else NaN."""
    flags = flags_of(variable) if "flag_meanings" in variable.attrs else {}
    return flags.get("absent", flags.get("no", np.nan))


def _rows(counts: Sequence[xr.DataArray], dim: str) -> npt.NDArray[np.int64]:
    """Return the rows of the concatenated tables in the order of the joined table."""
    ends = np.cumsum(np.concatenate([each.values.ravel() for each in counts]))
    of_each = np.split(ends, np.cumsum([each.size for each in counts])[:-1])
    numbered = [
        xr.Dataset({"count": each, "end": each.copy(data=own.reshape(each.shape))})
        for each, own in zip(counts, of_each, strict=True)
    ]
    joined = xr.concat(numbered, dim, join="exact", coords="minimal", compat="override")
    order = zip(joined["count"].values.flat, joined["end"].values.flat, strict=True)
    return np.concatenate([np.arange(end - count, end) for count, end in order])
