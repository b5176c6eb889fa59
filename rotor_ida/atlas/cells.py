"""One rotor of an atlas: its attractors, and how many of the starts end on each."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.basins.attractors import Attractor, attractors_of
from rotor_ida.basins.following import follow_here
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.parallel import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.storage.studies.arrays import packed, unpacked

Values = npt.NDArray[np.float64]

# Numbers of an attractor as they are kept.
NUMBERS = (
    *("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lifetime", "lifetime_low"),
)
# Of the times after which starts are decided: the median, and that of 95 of 100.
QUANTILES = (0.5, 0.95)
NEVER = np.full(2, np.nan)
_WORDS = {number: word for word, number in RESPONSE.items()}
_TRAPPING = {number: word for word, number in TRAPPING.items()}


@dataclass(slots=True)
class Member:
    """An attractor of one rotor, with the starts that end on it.

    Parameters
    ----------
    attractor : Attractor
        The attractor.
    count : int
        Number of starts.
    settling : ndarray, shape (2,)
        Median and 95 % of the times after which they are decided [1]; NaN where there are none.
    state : ndarray, shape (4,)
        A state of it on the rotating axes, of a limit cycle [1]; else NaN.
    identity : int
        Number of the attractor along the atlas; -1 until it is known.
    """

    attractor: Attractor
    count: int
    settling: Values
    state: Values
    identity: int = -1


@dataclass(slots=True)
class Cell:
    """One rotor with its attractors.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    members : list of Member
        Its attractors.
    undecided, not_computed : int
        Numbers of starts.
    """

    rotor: Rotor
    members: list[Member] = field(default_factory=list)
    undecided: int = 0
    not_computed: int = 0


@dataclass(frozen=True, slots=True)
class CellJob:
    """A rotor with its starts, (4, n), and the error allowed in a step."""

    rotor: Rotor
    states: Values
    tolerance: float


def fill_cell(job: CellJob, stop: Stop) -> Cell:
    """Follow all starts of a rotor, and count them by attractor."""
    known = known_from_closed_forms(job.rotor, stop)
    found = follow_here(known, job.states, job.tolerance, stop)
    cell, attractors = Cell(job.rotor), attractors_of(found)
    cell.undecided = int((found.labels == UNDECIDED).sum())
    cell.not_computed = int((found.labels == NOT_COMPUTED).sum())
    for number, attractor in enumerate(attractors):
        own = found.labels == number
        times = found.times[own]
        settling = np.quantile(times, QUANTILES) if times.size else NEVER
        state = np.full(4, np.nan)
        for cycle in found.cycles:
            if cycle.period == attractor.period:
                state = cycle.state
        cell.members.append(Member(attractor, int(own.sum()), settling, state))
    return cell


def cell_as_bytes(cell: Cell) -> bytes:
    """Return a cell as bytes that `cell_from_bytes` reads."""
    rows = [each.attractor for each in cell.members]
    arrays = {
        "rotor": np.array([cell.rotor.omega, cell.rotor.zeta, cell.rotor.delta0]),
        "left": np.array([cell.undecided, cell.not_computed]),
        "kind": np.array([RESPONSE[row.kind] for row in rows], dtype=np.int8),
        "trapping": np.array([TRAPPING[row.trapping] for row in rows], dtype=np.int8),
        "numbers": np.array([[getattr(row, name) for name in NUMBERS] for row in rows]),
        "count": np.array([each.count for each in cell.members], dtype=np.int64),
        "settling": np.array([each.settling for each in cell.members]),
        "state": np.array([each.state for each in cell.members]),
    }
    return packed(arrays)


def cell_from_bytes(content: bytes) -> Cell:
    """Return the cell that `cell_as_bytes` was given.

    Raises
    ------
    ValueError
        If it cannot have written it.
    """
    arrays = unpacked(content)
    try:
        omega, zeta, delta0 = arrays["rotor"].tolist()
        cell = Cell(Rotor(omega=omega, zeta=zeta, delta0=delta0))
        cell.undecided, cell.not_computed = arrays["left"].tolist()
        for number, kind in enumerate(arrays["kind"].tolist()):
            numbers = dict(zip(NUMBERS, arrays["numbers"][number].tolist(), strict=True))
            trapping = _TRAPPING[int(arrays["trapping"][number])]
            attractor = Attractor(_WORDS[kind], trapping=trapping, **numbers)
            count, settling = int(arrays["count"][number]), arrays["settling"][number]
            cell.members.append(Member(attractor, count, settling, arrays["state"][number]))
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"it holds no cell of an atlas: {error}") from error
    return cell
