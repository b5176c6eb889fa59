"""The least-squares problem of a fit: unknowns, residuals and their derivatives."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.errors import BudgetError, InputError, RotorError
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.motion import (
    ANY_WORK,
    LARGEST_GROWTH,
    Motion,
    MotionRequest,
    Turning,
    Work,
)
from rotor_ida.fitting.records import Measured
from rotor_ida.model.rotor import DimensionalRotor
from rotor_ida.schema.flags import ENTRY, EXIT

Mask: TypeAlias = npt.NDArray[np.bool_]

# Singular values below this part of the largest are rounding.
RANK = 1e-10
# A failed trial counts as this many times the largest residual of any other.
FAR_OFF = 1e3
# The largest work of a trial, in works of the first guess; the least that any trial is allowed;
# and of a search the largest number of trials, and the largest work of their derivatives, in that
# of the first guess.
MOST_WORK, LEAST_BUDGET = 20, Work(steps=100_000, panels=20_000)
MOST_TRIALS, MOST_OF_ALL = 200, 100
# Contact times count if no other event is nearer than this many of their standard errors. At a
# graze two events merge, and their times no longer change linearly.
APART = 10.0


@dataclass(frozen=True)
class Unknown:
    """One unknown.

    Parameters
    ----------
    name, field : str
        Its name, and the name of the corresponding parameter in SI units.
    factor : float
        Value of that parameter for a value of 1 of this one.
    guess, least : float
        The first guess, and the smallest value allowed.
    """

    name: str
    field: str
    factor: float
    guess: float
    least: float


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
class AngleErrors:
    """Changes of the residuals by errors of the measured angle, beside independent unit noise.

    Their covariance is ``1 + D D'`` of the changes D by each independent standard error.

    Parameters
    ----------
    directions : ndarray, shape (n, k)
        Left singular vectors of D.
    parts : ndarray, shape (k,)
        Part of each by which residuals are shortened to have unit noise again.
    """

    directions: Values
    parts: Values

    @classmethod
    def of(cls, changes: Sequence[Values]) -> AngleErrors:
        """Return them from the columns of D."""
        directions, sizes, _ = np.linalg.svd(np.stack(changes, axis=1), full_matrices=False)
        return cls(directions, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2))

    def independent(self, values: Values) -> Values:
        """Return residuals, or columns of their derivatives, with independent unit noise."""
        return np.asarray(values - (self.directions * self.parts) @ (self.directions.T @ values))


@dataclass
class FitProblem:
    """The residuals to minimise.

    Parameters
    ----------
    machine : DimensionalRotor
        The machine with the first guesses.
    unknown : list of Unknown
        The unknowns.
    records : list of Measured
        The measured records.
    noise : float
        Standard deviation of x and y [m].
    time_error : float
        Standard error of a contact time [s]; infinity leaves contact times out.
    starts : list of ndarray, optional
        The initial states, if they are known; otherwise they are fitted too.
    evaluations : int
        Number of trials, of which the motions have been simulated.
    budget : Work
        What a trial may take for each record.
    left_panels : float
        Panels that all derivatives to come may take together.
    deadline : float
        When the search must end, as `time.monotonic` has it [s].
    stop : ndarray, shape (1,), optional
        Ends the search as soon as it is not 0.
    part : float
        Fraction of the windows, from the first, that the search uses: 1 is all.
    clear : dict
        For each record and kind, which of the measured times are compared; by default all.
    angle_errors : AngleErrors, optional
        The effect of errors of the measured angle.
    """

    machine: DimensionalRotor
    unknown: list[Unknown]
    records: list[Measured]
    noise: float
    time_error: float = math.inf
    starts: list[Values] | None = None
    evaluations: int = 0
    budget: Work = ANY_WORK
    left_panels: float = math.inf
    deadline: float = math.inf
    stop: Stop | None = None
    part: float = 1.0
    clear: dict[tuple[int, int], Mask] = field(default_factory=dict)
    angle_errors: AngleErrors | None = None
    _last: Trial | None = field(default=None, repr=False)
    _best: Trial | None = field(default=None, repr=False)
    _residuals: tuple[bytes, Values, Values] | None = field(default=None, repr=False)
    _largest: float = 0.0

    def begin(self) -> Values:
        """Return the first guess, and let its work limit that of all trials.

        Raises
        ------
        InputError, SimulationError
            If it cannot be simulated.
        """
        first = self.first()
        try:
            motions = self.at(first)[2]
        except BudgetError as error:
            raise InputError(
                f"signals must be shorter, or the machine softer, for a fit: {error.reason}"
            ) from error
        panels = [each.derivatives.panels for each in motions]
        self.budget = Work(
            max(LEAST_BUDGET.steps, MOST_WORK * max(each.orbit.steps for each in motions)),
            max(LEAST_BUDGET.panels, MOST_WORK * max(panels)),
        )
        self.left_panels = MOST_OF_ALL * max(LEAST_BUDGET.panels, sum(panels))
        return first

    def renew(self, **known: object) -> None:
        """Set the noise, other errors or the part, which changes the weights."""
        for name, value in known.items():
            setattr(self, name, value)
        self._residuals = None
        best, self._best = self._best, None
        if best is not None:
            self._keep_better(best)

    @property
    def best(self) -> Values:
        """The best trial so far, over all windows; at first the first guess."""
        return self.first() if self._best is None else self._best.sought

    def _keep_better(self, trial: Trial) -> None:
        """Keep a trial if it is the best so far."""
        trial = replace(trial, cost=float((self._left(trial) ** 2).sum()))
        if self._best is None or trial.cost < self._best.cost:
            self._best = trial

    def touches(self, number: int, motion: Motion) -> dict[int, Touches]:
        """Return the residuals of the contact times of one record, by kind."""
        if not math.isfinite(self.time_error):
            return {}
        found = {
            kind: matched(times, motion, kind)
            for kind, times in self.records[number].touches.items()
        }
        return {kind: each.only(self.clear.get((number, kind))) for kind, each in found.items()}

    def clear_in(self, motions: Sequence[Motion]) -> dict[tuple[int, int], Mask]:
        """Return which measured times are clear of grazes and chatter in these motions too."""
        return {
            (number, kind): ~(found.gaps < APART * self.time_error)
            & self.clear.get((number, kind), np.array(True))
            for number, motion in enumerate(motions)
            for kind, times in self.records[number].touches.items()
            for found in [matched(times, motion, kind)]
        }

    def first(self) -> Values:
        """Return the first guess: the unknowns, then the initial states."""
        held = [np.array([each.guess for each in self.unknown])]
        if self.starts is None:
            held += [each.start for each in self.records]
        return np.concatenate(held)

    def bounds(self) -> tuple[Values, Values]:
        """Return the least and the largest values allowed."""
        low = np.full(self.first().size, -math.inf)
        low[: len(self.unknown)] = [each.least for each in self.unknown]
        return low, np.full(low.size, math.inf)

    def machine_of(self, sought: Values) -> tuple[DimensionalRotor, float]:
        """Return the machine with these unknowns, and the angle of its unbalance."""
        values = {
            each.field: each.factor * value
            for each, value in zip(self.unknown, sought.tolist(), strict=False)
        }
        ahead = values.pop(ANGLE, 0.0)
        return replace(self.machine, **values), ahead

    def motions(self, sought: Values) -> list[Motion]:
        """Return the motion for each record; raises as `trial` does."""
        return self.trial(sought).motions

    def trial(self, sought: Values) -> Trial:
        """Return a trial; the last one and the best one are known.

        Raises
        ------
        RotorError
            If it cannot be simulated, or takes more than its budget.
        SearchEnded
            If there must be no other trial.
        """
        for known in (self._last, self._best):
            if known is not None and np.array_equal(known.sought, sought):
                return known
        self._check_end()
        self.evaluations += 1
        machine, ahead = self.machine_of(sought)
        motions = [
            self._motion(number, machine, ahead, sought, each.turning)
            for number, each in enumerate(self.records)
        ]
        self._last = Trial(sought.copy(), motions)
        return self._last

    @property
    def count(self) -> int:
        """Number of records."""
        return len(self.records)

    def _check_end(self) -> None:
        """Raise `SearchEnded` if there must be no other trial."""
        if self.stop is not None and self.stop[0]:
            raise SearchEnded("interrupted")
        if self.evaluations > 0 and time.monotonic() > self.deadline:
            raise SearchEnded("stopped by its limit")
        if self.evaluations >= MOST_TRIALS or self.left_panels < 0.0:
            raise SearchEnded(f"stopped after {self.evaluations} trials")

    def start(self, sought: Values, number: int) -> Values:
        """Return the initial state for a record."""
        place = len(self.unknown) + 4 * number
        return sought[place : place + 4] if self.starts is None else self.starts[number]

    def _motion(
        self,
        number: int,
        machine: DimensionalRotor,
        ahead: float,
        sought: Values,
        turning: Turning,
    ) -> Motion:
        """Return the motion of a machine for one record."""
        each, names = self.records[number], [unknown.field for unknown in self.unknown]
        start = self.start(sought, number)
        request = MotionRequest(machine, turning, start, ahead, self.budget, self.stop)
        return request.motion(each.times, names)

    def at(self, sought: Values) -> tuple[Values, Values, list[Motion]]:
        """Return the residuals, their derivatives, and the motions; raises as `trial` does.

        Raises
        ------
        InputError
            If the motion is chaotic, or the disc rolls or slips the other way on the stator.
        """
        trial, key = self.trial(sought), sought.tobytes()
        if self._residuals is None or self._residuals[0] != key:
            for motion in trial.motions:
                _check_growth(motion)
            self.left_panels -= sum(each.derivatives.panels for each in trial.motions)
            left, kept = self._left(trial), self._kept()
            self._keep_better(trial)
            self._largest = max(self._largest, float(np.abs(left).max()))
            self._residuals = (key, left * kept, self._slopes(trial) * kept[:, None])
        return *self._residuals[1:], trial.motions

    def left(self, sought: Values) -> Values:
        """Return the residuals; large where the simulation fails or takes too long.

        A trial that least squares would accept must have derivatives too.
        """
        try:
            left = self._left(self.trial(sought)) * self._kept()
            if self._residuals is None or left @ left < self._residuals[1] @ self._residuals[1]:
                self.at(sought)
        except RotorError:
            size = sum(sum(self._sizes(number)) for number in range(self.count))
            return np.full(size, FAR_OFF * (1.0 + self._largest))
        return left

    def slopes(self, sought: Values) -> Values:
        """Return the derivatives of the residuals."""
        return self.at(sought)[1]

    def _sizes(self, number: int) -> tuple[int, int, int]:
        """Return the numbers of residuals of a record: of tracks, of its start, of contacts."""
        each = self.records[number]
        return (
            2 * each.tracks.orders.size * each.tracks.windows.times.size,
            4 if self.starts is None else 0,
            sum(times.size for times in each.touches.values())
            if math.isfinite(self.time_error)
            else 0,
        )

    def freedom(self, sought: Values) -> int:
        """Return the degrees of freedom: numbers compared less unknowns that they determine.

        If a motion forgets its start, the guess determines the start instead.
        """
        _, slopes, motions = self.at(sought)
        measured = np.ones(len(slopes), dtype=bool)
        row = 0
        for number in range(self.count):
            tracks, start, touches = self._sizes(number)
            measured[row + tracks : row + tracks + start] = False
            row += tracks + start + touches
        sizes = np.linalg.norm(slopes, axis=0)
        basis = np.linalg.svd(slopes / np.where(sizes > 0.0, sizes, 1.0), full_matrices=False)
        kept = basis[0][:, basis[1] > RANK * basis[1].max(initial=0.0)]
        used = float((kept[measured] ** 2).sum())
        lost = sum(
            int((~each.compared).sum())
            for number, motion in enumerate(motions)
            for each in self.touches(number, motion).values()
        )
        return int(measured.sum()) - lost - round(used)

    def errors_of_angle(self, sought: Values) -> AngleErrors | None:
        """Return the effect of errors of the measured angle; None if none are known."""
        trial = self.trial(sought)
        machine, ahead = self.machine_of(sought)
        changes = []
        for number, each in enumerate(self.records):
            for turning in each.other_turnings:
                self._check_end()
                motions = trial.motions.copy()
                motions[number] = self._motion(number, machine, ahead, sought, turning)
                changes.append(self._apart(Trial(sought, motions)) - self._apart(trial))
        return AngleErrors.of(changes) if changes else None

    def independent(self, values: Values) -> Values:
        """Return residuals, or columns of their derivatives, with independent unit noise."""
        return values if self.angle_errors is None else self.angle_errors.independent(values)

    def _left(self, trial: Trial) -> Values:
        """Return the residuals of a trial, over all windows."""
        return self.independent(self._apart(trial))

    def _apart(self, trial: Trial) -> Values:
        """Return the residuals of a trial with the measured angle taken as exact."""
        left = []
        for number, (each, motion) in enumerate(zip(self.records, trial.motions, strict=True)):
            apart = each.tracks.weighed((motion.z - each.record.z)[:, None])[:, 0]
            left.append(apart / self.noise)
            if self.starts is None:
                left.append((self.start(trial.sought, number) - each.start) / each.spread)
            left += [t.apart / self.time_error for t in self.touches(number, motion).values()]
        return np.concatenate(left)

    def _slopes(self, trial: Trial) -> Values:
        """Return the derivatives of these residuals by all that is sought."""
        slopes, count = [], len(self.unknown)
        for number, (each, motion) in enumerate(zip(self.records, trial.motions, strict=True)):
            own = [each.tracks.weighed(motion.derivatives.slopes) / self.noise]
            if self.starts is None:
                own.append(np.hstack([np.diag(1.0 / each.spread), np.zeros((4, count))]))
            own += [
                found.slopes(motion, kind) / self.time_error
                for kind, found in self.touches(number, motion).items()
            ]
            slopes.append(self._by_sought(np.concatenate(own), number))
        return self.independent(np.concatenate(slopes))

    def _kept(self) -> Values:
        """Return 1 for each residual in the part of the windows that is searched, else 0."""
        kept = []
        for number, each in enumerate(self.records):
            others = sum(self._sizes(number)[1:])
            kept += [each.tracks.first(self.part), np.ones(others)]
        return np.concatenate(kept)

    def _by_sought(self, slopes: Values, number: int) -> Values:
        """Return derivatives by all unknowns from those by one initial state and the parameters."""
        count = len(self.unknown)
        found = np.zeros((len(slopes), self.first().size))
        found[:, :count] = slopes[:, 4:] * [each.factor for each in self.unknown]
        if self.starts is None:
            found[:, count + 4 * number : count + 4 * number + 4] = slopes[:, :4]
        return found


def _check_growth(motion: Motion) -> None:
    """Raise `InputError` for a chaotic motion."""
    found = motion.derivatives
    if not found.growth <= LARGEST_GROWTH:
        raise InputError(
            "signals must show a motion that its start determines, but by "
            f"{found.lost:.6g} after the start small changes "
            f"have grown by {LARGEST_GROWTH:g}: fit a part of them"
        )


@dataclass(frozen=True)
class Touches:
    """Residuals of the contact times of one kind in a record.

    Parameters
    ----------
    times : ndarray, shape (n,)
        The measured times [s].
    apart : ndarray, shape (n,)
        Difference between the nearest computed time and each [s].
    nearest : ndarray of int, shape (n,)
        Number of that computed time; none if there is none.
    gaps : ndarray, shape (n,)
        Time between the nearest computed event and its neighbour [s].
    compared : ndarray of bool, shape (n,)
        Whether the computed time matches the measured one, so that they are compared.
    """

    times: Values
    apart: Values
    nearest: npt.NDArray[np.intp]
    gaps: Values
    compared: Mask

    def only(self, clear: Mask | None) -> Touches:
        """Return them without those that are not clear."""
        if clear is None:
            return self
        apart = np.where(clear, self.apart, 0.0)
        return replace(self, apart=apart, compared=self.compared & clear)

    def slopes(self, motion: Motion, kind: int) -> Values:
        """Return the derivatives of the differences, 0 where they are not compared."""
        found = motion.derivatives
        by = found.entry_slopes if kind > 0 else found.exit_slopes
        slopes = np.zeros((self.times.size, by.shape[1]))
        slopes[self.compared] = by[self.nearest[self.compared]]
        return slopes


def matched(times: Values, motion: Motion, kind: int) -> Touches:
    """Match computed contact times to measured ones.

    Two match if each is the nearest of the other, no farther away than half the usual gap.
    A measured time without a match has a constant residual, whatever the unknowns.
    """
    found, rise = motion.touches(kind)
    reach = 0.5 * float(np.median(np.diff(times))) if times.size > 1 else math.inf
    none = np.zeros(times.size)
    if not found.size:
        missed = none + min(reach, float(times[-1]))
        return Touches(times, missed, none.astype(np.intp), none + math.inf, none.astype(bool))
    distances = np.abs(found[:, None] - times)
    nearest = distances.argmin(axis=0)
    apart = found[nearest] - times
    alone = (np.abs(apart) >= reach) | (rise[nearest] == 0.0)
    alone |= distances.argmin(axis=1)[nearest] != np.arange(times.size)
    both = [motion.touches(each)[0] for each in (ENTRY, EXIT)]
    events = np.sort(np.concatenate([[-math.inf], *both, [math.inf]]))
    gaps = np.diff(events)
    place = np.searchsorted(events, found[nearest])
    return Touches(
        times,
        np.where(alone, np.clip(apart, -reach, reach), apart),
        nearest,
        np.minimum(gaps[place - 1], gaps[place]),
        ~alone,
    )
