"""The motion together with its tangent space: how small differences of the state evolve.

State and tangent vectors are read on the rotating axes, where the motion is autonomous. The
field is continuous with a continuous Jacobian: the Hertz force leaves the ring like
indentation**1.5, its slope like indentation**0.5. The variational equation ``M' = J(state) M``
therefore holds through every entry and exit as it stands, with no jump of M to be added there.

In flight both are known in closed form. In contact the pair is integrated by an explicit
Runge-Kutta method of order eight [1]_ that begins anew at each entry and ends its last step on the
exit, so that no step runs across the ring.

References
----------
.. [1] E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations I", 2nd ed.,
   Springer, 1993, section II.10: DOP853 and its error estimates.
.. [2] P. C. Müller, "Calculation of Lyapunov exponents for dynamic systems with
   discontinuities", Chaos, Solitons & Fractals 5, 1995: the jump, which vanishes here.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from rotor_ida.equations.compiling import asked_to_stop, compiled
from rotor_ida.equations.model import rotating_field_into, rotating_jacobian_into
from rotor_ida.parallel.jobs import Stop
from rotor_ida.simulation.flight import drift, first_touch, fly

Values = npt.NDArray[np.float64]

DONE, STUCK = 0, 1

_SAFETY, _MOST_GROWTH, _LEAST_GROWTH = 0.9, 6.0, 0.2
_ROUNDING = 2.0**-52
_PATIENCE = 200_000

STAGES = 12
# The estimate falls like the sixth power of the step.
ERROR_POWER = -1.0 / 6.0
_A = np.ascontiguousarray(DOP853.A)
_B = np.ascontiguousarray(DOP853.B)
_E5 = np.ascontiguousarray(DOP853.E5)


@compiled
def follow_stretches(
    bundle: Values,
    in_contact: bool,
    span: float,
    stretches: Values,
    omega: float,
    zeta: float,
    delta0: float,
    rtol: float,
    stop: Stop,
) -> int:
    """Follow a state and its four tangent vectors, and say how much these were stretched.

    Parameters
    ----------
    bundle : ndarray, shape (5, 4)
        The state on the rotating axes, then four orthonormal tangent vectors; overwritten
        with those at the end [1].
    in_contact : bool
        Whether the motion begins in contact.
    span : float
        Time after which the tangent vectors are made orthonormal again [1].
    stretches : ndarray, shape (n, 4)
        Filled with the logarithms of the factors by which each of n spans stretches the
        vectors [1].
    omega, zeta, delta0 : float
        The rotor [1].
    rtol : float
        Tolerance of one step relative to the size of state and vectors [1].
    stop : ndarray, shape (1,)
        Anything but 0 asks the integration to stop.

    Returns
    -------
    int
        0 if all was done; 1 if the integration was stuck, or asked to stop.
    """
    mode = np.array([1.0 if in_contact else 0.0, 1e-3])
    for row in range(stretches.shape[0]):
        if _follow(bundle, mode, span, omega, zeta, delta0, rtol, stop) != DONE:
            return STUCK
        orthonormalise(bundle, stretches[row])
    return DONE


@compiled
def follow_on(
    states: Values,
    in_contact: npt.NDArray[np.bool_],
    span: float,
    omega: float,
    zeta: float,
    delta0: float,
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
    span, omega, zeta, delta0, rtol, stop
        As for `follow_stretches`.
    """
    bundle = np.zeros((5, 4))
    bundle[0] = states[0]
    mode = np.array([1.0 if in_contact[0] else 0.0, 1e-3])
    for row in range(1, states.shape[0]):
        if _follow(bundle, mode, span, omega, zeta, delta0, rtol, stop) != DONE:
            return STUCK
        states[row] = bundle[0]
        in_contact[row] = mode[0] > 0.0
    return DONE


