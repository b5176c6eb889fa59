"""An atlas as a labelled dataset."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.basins.atlas.cells import Cell, Member
from rotor_ida.basins.atlas.extents import varied
from rotor_ida.basins.atlas.resilience import Resilience, witness_options
from rotor_ida.basins.atlas.shocks import KINDS
from rotor_ida.basins.dataset import ENTROPIES, agreement_of, followed_by, labelled_how
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.varied import Varied
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import (
    END,
    RESPONSE,
    TRAPPING,
    WHIRL_DIRECTION,
    WITH_EXTENTS,
    Column,
    labelled_dataset,
)
from rotor_ida.steady.system_sweep import OF_CONTACT, OF_NODE

# Largest probability that the sample misses an attractor with more than `missed_fraction`.
RISK = 0.05
# Lower and upper end of the values of a parameter at which an attractor exists.
SIDES = ("low", "high")
# Dimensions of the numbers of an attractor of a rotor system besides the attractor.
BEHIND = {
    **dict.fromkeys((*OF_CONTACT, "touched", "excursion", "mean_force"), ("contact",)),
    **dict.fromkeys(("contacts_per_revolution", "contact_fraction"), ("contact",)),
    **dict.fromkeys(("contact_loss_per_revolution", "heat_per_revolution"), ("contact",)),
    **dict.fromkeys(("slip_distance_per_revolution", "rolling_fraction"), ("contact",)),
    **dict.fromkeys((*OF_NODE, "whirl_over_spin", "whirl_sense"), ("node",)),
    "side_line_over_spin": ("node",), "final_state": ("component",),
}  # fmt: skip
# Fill values where there is no such attractor; other columns use NaN.
FLAGS = {
    "touched": 0,
    "whirl_sense": WHIRL_DIRECTION["none"],
    "kind": RESPONSE["not_found"],
    "trapping": TRAPPING["none"],
    **{f"{name}_{side}_end": END["not_found"] for name in WITH_EXTENTS for side in SIDES},
}


def atlas_dataset(
    grid: Varied, cells: Sequence[Cell[Any, Any]], starts: int, attributes: Mapping[str, object],
    places: Mapping[str, Column] = {},
) -> xr.Dataset:  # fmt: skip
    """Return the attractors over the parameters; `starts` is the number of starts of each rotor.

    `places` are the contacts and nodes of a rotor system.
    """
    members = [each for cell in cells for each in cell.members]
    count = 1 + max((each.identity for each in members), default=-1)
    columns = _columns(cells, count, starts)
    coordinates = {**grid.coordinates, **places, "attractor": ("attractor", np.arange(count))}
    if any(each.resilience is not None for each in members):
        columns |= _shocks(cells, count)
        coordinates["target"] = ("target", np.arange(count))
    over = ("attractor", "target")
    of_cell: dict[str, npt.ArrayLike] = {
        "undecided_fraction": [
            each.undecided / max(starts - each.not_computed, 1) for each in cells
        ],
        "not_computed_count": [each.not_computed for each in cells],
    }
    for place, name in enumerate(ENTROPIES):
        of_cell[name] = [each.entropies[place] for each in cells]
    agreement = [agreement_of(each.rechecked) for each in cells]
    of_cell |= {name: [each[name] for each in agreement] for name in agreement[0]}
    columns |= {name: np.array(values) for name, values in of_cell.items()}
    variables: dict[str, Column] = {}
    for name, column in columns.items():
        own = column.shape[1:]  # along the attractors, and of shocks along their targets
        behind = BEHIND.get(name, ()) if places else ()
        dims = (*grid.dims, *over[: len(own) - len(behind)], *behind)
        variables[name] = (dims, column.reshape(*grid.shape, *own))
    variables["missed_fraction"] = ((), missed_fraction(starts))
    title, told = "attractors and the fractions of starts on each", _flat(attributes)
    if places:
        title = f"Rotor system: {title}"
        return labelled_dataset(title, variables, coordinates, told, kind="system_atlas")
    title = f"Rotor in a clearance: {title}"
    return labelled_dataset(title, variables, coordinates, told, kind="atlas")


def how_computed(tolerance: float, shocks: int, rotor: Rotor) -> dict[str, object]:
    """Return, as attributes, the methods for starts and, if any were tried, for shocks."""
    how = labelled_how(tolerance, rotor)
    if shocks:
        how |= followed_by("witness", witness_options())
    return {**provenance(how), "shocks": shocks}


def missed_fraction(starts: int) -> float:
    """Return the fraction that an attractor may have and still be missed by this many starts."""
    return float(1.0 - RISK ** (1.0 / starts))


def member_row(rotor: object, member: Member[Any], computed: int) -> dict[str, Any]:
    """Return the numbers of an attractor by name; `computed` is the number of computed starts."""
    row = dict(member.attractor.numbers)
    part = member.count / computed if computed else math.nan
    error = math.sqrt(part * (1.0 - part) / computed) if computed else math.nan
    row |= {"count": member.count, "fraction": part, "fraction_error": error}
    row["settling_median"], row["settling_95"] = member.settling.tolist()
    if member.resilience is not None and isinstance(rotor, Rotor):
        row |= _resilience_row(rotor, member.resilience)
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
    cells: Sequence[Cell[Any, Any]], count: int, starts: int
) -> dict[str, npt.NDArray[np.generic]]:
    """Return the numbers of each attractor of each rotor, shape (cells, count)."""
    columns: dict[str, npt.NDArray[np.generic]] = {}
    for place, cell in enumerate(cells):
        for each in cell.members:
            row = member_row(cell.rotor, each, starts - cell.not_computed)
            for name, value in row.items():
                if name not in columns:
                    columns[name] = column_of(name, (len(cells), count, *np.shape(value)))
                columns[name][place, each.identity] = value
    return columns


def _shocks(cells: Sequence[Cell[Any, Any]], count: int) -> dict[str, npt.NDArray[np.generic]]:
    """Return the smallest shocks from each attractor to each, shape (cells, count, count)."""
    names = [f"{kind}_shock{what}" for what in ("", "_scatter") for kind in KINDS]
    columns = {name: np.full((len(cells), count, count), np.nan) for name in names}
    for place, cell in enumerate(cells):
        numbers = [each.identity for each in cell.members]
        for each in cell.members:
            if each.resilience is not None:
                told = (*each.resilience.sizes, *each.resilience.scatter)
                for column, values in zip(columns.values(), told, strict=True):
                    column[place, each.identity, numbers[: values.size]] = values
    return dict(columns)


def _flat(attributes: Mapping[str, object]) -> dict[str, object]:
    """Return attributes that an archive can store: tables of starts row after row."""
    return {
        name: np.ravel(np.asarray(value, dtype=np.float64)) if isinstance(value, list) else value
        for name, value in attributes.items()
    }
