"""The attractors on which starts of a rotor end: rows of numbers, matched with those met before.

A row is what a motion has settled on: of one disc numbers (`OF_DISC`), of a rotor system arrays
over its contacts and nodes (`rotor_ida.steady.points.point_of`). Both are matched in the same
way: by kind, period and radii, and state. A batch of starts numbers its own attractors; those of
all batches are then matched again, so that the labels do not depend on who followed what.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Flags, Stop, Values
from rotor_ida.basins.kernel import NOT_COMPUTED, UNDECIDED, Labels, Times
from rotor_ida.basins.starts import Starts, stretches
from rotor_ida.core.runs import NO_STOP
from rotor_ida.errors import SimulationError
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import RESPONSE, TRAPPING, by_number
from rotor_ida.simulation.flow import DiscFlow, Flow
from rotor_ida.simulation.options import Options, adams_or_taylor
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady import response
from rotor_ida.steady.follow import Features, Settled, settle_disc
from rotor_ida.steady.grid import Table
from rotor_ida.steady.points import OF_CONTACT, OF_NODE

Indices = npt.NDArray[np.int64]

# Two motions are on one attractor if their radii and periods, or their states, agree to this part.
SAME = 1e-5
RADII = (("radius_min", "node_radius_min"), ("radius_max", "node_radius_max"))
# Whirls that stay inside the clearance; fading touches converge to the outermost one.
CONTACT_FREE_FAMILY = (response.CONTACT_FREE, response.TOUCHING)
# Kinds of motion that move at the speed of the unbalance alone.
AT_THE_SPIN = (*CONTACT_FREE_FAMILY, response.SYNCHRONOUS)
# Kinds of motion without a period, in the order of their attractors.
APERIODIC = (response.ROLLING, response.QUASI_PERIODIC, response.CHAOTIC)

# Numbers of an attractor of one disc: amplitude and phase lag are those of the motion at the spin
# speed [1], [rad], radii the smallest and largest distance from the bearing axis [1], NaN where it
# depends on the start. A lifetime is the mean time after which orbits leave a chaotic motion,
# infinite if none did, with its lower 95 % confidence bound [1]; infinite for all others.
NUMBERS = (
    *("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lifetime", "lifetime_low"),
)
# And the evidence for its trapping region; whether a separate run leads to it from one of its
# starts; and a state on the rotating axes [1], NaN where the numbers say which.
OF_DISC = np.dtype(
    [
        ("response", np.int8), *((name, np.float64) for name in (*NUMBERS, "largest_force")),
        ("touched", np.int8), ("node_radius_min", np.float64, (0,)),
        ("node_radius_max", np.float64, (0,)), ("final_state", np.float64, (4,)),
        ("trapping", np.int8), ("confirmed", np.int8),
    ]
)  # fmt: skip
OF_SYSTEM = ("period", *OF_CONTACT, "touched", *OF_NODE, "final_state")
NOWHERE = np.full(4, np.nan)
# Evidence for the region of an attractor: see `rotor_ida.schema.TRAPPING`.
PROVEN, ESTIMATED, NOTHING = "proven", "estimated", "none"

# Number of starts that separate runs follow before an attractor counts as unconfirmed.
WITNESSES = 3
_KIND = by_number(RESPONSE)


class Found(NamedTuple):
    """Labelled starts of a batch.

    Parameters
    ----------
    labels, times : ndarray, shape (n,)
        Number of the row of the attractor of each start, UNDECIDED or NOT_COMPUTED; and the time
        after which it was decided.
    rows : list of structured scalars
        The attractors.
    again : callable
        Returns labels of some starts, given their numbers, followed again with a smaller error.
    watched : tuple of float
        Number of orbits that left a chaotic motion, and the time for which chaos was observed.
    reason : str
        Why starts were not computed; else empty.
    """

    labels: Labels
    times: Times
    rows: list[np.void]
    again: Callable[[Indices], Labels]
    watched: tuple[float, float] = (0.0, 0.0)
    reason: str = ""


class Ended(NamedTuple):
    """How a computation of many starts ended.

    Parameters
    ----------
    interrupted : bool
        Whether the user interrupted it.
    reason : str
        Why starts were not computed, other than by an interrupt; else empty.
    """

    interrupted: bool = False
    reason: str = ""


@dataclass(slots=True)
class Followed:
    """Results of many starts, n of them.

    Parameters
    ----------
    labels, times : ndarray, shape (n,)
        As of a batch, the attractors numbered in the order of a result.
    rows : structured array, shape (m,)
        The attractors.
    rtol : float
        Error allowed in a step.
    rechecked : ndarray of int64, shape (2,)
        As of a batch.
    ended : Ended
        How the computation ended.
    """

    labels: Labels
    times: Times
    rows: Table
    rtol: float
    rechecked: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(2, dtype=np.int64))
    ended: Ended = field(default_factory=Ended)

    @property
    def kinds(self) -> list[str]:
        """The kind of each attractor."""
        return [kind_of(row) for row in self.rows]


def disc_row(
    kind: str, amplitude: float, lag: float, low: float, high: float, *, period: float = math.nan,
    trapping: str = PROVEN, state: Values | Sequence[float] = NOWHERE,
) -> np.void:  # fmt: skip
    """Return an attractor of one disc as a row."""
    row: np.void = np.zeros(1, OF_DISC)[0]
    numbers = (amplitude, lag, low, high, period, math.inf, math.inf)
    for name, number in zip(NUMBERS, numbers, strict=True):
        row[name] = number
    row["response"], row["trapping"], row["final_state"] = RESPONSE[kind], TRAPPING[trapping], state
    return row


def row_of(settled: Settled[Features]) -> np.void:
    """Return what a motion of one disc has settled on as a row."""
    told = settled.features
    return disc_row(
        settled.kind, told.amplitude, told.phase_lag, told.radius_min, told.radius_max,
        period=told.period, trapping=NOTHING, state=settled.motion.state,
    )  # fmt: skip


def kind_of(row: np.void) -> str:
    """Return the kind of an attractor, one of those of `rotor_ida.steady.response`."""
    return _KIND[int(row["response"])]


def has_period(row: np.void) -> bool:
    """Return whether an attractor is a limit cycle."""
    return bool(row["period"] > 0.0)


def reported(columns: np.dtype[np.void]) -> tuple[str, ...]:
    """Return the names of what is reported of attractors with these columns, besides their kind."""
    return (*NUMBERS, "trapping") if columns == OF_DISC else OF_SYSTEM


def family_of(kinds: Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of the attractors in the contact-free family, by the kind of each."""
    return tuple(number for number, kind in enumerate(kinds) if kind in CONTACT_FREE_FAMILY)


