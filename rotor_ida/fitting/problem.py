"""The least-squares problem of a fit: residuals of trials, and their derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.errors import BudgetError, InputError, RotorError
from rotor_ida.fitting.contact_times import Mask, Touches, matched
from rotor_ida.fitting.identifiability import ROUNDING
from rotor_ida.fitting.motion import Change, Motion
from rotor_ida.fitting.trials import Beginning, Trial, Trials

# A failed trial counts as this many times the largest residual of any other.
FAR_OFF = 1e3
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


@dataclass
class FitProblem:
    """The residuals to minimise.

    Parameters
    ----------
    trials : Trials
        The motions that are compared with the measured ones.
    noise : float
        Standard deviation of x and y [m].
    time_error : float
        Standard error of a contact time [s]; infinity leaves contact times out.
    reach : float
        The clearance that the measured motion would just not reach, by the first guess [m].
    part : float
        Fraction of the windows, from the first, that the search uses: 1 is all.
    clear : dict
        For each record and kind, which of the measured times are compared; by default all.
    shared_errors : SharedErrors, optional
        The effect of errors that many residuals share.
    """

    trials: Trials
    noise: float
    time_error: float = math.inf
    reach: float = 0.0
    part: float = 1.0
    clear: dict[tuple[int, int], Mask] = field(default_factory=dict)
    shared_errors: SharedErrors | None = None
    _residuals: tuple[bytes, Values, Values] | None = field(default=None, repr=False)
    _largest: float = 0.0

    def begin(self) -> Values:
        """Return the first guess, and let its work limit that of all trials.

        Raises
        ------
        InputError, SimulationError
            If it cannot be simulated.
        """
        first = self.trials.first()
        try:
            motions = self.at(first)[2]
        except BudgetError as error:
            raise InputError(
                f"signals must be shorter, or the machine softer, for a fit: {error.reason}"
            ) from error
        self.reach = max(
            each.largest * motion.reach / max(float(np.abs(motion.z).max()), np.finfo(float).tiny)
            for each, motion in zip(self.trials.records, motions, strict=True)
        )
        self.trials.limit(motions)
        return first

    def renew(self, **known: object) -> None:
        """Set the noise, other errors or the part, which changes the weights."""
        for name, value in known.items():
            setattr(self, name, value)
        self._residuals = None
        best, self.trials.best = self.trials.best, None
        if best is not None:
            self._keep_better(best)

    @property
    def best(self) -> Values:
        """The best trial so far, over all windows; at first the first guess."""
        return self.trials.first() if self.trials.best is None else self.trials.best.sought

    def _keep_better(self, trial: Trial) -> None:
        """Keep a trial if it is the best so far."""
        trial = replace(trial, cost=float((self.apart(trial) ** 2).sum()))
        if self.trials.best is None or trial.cost < self.trials.best.cost:
            self.trials.best = trial

    def touches(self, number: int, motion: Motion) -> dict[int, Touches]:
        """Return the residuals of the contact times of one record, by kind."""
        if not math.isfinite(self.time_error):
            return {}
        found = {
            kind: matched(times, motion, kind)
            for kind, times in self.trials.records[number].touches.items()
        }
        return {kind: each.only(self.clear.get((number, kind))) for kind, each in found.items()}

    def clear_in(self, motions: Sequence[Motion]) -> dict[tuple[int, int], Mask]:
        """Return which measured times are clear of grazes and chatter in these motions too."""
        return {
            (number, kind): ~(found.gaps < APART * self.time_error)
            & self.clear.get((number, kind), np.array(True))
            for number, motion in enumerate(motions)
            for kind, times in self.trials.records[number].touches.items()
            for found in [matched(times, motion, kind)]
        }

    def at(self, sought: Values) -> tuple[Values, Values, list[Motion]]:
        """Return the residuals, their derivatives, and the motions; raises as `Trials.trial` does.

        Raises
        ------
        InputError
            If the motion is chaotic.
        """
        trial, key = self.trials.trial(sought), sought.tobytes()
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
            left = self.apart(self.trials.trial(sought)) * self._kept()
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
        each = self.trials.records[number]
        touches = each.touches.values() if math.isfinite(self.time_error) else ()
        begun = self.trials.freedom_of(self.trials.starts[number])
        return each.tracked, begun, sum(times.size for times in touches)

    def _rows(self) -> list[slice]:
        """Return which residuals are those of each record."""
        ends = np.cumsum([0, *(sum(self._sizes(each)) for each in range(len(self.trials.records)))])
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
        trial, rows, changes = self.trials.trial(sought), self._rows(), []
        for number, each in enumerate(self.trials.records):
            own = trial.motions[number]
            known, moved = self._of_record(number, trial, own), []
            for turning in each.other_turnings:
                self.trials.check_end()
                moved.append(self.trials.motion(number, sought, turning))
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
        for each, rows in zip(self.trials.records, self._rows(), strict=True):
            root = each.tracks.root
            parts = left[rows][: each.tracked].reshape(2, *root.shape[:2], -1)
            errors = np.linalg.norm(root, axis=2)
            found.append(root @ (parts[0] + 1j * parts[1]) / errors[..., None])
        return found

    def _of_record(
        self, number: int, trial: Trial, motion: Motion, *, matched_only: bool = False
    ) -> Values:
        """Return the residuals of a record, with the measured angle taken as exact."""
        each = self.trials.records[number]
        left = [each.tracks.weighed(motion.z - each.z).ravel() / self.noise,
                trial.sought[self.trials.places(number)]]  # fmt: skip
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
            own = self.trials.places(number)
            places = [*range(own.start, own.stop), *range(len(self.trials.unknown))]
            apart = [each for each in places if self._needs_differences(each, trial.sought)]
            beside = [each for each in places if each not in apart]
            if beside:
                slopes[rows, beside] = self._slopes_beside(number, trial, beside, around)
            for place in apart:
                slopes[rows, place] = self._slope(number, trial, place, *around[place])
        return self.independent(slopes)

    def _needs_differences(self, place: int, sought: Values) -> bool:
        """Whether the core cannot follow a change beside the motion: see `SystemFlow`."""
        unknown = self.trials.unknown[place : place + 1]  # none for a first state
        is_frictionless = any(each.role == "friction" for each in unknown) and sought[place] == 0.0
        return is_frictionless or bool(self.trials.body(sought).assembly.massless)

    def _slopes_beside(
        self, number: int, trial: Trial, places: Sequence[int], around: list[tuple[float, float]]
    ) -> Values:
        """Return the derivatives of the residuals of a record, by changes beside one motion."""
        each, own = self.trials.records[number], self.trials.places(number)
        changes = [self._change(number, trial.sought, place, *around[place]) for place in places]
        motion = self.trials.motion(number, trial.sought, changes=changes)
        self.trials.left_work -= 2.0 * len(changes) * motion.work  # at most: as two motions of each
        z_by = motion.z_by.copy()
        for column, place in enumerate(places):
            if place < len(self.trials.unknown) and any(each.slow_rolls):
                low, high = around[place]
                before, after = (
                    each.slow_whirl(self.trials.body_at(trial.sought, place, value))
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
        body, begun = self.trials.body(sought), self.trials.starts[number]
        if place >= len(self.trials.unknown):
            assert isinstance(begun, Beginning)
            moved = begun.root[:, place - self.trials.places(number).start].reshape(2, -1)
            return Change(np.array([body.found.to_y(each) for each in moved]))
        before, after = (self.trials.body_at(sought, place, value) for value in (low, high))
        start, turning = self.trials.start(number, sought), self.trials.records[number].turning
        return body.change(before, after, high - low, turning, start)

    def _around(self, sought: Values) -> list[tuple[float, float]]:
        """Return values below and above each that is sought, within the bounds.

        The motion depends almost linearly on its start, so that one difference is enough there.
        """
        sizes = np.ones(sought.size)
        sizes[: len(self.trials.unknown)] = [
            max(abs(value), each.size)
            for value, each in zip(sought.tolist(), self.trials.unknown, strict=False)
        ]
        low = np.maximum(sought - STEP * sizes, self.trials.bounds()[0])
        low[len(self.trials.unknown) :] = sought[len(self.trials.unknown) :]
        return list(zip(low.tolist(), (sought + STEP * sizes).tolist(), strict=True))

    def _slope(self, number: int, trial: Trial, place: int, low: float, high: float) -> Values:
        """Return the derivatives of the residuals of a record by one number, by two motions."""
        each, both = self.trials.records[number], []
        for value in (low, high):
            sought = trial.sought.copy()
            sought[place] = value
            known = value == trial.sought[place]
            both.append(trial.motions[number] if known else self.trials.motion(number, sought))
            self.trials.left_work -= both[-1].work
        before, after = both
        moved = after.z - before.z
        if np.abs(moved).max() < SAME * np.abs(trial.motions[number].z).max():
            moved[:] = 0.0
        own = self.trials.places(number)
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
        each, states = self.trials.records[number], trial.motions[number].states
        scale = np.array([1.0, float(each.turning.speeds.max())])[:, None]
        beside = states[0] + STEP * np.abs(states[:, 0]).max() * scale
        start = self.trials.body(trial.sought).found.to_q(beside)
        apart = (self.trials.motion(number, trial.sought, start=start).states - states) / scale
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
        for number, each in enumerate(self.trials.records):
            others = sum(self._sizes(number)[1:])
            kept += [each.first(self.part), np.ones(others)]
        return np.concatenate(kept)
