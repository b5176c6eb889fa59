"""Backward whirl of an axisymmetric rotor system by friction at one contact: dry whip.

In a circular motion ``u = A exp(i w t)`` of a contact, with the force ``N + i T`` on its stator,

    A = -H(w) (N + i T),    H(w) = b (K - w**2 + i w (C + Omega G))**-1 b'.

With the dynamic stiffness ``Z = 1/H``, the contact needs ``N = -A Re Z`` and ``T = -A Im Z``: at a
given whirl speed Z determines both forces over the amplitude.

- *Slipping forwards*, ``T = mu N``: ``Im(Z (1 - i mu)) = 0`` with ``Re Z < 0``. These whirl speeds
  are eigenfrequencies with the spring ``N (1 + i mu)/A`` at the contact. They depend on neither the
  contact law nor the clearance, and are the edges of the ranges in which friction can hold.
- *Rolling*, ``w = -R Omega/A``: dry whip. The amplitude follows from ``N(A) = -A Re Z(w)``, and
  friction holds while ``|Im Z| <= -mu Re Z``. As the spin speed grows, so does N, and w approaches
  the eigenfrequency with the contact closed, where ``-Re Z`` is the stiffness of the contact.

For one disc ``Z = kappa - w**2 + 2 i zeta w`` and these are the whirls of `backward_whirl`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev
from scipy.linalg import eig
from scipy.optimize import brentq

from rotor_ida.arrays import ROUNDING, ComplexValues, Values
from rotor_ida.closed_forms.whirls.turning_axes import as_real
from rotor_ida.model.axisymmetric import ForwardMotions
from rotor_ida.model.system_parts import Contact

# Eigenvalues this near to the real axis, relative to their size, are roots before rounding.
NEAR = 1e-3
# Degree of polynomials, their last terms that must be small, how small, and the shortest part of a
# range that has one of its own.
DEGREE, TAIL, RESOLVED, SHORTEST = 24, 3, 1e-9, 1e-9
# Growth rates below this part of the whirl speed are 0 but for rounding, as is that of the phase.
NEUTRAL = 1e-7


@dataclass(frozen=True, slots=True)
class Whip:
    """A rolling whirl: its speed (negative), amplitude, forces and growth rate."""

    whirl_speed: float
    amplitude: float
    normal_force: float
    tangential_force: float
    growth_rate: float


def dry_whips(motions: ForwardMotions, number: int, contact: Contact, speed: float) -> list[Whip]:
    """Return the rolling whirls that friction can hold at a spin speed, the slowest whirl first.

    Parameters
    ----------
    motions : ForwardMotions
        The rotor with its stators.
    number : int
        Number of the contact.
    contact : Contact
        Its law, clearance, friction and radius.
    speed : float
        Spin speed.

    Examples
    --------
    >>> from rotor_ida import Rotor, backward_whirl
    >>> from rotor_ida.model.assembly import assemble
    >>> from rotor_ida.model.axisymmetric import forward_motions
    >>> rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    >>> system = rotor.system()
    >>> (whip,) = dry_whips(forward_motions(assemble(system)), 0, system.contacts[0], 0.63)
    >>> exact = backward_whirl(rotor).isel(whirl=1)
    >>> bool(abs(whip.amplitude / exact.amplitude - 1.0) < 1e-12), round(whip.whirl_speed, 6)
    (True, -1.263414)
    """
    if not (contact.friction > 0.0 and contact.radius and speed != 0.0):
        return []
    rim = contact.radius * abs(speed)
    row, turned = motions.rows[number], motions.gyroscopic * abs(speed)

    last = -rim / contact.clearance
    power = 2.0 * contact.exponent
    stiff = contact.stiffness * contact.clearance ** (contact.exponent - 1.0)

    def flexibility(w: float) -> complex:
        one = np.eye(motions.size)
        dynamic = motions.stiffness - w * w * one + 1j * w * (motions.damping + turned)
        return complex(row @ np.linalg.solve(dynamic, row.conj()))

    def excess(angle: float) -> float:
        """Return the contact's force over the amplitude, less what the rotor needs, times cosine.

        With ``w = last cos(angle)**2`` the indentation is the clearance times the tangent's square.
        """
        sine, cosine = math.sin(angle), math.cos(angle)
        needed = (1.0 / flexibility(last * cosine**2)).real
        return float(stiff * sine**power * cosine ** (3.0 - power) + cosine * needed)

    found = []
    for low, high in _holding(_edges(motions, row, turned, contact.friction, last), last,
                              flexibility, contact.friction):  # fmt: skip
        ends = (math.acos(math.sqrt(min(each / last, 1.0))) for each in (low, high))
        for angle in _roots(excess, *ends):
            w = last * math.cos(angle) ** 2
            h = flexibility(w)
            z = 1.0 / h
            if abs(z.imag) > -contact.friction * z.real:
                continue
            amplitude = rim / -w
            forces = -amplitude * z
            growth = _growth(motions, row, turned, contact, w, amplitude, forces)
            found.append(Whip(w, amplitude, forces.real, forces.imag, growth))
    return sorted(found, key=lambda each: -each.whirl_speed)


def _holding(
    edges: Values, last: float, flexibility: Callable[[float], complex], friction: float
) -> list[tuple[float, float]]:
    """Return the ranges of whirl speeds between edges in which friction can hold."""
    ends = np.concatenate([[last], edges[edges > last], [0.0]])
    ranges = []
    for low, high in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        h = flexibility(0.5 * (low + high))  # Re Z < 0 where Re H < 0
        if abs(h.imag) <= -friction * h.real:
            ranges.append((low, high))
    return ranges


def _edges(
    motions: ForwardMotions, row: ComplexValues, turned: ComplexValues, friction: float, last: float
) -> Values:
    """Return the whirl speeds at which friction is just enough, in ascending order.

    They are the real zeros of ``(1 + i m) H(w) - (1 - i m) conj(H(w))`` for m = mu and -mu: the
    eigenvalues of a pencil in w that borders the motions and their conjugates with the contact.
    """
    n, one = motions.size, np.eye(motions.size)
    resisted = motions.damping + turned
    scale = float(np.sqrt(np.abs(np.linalg.eigvals(motions.stiffness)).mean())) or 1.0
    column = row.conj()[:, np.newaxis] / np.linalg.norm(row)
    zero, nothing = np.zeros((2 * n + 1, 2 * n + 1), complex), np.zeros((n, n))
    found = []
    for m in (friction, -friction):
        levels = []
        for power, own in enumerate((motions.stiffness / scale**2, 1j * resisted / scale, -one)):
            other = own.conj().T  # conj(H) is that of the adjoint, at real w
            levels.append(zero.copy())
            levels[-1][: 2 * n, : 2 * n] = np.block([[own, nothing], [nothing, other]])
            if power == 0:
                levels[0][: 2 * n, 2 * n :] = np.concatenate([column, column])
                border = np.hstack(
                    [(1 + 1j * m) * column.conj().T, -(1 - 1j * m) * column.conj().T]
                )
                levels[0][2 * n :, : 2 * n] = border
        identity = np.eye(2 * n + 1)
        values = eig(
            np.block([[zero, identity], [-levels[0], -levels[1]]]),
            np.block([[identity, zero], [zero, levels[2]]]), right=False,
        )  # fmt: skip
        with np.errstate(invalid="ignore"):
            real = np.isfinite(values) & (np.abs(values.imag) <= NEAR * np.abs(values))
        found.append(scale * values.real[real])
    edges = np.sort(np.concatenate(found))
    return edges[(edges < 0.0) & (edges > last)]


def _roots(function: Callable[[float], float], low: float, high: float) -> list[float]:
    """Return the sign changes of an analytic function between two arguments.

    Chebyshev polynomials resolve it on parts of the range. Their roots, those that are nearly real
    included, divide the range so that between neighbours it changes sign at most once.
    """
    parts, seen = [(low, high)], []
    while parts:
        first, last = parts.pop()
        middle, half = 0.5 * (first + last), 0.5 * (last - first)
        nodes = middle + half * chebyshev.chebpts1(DEGREE + 1)
        values = np.array([function(each) for each in nodes.tolist()])
        series = chebyshev.chebfit(chebyshev.chebpts1(DEGREE + 1), values, DEGREE)
        sizes = np.abs(series)
        if sizes[-TAIL:].max() > RESOLVED * sizes.max() and half > SHORTEST * (high - low):
            parts += [(first, middle), (middle, last)]
            continue
        roots = chebyshev.chebroots(series)
        near = (np.abs(roots.imag) <= NEAR) & (np.abs(roots.real) <= 1.0 + NEAR)
        seen += [*(middle + half * roots.real[near]).tolist(), first]
    seen = sorted(min(max(each, low), high) for each in seen)
    between = [low, *(0.5 * (one + other) for one, other in pairwise(seen)), high]
    signs = [math.copysign(1.0, function(each)) for each in between]
    return [
        float(brentq(function, *ends, xtol=1e-300, rtol=4.0 * ROUNDING))
        for ends, of_ends in zip(pairwise(between), pairwise(signs), strict=True)
        if of_ends[0] != of_ends[1]
    ]


def _growth(
    motions: ForwardMotions, row: ComplexValues, turned: ComplexValues, contact: Contact,
    w: float, amplitude: float, forces: complex,
) -> float:  # fmt: skip
    """Return the growth rate of small motions about a rolling whirl, on axes that rotate with it.

    They obey ``p'' + (C + Omega G + 2 i w) p' + (K - w**2 + i w (C + Omega G)) p = -b' phi`` with
    ``b p = xi + i eta``, the force ``phi = N_d xi + lambda N xi' + i tau + i (N + i T) eta/A`` and
    the constraint ``eta' + w xi = 0`` of rolling, whose force is tau.
    """
    n, one = motions.size, np.eye(motions.size)
    resisted = motions.damping + turned
    stiffness = as_real(motions.stiffness - w * w * one + 1j * w * resisted)
    damping = as_real(resisted + 2j * w * one)
    both = as_real(row[np.newaxis, :])  # xi and eta by the real and imaginary parts of p
    slope = contact.exponent * forces.real / (amplitude - contact.clearance)
    across = np.array([[slope, -forces.imag / amplitude], [0.0, forces.real / amplitude]])
    stiffness = stiffness + both.T @ across @ both
    damping = damping + contact.damping * forces.real * np.outer(both[0], both[0])
    half = 2 * n
    left, right = np.zeros((2, 2 * half + 1, 2 * half + 1))
    left[:half, half : 2 * half] = right[:half, :half] = np.eye(half)
    left[half : 2 * half, : 2 * half] = np.hstack([-stiffness, -damping])
    left[half : 2 * half, -1] = -both[1]
    right[half : 2 * half, half : 2 * half] = np.eye(half)
    left[-1, :half], left[-1, half : 2 * half] = w * both[0], both[1]
    values = eig(left, right, right=False)
    with np.errstate(invalid="ignore"):
        values = values[np.isfinite(values)]
        values = values[np.abs(values) > NEUTRAL * abs(w)]  # the phase of the whirl is free
    values = values[np.abs(values) < 1e8 * np.abs(values).min(initial=np.inf)]
    return float(values.real.max(initial=-np.inf))
