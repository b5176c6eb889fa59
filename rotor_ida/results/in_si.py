"""The border between SI units and dimensionless numbers: verbs of a `Rotor` take a machine too.

It is also the place where an answer gets its question (`rotor_ida.results.question`): the
decorators here, but for `keeps_si`, call a function and keep its name and arguments in the result.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from inspect import Parameter, signature
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar, cast

import numpy as np
import xarray as xr

from rotor_ida.checks import check_array, did_you_mean, listed, shown
from rotor_ida.errors import Amount, InputError, RotorError, SimulationError
from rotor_ida.model.parameters import OF_MACHINE
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import (
    KINDS,
    RotorSystem,
    SystemParameters,
    name_of,
    refuse_first,
)
from rotor_ida.model.scales import (
    BECOMES,
    IS_OF_MACHINE,
    UNITS_OF_ARGUMENTS,
    errors_in_units,
    unit_of,
    unit_of_parameter,
    unit_scale,
    without_units,
)
from rotor_ida.results.machine_file import load_machine, save_machine
from rotor_ida.results.question import with_question
from rotor_ida.results.si_units import (
    dimensional,
    dimensionless,
    in_units_of,
    machine_of,
    rescaled,
)
from rotor_ida.results.studies.store import FILE, MACHINE_FILE

Asked = ParamSpec("Asked")
Found = TypeVar("Found")
Verb = TypeVar("Verb", bound=Callable[..., xr.Dataset])
Failure = TypeVar("Failure", bound=RotorError)


def takes_rotors(
    *,
    disc: Collection[str] = (),
    system: Collection[str] = (),
    needed: Collection[str] = ("speed",),
    defaults: Mapping[str, tuple[Any, Any]] = {},
    varies: bool = False,
) -> Callable[[Verb], Verb]:
    """Return a decorator of a function of a `Rotor` or a `RotorSystem`.

    The function takes a `DimensionalRotor` too, as by `takes_si`, and in errors about a system
    numbers have its units.

    Parameters
    ----------
    disc, system : collection of str
        Keywords that only one disc, or only a rotor system, takes. Their defaults count as left
        out; of a system, those of one disc are None.
    needed : collection of str
        Keywords that a rotor system must be given.
    defaults : mapping of str to tuple
        Defaults that differ, of one disc and of a system; or functions of the other arguments.
    varies : bool
        Whether other keywords vary parameters. The ``speed`` of a machine is one of these.
    """
    only = {"one disc": ("speed", *system, *SystemParameters.__annotations__),
            "a rotor system": tuple(disc)}  # fmt: skip

    def decorated(verb: Verb) -> Verb:
        parameters = signature(verb).parameters
        known = () if varies else {*parameters, *SystemParameters.__annotations__}
        of_disc, of_system = takes_si(verb, known), takes_system(verb)
        usual = {name: each.default for name, each in parameters.items()}

        @wraps(verb)
        def either(*given: Any, **options: Any) -> xr.Dataset:
            rotor = given[0] if given else options.get("rotor")
            if not isinstance(rotor, Rotor | DimensionalRotor | RotorSystem | None):
                refuse_first(either, KINDS, rotor)
            is_system = isinstance(rotor, RotorSystem)
            kind = "a rotor system" if is_system else "one disc"
            is_varied = varies and isinstance(rotor, DimensionalRotor)
            for name in only[kind]:
                value = options.get(name)
                if value is None or value is usual.get(name) or (is_varied and name == "speed"):
                    continue
                raise InputError(f"{name} must be left out with {kind}, got {shown(value)}")
            for name, values in defaults.items():
                if options.get(name) is None:
                    usual_value = values[is_system]
                    options[name] = usual_value(options) if callable(usual_value) else usual_value
            if not is_system:
                return of_disc(*given, **options)
            if missing := [name for name in needed if name not in options]:
                raise TypeError(f"{name_of(verb)}() of a RotorSystem needs {listed(missing)}")
            options = options if varies else dict.fromkeys(disc) | options
            return of_system(*(given or (options.pop("rotor"),)), **options)

        return cast("Verb", either)

    return decorated


def takes_si(verb: Verb, known: Collection[str] = ()) -> Verb:
    """Return a function of a `Rotor` that also takes a `DimensionalRotor`, and is in SI units then.

    The rotor may be left out where the function has a default. Arguments become dimensionless by
    their names (`rotor_ida.model.scales`), and the result gets SI units. A start that is a dataset
    has its own units. Arguments other than the `known` are refused, by default those that the
    signature does not have.
    """
    parameters = signature(verb).parameters
    defaults = {
        name: each.default for name, each in parameters.items()
        if name in {"parameter", "parameters"}
    }  # fmt: skip
    allowed = known or parameters
    takes_all = allowed is parameters and any(
        each.kind is Parameter.VAR_KEYWORD for each in parameters.values()
    )
    is_needed = "rotor" in parameters and parameters["rotor"].default is Parameter.empty

    def refuse_unknown(options: Mapping[str, Any]) -> None:
        if not takes_all and (unknown := [name for name in options if name not in allowed]):
            raise TypeError(
                f"{name_of(verb)}() got an unexpected keyword argument {shown(unknown[0])}"
                f"{did_you_mean(unknown[0], allowed)}"
            )

    @wraps(verb)
    def either(*given: Any, **options: Any) -> xr.Dataset:
        is_given = bool(given) or "rotor" in options
        rotor = given[0] if given else options.get("rotor")
        if is_given and is_needed and not isinstance(rotor, Rotor | DimensionalRotor):
            refuse_first(verb, "a Rotor or DimensionalRotor", rotor)
        if not isinstance(rotor, DimensionalRotor) or (given and "rotor" in options):
            if isinstance(start := options.get("start"), xr.Dataset):
                options["start"] = dimensionless(start)
            refuse_unknown(options)
            return with_question(verb(*given, **options), verb, given, options)
        options.pop("rotor", None)
        plain = without_dimensions(rotor, defaults | options)
        refuse_unknown(options)
        try:
            with kept_machine(options.get("study"), rotor):
                given = (rotor.rotor(), *given[1:])
                found = with_question(verb(*given, **plain), verb, given, plain)
        except (InputError, SimulationError) as error:
            raise in_si(error, rotor) from error
        return dimensional(found, rotor)

    return cast("Verb", either)


def takes_system(verb: Verb) -> Verb:
    """Return a function of a rotor system that keeps its question, with units in its errors."""

    @wraps(verb)
    def either(*given: Any, **options: Any) -> xr.Dataset:
        system = given[0] if given else options.get("system")
        is_machine = isinstance(system, DimensionalRotor)
        with errors_in_units("SI" if is_machine else getattr(system, "units", "")):
            return with_question(verb(*given, **options), verb, given, options)

    return cast("Verb", either)


def keeps_si(
    analysis: Callable[Concatenate[xr.Dataset, Asked], Found],
) -> Callable[Concatenate[xr.Dataset, Asked], Found]:
    """Return a function of a dimensionless result that also takes one in SI units, as its answer.

    Examples
    --------
    >>> from rotor_ida import contact_summary, simulate
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=5e-7, speed=600.0)
    >>> contact_summary(simulate(machine, duration=0.1)).largest_force.attrs["units"]
    'N'
    """
    first = next(iter(signature(analysis).parameters))

    @wraps(analysis)
    def either(*given: Any, **options: Any) -> Any:
        result = given[0] if given else options.get(first)
        machine = machine_of(result) if isinstance(result, xr.Dataset) else None
        if machine is None or result is None:
            return analysis(*given, **options)
        options.pop(first, None)
        given = given[1:]
        try:
            found = analysis(dimensionless(result), *given, **without_dimensions(machine, options))
        except (InputError, SimulationError) as error:
            raise in_si(error, machine) from error
        if isinstance(found, list):
            return [in_units_of(each, result) for each in found]
        return in_units_of(cast("xr.Dataset", found), result)

    return cast("Callable[Concatenate[xr.Dataset, Asked], Found]", either)


def without_dimensions(machine: DimensionalRotor, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of a verb of a machine without dimensions, by name.

    Parameters of the machine become those of the rotor, by their names too.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> without_dimensions(machine, {"speed": [600.0, 1000.0], "duration": 0.04, "rtol": 1e-9})
    {'omega': array([1.2, 2. ]), 'duration': 20.0, 'rtol': 1e-09}
    >>> without_dimensions(machine, {"mass": [4.0, 5.0]})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: mass must be left out, as it sets the scales of all results: give a
    machine with another one
    """
    for name in options:
        if name in OF_MACHINE and OF_MACHINE[name].sets_scales:
            raise InputError(
                f"{name} must be left out, as it sets the scales of all results: give a machine "
                "with another one"
            )
        if name in IS_OF_MACHINE:
            raise InputError(
                f"{name} must be left out with a machine: give its {IS_OF_MACHINE[name]}"
            )
    plain = {_plain_name(name): _plain(machine, name, value) for name, value in options.items()}
    if "along" in options:
        plain["along"] = _plain_name(options["along"])
    if "parameters" in options:
        plain["parameters"], plain["limits"] = _several(machine, options)
    elif "limits" in options:
        parameter = options.get("parameter", "omega")
        plain["limits"] = _limits(machine, parameter, options["limits"])
        if "parameter" in options:
            plain["parameter"] = _plain_name(parameter)
    return plain


