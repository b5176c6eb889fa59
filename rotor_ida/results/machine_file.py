"""Machine files: the data sheet of a `DimensionalRotor` as TOML.

Each line is a quantity of `rotor_ida.machine_from_data_sheet`: a number in its SI unit, or a text
with a unit.

    mass = "12 kg"
    shaft_stiffness = 4e6          # N/m; or critical_speed = "5513 rpm"
    damping_ratio = "3 %"          # of the critical speed; or damping = 416 in N s/m
    clearance = "150 um"
    balance_grade = "G6.3"         # with its speed; or eccentricity, or unbalance = "200 g mm"
    balance_speed = "3600 rpm"
    speed = "3600 rpm"             # running speed
    contact_stiffness = "1e8 N/m"  # in N/m a linear contact, in N/m^1.5 one by Hertz
    friction = 0.12
    disc_radius = "60 mm"

A file may also give ``contact_exponent``, ``contact_damping`` in s/m, and ``load`` in N or as
``"weight"``.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np

from rotor_ida.checks import check_instance
from rotor_ida.errors import InputError
from rotor_ida.model.data_sheet import MILLIMETRE, check_keys, machine_from_data_sheet
from rotor_ida.model.parameters import OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor
from rotor_ida.results.files import check_target, file_to_write
from rotor_ida.results.toml_files import read_toml
from rotor_ida.units import quantity


def load_machine(path: str | os.PathLike[str]) -> DimensionalRotor:
    """Read a machine from a TOML file.

    Parameters
    ----------
    path : path-like
        A file from `save_machine` or ``rotor-ida machine``, or one written by hand. Each line
        gives a quantity of `machine_from_data_sheet`.

    Returns
    -------
    DimensionalRotor
        The machine in SI units.

    Raises
    ------
    InputError
        If the file cannot be read, or does not describe a machine.

    Examples
    --------
    >>> import tempfile
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = save_machine(machine, f"{folder}/disc.toml")
    ...     load_machine(f"{folder}/disc.toml") == machine
    True
    """
    sheet = read_data_sheet(path)
    check_keys(sheet, str(path))
    try:
        return machine_from_data_sheet(**sheet)  # type: ignore[arg-type]
    except InputError as error:
        raise error.within(f"{path}: ") from error


def read_data_sheet(path: str | os.PathLike[str]) -> dict[str, object]:
    """Return the quantities in a machine file as they are written there."""
    return read_toml("machine", path)


def save_machine(
    machine: DimensionalRotor, path: str | os.PathLike[str], *, overwrite: bool = False
) -> Path:
    """Write a machine to a TOML file, in SI units, with comments that explain each quantity.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine.
    path : path-like
        The file, for `load_machine` and the option ``--machine``.
    overwrite : bool
        Whether an existing file may be replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If the file cannot be written there.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> print(machine_text(machine).splitlines()[3])
    mass = 4.0  # kg: mass of the disc
    """
    check_instance("machine", machine, DimensionalRotor)
    place = check_target("path", path, overwrite=overwrite)
    with file_to_write(place, overwrite=overwrite) as part:
        part.write_text(machine_text(machine), encoding="utf-8")
    return place


def machine_text(machine: DimensionalRotor) -> str:
    """Return a machine as TOML with comments."""
    more = _in_other_words(machine)
    lines = [
        "# A machine for rotor_ida, in SI units. Words with a unit are allowed too,",
        '# such as clearance = "150 um" or speed = "3600 rpm".',
        "",
    ]
    for name, value in machine.given.items():
        parameter = OF_MACHINE[name]
        unit = parameter.shown_unit
        if name == "contact_stiffness" and machine.contact_exponent == 1.0:
            unit = "N/m"
        told = f"{unit}: {parameter.si_meaning}" if unit != "1" else parameter.si_meaning
        lines.append(f"{name} = {_number(value)}  # {told}{more.get(name, '')}")
    return "\n".join(lines) + "\n"


def _number(value: float) -> str:
    """Return a number as text that is read back to the same bits."""
    if 1e-3 <= value < 1e5:
        return repr(value)
    return np.format_float_scientific(value, trim="0", exp_digits=1)


def _in_other_words(machine: DimensionalRotor) -> dict[str, str]:
    """Return some quantities in the terms of a data sheet."""
    unbalance = quantity(machine.mass * machine.eccentricity, "kg m")
    found = {
        "eccentricity": f", {quantity(machine.eccentricity, 'm')}, {unbalance}",
        "clearance": f", {quantity(machine.clearance, 'm')}",
        "speed": f", {quantity(machine.speed, 'rad/s')}",
        "shaft_stiffness": f", critical speed {quantity(machine.critical_speed, 'rad/s')}",
        "contact_exponent": ", 1.5 by Hertz or 1 for a linear spring",
    }
    if machine.speed > 0.0:
        grade = machine.eccentricity * machine.speed / MILLIMETRE
        found["eccentricity"] += f", G{grade:.3g} at speed"
    if not math.isnan(machine.damping_ratio):
        found["damping"] = f", {machine.damping_ratio:.4g} of the critical speed"
    return found
