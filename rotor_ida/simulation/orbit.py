"""One simulated motion of a disc: samples, events and contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.runs import Rows
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema.flags import ROLLS
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.spin import SpeedProfile


@dataclass(frozen=True, slots=True)
class SpeedRecord:
    """How the speed of a rotor changed during a run.

    Parameters
    ----------
    profile : SpeedProfile
        The profile of the speed.
    samples, events, end : ndarray of `rotor_ida.core.runs.SPIN`
        Angle and speed at the sample times, at the events, and at the end [dimensionless].
    energies : tuple of float, optional
        The energy at the start and at the end, and the work of the drive less the losses in damping
        and contacts, which must be their difference [dimensionless]. None for the compiled core,
        which balances each contact itself.
    """

    profile: SpeedProfile
    samples: Rows
    events: Rows
    end: Rows
    energies: tuple[float, float, float] | None


@dataclass(frozen=True, slots=True)
class Orbit:
    """One simulated motion: samples, contact events and contacts.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    options : Options
        How it was simulated.
    duration : float
        Duration, from time 0 [dimensionless].
    times : ndarray, shape (n,)
        Sample times [dimensionless].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times, fixed frame [dimensionless].
    starts_in_contact : bool
        Whether it starts in contact.
    event_times, event_kinds : ndarray, shape (m,)
        When contact begins (1) and ends (-1); with contact damping when the surfaces come loose
        (-4) and press again (4); with friction when the disc begins to roll (2) or to slip (-2), or
        reverses its sliding (3) [dimensionless].
    event_states : ndarray, shape (m, 4)
        ``(x, y, vx, vy)`` at the events, fixed frame [dimensionless].
    contacts : ndarray of `rotor_ida.core.runs.CONTACT`
        The contacts [dimensionless]: angular momentum at the peak, loss and largest force with
        contact damping, and heat of sliding. Entry or exit is NaN where the run began or ended
        inside the contact; the impulse is NaN without clearance.
    end : ndarray, shape (4,)
        State at the end, fixed frame [dimensionless].
    evaluations : int
        Evaluations of the right-hand side.
    steps : int
        Steps of compiled code, where a flight in closed form is one.
    modes : ndarray, shape (m + 1,), optional
        With friction, the mode from the start, and from each event on: flight (0),
        sliding forwards (1) or backwards (-1), rolling (2) or loose (3).
    extrema : ndarray of `rotor_ida.core.runs.EXTREMUM`, optional
        The extrema of the radius, with states on the rotating axes [dimensionless], if requested.
    speed_record : SpeedRecord, optional
        How the speed changed, if it did.
    """

    rotor: Rotor
    options: Options
    duration: float
    times: Values
    states: Values
    starts_in_contact: bool
    event_times: Values
    event_kinds: npt.NDArray[np.int8]
    event_states: Values
    contacts: Rows
    end: Values
    evaluations: int
    steps: int
    modes: npt.NDArray[np.int8] | None = None
    extrema: Rows | None = None
    speed_record: SpeedRecord | None = None

    @property
    def event_angles(self) -> Values:
        """The angle of the unbalance at each event [dimensionless]."""
        if self.speed_record is None:
            return self.rotor.omega * self.event_times
        return np.asarray(self.speed_record.events["angle"])

    @property
    def event_speeds(self) -> Values | float:
        """The speed at each event, or the one speed of all [dimensionless]."""
        return self.rotor.omega if self.speed_record is None else self.speed_record.events["speed"]

    @property
    def speeds(self) -> Values | float:
        """The speed at each sample, or the one speed of all [dimensionless]."""
        return self.rotor.omega if self.speed_record is None else self.speed_record.samples["speed"]


def stretches_of_rolling(orbit: Orbit) -> Values:
    """Return when the disc begins and ceases to roll on the stator, shape (n, 2) [1]."""
    if orbit.modes is None:
        return np.empty((0, 2))
    rolls = orbit.modes == ROLLS
    began = np.concatenate([[0.0], orbit.event_times])
    ended = np.concatenate([orbit.event_times, [orbit.duration]])
    return np.column_stack([began[rolls], ended[rolls]])
