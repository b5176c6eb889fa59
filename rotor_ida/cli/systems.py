"""Simulate the rotor system of a file: it says most, options change its speed and solver."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rotor_ida
from rotor_ida.checks import State, listed, shown
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer, answer_whole, working
from rotor_ida.cli.parsing import Quantity, refuse_units
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.cli.rotor_options import RotorOptions, RotorsOptions
from rotor_ida.errors import InputError
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM

if TYPE_CHECKING:
    import xarray as xr

    from rotor_ida.model.rotor_system import RotorSystem
    from rotor_ida.results.system_file import Course

# Options of one disc that also apply to a system.
SPEED = "speed"
OF_SYSTEM = ("rtol", "method")


def simulate_file(
    file: Path,
    rotor: RotorOptions,
    start: State | str | None,
    solver: options.SolverOptions | options.RunUpSolverOptions,
    output: Output,
    given: Mapping[str, Any],
) -> Report:
    """Simulate the system of a file at a constant speed."""
    how = _checked(rotor.given, rotor.machine, solver, output)
    system, course = case_of(file, {**rotor.given, **given})
    course = _begun(course, start)
    speed = rotor.given.get(SPEED, course.speed)
    if speed is None:
        raise InputError(f"speed must be given with --speed or in {file}")
    with working("simulate [%]") as progress, _told_by_the_answer():
        run = rotor_ida.simulate(
            system, **course.motion, **given, **how, speed=speed, progress=progress
        )
    return answer(run, output, most=FIRST_ROWS)


def section_file(
    file: Path,
    rotor: RotorOptions,
    start: State | str | None,
    solver: options.RunUpSolverOptions,
    output: Output,
    given: Mapping[str, Any],
) -> Report:
    """Compute a section through a motion of the system of a file."""
    how = _checked(rotor.given, rotor.machine, solver, output)
    system, course = case_of(file, rotor.given)
    course = _begun(course, start)
    speed = rotor.given.get(SPEED, course.speed)
    if speed is None:
        raise InputError(f"speed must be given with --speed or in {file}")
    with working("section [%]") as progress:
        section = rotor_ida.poincare_section(
            system, start=course.start, modes=course.modes, **given, **how, speed=speed,
            progress=progress,
        )  # fmt: skip
    return answer(section, output, most=FIRST_ROWS)


def run_up_file(
    file: Path,
    rotor: RotorOptions,
    change: options.ChangeOptions,
    start: State | str | None,
    solver: options.SolverOptions | options.RunUpSolverOptions,
    output: Output,
    given: Mapping[str, Any],
) -> Report:
    """Simulate the system of a file at a changing speed."""
    how = _checked(rotor.given, rotor.machine, solver, output)
    of_change = {name: each for name, each in asdict(change).items() if each is not None}
    system, course = case_of(file, {**rotor.given, **given, **of_change})
    course = _begun(course, start)
    with working("run-up [%]") as progress, _told_by_the_answer():
        ways = _change(course, rotor, of_change)
        run = rotor_ida.run_up(system, **course.motion, **given, **how, **ways, progress=progress)
    return answer(run, output, most=FIRST_ROWS)


def sweep_file(
    file: Path,
    rotors: RotorsOptions,
    axes: Mapping[str, list[float] | None],
    starts: list[State | str] | None,
    solver: options.SolverOptions | options.RunUpsSolverOptions,
    output: Output,
    given: Mapping[str, Any],
    *,
    is_diagram: bool = False,
) -> Report:
    """Simulate the settled responses of the system of a file over speeds and its parameters.

    They are those of a sweep, or a bifurcation diagram.
    """
    what = "diagram" if is_diagram else "sweep"
    verb = rotor_ida.bifurcation_diagram if is_diagram else rotor_ida.sweep
    varied, how = _varied(rotors, axes, solver, output, f"a {what}")
    if SPEED not in rotors.values:
        raise InputError(f"speed must be given with --speed for a {what} of a rotor system")
    system, course = case_of(file, {**rotors.values, **axes})
    with working(what, given["study"]) as progress:
        dataset = verb(
            system, starts=_starts(course, starts), modes=course.modes, speed=rotors.values[SPEED],
            **varied, **given, **how, progress=progress,
        )  # fmt: skip
        return answer_whole(dataset, output, given["study"])


def run_ups_file(
    file: Path,
    rotors: RotorsOptions,
    axes: Mapping[str, list[float] | None],
    starts: list[State | str] | None,
    solver: options.RunUpsSolverOptions,
    output: Output,
    given: Mapping[str, Any],
) -> Report:
    """Simulate many run-ups of the system of a file, by default from its first speed."""
    varied, how = _varied(rotors, axes, solver, output, "run-ups")
    system, course = case_of(file, {**rotors.values, **axes, **given})
    speed = rotors.values.get(SPEED, course.run_up.get(SPEED, 0.0))
    with working("run-ups", given["study"]) as progress:
        dataset = rotor_ida.run_ups(
            system, starts=_starts(course, starts), modes=course.modes, speed=speed, **varied,
            **given, **how, progress=progress,
        )  # fmt: skip
        return answer_whole(dataset, output, given["study"])


def _varied(
    rotors: RotorsOptions,
    axes: Mapping[str, list[float] | None],
    solver: options.SolverOptions | options.RunUpSolverOptions,
    output: Output,
    words: str,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what varies of a system besides its speed, and the options of the solver."""
    values: dict[str, Any] = {**rotors.values, **axes}
    varied = {name: values.pop(name) for name in PARAMETERS_OF_SYSTEM
              if values.get(name) is not None}  # fmt: skip
    how = _checked(values, rotors.machine, solver, output)
    _refuse_units_of_factors(varied)
    if how.pop("method", "taylor") != "taylor":
        raise InputError(
            f"method must be taylor for {words} of a rotor system, got {solver.method}"
        )
    return {name: each[0] if len(each) == 1 else each for name, each in varied.items()}, how


