"""The command machine: from a data sheet to a file that the option --machine reads."""

from __future__ import annotations

import re
from pathlib import Path

from rotor_ida.cli.command import Case, command
from rotor_ida.cli.given import facts_of_machine
from rotor_ida.cli.output import check_file
from rotor_ida.cli.report import Report
from rotor_ida.cli.rotor_options import of_sheet
from rotor_ida.model.data_sheet import KEYS, check_keys, implausible
from rotor_ida.results.sheets import Line, Parts, facts
from rotor_ida.units import UnitSystem, read_in

ENDING = ".toml"
# Entries that are taken in rad/s where they have no unit, and what such a number looks like.
SPEEDS = {"speed": "--speed", "balance_speed": "--balance-speed"}
NUMBER = re.compile(r"\s*[\d.]+(e[+-]?\d+)?\s*")


@command("none", asks=("machine_from_data_sheet",), only=tuple(KEYS), writes=False)
def machine(
    case: Case, *, out: Path | None = None, inch: bool = False, as_json: bool = False,
    force: bool = False,
) -> Report:  # fmt: skip
    r"""Describe a machine by its data sheet, and write a file for the option --machine.

    A pump rotor balanced to G6.3, with a stator that it may touch:

        rotor-ida machine --mass 12kg --shaft-stiffness 4e6N/m \
            --damping-ratio 3% --clearance 150um --balance-grade G6.3 \
            --balance-speed 3600rpm --speed 3600rpm --friction 0.12 \
            --disc-radius 60mm --contact-stiffness 1e8N/m --out pump.toml

    Numbers without a unit are in SI units. Without --out the file is printed.
    """
    given = case.given
    check_keys(given, "machine")
    found = of_sheet(given, None)
    from rotor_ida.results.machine_file import machine_text, save_machine  # noqa: PLC0415
    from rotor_ida.results.plausible import speed_in_doubt  # noqa: PLC0415 - takes a moment

    plain = [name for name in SPEEDS if NUMBER.fullmatch(given.get(name, ""))]
    doubts = [speed_in_doubt(SPEEDS[name], float(given[name]), found.critical_speed)
              for name in plain]  # fmt: skip
    lines, warnings = facts_of_machine(found), [*implausible(found), *filter(None, doubts)]
    numbers = {name: float(f"{each:.6g}") for name, each in found.rotor().given.items()}
    parts: Parts = [
        facts("Machine", lines),
        facts("Dimensionless parameters", numbers),
        *(f"warning: {each}" for each in warnings),
    ]
    if out is None:
        parts += ["", machine_text(found).rstrip()]
    else:
        check_file("out", out, ENDING, force=force)
        save_machine(found, out, overwrite=force)
        parts.append(f"wrote {out}")
    told = dict(map(_usual, lines))
    record = {"machine": found.given, "facts": told | numbers, "warnings": warnings}
    system: UnitSystem = "inch" if inch else "metric"
    return Report(record=record, parts=parts, as_json=as_json, system=system)


def _usual(line: Line) -> tuple[str, float]:
    """Return a fact for a program, in a unit that does not depend on its size."""
    unit, parts = read_in(line.unit, system="metric")
    value = float(f"{float(str(line.values[0])) / parts:.6g}")
    return f"{line.name} [{unit}]" if unit else line.name, value
