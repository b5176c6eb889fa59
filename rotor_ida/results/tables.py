"""A result as tables: one for single numbers, and one for each set of dimensions.

Contacts and nodes are columns of the table of what varies, so that it has one row for each point.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, OF_MACHINE
from rotor_ida.model.scales import IS_OF_MACHINE, unit_scale
from rotor_ida.results.archived_system import NAMES, NEEDED
from rotor_ida.results.files import already_there, check_target, file_to_write
from rotor_ida.results.si_units import machine_of
from rotor_ida.schema import RESULT_KIND, words_of

# A pandas DataFrame; pandas has no annotations.
Table = Any

ENDING = ".csv"
# Name of the table of variables without dimensions.
NUMBERS = "numbers"
# Dimensions of what belongs to one point, with the variable that names each.
PARTS = {
    "contact": "contact_node", "node": "node", "exponent": "exponent", "multiplier": "multiplier",
}  # fmt: skip


# Dimensions of what a result is computed again from, which stays in its archive.
COMPUTED_FROM = {
    "freedom", "freedom_too", "assembled_freedom", "coordinate", "component", "axis", "stator",
    "unbalance",
}  # fmt: skip
# Kinds of result that are one point, with what belongs to it.
CYCLES = ("cycle", "system_cycle")
# Dimension of the states of a stroboscopic diagram at a point.
CROSSING = "crossing"


def to_dataframe(dataset: xr.Dataset) -> Table:
    """Return a result as a table for pandas, with one row for each point, sample or branch.

    Parameters
    ----------
    dataset : Dataset
        Any result.

    Returns
    -------
    DataFrame
        The variables on the first dimensions of the result, which are its index; flags are words.
        Those that are on contacts or nodes too have a column for each, such as
        ``radius_max[seal]``, by the name of the node, or by the number of the contact where two
        are at one node; so have Lyapunov exponents and multipliers, by their numbers. A
        limit cycle is one row, without its samples and its spectrum. A
        stroboscopic diagram has a row for each state at each point. Variables on
        other dimensions, such as those of events and of ``component``, are left out.

    Raises
    ------
    InputError
        If the argument is not a dataset, or is empty.

    Examples
    --------
    >>> from rotor_ida import Rotor, sweep
    >>> system = Rotor(omega=2.0, zeta=0.07, delta0=0.5).system()
    >>> table = to_dataframe(sweep(system, speed=[1.5, 1.7]))
    >>> len(table), table["radius_max[disc]"].round(3).tolist(), table.response.tolist()
    (2, [1.326, 1.196], ['synchronous', 'synchronous'])
    """
    result = check_instance("dataset", dataset, xr.Dataset)
    if result.attrs.get(RESULT_KIND) in CYCLES:
        result = result.set_coords(["contact_node"] if "contact_node" in result else [])
        own = {name for name, each in result.data_vars.items() if {*each.dims} <= {*PARTS}}
        result = result[[name for name in result.data_vars if name in own - {*NEEDED, *NAMES}]]
    if not any({*each.dims} - {*PARTS, "component"} for each in result.data_vars.values()):
        result = result.assign({name: each.expand_dims("point")
                                for name, each in result.data_vars.items()})  # fmt: skip
    wide = _with_parts_as_columns(result)
    rows: tuple[Any, ...] = next(
        (each.dims for each in wide.data_vars.values() if each.dims and each.dims[0] not in PARTS),
        (),
    )
    if not rows:
        raise InputError("dataset must contain a variable for a table, got none")
    crossed = (*rows, CROSSING)
    is_crossed = any(each.dims == crossed for each in wide.data_vars.values())
    kept = {rows, crossed} if is_crossed else {rows}
    part = _in_words(wide[[name for name, each in wide.data_vars.items() if each.dims in kept]])
    return part.to_dataframe(dim_order=list(crossed if is_crossed else rows))


def tables_of(dataset: xr.Dataset) -> dict[str, Table]:
    """Return the tables of a dataset by name: its dimensions joined by hyphens.

    Parameters
    ----------
    dataset : Dataset
        Any result.

    Returns
    -------
    dict of str to DataFrame
        For each set of dimensions, the variables and coordinates on them. Headers are names with
        units, flags are words, and rows follow the order of the dimensions. What is on contacts or
        nodes besides has a column for each, as in `to_dataframe`. The table ``numbers`` has one row
        for each variable or coordinate without dimensions. The parameters of machines are in SI
        units too. Matrices and states from which the result is computed again are left out.

    Examples
    --------
    >>> from rotor_ida import folds
    >>> found = folds(zeta=0.07, delta0=0.0)
    >>> {name: list(table.columns) for name, table in tables_of(found).items()}
    {'zeta-delta0-fold': ['zeta', 'delta0', 'fold', 'fold_omega', 'fold_amplitude']}
    """
    own = COMPUTED_FROM - {*dataset.coords}  # the unbalance may be an axis
    left = [name for name, each in dataset.variables.items() if own & {*each.dims}]
    whole = _in_si(dataset.drop_vars(left))
    scalars = [name for name, each in whole.variables.items() if not each.dims]
    tables = {}
    if scalars:
        tables[NUMBERS] = _numbers(whole[scalars])
        whole = whole.drop_vars(scalars)
    whole = _with_parts_as_columns(whole)
    for dims in dict.fromkeys(variable.dims for variable in whole.data_vars.values()):
        names = [name for name, variable in whole.data_vars.items() if variable.dims == dims]
        part = _in_words(whole[names])
        table = part.to_dataframe(dim_order=list(dims)).reset_index()
        tables["-".join(map(str, dims))] = table.rename(columns=lambda name: _head(whole, name))
    return tables


def save_tables(
    dataset: xr.Dataset, path: str | os.PathLike[str], *, overwrite: bool = False
) -> list[Path]:
    """Write a dataset as CSV, numbers to full precision and NaN as an empty cell.

    Parameters
    ----------
    dataset : Dataset
        Any result.
    path : path-like
        The file, if the dataset is one table. If there are several, the name of each comes before
        the suffix: ``run.t.csv``, ``run.event.csv``.
    overwrite : bool
        Whether existing files may be replaced.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    InputError
        If the path does not end in ``.csv``, or a file exists and `overwrite` is false.
    ArchiveError
        If the system refuses to write a file, for example on a full disk.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida import folds
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     (file,) = save_tables(folds(zeta=0.07, delta0=0.0), folder + "/folds.csv")
    ...     print(file.read_text())
    zeta,delta0,fold,fold_omega,fold_amplitude
    0.07,0.0,0,1.5978...
    """
    given = check_tables("path", path, overwrite=overwrite)
    tables = tables_of(dataset)
    paths = [
        given if len(tables) == 1 else given.with_suffix(f".{name}{ENDING}") for name in tables
    ]
    for place, table in zip(paths, tables.values(), strict=True):
        check_target("path", place, overwrite=overwrite)
        with file_to_write(place, overwrite=overwrite) as part:
            table.to_csv(part, index=False)
    return paths


def check_tables(
    name: str, path: object, *, overwrite: bool, permission: str = "overwrite=True"
) -> Path:
    """Return the path of CSV files; raise `InputError` if they cannot be written.

    The tables are not known before the result, so without `overwrite` any existing file that might
    be one of them is refused.
    """
    given = check_target(name, path, overwrite=overwrite, permission=permission)
    if given.suffix != ENDING:
        raise InputError(f"{name} must end in {ENDING}, got {shown(given)}")
    if not overwrite:
        for other in given.parent.iterdir():
            if other.name.startswith(f"{given.stem}.") and other.suffix == ENDING:
                raise already_there(other, permission)
    return given


def _in_si(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result of machines with their parameters in SI units, speeds in rad/s."""
    machine = machine_of(dataset) if "length_scale" in dataset.attrs else None
    if machine is None:
        return dataset
    found = {}
    for name in (each for each in ALL_PARAMETERS if each in dataset.coords):
        own = IS_OF_MACHINE.get(name, name)
        unit = OF_MACHINE[own].unit
        if unit != "1" and (own == name or own not in dataset.variables):
            value = dataset[name].variable * unit_scale(machine, unit)
            found[own] = xr.Variable(value.dims, value.values, {"units": unit})
    return dataset.assign_coords(found)


