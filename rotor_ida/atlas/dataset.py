"""An atlas as a labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.atlas.cells import NUMBERS, Cell
from rotor_ida.basins.dataset import LABELLING
from rotor_ida.parameters import PARAMETERS
from rotor_ida.provenance import provenance
from rotor_ida.schema import RESPONSE, TRAPPING, Column, labelled_dataset
from rotor_ida.simulation.options import Options

Values = npt.NDArray[np.float64]

# The sample misses an attractor that has more than `missed_fraction` with this probability at most.
RISK = 0.05


def atlas_dataset(
    axes: Mapping[str, Values], cells: Sequence[Cell], starts: int, attributes: Mapping[str, object]
) -> xr.Dataset:
    """Return the attractors over the parameters.

    Parameters
    ----------
    axes : mapping of str to ndarray
        omega, zeta and delta0 [1].
    cells : sequence of Cell
        The rotors in their order, each with its attractors numbered.
    starts : int
        Number of starts of each.
    attributes : mapping
        How they were drawn and followed.
    """
    members = [each for cell in cells for each in cell.members]
    count = 1 + max((each.identity for each in members), default=-1)
    shape = (len(cells), count)
    numbers = (*NUMBERS, "fraction", "fraction_error", "settling_median", "settling_95")
    columns = {name: np.full(shape, np.nan) for name in numbers}
    counts = np.zeros(shape, dtype=np.int64)
    kinds = np.full(shape, RESPONSE["not_found"], dtype=np.int8)
    trapping = np.zeros(shape, dtype=np.int8)
    for row, cell in enumerate(cells):
        computed = starts - cell.not_computed
        for each in cell.members:
            place = row, each.identity
            for name in NUMBERS:
                columns[name][place] = getattr(each.attractor, name)
            kinds[place] = RESPONSE[each.attractor.kind]
            trapping[place] = TRAPPING[each.attractor.trapping]
            counts[place] = each.count
            columns["settling_median"][place], columns["settling_95"][place] = each.settling
            if computed:
                part = each.count / computed
                columns["fraction"][place] = part
                columns["fraction_error"][place] = np.sqrt(part * (1.0 - part) / computed)
    sizes = tuple(values.size for values in axes.values())
    over = (*PARAMETERS, "attractor")
    variables: dict[str, Column] = {
        name: (over, values.reshape(*sizes, count))
        for name, values in {
            **columns, "count": counts, "kind": kinds, "trapping": trapping,
        }.items()
    }  # fmt: skip
    undecided = [cell.undecided / max(starts - cell.not_computed, 1) for cell in cells]
    variables["undecided_fraction"] = (PARAMETERS, np.array(undecided).reshape(sizes))
    missing = np.array([cell.not_computed for cell in cells])
    variables["not_computed_count"] = (PARAMETERS, missing.reshape(sizes))
    variables["missed_fraction"] = ((), 1.0 - RISK ** (1.0 / starts))
    coordinates: dict[str, Column] = {name: (name, values) for name, values in axes.items()}
    coordinates["attractor"] = ("attractor", np.arange(count))
    title = "Rotor in a clearance: attractors and the fractions of starts on each"
    told = {**provenance(Options().attributes()), "labelling": LABELLING}
    return labelled_dataset(title, variables, coordinates, told | _flat(attributes))


def _flat(attributes: Mapping[str, object]) -> dict[str, object]:
    """Return attributes that an archive can hold: tables of starts row after row."""
    return {
        name: np.ravel(np.asarray(value, dtype=np.float64)) if isinstance(value, list) else value
        for name, value in attributes.items()
    }
