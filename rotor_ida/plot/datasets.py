"""Check the datasets of a plot: variables, single parameter values, equal units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axis import Axis

from rotor_ida.arrays import Flags
from rotor_ida.checks import check_count, listed, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, FRICTIONLESS, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.results.archived_system import clearance_of_contacts
from rotor_ida.results.checked_run import refuse_system
from rotor_ida.results.si_units import LARGE_ONES, in_suitable_units, scale_of
from rotor_ida.schema import QUANTITIES, check_variables, flags_of
from rotor_ida.signals.nodes import Ring


def check_dataset(
    name: str, dataset: object, needed: Sequence[str], of_system: Sequence[str] = ()
) -> xr.Dataset:
    """Return `dataset` in suitable units; refuse one without a needed variable or its cycle.

    With variables that a result of a rotor system also needs, one of a disc needs its parameters.
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(f"{name} must be a Dataset, got {type(dataset).__name__}")
    if of_system:
        needed = (*(PARAMETERS if is_of_disc(dataset) else of_system), *needed)
    if not all(isinstance(variable, str) for variable in needed):
        chosen = next(variable for variable in needed if not isinstance(variable, str))
        raise InputError(f"{name} has variables named by text, got {shown(chosen)}")
    missing = [variable for variable in needed if variable not in dataset.variables]
    if missing:
        refuse_system(name, dataset)
        raise InputError(f"{name} must contain {', '.join(needed)}; it lacks {', '.join(missing)}")
    check_variables(name, dataset)
    period = dataset.variables.get("period")
    if period is not None and not period.ndim and np.isnan(period.values):
        raise InputError(f"{name} must contain a limit cycle, but the search found none")
    return in_suitable_units(dataset)


def table_of(name: str, dataset: xr.Dataset, variable: str, axes: Sequence[str]) -> xr.DataArray:
    """Return the numbers of a variable along `axes`, in this order; refuse any other shape."""
    table = dataset[variable]
    table = table.squeeze(
        [each for each in table.dims if table.sizes[each] == 1 and each not in axes]
    )
    if set(table.dims) != set(axes) or not table.size:
        sizes = ", ".join(f"{each}: {size}" for each, size in table.sizes.items()) or "one number"
        raise InputError(f"{name} must contain {variable} along {listed(axes)}, got {sizes}")
    if table.dtype.kind not in "iuf":
        raise InputError(f"{name} must contain {variable} as real numbers, got {table.dtype}")
    return table.transpose(*axes)


def one_value(name: str, dataset: xr.Dataset, parameter: str) -> float:
    """Return the single value of a parameter; refuse several."""
    values = np.atleast_1d(dataset[parameter].values)
    if values.size != 1:
        raise InputError(
            f"{name} must contain one {parameter}, got {values.size}: choose with "
            f".sel({parameter}=...)"
        )
    return float(values[0])


def along_one(name: str, dataset: xr.Dataset) -> tuple[xr.Dataset, str]:
    """Return answers at points along the one parameter that varies, and its name."""
    over, held = drawn_over(name, dataset)
    return dataset.isel(dict.fromkeys(held, 0), missing_dims="ignore"), over


def at_node(dataset: xr.Dataset, node: str | None) -> xr.Dataset:
    """Return the part of a result of a rotor system at a node; default: that of a contact.

    A result of one disc has no nodes.
    """
    if "node" not in dataset.dims:
        if node is not None and str(dataset.coords.get("node", xr.DataArray("")).values) != node:
            raise InputError(f"node must be left out for a result without nodes, got {shown(node)}")
        return dataset
    names = list(map(str, dataset["node"].values))
    number = int(dataset.attrs.get("contact", 0))
    touched = dataset["contact_node"].values.tolist()
    chosen = node
    if node is None:
        chosen = str(touched[number]) if number < len(touched) else names[0]
    if chosen not in names:
        raise InputError(f"node must be one of {', '.join(map(shown, names))}, got {shown(chosen)}")
    return dataset.isel(node=names.index(chosen))


