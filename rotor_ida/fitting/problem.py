"""The least-squares problem of a fit: unknowns, residuals and their derivatives."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Stop, Values
from rotor_ida.errors import BudgetError, InputError, RotorError
from rotor_ida.fitting.identifiability import ANGLE, ROUNDING
from rotor_ida.fitting.motion import ANY_WORK, Body, Change, Motion, Turning, Word
from rotor_ida.fitting.records import Measured
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import with_parameters
from rotor_ida.schema.flags import ENTRY, EXIT

Mask: TypeAlias = npt.NDArray[np.bool_]

# A failed trial counts as this many times the largest residual of any other.
FAR_OFF = 1e3
# The largest work of a trial, in works of the first guess; the least that any trial is allowed
# [rad]; and of a search the largest number of trials, and the largest work of their derivatives, in
# that of the first guess.
MOST_WORK, LEAST_BUDGET = 20.0, 1e5
MOST_TRIALS, MOST_OF_ALL = 200, 100.0
# Contact times count if no other event is nearer than this many of their standard errors. At a
# graze two events merge, and their times no longer change linearly.
APART = 10.0
# Derivatives of the matrices by unknowns, and of motions where the core cannot follow them, are
# differences of values that are this far apart, in parts of their sizes. Motions that differ by
# less than that part of their size differ by rounding.
STEP, SAME = 1e-6, 1e-12
# Above this growth a motion is chaotic for a fit: rounding has replaced its start.
LARGEST_GROWTH = 1e5


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
class SharedErrors:
    """Changes of the residuals by errors that they share, beside independent unit noise.

    They are those of the measured angle and of a subtracted slow roll.

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
    def of(cls, changes: Sequence[Values]) -> SharedErrors:
        """Return them from the columns of D."""
        directions, sizes, _ = np.linalg.svd(np.stack(changes, axis=1), full_matrices=False)
        return cls(directions, 1.0 - 1.0 / np.sqrt(1.0 + sizes**2))

    def independent(self, values: Values) -> Values:
        """Return residuals, or columns of their derivatives, with independent unit noise."""
        return np.asarray(values - (self.directions * self.parts) @ (self.directions.T @ values))


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
class FitProblem:
    """The residuals to minimise.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor with the first guesses.
    unknown : list of Unknown
        The unknowns.
    records : list of Measured
        The measured records.
    noise : float
        Standard deviation of x and y [m].
    starts : list
        For each record what is known of its first state, which is then fitted too; or that state,
        shape (2, n), or the word for it.
    time_error : float
        Standard error of a contact time [s]; infinity leaves contact times out.
    evaluations : int
        Number of trials, of which the motions have been simulated.
    budget : float
        What a motion may take [rad].
    left_work : float
        What all derivatives to come may take together [rad].
    reach : float
        The clearance that the measured motion would just not reach, by the first guess [m].
    deadline : float
        When the search must end, as `time.monotonic` has it [s].
    stop : ndarray, shape (1,), optional
        Ends the search as soon as it is not 0.
    part : float
        Fraction of the windows, from the first, that the search uses: 1 is all.
    clear : dict
        For each record and kind, which of the measured times are compared; by default all.
    shared_errors : SharedErrors, optional
        The effect of errors that many residuals share.
    """

    rotor: Rotor | DimensionalRotor | RotorSystem
    unknown: list[Unknown]
    records: list[Measured]
    noise: float
    starts: Sequence[Beginning | Values | Word]
    time_error: float = math.inf
    evaluations: int = 0
    budget: float = ANY_WORK
    left_work: float = math.inf
    reach: float = 0.0
    deadline: float = math.inf
    stop: Stop | None = None
    part: float = 1.0
    clear: dict[tuple[int, int], Mask] = field(default_factory=dict)
    shared_errors: SharedErrors | None = None
    _last: Trial | None = field(default=None, repr=False)
    _best: Trial | None = field(default=None, repr=False)
    _residuals: tuple[bytes, Values, Values] | None = field(default=None, repr=False)
    _body: tuple[bytes, Body] | None = field(default=None, repr=False)
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
        works = [each.work for each in motions]
        self.reach = max(
            each.largest * motion.reach / max(float(np.abs(motion.z).max()), np.finfo(float).tiny)
            for each, motion in zip(self.records, motions, strict=True)
        )
        self.budget = max(LEAST_BUDGET, MOST_WORK * max(works))
        self.left_work = MOST_OF_ALL * max(LEAST_BUDGET, 2.0 * first.size * sum(works))
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
        trial = replace(trial, cost=float((self.apart(trial) ** 2).sum()))
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
        """Return the first guess: the unknowns, then multiples of the errors of the first states.

        These are 0.
        """
        values = np.zeros(len(self.unknown) + sum(map(self._freedom_of, self.starts)))
        values[: len(self.unknown)] = [each.guess for each in self.unknown]
        return values

    @staticmethod
    def _freedom_of(start: Beginning | Values | Word) -> int:
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
        motions = [self._motion(number, sought) for number in range(len(self.records))]
        self._last = Trial(sought.copy(), motions)
        return self._last

    def _check_end(self) -> None:
        """Raise `SearchEnded` if there must be no other trial."""
        if self.stop is not None and self.stop[0]:
            raise SearchEnded("interrupted")
        if self.evaluations > 0 and time.monotonic() > self.deadline:
            raise SearchEnded("stopped by its limit")
        if self.evaluations >= MOST_TRIALS or self.left_work < 0.0:
            raise SearchEnded(f"stopped after {self.evaluations} trials")

    def _places(self, number: int) -> slice:
        """Return where the numbers of the first state of a record are in what is sought."""
        counts = [len(self.unknown), *map(self._freedom_of, self.starts)]
        return slice(sum(counts[: number + 1]), sum(counts[: number + 2]))

    def _motion(
        self, number: int, sought: Values, turning: Turning | None = None,
        start: Values | None = None, changes: Sequence[Change] = (),
    ) -> Motion:  # fmt: skip
        """Return the motion for one record; along another angle or from another state, if given.

        The whirl of a slow roll is subtracted where that of the signals is.
        """
        each, body = self.records[number], self.body(sought)
        motion = body.motion(
            each.turning if turning is None else turning,
            self._start(number, sought) if start is None else start, each.times, each.nodes,
            budget=self.budget, stop=self.stop, changes=changes,
        )  # fmt: skip
        return replace(motion, z=motion.z - each.slow_whirl(body))

    def _start(self, number: int, sought: Values) -> Values | Word:
        """Return the first state of a record, or the word for it."""
        start = self.starts[number]
        if isinstance(start, Beginning):
            return start.state(sought[self._places(number)])
        return start

    def at(self, sought: Values) -> tuple[Values, Values, list[Motion]]:
        """Return the residuals, their derivatives, and the motions; raises as `trial` does.

        Raises
        ------
        InputError
            If the motion is chaotic.
        """
        trial, key = self.trial(sought), sought.tobytes()
        if self._residuals is None or self._residuals[0] != key:
            left, kept = self.apart(trial), self._kept()
            slopes = self._slopes(trial)
            self._keep_better(trial)
            self._largest = max(self._largest, float(np.abs(left).max()))
            self._residuals = (key, left * kept, slopes * kept[:, None])
        return *self._residuals[1:], trial.motions

    def left(self, sought: Values) -> Values:
        """Return the residuals; large where the simulation fails or takes too long.

        A trial that least squares would accept must have derivatives too.
        """
        try:
            left = self.apart(self.trial(sought)) * self._kept()
            if self._residuals is None or left @ left < self._residuals[1] @ self._residuals[1]:
                self.at(sought)
        except RotorError:
            return np.full(self._rows()[-1].stop, FAR_OFF * (1.0 + self._largest))
        return left

    def slopes(self, sought: Values) -> Values:
        """Return the derivatives of the residuals."""
        return self.at(sought)[1]

    def _sizes(self, number: int) -> tuple[int, int, int]:
        """Return the numbers of residuals of a record: of tracks, of its start, of contacts."""
        each = self.records[number]
        return (
            each.tracked,
            self._freedom_of(self.starts[number]),
            sum(times.size for times in each.touches.values())
            if math.isfinite(self.time_error)
            else 0,
        )

    def _rows(self) -> list[slice]:
        """Return which residuals are those of each record."""
        ends = np.cumsum([0, *(sum(self._sizes(each)) for each in range(len(self.records)))])
        return [slice(*each) for each in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True)]

    def freedom(self, sought: Values) -> int:
        """Return the degrees of freedom: numbers compared less unknowns that they determine.

        If a motion forgets its start, the guess determines the start instead.
        """
        _, slopes, motions = self.at(sought)
        measured = np.ones(len(slopes), dtype=bool)
        for number, rows in enumerate(self._rows()):
            tracks, start, _ = self._sizes(number)
            measured[rows.start + tracks : rows.start + tracks + start] = False
        sizes = np.linalg.norm(slopes, axis=0)
        basis = np.linalg.svd(slopes / np.where(sizes > 0.0, sizes, 1.0), full_matrices=False)
        kept = basis[0][:, basis[1] > ROUNDING * basis[1].max(initial=0.0)]
        used = float((kept[measured] ** 2).sum())
        lost = sum(
            int((~each.compared).sum())
            for number, motion in enumerate(motions)
            for each in self.touches(number, motion).values()
        )
        return int(measured.sum()) - lost - round(used)

    def errors_in_common(self, sought: Values) -> SharedErrors | None:
        """Return the effect of errors of angle and slow roll; None if none are known."""
        trial, rows, changes = self.trial(sought), self._rows(), []
        for number, each in enumerate(self.records):
            own = trial.motions[number]
            known, moved = self._of_record(number, trial, own), []
            for turning in each.other_turnings:
                self._check_end()
                moved.append(self._motion(number, sought, turning))
            moved += [replace(own, z=own.z + error) for error in each.slow_roll_errors()]
            for motion in moved:
                change = np.zeros(rows[-1].stop)
                change[rows[number]] = self._of_record(number, trial, motion) - known
                changes.append(change)
        return SharedErrors.of(changes) if changes else None

    def independent(self, values: Values) -> Values:
        """Return residuals, or columns of their derivatives, with independent unit noise."""
        return values if self.shared_errors is None else self.shared_errors.independent(values)

    def apart(self, trial: Trial, *, matched_only: bool = False) -> Values:
        """Return the residuals of a trial, over all windows."""
        return self.independent(np.concatenate([
            self._of_record(number, trial, motion, matched_only=matched_only)
            for number, motion in enumerate(trial.motions)
        ]))  # fmt: skip

    def tracks_apart(self, trial: Trial) -> list[ComplexValues]:
        """Return the residuals of the orders of each record, over their standard errors.

        They are those that the sum of squares judges, without the errors that they share. Shape
        (windows, k, node).
        """
        left, found = self.apart(trial), []
        for each, rows in zip(self.records, self._rows(), strict=True):
            root = each.tracks.root
            parts = left[rows][: each.tracked].reshape(2, *root.shape[:2], -1)
            errors = np.linalg.norm(root, axis=2)
            found.append(root @ (parts[0] + 1j * parts[1]) / errors[..., None])
        return found

    def _of_record(
        self, number: int, trial: Trial, motion: Motion, *, matched_only: bool = False
    ) -> Values:
        """Return the residuals of a record, with the measured angle taken as exact."""
        each = self.records[number]
        left = [each.tracks.weighed(motion.z - each.z).ravel() / self.noise,
                trial.sought[self._places(number)]]  # fmt: skip
        for found in self.touches(number, motion).values():
            apart = np.where(found.compared, found.apart, 0.0) if matched_only else found.apart
            left.append(apart / self.time_error)
        return np.concatenate(left)

    def _slopes(self, trial: Trial) -> Values:
        """Return the derivatives of the residuals by all that is sought."""
        slopes, around = (
            np.zeros((self._rows()[-1].stop, trial.sought.size)),
            self._around(trial.sought),
        )
        for number, rows in enumerate(self._rows()):
            self._check_growth(number, trial)
            own = self._places(number)
            places = [*range(own.start, own.stop), *range(len(self.unknown))]
            apart = [each for each in places if self._needs_differences(each, trial.sought)]
            beside = [each for each in places if each not in apart]
            if beside:
                slopes[rows, beside] = self._slopes_beside(number, trial, beside, around)
            for place in apart:
                slopes[rows, place] = self._slope(number, trial, place, *around[place])
        return self.independent(slopes)

    def _needs_differences(self, place: int, sought: Values) -> bool:
        """Whether the core cannot follow a change beside the motion: see `SystemFlow`."""
        is_friction = place < len(self.unknown) and self.unknown[place].role == "friction"
        return bool(self.body(sought).assembly.massless) or (is_friction and sought[place] == 0.0)

    def _slopes_beside(
        self, number: int, trial: Trial, places: Sequence[int], around: list[tuple[float, float]]
    ) -> Values:
        """Return the derivatives of the residuals of a record, by changes beside one motion."""
        each, own = self.records[number], self._places(number)
        changes = [self._change(number, trial.sought, place, *around[place]) for place in places]
        motion = self._motion(number, trial.sought, changes=changes)
        self.left_work -= 2.0 * len(changes) * motion.work  # at most: as two motions of each
        z_by = motion.z_by.copy()
        for column, place in enumerate(places):
            if place < len(self.unknown) and any(each.slow_rolls):
                low, high = around[place]
                before, after = (
                    each.slow_whirl(self._body_at(trial.sought, place, value))
                    for value in (low, high)
                )
                z_by[..., column] -= (after - before) / (high - low)
        moved = each.tracks.weighed(z_by.reshape(len(motion.z), -1))
        slopes = [
            moved.reshape(-1, len(changes)) / self.noise,
            np.equal.outer(np.arange(own.start, own.stop), places),
            *(
                found.moved_by(motion, kind) / self.time_error
                for kind, found in self.touches(number, trial.motions[number]).items()
            ),
        ]
        return np.concatenate(slopes)

    def _change(self, number: int, sought: Values, place: int, low: float, high: float) -> Change:
        """Return what changes beside a motion with one number that is sought."""
        body, begun = self.body(sought), self.starts[number]
        if place >= len(self.unknown):
            assert isinstance(begun, Beginning)
            moved = begun.root[:, place - self._places(number).start].reshape(2, -1)
            return Change(np.array([body.found.to_y(each) for each in moved]))
        before, after = (self._body_at(sought, place, value) for value in (low, high))
        start, turning = self._start(number, sought), self.records[number].turning
        return body.change(before, after, high - low, turning, start)

    def _body_at(self, sought: Values, place: int, value: float) -> Body:
        """Return the rotor with another value of one unknown."""
        return body_of(self.rotor, self.values_of(sought) | {self.unknown[place].name: value})

    def _around(self, sought: Values) -> list[tuple[float, float]]:
        """Return values below and above each that is sought, within the bounds.

        The motion depends almost linearly on its start, so that one difference is enough there.
        """
        sizes = np.ones(sought.size)
        sizes[: len(self.unknown)] = [
            max(abs(value), each.size)
            for value, each in zip(sought.tolist(), self.unknown, strict=False)
        ]
        low = np.maximum(sought - STEP * sizes, self.bounds()[0])
        low[len(self.unknown) :] = sought[len(self.unknown) :]
        return list(zip(low.tolist(), (sought + STEP * sizes).tolist(), strict=True))

    def _slope(self, number: int, trial: Trial, place: int, low: float, high: float) -> Values:
        """Return the derivatives of the residuals of a record by one number, by two motions."""
        each, both = self.records[number], []
        for value in (low, high):
            sought = trial.sought.copy()
            sought[place] = value
            known = value == trial.sought[place]
            both.append(trial.motions[number] if known else self._motion(number, sought))
            self.left_work -= both[-1].work
        before, after = both
        moved = after.z - before.z
        if np.abs(moved).max() < SAME * np.abs(trial.motions[number].z).max():
            moved[:] = 0.0
        own = self._places(number)
        slope = [
            each.tracks.weighed(moved).ravel() / self.noise,
            (np.arange(own.start, own.stop) == place) * (high - low),
            *(
                (found.moved(after, kind) - found.moved(before, kind)) / self.time_error
                for kind, found in self.touches(number, trial.motions[number]).items()
            ),
        ]
        return np.concatenate(slope) / (high - low)

    def _check_growth(self, number: int, trial: Trial) -> None:
        """Raise `InputError` for a chaotic motion, by another from a start beside its own."""
        each, states = self.records[number], trial.motions[number].states
        scale = np.array([1.0, float(each.turning.speeds.max())])[:, None]
        beside = states[0] + STEP * np.abs(states[:, 0]).max() * scale
        start = self.body(trial.sought).found.to_q(beside)
        apart = (self._motion(number, trial.sought, start=start).states - states) / scale
        sizes = np.linalg.norm(apart, axis=(1, 2))
        grown = sizes > LARGEST_GROWTH * sizes[0]
        if grown.any():
            raise InputError(
                "signals must show a motion that its start determines, but by "
                f"{each.times[grown.argmax()]:.6g} after the start small changes have grown by "
                f"{LARGEST_GROWTH:g}: fit a part of them"
            )

    def _kept(self) -> Values:
        """Return 1 for each residual in the part of the windows that is searched, else 0."""
        kept = []
        for number, each in enumerate(self.records):
            others = sum(self._sizes(number)[1:])
            kept += [each.first(self.part), np.ones(others)]
        return np.concatenate(kept)