@compiled
def follow_from(
    states: Values,
    in_contact: npt.NDArray[np.bool_],
    spans: Values,
    reached: Values,
    omega: float,
    zeta: float,
    delta0: float,
    rtol: float,
    stop: Stop,
) -> int:
    """Write into `reached` the state that follows on each row of `states` after its span."""
    bundle = np.zeros((5, 4))
    for row in range(states.shape[0]):
        bundle[0] = states[row]
        mode = np.array([1.0 if in_contact[row] else 0.0, max(spans[row], 1e-6)])
        if spans[row] > 0.0 and _follow(bundle, mode, spans[row], omega, zeta, delta0, rtol, stop):
            return STUCK
        reached[row] = bundle[0]
    return DONE


@compiled
def orthonormalise(bundle: Values, stretch: Values) -> None:
    """Make the tangent vectors orthonormal, and write the logarithms of their lengths."""
    for i in range(1, 5):
        for _ in range(2):
            for j in range(1, i):
                along = 0.0
                for k in range(4):
                    along += bundle[i, k] * bundle[j, k]
                for k in range(4):
                    bundle[i, k] -= along * bundle[j, k]
        length = 0.0
        for k in range(4):
            length += bundle[i, k] ** 2
        length = math.sqrt(length)
        stretch[i - 1] = math.log(length)
        for k in range(4):
            bundle[i, k] /= length


@compiled
def _follow(
    bundle: Values,
    mode: Values,
    span: float,
    omega: float,
    zeta: float,
    delta0: float,
    rtol: float,
    stop: Stop,
) -> int:
    """Alternate flight and contact over `span`; `mode` keeps whether in contact, and the step."""
    left = span
    for _ in range(_PATIENCE):
        if mode[0] > 0.0:
            passed = _stay_in_contact(bundle, mode, left, omega, zeta, delta0, rtol, stop)
            if passed < 0.0:
                return STUCK
        else:
            z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
            touch = first_touch(z, w, omega, zeta, delta0, left, stop)
            if asked_to_stop(stop):
                return STUCK
            passed = min(touch, left)
            _fly(bundle, passed, omega, zeta)
            if touch <= left:
                _put_on_the_ring(bundle, delta0)
                mode[0] = 1.0
        left -= passed
        if left <= _ROUNDING * span:
            return DONE
    return STUCK


@compiled
def _fly(bundle: Values, tau: float, omega: float, zeta: float) -> None:
    """Move the state and its tangent vectors by `tau` of free flight, in closed form."""
    z, w = complex(bundle[0, 0], bundle[0, 1]), complex(bundle[0, 2], bundle[0, 3])
    z, w = fly(z, w, tau, omega, zeta)
    bundle[0, 0], bundle[0, 1], bundle[0, 2], bundle[0, 3] = z.real, z.imag, w.real, w.imag
    back = cmath.exp(-1j * omega * tau)
    reach, decay = drift(tau, zeta), math.exp(-2.0 * zeta * tau)
    for i in range(1, 5):
        position = complex(bundle[i, 0], bundle[i, 1])
        velocity = complex(bundle[i, 2], bundle[i, 3])
        position = (position + velocity * reach) * back
        velocity = velocity * decay * back
        bundle[i, 0], bundle[i, 1] = position.real, position.imag
        bundle[i, 2], bundle[i, 3] = velocity.real, velocity.imag


@compiled
def _put_on_the_ring(bundle: Values, delta0: float) -> None:
    """Take rounding off the radius at an event."""
    scale = delta0 / math.hypot(bundle[0, 0], bundle[0, 1])
    bundle[0, 0] *= scale
    bundle[0, 1] *= scale


