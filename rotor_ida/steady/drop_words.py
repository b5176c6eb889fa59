"""Drops on touchdown bearings in words, and the place of one drop among many."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr

from rotor_ida.checks import listed
from rotor_ida.results.depths import beyond_model
from rotor_ida.schema import OF_DROP
from rotor_ida.steady.drop_figures import touched_clearances
from rotor_ida.units import number, quantity

NOT_ACTING = "a touch there does not act on the rotor"


def sentence_of(run: xr.Dataset, drops: xr.Dataset | None) -> str:
    """Return in words whether the drop is survived, as far as figures say, the worst first."""
    forces, nodes = run["largest_force"].values, run["contact_node"].values
    worst = int(forces.argmax())
    unit = str(run["largest_force"].attrs.get("units", ""))
    touched = touched_clearances(run)
    warned = [beyond_model(each) for each in (drops, run) if each is not None]
    ratio = float(run["load_ratio"].max()) if "load_ratio" in run.variables else math.nan
    said = [f"The rotor touches {_clearances_at(touched)}; {NOT_ACTING}."] if touched else []
    loads = f"Loads reach {number(100.0 * ratio, 3)} % of the load capacities that were given."
    said += [loads] if ratio > 1.0 else []
    said += list(filter(None, warned))[:1]
    said += [
        f"The largest force of this drop is {quantity(float(forces[worst]), unit)}, in the bearing "
        f"at {str(nodes[worst])!r}; the rotor goes as far as "
        f"{float(run['excursion'].max()):.3g} clearances."
        if forces[worst] > 0.0
        else _untouched(run),
    ]
    said += [loads] if ratio <= 1.0 else []
    if (run["whirl_sense"].values < 0).any():
        said.append("It whirls backwards for three turns or more.")
    if np.isfinite(run["rest_time"].values).all():
        said.append(f"It stays in contact from {_time(run, run['rest_time'].max())} on.")
    if run["horizon"] < run["t"][-1]:
        said.append(
            f"After {_time(run, run['horizon'])} of {_time(run, run['t'][-1])} this one motion "
            "depends on rounding: what follows is one of many possible ones."
        )
    said += [] if drops is None else _of_many(drops, unit)
    said += [f"Note: {run.attrs['note']}."] if "note" in run.attrs else []
    return " ".join(said)


def _untouched(run: xr.Dataset) -> str:
    """Return why no bearing is touched in a drop."""
    if not run.sizes.get("support", 0):
        return "The system has no supports that could fail: it does not drop on a bearing."
    return "In this drop the rotor touches no bearing."


def _of_many(drops: xr.Dataset, unit: str) -> list[str]:
    """Return what many drops say in words."""
    count, forces = drops.sizes["drop"], drops["largest_force"].values
    if not np.isfinite(forces).any():
        return [f"All {count} drops failed."]
    most = quantity(float(np.nanmax(forces)), unit)
    touched = touched_clearances(drops)
    others = [f"Some drops touch {_clearances_at(touched)}."] if touched else []
    facts = [_share(drops, "backward_whirl", "whirl backwards")]
    if "overload_fraction" in drops.variables:
        facts.append(_share(drops, "overload", "exceed the load capacity of a bearing"))
    if "cell" in drops.sizes:
        at = place_of(drops, int(np.nanargmax(forces)) // forces.shape[1])
        where = f", at {places_in(drops)} = {at}" if at else ""
        return [*others, f"Over a grid of {count} drops the largest force is {most}{where}. "
                f"Of the grid {' and '.join(facts)}."]  # fmt: skip
    return [*others, f"Of {count} drops the largest force is {most}; {' and '.join(facts)} "
            "(95 % intervals)."]  # fmt: skip


def _time(run: xr.Dataset, value: xr.DataArray) -> str:
    return quantity(float(value), str(run["t"].attrs.get("units", "")), 3)


def _clearances_at(nodes: Sequence[str]) -> str:
    """Return the close clearances at nodes in words."""
    return f"the close clearance{'s' if len(nodes) > 1 else ''} at {listed(list(map(repr, nodes)))}"


def _share(drops: xr.Dataset, name: str, words: str) -> str:
    """Return the share of drops in the bearing where it is largest, in words."""
    values = drops[f"{name}_fraction"].values
    own = drops.isel(contact=int(np.nanargmax(values)))
    share = number(100.0 * float(own[f"{name}_fraction"]), 3)
    if "cell" in drops.sizes:
        return f"{share} % {words}"
    low, high = (100.0 * float(own[f"{name}_fraction_{end}"]) for end in ("low", "high"))
    return f"{share} % ({number(low, 3)} to {number(high, 3)} %) {words}"


def varying(drops: xr.Dataset, prefix: str = "drop") -> list[str]:
    """Return the names of what differs between drops, or between cells."""
    return [
        name for name in OF_DROP
        if f"{prefix}_{name}" in drops.variables and np.ptp(drops[f"{prefix}_{name}"].values) > 0.0
    ]  # fmt: skip


def place_of(drops: xr.Dataset, number: int) -> str:
    """Return where a drop lies on a grid, by the values of `places_in`.

    Examples
    --------
    >>> import xarray as xr
    >>> values = {"phase": [0.0, 1.0], "friction": [0.1, 0.3]}
    >>> drops = xr.Dataset({f"drop_{name}": ("drop", each) for name, each in values.items()})
    >>> place_of(drops, 1), place_of(drops, -1)
    ('57.3 deg, 0.3', '-')
    """
    if number < 0:
        return "-"
    values = {name: float(drops[f"drop_{name}"][number]) for name in varying(drops)}
    return ", ".join(
        quantity(each, "radian" if name == "phase" else "1") for name, each in values.items()
    )


def places_in(drops: xr.Dataset) -> str:
    """Return what the numbers of a place are."""
    return ", ".join(OF_DROP[name] for name in varying(drops))


def count_of(drops: xr.Dataset, name: str) -> int:
    """Return the number of drops that have a figure: some bearings never whirl, roll or rest."""
    return int((drops[name].notnull() & (drops["status"] == 0)).sum())


def cells_in(drops: xr.Dataset) -> list[str]:
    """Return the names of the variables of cells, in the order of their table."""
    return [f"cell_{name}" for name in varying(drops, "cell")]
