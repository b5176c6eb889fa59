"""What was asked: a verb of the package with its arguments, as JSON and back.

A study has it as its key, and a drop keeps it. To verify a result, or to resume a study, is to ask
the same question again.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact, Race, Stator, Support, Unbalance
from rotor_ida.results.kinds import loaded
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies.database import program_of
from rotor_ida.texts import in_shell

VALUES = {
    each.__name__: each
    for each in (Rotor, DimensionalRotor, RotorSystem, Contact, Stator, Race, Support, Unbalance)
}  # fmt: skip
# The functions that can be asked again: those of the results that are verified or studies.
VERBS = frozenset({
    "simulate", "run_up", "drop", "drop_ensemble", "sweep", "run_ups", "bifurcation_diagram",
    "basin", "basin_fractions", "continue_attractors", "limit_cycle", "continue_cycle",
    "bifurcation_curve", "synchronous_response", "folds", "hopf_points", "special_speeds",
    "campbell", "clearance_report", "lyapunov_exponent",
})  # fmt: skip
# The entry of plain values that says of what type they are, and one of these types.
TYPE, DATASET = "type", "Dataset"


@dataclass(frozen=True, slots=True)
class Question:
    """A function of the package and the arguments with which it was called.

    Parameters
    ----------
    verb : str
        Its name in `rotor_ida`.
    arguments : mapping
        Its arguments by name, that of the rotor or system as ``rotor``.

    Examples
    --------
    >>> asked = Question("folds", {"zeta": 0.07, "delta0": np.array([0.0, 0.5])})
    >>> asked.plain()
    {'zeta': 0.07, 'delta0': [0.0, 0.5]}
    >>> Question("folds", arguments_from(asked.plain())).ask().sizes["delta0"]
    2
    """

    verb: str
    arguments: Mapping[str, Any]

    def plain(self) -> dict[str, Any]:
        """Return the arguments as text, numbers, None, and lists and mappings of them."""
        found: dict[str, Any] = _plain(self.arguments, [])
        return found

    def design(self) -> dict[str, Any]:
        """Return the key of a study: the question, and what else determines the bits."""
        return {"verb": self.verb, **self.plain(), **computing()}

    @classmethod
    def of_design(cls, design: Mapping[str, Any]) -> Question:
        """Return the question in the key of a study."""
        program = program_of(design)
        plain = {name: each for name, each in design.items() if name not in program}
        return cls(plain.pop("verb"), arguments_from(plain))

    def text(self) -> str:
        """Return the arguments as the text that a dataset keeps."""
        return json.dumps(self.plain(), separators=(",", ":"))

    def python(self, rotor: str = "") -> str:
        """Return the call in Python, an argument a line; `rotor` is a name for that argument.

        Examples
        --------
        >>> asked = Question("simulate", {"rotor": Rotor(omega=1.7, zeta=0.07, delta0=0.5)})
        >>> print(Question("simulate", {**asked.arguments, "duration": 5.0}).python())
        simulate(
            Rotor(omega=1.7, zeta=0.07, delta0=0.5),
            duration=5.0,
        )
        """
        words = [
            rotor or written(each) if name == "rotor" else f"{name}={written(each)}"
            for name, each in self.arguments.items()
        ]
        return "\n".join([f"{self.verb}(", *(f"    {word}," for word in words), ")"])

    def command(self) -> str:
        """Return the command that asks it, of one disc: each argument is an option.

        Examples
        --------
        >>> asked = Question("folds", {"zeta": 0.07, "delta0": (0.0, 0.5)})
        >>> asked.command()
        'rotor-ida folds --zeta 0.07 --delta0 0.0 0.5'
        """
        given = dict(self.arguments)
        given = (given.pop("rotor").given if "rotor" in given else {}) | given
        words = ["rotor-ida", self.verb.replace("_", "-")]
        for name, each in given.items():
            values = [each] if isinstance(each, str) else np.ravel(each).tolist()
            words += [f"--{name.replace('_', '-')}", *map(str, values)]
        return " ".join(map(in_shell, words))

    def ask(self, **jobs: Any) -> xr.Dataset:
        """Return the answer; `jobs`, such as workers and progress, are left out if unknown."""
        if self.verb not in VERBS:
            raise InputError(
                f"a question must be one of {', '.join(sorted(VERBS))}, got {shown(self.verb)}"
            )
        function, arguments = loaded(f"rotor_ida:{self.verb}"), dict(self.arguments)
        rotor = [arguments.pop("rotor")] if "rotor" in arguments else []
        taken = inspect.signature(function).parameters
        jobs = {name: each for name, each in jobs.items() if name in taken and each is not None}
        answer: xr.Dataset = function(*rotor, **arguments, **jobs)
        return answer


def arguments_from(plain: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments that `Question.plain` made plain.

    Examples
    --------
    >>> shared = Stator(mass=1.0, stiffness=2.0)
    >>> touches = [Contact(node="disc", clearance=gap, stiffness=4.0, stator=shared)
    ...            for gap in (0.5, 0.6)]
    >>> system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...                      contacts=touches)
    >>> asked = Question("drop", {"rotor": system, "speed": 2.0})
    >>> again = arguments_from(asked.plain())
    >>> one, other = again["rotor"].contacts
    >>> again["rotor"].nodes, one.stator is other.stator
    ({'disc': (0, 1)}, True)
    >>> Question("drop", again).text() == asked.text()
    True
    """
    return dict(_given(plain, {}))


