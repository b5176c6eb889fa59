"""Many motions, such as drops or run-ups: a study with a job and a row for each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.model.varied import Varied
from rotor_ida.schema import ENDING, RESPONSE, STATUS
from rotor_ida.steady.grid import Places, Rows

# Whole numbers of a motion that failed; those of other names are 0.
NONE = {"ending": ENDING["failed"], "response": RESPONSE["failed"]}


@dataclass(frozen=True, slots=True)
class Member:
    """One motion, with everything a worker needs to follow it.

    Parameters
    ----------
    case : dict
        What is the same for all.
    varied : dict
        What is varied, by name.
    point : dtype
        The columns of its row.
    """

    case: dict[str, Any]
    varied: dict[str, float]
    point: np.dtype[np.void]


@dataclass(frozen=True, slots=True)
class Members:
    """All motions, by number.

    Parameters
    ----------
    case : dict
        What is the same for all; on a grid ``starts``, of which each motion has one.
    varied : Varied or dict
        What varies: a grid with the axes ``rate`` and ``start``, or values by name, shape
        (motion,).
    point : dtype
        The columns of a row.
    """

    case: dict[str, Any]
    varied: Varied | Mapping[str, Values]
    point: np.dtype[np.void]

    length = 1

    @property
    def points(self) -> int:
        """Number of motions."""
        if isinstance(self.varied, Varied):
            return self.varied.points
        return next(iter(self.varied.values())).size

    def places(self, number: int) -> Places:
        """Return the position of a motion among all: each is a separate job."""
        return np.array([number])

    def job(self, number: int) -> Member:
        """Return what a worker needs to follow a motion."""
        if not isinstance(self.varied, Varied):
            at = {name: float(each[number]) for name, each in self.varied.items()}
            return Member(self.case, at, self.point)
        place = [int(each) for each in np.unravel_index(number, self.varied.shape)]
        at = {name: float(each) for name, each in self.varied.at(place).items()}
        own = {name: each for name, each in self.case.items() if name != "starts"}
        return Member(own | {"start": self.case["starts"][int(at["start"])]}, at, self.point)

    def slowest_first(self) -> Places:
        """Return the numbers of the motions, of a grid those at the lowest rates first."""
        numbers = np.arange(self.points)
        if not isinstance(self.varied, Varied):
            return numbers
        places = np.unravel_index(numbers, self.varied.shape)
        rates = self.varied.axes["rate"][places[self.varied.dims.index("rate")]]
        return np.argsort(np.abs(rates), kind="stable")


def row_of(
    job: Member, figures: Mapping[str, Any], message: str = "", *, failed: bool = False
) -> Rows:
    """Return the figures of a motion as a row; those that are missing are NaN, or no number."""
    row = np.zeros(1, job.point)
    for name in row.dtype.names or ():
        blank = math.nan if row[name].dtype.kind == "f" else NONE.get(name, 0)
        row[name] = figures.get(name, blank)
    row["status"] = STATUS["failed" if failed else "done"]
    return Rows(row, [message])


def lost(job: Member, reason: str) -> Rows:
    """Return the row of a motion that failed, or whose workers died."""
    return row_of(job, {}, reason, failed=True)


def as_they_are(rows: Rows) -> Rows:
    """Return rows, which need nothing done."""
    return rows