def in_si(error: Failure, machine: DimensionalRotor) -> Failure:
    """Return an error about dimensionless numbers of a machine with these in SI units.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=600.0)
    >>> error = InputError("{name} must be positive, got {value}", name="duration", value=-500.0)
    >>> print(in_si(error, machine))
    duration must be positive, got -1 s
    """

    def amount(field: str, name: str, place: int, value: float) -> float:
        unit = unit_of(field, place) or unit_of(name, place)
        has_scale = unit is not None and unit != "kg"
        return Amount(value * unit_scale(machine, unit), unit) if unit and has_scale else value

    return error.with_numbers(amount, IS_OF_MACHINE)


@contextmanager
def kept_machine(study: object, machine: DimensionalRotor) -> Iterator[None]:
    """Write a machine into the folder of a study that begins, so that it continues in SI units."""
    if not isinstance(study, (str, os.PathLike)) or not os.fspath(study):
        yield
        return
    folder, place = Path(study), Path(study) / MACHINE_FILE
    if place.exists() and load_machine(place) != machine:
        raise InputError(f"study must be of this machine, got {shown(study)} of another")
    if not place.exists() and (folder / FILE).exists():
        raise InputError(f"study must be of a machine, got {shown(study)} without dimensions")
    is_new = not place.exists() and not (folder.is_dir() and any(folder.iterdir()))
    if is_new:
        folder.mkdir(parents=True, exist_ok=True)
        save_machine(machine, place)
    try:
        yield
    finally:
        if is_new and not (folder / FILE).exists():  # it was refused
            place.unlink(missing_ok=True)