def arguments_in(text: str) -> dict[str, Any]:
    """Return the arguments in the text of a dataset."""
    try:
        return arguments_from(json.loads(text))
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise InputError(f"a question must be arguments in JSON, got {shown(text)}") from error


def written(value: Any) -> str:
    """Return a rotor, a number, a text, an array or a sequence of them in Python.

    Examples
    --------
    >>> written(Rotor(omega=1.7, zeta=0.07, delta0=0.5)), written(np.array([0.1, 2.0]))
    ('Rotor(omega=1.7, zeta=0.07, delta0=0.5)', '[0.1, 2.0]')
    """
    if isinstance(value, Rotor | DimensionalRotor):
        given = ", ".join(f"{name}={each!r}" for name, each in value.given.items())
        return f"{type(value).__name__}({given})"
    return repr(value.tolist() if isinstance(value, np.ndarray | np.generic) else value)


def _plain(value: Any, stators: list[Stator]) -> Any:
    """Return a value as JSON has it; `stators` are those before it, by number."""
    if isinstance(value, xr.Dataset):  # a mapping too
        return {TYPE: DATASET, **value.to_dict()}
    if isinstance(value, Mapping):
        return {str(name): _plain(each, stators) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each, stators) for each in value]
    if type(value).__name__ in VALUES:
        return _plain_fields(value, stators)
    if isinstance(value, np.ndarray | np.generic | xr.DataArray):
        numbers = np.asarray(value)
        return (numbers.astype(float) if numbers.dtype == object else numbers).tolist()
    # fractions and decimals are numbers too
    return value if value is None or isinstance(value, str | float | int) else float(value)


def _plain_fields(value: Any, stators: list[Stator]) -> dict[str, Any]:
    """Return the fields that are not None; of a stator of several contacts once."""
    found: dict[str, Any] = {TYPE: type(value).__name__}
    if isinstance(value, Stator):
        found["number"] = next((n for n, each in enumerate(stators) if each is value), len(stators))
        if found["number"] < len(stators):
            return found
        stators.append(value)
    held = {each.name: getattr(value, each.name) for each in fields(value)}
    return found | {name: _plain(each, stators) for name, each in held.items() if each is not None}


def _given(value: Any, stators: dict[int, Stator]) -> Any:
    """Return the value that `_plain` made plain; `stators` are those before it, by number."""
    if isinstance(value, list):
        is_row = all(isinstance(each, str | float | int) for each in value)
        return tuple(value) if is_row else [_given(each, stators) for each in value]
    if not isinstance(value, Mapping):
        return value
    name = value.get(TYPE)
    if name == DATASET:
        return xr.Dataset.from_dict(dict(value))
    held = {key: _given(each, stators) for key, each in value.items()}
    if not isinstance(name, str):  # a mapping, of nodes for instance
        return held
    del held[TYPE]
    number = held.pop("number", None)
    if number in stators:
        return stators[number]
    made: Any = VALUES[name](**held)
    return made if number is None else stators.setdefault(number, made)
