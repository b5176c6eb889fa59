"""The question of a result: a function of the package with its arguments, as JSON and back.

A study has it as its key, and a result as an attribute, without dimensions for one disc. To verify
a result, or to resume a study, is to ask the same question again.
"""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS, shown
from rotor_ida.errors import InputError
from rotor_ida.model.bearing import Bearing
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, name_of
from rotor_ida.model.system_parts import Contact, Race, Stator, Support, Unbalance
from rotor_ida.results.dataset_kinds import loaded
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies import design_of, program_of
from rotor_ida.texts import in_shell

VALUES = {
    each.__name__: each
    for each in (Rotor, DimensionalRotor, RotorSystem, Bearing, Contact, Stator, Race, Support,
                 Unbalance)
}  # fmt: skip
# The functions that can be asked again: those of the results that are verified or studies.
VERBS = frozenset({
    "simulate", "run_up", "drop", "drop_ensemble", "sweep", "run_ups", "bifurcation_diagram",
    "basin", "basin_fractions", "continue_attractors", "touchdown_report", "limit_cycle",
    "continue_cycle", "bifurcation_curve", "synchronous_response", "folds", "hopf_points",
    "special_speeds", "campbell", "clearance_report", "lyapunov_exponent", "poincare_section",
})  # fmt: skip
# The entry of plain values that says of what type they are, and one of these types.
TYPE, DATASET = "type", "Dataset"
# Attribute of a result, and the entry of it with the name of the function.
QUESTION, VERB = "question", "verb"
# Arguments that do not change the answer, so that no file chooses them.
JOBS = ("workers", "executor", "study", "progress")
# Types that JSON has.
PLAIN = (float, str, bool, int)
# An argument, and the variables of a run of a rotor system that have its state and the system.
START, STATE, MATRIX = "start", "start_state", "mass_matrix"
# A question with more numbers is not kept.
MOST_NUMBERS = 1_000_000
# Functions whose samples are computed again at the times of the result.
SAMPLED = ("simulate", "run_up", "drop")


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
        return {VERB: self.verb, **self.plain(), **computing()}

    @classmethod
    def of_design(cls, design: Mapping[str, Any]) -> Question:
        """Return the question in the key of a study."""
        program = program_of(design)
        plain = {name: each for name, each in design.items() if name not in program}
        return cls(plain.pop(VERB), arguments_from(plain))

    @classmethod
    def of_result(cls, dataset: xr.Dataset) -> Question | None:
        """Return the question that a result keeps; None if it has none.

        Examples
        --------
        >>> from rotor_ida import folds
        >>> Question.of_result(folds(zeta=0.07, delta0=0.5))
        Question(verb='folds', arguments={'zeta': 0.07, 'delta0': 0.5})
        """
        text = dataset.attrs.get(QUESTION)
        return cls.of_text(text) if isinstance(text, str) else None

    @classmethod
    def of_text(cls, text: str) -> Question:
        """Return the question in the text that a dataset keeps."""
        try:
            arguments = arguments_from(json.loads(text))
            verb = arguments.pop(VERB)
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise InputError(f"a question must be arguments in JSON, got {shown(text)}") from error
        return cls(str(verb), {each: arguments[each] for each in arguments if each not in JOBS})

    def text(self) -> str:
        """Return the question as the text that a dataset keeps."""
        plain = partial(_plain, stators=[])  # what JSON does not know
        return json.dumps({VERB: self.verb, **self.arguments}, separators=(",", ":"), default=plain)

    def attribute(self) -> dict[str, str]:
        """Return the attribute by which a dataset keeps the question; none for a very long one."""
        is_kept = sum(map(_size, self.arguments.values())) < MOST_NUMBERS
        return {QUESTION: self.text()} if is_kept else {}

    def python(self, rotor: str = "", others: str = "") -> str:
        """Return the call in Python, an argument a line.

        `rotor` is a name for that argument, and `others` the words of arguments by a mapping.

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
        words += [others] if others else []
        return "\n".join([f"{self.verb}(", *(f"    {word}," for word in words), ")"])

    def command(self) -> str:
        """Return the command that asks it, of one disc or a file: each argument is an option.

        Examples
        --------
        >>> asked = Question("folds", {"zeta": 0.07, "delta0": (0.0, 0.5)})
        >>> asked.command()
        'rotor-ida folds --zeta 0.07 --delta0 0.0 0.5'
        >>> Question("drop", {"rotor": Path("my rotor.toml"), "speed": "3000 rpm"}).command()
        "rotor-ida drop 'my rotor.toml' --speed '3000 rpm'"
        """
        given = dict(self.arguments)
        rotor = given.pop("rotor", None)
        words: list[str | Path] = ["rotor-ida", self.verb.replace("_", "-")]
        if isinstance(rotor, Path):
            words.append(rotor)
        elif rotor is not None:
            given = rotor.given | given
        for name, each in given.items():
            is_word = isinstance(each, str | Path)
            words.append(f"--{name.replace('_', '-')}")
            words += [each] if is_word else map(str, np.ravel(each).tolist())
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


def with_question(
    answer: xr.Dataset, verb: Callable[..., Any], given: Sequence[Any], options: Mapping[str, Any]
) -> xr.Dataset:
    """Give an answer the question to a function, called with these arguments, as an attribute.

    Studies do that themselves, and so do not depend on how they were asked for. Where an argument
    is left out, or a result, the answer has what came of it; if it does not, or for very many
    numbers, it keeps no question. A large system is left out where the answer has its matrices.
    """
    kept = answer.attrs.get(QUESTION, "")
    if kept.startswith(f'{{"{VERB}":"{name_of(verb)}"'):
        return answer
    answer.attrs.pop(QUESTION, None)  # of a part of the computation
    if study := options.get("study"):
        question = Question.of_design(design_of(study))
        if question.verb == name_of(verb):
            answer.attrs[QUESTION] = question.text()
        return answer
    arguments = _arguments(verb, given, options)
    kept = {name: each for name, each in arguments.items() if each is not None}
    left = {"rate", START} if STATE in answer.variables else {"rate"}  # there may be a ramp_time
    for name, each in arguments.items():
        parts = each if isinstance(each, list | tuple) else [each]
        if name in left and each is None:
            continue
        if each is None or any(isinstance(part, xr.Dataset) for part in parts):
            kept[name] = _resolved(name, answer)
            if kept[name] is None and each is not None:
                return answer
    if name_of(verb) in SAMPLED and _size(kept.get("samples")) > 1:
        del kept["samples"]
    has_system = MATRIX in answer.variables and name_of(verb) != "drop"  # but how it was held
    if has_system and _size(kept["rotor"]) >= MOST_NUMBERS:
        bearings = kept.get("bearings") or kept["rotor"].bearings
        if any(each.varies for each in bearings):
            return answer  # its matrices have them at one speed, or not
        # its matrices and variables have all of these
        for name in {"rotor", *SystemParameters.__annotations__} & kept.keys():
            del kept[name]
        if kept.pop("modes", None) is not None and STATE in answer.variables:
            kept[START] = _resolved(START, answer)  # its matrices are in these modes too
    kept = {name: each for name, each in kept.items() if each is not None}
    answer.attrs |= Question(name_of(verb), kept).attribute()
    return answer


def _resolved(name: str, answer: xr.Dataset) -> Any:
    """Return the value of an argument by an answer; None if it does not have it."""
    if name == "starts" and all(f"start_{each}" in answer.variables for each in COMPONENTS):
        columns = [answer.variables[f"start_{each}"].values for each in COMPONENTS]
        states = np.column_stack(columns)
        words = str(answer.attrs.get("start_words", "")).split()
        if not words:
            return states
        pairs = zip(words, states.tolist(), strict=True)
        return [state if word == "state" else word for word, state in pairs]
    if name == START and STATE in answer.variables:
        return tuple(answer.variables[STATE].values.reshape(2, -1))
    return answer.attrs.get(name)


def _size(value: Any) -> int:
    """Return about how many numbers an argument has."""
    if isinstance(value, RotorSystem):
        return 5 * value.size**2
    return int(getattr(value, "size", len(value) if isinstance(value, list | tuple) else 1))


def _arguments(
    verb: Callable[..., Any], given: Sequence[Any], options: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the arguments of a call by name, with defaults, and the rotor under that name.

    As `inspect.Signature.bind` does, without its checks: the call has succeeded.
    """
    defaults = _defaults(verb)
    names = list(defaults)
    found = {**defaults, **dict(zip(names, given, strict=False)), **options}
    first = names[0]
    return {
        "rotor" if name in {first, "rotor", "system"} else name: each
        for name, each in found.items()
        if name not in JOBS
    }


