"""An atlas as a labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.basins.atlas.cells import Cell, Member
from rotor_ida.basins.atlas.effects import effects_of
from rotor_ida.basins.atlas.extents import varied
from rotor_ida.basins.atlas.resilience import Resilience
from rotor_ida.basins.atlas.shocks import KINDS
from rotor_ida.basins.attractors import reported, witness_options
from rotor_ida.basins.dataset import ENTROPIES, agreement_of
from rotor_ida.basins.following import followed_by, labelled_how
from rotor_ida.basins.subjects import Subjects
from rotor_ida.checks import COMPONENTS
from rotor_ida.model.rotor import Rotor
from rotor_ida.results.provenance import provenance
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import (
    END,
    RESPONSE,
    TRAPPING,
    WHIRL_DIRECTION,
    WITH_EXTENTS,
    Column,
    labelled_dataset,
)
from rotor_ida.steady.points import VariedSystem, with_meanings

# Largest probability that the sample misses an attractor with more than `missed_fraction`.
RISK = 0.05
# Lower and upper end of the values of a parameter at which an attractor exists.
SIDES = ("low", "high")
# Dimensions of the numbers of an attractor of a rotor system besides the attractor.
BEHIND = {
    **VariedSystem.behind, **dict.fromkeys(("excursion", "mean_force"), ("contact",)),
    **dict.fromkeys(("contacts_per_revolution", "contact_fraction"), ("contact",)),
    **dict.fromkeys(("contact_loss_per_revolution", "heat_per_revolution"), ("contact",)),
    **dict.fromkeys(("slip_distance_per_revolution", "rolling_fraction"), ("contact",)),
    **dict.fromkeys(("whirl_over_spin", "whirl_sense", "side_line_over_spin"), ("node",)),
    **{f"{kind}_shock_{when}": ("component",) for kind in KINDS for when in ("before", "after")},
}  # fmt: skip
# Numbers of an attractor and of a rotor that add nothing to a report.
LEFT_OUT = ("count", "phase_lag", "not_computed_count")
# Fill values where there is no such attractor; other columns use NaN.
FLAGS = {
    "touched": 0,
    "whirl_sense": WHIRL_DIRECTION["none"],
    "kind": RESPONSE["not_found"],
    "trapping": TRAPPING["none"],
    **{f"{name}_{side}_end": END["not_found"] for name in WITH_EXTENTS for side in SIDES},
}


def atlas_dataset(
    subjects: Subjects, cells: Sequence[Cell], starts: int, attributes: Mapping[str, object], *,
    is_report: bool = False,
) -> xr.Dataset:  # fmt: skip
    """Return the attractors over the parameters; `starts` is the number of starts of each rotor.

    A report of one point also has what each attractor does, and the states at shocks.
    """
    grid, system = subjects.varied, subjects.varied.system
    members = [each for cell in cells for each in cell.members]
    count = 1 + max((each.identity for each in members), default=-1)
    columns = _columns(cells, count, starts, is_report=is_report)
    coordinates = {**subjects.coordinates, "attractor": ("attractor", np.arange(count))}
    if any(each.resilience is not None for each in members):
        columns |= _shocks(cells, count, is_report=is_report)
        coordinates["target"] = ("target", np.arange(count))
    of_cells = [_of_cell(each, starts) for each in cells]
    columns |= {name: np.array([each[name] for each in of_cells]) for name in of_cells[0]}
    variables: dict[str, Column] = {}
    for name, column in columns.items():
        own = column.shape[1:]  # along the attractors, and of shocks along their targets
        behind = () if system is None else BEHIND.get(name, ())
        dims = (*grid.dims, *("attractor", "target")[: len(own) - len(behind)], *behind)
        variables[name] = (dims, column.reshape((*grid.shape, *own)))
    variables["missed_fraction"] = ((), missed_fraction(starts))
    title = "Touchdown report" if is_report else "attractors and the fractions of starts on each"
    if not is_report:
        title = f"{'Rotor in a clearance' if system is None else 'Rotor system'}: {title}"
    kind = f"{'' if system is None else 'system_'}{'touchdown' if is_report else 'atlas'}"
    found = labelled_dataset(title, variables, coordinates, _flat(attributes), kind=kind)
    if is_report:
        found = found.drop_vars(LEFT_OUT)
    return found if system is None else with_meanings(with_system_units(found, system), grid)


def _of_cell(cell: Cell, starts: int) -> dict[str, float]:
    """Return the numbers of a rotor that are of no attractor."""
    return {
        "undecided_fraction": cell.undecided / max(starts - cell.not_computed, 1),
        "not_computed_count": cell.not_computed,
        **dict(zip(ENTROPIES, cell.entropies, strict=True)), **agreement_of(cell.rechecked),
    }  # fmt: skip


def how_computed(rtol: float, shocks: int, subjects: Subjects) -> dict[str, object]:
    """Return, as attributes, the methods for starts and, if any were tried, for shocks."""
    first = subjects.points[0]
    disc = first if isinstance(first, Rotor) else None
    how = labelled_how(rtol, disc)
    if shocks and disc is not None:
        how |= followed_by("witness", witness_options())
    return {**provenance(how), "shocks": shocks}


def missed_fraction(starts: int) -> float:
    """Return the fraction that an attractor may have and still be missed by this many starts."""
    return float(1.0 - RISK ** (1.0 / starts))


def member_row(cell: Cell, member: Member, starts: int) -> dict[str, Any]:
    """Return the numbers of an attractor by name; `starts` is the number of starts."""
    own, computed = member.row, starts - cell.not_computed
    row: dict[str, Any] = {"kind": own["response"]}
    row |= {name: own[name] for name in reported(own.dtype)}
    part = member.count / computed if computed else math.nan
    error = math.sqrt(part * (1.0 - part) / computed) if computed else math.nan
    row |= {"count": member.count, "fraction": part, "fraction_error": error}
    row["settling_median"], row["settling_95"] = member.settling.tolist()
    if member.resilience is not None and isinstance(cell.rotor, Rotor):
        row |= _resilience_row(cell.rotor, member.resilience)
    return row


def _resilience_row(rotor: Rotor, told: Resilience) -> dict[str, float]:
    bounds = [f"{kind}_shock_bound" for kind in KINDS]
    extents = [f"{name}_{side}" for name in varied(rotor) for side in SIDES]
    return {
        **dict(zip(bounds, told.bounds.tolist(), strict=True)),
        **dict(zip(extents, told.extents.ravel().tolist(), strict=True)),
        **dict(zip([f"{name}_end" for name in extents], told.ends.ravel().tolist(), strict=True)),
    }


def column_of(name: str, shape: tuple[int, ...]) -> npt.NDArray[np.generic]:
    """Return an empty column: of these numbers, with those of a contact or node behind."""
    if name in FLAGS:
        return np.full(shape, FLAGS[name], dtype=np.int8)
    return np.zeros(shape, dtype=np.int64) if name == "count" else np.full(shape, np.nan)


def _columns(
    cells: Sequence[Cell], count: int, starts: int, *, is_report: bool
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the numbers of each attractor of each rotor, shape (cells, count)."""
    columns: dict[str, npt.NDArray[np.generic]] = {}
    for place, cell in enumerate(cells):
        for each in cell.members:
            row = member_row(cell, each, starts)
            if is_report:
                row |= effects_of(cell.rotor, each.row)
            for name, value in row.items():
                if name not in columns:
                    columns[name] = column_of(name, (len(cells), count, *np.shape(value)))
                columns[name][place, each.identity] = value
    return columns