def basin_file(
    verb: Callable[..., xr.Dataset],
    file: Path,
    rotor: RotorOptions,
    node: str | None,
    start: State | str | None,
    output: Output,
    given: Mapping[str, Any],
) -> Report:
    """Compute basins of the system of a file, or their fractions, over the states of a node."""
    _checked(rotor.given, rotor.machine, options.SolverOptions(), output)
    system, course = case_of(file, {**rotor.given, **given})
    speed = rotor.given.get(SPEED, course.speed)
    if speed is None:
        raise InputError(f"speed must be given with --speed or in {file}")
    if node is None:
        nodes = listed([repr(each) for each in system.nodes], "or")
        raise InputError(f"node must be given with --node for a rotor system: {nodes}")
    chosen = {name: each for name, each in given.items() if name != "rtol" or each is not None}
    with working(verb.__name__, given.get("study")) as progress:
        dataset = verb(
            system, speed=speed, node=node, start=_begun(course, start).start, modes=course.modes,
            **chosen, progress=progress,
        )  # fmt: skip
        return answer_whole(dataset, output, given.get("study"))


def _refuse_units_of_factors(varied: Mapping[str, list[float]]) -> None:
    """Refuse a damping or stiffness with a unit, which is that of one disc."""
    for name, values in varied.items():
        unit = next((each.word for each in values if isinstance(each, Quantity)), "")
        if unit and PARAMETERS_OF_SYSTEM[name].unit == "1":
            raise InputError(
                f"{name} must be a factor without a unit for a rotor system, got {shown(unit)}"
            )


