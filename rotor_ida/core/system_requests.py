"""What is asked of a run of a rotor system, and what it reports: values without the core."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.runs import Rows, rows_of_numbers
from rotor_ida.model.bearing import Films

LAW = np.dtype(
    [
        ("offset", np.float64, 2),
        *(
            (name, np.float64)
            for name in (
                "clearance", "hertz", "linear", "contact_damping", "friction", "radius",
                "race_radius", "inverse_race_inertia", "race_drag",
            )
        ),
        ("race", np.int64),
    ]
)  # fmt: skip
LAW_CHANGE = rows_of_numbers("clearance", "stiffness", "contact_damping", "friction")
TOUCH = np.dtype(
    [
        *((name, np.float64) for name in ("root", "race", "sense")),
        ("mode", np.int32),
        ("zeros", np.int32, 3),
    ]
)
EPISODE = rows_of_numbers(
    "contact", "entry", "exit", "peak_root", "peak_time", "largest_force", "force_time",
    "impulse", "work", "heat", "slip_distance", "rolling_time",
)  # fmt: skip
# The extreme speeds of a race, and their times.
RACE = rows_of_numbers("largest", "largest_time", "smallest", "smallest_time")
# An extremum of the distance of a place, of the kinds -1 minimum and 1 maximum; at the ends of a
# run 0.
EXTREMUM_OF_PLACE = np.dtype(
    [("time", np.float64), ("distance", np.float64), ("place", np.int32), ("kind", np.int32)]
)
# Numbers of a contact at a sample: normal and tangential force, slip speed, mode.
FORCES = 4
# Energies that a run gains and loses.
LEDGER = ("unbalance", "damping", "stiffness_rate", "normal", "tangential", "bearings")
NO_FILMS = Films((), np.zeros((0, 2, 0)))


class Standstill(NamedTuple):
    """Whether a driven rotor stands: since when its speed has stayed below a limit in size.

    Parameters
    ----------
    limit : float
        The limit; 0 where it was not asked for.
    since, rate : float
        When the speed last fell below it, NaN while it is above; and its rate then.
    longest : float
        The longest time below that has ended.
    """

    limit: float
    since: float = math.nan
    rate: float = 0.0
    longest: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ByParameter:
    """The derivatives of a system by one parameter, in coordinates with a unit mass matrix.

    Parameters
    ----------
    speed : float
        Of the speed, the same at all times.
    mass, stiffness, damping : ndarray, shape (n, n)
        Of the matrices; None where they stay as they are.
    unbalance : ndarray, shape (2, n), or None
        Of the unbalance.
    force : ndarray, shape (n,), or None
        Of the constant force.
    laws : ndarray of LAW_CHANGE, shape (contact,)
        Of the contacts; that of a stiffness in parts of it.
    """

    speed: float = 0.0
    mass: Values | None = None
    stiffness: Values | None = None
    damping: Values | None = None
    unbalance: Values | None = None
    force: Values | None = None
    laws: Rows


def law_changes(own: Rows, before: Rows, after: Rows, step: float) -> Rows:
    """Return the derivatives of the laws of contacts, of which two differ by a step."""
    laws = np.zeros(len(own), LAW_CHANGE)
    for each in ("clearance", "contact_damping", "friction"):
        laws[each] = (after[each] - before[each]) / step
    here, less, more = (each["hertz"] + each["linear"] for each in (own, before, after))
    laws["stiffness"] = (more - less) / here / step
    return laws


class Places(NamedTuple):
    """Places of a system whose distances from centres are observed.

    Parameters
    ----------
    rows : ndarray, shape (place, 2, n)
        Their displacements, in coordinates with a unit mass matrix.
    centres : ndarray, shape (place, 2)
        From where the distances count.
    """

    rows: Values
    centres: Values


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemRequest:
    """A run of a rotor system, in coordinates with a unit mass matrix.

    Parameters
    ----------
    stiffness, damping, gyroscopic, stiffness_rate : ndarray, shape (n, n)
        Matrices; None where there are none.
    rows : ndarray, shape (contact, 2, n)
        Displacements of the contacts.
    unbalance : ndarray, shape (2, n)
        Unbalance, by the cosine and the sine of the angle.
    force : ndarray, shape (n,)
        Constant force.
    laws : ndarray of LAW
        The law of each contact.
    races : ndarray, shape (contact,)
        Speed of each race at time 0.
    pieces : ndarray of PIECE
        How the speed changes.
    speed : float
        Speed at time 0, if a torque drives it.
    inertia : float
        Moment of inertia about the axis of rotation, if a torque drives the rotor.
    weight : tuple of float
        Moment of the unbalance's weight about that axis, by the cosine of the angle and by minus
        its sine.
    standing : float
        Speed below which a rotor that a torque drives stands; 0 if that is not asked.
    rtol : float
        Tolerance of one step.
    order : int
        Order of the Taylor series.
    only_events : bool
        Whether energies, episodes and peaks are left out.
    displacement, velocity, fastest : float
        By which errors are measured; and the largest rate of the system without contacts.
    start : ndarray, shape (2, n)
        Displacement and velocity at time 0.
    times : ndarray
        Times of samples; the last is the end.
    duration : float
        The end.
    massless : int
        How many of the coordinates, the last, are of stators without mass.
    columns : ndarray, shape (column, 2 n + contact), optional
        Small changes of the start, whose course is wanted: of displacements, velocities and speeds
        of races. At a prescribed speed, and without stators without mass; by Taylor series.
    parameters : sequence of ByParameter
        Parameters that change beside, each alone with one of the last columns.
    watched : ndarray, shape (row, n), optional
        Rows by which samples see the columns.
    method : {"taylor", "adams", "bdf"}
        Solver while a contact touches. Flight, a linear motion, is always by Taylor series.
    places : Places, optional
        Of which the extrema of the distances are wanted.
    films : Films, optional
        Bearings whose coefficients depend on the speed.
    """

    stiffness: Values
    damping: Values | None
    gyroscopic: Values | None
    stiffness_rate: Values | None
    rows: Values
    unbalance: Values
    force: Values
    laws: Rows
    races: Values
    pieces: Rows
    speed: float
    inertia: float
    weight: tuple[float, float]
    standing: float
    rtol: float
    order: int
    only_events: bool = False
    displacement: float
    velocity: float
    fastest: float
    start: Values
    times: Values
    duration: float
    massless: int = 0
    columns: Values | None = None
    parameters: Sequence[ByParameter] = ()
    watched: Values | None = None
    method: str = "taylor"
    places: Places | None = None
    films: Films = NO_FILMS


@dataclass(frozen=True, slots=True, kw_only=True)
class SystemResult:
    """What the core reports of a run.

    Parameters
    ----------
    status : int
        How it ended.
    time : float
        Where it ended.
    state : ndarray, shape (2, n)
        The state there.
    touches : ndarray of TOUCH
        How each contact was then.
    samples : ndarray, shape (sample, 2, n)
        Displacement and velocity.
    forces : ndarray, shape (sample, contact, 4)
        Normal and tangential force, slip speed, mode.
    turns : ndarray, shape (sample, 2)
        Angle and speed.
    event_times, event_kinds, event_contacts, event_turns : ndarray
        The events.
    event_states : ndarray, shape (event, 2, n)
        Displacement and velocity at events.
    event_races : ndarray, shape (event, contact)
        Speeds of races.
    event_rates : ndarray, shape (event,)
        How fast the guard of each event changes: the radius at an entry or exit, the radial
        velocity at a press or release, the slip, or the tangential force that is left at a slip.
        Infinite where another event or a jump of the acceleration brings it about; NaN by the
        plain-Python witness.
    races : ndarray of RACE, shape (contact,)
        The extreme speeds of races.
    episodes : ndarray of EPISODE
        Contacts that ended, in the order of their ends; then those that last.
    ledger : dict
        Energies gained and lost.
    steps : int
        Steps taken.
    turn : tuple of float
        Angle and speed at the end.
    standstill : Standstill
        Whether a driven rotor stands at the end.
    columns : ndarray, shape (column, 2 n + contact)
        What the changes of the start have become.
    sample_columns : ndarray, shape (sample, row, column)
        What was watched of them at samples.
    event_columns : ndarray, shape (event, 2, column)
        Displacements of the contacts at their events.
    extrema : ndarray of EXTREMUM_OF_PLACE
        The extrema of the distances of places, and these at both ends; place by place, by time.
    """

    status: int
    time: float
    state: Values
    touches: Rows
    samples: Values
    forces: Values
    turns: Values
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    event_contacts: npt.NDArray[np.int32]
    event_turns: Values
    event_states: Values
    event_races: Values
    event_rates: Values
    races: Rows
    episodes: Rows
    ledger: dict[str, float]
    steps: int
    turn: tuple[float, float]
    standstill: Standstill
    columns: Values = field(default_factory=lambda: np.empty((0, 0)))
    sample_columns: Values = field(default_factory=lambda: np.empty((0, 0, 0)))
    event_columns: Values = field(default_factory=lambda: np.empty((0, 2, 0)))
    extrema: Rows = field(default_factory=lambda: np.empty(0, EXTREMUM_OF_PLACE))

    def at_every(self, step: int) -> SystemResult:
        """Return the run with every `step`-th sample, beginning with the first."""
        sampled = ("samples", "forces", "turns", "sample_columns")
        return replace(self, **{name: getattr(self, name)[::step].copy() for name in sampled})


class SystemEvents(NamedTuple):
    """The events of a run up to a time; the fields of `SystemResult`."""

    time: float
    event_times: Values
    event_kinds: npt.NDArray[np.int32]
    event_contacts: npt.NDArray[np.int32]
