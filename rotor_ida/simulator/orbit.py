"""What a simulation returns before it is labelled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from rotor_ida.parameters import Rotor
from rotor_ida.simulator.options import Options

Values = npt.NDArray[np.float64]

ENTRY = 1
EXIT = -1


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
        Time that it covers, from 0 [1].
    times : ndarray, shape (n,)
        Sample times [1].
    states : ndarray, shape (n, 4)
        ``(x, y, vx, vy)`` at those times, fixed frame [1].
    starts_in_contact : bool
        Whether it starts in contact.
    event_times, event_kinds : ndarray, shape (m,)
        When contact begins (1) and ends (-1) [1].
    event_states : ndarray, shape (m, 4)
        ``(x, y, vx, vy)`` at the events, fixed frame [1].
    contacts : ndarray, shape (k, 6)
        Entry, exit and peak time, peak indentation, impulse, and angular momentum at the peak
        of each contact [1]; entry or exit, and the impulse, are NaN where the run began or
        ended inside the contact.
    end : ndarray, shape (4,)
        State at the end, fixed frame [1].
    evaluations : int
        Evaluations of the right-hand side.
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
    contacts: Values
    end: Values
    evaluations: int