@compiled
def _stay_in_contact(
    bundle: Values,
    mode: Values,
    left: float,
    omega: float,
    zeta: float,
    delta0: float,
    rtol: float,
    stop: Stop,
) -> float:
    """Integrate until the exit or for `left`; return the time passed, negative if stuck."""
    rotor = (omega, zeta, delta0)
    rates = np.empty((STAGES + 1, 5, 4))
    trial, matrix = np.empty((5, 4)), np.zeros((4, 4))
    _write_rate(bundle, rates[0], matrix, rotor)
    passed, size = 0.0, mode[1]
    for _ in range(_PATIENCE):
        if asked_to_stop(stop):
            return -1.0
        last = size >= left - passed
        length = left - passed if last else size
        error = _step(bundle, length, rates, trial, matrix, rotor, rtol)
        if not error <= 1.0:
            size = length * max(_LEAST_GROWTH, _SAFETY * error**ERROR_POWER)
            if not size > _ROUNDING * left:
                return -1.0
            continue
        growth = _SAFETY * error**ERROR_POWER if error > 0.0 else _MOST_GROWTH
        if not last or growth < 1.0:
            size = length * min(_MOST_GROWTH, max(_LEAST_GROWTH, growth))
        leaves = math.hypot(trial[0, 0], trial[0, 1]) < delta0
        if leaves and _radial(trial) < 0.0:
            length = _land_on_exit(bundle, length, rates, trial, matrix, rotor, rtol)
            mode[0], last = 0.0, True
        bundle[:, :] = trial
        passed += length
        if last:
            if mode[0] == 0.0:
                _put_on_the_ring(bundle, delta0)
            mode[1] = max(min(size, 1.0), 1e-6)
            return passed
        rates[0] = rates[STAGES]
    return -1.0


@compiled
def _land_on_exit(
    bundle: Values,
    length: float,
    rates: Values,
    trial: Values,
    matrix: Values,
    rotor: tuple[float, float, float],
    rtol: float,
) -> float:
    """Shorten a step that leaves the contact so that it ends on the ring: Newton in a bracket."""
    delta0 = rotor[2]
    low, high, size = 0.0, length, length
    for _ in range(60):
        radius = math.hypot(trial[0, 0], trial[0, 1])
        late = delta0 - radius
        if late > 0.0:
            high = size
        else:
            low = size
        if abs(late) <= 4.0 * _ROUNDING * delta0 or high - low <= _ROUNDING * length:
            break
        speed = _radial(trial) / radius
        new = size + late / speed if speed < 0.0 else low
        size = new if low < new < high else 0.5 * (low + high)
        _step(bundle, size, rates, trial, matrix, rotor, rtol)
    return size


@compiled
def _radial(bundle: Values) -> float:
    """Return ``r r'`` of the state."""
    return float(bundle[0, 0] * bundle[0, 2] + bundle[0, 1] * bundle[0, 3])


@compiled
def _write_rate(
    bundle: Values, rate: Values, matrix: Values, rotor: tuple[float, float, float]
) -> None:
    """Write the rate of change of the state and of its tangent vectors."""
    omega, zeta, delta0 = rotor
    rotating_field_into(bundle[0], rate[0], omega, zeta, delta0)
    rotating_jacobian_into(bundle[0], matrix, omega, zeta, delta0)
    for i in range(1, 5):
        for j in range(4):
            total = 0.0
            for k in range(4):
                total += matrix[j, k] * bundle[i, k]
            rate[i, j] = total


@compiled
def _step(
    bundle: Values,
    size: float,
    rates: Values,
    trial: Values,
    matrix: Values,
    rotor: tuple[float, float, float],
    rtol: float,
) -> float:
    """Write the bundle after one step into `trial`; return its error in tolerances.

    ``rates[0]`` holds the rate at the beginning of the step. The error is the estimate of order
    five alone: the smaller one that [1]_ makes of it trusts in derivatives that the force of a
    rotor without clearance lacks at the centre, where it let through errors of 1e4 tolerances.
    """
    for stage in range(1, STAGES + 1):
        for i in range(5):
            for j in range(4):
                total = 0.0
                for k in range(stage):
                    weight = _A[stage, k] if stage < STAGES else _B[k]
                    total += weight * rates[k, i, j]
                trial[i, j] = bundle[i, j] + size * total
        _write_rate(trial, rates[stage], matrix, rotor)
    worst = 0.0
    for i in range(5):
        scale = 0.0
        square = 0.0
        for j in range(4):
            scale = max(scale, abs(bundle[i, j]), abs(trial[i, j]))
            error = 0.0
            for k in range(STAGES + 1):
                error += _E5[k] * rates[k, i, j]
            square += error**2
        if square > 0.0:
            worst = max(worst, 0.5 * size * math.sqrt(square) / (rtol * scale))
    return worst
