"""Convert results to SI units and back, with prefixes if requested."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_between, check_instance, shown
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS, OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.scales import IS_OF_MACHINE, UNITS_OF_ARGUMENTS, unit_of_parameter, unit_scale
from rotor_ida.schema import QUANTITIES, check_variables
from rotor_ida.schema.quantities import OTHER_UNITS, SPECIAL_VALUES, UNITS
from rotor_ida.units import PREFIXES, SPEED_UNITS, read_in

# Units of speed in rad/s; for UDUNITS a radian is 1, and Hz is 1/s too.
OF_SPEED = {UNITS["speed"]: 1.0, "rpm": SPEED_UNITS["rpm"]}
# Prefixes of attributes of a result in SI units: the machine, and the original parameters.
MACHINE, EXACT = "machine_", "dimensionless"
# Inputs of a result that are stored to the last bit; longer axes are divided by their scale.
INPUTS = (*COMPONENTS, *(f"start_{name}" for name in COMPONENTS), "to", "rate")
LONGEST_INPUT = 4096
# Kinds of quantities that figures show in the units of the field.
SUITABLE = ("length", "velocity", "force", "impulse", "energy")
# Of these the largest decides about the unit.
SIZED = ("force", "impulse", "energy")
# Not small: the rim of the disc is far faster than its centre, and a shaft is long.
LARGE_ONES = ("slip_speed", "axial_position")
# Dimensionless ones in some unit; that of a moment of inertia is a product of two.
SCALES = (1e-200, 1e200)
# Attributes of a changing speed, and the one with the note of a rotor system.
OF_CHANGE = ("speed", "to", "rate", "speeds", "torque", "inertia")
NOTE = "note"
# Results that are values of a parameter, and stay dimensionless in SI units as it does.
VALUES_OF = {
    **{f"{of}_omega": "omega" for of in ("fold", "hopf", "jump", "birth", "cusp", "peak")},
    "cusp_zeta": "zeta",
}  # fmt: skip


def dimensional(
    dataset: xr.Dataset,
    machine: DimensionalRotor | None = None,
    *,
    units: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Return a result with displacements, times, velocities and forces in SI or other units.

    Parameters
    ----------
    dataset : Dataset
        A result of this package for a `DimensionalRotor`, or a dimensionless one.
    machine : DimensionalRotor, optional
        The machine; required for a dimensionless result.
    units : mapping of str to str, optional
        Units other than m, s, m/s, N, N s, J, N m and 1/s, by kind: ``length``, ``time``,
        ``velocity``, ``force``, ``impulse``, ``energy`` or ``torque``, such as
        ``{"length": "µm", "time": "ms"}``. Prefixes
        are p, n, µ (or u), m, k and M. A ``speed`` that changes is in ``rad/s`` or ``rpm``.
        Figures show the chosen units, and a suitable prefix, such as µm, for the others.

    Returns
    -------
    Dataset
        The same variables in those units; parameters, phases, kinds and counts are unchanged. Each
        variable's attribute ``units`` has its unit in the notation of UDUNITS (``um``, ``m s-1``).
        The attributes ``length_scale``, ``time_scale`` and so on are the values of a dimensionless
        1; ``machine_mass`` and so on describe the machine.
        The attributes of what was asked, such as ``start``, ``duration`` and ``rate``, are in SI
        units too, given by ``start_units`` and so on. Parameters of the rotor and coordinates named
        ``omega``, ``zeta`` and so on stay dimensionless.

    Raises
    ------
    InputError
        If a dimensionless result has no machine, one in SI units is of another, or a unit is not of
        its kind.

    Notes
    -----
    ``Z = D z``, ``T = t/omega_0``, force ``k D**n f``, with ``omega_0**2 = k D**(n - 1)/m`` and
    the exponent n of the contact force: ``k D**1.5 f`` and ``omega_0**2 = k sqrt(D)/m`` by Hertz.

    References
    ----------
    Eq. (9) of the paper, Mechanika 25(6), 2019, which prints ``omega_0**2 = k/m``.

    Examples
    --------
    >>> from rotor_ida import simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = simulate(machine, duration=0.04)
    >>> run.t.attrs["units"]
    's'
    >>> shown = dimensional(run, units={"length": "µm"})
    >>> shown.x.attrs["units"], round(shown.attrs["length_scale"], 9)
    ('um', 1.0)
    """
    check_instance("dataset", dataset, xr.Dataset)
    check_variables("dataset", dataset)
    own = machine_of(dataset)
    if machine is None and own is None:
        raise InputError("machine must be given for a dimensionless result, got None")
    machine = check_instance("machine", own if machine is None else machine, DimensionalRotor)
    if own not in {None, machine}:
        raise InputError(f"machine must be that of the result, {own!r}, got {machine!r}")
    dataset, in_si = dimensionless(dataset), scales_of(machine)
    if units is None:
        units = {}
    if not isinstance(units, Mapping):
        raise InputError(f"units must be a mapping such as {{'length': 'mm'}}, got {shown(units)}")
    chosen = UNITS | {kind: _checked(kind, unit) for kind, unit in units.items()}
    scales = {kind: in_si[kind] * _parts(kind)[unit] for kind, unit in chosen.items()}
    converted = {}
    for name, variable in dataset.variables.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and quantity.scale:
            attributes = {**variable.attrs, "units": chosen[quantity.scale]}
            values = variable.values * scales[quantity.scale]
            if name in INPUTS and name in dataset.coords and values.size <= LONGEST_INPUT:
                attributes[EXACT] = np.ravel(variable.values)
            converted[name] = xr.Variable(variable.dims, values, attributes)
    told: dict[str, object] = {f"{kind}_scale": value for kind, value in scales.items()}
    told |= {f"{MACHINE}{name}": value for name, value in machine.given.items()}
    told |= _attributes_in_si(dataset, machine, scales, chosen)
    return dataset.assign(converted).assign_attrs(told)