def renumbered(labels: Labels, numbers: Sequence[int]) -> Labels:
    """Return labels with other numbers of attractors; the two fates stay."""
    # negative indices find them at the end
    table = np.array([*numbers, NOT_COMPUTED, UNDECIDED], np.int16)
    return table[labels]


class Attractors:
    """The attractors on which motions of a flow have settled, in the order in which they were met.

    Parameters
    ----------
    flow : Flow
        How the rotor moves.
    rows : iterable of structured scalars
        Attractors that are known already.
    """

    def __init__(self, flow: Flow, rows: Iterable[np.void] = ()) -> None:
        self.flow = flow
        self.rows = list(rows)
        self._strobed: dict[int, Values] = {}

    def numbers_of(self, rows: Iterable[np.void]) -> list[int]:
        """Return the numbers of several attractors, no two of which are one."""
        numbers: list[int] = []
        for row in rows:
            numbers.append(self.number_of(row, numbers))
        return numbers

    def number_of(self, row: np.void, besides: Collection[int] = ()) -> int:
        """Return the number of the attractor of a settled motion, which may be a new one."""
        number = self.find(row, besides)
        if number is None:
            self.rows.append(row.copy())
            return len(self.rows) - 1
        self.rows[number] = _joined(self.rows[number], row)
        return number

    def find(self, row: np.void, besides: Collection[int] = ()) -> int | None:
        """Return the number of the attractor of a settled motion; None if it was not met."""
        others = (each for each in range(len(self.rows)) if each not in besides)
        return next(
            (each for each in others if _same(self.rows[each], row) or self._is_on(each, row)), None
        )

    def order(self) -> list[int]:
        """Return their numbers in the order of a result.

        That is whirls, the contact-free family, cycles, and motions without a period, each by the
        largest part of a clearance that they take.
        """
        gaps = np.where(self.flow.clearances > 0.0, self.flow.clearances, 1.0)

        def place(number: int) -> tuple[int, int, float]:
            row, kind = self.rows[number], kind_of(self.rows[number])
            sorts = [kind == response.SYNCHRONOUS, kind in CONTACT_FREE_FAMILY, has_period(row)]
            sort = [*sorts, True].index(True)
            among = APERIODIC.index(kind) if sort == len(sorts) and kind in APERIODIC else 0
            return sort, among, float(np.nanmax(row["radius_max"] / gaps, initial=0.0))

        return sorted(range(len(self.rows)), key=place)

    def _is_on(self, number: int, row: np.void) -> bool:
        """Return whether a settled motion is on a known attractor.

        All contact-free motions are on one, all touches that fade on one, and so are all motions
        without a period of one kind, but for those that roll in different contacts.
        """
        known, kind = self.rows[number], kind_of(row)
        if known["response"] != row["response"]:
            return False
        if kind in CONTACT_FREE_FAMILY:
            return True
        if kind == response.SYNCHRONOUS:
            return self._has_state(number, row)
        if not (has_period(known) and has_period(row)):
            elsewhere = (
                kind == response.ROLLING and np.not_equal(known["touched"], row["touched"]).any()
            )
            return has_period(known) == has_period(row) and not elsewhere
        periods = np.array([known["period"], row["period"]])
        times = periods.max() / periods.min()  # round the cycle, which may be found as a multiple
        if abs(times / round(times) - 1.0) > SAME or _differing(known, row).any():
            return False
        # on rotating axes a motion meets a cycle anywhere
        return self.flow.period is None or self._has_state(number, row)

    def _has_state(self, number: int, row: np.void) -> bool:
        """Return whether an attractor has the state at the end of a motion."""
        if number not in self._strobed:
            self._strobed[number] = self._strobed_states(self.rows[number])
        strobed = self._strobed[number]
        apart = np.abs(strobed - state_on(self.flow, row)).max(axis=1).min()
        return bool(apart <= SAME * np.abs(strobed).max())

    def _strobed_states(self, row: np.void) -> Values:
        """Return the states of an attractor after each revolution of its period."""
        states = [state_on(self.flow, row)]
        period = float(row["period"]) if has_period(row) else 0.0
        for _ in range(round(period / self.flow.revolution) - 1):
            states.append(self.flow.after(states[-1], self.flow.revolution))
        return np.array(states)


