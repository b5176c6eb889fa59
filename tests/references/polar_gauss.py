"""Second method: other variables, another integrator, another search for the roots.

Flight: Taylor series in t of the Cartesian equations, advanced in steps; the first root of
|z|^2 - delta0^2 by the signs of its Bernstein coefficients. Contact: implicit Gauss-Legendre
collocation in polar variables of the rotating frame,

    q_u = w/2,  L_u = q (-2 zeta L - omega^2 r sin phi),  phi_u = q (L/r^2 - omega),  t_u = q,
    w_u = q (-2 zeta w + L^2/r^3 - q^3 + omega^2 cos phi),  r = delta0 + q^2,

with w = r', L = r^2 theta', phi = theta - omega t; the exit by Newton's method on the step.
"""

from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from math import comb

from flint import acb, arb, arb_mat, ctx

from .motion import Instant, UnresolvedError, dot, gap_derivatives, leading_order, phasor, start_of

BITS = 200
STAGES = 18
FLIGHT_ORDER = 45
SETTLED = arb(2) ** -170  # change at which a collocation has converged
SMOOTH = 1e-19  # last Legendre coefficient of the slopes in a step; the error is like its square


def events(case):
    """Return whether the run starts in contact, and its events as (kind, time)."""
    ctx.prec = BITS
    now, found, end = start_of(case), [], arb(case.duration)
    derivatives = gap_derivatives(case, now)
    leading = leading_order(derivatives)
    if leading is None:
        return False, []
    in_contact = starts_in_contact = bool(derivatives[leading] > 0)
    tangential = in_contact and leading == 2
    while True:
        if in_contact:
            now = contact(case, now, end, tangential=tangential)
        else:
            now = flight(case, now, end)
        if now is None:
            return starts_in_contact, found
        found.append((-1 if in_contact else 1, now.time))
        in_contact, tangential = not in_contact, False


# Flight ---------------------------------------------------------------------------------------


def flight(case, now, end):
    """Return the entry that ends a flight, or None where there is none until the end."""
    longest = 2.0 / max(1.0, case.omega, 2.0 * case.zeta)
    time, z, v = now.time, now.z, now.v
    skip = leading_order(gap_derivatives(case, now))
    while time < end:
        step = min(arb(longest), (end - time).mid(), key=float)
        terms = free_series(case, time, z, v, step)
        gap = []
        for n in range(FLIGHT_ORDER + 1):
            gap.append(sum((dot(terms[k], terms[n - k]) for k in range(n + 1)), arb(0)).mid())
        gap[0] -= arb(case.delta0) ** 2
        part = first_root(gap[skip:])
        at = arb(1) if part is None else part
        z = evaluate(terms, at).mid()
        v = (evaluate([n * term for n, term in enumerate(terms)][1:], at) / step).mid()
        time = (time + at * step).mid()
        if part is not None:
            z = (z * (arb(case.delta0) / dot(z, z).sqrt())).mid()
            return Instant(time, z, v, on_ring=True) if time < end else None
        skip = 0
    return None


def free_series(case, time, z, v, step):
    """Taylor coefficients of the flight, over a step that is stretched to 1."""
    damping, turn = 2 * arb(case.zeta) * step, acb(0, arb(case.omega)) * step
    push = (arb(case.omega) * step) ** 2 * phasor(case, time)
    terms, speed = [z], v * step
    for n in range(FLIGHT_ORDER):
        terms.append(speed / (n + 1))
        speed = (push - damping * speed) / (n + 1)
        push = push * turn / (n + 1)
    return terms


def evaluate(terms, at):
    """Horner's rule."""
    total = terms[-1]
    for term in terms[-2::-1]:
        total = total * at + term
    return total


@cache
def bernstein_matrix(size):
    """From coefficients in powers to Bernstein coefficients on [0, 1]."""
    top = size - 1
    rows = [
        [arb(comb(j, i)) / comb(top, i) if i <= j else arb(0) for i in range(size)]
        for j in range(size)
    ]
    return arb_mat(rows)


def first_root(coefficients):
    """Return the first root in (0, 1] of a polynomial that starts negative, or None."""
    size = len(coefficients)
    weights = bernstein_matrix(size) * arb_mat(size, 1, coefficients)
    pieces = [([entry.mid() for entry in weights.entries()], arb(0), arb(1))]
    while pieces:
        weights, left, right = pieces.pop()
        signs = [bool(weight > 0) for weight in weights]
        changes = sum(a != b for a, b in pairwise(signs))
        if changes == 0:
            continue
        if changes == 1 and not signs[0]:
            return secure_newton(coefficients, left, right)
        if right - left < arb(2) ** -100:
            raise UnresolvedError("a touch cannot be told from a miss")
        halves = subdivide(weights)
        middle = (left + right) / 2
        pieces += [(halves[1], middle, right), (halves[0], left, middle)]
    return None


