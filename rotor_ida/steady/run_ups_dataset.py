"""The dataset of many run-ups: what each meets and ends on, and the fractions of the endings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import get_type_hints

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, State
from rotor_ida.model.parameters import Rotor
from rotor_ida.results.provenance import provenance
from rotor_ida.results.studies.arrays import Arrays
from rotor_ida.results.studies.results import Form
from rotor_ida.schema import (
    ENDING,
    ENDS_IN_WORDS,
    RESPONSE,
    STATUS,
    Column,
    labelled,
    labelled_dataset,
)
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import FAILED
from rotor_ida.steady.passage import Met, Passage, Passed
from rotor_ida.steady.ramps import Places
from rotor_ida.steady.sweep_dataset import FEATURES, Pieces, Rows, columns_of

MET = tuple(each.name for each in fields(Met))
# What only friction, or contact damping, has to tell.
OF_FRICTION, OF_CONTACT_DAMPING = ("first_roll_speed", "total_heat"), ("total_contact_loss",)
COLUMNS: dict[str, type[np.generic]] = {
    "ending": np.int8,
    "response": np.int8,
    **{name: np.int64 if kind is int else np.float64 for name, kind in get_type_hints(Met).items()},
    **dict.fromkeys(FEATURES, np.float64),
    "status": np.int8,
}
# The dimensions over which the endings are counted.
COUNTED = ("phase", "start")


@dataclass(frozen=True)
class RunUps:
    """All run-ups, by number.

    Parameters
    ----------
    axes : mapping of str to ndarray
        The values of ``omega``, ``zeta``, ``delta0``, of what else is not the default, and of
        ``rate`` and ``phase`` [1].
    to : float
        The speed at the end of the ramps [1].
    starts : sequence of tuple of float
        The starts ``(x, y, vx, vy)`` [1].
    options : Options
        How to simulate.
    numbers : frozenset of str
        Parameters beyond the paper's that were given as a number: they are no dimension.
    """

    axes: Mapping[str, Values]
    to: float
    starts: Sequence[State]
    options: Options
    numbers: frozenset[str] = frozenset()

    length = 1

    @property
    def shape(self) -> tuple[int, ...]:
        """Numbers of values on each axis, and of starts."""
        return (*(axis.size for axis in self.axes.values()), len(self.starts))

    @property
    def points(self) -> int:
        """Number of run-ups."""
        return int(np.prod(self.shape))

    def job(self, number: int) -> Passage:
        """Return what a worker needs to follow a run-up."""
        *places, start = (int(each) for each in np.unravel_index(number, self.shape))
        axes = zip(self.axes.items(), places, strict=True)
        given = {name: float(axis[place]) for (name, axis), place in axes}
        rate, phase = given.pop("rate"), given.pop("phase")
        return Passage(Rotor(**given), self.to, rate, phase, self.starts[start], self.options)

    def slowest_first(self) -> Places:
        """Return the numbers of the run-ups, those at the lowest rates first."""
        rates = self.axes["rate"][
            np.unravel_index(np.arange(self.points), self.shape)[[*self.axes].index("rate")]
        ]
        return np.argsort(np.abs(rates), kind="stable")


def rows_of(passed: Passed) -> Rows:
    """Return a passage as a row."""
    values = asdict(passed.met) | asdict(passed.features)
    values |= {"ending": ENDING[passed.ending], "response": RESPONSE[passed.response]}
    values["status"] = STATUS["failed" if passed.response == FAILED else "done"]
    columns = {name: np.array([values[name]], dtype=kind) for name, kind in COLUMNS.items()}
    return Rows(dict(columns), [passed.message])


def run_ups_dataset(run_ups: RunUps, pieces: Pieces, folder: Path | None = None) -> xr.Dataset:
    """Return run-ups as a labelled dataset; `pieces` and `folder` as for a sweep."""
    numbers = {name: run_ups.axes[name][0] for name in run_ups.numbers}
    every = (*run_ups.axes, "start")
    dims = [name for name in every if name not in numbers]
    shape = [size for name, size in zip(every, run_ups.shape, strict=True) if name not in numbers]
    coordinates: dict[str, Column | xr.Variable] = {
        name: ((), axis[0]) if name in numbers else (name, axis)
        for name, axis in run_ups.axes.items()
    }
    coordinates["rate"] = rate = labelled("rate", "rate", run_ups.axes["rate"])
    rate.attrs["long_name"] = "change of the spin speed in a unit of time"
    coordinates |= {"to": ((), run_ups.to), "start": ("start", np.arange(len(run_ups.starts)))}
    for name, column in zip(COMPONENTS, np.array(run_ups.starts).T, strict=True):
        coordinates[f"start_{name}"] = ("start", column.copy())
    columns = columns_of(COLUMNS, pieces, run_ups.points, folder)
    for name in _never_told(run_ups):
        del columns[name]
    variables = {
        name: labelled(name, dims, column.reshape(shape)) for name, column in columns.items()
    }
    counted = tuple(dims.index(name) for name in COUNTED)
    left = [name for name in dims if name not in COUNTED]
    endings = columns["ending"].reshape(shape)
    variables |= {
        name: labelled(name, left, values)
        for name, values in fractions_of(endings, counted).items()
    }
    for name in ("radius_min", "radius_max"):
        variables[name].attrs["long_name"] += " at the last speed"
    variables["contact_count"].attrs["long_name"] += " on the ramp"
    variables["largest_force"].attrs["long_name"] += " on the ramp"
    title = "Rotor in a clearance: run-ups over a range of speeds"
    how = provenance(run_ups.options.attributes())
    return labelled_dataset(title, variables, coordinates, how, kind="run_ups")


def fractions_of(
    endings: npt.NDArray[np.generic], counted: tuple[int, ...]
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the fractions of the endings over some axes, of those that did not fail.

    The standard error of a fraction p of n run-ups is ``sqrt(p (1 - p)/n)``.

    Examples
    --------
    >>> found = fractions_of(np.array([[3, 2, 3, -1, 3]]), (1,))
    >>> found["whip_fraction"], found["whip_fraction_error"].round(6), found["failed_count"]
    (array([0.75]), array([0.216506]), array([1]))
    """
    failures = (endings == ENDING["failed"]).sum(axis=counted)
    total = np.prod([endings.shape[axis] for axis in counted], dtype=np.int64) - failures
    found: dict[str, npt.NDArray[np.generic]] = {"failed_count": failures}
    for word in ENDS_IN_WORDS:
        count = (endings == ENDING[word]).sum(axis=counted)
        fraction = np.divide(count, total, out=np.full(total.shape, np.nan), where=total > 0)
        found[f"{word}_fraction"] = fraction
        spread = fraction * (1.0 - fraction)
        found[f"{word}_fraction_error"] = np.sqrt(
            np.divide(spread, total, out=np.full(total.shape, np.nan), where=total > 0)
        )
    return found


def _never_told(run_ups: RunUps) -> tuple[str, ...]:
    """Return the columns that none of the rotors has anything in."""
    names: tuple[str, ...] = ()
    for parameter, told in (("friction", OF_FRICTION), ("contact_damping", OF_CONTACT_DAMPING)):
        axis = run_ups.axes.get(parameter)
        if axis is None or not axis.any():
            names += told
    return names


def _as_arrays(rows: Rows) -> Arrays:
    # each array has a header, which a table of columns has only once
    table = np.empty(len(rows.messages), dtype=list(COLUMNS.items()))
    for name in COLUMNS:
        table[name] = rows.columns[name]
    return {"messages": np.array(rows.messages, dtype=str), "run_ups": table}


def _from_arrays(tables: Arrays) -> Rows:
    return Rows({name: tables["run_ups"][name] for name in COLUMNS}, tables["messages"].tolist())


FORM = Form("run-up", _as_arrays, _from_arrays)
