"""Touches that fade: states from which a rotor touches the ring ever more slightly, for ever.

Out of contact the whirl's centre moves straight from c to c + drift. Where it comes to rest a
little farther out than the clearance leaves room for, the whirl touches the ring once a revolution,
and each touch pushes it inwards a little less than the one before: the limit is the contact-free
whirl that just reaches the ring (`rotor_ida.closed_forms.touch_fading`). A push that is too strong
puts it inside for good. How far out a whirl with little drift may be for its touches to fade is
found by following such states: it is halved until the touches of each of them fade by the law. So
it is an estimate, not a proof.
"""

from __future__ import annotations

import cmath
import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.closed_forms import touch_fading
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.errors import SimulationError
from rotor_ida.parallel import Stop
from rotor_ida.parameters import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

HOW = Options(method="taylor", rtol=1e-12)
STATES, MOST_TRIES = 24, 240
# The drift is at most this part of how much too far out it ends: as in core/lanes.c.
MOST_DRIFT = 0.3
# So many 1/zeta, in which a drift comes to its end, and revolutions after that.
DRIFT_ENDS, REVOLUTIONS = 8.0, 24
# With so little damping that a drift takes longer, none is sought.
LONGEST = 4000.0
# The law is to leading order in C h: the first excess tried, in parts of 1/C and of the room.
LARGEST, OF_THE_ROOM = 0.1, 0.2
HALVINGS = 8
# Touches fade when the last of them come once a revolution, to this part of one, and 1/h grows as
# the law says, to this part of it.
LAST = 4
ONCE_A_REVOLUTION, LIKE_THE_LAW = 0.02, 0.25


def fading_excess(rotor: Rotor, stop: Stop) -> float:
    """Return how much too far out a whirl may lie and still touch ever more slightly.

    Parameters
    ----------
    rotor : Rotor
        A damped rotor.
    stop : ndarray, shape (1,)
        Anything but 0 asks to stop.

    Returns
    -------
    float
        The distance [1]; 0 where there is none, NaN where no contact-free whirl fits.
    """
    growth = touch_fading(rotor)
    if math.isnan(growth):
        return math.nan
    if DRIFT_ENDS / rotor.zeta > LONGEST:
        return 0.0
    room = rotor.delta0 - abs(complex(complex_amplitude(rotor.omega, rotor.zeta)))
    excess = min(LARGEST / growth, OF_THE_ROOM * room)
    for _ in range(HALVINGS):
        states = _states(rotor, room, excess)
        if stop[0] or (states and all(_fades(rotor, state, stop) for state in states)):
            return excess
        excess *= 0.5
    return 0.0


def _states(rotor: Rotor, room: float, excess: float) -> list[Values]:
    """Return states out of contact whose whirl comes to rest too far out, by up to `excess`."""
    whirl = complex(complex_amplitude(rotor.omega, rotor.zeta))
    random = np.random.default_rng(0)
    states: list[Values] = []
    for _ in range(MOST_TRIES):
        outside = excess * random.choice([1.0, 0.5, 0.1])
        end = cmath.rect(room + outside, 2.0 * math.pi * random.random())
        drift = cmath.rect(MOST_DRIFT * outside, 2.0 * math.pi * random.random())
        position = end - drift + whirl
        velocity = 1j * rotor.omega * whirl + 2.0 * rotor.zeta * drift
        if abs(position) < rotor.delta0 and len(states) < STATES:
            states.append(np.array([position.real, position.imag, velocity.real, velocity.imag]))
    return states


def _fades(rotor: Rotor, state: Values, stop: Stop) -> bool:
    """Return whether the touches of a motion fade by the law."""
    revolution = 2.0 * math.pi / rotor.omega
    duration = DRIFT_ENDS / rotor.zeta + REVOLUTIONS * revolution
    x, y, vx, vy = state.tolist()
    try:
        orbit = run(rotor, (x, y, vx, vy), duration, np.empty(0), HOW, stop=stop)
    except SimulationError:
        return False
    times, depths = orbit.contacts[:, 2:4].T
    if depths.size < LAST or times[-1] < duration - 2.0 * revolution:
        return False
    revolutions = np.diff(times[-LAST:]) / revolution
    growth = np.diff(1.0 / depths[-LAST:]) / touch_fading(rotor)
    once = np.abs(revolutions - 1.0) <= ONCE_A_REVOLUTION
    return bool((once & (np.abs(growth - 1.0) <= LIKE_THE_LAW)).all())
