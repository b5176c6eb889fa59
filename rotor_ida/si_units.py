"""Results of a real machine in SI units."""

from __future__ import annotations

import xarray as xr

from rotor_ida.checks import check_instance
from rotor_ida.errors import InputError
from rotor_ida.parameters import DimensionalRotor
from rotor_ida.schema import QUANTITIES

UNITS = {
    "length": "m",
    "time": "s",
    "velocity": "m s-1",
    "force": "N",
    "impulse": "N s",
    "energy": "J",
    "rate": "s-1",
}


def dimensional(dataset: xr.Dataset, machine: DimensionalRotor) -> xr.Dataset:
    """Return a result with displacements, times, velocities and forces in SI units.

    Parameters
    ----------
    dataset : Dataset
        A dimensionless result of this package.
    machine : DimensionalRotor
        The machine it belongs to.

    Returns
    -------
    Dataset
        The same variables in m, s, m/s and N; parameters, phases, kinds and counts unchanged.

    Raises
    ------
    InputError
        If the dataset is in SI units already.

    Notes
    -----
    ``Z = D z``, ``T = t/omega_0``, force ``k D**1.5 f``, with ``omega_0**2 = k sqrt(D)/m``.

    References
    ----------
    Eq. (9) of the paper, Mechanika 25(6), 2019, which prints ``omega_0**2 = k/m``.

    Examples
    --------
    >>> from rotor_ida import simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=20.0)
    >>> dimensional(run, machine).t.attrs["units"]
    's'
    """
    check_instance("dataset", dataset, xr.Dataset)
    check_instance("machine", machine, DimensionalRotor)
    if "length_scale" in dataset.attrs:
        raise InputError("the dataset is in SI units already")
    scales = {
        "length": machine.length_scale,
        "time": machine.time_scale,
        "velocity": machine.velocity_scale,
        "force": machine.force_scale,
        "impulse": machine.force_scale * machine.time_scale,
        "energy": machine.force_scale * machine.length_scale,
        "rate": machine.reference_frequency,
    }
    converted = {}
    for name, variable in dataset.variables.items():
        quantity = QUANTITIES.get(str(name))
        if quantity is not None and quantity.scale:
            attributes = {**variable.attrs, "units": UNITS[quantity.scale]}
            values = variable.values * scales[quantity.scale]
            converted[name] = xr.Variable(variable.dims, values, attributes)
    result = dataset.assign({name: converted[name] for name in converted})
    return result.assign_attrs(**{f"{kind}_scale": value for kind, value in scales.items()})