@contextmanager
def _told_by_the_answer() -> Iterator[None]:
    """Leave out the warnings of a run, as its answer says the same."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        yield


def cycle_case(
    file: Path,
    rotor: RotorOptions,
    start: State | str | None,
    output: Output,
    *,
    without_gravity: bool,
) -> tuple[RotorSystem, dict[str, Any]]:
    """Return the system of a file, and what its cycles are computed from."""
    _checked(rotor.given, rotor.machine, options.SolverOptions(), output)
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
    _checked(rotor.given, rotor.machine, options.SolverOptions(), output)
    if start is not None:
        _word(start)
    return linear_case(file, rotor.given, without_gravity=False)[0]


def _begun(course: Course, start: State | str | None) -> Course:
    """Return a course that begins as the option says, if it is given."""
    return course if start is None else replace(course, start=_word(start))


def _starts(course: Course, starts: list[State | str] | None) -> list[Any]:
    """Return the starts of many motions: those of the options, or that of the file."""
    return [course.start] if starts is None else [_word(each) for each in starts]


def _word(start: State | str) -> str:
    """Return the word of a start; the four numbers are of one disc."""
    if isinstance(start, str):
        return start
    raise InputError(f"start must be settled or rest with a rotor system, got {shown(start)}")


def _checked(
    quantities: Mapping[str, object],
    machine: Path | None,
    solver: options.SolverOptions | options.RunUpSolverOptions,
    output: Output,
) -> dict[str, Any]:
    """Return the options of the solver; refuse what is of one disc only, and bad paths."""
    of_disc: dict[str, object] = {**quantities, "machine": machine}
    of_disc.pop(SPEED, None)
    chosen, usual = asdict(solver), asdict(type(solver)())
    of_disc |= {name: each for name, each in chosen.items()
                if name not in OF_SYSTEM and each != usual[name]}  # fmt: skip
    for name, value in of_disc.items():
        if value is not None:
            raise InputError(f"{name} must be left out with a rotor system, got {shown(value)}")
    output.check()
    return {name: chosen[name] for name in OF_SYSTEM if chosen[name] is not None}


def _change(course: Course, rotor: RotorOptions, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the change of speed: that of the file, unless options give another."""
    begins = [each for each in (given.get("begin"), rotor.given.get(SPEED)) if each is not None]
    if len(begins) > 1:
        raise InputError("speed must be left out with --from, got both")
    ways = {name: each for name, each in given.items() if name != "begin"}
    replaces = bool(ways.keys() - {"duration"})
    found = {**({} if replaces else course.run_up), **ways}
    if "speeds" not in found:
        found[SPEED] = begins[0] if begins else course.run_up.get(SPEED, 0.0)
    elif begins:
        raise InputError(f"from must be left out with speeds, got {shown(begins[0])}")
    return found


def whirls_file(
    file: Path, rotors: RotorsOptions, output: Output, *, without_gravity: bool
) -> Report:
    """Compute the synchronous whirls of the system of a file."""
    speeds: Any = rotors.values.get(SPEED)
    for name, value in {**rotors.values, "machine": rotors.machine}.items():
        if name != SPEED and value is not None:
            raise InputError(f"{name} must be left out with a rotor system, got {shown(value)}")
    output.check()
    system, course = linear_case(file, {SPEED: speeds}, without_gravity=without_gravity)
    if speeds is None:
        speeds = course.speed
    if speeds is None:
        raise InputError(f"speed must be given with --speed or in {file}")
    found = rotor_ida.synchronous_response(system, speed=speeds)
    return answer(found, output, most=FIRST_ROWS)


def case_of(file: Path, given: Mapping[str, Any]) -> tuple[RotorSystem, Course]:
    """Return what a file says; options with units are for one in SI units."""
    from rotor_ida.results.system_file import read_system_file  # noqa: PLC0415 - heavy

    system, course = read_system_file(file)
    if system.units != "SI":
        refuse_units(given)
    return system, course


def linear_case(
    file: Path, given: Mapping[str, Any], *, without_gravity: bool
) -> tuple[RotorSystem, Course]:
    """Return what a file says, its system in a few modes if the file says so."""
    from rotor_ida.model.few_modes import in_modes  # noqa: PLC0415 - heavy

    system, course = case_of(file, given)
    if without_gravity:
        system = replace(system, gravity=None)
    return in_modes(system, course.modes, None)[0], course