def in_units_of_study(dataset: xr.Dataset, study: str | os.PathLike[str]) -> xr.Dataset:
    """Return the dimensionless result of a study, in SI units if that is of a machine."""
    place = Path(study) / MACHINE_FILE
    return dimensional(dataset, load_machine(place)) if place.is_file() else dataset


def _plain(machine: DimensionalRotor, name: str, value: Any) -> Any:
    """Return an argument without dimensions; a word, a count or a wrong value as it is."""
    if name in {"start", "starts"} and isinstance(value, xr.Dataset):
        return rescaled(value, machine)
    apart = name == "starts" and isinstance(value, (list, tuple))
    if apart and any(isinstance(each, xr.Dataset | str) for each in value):
        return [_plain(machine, "start", each) for each in value]
    units = (unit_of_parameter(name),) if name in OF_MACHINE else UNITS_OF_ARGUMENTS.get(name)
    is_count = name in {"samples", "starts"} and _is_number(value)
    if units is None or value is None or is_count or isinstance(value, str):
        return value
    numbers = check_array(name, value)
    if len(units) == 1:
        plain = without_units(machine, units[0], numbers)
        return plain.item() if plain.ndim == 0 else plain
    if numbers.ndim == 0 or numbers.shape[-1] != len(units):
        return value  # the function refuses it, as it was given
    columns = [without_units(machine, unit, numbers[..., at]) for at, unit in enumerate(units)]
    return np.stack(columns, axis=-1)


def _is_number(value: Any) -> bool:
    """Return whether a value is no array or sequence."""
    return getattr(value, "ndim", 0 if not hasattr(value, "__len__") else 1) == 0


def _plain_name(parameter: Any) -> Any:
    """Return the dimensionless parameter for a name; what is none as it is."""
    return BECOMES.get(parameter, parameter) if isinstance(parameter, str) else parameter


def _limits(machine: DimensionalRotor, parameter: Any, limits: Any) -> Any:
    """Return limits of a parameter without dimensions."""
    is_name = isinstance(parameter, str)
    known = OF_MACHINE.get(IS_OF_MACHINE.get(parameter, parameter)) if is_name else None
    if known is None or known.sets_scales:
        return limits  # the function refuses the parameter
    values = check_array("limits", limits)
    return without_units(machine, unit_of_parameter(parameter), values).tolist()


def _several(machine: DimensionalRotor, options: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return parameters and their limits without dimensions; wrong ones as they are."""
    names, limits = options["parameters"], options.get("limits")
    if not isinstance(names, (tuple, list)):
        return names, limits
    plain = tuple(map(_plain_name, names))
    if isinstance(limits, Mapping):
        return plain, {_plain_name(each): _limits(machine, each, limits[each]) for each in limits}
    if not isinstance(limits, (tuple, list, np.ndarray)) or len(limits) != len(names):
        return plain, limits
    pairs = zip(names, limits, strict=True)
    return plain, [_limits(machine, name, each) for name, each in pairs]
