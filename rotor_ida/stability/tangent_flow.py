"""The motion together with its tangent space: how small differences of the state evolve.

State and tangent vectors are read on the rotating axes, where the motion is autonomous. The
field is continuous with a continuous Jacobian: the Hertz force leaves the ring like
indentation**1.5, its slope like indentation**0.5. The variational equation ``M' = J(state) M``
therefore holds through every entry and exit as it stands, with no jump of M to be added there [1]_.

In flight both are known in closed form; in contact they are followed together, by one Taylor
series, or by CVODE.

References
----------
.. [1] P. C. Müller, "Calculation of Lyapunov exponents for dynamic systems with
   discontinuities", Chaos, Solitons & Fractals 5, 1995: the jump, which vanishes here.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import numpy.typing as npt

from rotor_ida.equations.compiling import asked_to_stop, compiled, release
from rotor_ida.parallel.jobs import Stop
from rotor_ida.simulation.contact_phase import T, cartesian, end_of_step, tolerances
from rotor_ida.simulation.flight import drift, first_touch, fly
from rotor_ida.simulation.motion import GOES_ON, Motion
from rotor_ida.simulation.start import contact_start
from rotor_ida.simulation.tangents import COUNT, joined
from rotor_ida.simulation.taylor.motion import open_taylor

Values = npt.NDArray[np.float64]
Parameters = tuple[float, float, float]

DONE, STUCK = 0, 1

_ROUNDING = 2.0**-52
_PATIENCE = 200_000
# Absolute tolerance in parts of the relative one.
_ATOL = 1e-2


@compiled
def follow_on(
    states: Values,
    in_contact: npt.NDArray[np.bool_],
    span: float,
    rotor: Parameters,
    rtol: float,
    stop: Stop,
) -> int:
    """Fill all rows but the first with the states that follow on it, `span` apart.

    Parameters
    ----------
    states : ndarray, shape (n, 4)
        States on the rotating axes, of which the first is given [1].
    in_contact : ndarray of bool, shape (n,)
        Whether each is in contact; the first is given.
    span, rotor, rtol, stop
        As for `follow`: the time from one to the next, omega, zeta and delta0, the tolerance of
        one step relative to the size of the state [1], and what asks to stop.
    """
    state, mode = states[:1].copy(), np.array([1.0 if in_contact[0] else 0.0])
    motion = open_taylor(rotor[0], rotor[1], rotor[2], rotor[2] > 0.0, rtol, False)
    done = DONE
    for row in range(1, states.shape[0]):
        done = follow(state, mode, span, rotor, rtol, motion, stop)
        if done != DONE:
            break
        states[row] = state[0]
        in_contact[row] = mode[0] > 0.0
    release(motion)
    return done


@compiled
def follow_from(
    states: Values,
    in_contact: npt.NDArray[np.bool_],
    spans: Values,
    reached: Values,
    rotor: Parameters,
    rtol: float,
    stop: Stop,
) -> int:
    """Write into `reached` the state that follows on each row of `states` after its span."""
    mode = np.zeros(1)
    motion = open_taylor(rotor[0], rotor[1], rotor[2], rotor[2] > 0.0, rtol, False)
    done = DONE
    for row in range(states.shape[0]):
        state = states[row : row + 1].copy()
        mode[0] = 1.0 if in_contact[row] else 0.0
        if spans[row] > 0.0:
            done = follow(state, mode, spans[row], rotor, rtol, motion, stop)
        if done != DONE:
            break
        reached[row] = state[0]
    release(motion)
    return done


@compiled
def carry(
    bundle: Values, in_contact: bool, span: float, rotor: Parameters, rtol: float, stop: Stop
) -> int:
    """Follow a state and its tangent vectors over `span`, as `follow` does, by Taylor series."""
    mode = np.array([1.0 if in_contact else 0.0])
    motion = open_taylor(rotor[0], rotor[1], rotor[2], rotor[2] > 0.0, rtol, True)
    done = follow(bundle, mode, span, rotor, rtol, motion, stop)
    release(motion)
    return done


@compiled
def follow(
    bundle: Values, mode: Values, span: float, rotor: Parameters, rtol: float, motion: Motion,
    stop: Stop,
) -> int:  # fmt: skip
    """Alternate flight and contact over `span`; `mode` keeps whether in contact.

    The bundle holds the state on the rotating axes, then its tangent vectors [1].
    """
    omega, zeta, delta0 = rotor
    left = span
    for _ in range(_PATIENCE):
        if mode[0] > 0.0:
            passed = _stay_in_contact(bundle, mode, left, rotor, rtol, motion, stop)
            if passed < 0.0:
                return STUCK
            if mode[0] == 0.0:
                put_on_the_ring(bundle, delta0)
        else:
            z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
            touch = first_touch(z, w, omega, zeta, delta0, left, stop)
            if asked_to_stop(stop):
                return STUCK
            passed = min(touch, left)
            fly_bundle(bundle, passed, omega, zeta)
            if touch <= left:
                put_on_the_ring(bundle, delta0)
                mode[0] = 1.0
        left -= passed
        if left <= _ROUNDING * span:
            return DONE
    return STUCK


@compiled
def fly_bundle(bundle: Values, tau: float, omega: float, zeta: float) -> None:
    """Move the state and its tangent vectors by `tau` of free flight, in closed form."""
    z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
    z, w = fly(z, w, tau, omega, zeta)
    bundle[0, 0], bundle[0, 1], bundle[0, 2], bundle[0, 3] = z.real, z.imag, w.real, w.imag
    back = cmath.exp(-1j * omega * tau)
    reach, decay = drift(tau, zeta), math.exp(-2.0 * zeta * tau)
    for i in range(1, bundle.shape[0]):
        position = complex(bundle[i, 0], bundle[i, 1])
        velocity = complex(bundle[i, 2], bundle[i, 3])
        position = (position + velocity * reach) * back
        velocity = velocity * decay * back
        bundle[i, 0], bundle[i, 1] = position.real, position.imag
        bundle[i, 2], bundle[i, 3] = velocity.real, velocity.imag


@compiled
def put_on_the_ring(bundle: Values, delta0: float) -> None:
    """Take rounding off the radius at an event."""
    scale = delta0 / math.hypot(bundle[0, 0], bundle[0, 1])
    bundle[0, 0] *= scale
    bundle[0, 1] *= scale


@compiled
def _stay_in_contact(
    bundle: Values, mode: Values, left: float, rotor: Parameters, rtol: float, motion: Motion,
    stop: Stop,
) -> float:  # fmt: skip
    """Follow a contact until its exit or for `left`; return the time passed, negative if stuck."""
    passed = begin_contact(bundle, left, rotor, rtol, motion)
    regularised, leaves, reached = rotor[2] > 0.0, False, motion.values.copy()
    while passed < left:
        if asked_to_stop(stop) or motion.advance() != GOES_ON:
            return -1.0
        if regularised:
            end, leaves = end_of_step(motion, left, 0.0, reached)
            passed = reached[T]
        else:
            end = passed = min(motion.point, left)
            reached[:] = motion.at(end)
        if math.isnan(end):
            return -1.0
        if leaves:
            mode[0] = 0.0
            break
    write_bundle(bundle, reached, rotor[2])
    return passed


@compiled
def begin_contact(
    bundle: Values, left: float, rotor: Parameters, rtol: float, motion: Motion
) -> float:
    """Put a motion at the state of the bundle, or a moment later; return that moment.

    Of the rows behind the state, the motion takes the first four as its tangent vectors.
    """
    omega, zeta, delta0 = rotor
    own, atol, moment = bundle[0], np.full(4, _ATOL * rtol), 0.0
    if delta0 > 0.0:
        z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
        own = contact_start(z, w, left, omega, zeta, delta0)
        atol, moment = tolerances(own, rtol, _ATOL * rtol), own[T]
        if moment > 0.0:
            fly_bundle(bundle, moment, omega, zeta)
    vectors = bundle[1 : 1 + COUNT]
    motion.restart(joined(own, vectors), joined(atol, np.full(vectors.shape, rtol)))
    return float(moment)


@compiled
def write_bundle(bundle: Values, reached: Values, delta0: float) -> None:
    """Write state and tangent vectors at the end of a contact."""
    if delta0 > 0.0:
        z, w = cartesian(reached, delta0)
        bundle[0, 0], bundle[0, 1], bundle[0, 2], bundle[0, 3] = z.real, z.imag, w.real, w.imag
    else:
        bundle[0] = reached[:4]
    count = min(bundle.shape[0] - 1, COUNT)
    vectors = reached[reached.size - 4 * count :]
    for i in range(count):
        for j in range(4):
            bundle[i + 1, j] = vectors[COUNT * j + i]