@cache
def _defaults(verb: Callable[..., Any]) -> dict[str, Any]:
    """Return the arguments of a function in order, None where they have no default."""
    each = inspect.signature(verb).parameters.values()
    named = [one for one in each if one.kind is not inspect.Parameter.VAR_KEYWORD]
    return {one.name: None if one.default is one.empty else one.default for one in named}


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
    if hasattr(value, "__array__"):  # also of pandas
        numbers = np.asarray(value)
        return (numbers.astype(float) if numbers.dtype == object else numbers).tolist()
    is_plain = value is None or isinstance(value, str | float | int)
    return value if is_plain else float(value)  # fractions and decimals are numbers too


def _plain_fields(value: Any, stators: list[Stator]) -> dict[str, Any]:
    """Return the fields that are not None; of a stator of several contacts once."""
    found: dict[str, Any] = {TYPE: type(value).__name__}
    if isinstance(value, Stator):
        found["number"] = next((n for n, each in enumerate(stators) if each is value), len(stators))
        if found["number"] < len(stators):
            return found
        stators.append(value)
    for name in _fields(type(value).__name__):
        if (each := getattr(value, name)) is not None:
            found[name] = each if type(each) in PLAIN else _plain(each, stators)
    return found


@cache
def _fields(kind: str) -> tuple[str, ...]:
    return tuple(each.name for each in fields(VALUES[kind]) if each.init)


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