def dimensionless(dataset: xr.Dataset) -> xr.Dataset:
    """Convert a result in SI units back to a dimensionless one; return any other unchanged.

    Parameters
    ----------
    dataset : Dataset
        A result of `dimensional`, for example one loaded from an archive.

    Returns
    -------
    Dataset
        The same result, dimensionless. Its parameters are as before to the last bit, everything
        else within rounding.

    Examples
    --------
    >>> from rotor_ida import simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=20.0)
    >>> again = dimensionless(dimensional(run, machine, units={"length": "um"}))
    >>> bool(abs(again.x - run.x).max() < 1e-15), again.attrs.keys() == run.attrs.keys()
    (True, True)
    """
    check_instance("dataset", dataset, xr.Dataset)
    if not is_in_si(dataset):
        return dataset
    check_variables("dataset", dataset)
    converted = {}
    for name, variable in dataset.variables.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and quantity.scale:
            attributes = {**variable.attrs, "units": quantity.units}
            exact = np.asarray(attributes.pop(EXACT, ()))
            scale = scale_of(dataset, quantity.scale)
            values = variable.values / scale
            if exact.size == values.size:
                exact = exact.reshape(values.shape)
                if np.array_equal(exact * scale, variable.values, equal_nan=True):
                    values = exact  # else it was changed
            converted[name] = xr.Variable(variable.dims, values, attributes)
    plain = dataset.assign(converted)
    attributes = plain.attrs = _attributes_before(dataset)
    if "t" in plain.coords and "duration" in attributes:
        # the division may have moved the last sample behind the end of the run by a rounding
        t, end = plain["t"], float(str(attributes["duration"]))
        plain = plain.assign_coords(t=t.where((t < end) | (t > end * (1.0 + 1e-12)), end))
    return plain


def rescaled(dataset: xr.Dataset, machine: DimensionalRotor) -> xr.Dataset:
    """Return a result without dimensions; one of another machine by the scales of `machine`."""
    plain, own = dimensionless(dataset), machine_of(dataset)
    if own is None or scales_of(own) == scales_of(machine):
        return plain
    scales = {f"{kind}_scale": each for kind, each in scales_of(machine).items()}
    moved = dimensionless(dimensional(plain, own).assign_attrs(scales))
    for name in [each for each in ALL_PARAMETERS if each in plain.variables]:
        unit = unit_of_parameter(name)
        factor = unit_scale(own, unit) / unit_scale(machine, unit)
        moved = moved.assign({name: plain.variables[name].copy(data=plain[name].data * factor)})
    return moved


def is_in_si(dataset: xr.Dataset) -> bool:
    """Return whether a result is in SI units."""
    return "length_scale" in dataset.attrs


def machine_of(dataset: xr.Dataset) -> DimensionalRotor | None:
    """Return the machine of a result in SI units; None if it has none."""
    told = {name: dataset.attrs[f"{MACHINE}{name}"] for name in OF_MACHINE
            if f"{MACHINE}{name}" in dataset.attrs}  # fmt: skip
    if not told:
        return None
    try:
        return DimensionalRotor(**{name: float(value) for name, value in told.items()})
    except (TypeError, ValueError) as error:  # not written by `dimensional`
        raise InputError(f"the dataset has no valid machine: {error}") from error


