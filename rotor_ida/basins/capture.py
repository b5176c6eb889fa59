"""Sets of states from which no orbit escapes a stable whirl: a start inside is decided.

On the rotating axes a synchronous whirl is an equilibrium. Round it we look for a quadratic form
``V`` of the distance in state space that falls along every orbit on a whole ellipsoid ``V <= 1``.
Then no orbit leaves the ellipsoid, and all in it converge to the whirl.

Notes
-----
Write ``xi`` for the state less that of the whirl, ``v`` for the position in it. The equation is
linear but for the contact force F, and

    F(v) - F(v*) = K (v - v*),    K = mean of DF along the segment from v* to v,
    DF = s I + (f' - s) n n^T,    n = v/|v|,  s = f(|v|)/|v|.

So ``xi' = (L - E K) xi`` with a constant L and a symmetric 2 x 2 matrix K that varies. Over a
convex set of positions K lies in the smallest box (three entries) that holds every DF there: a
mean of members of a convex set is a member. ``d/dt xi^T P xi = xi^T (J^T P + P J) xi`` with
``J = L - E K`` is affine in K, so if ``J^T P + P J`` is negative definite at the eight corners of
the box it is so throughout, with one margin: V decays exponentially. The positions of the
ellipsoid ``xi^T P xi <= c`` are an ellipse with half-widths ``sqrt(c S)``, ``S`` the position
block of ``P^-1``; its bounding rectangle, along and across the whirl, gives the box. The largest
such c is found by bisection and P by a search for the largest volume. The rectangle is kept out
of the clearance and of the centre, where DF is not what is written above.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from rotor_ida.closed_forms import synchronous_response
from rotor_ida.contact import contact_stiffness, secant_stiffness
from rotor_ida.model import rotating_jacobian
from rotor_ida.parameters import Rotor
from rotor_ida.schema import STABILITY

Values = npt.NDArray[np.float64]

# V must fall by this part of the fastest possible rate at least, so that rounding cannot matter.
MARGIN = 1e-6
BISECTIONS = 40
SEARCH_STEPS = 300
MODE_RATIOS = np.geomspace(1e-2, 1e2, 33)


@dataclass(frozen=True, slots=True)
class CaptureSet:
    """An ellipsoid of states, all of which converge to one stable whirl in contact.

    Parameters
    ----------
    amplitude, phase_lag : float
        The whirl [1], [rad].
    centre : ndarray, shape (4,)
        Its state on the rotating axes [1].
    form : ndarray, shape (4, 4)
        Positive definite P: the set is ``(z - centre)^T P (z - centre) <= 1``. All infinite
        where no such set was found.
    """

    amplitude: float
    phase_lag: float
    centre: Values
    form: Values

    @property
    def factor(self) -> Values:
        """Upper triangular R with ``P = R^T R``, shape (4, 4); infinite where there is no set."""
        if not np.isfinite(self.form).all():
            return np.diag(np.full(4, np.inf))
        return np.asarray(np.linalg.cholesky(self.form).T)


def capture_sets(rotor: Rotor) -> list[CaptureSet]:
    """Return a capture set for each stable whirl in contact, in order of amplitude.

    Parameters
    ----------
    rotor : Rotor
        A rotor that turns and is damped.

    Examples
    --------
    >>> sets = capture_sets(Rotor(omega=1.7, zeta=0.07, delta0=0.0))
    >>> [round(each.amplitude, 4) for each in sets]
    [1.8796, 9.4872]
    """
    whirls = synchronous_response(omega=rotor.omega, zeta=rotor.zeta, delta0=rotor.delta0)
    whirls = whirls.squeeze(("omega", "zeta", "delta0"))
    stable = (whirls["stability"] == STABILITY["stable"]) & (whirls["in_contact"] == 1)
    return [
        _capture_set(rotor, amplitude, lag)
        for amplitude, lag in zip(
            whirls["amplitude"].values[stable.values].tolist(),
            whirls["phase_lag"].values[stable.values].tolist(),
            strict=True,
        )
    ]


def _capture_set(rotor: Rotor, amplitude: float, lag: float) -> CaptureSet:
    """Search for the form of largest volume, from those that the linear motion suggests."""
    problem = _Problem(rotor, amplitude)
    best = max(problem.modal_forms(), key=problem.log_volume)
    found = minimize(
        lambda parts: -problem.log_volume(_form_of(parts)),
        _parts_of(best),
        method="Nelder-Mead",
        options={"maxfev": SEARCH_STEPS, "initial_simplex": _simplex(_parts_of(best))},
    )
    if -found.fun > problem.log_volume(best):
        best = _form_of(found.x)
    level = problem.largest_level(best)
    position = amplitude * complex(math.cos(lag), -math.sin(lag))
    velocity = 1j * rotor.omega * position
    centre = np.array([position.real, position.imag, velocity.real, velocity.imag])
    if level == 0.0:
        return CaptureSet(amplitude, lag, centre, np.full((4, 4), np.inf))
    turn = np.kron(np.eye(2), np.array([[math.cos(lag), -math.sin(lag)],
                                        [math.sin(lag), math.cos(lag)]]))  # fmt: skip
    # turn takes offsets in the plane to offsets along and across the whirl
    return CaptureSet(amplitude, lag, centre, turn.T @ (best / level) @ turn)


class _Problem:
    """The motion near one whirl, on axes along and across it."""

    def __init__(self, rotor: Rotor, amplitude: float):
        self.rotor, self.amplitude = rotor, amplitude
        self.linear = rotating_jacobian((0.0, 0.0, 0.0, 0.0), Rotor(
            omega=rotor.omega, zeta=rotor.zeta, delta0=1.0))  # fmt: skip

    def matrix(self, along: float, across: float, mixed: float) -> Values:
        """Return J for one stiffness matrix K."""
        matrix = self.linear.copy()
        matrix[2:, :2] -= [[along, mixed], [mixed, across]]
        return matrix

    def corners(self, half_along: float, half_across: float) -> Values:
        """Return J at the corners of the box that holds DF on a rectangle, shape (8, 4, 4)."""
        delta0 = self.rotor.delta0
        nearest = self.amplitude - half_along
        farthest = math.hypot(self.amplitude + half_along, half_across)
        angle = math.atan2(half_across, nearest)
        # f', s and f' - s all grow with the radius
        tangent = [float(contact_stiffness(r, delta0)) for r in (nearest, farthest)]
        secant = [float(secant_stiffness(r, delta0)) for r in (nearest, farthest)]
        excess = [t - s for t, s in zip(tangent, secant, strict=True)]
        along = (secant[0] + excess[0] * math.cos(angle) ** 2, tangent[1])
        across = (secant[0], secant[1] + excess[1] * math.sin(angle) ** 2)
        most = excess[1] * 0.5 * math.sin(2.0 * min(angle, 0.25 * math.pi))
        return np.array(
            [self.matrix(a, b, c) for a in along for b in across for c in (-most, most)]
        )

    def falls(self, form: Values, level: float) -> bool:
        """Return whether V falls everywhere on the ellipsoid ``xi^T P xi <= level``."""
        widths = np.sqrt(level * np.diag(np.linalg.inv(form)))
        if self.amplitude - widths[0] <= self.rotor.delta0:
            return False
        matrices = self.corners(float(widths[0]), float(widths[1]))
        rates = np.swapaxes(matrices, 1, 2) @ form + form @ matrices
        largest = np.linalg.eigvalsh(rates + 2.0 * MARGIN * self.rotor.zeta * form).max()
        return bool(largest < 0.0)

    def largest_level(self, form: Values) -> float:
        """Return the largest level found by bisection, 0 if there is none."""
        room = self.amplitude - self.rotor.delta0
        high = room**2 / float(np.linalg.inv(form)[0, 0])
        low = 0.0
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high) if low > 0.0 else 0.1 * high
            if self.falls(form, middle):
                low = middle
            else:
                high = middle
            if low > 0.0 and high - low < 1e-3 * low:
                break
        return low

    def log_volume(self, form: Values) -> float:
        """Return the logarithm of the volume of the set, to a constant."""
        level = self.largest_level(form)
        if level == 0.0:
            return -1e3
        return 2.0 * math.log(level) - 0.5 * float(np.linalg.slogdet(form)[1])

    def modal_forms(self) -> list[Values]:
        """Return forms that the linear motion makes fall at its own rate, mode by mode."""
        r, delta0 = self.amplitude, self.rotor.delta0
        matrix = self.matrix(float(contact_stiffness(r, delta0)),
                             float(secant_stiffness(r, delta0)), 0.0)  # fmt: skip
        values, vectors = np.linalg.eig(matrix)
        order = np.argsort(np.abs(values.imag))
        inverse = np.linalg.inv(vectors[:, order])
        forms = []
        for ratio in MODE_RATIOS:
            weights = np.array([1.0, 1.0, ratio, ratio])
            form = (inverse.conj().T * weights) @ inverse
            forms.append(np.ascontiguousarray(form.real))
        return forms


def _parts_of(form: Values) -> Values:
    """Return ten numbers without constraint that describe a positive definite form."""
    lower = np.linalg.cholesky(form / np.linalg.norm(form))
    lower[np.diag_indices(4)] = np.log(np.diag(lower))
    return np.asarray(lower[np.tril_indices(4)])


def _form_of(parts: Values) -> Values:
    lower = np.zeros((4, 4))
    lower[np.tril_indices(4)] = parts
    lower[np.diag_indices(4)] = np.exp(np.diag(lower))
    return np.asarray(lower @ lower.T)


def _simplex(first: Values) -> Values:
    return np.vstack([first, first + 0.1 * np.eye(first.size)])