def _shocks(
    cells: Sequence[Cell], count: int, *, is_report: bool
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the smallest shocks from each attractor to each, shape (cells, count, count)."""
    columns: dict[str, npt.NDArray[np.generic]] = {}
    for place, cell in enumerate(cells):
        numbers = [each.identity for each in cell.members]
        for each in cell.members:
            if each.resilience is None:
                continue
            for name, values in _shocks_of(cell, each.resilience, is_report=is_report).items():
                if name not in columns:
                    shape = (len(cells), count, count, *values.shape[1:])
                    columns[name] = np.full(shape, np.nan)
                columns[name][place, each.identity, numbers[: len(values)]] = values
    if is_report:
        for kind, largest in zip(KINDS, cells[0].largest_shocks, strict=True):
            columns[f"{kind}_shock_largest"] = np.array([largest])
    return columns


def _shocks_of(cell: Cell, told: Resilience, *, is_report: bool) -> dict[str, Values]:
    """Return the shocks from an attractor to each, and in a report the states at them."""
    found: dict[str, Values] = {}
    for row, kind in enumerate(KINDS):
        found |= {f"{kind}_shock": told.sizes[row], f"{kind}_shock_scatter": told.scatter[row]}
        for when, states in (("before", told.before), ("after", told.after)):
            name = f"{kind}_shock_{when}"
            if is_report and isinstance(cell.rotor, Rotor):
                pairs = zip(COMPONENTS, states[row].T, strict=True)
                found |= {f"{name}_{component}": each for component, each in pairs}
            elif is_report:
                found[name] = states[row]
    return found


def _flat(attributes: Mapping[str, object]) -> dict[str, object]:
    """Return attributes that an archive can store: tables of starts row after row."""
    return {
        name: np.ravel(np.asarray(value, dtype=np.float64)) if isinstance(value, list) else value
        for name, value in attributes.items()
    }