def touching_nodes(dataset: xr.Dataset) -> list[str]:
    """Return the nodes with contacts of a result of a rotor system; without any the first node."""
    if "node" not in dataset.dims:
        return [str(dataset["node"].values)]
    nodes = list(dict.fromkeys(map(str, np.ravel(dataset["contact_node"].values))))
    return nodes or list(map(str, dataset["node"].values[:1]))


def contact_in(dataset: xr.Dataset, contact: int | str) -> int:
    """Return the number of a contact, given by it or by the name of its node; a disc has one."""
    if is_of_disc(dataset):
        return 0
    nodes = list(map(str, np.atleast_1d(dataset["contact_node"].values)))
    if isinstance(contact, str):
        here = [number for number, node in enumerate(nodes) if node == contact]
        if len(here) != 1:
            one = ", ".join(shown(node) for node in dict.fromkeys(nodes) if nodes.count(node) == 1)
            raise InputError(
                f"contact must be a number, or the only one at its node: {one or 'none'}, "
                f"got {shown(contact)}"
            )
        return here[0]
    if check_count("contact", contact, minimum=0) >= len(nodes):
        allowed = f"0 to {len(nodes) - 1}" if nodes else "none: there is no contact"
        raise InputError(f"contact must be one of {allowed}, got {contact}")
    return int(contact)


def at_contact(dataset: xr.Dataset, contact: int | str) -> xr.Dataset:
    """Return the part of a dataset at a contact; refuse one that it has not. A disc has one."""
    number = contact_in(dataset, contact)
    if "contact" not in dataset.dims:
        return dataset
    return dataset.isel(contact=number).assign(contact=number)


def contact_text(dataset: xr.Dataset, number: int) -> str:
    """Return what figures call a contact of a dataset, or the only one: number, node and stator."""
    names = [
        np.atleast_1d(dataset[each].values) if each in dataset.variables else [""]
        for each in ("contact_node", "contact_stator")
    ]
    node, stator = (str(each[number if len(each) > 1 else 0]) for each in names)
    return f"contact {number} at {Ring(node, stator, []).title}"


def is_of_kind(variable: xr.DataArray, kinds: Iterable[str]) -> xr.DataArray:
    """Return which values of a variable with flags are one of some kinds; it may lack some."""
    flags = flags_of(variable)
    return variable.isin([flags[kind] for kind in kinds if kind in flags])


def varied_in(dataset: xr.Dataset) -> list[str]:
    """Return the speed and parameters that have several values."""
    return [name for name in parameters_in(dataset) if dataset[name].size > 1]


def is_of_disc(dataset: xr.Dataset) -> bool:
    """Return whether a result is of one disc, and of no rotor system."""
    if SPEED in dataset.variables and dataset[SPEED].dims in {(), (SPEED,)}:
        return False  # exponents of a system have no node
    return "contact_node" not in dataset.variables and "node" not in dataset.variables


def parameters_in(dataset: xr.Dataset) -> list[str]:
    """Return the speed and parameters of a dataset that are numbers or axes."""
    if is_of_disc(dataset):
        return [name for name in ALL_PARAMETERS if name in dataset.variables]
    if "node" in dataset.variables and "contact_node" not in dataset.variables:  # signals
        return []
    return [
        name for name in (SPEED, *PARAMETERS_OF_SYSTEM)
        if name in dataset.variables and dataset[name].dims in {(), (name,)}
    ]  # fmt: skip


def drawn_over(name: str, dataset: xr.Dataset) -> tuple[str, dict[str, float]]:
    """Return the parameter over which a result is drawn, and the one value of each other."""
    over = axis_of(dataset)
    others = [each for each in parameters_in(dataset) if each != over]
    return over, {each: one_value(name, dataset, each) for each in others}