def subdivide(weights):
    """De Casteljau's halving of a polynomial in Bernstein form."""
    lower, upper = [weights[0]], [weights[-1]]
    while len(weights) > 1:
        weights = [((a + b) / 2).mid() for a, b in pairwise(weights)]
        lower.append(weights[0])
        upper.append(weights[-1])
    return lower, upper[::-1]


def secure_newton(coefficients, left, right):
    """Return the only root between left and right, where the polynomial changes to plus."""
    slopes = [n * term for n, term in enumerate(coefficients)][1:]
    root, before = ((left + right) / 2).mid(), arb(1)
    for _ in range(200):
        height = evaluate(coefficients, root)
        if height > 0:
            right = root
        else:
            left = root
        guess = (root - height / evaluate(slopes, root)).mid()
        if not left <= guess <= right:
            guess = ((left + right) / 2).mid()
        move = abs(guess - root).mid()
        if move < arb(2) ** -100 and not 2 * move < before:  # rounding has been reached
            return guess
        root, before = guess, move
    raise UnresolvedError("Newton's method did not settle")


# Contact --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Tableau:
    """Gauss-Legendre collocation on [0, 1]."""

    nodes: list
    weights: list
    matrix: arb_mat
    last: list  # weights that give the last Legendre coefficient


@cache
def tableau():
    """Nodes, weights and the integrals of the cardinal polynomials, made at 600 bits."""
    kept, ctx.prec = ctx.prec, 600
    pairs = [arb.legendre_p_root(STAGES, k, weight=True) for k in range(STAGES)]
    pairs = sorted((((1 + x) / 2).mid(), (w / 2).mid()) for x, w in pairs)
    nodes, weights = [x for x, _ in pairs], [w for _, w in pairs]
    powers = arb_mat([[x**k for k in range(STAGES)] for x in nodes])
    integrals = arb_mat([[x ** (k + 1) / (k + 1) for k in range(STAGES)] for x in nodes])
    matrix = integrals * powers.inv()
    last = [w * (2 * x - 1).legendre_p(STAGES - 1) * (2 * STAGES - 1) for x, w in pairs]
    rounded = arb_mat(STAGES, STAGES, [entry.mid() for entry in matrix.entries()])
    ctx.prec = kept
    return Tableau(nodes, weights, rounded, [entry.mid() for entry in last])


class RoughStepError(ArithmeticError):
    """A step is too long for the number of stages; `factor` says how much shorter to try."""

    def __init__(self, factor):
        super().__init__(factor)
        self.factor = factor


def collocate(slopes, state, step, guess=None):
    """Return the stages, the state after a step and the factor for the next one.

    Raise RoughStepError where the step has to be shorter.
    """
    table, size = tableau(), len(state)
    stages = guess or [list(state)] * STAGES
    contraction = arb(10)
    for sweep in range(120):
        rates = [slopes(stage) for stage in stages]
        moves = table.matrix * arb_mat(rates)
        new, change = [], arb(0)
        for i in range(STAGES):
            row = [(state[j] + step * moves[i, j]).mid() for j in range(size)]
            change = max(
                [change] + [abs(a - b).mid() for a, b in zip(row, stages[i], strict=True)],
                key=float,
            )
            new.append(row)
        stages = new
        if change < SETTLED:
            break
        if sweep > 3 and (change > 4 * contraction or not change.is_finite()):
            raise RoughStepError(0.4)
        contraction = change
    else:
        raise RoughStepError(0.5)
    rates = [slopes(stage) for stage in stages]
    after, roughest = [], 0.0
    for j in range(size):
        column = [rate[j] for rate in rates]
        move = sum((w * r for w, r in zip(table.weights, column, strict=True)), arb(0))
        after.append((state[j] + step * move).mid())
        last = sum((w * r for w, r in zip(table.last, column, strict=True)), arb(0))
        roughest = max(roughest, float(abs(last * step).mid()))
    factor = 4.0
    if roughest > 0.0:
        factor = min(4.0, (SMOOTH / roughest) ** (1.0 / (STAGES - 1)))
    if factor < 0.75:
        raise RoughStepError(max(0.9 * factor, 0.1))
    return stages, after, factor


