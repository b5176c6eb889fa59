"""The contact times of a record beside those of a motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.fitting.motion import Motion
from rotor_ida.schema.flags import ENTRY, EXIT

Mask: TypeAlias = npt.NDArray[np.bool_]


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
