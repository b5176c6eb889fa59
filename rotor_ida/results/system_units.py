"""Units of the results of a rotor system."""

from __future__ import annotations

import xarray as xr

from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.schema import QUANTITIES
from rotor_ida.schema.quantities import OTHER_UNITS, UNITS

# Units of the attributes of a changing speed, as `rotor_ida.dimensional` names them.
UNITS_OF_CHANGE = {
    "speed": "s-1", "to": "s-1", "rate": "s-2", "speeds": "s, s-1", "torque": "N m, N m s",
    "inertia": "kg m2",
}  # fmt: skip
# Attribute with the note of the system, if it has one.
NOTE = "note"


def with_system_units(dataset: xr.Dataset, system: RotorSystem) -> xr.Dataset:
    """Return a result with the units and the note of its system; its speeds are over no scale."""
    if system.note:
        dataset.attrs[NOTE] = system.note
    if "speed" in dataset.variables:
        dataset["speed"].attrs["long_name"] = "spin speed"
    if system.units == "SI":
        for name, variable in dataset.variables.items():
            scale = QUANTITIES[str(name)].scale
            if scale or name in OTHER_UNITS:
                variable.attrs["units"] = UNITS[scale] if scale else OTHER_UNITS[str(name)]
        for name, unit in UNITS_OF_CHANGE.items():
            if name in dataset.attrs:
                dataset.attrs[f"{name}_units"] = unit
    return dataset