def in_units_of(dataset: xr.Dataset, other: xr.Dataset) -> xr.Dataset:
    """Return a dimensionless result in the units of another, which may be dimensionless too.

    Examples
    --------
    >>> from rotor_ida import simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=20.0)
    >>> shown = dimensional(run, machine, units={"length": "um"})
    >>> in_units_of(run, shown).identical(shown), in_units_of(run, run) is run
    (True, True)
    """
    machine = machine_of(other)
    if machine is None:
        return dataset
    return dimensional(dataset, machine, units=_units_in(other))


def _units_in(dataset: xr.Dataset) -> dict[str, str]:
    """Return the units of a result in SI units, by kind."""
    units = {}
    for name, variable in dataset.variables.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and quantity.scale:
            units[quantity.scale] = str(variable.attrs["units"])
    return units


def in_suitable_units(dataset: xr.Dataset) -> xr.Dataset:
    """Return a result in m, m/s, N, N s or J in µm, mm/s, kN and so on; in other units as it is.

    Forces, impulses and energies are in the unit in which the largest of them is read, and all of
    them in mils, in/s, lbf and so on within `sentences_in("inch")`.
    """
    together: dict[str, list[str]] = {}
    for name, variable in dataset.variables.items():
        kind = QUANTITIES[str(name)].scale if str(name) in QUANTITIES else ""
        if name in SPECIAL_VALUES and variable.attrs.get("units") == UNITS["length"]:
            kind = "length"
        if str(variable.attrs.get("units")) == UNITS.get(kind) and kind in SUITABLE:
            together.setdefault(str(name) if name in LARGE_ONES else kind, []).append(str(name))
    converted, told = {}, {}
    for kind, names in together.items():
        sizes = [1.0] if kind in LARGE_ONES else []
        if kind in SIZED:
            values = [dataset[name].values for name in names]
            sizes = [np.abs(each[np.isfinite(each)]).max(initial=0.0) for each in values]
        unit, parts = read_in(dataset[names[0]].attrs["units"], sizes)
        for name in names:
            variable = dataset.variables[name]
            attributes = {**variable.attrs, "units": unit.replace("/s", " s-1")}
            converted[name] = xr.Variable(variable.dims, variable.data / parts, attributes)
        if f"{kind}_scale" in dataset.attrs:
            told[f"{kind}_scale"] = scale_of(dataset, kind) / parts
    return dataset.assign(converted).assign_attrs(told) if converted else dataset


def si_of(dataset: xr.Dataset, name: str) -> tuple[str, float] | None:
    """Return the label of a parameter in SI units, and the value of a dimensionless 1.

    None if it has no unit or the result has no machine. Speeds are in rpm.

    Examples
    --------
    >>> from rotor_ida import sweep
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> swept = dimensional(sweep(omega=1.2, zeta=0.07, delta0=2.0), machine)
    >>> si_of(swept, "delta0"), si_of(swept, "friction")
    (('clearance [m]', 1e-06), None)
    """
    machine = machine_of(dataset)
    if machine is None:
        return None
    if name in SPECIAL_VALUES:
        name = dict(zip(SPECIAL_VALUES, _continued(dataset), strict=False)).get(name, name)
    parameter = VALUES_OF.get(name, name)
    own = IS_OF_MACHINE.get(parameter, parameter)
    if name in {"to", "rate"}:
        (unit,) = UNITS_OF_ARGUMENTS[name]
    elif parameter in ALL_PARAMETERS and OF_MACHINE[own].unit != "1":
        unit = OF_MACHINE[own].unit
    else:
        return None
    shown_unit = {"rad s-1": "rpm", "rad s-2": "rpm/s"}.get(unit) or OF_MACHINE[own].shown_unit
    in_one = SPEED_UNITS["rpm"] if unit.startswith("rad") else 1.0
    words = f"{name.removesuffix(parameter)}{own}".replace("_", " ")
    return f"{words} [{shown_unit}]", unit_scale(machine, unit) / in_one


def scale_of(dataset: xr.Dataset, kind: str) -> float:
    """Return the value of a dimensionless 1 in the units of a result: 1 if it has none."""
    name = f"{kind}_scale"
    return check_between(name, dataset.attrs.get(name, 1.0), *SCALES)


