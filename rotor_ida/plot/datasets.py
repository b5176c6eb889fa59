"""What a picture asks of its datasets: variables, one value of a parameter, the same units."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import product

import numpy as np
import xarray as xr
from matplotlib.axis import Axis

from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, OPTIONAL
from rotor_ida.results.si_units import in_suitable_units, scale_of
from rotor_ida.schema import QUANTITIES


def check_dataset(name: str, dataset: object, needed: Sequence[str]) -> xr.Dataset:
    """Return `dataset`, in units that suit, if it is one and has the variables that are needed."""
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"{name} must be a Dataset, got {type(dataset).__name__}")
    missing = [variable for variable in needed if variable not in dataset.variables]
    if missing:
        raise InputError(f"{name} must hold {', '.join(needed)}; it lacks {', '.join(missing)}")
    return in_suitable_units(dataset)


def one_value(name: str, dataset: xr.Dataset, parameter: str) -> float:
    """Return the one value of a parameter that a picture can show."""
    values = np.atleast_1d(dataset[parameter].values)
    if values.size != 1:
        raise InputError(
            f"{name} must hold one {parameter}, got {values.size}: choose with "
            f".sel({parameter}=...)"
        )
    return float(values[0])


def parameters_in(dataset: xr.Dataset) -> list[str]:
    """Return the parameters of the rotor that a dataset has."""
    return [name for name in ALL_PARAMETERS if name in dataset.variables]


def rotors_in(
    dataset: xr.Dataset, *, but: Sequence[str] = ()
) -> Iterator[tuple[dict[str, float], xr.Dataset]]:
    """Yield the parts with one value of each parameter, and the values of those that vary."""
    names = [name for name in parameters_in(dataset) if name in dataset.dims and name not in but]
    varied = [name for name in names if dataset.sizes[name] > 1]
    for places in product(*(range(dataset.sizes[name]) for name in names)):
        part = dataset.isel({name: [at] for name, at in zip(names, places, strict=True)})
        yield {name: part[name].item() for name in varied}, part


def clearance_of(dataset: xr.Dataset, name: str = "run") -> float:
    """Return the clearance in the units of the lengths of a dataset."""
    return one_value(name, dataset, "delta0") * scale_of(dataset, "length")


def units_in(variable: xr.DataArray | xr.Variable) -> str:
    """Return the units of a variable as its attributes have them; 1 where they have none."""
    return str(variable.attrs.get("units", "1"))


def hold_units(axis: Axis, variable: xr.DataArray) -> None:
    """Refuse a variable in other units than those in which the axis shows values already.

    Axes that share an axis share its units.
    """
    here, there = units_in(variable), axis.units
    if there is not None and here != there:
        raise InputError(
            f"what is drawn on one axis must have its units, {there!r} ('1' is dimensionless), "
            f"got {here!r}"
        )
    reached = [(ax, ax.dataLim.frozen()) for ax in axis.axes.figure.axes]
    axis.set_units(here)
    # at new units matplotlib looks at lines anew, and forgets how far bars and areas reach
    for ax, limits in reached:
        ax.dataLim.set(limits)


def fixed_parameters(
    name: str, dataset: xr.Dataset, of_all: Sequence[str] = ("zeta", "delta0")
) -> dict[str, float]:
    """Return the parameters but the one on the axis, of which there is one value each."""
    names = (*of_all, *(each for each in OPTIONAL if each in dataset.variables))
    return {each: one_value(name, dataset, each) for each in names}


def check_same_parameters(name: str, here: Mapping[str, float], there: Mapping[str, float]) -> None:
    """Refuse other parameters than those of the exact curve."""
    papers = {**FRICTIONLESS, "friction": 0.0}
    of_this, of_exact = {**papers, **here}, {**papers, **there}
    for parameter, value in of_exact.items():
        # contact damping moves no fold
        skipped = (name, parameter) == ("fold_points", "contact_damping")
        if of_this[parameter] != value and not skipped:
            raise InputError(
                f"{name} must have the {parameter} of exact, {value!r}, got {of_this[parameter]!r}"
            )


def check_same_units(name: str, dataset: xr.Dataset, shown: xr.Dataset) -> None:
    """Refuse two datasets for one picture whose units or scales differ."""
    here, there = _measures(dataset), _measures(shown)
    for kind in there:
        if here.get(kind, there[kind]) != there[kind]:
            raise InputError(
                f"{name} must have the {kind} scale and units of what it is drawn with, "
                f"{there[kind]}, got {here[kind]}"
            )


def _measures(dataset: xr.Dataset) -> dict[str, str]:
    """Return scale and units of each kind of quantity that a dataset holds."""
    kinds = {
        QUANTITIES[str(name)].scale: units_in(variable)
        for name, variable in dataset.variables.items()
        if str(name) in QUANTITIES
    }
    return {
        kind: "dimensionless" if units == "1" else f"{scale_of(dataset, kind)!r} {units}"
        for kind, units in kinds.items()
        if kind
    }
