"""Print datasets by dimension: rows for programs, tables and words for people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.results.sheets import Line, Parts, Range, Sheet, facts, table
from rotor_ida.results.si_units import si_of
from rotor_ida.schema import NO_YES, RESULT_KIND, along, flags_of, unit_of, words_of
from rotor_ida.units import SPEED_UNITS

Record = dict[str, object]
Description = tuple[Record, Parts]
METHOD = ("method", "flight", "backend", "rtol", "atol")
VERSION = "_version"
# Attributes for internal use, or shown as the kind.
HOUSEKEEPING = ("Conventions", "content_sha256", "rotor_ida_format", RESULT_KIND)

# Words for variables whose names say too little.
WORDS = {
    "standstill_time": "below 1 % of the speed at the drop from",
    "excursion": "largest radius over clearance", "contact_count": "number of contacts",
    "total_contact_time": "time in contact", "longest_contact_time": "longest contact",
    "mean_contact_force": "mean force in contact", "total_impulse": "impulse of all contacts",
    "largest_impulse": "largest impulse of a contact",
    "node_clearance": "clearance", "node_excursion": "largest radius over clearance",
    "total_contact_loss": "loss by contact damping", "total_heat": "heat of friction",
    "rest_time": "in contact to the end from", "first_roll_time": "first rolling at",
    "largest_force_time": "largest force at", "race_speed_time": "largest race speed at",
    "whirl_turns": "turns of the longest whirl", "load_ratio": "largest force over load capacity",
    "horizon": "determined by the parameters up to",
}  # fmt: skip
# Speeds of whirls and of lines of spectra, which are read in Hz.
IN_HERTZ = ("frequency", "bandwidth", "whirl_speed", "hopf_frequency")
# Units of a result in SI units, whose angles are read in degrees.
IN_SI = ("m", "um", "s", "s-1")
# Digits of an estimated error.
OF_ERROR = 3
# Most rows of a table in the record; for a larger result it has sums and ranges only.
MOST_TOLD = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Rows:
    """A table of a result, along the dimensions of one of its variables.

    The record has all variables along these dimensions, the table only the named ones.

    Parameters
    ----------
    title, key : str
        Name of the table, and of the rows in the record.
    lead : str
        The variable that gives the dimensions.
    names : tuple of str
        The columns, in order. Those missing from a dataset are left out.
    prefix : str
        Prefix omitted from the column heads.
    digits : int
        Number of digits.
    gaps : bool
        Whether to leave out rows whose lead is NaN.
    falling : bool
        Whether to sort the rows by the lead, the largest first.
    on_request : bool
        Whether to print the table only if a number of rows is requested, without columns that are
        empty in all rows. The record omits it if it has more than `MOST_TOLD` rows.
    """

    title: str
    key: str
    lead: str
    names: tuple[str, ...]
    prefix: str = ""
    digits: int = 8
    gaps: bool = False
    falling: bool = False
    on_request: bool = False

    def of(self, dataset: xr.Dataset) -> list[Record]:
        """Return the rows of a dataset, for its record."""
        lead = dataset[self.lead]
        if self.on_request and lead.size > MOST_TOLD:
            return []
        dims = [str(dim) for dim in lead.dims]
        there = [self.lead, *(name for name in self.names if name in dataset or name in dims)]
        there += [*names_on(dataset, *dims), *(dim for dim in dims if dim in dataset.coords)]
        there = [name for name in dict.fromkeys(there) if set(dataset[name].dims) <= set(dims)]
        rows = rows_of(dataset, there)
        values = lead.values.ravel()
        order = np.argsort(-values, kind="stable") if self.falling else np.arange(values.size)
        if self.gaps:
            order = order[lead.notnull().values.ravel()[order]]
        return [rows[place] for place in order.tolist()]

    def table(self, dataset: xr.Dataset, rows: list[Record], most: int | None) -> Parts:
        """Return the table of the rows of a dataset."""
        if self.on_request and (most is None or not rows):
            return []
        names = [name for name in self.names if rows and name in rows[0]]
        if self.on_request:
            names = [name for name in names if any(_says(row[name]) for row in rows)]
        lines = [line_of(dataset, name, [row[name] for row in rows[:most]], self.digits)
                 for name in names]  # fmt: skip
        prefix = self.prefix.replace("_", " ")
        lines = [replace(each, name=each.name.removeprefix(prefix)) for each in lines]
        return [Sheet(title, lines) if rows else title
                for title in [counted(self.title, len(rows), most)]]  # fmt: skip


@dataclass(frozen=True, slots=True)
class Layout:
    """Description of a kind of result: its numbers, and tables along its dimensions."""

    title: str
    tables: tuple[Rows, ...]

    def __call__(self, dataset: xr.Dataset, most: int | None) -> Description:
        """Return the record of a dataset and its tables."""
        record, parts = tabled(dataset, most, *self.tables)
        parameters = parameters_in(dataset).items()
        numbers = {name: each for name, each in parameters if not isinstance(each, list)}
        told = lines_of(dataset, numbers | scalars_of(dataset))
        return record, [facts(self.title, told), *parts] if told else parts


def show_by_dimension(dataset: xr.Dataset, most: int | None) -> Description:
    """Return the variables of a dataset, its numbers, and tables along each of its dimensions."""
    variables: list[Record] = [
        {
            "name": str(name),
            "long_name": str(variable.attrs.get("long_name", "")),
            "units": str(variable.attrs.get("units", "")),
            "dimensions": " ".join(str(dim) for dim in variable.dims),
        }
        for name, variable in dataset.variables.items()
    ]
    layout = Layout("Numbers", tuple(_along(dataset, dims) for dims in _dimensions(dataset)))
    record, parts = layout(dataset, most)
    title = counted("Variables", len(variables), None)
    listed = table(title, variables, list(variables[0])) if variables else title
    return {**record, "variables": variables}, [listed, *parts]


def _dimensions(dataset: xr.Dataset) -> list[tuple[str, ...]]:
    """Return the dimensions of variables with few enough values to print."""
    variables = dataset.data_vars.variables.values()
    shapes = [each.dims for each in variables if each.size <= MOST_TOLD]
    return [tuple(map(str, dims)) for dims in dict.fromkeys(shapes) if dims]


def _along(dataset: xr.Dataset, dims: tuple[str, ...]) -> Rows:
    """Return the rows of all variables along some dimensions, after the coordinates."""
    known = [name for name in (*ALL_PARAMETERS, *dims) if name in dataset.coords]
    places = [name for name in dict.fromkeys(known) if dataset[name].dims]
    names, words = names_on(dataset, *dims), ", ".join(dims)
    return Rows(
        title=f"Along {words}",
        key=f"along {words}",
        lead=names[0],
        gaps=True,
        names=(*places, *names),
    )


def tabled(dataset: xr.Dataset, most: int | None, *tables: Rows) -> Description:
    """Return the record of a dataset, and the tables whose variables it has."""
    there = [each for each in tables if each.lead in dataset.variables]
    rows = {each.key: each.of(dataset) for each in there}
    record: Record = {
        "parameters": parameters_in(dataset),
        **scalars_of(dataset),
        **rows,
        **about(dataset),
    }
    return record, [part for each in there for part in each.table(dataset, rows[each.key], most)]


def line_of(dataset: xr.Dataset, name: str, values: Sequence[object], digits: int = 8) -> Line:
    """Return values of a variable as a line; parameters of machines in SI units."""
    if name.endswith(("_error", "_defect", "residual")):
        digits = OF_ERROR
    known = si_of(dataset, name)
    if known is not None:
        words, _, unit = known[0].removesuffix("]").partition(" [")
        return Line(words, [_times(known[1], each) for each in values], unit, digits)
    words, unit = WORDS.get(name, name.replace("_", " ")), _unit_of(dataset, name)
    if unit == "rad/s" and name in IN_HERTZ:
        return Line(words, [_times(1.0 / SPEED_UNITS["Hz"], each) for each in values], "Hz", digits)
    return Line(words, values, unit, digits)


def lines_of(dataset: xr.Dataset, entries: Mapping[str, object]) -> list[Line]:
    """Return values of variables as lines, one each."""
    return [line_of(dataset, name, [value]) for name, value in entries.items()]


def _unit_of(dataset: xr.Dataset, name: str) -> str:
    """Return the unit of a variable."""
    if name == "duration" and name not in dataset.variables:
        name = "t"
    if name not in dataset.variables:
        return str(dataset.attrs.get("start_units", "1")) if name == "start" else "1"
    unit = unit_of(name, str(dataset[name].attrs.get("units", "1")))
    if unit == "s-1" and (name == "to" or name.endswith("_speed")):
        return "rad/s"
    if unit == "radian" and not is_in_si(dataset):
        return "rad"
    return "rad/s2" if (name, unit) == ("rate", "s-2") else unit


def is_in_si(dataset: xr.Dataset) -> bool:
    """Return whether a result has units."""
    return any(str(each.attrs.get("units")) in IN_SI for each in dataset.variables.values())


def _times(factor: float, value: Any) -> Any:
    """Return numbers times a factor, also in lists and ranges; other values are unchanged."""
    if isinstance(value, Range):
        return Range(factor * each for each in value)
    if isinstance(value, list):
        return [_times(factor, each) for each in value]
    return value * factor if isinstance(value, float) else value


def scalars_of(dataset: xr.Dataset) -> Record:
    """Return the variables without dimensions, parameters aside."""
    return {name: value_of(dataset, name) for name in names_on(dataset)}


def rows_of(dataset: xr.Dataset, names: Sequence[str]) -> list[Record]:
    """Return one record for each element of the first named variable, broadcasting the others.

    Flags become words, or true and false if the words are yes and no.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=[0.5, 1.0], zeta=0.5, delta0=2.0)
    >>> rows_of(whirls, ["stability", "omega"])
    [{'stability': 'neutral', 'omega': 0.5}, {'stability': 'neutral', 'omega': 1.0}]
    """
    if not names:
        return []
    first = dataset[names[0]]
    columns = [values_of(along(dataset[name].variable, first.sizes), name) for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def value_of(dataset: xr.Dataset, name: str) -> object:
    """Return a scalar variable, in words if it is a flag."""
    (value,) = values_of(dataset[name])
    return value


def names_on(dataset: xr.Dataset, *dims: str) -> list[str]:
    """Return the variables with exactly these dimensions."""
    variables = dataset.data_vars.variables  # quicker than arrays with their coordinates
    return [str(name) for name, variable in variables.items() if variable.dims == dims]


def attributes_of(dataset: xr.Dataset) -> Record:
    """Return the origin of a dataset: method, versions and other attributes."""
    plain = {
        str(name): value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value
        for name, value in dataset.attrs.items()
        if name not in HOUSEKEEPING
    }
    record: Record = {}
    method = {name: plain.pop(name) for name in METHOD if name in plain}
    versions = {
        name.removesuffix(VERSION): plain.pop(name)
        for name in list(plain)
        if name.endswith(VERSION)
    }
    if method:
        record["method"] = method
    if versions:
        record["versions"] = versions
    return {**plain, **record}


def about(dataset: xr.Dataset) -> Record:
    """Return the attributes of a dataset other than its parameters."""
    attributes = attributes_of(dataset)
    return {name: entry for name, entry in attributes.items() if name not in ALL_PARAMETERS}


def parameters_in(dataset: xr.Dataset) -> Record:
    """Return the parameters of a result, each as a number or, along an axis, as a list."""
    told = [name for name in ALL_PARAMETERS if name in dataset.variables]
    return {name: dataset[name].values.tolist() for name in told}


def span(values: np.ndarray[Any, Any]) -> Range | str:
    """Return the range of the finite values; empty if there are none."""
    known = values[np.isfinite(values)]
    return Range((float(known.min()), float(known.max()))) if known.size else ""


def counted(title: str, count: int, most: int | None) -> str:
    """Return the title of a table with a number of rows, of which at most some are shown."""
    if most is not None and count > most:
        return f"{title}: first {most} of {count} (all with --json)"
    return f"{title}: {count or 'none'}"


def values_of(variable: xr.DataArray | xr.Variable, name: str | None = None) -> list[Any]:
    """Return the values of a variable as a flat list, in words if it is a flag."""
    if "flag_meanings" not in variable.attrs:
        return list(variable.values.ravel().tolist())
    words = words_of(variable, name)
    return [word == "yes" for word in words] if flags_of(variable) == NO_YES else words


def _says(value: object) -> bool:
    nothing = isinstance(value, float) and math.isnan(value)
    return not nothing and value not in {"", "done", "from_start"}