def axis_of(dataset: xr.Dataset) -> str:
    """Return the parameter over which a result is drawn: the speed, unless only others vary."""
    varied = varied_in(dataset)
    along = str(dataset.attrs.get("along", "omega" if is_of_disc(dataset) else SPEED))
    # folds are drawn over the speed, which they do not have
    is_held = along in dataset.variables and along not in varied
    return varied[0] if varied and is_held else along


def clearance_of(dataset: xr.Dataset, name: str = "run") -> float:
    """Return the clearance in the units of the lengths of a dataset."""
    return one_value(name, dataset, "delta0") * scale_of(dataset, "length")


def clearances_in(dataset: xr.Dataset) -> xr.DataArray:
    """Return the clearances of a disc, or of the contacts of a system, in the units of lengths."""
    if is_of_disc(dataset):
        return dataset["delta0"] * scale_of(dataset, "length")
    return clearance_of_contacts(dataset)


def rings_about(name: str, dataset: xr.Dataset) -> list[float]:
    """Return the clearances of a disc, or of a node of a rotor system, that are rings at rest."""
    if is_of_disc(dataset):
        return [clearance_of(dataset, name)]
    here = dataset["contact_node"].values == str(dataset["node"].values)
    found: list[float] = dataset["clearance"].values[here & is_centred(dataset)].tolist()
    return found


def is_centred(dataset: xr.Dataset) -> Flags:
    """Return which contacts of a rotor system have a stator on the ground, centred on the axis."""
    aside = [dataset[name].values != 0.0 for name in ("centre_x", "centre_y")]
    aside.append(dataset["contact_stator"].values != "")
    return np.asarray(~np.any(aside, axis=0))


def units_in(variable: xr.DataArray | xr.Variable) -> str:
    """Return the units attribute of a variable; 1 if it has none."""
    return str(variable.attrs.get("units", "1"))


def hold_units(axis: Axis, variable: xr.DataArray) -> None:
    """Refuse a variable whose units differ from those already on the axis.

    Shared axes share their units.
    """
    here, there = units_in(variable), axis.units
    if there is not None and here != there:
        raise InputError(
            f"what is drawn on one axis must have its units, {there!r} ('1' is dimensionless), "
            f"got {here!r}"
        )
    reached = [(ax, ax.dataLim.frozen()) for ax in axis.axes.figure.axes]
    axis.set_units(here)
    # when units change, matplotlib rescans lines but forgets the extent of bars and areas
    for ax, limits in reached:
        ax.dataLim.set(limits)


def check_same_parameters(name: str, here: Mapping[str, float], there: Mapping[str, float]) -> None:
    """Refuse parameters that differ from those of the exact curve."""
    papers = {**FRICTIONLESS, "friction": 0.0}
    of_this, of_exact = {**papers, **here}, {**papers, **there}
    for parameter, value in of_exact.items():
        # contact damping moves no fold
        skipped = (name, parameter) == ("fold_points", "contact_damping")
        if of_this.get(parameter, value) != value and not skipped:
            raise InputError(
                f"{name} must have the {parameter} of exact, {value!r}, got {of_this[parameter]!r}"
            )


def check_same_units(name: str, dataset: xr.Dataset, shown: xr.Dataset) -> None:
    """Refuse two datasets for one plot if their units or scales differ."""
    here, there = _measures(dataset), _measures(shown)
    for kind in there:
        if here.get(kind, there[kind]) != there[kind]:
            raise InputError(
                f"{name} must have the {kind} scale and units of what it is drawn with, "
                f"{there[kind]}, got {here[kind]}"
            )


def _measures(dataset: xr.Dataset) -> dict[str, str]:
    """Return scale and units of each kind of quantity in a dataset."""
    kinds = {
        QUANTITIES[str(name)].scale: units_in(variable)
        for name, variable in dataset.variables.items()
        if str(name) in QUANTITIES and name not in LARGE_ONES
    }
    return {
        kind: "dimensionless" if units == "1" else f"{scale_of(dataset, kind)!r} {units}"
        for kind, units in kinds.items()
        if kind
    }
