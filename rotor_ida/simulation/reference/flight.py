"""Flight inside the clearance: exact motion, and the first touch of the ring.

Out of contact the rotor is linear. Measured from a moment at which its displacement and
velocity, read on the rotating axes, are z0 and w0, its motion on axes that stand still from
then on is

    z(tau) = z0 + w phi(tau) + a (exp(i omega tau) - 1),   phi = (1 - exp(-2 zeta tau))/(2 zeta),

with a = -omega/(omega - 2 i zeta) and w = w0 - i omega a: a whirl of radius |a| about a centre
that drifts along a straight line. phi tends to tau as zeta tends to 0.

The first touch is the first root of g = |z|**2 - delta0**2. The search steps only as far as
a bound on g''' guarantees that g has no root, so no touch can hide between two steps.
"""

from __future__ import annotations

import cmath
import math

import numpy as np
import numpy.typing as npt

from rotor_ida.parallel.jobs import Stop

Values = npt.NDArray[np.float64]

NEVER = math.inf
ROUNDING = 2.0**-52


def unbalance_whirl(omega: float, zeta: float) -> complex:
    """Return the complex amplitude ``a`` of the contact-free whirl on the rotating axes."""
    if omega == 0.0:
        return 0j
    return -omega / complex(omega, -2.0 * zeta)


def drift(tau: float, zeta: float) -> float:
    """Return ``phi(tau) = (1 - exp(-2 zeta tau))/(2 zeta)`` without cancellation."""
    exponent = 2.0 * zeta * tau
    if exponent < 1e-300:
        return tau
    return -math.expm1(-exponent) / (2.0 * zeta)


def turn_less_one(angle: float) -> complex:
    """Return ``exp(i angle) - 1`` without cancellation."""
    half = math.sin(0.5 * angle)
    return complex(-2.0 * half * half, math.sin(angle))


def fly(z0: complex, w0: complex, tau: float, omega: float, zeta: float) -> tuple[complex, complex]:
    """Return displacement and velocity after `tau`, read on the rotating axes of that moment."""
    a = unbalance_whirl(omega, zeta)
    w = w0 - 1j * omega * a
    turn = cmath.exp(1j * omega * tau)
    position = z0 + w * drift(tau, zeta) + a * turn_less_one(omega * tau)
    velocity = w * math.exp(-2.0 * zeta * tau) + 1j * omega * a * turn
    back = turn.conjugate()
    return position * back, velocity * back


def fly_over(z0: complex, w0: complex, taus: Values, omega: float, zeta: float) -> Values:
    """Return ``(x, y, vx, vy)`` after each of `taus`, on the rotating axes, shape (n, 4)."""
    states = np.empty((taus.size, 4))
    for row, tau in enumerate(taus):
        position, velocity = fly(z0, w0, tau, omega, zeta)
        states[row, 0], states[row, 1] = position.real, position.imag
        states[row, 2], states[row, 3] = velocity.real, velocity.imag
    return states


def fly_by_parameters(
    z0: complex, w0: complex, tau: float, omega: float, zeta: float
) -> tuple[complex, complex, complex, complex]:
    """Return what omega, and what zeta, adds to displacement and velocity after `tau`.

    They are the derivatives of what `fly` returns. The clearance adds nothing in flight.
    """
    a = a_omega = a_zeta = 0j
    if omega > 0.0 or zeta > 0.0:
        pole = complex(omega, -2.0 * zeta)
        a, a_omega, a_zeta = -omega / pole, 2j * zeta / pole**2, -2j * omega / pole**2
    w, w_omega, w_zeta = w0 - 1j * omega * a, -1j * (a + omega * a_omega), -1j * omega * a_zeta
    reach, decay, turn = drift(tau, zeta), math.exp(-2.0 * zeta * tau), cmath.exp(1j * omega * tau)
    less_one, spin = turn_less_one(omega * tau), 1j * omega * turn
    position = z0 + w * reach + a * less_one
    velocity = w * decay + a * spin
    z_omega = w_omega * reach + a_omega * less_one + 1j * tau * (a * turn - position)
    w_by_omega = w_omega * (decay - turn) + 1j * tau * (a * spin - velocity)
    z_zeta = w_zeta * reach + w * _drift_by_zeta(tau, zeta) + a_zeta * less_one
    w_by_zeta = w_zeta * decay - 2.0 * tau * w * decay + a_zeta * spin
    back = turn.conjugate()
    return z_omega * back, w_by_omega * back, z_zeta * back, w_by_zeta * back


def _drift_by_zeta(tau: float, zeta: float) -> float:
    """Return the derivative of `drift` by zeta, without cancellation."""
    x = 2.0 * zeta * tau
    if x > 0.1:
        return -2.0 * tau * tau * (1.0 - math.exp(-x) * (1.0 + x)) / (x * x)
    # (1 - (1 + x) exp(-x))/x**2 is the sum over n of (-x)**n (n + 1)/(n + 2)!
    total, power = 0.0, 0.5
    for n in range(1, 12):
        total += power * n
        power *= -x / (n + 2.0)
    return -2.0 * tau * tau * total


def touch_floor(omega: float, zeta: float, delta0: float) -> float:
    """Return the smallest ``|z|**2 - delta0**2`` that stands clear of rounding.

    A graze below an indentation of ``touch_floor/(2 delta0)``, about 1e-14 of the lengths
    involved, may be missed or invented.
    """
    return 64.0 * ROUNDING * delta0 * (delta0 + abs(unbalance_whirl(omega, zeta)))