def body_of(rotor: Rotor | DimensionalRotor | RotorSystem, values: Mapping[str, float]) -> Body:
    """Return a rotor with other values of some parameters."""
    given: dict[str, Any] = dict(values)
    ahead = given.pop(ANGLE, 0.0)
    if isinstance(rotor, RotorSystem):
        system = with_parameters(rotor, given)
    else:
        system = replace(rotor, **given).system()
    return Body.of(system).turned(ahead)


@dataclass(frozen=True)
class Touches:
    """Residuals of the contact times of one kind in a record.

    Parameters
    ----------
    times : ndarray, shape (n,)
        The measured times [s].
    apart : ndarray, shape (n,)
        Difference between the nearest computed time and each [s].
    gaps : ndarray, shape (n,)
        Time between the nearest computed event and its neighbour [s].
    compared : ndarray of bool, shape (n,)
        Whether the computed time matches the measured one, so that they are compared.
    """

    times: Values
    apart: Values
    gaps: Values
    compared: Mask

    def only(self, clear: Mask | None) -> Touches:
        """Return them without those that are not clear."""
        if clear is None:
            return self
        apart = np.where(clear, self.apart, 0.0)
        return replace(self, apart=apart, compared=self.compared & clear)

    def moved(self, motion: Motion, kind: int) -> Values:
        """Return the computed times in a motion nearby; 0 where they are not compared."""
        return self._nearest(motion.touches(kind), motion.touches(kind), self.times + self.apart)

    def moved_by(self, motion: Motion, kind: int) -> Values:
        """Return the derivatives of the computed times, shape (n, change), likewise."""
        own = motion.times_by[motion.event_kinds == kind]
        return self._nearest(motion.touches(kind), own, np.zeros((self.times.size, own.shape[1])))

    def _nearest(self, found: Values, values: Values, none: Values) -> Values:
        """Return the values of the events nearest to those compared."""
        moved = np.zeros(none.shape)
        computed = (self.times + self.apart)[self.compared]
        nearest = np.abs(found[:, None] - computed).argmin(axis=0) if found.size else ()
        moved[self.compared] = values[nearest] if found.size else none[self.compared]
        return moved


def matched(times: Values, motion: Motion, kind: int) -> Touches:
    """Match computed contact times to measured ones.

    Two match if each is the nearest of the other, no farther away than half the usual gap.
    A measured time without a match has a constant residual, whatever the unknowns.
    """
    found = motion.touches(kind)
    reach = 0.5 * float(np.median(np.diff(times))) if times.size > 1 else math.inf
    none = np.zeros(times.size)
    if not found.size:
        missed = none + min(reach, float(times[-1]))
        return Touches(times, missed, none + math.inf, none.astype(bool))
    distances = np.abs(found[:, None] - times)
    nearest = distances.argmin(axis=0)
    apart = found[nearest] - times
    alone = (np.abs(apart) >= reach) | (distances.argmin(axis=1)[nearest] != np.arange(times.size))
    both = [motion.touches(each) for each in (ENTRY, EXIT)]
    events = np.sort(np.concatenate([[-math.inf], *both, [math.inf]]))
    gaps = np.diff(events)
    place = np.searchsorted(events, found[nearest])
    return Touches(
        times,
        np.where(alone, np.clip(apart, -reach, reach), apart),
        np.minimum(gaps[place - 1], gaps[place]),
        ~alone,
    )