def in_rpm(speeds: xr.DataArray) -> Values | None:
    """Return speeds in revolutions per minute; None if they are dimensionless.

    Examples
    --------
    >>> in_rpm(xr.DataArray([50.0], attrs={"units": "s-1"})).round(3)
    array([477.465])
    """
    factor = OF_SPEED.get(str(speeds.attrs.get("units")))
    return None if factor is None else np.asarray(speeds.values) * (factor / OF_SPEED["rpm"])


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
        for name in [each for each in OF_CHANGE if each in dataset.attrs]:
            units = UNITS_OF_ARGUMENTS.get(name, ("s-1",))
            dataset.attrs[f"{name}_units"] = ", ".join(units).replace("rad ", "")
    return dataset


def scales_of(machine: DimensionalRotor) -> dict[str, float]:
    """Return the value of a dimensionless 1 in SI units, by kind."""
    return {
        "length": machine.length_scale,
        "time": machine.time_scale,
        "velocity": machine.velocity_scale,
        "force": machine.force_scale,
        "impulse": machine.force_scale * machine.time_scale,
        "energy": machine.force_scale * machine.length_scale,
        "torque": machine.torque_scale,
        "rate": machine.reference_frequency,
        "speed": machine.reference_frequency,
    }


def _attributes_in_si(
    dataset: xr.Dataset,
    machine: DimensionalRotor,
    scales: Mapping[str, float],
    units: Mapping[str, str],
) -> dict[str, object]:
    """Return the attributes that have units, with these and their dimensionless values."""
    kinds = {"m": "length", "s": "time", "m s-1": "velocity", "rad s-1": "speed"}
    chosen = {si: (scales[kind], units[kind]) for si, kind in kinds.items()}
    speed, unit = chosen["rad s-1"]
    rate = speed * machine.reference_frequency
    chosen["rad s-2"] = (rate, "s-2" if unit == "s-1" else f"{unit} s-1")
    ends = tuple(unit_of_parameter(name) for name in _continued(dataset) for _ in ("low", "high"))
    found: dict[str, object] = {}
    for name, each in {**UNITS_OF_ARGUMENTS, "limits": ends}.items():
        if each and name in dataset.attrs and np.asarray(dataset.attrs[name]).dtype.kind == "f":
            pairs = [chosen.get(si) or (unit_scale(machine, si), si) for si in each]
            given = np.asarray(dataset.attrs[name])
            values = np.reshape(given, (-1, len(pairs))) * [factor for factor, _ in pairs]
            found[name] = values.ravel() if given.ndim else values.item()
            found[f"{name}_units"] = ", ".join(dict.fromkeys(unit for _, unit in pairs))
            found[f"{EXACT}_{name}"] = dataset.attrs[name]
    return found


def _continued(dataset: xr.Dataset) -> list[str]:
    """Return the parameters over which a result was continued."""
    return str(dataset.attrs.get("parameter", dataset.attrs.get("parameters", ""))).split()


def _attributes_before(dataset: xr.Dataset) -> dict[str, object]:
    """Return the attributes of a result before its conversion to SI units."""
    added = {f"{kind}_scale" for kind in UNITS} | {f"{MACHINE}{name}" for name in OF_MACHINE}
    before = {str(name): value for name, value in dataset.attrs.items() if name not in added}
    for name in [each for each in (*UNITS_OF_ARGUMENTS, "limits") if f"{each}_units" in before]:
        del before[f"{name}_units"]
        if name not in before and f"{EXACT}_{name}" not in before:
            continue  # in which results that were joined differed
        if f"{EXACT}_{name}" not in before:
            raise InputError(f"a result in SI units must have {EXACT}_{name}, got none")
        before[name] = before.pop(f"{EXACT}_{name}")
    return before


def _parts(kind: str) -> dict[str, float]:
    """Return the number of each unit of a kind in one without a prefix; rates have no prefixes."""
    base = UNITS[kind]
    if kind == "rate":
        return {base: 1.0}
    if kind == "speed":
        return {unit: 1.0 / each for unit, each in OF_SPEED.items()}
    return {prefix + base: parts for prefix, parts in PREFIXES.items()}


def _checked(kind: str, unit: str) -> str:
    """Return a unit in the notation of UDUNITS; raise `InputError` if it is not of its kind."""
    if kind not in UNITS:
        raise InputError(f"units must be of {', '.join(UNITS)}, got {shown(kind)}")
    allowed = _parts(kind)
    # the micro sign and the Greek letter look the same
    plain = str(unit).replace("\u00b5", "u").replace("\u03bc", "u")
    if kind == "speed":
        plain = plain.replace("rad/s", "1/s")
    written = plain.replace("1/s", "s-1").replace("/s", " s-1")
    if written not in allowed:
        words = ", ".join(allowed)
        raise InputError(f"the unit of {kind} must be one of {words}, got {shown(unit)}")
    return written