def state_on(flow: Flow, row: np.void) -> Values:
    """Return the state on an attractor, as that of a flow."""
    own: Values = row["final_state"]
    return flow.given_state(own) if isinstance(flow, SystemFlow) else own


def _radii(row: np.void) -> Values:
    """Return the smallest and largest radii of contacts and nodes, shape (2, place)."""
    return np.array([np.concatenate([np.atleast_1d(row[name]) for name in names])
                     for names in RADII])  # fmt: skip


def _same(known: np.void, row: np.void) -> bool:
    """Return whether two rows have the same bits, as where several batches know an attractor."""
    return known.tobytes() == row.tobytes()


def _differing(known: np.void, row: np.void) -> Flags:
    """Return which radii differ, relative to the largest, shape (2, place)."""
    one, other = _radii(known), _radii(row)
    return np.asarray(~(np.abs(one - other) <= SAME * np.nan_to_num(other).max()))


def _joined(known: np.void, row: np.void) -> np.void:
    """Return an attractor with one more of its motions.

    It has the shortest period that was found, and the range of radii that depend on the start.
    """
    kind = kind_of(row)
    if kind == response.SYNCHRONOUS or _same(known, row):
        return known
    if has_period(known):
        times = float(known["period"] / row["period"])
        return min(known, row, key=itemgetter("period")) if round(times) != 1 else known
    if kind in CONTACT_FREE_FAMILY:
        radii = np.where(_differing(known, row), math.nan, _radii(known))
    else:
        (low, high), (lower, higher) = _radii(known), _radii(row)
        radii = np.array([np.minimum(low, lower), np.maximum(high, higher)])
    found, contacts = known.copy(), np.size(known["touched"])
    for names, each in zip(RADII, radii, strict=True):
        for name, part in zip(names, (each[:contacts], each[contacts:]), strict=True):
            found[name] = part.reshape(np.shape(known[name]))
    for name in ("largest_force", "touched"):
        found[name] = np.maximum(known[name], row[name])
    return found


# ---- What separate runs say of those of one disc: by CVODE where it is there ----


def witness_options() -> Options:
    """Return the options by which attractors and smallest shocks of one disc are confirmed."""
    return Options(method=adams_or_taylor({}))


def confirm(
    rotor: Rotor, followed: Followed, starts: Starts, options: Options, *, can_stop: bool
) -> None:
    """Note which attractors of one disc a separate run reaches from one of their starts.

    If the user interrupts it, and it `can_stop`, none counts as confirmed.
    """
    try:
        for row, numbers in zip(followed.rows, _first_decided(followed), strict=True):
            states = (starts(number, number + 1)[:, 0] for number in numbers)
            row["confirmed"] = any(leads_to(rotor, row, state, options) for state in states)
    except KeyboardInterrupt:  # labels without confirmation are better than none
        if not can_stop:
            raise
        followed.ended = followed.ended._replace(interrupted=True)
        followed.rows["confirmed"] = 0


def _first_decided(followed: Followed) -> list[list[int]]:
    """Return, for each attractor, the numbers of the starts that were decided first.

    They are the least likely to lie so near a basin boundary that another integrator disagrees.
    """
    labels, times = followed.labels, followed.times
    first = [np.empty(0, dtype=np.int64) for _ in followed.rows]
    for stretch in stretches(labels.size):
        for number in range(len(first)):
            members = stretch.start + np.flatnonzero(labels[stretch] == number)
            members = np.concatenate([first[number], members])
            order = np.argsort(times[members], kind="stable")
            first[number] = members[order[:WITNESSES]]
    return [each.tolist() for each in first]


def leads_to(
    rotor: Rotor, attractor: np.void, start: Values, options: Options, *, family: bool = False,
    stop: Stop = NO_STOP,
) -> bool:  # fmt: skip
    """Return whether a run leads from a start to an attractor, or with `family` to its family.

    Fading touches belong to the contact-free family.
    """
    try:
        row = row_of(settle_disc(rotor, start, options, stop=stop))
    except SimulationError:
        return False
    if family and {kind_of(attractor), kind_of(row)} <= {*CONTACT_FREE_FAMILY}:
        return True
    return Attractors(DiscFlow(rotor, stop), [attractor]).find(row) is not None
