"""In which units a dataset is drawn: its own, with the SI prefix that suits the values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida.errors import InputError
from rotor_ida.plot.labels import IN_UNITS, LABELS
from rotor_ida.si_units import UNITS

PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M"}
# How units are written in a label, before the prefix.
WRITTEN = {base: base.replace("m s-1", "m/s").replace("s-1", "1/s") for base in UNITS.values()}
# What each unit is in units without a prefix; rates take none.
SIZES = {
    kind: {prefix + WRITTEN[base]: 10.0**power for power, prefix in PREFIXES.items()}
    if kind != "rate"
    else {WRITTEN[base]: 1.0}
    for kind, base in UNITS.items()
}


def suited(
    dataset: xr.Dataset,
    drawn: Sequence[str],
    *,
    units: Mapping[str, str] | None = None,
    ax: Axes | None = None,
) -> xr.Dataset:
    """Return a dataset in the units in which it is drawn; one without units as it is.

    Parameters
    ----------
    dataset : Dataset
        A result of this package, perhaps made dimensional.
    drawn : sequence of str
        The variables that are drawn: their largest values decide the prefixes.
    units : mapping of str to str, optional
        Units wanted, by kind of quantity, such as ``{"length": "mm"}``.
    ax : Axes, optional
        Where it is drawn: a unit that stands on it already, or on axes that share theirs with
        it, is kept.

    Returns
    -------
    Dataset
        The values and scales in those units, which the variables carry.

    Raises
    ------
    InputError
        If a unit is none of its kind, or the dataset has no units.

    Examples
    --------
    >>> run = xr.Dataset({"x": ("t", [0.0, 2e-5], {"units": "m"})}, attrs={"length_scale": 1e-5})
    >>> shown = suited(run, ["x"])
    >>> shown.x.attrs["units"], [round(float(x), 9) for x in shown.x]
    ('µm', [0.0, 20.0])
    """
    wanted = _checked(units, dataset)
    if "length_scale" not in dataset.attrs:
        return dataset
    standing = {} if ax is None else dict(_units_on(ax))
    changed, scales = {}, {}
    for kind, present in _units_in(dataset).items():
        unit = wanted.get(kind) or standing.get(kind) or _unit_for(kind, dataset, drawn)
        factor = SIZES[kind][unit] / SIZES[kind].get(present, 1.0)
        for name, variable in dataset.variables.items():
            if variable.attrs.get("units") == present:
                attributes = {**variable.attrs, "units": unit}
                changed[name] = xr.Variable(variable.dims, variable.values / factor, attributes)
        scales[f"{kind}_scale"] = dataset.attrs[f"{kind}_scale"] / factor
    return dataset.assign(changed).assign_attrs(scales)


def label_of(name: str, variable: xr.DataArray, *, words: str | None = None) -> str:
    """Return the label of an axis: name and symbol, and the unit of the variable, if it has one.

    Examples
    --------
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "µm"}))
    'radius $|Z|$ [µm]'
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "1"}))
    'radius $|z|$'
    """
    unit = unit_of(variable)
    if not unit:
        return words or LABELS[name]
    return f"{words or IN_UNITS.get(name, LABELS[name])} [{unit}]"


def unit_of(variable: xr.DataArray | xr.Variable) -> str:
    """Return the unit of length, time, force and so on that a variable carries, or nothing."""
    unit = str(variable.attrs.get("units", ""))
    return unit if any(unit in sizes for sizes in SIZES.values()) else ""


def scale_of(dataset: xr.Dataset, kind: str) -> float:
    """Return what 1 means in the units of the dataset: 1 where it has none."""
    return float(dataset.attrs.get(f"{kind}_scale", 1.0))


def alike(name: str, dataset: xr.Dataset, shown: xr.Dataset) -> xr.Dataset:
    """Return a dataset in the units of one that is drawn already.

    Raises
    ------
    InputError
        If one of them is dimensionless and the other is not, or they are of different machines.
    """
    if "length_scale" in dataset.attrs and "length_scale" in shown.attrs:
        dataset = suited(dataset, (), units=_units_in(shown))
    here, there = (each.attrs.get("length_scale") for each in (dataset, shown))
    if here != there:
        raise InputError(
            f"{name} must have the length scale of what it is drawn with, {there!r} (None for "
            f"dimensionless), got {here!r}"
        )
    return dataset


def _units_in(dataset: xr.Dataset) -> dict[str, str]:
    """Return the units that a dataset has, by kind; each kind has one."""
    units = (str(variable.attrs.get("units")) for variable in dataset.variables.values())
    return {kind: unit for unit in units for kind in SIZES if unit in (*SIZES[kind], UNITS[kind])}


def _unit_for(kind: str, dataset: xr.Dataset, drawn: Sequence[str]) -> str:
    """Return the unit in which the largest of the values drawn is at least 1 and below 1000."""
    written, present = WRITTEN[UNITS[kind]], _units_in(dataset)[kind]
    largest = 0.0
    for name in drawn:
        if name in dataset.variables and dataset[name].attrs.get("units") == present:
            values = np.abs(dataset[name].values) * SIZES[kind].get(present, 1.0)
            largest = max(largest, float(values[np.isfinite(values)].max(initial=0.0)))
    if largest == 0.0 or kind == "rate":
        return written
    power = 3 * math.floor(math.log10(largest) / 3.0 + 1e-12)
    return PREFIXES[min(max(power, min(PREFIXES)), max(PREFIXES))] + written


def _units_on(ax: Axes) -> Iterator[tuple[str, str]]:
    """Yield kind and unit of what is labelled already, here and where an axis is shared."""
    for axis in ("x", "y", "z"):
        shared = getattr(ax, f"get_shared_{axis}_axes", None)
        for each in (ax,) if shared is None else (ax, *shared().get_siblings(ax)):
            label = getattr(each, f"get_{axis}label", str)()
            found = re.search(r"\[(.+)\]$", label)
            if found is not None:
                yield from ((kind, found[1]) for kind, known in SIZES.items() if found[1] in known)


def _checked(units: Mapping[str, str] | None, dataset: xr.Dataset) -> Mapping[str, str]:
    if not units:
        return {}
    if "length_scale" not in dataset.attrs:
        raise InputError(
            f"units must be left out for a dimensionless dataset, got {dict(units)!r}: "
            "rotor_ida.dimensional makes it one in SI units"
        )
    for kind, unit in units.items():
        if kind not in SIZES:
            raise InputError(f"units must be of {', '.join(SIZES)}, got {kind!r}")
        if unit not in SIZES[kind]:
            allowed = ", ".join(SIZES[kind])
            raise InputError(f"the unit of {kind} must be one of {allowed}, got {unit!r}")
    return units
