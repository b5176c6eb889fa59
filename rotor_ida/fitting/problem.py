"""The least-squares problem of a fit: unknowns, residuals and their derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.errors import InputError, RotorError
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.fitting.motion import LARGEST_GROWTH, Motion, motion_of
from rotor_ida.fitting.records import Measured
from rotor_ida.model.rotor import DimensionalRotor

Mask: TypeAlias = npt.NDArray[np.bool_]

# Singular values below this part of the largest are rounding.
RANK = 1e-10
# A failed simulation counts as this many times the residuals of the first guess.
FAR_OFF = 1e3
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
        Number of times that motions have been simulated.
    part : float
        Fraction of the windows, from the first, that the search uses: 1 is all.
    clear : dict
        For each record and kind, which of the measured times are compared; by default all.
    """

    machine: DimensionalRotor
    unknown: list[Unknown]
    records: list[Measured]
    noise: float
    time_error: float = math.inf
    starts: list[Values] | None = None
    _last: tuple[bytes, Values, Values, list[Motion]] | None = field(default=None, repr=False)
    evaluations: int = 0
    part: float = 1.0
    clear: dict[tuple[int, int], Mask] = field(default_factory=dict)

    def renew(self, **known: object) -> None:
        """Set the noise, the error of contact times or the part, which changes the weights."""
        for name, value in known.items():
            setattr(self, name, value)
        self._last = None

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
        """Return the motion for each record."""
        machine, ahead = self.machine_of(sought)
        names = [each.field for each in self.unknown]
        count = len(names)
        found = []
        for number, each in enumerate(self.records):
            start = (
                sought[count + 4 * number : count + 4 * number + 4]
                if self.starts is None
                else self.starts[number]
            )
            found.append(motion_of(machine, each.turning, start, each.times, names, ahead))
            if not found[-1].growth <= LARGEST_GROWTH:
                raise InputError(
                    "signals must show a motion that its start determines, but by "
                    f"{found[-1].lost:.6g} after the start small changes "
                    f"have grown by {LARGEST_GROWTH:g}: fit a part of them"
                )
        return found

    def at(self, sought: Values) -> tuple[Values, Values, list[Motion]]:
        """Return the residuals, their derivatives, and the motions."""
        key = sought.tobytes()
        if self._last is None or self._last[0] != key:
            self.evaluations += 1
            motions = self.motions(sought)
            parts = [self._compared(n, motion, sought) for n, motion in enumerate(motions)]
            left, slopes = (np.concatenate(each) for each in zip(*parts, strict=True))
            self._last = (key, left, slopes, motions)
        return self._last[1:]

    def left(self, sought: Values) -> Values:
        """Return the residuals; large where the simulation fails."""
        try:
            return self.at(sought)[0]
        except RotorError:
            if self._last is None:
                raise
            return np.full(self._last[1].size, FAR_OFF * (1.0 + np.abs(self._last[1]).max()))

    def slopes(self, sought: Values) -> Values:
        """Return the derivatives of the residuals."""
        return self.at(sought)[1]

    def freedom(self, sought: Values) -> int:
        """Return the degrees of freedom: numbers compared less unknowns that they determine.

        If a motion forgets its start, the guess determines the start instead.
        """
        _, slopes, motions = self.at(sought)
        measured = np.ones(len(slopes), dtype=bool)
        row = 0
        for each in self.records:
            row += 2 * each.tracks.orders.size * each.tracks.windows.times.size
            if self.starts is None:
                measured[row : row + 4] = False
                row += 4
            if math.isfinite(self.time_error):
                row += sum(times.size for times in each.touches.values())
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

    def _compared(self, number: int, motion: Motion, sought: Values) -> tuple[Values, Values]:
        """Return the residuals of one record, and their derivatives by all unknowns."""
        each, count = self.records[number], len(self.unknown)
        tracks = each.tracks
        kept = tracks.first(self.part) / self.noise
        left = [tracks.weighed((motion.z - each.record.z)[:, None])[:, 0] * kept]
        slopes = [tracks.weighed(motion.slopes) * kept[:, None]]
        if self.starts is None:
            start = sought[count + 4 * number : count + 4 * number + 4]
            left.append((start - each.start) / each.spread)
            slopes.append(np.hstack([np.diag(1.0 / each.spread), np.zeros((4, count))]))
        for found in self.touches(number, motion).values():
            left.append(found.apart / self.time_error)
            slopes.append(found.slopes / self.time_error)
        return np.concatenate(left), self._by_sought(np.concatenate(slopes), number)

    def _by_sought(self, slopes: Values, number: int) -> Values:
        """Return derivatives by all unknowns from those by one initial state and the parameters."""
        count = len(self.unknown)
        found = np.zeros((len(slopes), self.first().size))
        found[:, :count] = slopes[:, 4:] * [each.factor for each in self.unknown]
        if self.starts is None:
            found[:, count + 4 * number : count + 4 * number + 4] = slopes[:, :4]
        return found


@dataclass(frozen=True)
class Touches:
    """Residuals of the contact times of one kind in a record.

    Parameters
    ----------
    times : ndarray, shape (n,)
        The measured times [s].
    apart : ndarray, shape (n,)
        Difference between the nearest computed time and each [s].
    slopes : ndarray, shape (n, c)
        Derivatives of that difference.
    gaps : ndarray, shape (n,)
        Time between the nearest computed event and its neighbour [s].
    compared : ndarray of bool, shape (n,)
        Whether the computed time matches the measured one, so that they are compared.
    """

    times: Values
    apart: Values
    slopes: Values
    gaps: Values
    compared: Mask

    def only(self, clear: Mask | None) -> Touches:
        """Return them without those that are not clear."""
        return (
            self
            if clear is None
            else replace(
                self,
                apart=np.where(clear, self.apart, 0.0),
                slopes=np.where(clear[:, None], self.slopes, 0.0),
                compared=self.compared & clear,
            )
        )


def matched(times: Values, motion: Motion, kind: int) -> Touches:
    """Match computed contact times to measured ones.

    Two match if each is the nearest of the other, no farther away than half the usual gap.
    A measured time without a match has a constant residual, whatever the unknowns.
    """
    found, slopes = (
        (motion.entries, motion.entry_slopes) if kind > 0 else (motion.exits, motion.exit_slopes)
    )
    reach = 0.5 * float(np.median(np.diff(times))) if times.size > 1 else math.inf
    if not found.size:
        missed, none = np.full(times.size, min(reach, float(times[-1]))), np.zeros(times.size)
        still = np.zeros((times.size, slopes.shape[1]))
        return Touches(times, missed, still, none + math.inf, none.astype(bool))
    distances = np.abs(found[:, None] - times)
    nearest = distances.argmin(axis=0)
    apart, by = found[nearest] - times, slopes[nearest]
    alone = (np.abs(apart) >= reach) | ~np.isfinite(by).all(axis=1)
    alone |= distances.argmin(axis=1)[nearest] != np.arange(times.size)
    events = np.sort(np.concatenate([[-math.inf], motion.entries, motion.exits, [math.inf]]))
    gaps = np.diff(events)
    place = np.searchsorted(events, found[nearest])
    return Touches(
        times,
        np.where(alone, np.clip(apart, -reach, reach), apart),
        np.where(alone[:, None], 0.0, by),
        np.minimum(gaps[place - 1], gaps[place]),
        ~alone,
    )