def polar_slopes(case):
    """Return the rates of (q, w, L, phi, t) with u."""
    damping, omega, delta0 = 2 * arb(case.zeta), arb(case.omega), arb(case.delta0)
    push = omega**2

    def rates(state):
        q, w, momentum, phi, _ = state
        square = q * q
        r = delta0 + square
        spin = momentum / (r * r)
        sine, cosine = phi.sin_cos()
        return [
            w / 2,
            q * (momentum * spin / r - damping * w - square * q + push * cosine),
            -q * (damping * momentum + push * r * sine),
            q * (spin - omega),
            q,
        ]

    return rates


def slopes_in_time(case):
    """Return the rates of (gap, w, L, phi, t) with t, gap = r - delta0."""
    damping, omega, delta0 = 2 * arb(case.zeta), arb(case.omega), arb(case.delta0)
    push = omega**2

    def rates(state):
        gap, w, momentum, phi, _ = state
        r = delta0 + gap
        spin = momentum / (r * r)
        sine, cosine = phi.sin_cos()
        force = gap * gap.sqrt() if gap > 0 else arb(0)
        return [
            w,
            momentum * spin / r - damping * w - force + push * cosine,
            -(damping * momentum + push * r * sine),
            spin - omega,
            arb(1),
        ]

    return rates


def polar(case, now):
    """Return (gap, w, L, phi, t) of an instant."""
    r = dot(now.z, now.z).sqrt()
    gap = arb(0)
    if not now.on_ring:
        gap = (dot(now.z, now.z) - arb(case.delta0) ** 2) / (r + arb(case.delta0))
    momentum = now.z.real * now.v.imag - now.z.imag * now.v.real
    turned = now.z * phasor(case, now.time).conjugate()
    values = [gap, dot(now.z, now.v) / r, momentum, turned.arg(), now.time]
    return [each.mid() for each in values]


def cartesian(case, w, momentum, phi, time):
    """Return the instant on the ring with these polar variables."""
    direction = phasor(case, time) * acb(phi.cos(), phi.sin())
    delta0 = arb(case.delta0)
    z = (delta0 * direction).mid()
    v = (acb(w, momentum / delta0) * direction).mid()
    return Instant(time, z, v, on_ring=True)


def contact(case, now, end, *, tangential=False):
    """Return the exit that ends a contact, or None where it lasts beyond the end."""
    state = polar(case, now)
    if tangential:
        state = leave_ring_tangentially(case, now, state)
    else:
        state[0] = state[0].sqrt().mid()
    slopes, step = polar_slopes(case), 0.3
    while state[-1] < end:
        try:
            stages, after, factor = collocate(slopes, state, arb(step))
        except RoughStepError as rough:
            step *= rough.factor
            continue
        inside = [stage[0] > 0 for stage in stages] + [after[0] > 0]
        if not all(inside):
            places = [arb(0), *tableau().nodes, arb(1)]
            first = inside.index(False)
            heights = [state[0], *[stage[0] for stage in stages], after[0]]
            low, high = heights[first], heights[first + 1]
            part = (places[first + 1] - places[first]) * low / (low - high) + places[first]
            state = find_exit(slopes, state, (step * part).mid())
            return cartesian(case, *state[1:]) if state[-1] < end else None
        state, step = after, step * 0.95 * factor
    return None


def find_exit(slopes, state, step):
    """Return the state where q comes back to zero, by Newton's method on the step."""
    for _ in range(12):
        _, after, _ = collocate(slopes, state, step)
        move = 2 * after[0] / after[1]
        if after[1] > 0 or not step > 0:
            raise UnresolvedError("the exit was lost")
        step = (step - move).mid()
        if abs(move) < arb(2) ** -90:
            _, after, _ = collocate(slopes, state, step)
            return after
    raise UnresolvedError("Newton's method did not settle on the exit")


def leave_ring_tangentially(case, now, state):
    """Return (q, ...) a little after a start on the ring with r' = 0 < r''.

    The motion is analytic in t there, though the force is not analytic in place.
    """
    half = gap_derivatives(case, now)[2] / (4 * arb(case.delta0))
    state = [arb(0), arb(0), *state[2:]]
    step = 0.25
    while True:
        guess = []
        for node in tableau().nodes:
            s = node * step
            guess.append([half * s * s, 2 * half * s, *state[2:]])
        try:
            stages, after, _ = collocate(slopes_in_time(case), state, arb(step), guess)
        except RoughStepError as rough:
            step *= rough.factor
            continue
        if all(stage[0] > 0 for stage in stages):
            return [after[0].sqrt().mid(), *after[1:]]
        step *= 0.5
