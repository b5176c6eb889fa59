"""Cycles and fits of the rotor system of a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rotor_ida.checks import State, shown
from rotor_ida.cli.output import Output
from rotor_ida.cli.parsing import refuse_units
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    from rotor_ida.model.rotor_system import RotorSystem
    from rotor_ida.results.system_file import Course

SPEED = "speed"


def cycle_case(
    file: Path,
    rotor: RotorOptions,
    start: State | str | None,
    output: Output,
    *,
    without_gravity: bool,
) -> tuple[RotorSystem, dict[str, Any]]:
    """Return the system of a file, and what its cycles are computed from."""
    _check(rotor, output)
    system, course = case_of(file, rotor.given)
    course = _begun(course, start)
    if without_gravity:
        system = replace(system, gravity=None)
    speed = rotor.given.get(SPEED, course.speed)
    return system, {"start": course.start, "modes": course.modes, SPEED: speed}


def system_to_fit(
    file: Path, rotor: RotorOptions, start: State | str | None, output: Output
) -> RotorSystem:
    """Return the system of a file as a first guess."""
    from rotor_ida.model.few_modes import in_modes  # noqa: PLC0415 - heavy

    _check(rotor, output)
    if start is not None:
        _word(start)
    system, course = case_of(file, rotor.given)
    return in_modes(system, course.modes, None)[0]


def _begun(course: Course, start: State | str | None) -> Course:
    """Return a course that begins as the option says, if it is given."""
    return course if start is None else replace(course, start=_word(start))


def _word(start: State | str) -> str:
    """Return the word of a start; the four numbers are of one disc."""
    if isinstance(start, str):
        return start
    raise InputError(f"start must be settled or rest with a rotor system, got {shown(start)}")


def _check(rotor: RotorOptions, output: Output) -> None:
    """Refuse what is of one disc only, and bad paths."""
    for name, value in {**rotor.given, "machine": rotor.machine}.items():
        if value is not None and name != SPEED:
            raise InputError(f"{name} must be left out with a rotor system, got {shown(value)}")
    output.check()


def case_of(file: Path, given: Mapping[str, Any]) -> tuple[RotorSystem, Course]:
    """Return what a file says; options with units are for one in SI units."""
    from rotor_ida.results.system_file import read_system_file  # noqa: PLC0415 - heavy

    system, course = read_system_file(file)
    if system.units != "SI":
        refuse_units(given)
    return system, course