def _with_parts_as_columns(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result with a variable for each contact, node and so on of what varies besides.

    What belongs to contacts or nodes alone is a table of its own.
    """
    found: dict[str, xr.Variable] = {}
    for name, variable in dataset.variables.items():
        part = next((each for each in PARTS if each in variable.dims), None)
        if part is None or variable.ndim == 1:
            found[str(name)] = variable
        else:
            labels = enumerate(_names_of(dataset, part))
            found |= {f"{name}[{word}]": variable.isel({part: at}) for at, word in labels}
    of_parts = {str(name) for name, each in dataset.coords.items()
                if len(found) > len(dataset.variables) and name not in dataset.dims
                and each.dims in {(part,) for part in PARTS}}  # fmt: skip
    names = {str(name) for name in dataset.coords} - of_parts
    coordinates = {name: each for name, each in found.items() if name.partition("[")[0] in names}
    others = {name: each for name, each in found.items() if name not in coordinates}
    return xr.Dataset(others, coordinates, dataset.attrs)


def _names_of(dataset: xr.Dataset, part: str) -> list[Any]:
    """Return the names of nodes, or of contacts by their nodes; numbers where these are not one."""
    numbers = [*range(dataset.sizes[part])]
    if PARTS[part] not in dataset.variables or dataset[PARTS[part]].dims != (part,):
        return numbers
    names = dataset[PARTS[part]].values.tolist()
    return names if len({*names}) == len(names) else numbers


def _numbers(scalars: xr.Dataset) -> Table:
    described = _in_words(scalars)
    # one by one: an array of numbers would turn counts into floats
    values: npt.NDArray[Any] = np.empty(len(described.variables), dtype=object)
    values[:] = [each.values.item() for each in described.variables.values()]
    attributes = [scalars[name].attrs for name in described.variables]
    columns = {
        "value": values,
        "units": [each.get("units", "") for each in attributes],
        "long_name": [each.get("long_name", "") for each in attributes],
    }
    table = xr.Dataset({name: ("name", each) for name, each in columns.items()},
                       {"name": list(described.variables)})  # fmt: skip
    return table.to_dataframe().reset_index()


def _in_words(dataset: xr.Dataset) -> xr.Dataset:
    """Return a dataset whose flags are words."""
    words = {
        name: (each.dims, np.array(words_of(each), dtype=object).reshape(each.shape))
        for name, each in dataset.data_vars.items()
        if "flag_meanings" in each.attrs
    }
    return dataset.assign(words)


def _head(dataset: xr.Dataset, name: str) -> str:
    """Return a variable's name with its unit, if it has one."""
    unit = dataset[name].attrs.get("units", "1") if name in dataset.variables else "1"
    return name if unit in {"", "1"} else f"{name} [{unit}]"
