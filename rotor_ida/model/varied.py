"""A rotor and what varies: the given values of each parameter as axes, checked once."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import (
    MOST_NUMBERS,
    Meant,
    check_axis,
    check_distinct,
    check_points,
    is_scalar,
    listed,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import (
    ALL_PARAMETERS,
    DEFAULTS,
    NEED_CLEARANCE,
    PARAMETERS,
    Parameters,
    check_clearance_needed,
    check_exponent,
)
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, changed_system
from rotor_ida.model.system_parameters import (
    PARAMETERS_OF_SYSTEM,
    SPEED,
    UNBALANCE,
    SystemAxes,
    parameter_of,
    with_parameters,
)
from rotor_ida.model.system_parts import Unbalance

Axis = npt.NDArray[Any]
# Smallest nonzero and largest value of a parameter [1].
Range = tuple[float, float]
ANY: Range = (0.0, math.inf)
# Largest value of a parameter of a system, in its own: beyond, a run has no end in sight.
MOST_TIMES = 1e6


@dataclass(frozen=True, slots=True)
class Varied:
    """A rotor and what varies: all combinations of the values along the axes.

    Parameters
    ----------
    given : mapping of str to ndarray, shape () or (n,)
        The numbers of the rotor and the axes, parameters first, in the order of `ALL_PARAMETERS`
        [dimensionless]: numbers are scalar coordinates of a result, axes are its dimensions. An
        optional number equal to its default is left out. Behind them are the axes of what is no
        parameter, such as ``start``.
    system : RotorSystem, optional
        The system whose parameters, and whose speed, these are; without it they are those of one
        disc.
    """

    given: Mapping[str, Axis]
    system: RotorSystem | None = None

    @property
    def axes(self) -> dict[str, Axis]:
        """The values along each dimension."""
        return {name: values for name, values in self.given.items() if values.ndim}

    @property
    def dims(self) -> tuple[str, ...]:
        """Dimensions of a result, in order."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension."""
        return tuple(axis.size for axis in self.axes.values())

    @property
    def points(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def parameters(self) -> dict[str, Axis]:
        """The given parameters."""
        known = ALL_PARAMETERS if self.system is None else (SPEED, *PARAMETERS_OF_SYSTEM)
        return {name: each for name, each in self.given.items() if name in known}

    @property
    def optional(self) -> tuple[str, ...]:
        """Optional parameters that are given and are not one default number."""
        return tuple(name for name in self.parameters if name not in PARAMETERS)

    @property
    def varying(self) -> tuple[str, ...]:
        """Parameters of several values."""
        return tuple(name for name, each in self.parameters.items() if each.size > 1)

    @property
    def coordinates(self) -> dict[str, Column]:
        """The coordinates of a result: an axis of each dimension, and the numbers."""
        return {name: (name if each.ndim else (), each) for name, each in self.given.items()}

    @property
    def design(self) -> dict[str, Any]:
        """The parameters as plain numbers and lists, as a study stores them."""
        return {name: each.tolist() for name, each in self.parameters.items()}

    @property
    def columns(self) -> dict[str, Axis]:
        """All values at every point, the last dimension varying fastest."""
        grid = np.meshgrid(*self.given.values(), indexing="ij")
        return {name: part.ravel() for name, part in zip(self.given, grid, strict=True)}

    def over(self, **axes: Axis) -> Varied:
        """Return the same with these axes, in place of those of the same names or behind all."""
        return replace(self, given={**self.given, **axes})

    def without(self, *names: str) -> Varied:
        """Return the same without some parameters."""
        given = {name: each for name, each in self.given.items() if name not in names}
        return replace(self, given=given)

    def values(self, name: str) -> Values:
        """Return the values of a parameter, or its default if not given."""
        default = DEFAULTS.get(name)
        return np.atleast_1d(self.given.get(name, math.nan if default is None else default))

    def at(self, place: Sequence[int]) -> dict[str, Any]:
        """Return all values at a place, an index along each dimension."""
        index = dict(zip(self.dims, place, strict=True))
        return {name: each[index[name]] if each.ndim else each for name, each in self.given.items()}

    def rotor(self, place: Sequence[int]) -> Rotor:
        """Return the rotor at a place, an index along each dimension."""
        at = self.at(place)
        return Rotor(**{name: float(at[name]) for name in self.parameters})

    @property
    def base(self) -> RotorSystem:
        """The rotor system whose parameters vary."""
        assert self.system is not None
        return self.system

    def system_at(self, place: Sequence[int]) -> RotorSystem:
        """Return the rotor system at a place."""
        at = self.at(place)
        values = {name: float(at[name]) for name in self.parameters if name != SPEED}
        return with_parameters(self.base, values)

    def rotors(self) -> Iterator[Rotor]:
        """Yield the rotor at each place, the last dimension varying fastest."""
        return map(self.rotor, np.ndindex(self.shape))

    def extremes(self) -> list[Rotor]:
        """Return rotors with each value of each parameter, and the largest of all others.

        For the damping ratio and the shaft stiffness the largest value is enough: if any rotor
        cannot be simulated, then this one cannot.
        """
        largest = {name: float(values.max()) for name, values in self.parameters.items()}
        found = [
            Rotor(**largest | {name: value})
            for name, values in self.parameters.items()
            if values.size > 1 and name not in {"zeta", "shaft_stiffness"}
            for value in values.tolist()
        ]
        return found or [Rotor(**largest)]

    def check_size(self, most: int = MOST_NUMBERS) -> Varied:
        """Return the same, or raise `InputError` for too many points."""
        check_points(*self.axes.values(), most=most)
        return self


def varied_of(
    verb: Callable[..., object],
    rotor: Rotor | DimensionalRotor | None,
    given: Parameters,
    *,
    left_out: Mapping[str, str] = {},
    ranges: Mapping[str, Range] = {},
    others: Range = ANY,
    always: Collection[str] = PARAMETERS,
) -> Varied:
    """Return what a function is asked to vary, from its rotor and its keywords.

    Parameters
    ----------
    verb : callable
        The function, which messages name.
    rotor : Rotor, optional
        Its first argument.
    given : Parameters
        A number or a vector for each parameter given by keyword, which overrides that of `rotor`.
        None is the default of `disc_radius`.
    left_out : mapping of str to str
        Parameters that the function does not take, each with the reason.
    ranges : mapping of str to tuple of two floats
        Smallest nonzero and largest value of some parameters; `others` is that of all others.
    always : collection of str
        Parameters of which a number is an axis of one value.

    Raises
    ------
    InputError
        If a keyword is unknown, a parameter is missing, a value is not a finite number that is zero
        or positive, or is given twice on an axis, or if values exclude each other.

    Examples
    --------
    >>> def sweep(rotor=None, *, direction=None, **varied): ...
    >>> rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=0.1)
    >>> varied = varied_of(sweep, rotor, {"shaft_stiffness": [0.0, 0.25], "friction": 0.0})
    >>> varied.dims, varied.shape, varied.optional
    (('omega', 'zeta', 'delta0', 'shaft_stiffness'), (1, 1, 1, 2), ('shaft_stiffness', 'load'))
    >>> varied.rotor((0, 0, 0, 1))
    Rotor(omega=1.2, zeta=0.07, delta0=0.5, shaft_stiffness=0.25, load=0.1)
    >>> varied_of(sweep, rotor, {"frictionn": 0.1})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: sweep has no argument 'frictionn'; did you mean 'friction'?
    """
    asked = _asked(verb, rotor, given, left_out)
    found: dict[str, Axis] = {}
    for name in ALL_PARAMETERS:
        value, default = asked.get(name), DEFAULTS.get(name)
        if name not in asked or (value is None and name in DEFAULTS and default is None):
            continue
        smallest, largest = ranges.get(name, others)
        axis = check_distinct(name, check_axis(name, value, smallest=smallest, largest=largest))
        if name in always or not is_scalar(name, value):
            found[name] = axis
        elif axis[0] != default:
            found[name] = axis[0]
    varied = Varied(found)
    for exponent in varied.values("contact_exponent").tolist():
        check_exponent(exponent)
    if "delta0" in found and (found["delta0"] == 0.0).any():
        check_clearance_needed({name: float(varied.values(name).max()) for name in NEED_CLEARANCE})
    return varied


def varied_system_of(
    verb: Callable[..., Any], given: object, changed: SystemAxes, speed: Axis
) -> Varied:
    """Return what a function is asked to vary of a rotor system, from its keywords.

    Parameters
    ----------
    verb : callable
        The function, which messages name.
    given : RotorSystem, Rotor or DimensionalRotor
        Its first argument.
    changed : SystemAxes
        Fields of the system, in place of its own; and a number or a vector for each of its
        parameters that is given.
    speed : ndarray, shape () or (n,)
        The checked speeds.

    Raises
    ------
    InputError
        If a value is not a finite number that is zero or positive, is given twice on an axis, or
        fits no part of the system.

    Examples
    --------
    >>> def sweep(system, *, speed, **changed): ...
    >>> rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=5.0)
    >>> asked = varied_system_of(sweep, rotor, {"friction": [0.0, 0.2]}, np.array([1.2]))
    >>> asked.dims, asked.system_at((0, 1)).contacts[0].friction
    (('speed', 'friction'), 0.2)
    """
    fields: dict[str, Any] = dict(changed)
    numbers = {
        name: fields.pop(name)
        for name in PARAMETERS_OF_SYSTEM
        if name in fields and not (name == UNBALANCE and _is_list(fields[name]))
    }
    system = changed_system(verb, given, cast("Any", fields), others=PARAMETERS_OF_SYSTEM)
    found: dict[str, Axis] = {SPEED: speed}
    for name, value in numbers.items():
        largest = MOST_TIMES * (parameter_of(system, name) or 1.0)
        axis = check_distinct(name, check_axis(name, value, largest=largest))
        for end in (axis.min(), axis.max()):
            with_parameters(system, {name: float(end)})  # raises if the system may not have it
        found[name] = axis[0] if is_scalar(name, value) else axis
    return Varied(found, system)


def _is_list(value: object) -> bool:
    """Return whether an unbalance is given by its parts, or none."""
    parts = list(value) if isinstance(value, list | tuple) else [value]
    return not parts or any(isinstance(each, Unbalance) for each in parts)


def _asked(
    verb: Callable[..., object],
    rotor: Rotor | DimensionalRotor | None,
    given: Parameters,
    left_out: Mapping[str, str],
) -> dict[str, object]:
    """Return the parameters of a rotor, overridden by those given by keyword."""
    name = verb.__name__
    needed = [each for each in PARAMETERS if each not in left_out]
    keywords = ", ".join(f"{each}=..." for each in needed)
    if isinstance(rotor, DimensionalRotor):
        raise InputError(
            f"rotor must be a Rotor, got {shown(rotor)}: write {name}(machine.rotor(), ...), and "
            "dimensional(result, machine) for SI units"
        )
    if not isinstance(rotor, Rotor | None):
        raise InputError(
            f"rotor must be a Rotor, got {shown(rotor)}: write {name}(rotor, ...), or "
            f"{name}({keywords})"
        )
    known = [each for each in ALL_PARAMETERS if each not in left_out]
    for each in given:
        if each in left_out:
            raise InputError(f"{each} must be left out of {name}: {left_out[each]}")
        if each not in known:
            options = [*known, *inspect.signature(verb).parameters]
            raise InputError(
                "{verb} has no argument {given}{meant}", verb=name, given=shown(each),
                meant=Meant(each, tuple(word for word in options if word != "varied")),
            )  # fmt: skip
    asked: dict[str, object] = {**({} if rotor is None else rotor.given), **given}
    missing = [each for each in needed if each not in asked]
    if missing:
        raise InputError(
            f"{listed(missing)} must be given to {name}, or a rotor: {name}(rotor, ...), or "
            f"{name}({keywords})"
        )
    return {each: value for each, value in asked.items() if each in known}
