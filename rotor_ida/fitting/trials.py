"""The trials of a fit: the motions for values of what is sought, within a budget."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from rotor_ida.arrays import Stop, Values
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.motion import ANY_WORK, Body, Change, Motion, Turning, Word
from rotor_ida.fitting.records import Measured
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import with_parameters

# The largest work of a trial, in works of the first guess; the least that any trial is allowed
# [rad]; and of a search the largest number of trials, and the largest work of their derivatives, in
# that of the first guess.
MOST_WORK, LEAST_BUDGET = 20.0, 1e5
MOST_TRIALS, MOST_OF_ALL = 200, 100.0


@dataclass(frozen=True)
class Unknown:
    """One unknown.

    Parameters
    ----------
    name, role : str
        Its name, and the name of the same parameter in SI units.
    unit : str
        Its unit.
    guess, least : float
        The first guess, and the smallest value allowed.
    size : float
        Its natural size, as the guess may be 0.
    """

    name: str
    role: str
    unit: str
    guess: float
    least: float
    size: float


class SearchEnded(Exception):  # noqa: N818 - no error: the search ends with its best trial
    """The search was stopped, or has taken all the time or trials that it may: says which."""


@dataclass(frozen=True)
class Trial:
    """A simulated trial.

    Parameters
    ----------
    sought : ndarray
        The unknowns, then the initial states.
    motions : list of Motion
        The motion for each record.
    cost : float
        Sum of squared residuals over all windows.
    """

    sought: Values
    motions: list[Motion]
    cost: float = math.inf


@dataclass(frozen=True)
class Beginning:
    """What is known of the state at the beginning of a record.

    Parameters
    ----------
    mean : ndarray, shape (2 n,)
        Displacements and velocities by the first samples.
    root : ndarray, shape (2 n, 2 n)
        Root of their covariance: what is sought are multiples of its columns.
    """

    mean: Values
    root: Values

    def state(self, sought: Values) -> Values:
        """Return the state, shape (2, n)."""
        return np.asarray((self.mean + self.root @ sought).reshape(2, -1))


@dataclass
class Trials:
    """The motions of a rotor with other values of what is sought, beside measured records.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor with the first guesses.
    unknown : list of Unknown
        The unknowns.
    records : list of Measured
        The measured records.
    starts : list
        For each record what is known of its first state, which is then fitted too; or that state,
        shape (2, n), or the word for it.
    evaluations : int
        Number of trials, of which the motions have been simulated.
    budget : float
        What a motion may take [rad].
    left_work : float
        What all derivatives to come may take together [rad].
    deadline : float
        When the search must end, as `time.monotonic` has it [s].
    stop : ndarray, shape (1,), optional
        Ends the search as soon as it is not 0.
    best : Trial, optional
        The best trial so far.
    """

    rotor: Rotor | DimensionalRotor | RotorSystem
    unknown: list[Unknown]
    records: list[Measured]
    starts: Sequence[Beginning | Values | Word]
    evaluations: int = 0
    budget: float = ANY_WORK
    left_work: float = math.inf
    deadline: float = math.inf
    stop: Stop | None = None
    best: Trial | None = field(default=None, repr=False)
    _last: Trial | None = field(default=None, repr=False)
    _body: tuple[bytes, Body] | None = field(default=None, repr=False)

    def limit(self, motions: Sequence[Motion]) -> None:
        """Let the works of the motions of the first guess limit those of all trials."""
        works = [each.work for each in motions]
        self.budget = max(LEAST_BUDGET, MOST_WORK * max(works))
        self.left_work = MOST_OF_ALL * max(LEAST_BUDGET, 2.0 * self.first().size * sum(works))

    def first(self) -> Values:
        """Return the first guess: the unknowns, then multiples of the errors of the first states.

        These are 0.
        """
        values = np.zeros(len(self.unknown) + sum(map(self.freedom_of, self.starts)))
        values[: len(self.unknown)] = [each.guess for each in self.unknown]
        return values

    @staticmethod
    def freedom_of(start: Beginning | Values | Word) -> int:
        """Return how many numbers of a first state are sought."""
        return start.mean.size if isinstance(start, Beginning) else 0

    def bounds(self) -> tuple[Values, Values]:
        """Return the least and the largest values allowed."""
        low = np.full(self.first().size, -math.inf)
        low[: len(self.unknown)] = [each.least for each in self.unknown]
        return low, np.full(low.size, math.inf)

    def values_of(self, sought: Values) -> dict[str, float]:
        """Return the unknowns by name."""
        return dict(zip((each.name for each in self.unknown), sought.tolist(), strict=False))

    def body(self, sought: Values) -> Body:
        """Return the rotor with these unknowns."""
        key = sought[: len(self.unknown)].tobytes()
        if self._body is None or self._body[0] != key:
            self._body = key, body_of(self.rotor, self.values_of(sought))
        return self._body[1]

    def body_at(self, sought: Values, place: int, value: float) -> Body:
        """Return the rotor with another value of one unknown."""
        return body_of(self.rotor, self.values_of(sought) | {self.unknown[place].name: value})

    def trial(self, sought: Values) -> Trial:
        """Return a trial; the last one and the best one are known.

        Raises
        ------
        RotorError
            If it cannot be simulated, or takes more than its budget.
        SearchEnded
            If there must be no other trial.
        """
        for known in (self._last, self.best):
            if known is not None and np.array_equal(known.sought, sought):
                return known
        self.check_end()
        self.evaluations += 1
        motions = [self.motion(number, sought) for number in range(len(self.records))]
        self._last = Trial(sought.copy(), motions)
        return self._last

    def check_end(self) -> None:
        """Raise `SearchEnded` if there must be no other trial."""
        if self.stop is not None and self.stop[0]:
            raise SearchEnded("interrupted")
        if self.evaluations > 0 and time.monotonic() > self.deadline:
            raise SearchEnded("stopped by its limit")
        if self.evaluations >= MOST_TRIALS or self.left_work < 0.0:
            raise SearchEnded(f"stopped after {self.evaluations} trials")

    def places(self, number: int) -> slice:
        """Return where the numbers of the first state of a record are in what is sought."""
        counts = [len(self.unknown), *map(self.freedom_of, self.starts)]
        return slice(sum(counts[: number + 1]), sum(counts[: number + 2]))

    def motion(
        self, number: int, sought: Values, turning: Turning | None = None,
        start: Values | None = None, changes: Sequence[Change] = (),
    ) -> Motion:  # fmt: skip
        """Return the motion for one record; along another angle or from another state, if given.

        The whirl of a slow roll is subtracted where that of the signals is.
        """
        each, body = self.records[number], self.body(sought)
        motion = body.motion(
            each.turning if turning is None else turning,
            self.start(number, sought) if start is None else start, each.times, each.nodes,
            budget=self.budget, stop=self.stop, changes=changes,
        )  # fmt: skip
        return replace(motion, z=motion.z - each.slow_whirl(body))

    def start(self, number: int, sought: Values) -> Values | Word:
        """Return the first state of a record, or the word for it."""
        start = self.starts[number]
        if isinstance(start, Beginning):
            return start.state(sought[self.places(number)])
        return start


def body_of(rotor: Rotor | DimensionalRotor | RotorSystem, values: Mapping[str, float]) -> Body:
    """Return a rotor with other values of some parameters."""
    given: dict[str, Any] = dict(values)
    ahead = given.pop(ANGLE, 0.0)
    if isinstance(rotor, RotorSystem):
        system = with_parameters(rotor, given)
    else:
        system = replace(rotor, **given).system()
    return Body.of(system).turned(ahead)