def _first_root_of_majorant(value: float, slope: float, curvature: float) -> float:
    """Return the first s > 0 with ``value + slope s + curvature s**2/2 = 0``, value < 0."""
    discriminant = slope * slope - 2.0 * curvature * value
    if discriminant < 0.0:
        return NEVER
    root = math.sqrt(discriminant)
    if slope >= 0.0:
        return -2.0 * value / (slope + root) if slope + root > 0.0 else NEVER
    return (root - slope) / curvature if curvature > 0.0 else NEVER


def _safe_step(value: float, slope: float, curvature: float, jerk: float, reach: float) -> float:
    """Return a step over which a function with this Taylor start and |g'''| < jerk stays < 0.

    On [0, L] the function lies below the parabola of curvature ``curvature + jerk L``; the
    step is the largest L, to a few bisections, that its parabola allows.
    """
    longest = min(reach, _first_root_of_majorant(value, slope, curvature + jerk * reach))
    if longest >= reach:
        return reach
    low, high = longest, reach
    for _ in range(6):
        middle = 0.5 * (low + high) if high < 4.0 * low else math.sqrt(low * high)
        allowed = _first_root_of_majorant(value, slope, curvature + jerk * middle)
        if allowed >= middle:
            low = middle
        else:
            high = middle
            low = max(low, allowed)
    return low


def _gap_function(
    z0: complex, a: complex, w: complex, tau: float, omega: float, zeta: float, delta0: float
) -> tuple[float, float, float]:
    """Return ``g = |z|**2 - delta0**2`` and its first two derivatives at `tau`."""
    turn = cmath.exp(1j * omega * tau)
    decay = math.exp(-2.0 * zeta * tau)
    z = z0 + w * drift(tau, zeta) + a * turn_less_one(omega * tau)
    v = w * decay + 1j * omega * a * turn
    b = -2.0 * zeta * decay * w - omega * omega * a * turn
    radius = abs(z)
    g = (radius - delta0) * (radius + delta0)
    slope = 2.0 * (z.real * v.real + z.imag * v.imag)
    bend = 2.0 * (v.real * v.real + v.imag * v.imag + z.real * b.real + z.imag * b.imag)
    return g, slope, bend


def _jerk_bound(a: float, w: float, tau: float, omega: float, zeta: float, delta0: float) -> float:
    """Bound ``|g'''| = |6 Re(conj(z') z'') + 2 Re(conj(z) z''')|`` from `tau` to the touch."""
    decayed = w * math.exp(-2.0 * zeta * tau)
    speed = decayed + omega * a
    acceleration = 2.0 * zeta * decayed + omega * omega * a
    jerk = 4.0 * zeta * zeta * decayed + omega**3 * a
    return 6.0 * speed * acceleration + 2.0 * delta0 * jerk


def _polish(
    z0: complex,
    a: complex,
    w: complex,
    low: float,
    high: float,
    omega: float,
    zeta: float,
    delta0: float,
) -> float:
    """Return the root of g between `low` (g <= 0) and `high` (g > 0): Newton in a bracket."""
    tau = high
    for _ in range(80):
        g, slope, _bend = _gap_function(z0, a, w, tau, omega, zeta, delta0)
        if g > 0.0:
            high = tau
        else:
            low = tau
        step = g / slope if slope > 0.0 else NEVER
        new = tau - step
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - tau) <= ROUNDING * tau or high - low <= ROUNDING * high:
            return new
        tau = new
    return tau


def first_touch(
    z0: complex, w0: complex, omega: float, zeta: float, delta0: float, limit: float, stop: Stop
) -> float:
    """Return the time to the first touch of the ring, or infinity if none comes by `limit`.

    It is infinite too where the search was asked to stop.

    Parameters
    ----------
    z0, w0 : complex
        Displacement, ``|z0| <= delta0``, and velocity, read on the rotating axes [1].
    omega, zeta, delta0 : float
        The rotor [1].
    limit : float
        Longest flight of interest [1].
    stop : ndarray, shape (1,)
        Anything but 0 asks the search to stop.
    """
    a = unbalance_whirl(omega, zeta)
    w = w0 - 1j * omega * a
    floor = touch_floor(omega, zeta, delta0)
    last_centre = abs(z0 - a + w * drift(limit, zeta))
    tau, outside, step = 0.0, 0.0, limit
    while tau < limit and not stop[0]:
        g, slope, bend = _gap_function(z0, a, w, tau, omega, zeta, delta0)
        if g <= 0.0:
            outside = tau
        reach = limit - tau
        if g - floor >= -0.25 * floor:
            root = _polish(z0, a, w, outside, tau, omega, zeta, delta0)
            if _gap_function(z0, a, w, root, omega, zeta, delta0)[1] > 0.0:
                return root
            # A flight that began, within rounding, in a hollow of the gap on the ring is over.
            if slope > 0.0 and bend > 0.0:
                return tau
            # A touch that rounding cannot tell from a miss: pass over its summit.
            step = 2.0 * math.sqrt(2.0 * floor / max(abs(bend), floor)) + ROUNDING * tau
        else:
            # The centre drifts along a straight line, so it is farthest out at an end.
            centre = max(abs(z0 - a + w * drift(tau, zeta)), last_centre)
            if (centre + abs(a) - delta0) * 2.0 * delta0 <= 0.5 * floor:
                return NEVER
            jerk = _jerk_bound(abs(a), abs(w), tau, omega, zeta, delta0)
            step = _safe_step(g - floor, slope, bend, jerk, min(4.0 * step, reach))
        tau += max(step, ROUNDING * tau)
    return NEVER
